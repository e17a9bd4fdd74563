//! The serial ports of this computer, with blocking operations.

use std::fs::File;
use std::io::{self, IsTerminal, Read, Write};
use std::path::{Path, PathBuf};

#[cfg(windows)]
use serialport::COMPort as Serial;
#[cfg(unix)]
use serialport::TTYPort as Serial;
use serialport::{SerialPort, SerialPortInfo, SerialPortType};
use web_time::Duration;

#[cfg(unix)]
use crate::device::board;
use crate::device::port::error::{Listed, PortError, WRITE_TIMEOUT};
#[cfg(unix)]
use crate::device::port::guardian::Guardian;
#[cfg(unix)]
use crate::device::profile::Profile;
use crate::echo;

/// Tolerated relative error of a bit rate, as a divisor.
const BAUD_TOLERANCE: u32 = 40;
/// Folder in which Linux lists its terminals.
const LINUX_PORTS: &str = "/sys/class/tty";

/// An open port.
#[derive(Debug)]
pub struct Wire {
    /// Ends before the port is closed, which is then free.
    #[cfg(unix)]
    guardian: Option<Guardian>,
    serial: Serial,
    name: String,
}

/// Ports that look like serial ones, in order, and then the virtual boards that run here.
///
/// # Errors
/// A system that does not say.
pub async fn available() -> io::Result<Vec<Listed>> {
    let mut ports = serial_ports()?;
    ports.extend(virtual_boards());
    Ok(ports)
}

#[cfg(unix)]
fn virtual_boards() -> Vec<Listed> {
    let listed = |(path, profile): (PathBuf, Profile)| {
        let what = Some(format!("virtual board, {}", profile.name()));
        Listed { path, what, profile: Some(profile) }
    };
    board::running().into_iter().map(listed).collect()
}

#[cfg(not(unix))]
fn virtual_boards() -> Vec<Listed> {
    Vec::new()
}

fn serial_ports() -> io::Result<Vec<Listed>> {
    // serialport panics if Linux lists no terminals, as in some containers.
    if cfg!(target_os = "linux")
        && let Err(error) = std::fs::read_dir(LINUX_PORTS)
    {
        return if error.kind() == io::ErrorKind::NotFound { Ok(Vec::new()) } else { Err(error) };
    }
    Ok(in_order(serialport::available_ports()?))
}

fn in_order(ports: Vec<SerialPortInfo>) -> Vec<Listed> {
    let port = |port: SerialPortInfo| {
        let what = in_words(port.port_type);
        Listed { path: PathBuf::from(port.port_name), what, profile: None }
    };
    let mut ports: Vec<_> = ports.into_iter().map(port).collect();
    ports.sort_by(|one, other| one.path.cmp(&other.path));
    ports
}

/// Product and manufacturer of a USB adapter, as external text.
fn in_words(kind: SerialPortType) -> Option<String> {
    match kind {
        SerialPortType::UsbPort(usb) => {
            let parts = [usb.product, usb.manufacturer].into_iter().flatten();
            let parts: Vec<_> =
                parts.map(|part| echo::message(&part)).filter(|part| !part.is_empty()).collect();
            (!parts.is_empty()).then(|| parts.join(", "))
        }
        SerialPortType::BluetoothPort => Some("Bluetooth".to_owned()),
        SerialPortType::PciPort | SerialPortType::Unknown => None,
    }
}

impl Wire {
    pub async fn open(path: &Path, baud: u32) -> Result<Self, PortError> {
        let name = path.display().to_string();
        let file = std::fs::metadata(path);
        if file.as_ref().is_ok_and(|file| file.is_file() || file.is_dir()) {
            return Err(PortError::NotSerial(name));
        }
        let serial = serialport::new(path.to_string_lossy(), baud)
            .open_native()
            .map_err(|error| refused(path, baud, error))?;
        never_block(&serial).map_err(|error| PortError::Lost { path: name.clone(), error })?;
        #[cfg(target_os = "linux")]
        hold_dtr(&serial).map_err(|error| PortError::Lost { path: name.clone(), error })?;
        ask_for_low_latency(&serial);
        check_rate(&serial, baud).map_err(|error| PortError::Baud { path: name.clone(), baud, error })?;
        Ok(Self {
            #[cfg(unix)]
            guardian: None,
            serial,
            name,
        })
    }

