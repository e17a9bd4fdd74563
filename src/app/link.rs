//! The connected board: the link, the last sent state, and the values shown by the panel.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use eframe::egui::Context;

use crate::acoustics::Aperture;
use crate::device::calibration::Calibration;
use crate::device::health::State;
use crate::device::link::{Content, Event, Link, Settings};
use crate::device::port;
use crate::device::profile::Profile;
use crate::device::task::{self, Task};
use crate::device::wiring::{Share, Wiring};
use crate::scene::{Envelope, Modulation};
use crate::solver::{self, Problem, Solution};
use crate::source;
use crate::studio::bring_up::{Report, Verdict, focus_scene, survey_line, tested};
use crate::studio::output::{self, note};
use crate::studio::performance::Performance;
use crate::studio::player::Player;
use crate::ui::board::{BoardCommand, BoardShown, Plays, PortShown, Ports, absence, sentence};
use crate::ui::bring_up::Surveyed;
use crate::ui::{Editor, Notice, Panel, Shown};

/// Polling interval of a link's figures.
const LOOK: Duration = Duration::from_millis(250);
/// Hz of modulated test sounds: for hands, and for microphones.
const FELT: f64 = 200.0;
const AUDIBLE: f64 = 500.0;
/// Search (s) for a board after which Send gives up: one that appears later must not sound by surprise.
const SEARCH: f64 = 2.0;
/// Messages that are kept.
const KEPT: usize = 20;

/// The player, once connected.
#[derive(Debug, Default)]
pub struct Board {
    /// Shared with the thread that waits for Ctrl-C.
    player: Arc<Mutex<Option<Player>>>,
    hears_signals: bool,
    /// A scene or a motion is to be sent, once it is solved.
    awaits: bool,
    /// s on the window's clock since when a board is missing that was never found.
    missing: Option<f64>,
    compared: Option<(Arc<Solution>, Wiring)>,
    survey: Option<Receiver<Surveyed>>,
    /// Whether ports have been listed: once at the beginning, then on request.
    has_listed: bool,
    ports: Option<Receiver<Vec<PortShown>>>,
    /// The result of the port dialog.
    choice: Option<Receiver<Result<Option<String>, String>>>,
}

impl Board {
    /// The panel's state before the first connection.
    pub fn shown() -> BoardShown {
        BoardShown { ports_from: ports_from(), ..BoardShown::default() }
    }

    /// Silences the board for other programs, while the window does something else.
    pub fn silencer(&self) -> Box<dyn Fn() + Send + Sync> {
        let player = Arc::clone(&self.player);
        Box::new(move || locked(&player).iter().for_each(|player| player.link.silencer().silence()))
    }

    /// Learns, before what other programs wish, whether they have silenced the board since the last frame.
    pub fn attend(&mut self, shown: &mut Shown) {
        if locked(&self.player).as_mut().is_some_and(Player::was_silenced) {
            shown.board.plays = Plays::Nothing;
        }
    }

    pub fn execute(&mut self, command: &BoardCommand, editor: &mut Editor, shown: &mut Shown, ctx: &Context) {
        let profile = editor.board.profile;
        match command {
            BoardCommand::ListPorts => self.list_ports(ctx),
            BoardCommand::ChoosePort => self.choose_port(ctx),
            BoardCommand::Connect => self.connect(editor, shown, ctx),
            BoardCommand::Disconnect => {
                editor.board.leave_test();
                *locked(&self.player) = None;
                (shown.board.health, shown.board.found, shown.board.plays) = (None, None, Plays::Nothing);
                editor.board.virtual_port = None;
            }
            BoardCommand::EndTest => {
                shown.board.plays = Plays::Nothing;
                let mut player = locked(&self.player);
                player.iter_mut().for_each(Player::stop);
                if player.is_none() {
                    editor.board.virtual_port = None;
                }
            }
            BoardCommand::TryWithout => self.try_without(editor, shown, ctx),
            BoardCommand::AskForBoard => {
                let text = shown.board.missing();
                shown.notice = Some(Notice { text, is_error: true });
            }
            BoardCommand::Send => (self.awaits, shown.board.plays) = (true, Plays::Scene),
            BoardCommand::PlayMotion => (self.awaits, shown.board.plays) = (true, Plays::Motion),
            BoardCommand::Stop => {
                shown.board.plays = Plays::Nothing;
                locked(&self.player).iter_mut().for_each(Player::stop);
            }
            BoardCommand::One => {
                let element = editor.board.element;
                shown.board.plays = Plays::One(element);
                let (_, wiring) = tested(profile, editor.scene());
                self.show(Content::Still(wiring.one(element as usize)));
            }
            BoardCommand::Checkerboard => {
                shown.board.plays = Plays::Checkerboard;
                let (scene, wiring) = tested(profile, editor.scene());
                self.show(Content::Still(wiring.checkerboard(scene.array.columns as usize)));
            }
            BoardCommand::Survey => self.survey(editor, shown, ctx),
            BoardCommand::Focus => self.focus(editor, shown),
            BoardCommand::SaveCalibration(text) => self.save_calibration(text, editor, shown),
            BoardCommand::TakeCarrier => {
                if let Some(found) = shown.board.found {
                    editor.document.scene.array.frequency = found.carrier;
                }
            }
        }
    }

