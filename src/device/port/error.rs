//! Errors of a port, and listed ports.

use std::path::PathBuf;
use std::{fmt, io};

use web_time::Duration;

use crate::device::profile::Profile;

/// Time after which a blocked port counts as lost.
pub const WRITE_TIMEOUT: Duration = Duration::from_millis(500);

/// Advice of the command line about a missing port; the window names its button instead.
#[doc(hidden)]
pub const LISTED: &str = "; `sonoglyph ports` lists the ports";

#[derive(Debug, thiserror::Error)]
pub enum PortError {
    #[cfg_attr(not(target_arch = "wasm32"), error("there is no port {0}{advice}", advice = LISTED))]
    #[cfg_attr(target_arch = "wasm32", error("there is no port {0} that this page may use"))]
    Missing(String),
    #[cfg_attr(
        not(target_arch = "wasm32"),
        error("no permission to open {0}; on Debian, add yourself to the group dialout")
    )]
    #[cfg_attr(target_arch = "wasm32", error("the browser does not let this page open {0}"))]
    NoPermission(String),
    #[error("{0} is in use by another program")]
    Busy(String),
    #[cfg(target_arch = "wasm32")]
    #[error("{path} could not be opened: {error}; another program or page may have it")]
    Unopened { path: String, error: io::Error },
    #[error("{0} is not a serial port")]
    NotSerial(String),
    #[error("{path}: {baud} baud is not possible here: {error}")]
    Baud { path: String, baud: u32, error: io::Error },
    #[error("{path} was lost: {error}")]
    Lost { path: String, error: io::Error },
    #[error("{0} takes no bytes: the other end does not read")]
    Stalled(String),
}

/// A port to choose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    pub path: PathBuf,
    /// Description of the adapter, or of a virtual board.
    pub what: Option<String>,
    /// Profile of a virtual board.
    pub profile: Option<Profile>,
}

impl fmt::Display for Listed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        self.what.as_ref().map_or(Ok(()), |what| write!(f, " ({what})"))
    }
}
