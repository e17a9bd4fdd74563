//! Window, `serve` and `send` put the same on the line for the same scene.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::fs::{Mode, OFlags, fcntl_setfl, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use sonoglyph::control;
use sonoglyph::control::desk::Desk;
use sonoglyph::control::edit::Edit;
use sonoglyph::control::live::Live;
use sonoglyph::device::board::memory::VirtualBoard;
use sonoglyph::device::calibration::Calibration;
use sonoglyph::device::envelope;
use sonoglyph::device::link::Settings;
use sonoglyph::device::native::packet::Packet;
use sonoglyph::device::native::table::Kind;
use sonoglyph::device::profile::Profile;
use sonoglyph::scene::file;

use crate::board::{connected_to, press, until};

/// Longer than the cycle of the motion, and than the period of the envelope.
const RECORDED: Duration = Duration::from_millis(1200);

/// A port with a virtual board in this program, which records what is written to it.
struct Recorder {
    path: PathBuf,
    is_over: Arc<AtomicBool>,
    thread: JoinHandle<BTreeSet<String>>,
}

impl Recorder {
    fn new(profile: Profile) -> Self {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let path = PathBuf::from(ptsname(&master, Vec::new()).unwrap().into_string().unwrap());
        let slave = open(&path, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty()).unwrap();
        let mut settings = tcgetattr(&slave).unwrap();
        settings.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &settings).unwrap();
        fcntl_setfl(&master, OFlags::RDWR | OFlags::NONBLOCK).unwrap();
        let is_over = Arc::new(AtomicBool::new(false));
        let its = Arc::clone(&is_over);
        let record = move || {
            let mut board = VirtualBoard::new(profile, profile.baud());
            let (mut bytes, mut part, mut shown) = (Vec::new(), [0; 4096], BTreeSet::new());
            while !its.load(Ordering::Relaxed) {
                let count = rustix::io::read(&master, &mut part).unwrap_or(0);
                bytes.extend_from_slice(&part[..count]);
                board.write(&part[..count]);
                let _ = rustix::io::write(&master, &board.read());
                shown.extend(board.frames().into_iter().map(|shown| format!("{:?}", shown.levels.channels)));
                std::thread::sleep(Duration::from_millis(1));
            }
            drop(slave);
            if profile.answers() { packets(&bytes) } else { shown }
        };
        let thread = std::thread::Builder::new().name("recorder".to_owned()).spawn(record).unwrap();
        Self { path, is_over, thread }
    }

    /// The frames shown by a stock board, or the packets to a native one.
    fn end(self) -> BTreeSet<String> {
        self.is_over.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }
}

/// The packets that say what to play. The number of questions and of silences, and the slot of a frame that is sent
/// again, depend on timing.
fn packets(bytes: &[u8]) -> BTreeSet<String> {
    let others = [Kind::Info, Kind::Status, Kind::Digest, Kind::Mute, Kind::Stop].map(Kind::code);
    let mut packets = BTreeSet::new();
    for mut packet in bytes.split(|&byte| byte == 0).filter_map(|part| Packet::of_line(part).ok()) {
        if [Kind::Phases, Kind::Frame].map(Kind::code).contains(&packet.code) {
            packet.arguments[0] = 0;
        }
        if !others.contains(&packet.code) {
            packets.insert(format!("{:?}", packet.numbered(0)));
        }
    }
    packets
}

fn by_window(port: &Path, profile: Profile, scene: &str, button: &str) {
    let mut screen = connected_to(port, profile, scene);
    press(&mut screen, button);
    until(&mut screen, "content in place", |screen| {
        screen.state().shown().board.health.as_ref().is_some_and(|health| health.in_place)
    });
    let begun = Instant::now();
    while begun.elapsed() < RECORDED {
        screen.step();
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn by_serve(port: &Path, profile: Profile, scene: &str) {
    let scene = file::parse(scene, Path::new("scene.toml")).unwrap();
    let desk = Arc::new(Desk::new(Arc::new(scene), Box::new(|| {})));
    let settings = Settings { port: port.to_owned(), profile, baud: None };
    let board = control::board::Board::open(settings, Calibration::default(), || false).unwrap();
    let mut live = Live::new(Arc::clone(&desk), board);
    desk.change(&[Edit::Send(true)]).unwrap();
    let start = Instant::now();
    let mut begun = None;
    while begun.is_none_or(|begun: Instant| begun.elapsed() < RECORDED) {
        live.turn();
        if desk.report().board.as_ref().is_some_and(|board| board.health.in_place) {
            begun.get_or_insert_with(Instant::now);
        }
        assert!(start.elapsed() < Duration::from_secs(60), "{:?}", desk.report());
    }
    live.close();
}

fn by_send(port: &Path, profile: Profile, scene: &Path) {
    let seconds = RECORDED.as_secs_f64().to_string();
    let mut command = Command::new(env!("CARGO_BIN_EXE_sonoglyph"));
    command.arg("send").arg(scene).arg("--port").arg(port).args(["--profile", profile.name()]);
    let output = command.args(["--seconds", &seconds]).stdout(Stdio::null()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Compares the three on every board that plays a scene.
fn compare(more: &str, button: &str) {
    let folder = tempfile::tempdir().unwrap();
    for profile in Profile::ALL.into_iter().chain([Profile::Natives(2)]) {
        let [columns, rows] = profile.shape().unwrap_or([16, profile.elements() as u32 / 16]);
        let text = format!(
            "format = 1\n[[target]]\nat = [0.01, 0.02, 0.1]\n[array]\ncolumns = {columns}\nrows = {rows}\n{more}"
        );
        let scene = file::parse(&text, Path::new("scene.toml")).unwrap();
        if envelope::plays(profile, &scene).is_err() {
            continue;
        }
        let path = folder.path().join(format!("{}.toml", profile.name()));
        std::fs::write(&path, &text).unwrap();
        let recorders = [(); 3].map(|()| Recorder::new(profile));
        std::thread::scope(|scope| {
            scope.spawn(|| by_serve(&recorders[1].path, profile, &text));
            scope.spawn(|| by_send(&recorders[2].path, profile, &path));
            by_window(&recorders[0].path, profile, &text, button);
        });
        let [window, serve, send] = recorders.map(Recorder::end);
        assert!(window.len() > 1, "{}: {window:?}", profile.name());
        for (name, other) in [("serve", serve), ("send", send)] {
            let [more, less] = [&other - &window, &window - &other];
            let differ = more.len() + less.len();
            assert!(differ == 0, "{}, {name}: {more:.100?} instead of {less:.100?}", profile.name());
        }
    }
}

#[test]
fn window_serve_and_send_write_the_same_still() {
    compare("", "Send");
}

#[test]
fn window_serve_and_send_write_the_same_motion() {
    compare("[motion]\npath = \"circle\"\nsize = 0.01\nframes = 4\nrate = 2.0\n", "Play motion");
}

#[test]
fn window_serve_and_send_write_the_same_envelope() {
    compare("[modulation]\nshape = \"square\"\nfrequency = 5.0\n", "Send");
}
