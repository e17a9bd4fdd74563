//! The scan of a microphone on the Measure page: its files, and the gains and the bench that explain it.
//!
//! The files are read by the thread that fits, again whenever they are opened. With drives from a file the fit depends on
//! array and air alone, so that targets can be edited meanwhile; otherwise the scene's drive is solved for it.

pub mod panel;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use egui::Context;

use crate::gauge::Gauge;
use crate::measure::{Search, fit};
use crate::scene::{Scene, check};
use crate::source;
use crate::studio::figure;
use crate::studio::later::{Answer, Later};
use crate::studio::measurement::{self, DRIVE, Measured, Reading};
use crate::studio::posing::posed;
use crate::ui::layout::Panel;
use crate::ui::part::{Background, Now, wake};

/// Resolution of progress.
const STEPS: f64 = 1000.0;

/// The files of a scan, and what is known of the microphone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScanForm {
    pub scan: Option<PathBuf>,
    /// Drives that the user chose.
    pub drive: Option<PathBuf>,
    /// Drives that lie beside the scan.
    beside: Option<PathBuf>,
    /// Diameter of the microphone's membrane, m; fitted if `None`.
    pub width: Option<f64>,
    /// Number of times that files were opened: their content may have changed.
    opened: u32,
}

/// The inputs of a fit.
#[derive(Clone, Debug, PartialEq)]
struct Input {
    /// Reduced to what matters.
    scene: Scene,
    scan: PathBuf,
    drive: Option<PathBuf>,
    width: Option<f64>,
    opened: u32,
}

/// A fitted scan with its texts and its figure.
#[derive(Debug)]
pub struct Finding {
    pub measured: Measured,
    /// The sentence of the verdict.
    pub verdict: String,
    /// Names and values of what was found; sentences have no name.
    pub facts: Vec<(String, String)>,
    pub warnings: Vec<String>,
    /// Remarks on the files and the fit that are no reasons for care.
    pub notes: Vec<String>,
    pub panels: Vec<figure::Panel>,
}

type Output = Result<Arc<Finding>, String>;

/// A calibration on the disk, and the result that it is of.
#[derive(Debug)]
struct Saved {
    finding: Arc<Finding>,
    with_gains: bool,
    path: PathBuf,
}

/// The open scan, with its newest fit.
#[derive(Debug, Default)]
pub struct Measuring {
    pub form: ScanForm,
    /// Whether a calibration evens the gains, too.
    pub with_gains: bool,
    saved: Option<Saved>,
    input: Option<Input>,
    made: Later<Input, Output>,
    /// Completed part of the running fit.
    progress: Arc<AtomicU32>,
}

impl ScanForm {
    fn input(&self, scene: &Scene) -> Option<Input> {
        let (scan, drive) = (self.scan.clone()?, self.drive().map(Path::to_owned));
        let scene = match &drive {
            None => posed(scene),
            Some(_) => Scene {
                medium: scene.medium.clone(),
                array: scene.array.clone(),
                boards: scene.boards.clone(),
                reflectors: scene.reflectors.clone(),
                ..Scene::default()
            },
        };
        Some(Input { scene, scan, drive, width: self.width, opened: self.opened })
    }

    /// The file of the drives; `None`: the scene's own.
    pub fn drive(&self) -> Option<&Path> {
        self.drive.as_deref().or(self.beside.as_deref())
    }
}

impl Measuring {
    /// Takes the file of a scan, with the drives beside it. Chosen drives stay for further scans of their folder.
    pub fn open(&mut self, path: PathBuf) {
        if self.form.scan.as_deref().and_then(Path::parent) != path.parent() {
            self.form.drive = None;
        }
        self.form.scan = Some(path);
        self.read_again();
    }

    /// Takes other drives; `None`: those beside the scan, or else the scene's own.
    pub fn take_drive(&mut self, path: Option<PathBuf>) {
        self.form.drive = path;
        self.read_again();
    }

    /// Reads the files again.
    pub fn read_again(&mut self) {
        let beside = self.form.scan.as_ref().map(|scan| scan.with_file_name(DRIVE));
        self.form.beside = beside.filter(|path| source::exists(path));
        self.form.opened += 1;
    }

    /// The result of the present files and scene, or the reason for its absence.
    pub fn exact(&self) -> Option<Result<&Arc<Finding>, &str>> {
        let output = self.made.get(self.input.as_ref()?)?;
        Some(output.as_ref().map_err(String::as_str))
    }

    /// The result before a change, of the same scan, while the next one is computed.
    fn earlier(&self) -> Option<&Arc<Finding>> {
        let (input, before) = (self.input.as_ref()?, self.made.latest()?);
        let is_of_this = (&input.scan, input.opened) == (&before.scan, before.opened);
        self.made.newest()?.as_ref().ok().filter(|_| is_of_this && self.is_running())
    }

    /// The displayed result.
    pub fn finding(&self) -> Option<&Arc<Finding>> {
        self.exact().and_then(Result::ok).or_else(|| self.earlier())
    }

    /// The completed part of the running fit.
    fn part(&self) -> Option<f32> {
        let part = f64::from(self.progress.load(Ordering::Relaxed)) / STEPS;
        self.is_running().then_some(part as f32)
    }

    /// Remembers the file of the present result's calibration.
    pub fn saved_as(&mut self, path: PathBuf) {
        let finding = self.exact().and_then(Result::ok).cloned();
        self.saved = finding.map(|finding| Saved { finding, with_gains: self.with_gains, path });
    }