    /// When all has been sent.
    pub async fn set_baud(&mut self, baud: u32) -> Result<(), PortError> {
        let set = self.serial.flush().and_then(|()| Ok(self.serial.set_baud_rate(baud)?));
        let set = set.and_then(|()| check_rate(&self.serial, baud));
        set.map_err(|error| PortError::Baud { path: self.name.clone(), baud, error })
    }

    pub async fn write(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        self.hand_over(bytes)
    }

    fn hand_over(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        let written = self.wait_at_most(WRITE_TIMEOUT).and_then(|()| self.serial.write_all(bytes));
        written.map_err(|error| match waited_in_vain(&error) {
            true => PortError::Stalled(self.name.clone()),
            false => self.lost(error),
        })
    }

    pub async fn read(&mut self, timeout: Duration) -> Result<Vec<u8>, PortError> {
        let mut bytes = [0; 1024];
        let read = self.wait_at_most(timeout).and_then(|()| self.serial.read(&mut bytes));
        match read {
            Ok(0) => Err(self.lost(io::ErrorKind::UnexpectedEof.into())),
            Ok(count) => Ok(bytes[..count].to_vec()),
            Err(error) if waited_in_vain(&error) => Ok(Vec::new()),
            Err(error) => Err(self.lost(error)),
        }
    }

    /// Drops the bytes that have not left for the adapter.
    pub fn discard(&mut self) -> bool {
        self.serial.clear(serialport::ClearBuffer::Output).is_ok()
    }

    /// Bytes that have not left for the adapter; 0 if the system does not count them.
    pub fn held(&self) -> usize {
        self.serial.bytes_to_write().map_or(0, |bytes| bytes as usize)
    }

    /// The system sends them when this program has ended.
    pub fn leave(&mut self, last: &[u8]) -> bool {
        self.hand_over(last).is_ok()
    }

    /// A guardian has them.
    #[cfg(unix)]
    pub fn leave_behind(&mut self, last: &[u8], wait: Duration) -> io::Result<()> {
        self.guardian = Guardian::start(descriptor(&self.serial), last, wait)?;
        Ok(())
    }

    /// Windows has no guardian: only an unwinding thread silences the board.
    #[cfg(windows)]
    pub fn leave_behind(&mut self, _: &[u8], _: Duration) -> io::Result<()> {
        Ok(())
    }

    /// serialport has one timeout for reads and writes.
    fn wait_at_most(&mut self, timeout: Duration) -> io::Result<()> {
        // A timeout of 0 is undefined on Windows.
        let least = Duration::from_millis(if cfg!(windows) { 1 } else { 0 });
        Ok(self.serial.set_timeout(timeout.max(least))?)
    }

    fn lost(&self, error: io::Error) -> PortError {
        PortError::Lost { path: self.name.clone(), error }
    }
}

/// Whether the operation timed out; Windows then returns 0 bytes without an error.
fn waited_in_vain(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock, WriteZero};
    matches!(error.kind(), Interrupted | TimedOut | WouldBlock | WriteZero)
}

/// The reason of a failure to open a port. serialport reports few distinct reasons, so the system is asked again.
fn refused(path: &Path, baud: u32, error: serialport::Error) -> PortError {
    let name = path.display().to_string();
    if cfg!(unix) && error.kind == serialport::ErrorKind::NoDevice {
        return PortError::Busy(name);
    }
    match open_as_file(path) {
        Err(error) => unopened(name, error),
        Ok(file) if cfg!(unix) && !file.is_terminal() => PortError::NotSerial(name),
        Ok(_) => PortError::Baud { path: name, baud, error: error.into() },
    }
}

/// Opens a port without setting it up, and without waiting for a carrier.
#[cfg(unix)]
fn open_as_file(path: &Path) -> io::Result<File> {
    use rustix::fs::{Mode, OFlags};
    let how = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    Ok(rustix::fs::open(path, how, Mode::empty())?.into())
}

