//! Commands for boards: `ports`, `check`, `send`, `serve` and `board`.

pub mod arguments;
#[cfg(unix)]
mod board;
pub mod check;
pub mod ports;
pub mod send;
pub mod serve;

#[cfg(not(unix))]
use arguments::BoardArgs;

#[cfg(unix)]
pub use board::run as board;

/// Without pseudo-terminals.
#[cfg(not(unix))]
pub fn board(_: &BoardArgs) -> anyhow::Result<()> {
    anyhow::bail!("virtual boards need a Unix system")
}
