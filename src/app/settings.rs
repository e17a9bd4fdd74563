//! Settings kept between runs: position, panels, colours, board, and recent files.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use egui::{Context, ThemePreference};
use serde::{Deserialize, Serialize};

use crate::app::board_tests;
use crate::device::profile::Profile;
use crate::echo;
use crate::field::Scale;
use crate::picture::ColourMap;
use crate::scene::Scene;
use crate::scene::strict::Strict;
use crate::source;
use crate::studio::convention::Convention;
use crate::studio::output;
use crate::ui::board::BoardForm;
use crate::ui::bring_up::KeptTest;
use crate::ui::document::Document;
use crate::ui::{Editor, action};

/// s between two files.
const OFTEN: f64 = 2.0;
/// Files that are remembered.
const MOST_RECENT: usize = 10;
/// Bits per second that a line may have.
const BAUDS: RangeInclusive<u32> = 1200..=12_000_000;
/// Bytes of the file, at most.
const MOST_BYTES: u64 = 1 << 20;
/// Limits of window sizes and positions in points.
const SMALLEST: [f32; 2] = [200.0, 150.0];
const LARGEST: f32 = 16_384.0;

const THEMES: [(ThemePreference, &str); 3] =
    [(ThemePreference::System, "system"), (ThemePreference::Dark, "dark"), (ThemePreference::Light, "light")];

const GROUNDS: [(bool, &str); 2] = [(false, "dark"), (true, "light")];