#[cfg(windows)]
fn open_as_file(path: &Path) -> io::Result<File> {
    File::options().read(true).write(true).open(format!(r"\\.\{}", path.display()))
}

fn unopened(name: String, error: io::Error) -> PortError {
    /// Unix: no device behind the file.
    const ENXIO: i32 = 6;
    match (error.kind(), error.raw_os_error()) {
        (io::ErrorKind::NotFound, _) => PortError::Missing(name),
        (_, Some(ENXIO)) if cfg!(unix) => PortError::Missing(name),
        // Windows gives a port to one program and denies it to others.
        (io::ErrorKind::PermissionDenied, _) if cfg!(windows) => PortError::Busy(name),
        (io::ErrorKind::PermissionDenied, _) => PortError::NoPermission(name),
        _ => PortError::Lost { path: name, error },
    }
}

/// Drivers may choose another rate, at which the line carries noise.
fn check_rate(serial: &Serial, baud: u32) -> io::Result<()> {
    match serial.baud_rate()? {
        rate if rate.abs_diff(baud) <= baud / BAUD_TOLERANCE => Ok(()),
        rate => Err(io::Error::other(format!("the port runs at {rate} instead"))),
    }
}

/// serialport would block until all bytes are written.
#[cfg(unix)]
fn never_block(serial: &Serial) -> io::Result<()> {
    use rustix::fs::{OFlags, fcntl_setfl};
    Ok(fcntl_setfl(descriptor(serial), OFlags::NONBLOCK)?)
}

/// DTR falls no more when the port is closed: its next rise would reset an Arduino.
#[cfg(target_os = "linux")]
fn hold_dtr(serial: &Serial) -> io::Result<()> {
    use rustix::termios::{ControlModes, OptionalActions, tcgetattr, tcsetattr};
    let mut settings = tcgetattr(descriptor(serial))?;
    settings.control_modes.remove(ControlModes::HUPCL);
    Ok(tcsetattr(descriptor(serial), OptionalActions::Now, &settings)?)
}

#[cfg(unix)]
#[expect(unsafe_code, reason = "the descriptor stays open as long as the port that it is borrowed from")]
fn descriptor(serial: &Serial) -> rustix::fd::BorrowedFd<'_> {
    use rustix::fd::{AsRawFd, BorrowedFd};
    unsafe { BorrowedFd::borrow_raw(serial.as_raw_fd()) }
}

/// Does nothing on Windows, whose timeout covers the whole write.
#[cfg(windows)]
fn never_block(_: &Serial) -> io::Result<()> {
    Ok(())
}

/// FTDI's driver then hands bytes on after 1 ms in place of 16. Other ports ignore or refuse it.
#[cfg(target_os = "linux")]
#[expect(unsafe_code, reason = "the structure is the one that the kernel reads and writes with these calls")]
fn ask_for_low_latency(serial: &Serial) {
    use std::ffi::{c_int, c_uint, c_ulong, c_ushort, c_void};

    use rustix::ioctl::{Getter, Opcode, Setter, ioctl};

    const TIOCGSERIAL: Opcode = 0x541E;
    const TIOCSSERIAL: Opcode = 0x541F;
    const ASYNC_LOW_LATENCY: c_int = 1 << 13;

    /// `serial_struct` of `linux/serial.h`.
    #[repr(C)]
    struct Settings {
        kind_line_port_irq: [c_int; 4],
        flags: c_int,
        fifo_divisor_base: [c_int; 3],
        close_delay: c_ushort,
        io_type: [u8; 2],
        hub6: c_int,
        closing_wait: [c_ushort; 2],
        iomem_base: *mut c_void,
        iomem_reg_shift: c_ushort,
        port_high: c_uint,
        iomap_base: c_ulong,
    }

    let settings = unsafe { ioctl(descriptor(serial), Getter::<TIOCGSERIAL, Settings>::new()) };
    if let Ok(mut settings) = settings {
        settings.flags |= ASYNC_LOW_LATENCY;
        // A port that refuses is as good as before.
        let _ = unsafe { ioctl(descriptor(serial), Setter::<TIOCSSERIAL, Settings>::new(settings)) };
    }
}