    /// A separate task, since slow lines take seconds.
    fn survey(&mut self, editor: &mut Editor, shown: &mut Shown, ctx: &Context) {
        if let Err(error) = begin_with_own(editor) {
            editor.board.leave_test();
            return refuse(shown, &error);
        }
        *locked(&self.player) = None;
        (shown.board.health, shown.board.found, shown.board.plays) = (None, None, Plays::Nothing);
        shown.board.surveyed = None;
        let (port, profile) = (editor.board.port().to_owned(), editor.board.profile);
        let (sender, receiver) = sync_channel(1);
        let ctx = ctx.clone();
        let task = Task::start("survey", move || async move {
            // The receiver may be gone.
            let _ = sender.send(surveyed(&port, profile).await);
            drop(sender);
            ctx.request_repaint();
        });
        match task {
            Ok(_) => self.survey = Some(receiver),
            Err(error) => refuse(shown, &error.to_string()),
        }
    }

    fn list_ports(&mut self, ctx: &Context) {
        self.ports = Some(ask(ctx, async {
            port::available().await.unwrap_or_default().iter().map(shown_port).collect()
        }));
    }

    fn choose_port(&mut self, ctx: &Context) {
        self.choice = Some(ask(ctx, async {
            let port = chosen().await.map_err(|error| error.to_string())?;
            Ok(port.map(|port| port.display().to_string()))
        }));
    }

    fn focus(&mut self, editor: &Editor, shown: &mut Shown) {
        let profile = editor.board.profile;
        let carrier = shown.board.found.map_or(profile.carrier(), |found| found.carrier);
        let Some(player) = &mut *locked(&self.player) else { return };
        let scene = focus_scene(&tested(profile, editor.scene()).0, carrier);
        let solved = solver::solve(&scene).map_err(|error| error.to_string());
        let levels = solved.and_then(|solution| player.levels(&scene, &solution.drive));
        match levels {
            Ok(levels) => {
                shown.board.plays = Plays::Focus;
                player.show(Content::Still(levels));
            }
            Err(error) => refuse(shown, &error),
        }
    }

    fn save_calibration(&mut self, text: &str, editor: &mut Editor, shown: &mut Shown) {
        let Some(run) = &editor.board.bring_up else { return };
        let path = PathBuf::from(run.file.trim());
        let own = editor.board.calibration().is_some_and(|own| own == path);
        let written = match source::exists(&path) && !own {
            true => Err(anyhow::anyhow!("{}: this file already exists", path.display())),
            false => output::save(&path, text.as_bytes()),
        };
        shown.notice = Some(match written {
            Ok(()) => {
                editor.board.calibration = path.display().to_string();
                let text = format!("{} is used from the next connection on", path.display());
                Notice { text, is_error: false }
            }
            Err(error) => Notice { text: format!("{error:#}"), is_error: true },
        });
    }

    fn show(&self, content: Content) {
        if let Some(player) = &mut *locked(&self.player) {
            player.show(content);
        }
    }

