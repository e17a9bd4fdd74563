//! A process that a test starts and signals, killed at the end of the test.

use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

/// Upper limit of waiting for the end of a process.
const PATIENCE: Duration = Duration::from_secs(60);

/// Killed when dropped.
pub struct Running(pub Child);

impl Running {
    /// Sends a signal: INT, TERM and so on.
    pub fn signal(&self, name: &str) {
        let script = format!("kill -{name} {}", self.0.id());
        let sent = Command::new("sh").args(["-c", &script]).status().unwrap();
        assert!(sent.success(), "SIG{name}");
    }

    /// Waits for the end.
    pub fn ended(&mut self) -> ExitStatus {
        let start = Instant::now();
        loop {
            if let Some(status) = self.0.try_wait().unwrap() {
                return status;
            }
            assert!(start.elapsed() < PATIENCE, "timed out waiting for the end of the process");
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // Fails if the process has already ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