#[cfg(not(target_os = "linux"))]
fn ask_for_low_latency(_: &Serial) {}

#[cfg(test)]
mod tests {
    use serialport::UsbPortInfo;

    use super::*;

    #[test]
    fn adapters_are_named_as_the_system_names_them() {
        let named = |product: Option<&str>, manufacturer: Option<&str>| {
            let [product, manufacturer] = [product, manufacturer].map(|name| name.map(str::to_owned));
            in_words(SerialPortType::UsbPort(UsbPortInfo {
                vid: 0x0403,
                pid: 0x6001,
                serial_number: None,
                manufacturer,
                product,
            }))
        };
        assert_eq!(named(Some("FT232R USB UART"), Some("FTDI")).unwrap(), "FT232R USB UART, FTDI");
        assert_eq!(named(None, Some("FTDI")).unwrap(), "FTDI");
        assert_eq!((named(None, Some("")), in_words(SerialPortType::Unknown)), (None, None));
        assert!(!named(Some("\u{1b}[2J"), None).unwrap().contains('\u{1b}'), "text from outside is escaped");
    }

    #[test]
    fn ports_are_listed_by_name() {
        let port = |name: &str| SerialPortInfo {
            port_name: name.to_owned(),
            port_type: SerialPortType::BluetoothPort,
        };
        let listed = in_order(["/dev/ttyUSB1", "/dev/ttyACM0", "/dev/ttyUSB0"].map(port).to_vec());
        let said: Vec<_> = listed.iter().map(ToString::to_string).collect();
        let names = ["/dev/ttyACM0", "/dev/ttyUSB0", "/dev/ttyUSB1"];
        assert_eq!(said, names.map(|name| format!("{name} (Bluetooth)")));
    }
}

#[cfg(all(test, unix))]
mod tests_with_boards {
    use web_time::Instant;

    use super::*;
    use crate::device::board::{Board, Setup};
    use crate::device::native::packet::Packet;
    use crate::device::task::{finish, sleep};

    const PATIENCE: Duration = Duration::from_secs(20);

    #[expect(clippy::unwrap_used, reason = "a test's helper may panic")]
    fn board(profile: Profile) -> Board {
        Board::start(Setup::new(profile), Box::new(|_| {})).unwrap()
    }

    #[test]
    fn virtual_boards_are_listed_in_order_as_long_as_they_run() {
        let profiles = Profile::ALL;
        let boards = profiles.map(board);
        let mut own: Vec<_> = boards.iter().map(|board| board.path().to_owned()).zip(profiles).collect();
        own.sort_by(|(one, _), (other, _)| one.cmp(other));
        let listed = || -> Vec<_> {
            let all = finish(available()).unwrap().into_iter();
            let all = all.filter_map(|listed| Some((listed.path, listed.profile?)));
            all.filter(|board| own.contains(board)).collect()
        };
        assert_eq!(listed(), own);
        drop(boards);
        assert!(listed().is_empty());
    }

    #[test]
    fn folders_are_no_ports() {
        let opened = finish(Wire::open(&std::env::temp_dir(), 9600));
        assert!(matches!(opened, Err(PortError::NotSerial(_))));
    }

    #[test]
    fn a_read_waits_for_the_answer() {
        let board = board(Profile::Native);
        let mut wire = finish(Wire::open(board.path(), Profile::Native.baud())).unwrap();
        finish(wire.write(&Packet::info().to_line())).unwrap();
        assert!(!finish(wire.read(PATIENCE)).unwrap().is_empty());
    }

    #[test]
    fn bytes_at_another_bit_rate_are_noise() {
        let board = board(Profile::Native);
        // No packet ends in them.
        let bytes = [0x55; 2000];
        let mut wire = finish(Wire::open(board.path(), Profile::Native.baud() / 2)).unwrap();
        finish(wire.write(&bytes)).unwrap();
        let until = Instant::now() + PATIENCE;
        while board.report().wrong_baud < bytes.len() as u64 {
            assert!(Instant::now() < until);
            finish(sleep(Duration::from_millis(1)));
        }
        assert!(board.report().spoiled > 0);
    }
}