    /// The file of the present result's calibration.
    fn saved(&self) -> Option<&Path> {
        let finding = self.exact()?.ok()?;
        let is_of_this =
            |saved: &&Saved| Arc::ptr_eq(&saved.finding, finding) && saved.with_gains == self.with_gains;
        self.saved.as_ref().filter(is_of_this).map(|saved| saved.path.as_path())
    }
}

impl Background for Measuring {
    fn collect(&mut self) -> bool {
        self.made.collect()
    }

    /// A fit goes on while another page is shown, and is cancelled once its inputs differ.
    fn update(&mut self, now: &Now<'_>, ctx: &Context) {
        let is_shown = now.panel == Some(Panel::Measure);
        if is_shown || self.form.scan.is_none() {
            self.input = self.form.input(now.scene);
        }
        self.made.keep(self.input.as_ref());
        let Some(input) = self.input.as_ref().filter(|_| is_shown && now.rests) else { return };
        let (was_running, progress) = (self.made.is_running(), Arc::<AtomicU32>::default());
        let (told, wake_up) = (Arc::clone(&progress), wake(ctx));
        let ctx = ctx.clone();
        self.made.ask_with(input, wake_up, move |input, answer| {
            let gauge = Gauge::new(move |part| {
                let part = (STEPS * part) as u32;
                if told.swap(part, Ordering::Relaxed) != part {
                    ctx.request_repaint();
                }
            });
            compute(input, answer, gauge)
        });
        if !was_running {
            self.progress = progress;
        }
    }

    fn is_running(&self) -> bool {
        self.made.is_running()
    }
}

fn compute(input: &Input, answer: &Answer<Output>, gauge: Gauge) -> Output {
    let Input { scene, scan: path, drive, width, .. } = input;
    check::check(scene).map_err(|error| error.to_string())?;
    let Reading { scan, drives, notes } = measurement::read(scene, path, drive.as_deref())?;
    let search = Search { width: *width, ..Search::default() };
    let fitted = fit(scene, &drives, &scan, &search, &gauge.until(&answer.cancel));
    let fitted = fitted.map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(Arc::new(Finding::new(Measured::new(scene.clone(), scan, fitted, None), notes)))
}

impl Finding {
    fn new(measured: Measured, mut notes: Vec<String>) -> Self {
        let mut lines = measured.lines().into_iter();
        // The window has no options of the command line.
        let verdict = lines.next().unwrap_or_default().replace(", or --snr,", "");
        notes.extend(measured.notes());
        Self {
            verdict: figure::capital(&verdict),
            facts: lines.map(|line| parted(&line)).collect(),
            warnings: measured.warnings().iter().map(|text| figure::capital(text)).collect(),
            notes: notes.iter().map(|text| figure::capital(text)).collect(),
            panels: measurement::panels(&measured),
            measured,
        }
    }
}

/// Name and value of a line: before and after its first colon, or before its first number. A long name makes it a sentence.
fn parted(line: &str) -> (String, String) {
    /// Letters of a name.
    const LONGEST: usize = 20;
    let is_number = |at: usize| {
        let rest = line[at..].trim_start_matches(['+', '-', '−']);
        rest.starts_with(|first: char| first.is_ascii_digit())
    };
    let number = line.match_indices(' ').find(|(at, _)| is_number(at + 1));
    let colon = line.match_indices(": ").next();
    let first = number.into_iter().chain(colon).min_by_key(|(at, _)| *at);
    match first.filter(|(at, _)| *at <= LONGEST) {
        Some((at, between)) => (figure::capital(&line[..at]), line[at + between.len()..].to_owned()),
        None => (String::new(), figure::capital(line)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_a_name_and_a_value() {
        for (line, name, value) in [
            ("shift x -0.31 ± 0.02 mm", "Shift x", "-0.31 ± 0.02 mm"),
            ("element radius 4.5 mm held: as it is", "Element radius", "4.5 mm held: as it is"),
            ("16 elements: phases 3.1° rms", "16 elements", "phases 3.1° rms"),
            ("dead: 3, 7", "Dead", "3, 7"),
            ("elements alike", "", "Elements alike"),
            ("held, as nothing else is known: z 2 mm", "", "Held, as nothing else is known: z 2 mm"),
        ] {
            assert_eq!(parted(line), (name.to_owned(), value.to_owned()));
        }
    }

    #[test]
    fn drives_of_a_file_make_targets_irrelevant() {
        let scene = Scene::default();
        let other = Scene { targets: Vec::new(), bead: scene.bead.clone(), ..scene.clone() };
        let mut moved = scene.clone();
        moved.plane.centre.z += 0.01;
        let mut measuring = Measuring::default();
        assert_eq!(measuring.form.input(&scene), None);
        measuring.open(PathBuf::from("no such folder/scan.csv"));
        measuring.take_drive(Some(PathBuf::from("drive.csv")));
        let input = |measuring: &Measuring, scene: &Scene| measuring.form.input(scene).unwrap();
        assert_eq!(input(&measuring, &scene), input(&measuring, &other));
        assert_eq!(input(&measuring, &scene), input(&measuring, &moved));
        let mut warmer = scene.clone();
        warmer.array.element_radius *= 2.0;
        assert_ne!(input(&measuring, &scene), input(&measuring, &warmer));
        let before = input(&measuring, &scene);
        measuring.read_again();
        assert_ne!(before, input(&measuring, &scene));
    }
}