/// The name of a value in the file; the first one by default.
fn name<T: PartialEq>(names: &[(T, &'static str)], value: &T) -> String {
    names.iter().find(|(own, _)| own == value).unwrap_or(&names[0]).1.to_owned()
}

fn value<T: Copy>(names: &[(T, &'static str)], name: &str) -> Option<T> {
    names.iter().find(|(_, own)| *own == name).map(|(value, _)| *value)
}

/// The file's contents. Missing values have their defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Points of the screen, inside the frame.
    pub size: [f32; 2],
    /// `None`: chosen by the desktop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f32; 2]>,
    pub maximized: bool,
    pub theme: String,
    /// Scale factor of the window.
    pub scale: f32,
    /// Whether the hints of the first start are still shown.
    pub hints: bool,
    pub panel: String,
    /// Points of the screen.
    pub panel_width: f32,
    pub section_height: f32,
    pub section: bool,
    pub marks: bool,
    pub grid_lines: bool,
    pub guides: bool,
    pub elements: bool,
    pub extremes: bool,
    pub palm: bool,
    pub contours: bool,
    /// dB
    pub contour_level: f64,
    pub threshold_contours: bool,
    pub shaded: bool,
    pub colours: String,
    pub decibels: bool,
    /// Lower end of a logarithmic scale relative to the largest value.
    pub floor: f64,
    /// The brightness of phase maps follows the amplitude.
    pub fades: bool,
    /// Ground of maps: dark or light.
    pub ground: String,
    /// Pressures are stated as peak amplitudes.
    pub peak: bool,
    /// m
    pub grid: f64,
    pub snaps: bool,
    /// Kind of board, its port, and its calibration file.
    pub board: String,
    pub port: String,
    /// A bit rate of any board, in old files.
    #[serde(skip_serializing)]
    pub baud: u32,
    pub calibration: String,
    /// The last one first.
    pub recent: Vec<PathBuf>,
    /// Bit rates that the user chose, by kind of board.
    pub rates: BTreeMap<String, u32>,
}

impl Default for Settings {
    /// The settings of a new editor.
    fn default() -> Self {
        let editor = Editor::new(Document::new(Scene::default(), "untitled"));
        Self { hints: true, ..Self::of_editor(&editor) }
    }
}

impl Settings {
    /// The current settings.
    pub fn of(editor: &Editor, recent: &[PathBuf], ctx: &Context) -> Self {
        let window = ctx.input(|input| input.viewport().clone());
        let content = ctx.content_rect();
        let presented = if editor.layout.presents { action::PRESENTED } else { 1.0 };
        let pair = |x: f32, y: f32| [x.round(), y.round()];
        Self {
            size: pair(content.width() * ctx.zoom_factor(), content.height() * ctx.zoom_factor()),
            position: window.outer_rect.map(|rect| pair(rect.min.x, rect.min.y)),
            maximized: window.maximized.unwrap_or(false),
            theme: name(&THEMES, &ctx.options(|options| options.theme_preference)),
            scale: (ctx.zoom_factor() / presented * 100.0).round() / 100.0,
            recent: recent.to_vec(),
            ..Self::of_editor(editor)
        }
    }

    /// The editor's part, in a window by default.
    fn of_editor(editor: &Editor) -> Self {
        let Editor { view, board, layout, .. } = editor;
        Self {
            size: [1280.0, 800.0],
            position: None,
            maximized: false,
            theme: THEMES[0].1.to_owned(),
            scale: 1.0,
            hints: editor.hints,
            panel: editor.panel.into_str().to_owned(),
            panel_width: layout.panel.round(),
            section_height: layout.section.round(),
            section: view.section,
            marks: view.marks,
            grid_lines: view.grid,
            guides: view.guides,
            elements: view.elements,
            extremes: view.extremes,
            palm: view.palm,
            contours: view.contours,
            contour_level: view.contour_level,
            threshold_contours: view.threshold_contours,
            shaded: view.shaded,
            colours: view.colours.into_str().to_owned(),
            decibels: view.scale == Scale::Logarithmic,
            floor: view.floor,
            fades: view.fades,
            ground: name(&GROUNDS, &view.is_light),
            peak: view.convention == Convention::Peak,
            grid: editor.grid,
            snaps: editor.snaps,
            board: board.profile.name().to_owned(),
            port: board.port.trim().to_owned(),
            baud: 0,
            rates: rates(board),
            calibration: board.calibration.trim().to_owned(),
            recent: Vec::new(),
        }
    }

    /// Restores the settings.
    pub fn apply(&self, editor: &mut Editor, ctx: &Context) {
        ctx.set_theme(value(&THEMES, &self.theme).unwrap_or(THEMES[0].0));
        action::scale(ctx, self.scale);
        editor.hints = self.hints;
        editor.panel = self.panel.parse().unwrap_or(editor.panel);
        editor.layout.panel = self.panel_width;
        editor.layout.section = self.section_height;
        (editor.grid, editor.snaps) = (self.grid, self.snaps);
        let board = &mut editor.board;
        board.profile = Profile::of_name(&self.board).unwrap_or(board.profile);
        board.port.clone_from(&self.port);
        board.rates =
            self.rates.iter().filter_map(|(name, &baud)| Some((Profile::of_name(name)?, baud))).collect();
        board.calibration.clone_from(&self.calibration);
        let view = &mut editor.view;
        (view.section, view.marks) = (self.section, self.marks);
        (view.grid, view.guides) = (self.grid_lines, self.guides);
        (view.elements, view.extremes, view.palm) = (self.elements, self.extremes, self.palm);
        (view.contour_level, view.threshold_contours) = (self.contour_level, self.threshold_contours);
        (view.floor, view.fades) = (self.floor, self.fades);
        view.is_light = value(&GROUNDS, &self.ground).unwrap_or(false);
        (view.contours, view.shaded) = (self.contours, self.shaded);
        view.scale = if self.decibels { Scale::Logarithmic } else { Scale::Linear };
        view.convention = if self.peak { Convention::Peak } else { Convention::Rms };
        let named = ColourMap::OF_AMOUNTS.into_iter().find(|map| map.into_str() == self.colours);
        view.colours = named.unwrap_or(view.colours);
    }

    /// Parses the file's text, with all numbers clamped to their limits.
    ///
    /// # Errors
    /// The invalid part.
    pub fn parse(text: &str) -> Result<Self, String> {
        let settings = toml::Deserializer::parse(text).and_then(|table| Self::deserialize(Strict(table)));
        let settings =
            settings.map_err(|error| echo::message(error.message().lines().next().unwrap_or_default()));
        Ok(settings?.sane())
    }

    fn sane(mut self) -> Self {
        let own = Self::default();
        let within = |value: f32, least: f32, most: f32, otherwise: f32| {
            if value.is_finite() { value.clamp(least, most) } else { otherwise }
        };
        let ([width, height], [own_width, own_height]) = (self.size, own.size);
        self.size = [
            within(width, SMALLEST[0], LARGEST, own_width),
            within(height, SMALLEST[1], LARGEST, own_height),
        ];
        let is_on_a_screen = |place: &[f32; 2]| place.iter().all(|x| (-LARGEST..LARGEST).contains(x));
        self.position = self.position.filter(is_on_a_screen);
        self.scale = within(self.scale, 0.75, 2.0, own.scale);
        self.panel_width = within(self.panel_width, 100.0, 1000.0, own.panel_width);
        self.section_height = within(self.section_height, 50.0, 1000.0, own.section_height);
        let between = |value: f64, least: f64, most: f64, otherwise: f64| {
            if value.is_finite() { value.clamp(least, most) } else { otherwise }
        };
        self.grid = between(self.grid, 1e-4, 0.1, own.grid);
        self.floor = between(self.floor, 1e-12, 0.9, own.floor);
        self.contour_level = between(self.contour_level, -60.0, -0.1, own.contour_level);
        self.rates.retain(|_, baud| BAUDS.contains(baud));
        // A silent board of a wrong rate stays silent without an error, so only boards that answer keep an old one.
        let old = std::mem::take(&mut self.baud);
        let is_sure = Profile::of_name(&self.board).is_some_and(Profile::answers);
        if is_sure && BAUDS.contains(&old) {
            self.rates.entry(self.board.clone()).or_insert(old);
        }
        self.recent.truncate(MOST_RECENT);
        self
    }
}

/// The chosen bit rates by the boards' names.
fn rates(board: &BoardForm) -> BTreeMap<String, u32> {
    board.rates.iter().map(|(profile, &baud)| (profile.name().to_owned(), baud)).collect()
}

/// Adds an opened or saved file to the front of the recent files.
pub fn remember(recent: &mut Vec<PathBuf>, path: &Path) {
    // A non-text name cannot be stored in the settings.
    if path.to_str().is_none() {
        return;
    }
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    recent.retain(|own| *own != path);
    recent.insert(0, path);
    recent.truncate(MOST_RECENT);
}

/// The settings' file, and that of board tests. Pending settings are written on drop.
#[derive(Debug)]
pub struct Memory {
    path: PathBuf,
    /// The board tests in their file.
    tests: Vec<KeptTest>,
    /// The settings in the file.
    kept: Settings,
    pending: Option<Settings>,
    /// s on the window's clock.
    last: f64,
}

impl Memory {
    /// The file in this folder, its settings, and a message if it is unreadable.
    pub fn at(folder: &Path) -> (Self, Settings, Option<String>) {
        let path = folder.join("settings.toml");
        let read = match source::read_text(&path, MOST_BYTES) {
            Ok(text) => Settings::parse(&text),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Settings::default()),
            Err(error) => Err(error.to_string()),
        };
        let (settings, word) = match read {
            Ok(settings) => (settings, None),
            Err(why) => (Settings::default(), Some(format!("{} was ignored: {why}", path.display()))),
        };
        let (tests, kept) = (board_tests::read(folder), settings.clone());
        (Self { path, tests, kept, pending: None, last: f64::NEG_INFINITY }, settings, word)
    }

    /// The board tests that were left.
    pub fn board_tests(&self) -> &[KeptTest] {
        &self.tests
    }

    /// Writes the board tests, if they have changed.
    pub fn keep_board_tests(&mut self, board: &BoardForm) {
        let tests = board_tests::lasting(board);
        if tests != self.tests
            && let Some(folder) = self.path.parent()
        {
            board_tests::write(folder, &tests);
            self.tests = tests;
        }
    }

    /// Writes the settings at intervals. Returns the seconds until the next call.
    pub fn keep(&mut self, mut settings: Settings, now: f64) -> Option<f64> {
        if settings.maximized {
            // The size that it goes back to.
            (settings.size, settings.position) = (self.kept.size, self.kept.position);
        }
        self.pending = Some(settings).filter(|settings| *settings != self.kept);
        self.pending.as_ref()?;
        if now - self.last < OFTEN {
            return Some(OFTEN - (now - self.last));
        }
        self.last = now;
        self.write();
        None
    }

    fn write(&mut self) {
        let Some(settings) = self.pending.take() else { return };
        let mut file = settings.clone();
        // Includes files opened by other windows meanwhile.
        let there =
            source::read_text(&self.path, MOST_BYTES).ok().and_then(|text| Settings::parse(&text).ok());
        let recent = there.map_or_else(Vec::new, |there| there.recent);
        let is_known = |path: &PathBuf| self.kept.recent.contains(path) || settings.recent.contains(path);
        file.recent.extend(recent.into_iter().filter(|path| !is_known(path)));
        file.recent.truncate(MOST_RECENT);
        // If writing fails, the next run starts with defaults.
        if let (Some(folder), Ok(text)) = (self.path.parent(), toml::to_string(&file)) {
            let _ = std::fs::create_dir_all(folder);
            // A pipe would block the window until it is read.
            let _ =
                output::refuse_stream(&self.path).and_then(|()| output::write(&self.path, text.as_bytes()));
        }
        self.kept = settings;
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        self.write();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::FLOOR;
    use crate::ui::Panel;

    fn blank() -> Editor {
        Editor::new(Document::new(Scene::default(), "untitled"))
    }

    #[test]
    fn each_setting_survives_its_file_and_a_new_editor() {
        let (mut editor, ctx) = (blank(), Context::default());
        editor.panel = Panel::Device;
        (editor.layout.panel, editor.layout.section) = (300.0, 180.0);
        (editor.grid, editor.snaps) = (0.002, true);
        let board = &mut editor.board;
        board.profile = Profile::SonicSurface;
        board.rates = [(Profile::SonicSurface, 9600), (Profile::Native, 3_000_000)].into();
        (board.port, board.calibration) = ("/dev/ttyUSB1".to_owned(), "gains.csv".to_owned());
        let view = &mut editor.view;
        for toggle in [
            &mut view.section,
            &mut view.marks,
            &mut view.grid,
            &mut view.guides,
            &mut view.elements,
            &mut view.extremes,
            &mut view.palm,
            &mut view.contours,
            &mut view.threshold_contours,
            &mut view.shaded,
            &mut view.fades,
        ] {
            *toggle = !*toggle;
        }
        (view.contour_level, view.floor, view.is_light) = (-3.0, 0.01, true);
        (view.colours, view.scale) = (ColourMap::Viridis, Scale::Logarithmic);
        view.convention = Convention::Peak;
        let window = Settings {
            size: [900.0, 700.0],
            position: Some([3.0, 4.0]),
            maximized: true,
            theme: "dark".to_owned(),
            scale: 1.25,
            recent: vec![PathBuf::from("/a.toml")],
            ..Settings::of_editor(&editor)
        };
        let table = |settings: &Settings| toml::Table::try_from(settings).unwrap();
        let (kept, own) = (table(&window), table(&Settings::default()));
        for (key, value) in &kept {
            assert_ne!(own.get(key), Some(value), "{key} is not changed by this test");
        }
        let read = Settings::parse(&toml::to_string(&window).unwrap()).unwrap();
        assert_eq!(read, window);
        let mut next = blank();
        read.apply(&mut next, &ctx);
        assert_eq!(Settings::of_editor(&next), Settings::of_editor(&editor));
        assert_eq!(ctx.options(|options| options.theme_preference), ThemePreference::Dark);
    }

    #[test]
    fn what_is_kept_is_there_in_the_next_run() {
        let folder = tempfile::tempdir().unwrap();
        let (mut memory, first, word) = Memory::at(folder.path());
        assert_eq!((first, word), (Settings::default(), None));
        let mut settings = Settings { panel_width: 300.0, theme: "light".to_owned(), ..Settings::default() };
        remember(&mut settings.recent, Path::new("/a/b.toml"));
        assert_eq!(memory.keep(settings.clone(), 1.0), None);
        assert_eq!(Memory::at(folder.path()).1, settings);
        settings.decibels = true;
        assert_eq!(memory.keep(settings.clone(), 2.0), Some(1.0), "not all the time");
        assert_ne!(Memory::at(folder.path()).1, settings);
        drop(memory);
        assert_eq!(Memory::at(folder.path()).1, settings, "the last ones are written at the end");
    }

    #[test]
    fn what_two_windows_open_is_remembered_of_both_and_what_one_forgets_is_forgotten() {
        let folder = tempfile::tempdir().unwrap();
        let opened = |settings: &mut Settings, name: &str| remember(&mut settings.recent, Path::new(name));
        let (mut one, mut first, _) = Memory::at(folder.path());
        let (mut other, mut second, _) = Memory::at(folder.path());
        opened(&mut first, "/a");
        one.keep(first.clone(), 0.0);
        opened(&mut second, "/b");
        other.keep(second, 0.0);
        opened(&mut first, "/c");
        one.keep(first.clone(), 9.0);
        let recent = || Memory::at(folder.path()).1.recent;
        assert_eq!(recent(), ["/c", "/a", "/b"].map(PathBuf::from));
        first.recent.clear();
        one.keep(first, 18.0);
        assert_eq!(recent(), [PathBuf::from("/b")]);
    }

    #[test]
    fn broken_files_are_ignored_with_a_word_and_odd_numbers_come_within_their_limits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        for broken in ["size = [", "panel_width = \"wide\"", "\u{0}"] {
            std::fs::write(&path, broken).unwrap();
            let (_, settings, word) = Memory::at(folder.path());
            assert_eq!(settings, Settings::default());
            assert!(word.unwrap().contains("settings.toml was ignored: "));
        }
        let odd = "size = [nan, 1e30]\nposition = [inf, 0]\npanel_width = -5\ngrid = nan\nfloor = inf\ncontour_level = 9\nbaud = 7\nnew_key = 1\n";
        std::fs::write(&path, odd).unwrap();
        let (_, settings, word) = Memory::at(folder.path());
        assert_eq!(word, None);
        assert_eq!((settings.size, settings.position), ([1280.0, LARGEST], None));
        assert_eq!((settings.panel_width, settings.grid), (100.0, 0.005));
        // A rate of the old form, which was that of any board.
        for (board, rates) in [("native", 1), ("sonicsurface", 0)] {
            let old = Settings::parse(&format!("board = {board:?}\nbaud = 3000000\n")).unwrap();
            assert_eq!(old.rates.len(), rates, "{board}");
        }
        assert_eq!((settings.floor, settings.contour_level), (FLOOR.into(), -0.1));
    }

    #[test]
    fn a_file_is_remembered_once_and_the_last_one_first() {
        let mut recent = Vec::new();
        for name in ["a", "b", "a", "c", "d", "e", "f", "g", "h", "i", "j", "k"] {
            remember(&mut recent, &Path::new("/scenes").join(name));
        }
        assert_eq!(recent.len(), MOST_RECENT);
        assert!(recent[0].ends_with("k") && recent.iter().filter(|path| path.ends_with("a")).count() <= 1);
    }
}
