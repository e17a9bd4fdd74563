//! Serial ports: which there are, and one that is open.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serial2::SerialPort;

use crate::device::pace::Pace;

/// After this a port that takes nothing is given up.
const WRITE_TIMEOUT: Duration = Duration::from_millis(500);

#[derive(Debug, thiserror::Error)]
pub enum PortError {
    #[error("there is no port {0}; `sonoglyph ports` lists those there are")]
    Missing(String),
    #[error("{0} may not be opened by you; on Debian, members of the group dialout may")]
    NoPermission(String),
    #[error("{0} is in use by another program")]
    Busy(String),
    #[error("{0} is not a serial port")]
    NotSerial(String),
    #[error("{path}: {baud} baud is not possible here: {error}")]
    Baud { path: String, baud: u32, error: io::Error },
    #[error("{path} was lost: {error}")]
    Lost { path: String, error: io::Error },
    #[error("{0} takes no bytes: nothing drains it")]
    Stalled(String),
}

/// An open port, and what it has still to send.
#[derive(Debug)]
pub struct Port {
    serial: SerialPort,
    name: String,
    baud: u32,
    pace: Pace,
}

/// Ports that look like serial ones, in order.
///
/// # Errors
/// A system that does not say.
pub fn available() -> io::Result<Vec<PathBuf>> {
    let mut ports = match SerialPort::available_ports() {
        // A system that lists no devices, as containers may, has none to offer.
        Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
        ports => ports?,
    };
    ports.sort();
    Ok(ports)
}

impl Port {
    /// 8 data bits, no parity, one stop bit.
    ///
    /// # Errors
    /// A port that is not there, not allowed, not serial, in use, or cannot have this bit rate.
    pub fn open(path: &Path, baud: u32) -> Result<Self, PortError> {
        let name = path.display().to_string();
        let file = std::fs::metadata(path);
        if file.as_ref().is_ok_and(|file| file.is_file() || file.is_dir()) {
            return Err(PortError::NotSerial(name));
        }
        // Opened as it is first, so that what cannot be set up is told from what cannot be opened.
        let mut serial =
            SerialPort::open(path, serial2::KeepSettings).map_err(|error| refused(name.clone(), error))?;
        alone(&serial).map_err(|_| PortError::Busy(name.clone()))?;
        let mut settings = serial.get_configuration().map_err(|_| PortError::NotSerial(name.clone()))?;
        settings.set_raw();
        let set = settings.set_baud_rate(baud).and_then(|()| serial.set_configuration(&settings));
        set.map_err(|error| PortError::Baud { path: name.clone(), baud, error })?;
        let timeout = serial.set_write_timeout(WRITE_TIMEOUT);
        timeout.map_err(|error| PortError::Lost { path: name.clone(), error })?;
        Ok(Self { serial, name, baud, pace: Pace::new(f64::from(baud), Instant::now()) })
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn baud(&self) -> u32 {
        self.baud
    }

    /// Changes the bit rate when all has been sent.
    ///
    /// # Errors
    /// A bit rate that this port cannot have.
    pub fn set_baud(&mut self, baud: u32) -> Result<(), PortError> {
        let set = self.serial.flush().and_then(|()| self.serial.get_configuration());
        let set = set.and_then(|mut settings| {
            settings.set_baud_rate(baud)?;
            self.serial.set_configuration(&settings)
        });
        set.map_err(|error| PortError::Baud { path: self.name.clone(), baud, error })?;
        self.baud = baud;
        self.pace = Pace::new(f64::from(baud), Instant::now());
        Ok(())
    }

    /// Hands bytes over, and says when the last of them will have left.
    ///
    /// # Errors
    /// A port that is gone, or takes nothing for [`WRITE_TIMEOUT`].
    pub fn write(&mut self, bytes: &[u8]) -> Result<Instant, PortError> {
        self.serial.write_all(bytes).map_err(|error| match error.kind() {
            io::ErrorKind::TimedOut => PortError::Stalled(self.name.clone()),
            _ => self.lost(error),
        })?;
        Ok(self.pace.sent(bytes.len(), Instant::now()))
    }

    /// What has arrived, after waiting for it for at most `timeout`; nothing if nothing came.
    ///
    /// # Errors
    /// A port that is gone.
    pub fn read(&mut self, timeout: Duration) -> Result<Vec<u8>, PortError> {
        let mut bytes = [0; 1024];
        let read = self.serial.set_read_timeout(timeout).and_then(|()| self.serial.read(&mut bytes));
        match read {
            Ok(0) => Err(self.lost(io::ErrorKind::UnexpectedEof.into())),
            Ok(count) => Ok(bytes[..count].to_vec()),
            Err(error) if error.kind() == io::ErrorKind::TimedOut => Ok(Vec::new()),
            Err(error) => Err(self.lost(error)),
        }
    }

    /// How long the line is still busy.
    pub fn backlog(&self) -> Duration {
        self.pace.backlog(Instant::now())
    }

    /// How long `bytes` take on the line.
    pub fn time_of(&self, bytes: usize) -> Duration {
        self.pace.time_of(bytes)
    }

    fn lost(&self, error: io::Error) -> PortError {
        PortError::Lost { path: self.name.clone(), error }
    }
}

fn refused(name: String, error: io::Error) -> PortError {
    /// Of Unix: another program has it for itself.
    const EBUSY: i32 = 16;
    /// No such device behind the file.
    const ENXIO: i32 = 6;
    /// A file that is no terminal.
    const ENOTTY: i32 = 25;
    match (error.kind(), error.raw_os_error()) {
        (io::ErrorKind::NotFound, _) => PortError::Missing(name),
        (_, Some(EBUSY)) if cfg!(unix) => PortError::Busy(name),
        (_, Some(ENXIO)) if cfg!(unix) => PortError::Missing(name),
        (_, Some(ENOTTY)) if cfg!(unix) => PortError::NotSerial(name),
        // Windows lets one program have a port and denies it to others.
        (io::ErrorKind::PermissionDenied, _) if cfg!(windows) => PortError::Busy(name),
        (io::ErrorKind::PermissionDenied, _) => PortError::NoPermission(name),
        _ => PortError::Lost { path: name, error },
    }
}

/// Two programs that write to one board at once tear each other's frames: the second is refused.
#[cfg(unix)]
fn alone(serial: &SerialPort) -> io::Result<()> {
    Ok(rustix::fs::flock(serial, rustix::fs::FlockOperation::NonBlockingLockExclusive)?)
}

#[cfg(windows)]
fn alone(_: &SerialPort) -> io::Result<()> {
    Ok(())
}