    fn connect(&mut self, editor: &mut Editor, shown: &mut Shown, ctx: &Context) {
        // A test that is continued starts from it, too; an error is told below.
        let _ = begin_with_own(editor);
        let form = &editor.board;
        let calibration = match form.calibration() {
            Some(path) => Calibration::read(&path, &tested(form.profile, editor.scene()).0)
                .map_err(|error| format!("{}: {error}", path.display())),
            None => Ok(Calibration::default()),
        };
        let opened = calibration.and_then(|calibration| {
            let port = Path::new(form.port()).to_owned();
            let settings = Settings { port, profile: form.profile, baud: form.baud() };
            let ctx = ctx.clone();
            Player::open(settings, calibration, Box::new(move || ctx.request_repaint()))
                .map_err(|error| error.to_string())
        });
        match opened {
            Ok(player) => {
                shown.board.health = Some(player.link.health());
                shown.board.messages.clear();
                self.hear_signals();
                *locked(&self.player) = Some(player);
            }
            Err(error) => shown.notice = Some(Notice { text: sentence(&error), is_error: true }),
        }
    }

    /// Connects to a virtual board in this program.
    fn try_without(&mut self, editor: &mut Editor, shown: &mut Shown, ctx: &Context) {
        editor.board.virtual_port = Some(port::virtual_board(editor.board.profile).display().to_string());
        self.connect(editor, shown, ctx);
        if shown.board.health.is_none() {
            editor.board.virtual_port = None;
        }
    }

    /// Ctrl-C ends the window as ever, but not before its board is silent.
    fn hear_signals(&mut self) {
        if !std::mem::replace(&mut self.hears_signals, true) {
            // Without it only the board's own watchdog remains, if any.
            if let Err(error) = silence_on_signals(Arc::clone(&self.player)) {
                note(&format!("Ctrl-C will not silence the board: {error}"));
            }
        }
    }

    /// Sends changes, and updates the panel's values.
    pub fn update(&mut self, editor: &mut Editor, shown: &mut Shown, ctx: &Context) {
        self.compare(editor, shown);
        if !std::mem::replace(&mut self.has_listed, true) {
            self.list_ports(ctx);
        }
        if let Some(surveyed) = received(&mut self.survey) {
            shown.board.surveyed = Some(surveyed);
        }
        if let Some(ports) = received(&mut self.ports) {
            shown.board.ports = ports;
        }
        match received(&mut self.choice) {
            Some(Ok(Some(port))) => {
                editor.board.port = port;
                self.list_ports(ctx);
            }
            Some(Err(error)) => refuse(shown, &error),
            Some(Ok(None)) | None => {}
        }
        let shared = Arc::clone(&self.player);
        let mut held = locked(&shared);
        let Some(player) = &mut *held else { return };
        while let Some(event) = player.link.event() {
            hear(event, &player.link, shown);
        }
        let health = player.link.health();
        let is_missing = health.found == 0 && matches!(health.state, State::Lost(_));
        let now = ctx.input(|input| input.time);
        let since = is_missing.then(|| self.missing.unwrap_or(now));
        self.missing = since;
        if let (Some(since), Plays::Scene | Plays::Motion) = (since, shown.board.plays)
            && now - since > SEARCH
        {
            player.stop();
            let port = player.link.settings().port.display();
            refuse(shown, &format!("Nothing was sent: no board is at {port}"));
        }
        // After an emergency stop a drag must not start the sound again: only a button pressed while the board is
        // still stopped does.
        let was_stopped = shown.board.health.as_ref().is_some_and(|before| before.stopped);
        if health.stopped && !was_stopped && matches!(shown.board.plays, Plays::Scene | Plays::Motion) {
            shown.board.plays = Plays::Nothing;
        }
        shown.board.health = Some(health);
        ctx.request_repaint_after(LOOK);
        let modulation = modulation(editor, shown.board.plays);
        if let Err(error) = player.modulate(&modulation, editor.scene().array.frequency)
            && matches!(shown.board.plays, Plays::Scene | Plays::Motion)
        {
            player.stop();
            return refuse(shown, &error);
        }
        let performance = match shown.board.plays {
            Plays::Scene if shown.solution.is_none() => {
                // Without targets the board is silent.
                player.rest();
                self.awaits = true;
                None
            }
            Plays::Scene if self.awaits || editor.board.live => {
                shown.solution.clone().map(Performance::Still)
            }
            Plays::Motion if self.awaits => shown.round.clone().map(Performance::Motion),
            Plays::Nothing
            | Plays::Scene
            | Plays::Motion
            | Plays::One(_)
            | Plays::Checkerboard
            | Plays::Focus => None,
        };
        let Some(performance) = performance else { return };
        if std::mem::take(&mut self.awaits) {
            player.forget();
        }
        match player.play(editor.scene(), performance) {
            Ok(notices) => notices.into_iter().for_each(|text| tell(shown, &text, false)),
            Err(error) => refuse(shown, &error),
        }
    }

    /// Compares the scene's drive with its version on the board, on demand.
    fn compare(&mut self, editor: &Editor, shown: &mut Shown) {
        let profile = editor.board.profile;
        let Some(solution) = &shown.solution else {
            shown.board.pressures = None;
            return;
        };
        if editor.panel != Panel::Device {
            return;
        }
        let Ok(wiring) = Wiring::of(profile, editor.scene(), Share::default()) else {
            (shown.board.pressures, self.compared) = (None, None);
            return;
        };
        let same =
            |(compared, of): &(Arc<Solution>, Wiring)| Arc::ptr_eq(compared, solution) && *of == wiring;
        if self.compared.as_ref().is_some_and(same) {
            return;
        }
        let aperture = Aperture::new(editor.scene());
        let fits = !solution.foci.is_empty() && aperture.positions.len() == solution.drive.phases.len();
        let levels = wiring.levels(&solution.drive, &Calibration::default());
        shown.board.pressures = levels.ok().filter(|_| fits).map(|levels| {
            let transfer = Problem::new(&aperture, solution.foci.clone()).transfer;
            let played = transfer.pressure(&wiring.drive(&levels.drive()).excitation(&aperture.driven));
            let mean = played.iter().map(|p| p.norm()).sum::<f64>() / played.len().max(1) as f64;
            (solution.quality.mean_pressure, mean)
        });
        self.compared = Some((solution.clone(), wiring));
    }
}

/// The thread waiting for Ctrl-C shares the link, so it must be closed explicitly.
impl Drop for Board {
    fn drop(&mut self) {
        drop(locked(&self.player).take());
    }
}

fn locked(player: &Mutex<Option<Player>>) -> MutexGuard<'_, Option<Player>> {
    task::locked(player)
}

#[cfg(unix)]
fn silence_on_signals(player: Arc<Mutex<Option<Player>>>) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGQUIT, SIGTERM, SIGHUP])?;
    let wait = move || {
        for signal in signals.forever() {
            drop(locked(&player).take());
            // This ends the program; if it fails, the window can still be closed.
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        }
    };
    std::thread::Builder::new().name("signals".to_owned()).spawn(wait).map(drop)
}

/// Windows only has Ctrl-C and Ctrl-Break, and only for windows opened from a console.
#[cfg(windows)]
fn silence_on_signals(player: Arc<Mutex<Option<Player>>>) -> std::io::Result<()> {
    let end = move || {
        drop(locked(&player).take());
        std::process::exit(130);
    };
    match ctrlc::set_handler(end) {
        Ok(()) | Err(ctrlc::Error::MultipleHandlers) => Ok(()),
        Err(ctrlc::Error::NoSuchSignal(_)) => Err(std::io::ErrorKind::Unsupported.into()),
        Err(ctrlc::Error::System(error)) => Err(error),
    }
}

#[cfg(not(any(unix, windows)))]
fn silence_on_signals(_: Arc<Mutex<Option<Player>>>) -> std::io::Result<()> {
    Ok(())
}

/// What the board is modulated by: tests have their own.
fn modulation(editor: &Editor, plays: Plays) -> Modulation {
    let sine = |frequency| Modulation { shape: Envelope::Sine, frequency, ..Modulation::default() };
    match (plays, &editor.board.bring_up) {
        (Plays::Focus, _) => sine(FELT),
        (Plays::One(_), Some(run)) if run.modulates => sine(AUDIBLE),
        (Plays::One(_), Some(_)) => Modulation { shape: Envelope::Off, ..Modulation::default() },
        (Plays::One(_) | Plays::Nothing | Plays::Scene | Plays::Motion | Plays::Checkerboard, _) => {
            editor.scene().envelope().clone()
        }
    }
}

fn hear(event: Event, link: &Link, shown: &mut Shown) {
    let profile = link.settings().profile;
    let (text, is_error) = match event {
        Event::Ready(found) => {
            shown.board.found = Some(found);
            let text = match profile.answers() {
                true => format!("The board is ready, at {} baud", found.baud),
                false if profile.echoes() => format!(
                    "The board sends back commands, at {} baud; {} cannot confirm what it plays",
                    found.baud,
                    profile.title()
                ),
                false => format!(
                    "The port is open, at {} baud; {} cannot confirm what it plays",
                    found.baud,
                    profile.title()
                ),
            };
            (text, false)
        }
        Event::Lost(why) => (absence(&why, link.health().found > 0), true),
        Event::Notice(text) => (text, false),
    };
    tell(shown, &text, is_error);
}

/// Adds a message of the board.
fn tell(shown: &mut Shown, text: &str, is_error: bool) {
    let text = sentence(text);
    let messages = &mut shown.board.messages;
    messages.push(text.clone());
    let old = messages.len().saturating_sub(KEPT);
    messages.drain(..old);
    shown.notice = Some(Notice { text, is_error });
}

/// Starts with the current calibration, to which silent elements are added.
fn begin_with_own(editor: &mut Editor) -> Result<(), String> {
    let Some(path) = editor.board.calibration() else { return Ok(()) };
    let (scene, _) = tested(editor.board.profile, editor.scene());
    let own = Calibration::read(&path, &scene).map_err(|error| format!("{}: {error}", path.display()))?;
    if let Some(run) = &mut editor.board.bring_up {
        // It is written as CSV.
        let file = path.with_extension("csv").display().to_string();
        run.start_from(own);
        run.file = file;
    }
    Ok(())
}

/// The findings at a port, including failures.
async fn surveyed(port: &str, profile: Profile) -> Surveyed {
    let mut report = Report::default();
    let tell = &mut |verdict, what| report.note(verdict, what);
    let baud = survey_line(Path::new(port), profile, tell).await;
    let baud = baud.unwrap_or_else(|error| {
        report.note(Verdict::Failed, format!("{error:#}"));
        None
    });
    Surveyed { findings: report.findings, baud }
}

/// Reports the reason for not sending, and clears the wish.
fn refuse(shown: &mut Shown, text: &str) {
    shown.board.plays = Plays::Nothing;
    shown.notice = Some(Notice { text: sentence(text), is_error: true });
}

/// A short operation, longer in a page.
fn ask<T: 'static>(ctx: &Context, work: impl Future<Output = T> + 'static) -> Receiver<T> {
    let (sender, receiver) = sync_channel(1);
    let ctx = ctx.clone();
    task::run(async move {
        // The receiver may be gone.
        let _ = sender.send(work.await);
        ctx.request_repaint();
    });
    receiver
}

/// The result of a task, once.
fn received<T>(receiver: &mut Option<Receiver<T>>) -> Option<T> {
    let value = receiver.as_ref()?.try_recv();
    // A task that ended silently sends nothing more.
    if !matches!(value, Err(TryRecvError::Empty)) {
        *receiver = None;
    }
    value.ok()
}

fn shown_port(port: &port::Listed) -> PortShown {
    PortShown { name: port.path.display().to_string(), label: port.to_string(), profile: port.profile }
}

#[cfg(not(target_arch = "wasm32"))]
fn ports_from() -> Ports {
    Ports::Computer
}

#[cfg(target_arch = "wasm32")]
fn ports_from() -> Ports {
    if port::is_there() { Ports::Browser } else { Ports::Nowhere }
}

/// Paths are typed.
#[cfg(not(target_arch = "wasm32"))]
async fn chosen() -> std::io::Result<Option<PathBuf>> {
    Ok(None)
}

#[cfg(target_arch = "wasm32")]
async fn chosen() -> std::io::Result<Option<PathBuf>> {
    port::choose().await
}
