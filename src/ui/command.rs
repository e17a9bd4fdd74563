//! What the user wants beyond the window: files, boards, other programs.

use std::path::{Path, PathBuf};

use crate::drive;
use crate::picture::figure::Format;
use crate::source;
use crate::studio::animate::Kind;
use crate::studio::{opening, routes, surfaces};
use crate::table::Table;
use crate::ui::board::BoardCommand;

/// Extensions of drawings.
pub const IMPORTED: &[&str] = &["svg", "png", "jpg", "jpeg", "bmp"];
/// Endings of tables of elements.
pub const ELEMENTS: &[&str] = &["csv", "pat", "txt", "tsv", "xml", "gz", "json", "npy"];
/// Endings of files of drives.
const DRIVES: &[&str] = &["csv", "tsv", "txt"];

/// Commands beyond the user interface.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    New,
    Open(PathBuf),
    /// By its index in the list.
    Example(usize),
    /// Renders an example's thumbnail, by index.
    Thumbnail(usize),
    Save,
    SaveAs(PathBuf),
    /// Saves over another program's changes.
    Overwrite(PathBuf),
    /// Reads a drawing and opens the import dialog.
    Import(PathBuf),
    /// Uses an element table as the array.
    TakeElements(PathBuf),
    /// Uses a table of wires.
    TakeWiring(PathBuf),
    /// Plays the drives of a file instead of solved ones.
    OpenDrive(PathBuf),
    /// Fits the array to the readings of a microphone.
    OpenScan(PathBuf),
    /// Takes the drives that were played during the scan.
    OpenScanDrive(PathBuf),
    Export(Export, PathBuf),
    /// Forgets the files that were open last.
    ForgetRecent,
    /// Takes a WAV file as the waveform of the scene's modulation, or of a target's own.
    Waveform(Option<usize>, PathBuf),
    /// Takes a table of thresholds of feeling for the skin.
    Thresholds(PathBuf),
    /// Takes a table as the directivity of the elements.
    Directivity(PathBuf),
    /// Takes a mesh as the surface of a body, or of a new one.
    Body(Option<usize>, PathBuf),
    /// Reads the path of a target's own motion, or of the scene's.
    Path(Option<usize>, PathBuf),
    /// Copies the scene as a link to the clipboard.
    CopyLink,
    /// Opens the scene of a link.
    OpenLink(String),
    /// Cancels the current export.
    CallOff,
    /// The answer to a file dialog.
    Answer(Purpose, String),
    /// Lists a folder; `None`: the last one.
    List(Option<PathBuf>),
    /// Opens the desktop's file dialog; without an answer, returns to the current one.
    Browse(Purpose, String),
    /// Puts the figure on the clipboard.
    CopyFigure,
    CompareMethods,
    Board(BoardCommand),
    /// Starts or stops live control by other programs.
    Serve(bool),
    /// Requests the clipboard's content.
    Paste,
    /// Recovers the scene of the last run.
    Recover,
    /// Discards the scene of the last run.
    Discard,
    Close,
}

impl Command {
    /// Whether it replaces the current scene.
    pub fn replaces_scene(&self) -> bool {
        matches!(self, Self::New | Self::Open(_) | Self::OpenLink(_) | Self::Example(_) | Self::Close)
    }
}

/// Export formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Export {
    /// Panels of what is shown, with the options of [`crate::ui::Editor::figure`].
    Figure(Format),
    /// The map or the 3D view as displayed.
    Map,
    /// Targets, drive and map on one page.
    Sheet,
    /// The map's numbers.
    Numbers,
    /// Phase and amplitude per element.
    Drive,
    /// The values along the profile line.
    Profile,
    /// Positions and directions of the elements.
    Elements,
    /// Corrections by a measured field, for the board of the Device page if it is to use them.
    Calibration { is_used: bool },
    /// Words and figure of a measured field.
    Report,
    /// Every frame of the displayed motion, with the options of [`crate::ui::Editor::film`].
    Motion(Kind),
}

/// Whether a file is a table of drives, by its columns.
fn is_drive(path: &Path) -> bool {
    source::open(path).is_ok_and(drive::is_table)
}

/// Whether a file is a scan of a microphone, by its columns: places with readings, and no elements or frames.
fn is_scan(path: &Path) -> bool {
    const COLUMNS: [&str; 9] = ["element", "frame", "time", "nx", "re", "im", "amplitude", "rms", "level"];
    let Ok(file) = source::open(path) else { return false };
    Table::open(file, ["x", "y", "z"], COLUMNS).is_ok_and(|table| {
        let has_any = |names: &[&str]| names.iter().any(|name| table.has(name));
        let has_readings = has_any(&["amplitude", "rms", "level"]) || (table.has("re") && table.has("im"));
        has_readings && !has_any(&["element", "frame", "time", "nx"])
    })
}

/// The purpose of a file dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    Open,
    SaveAs,
    /// A drawing that becomes targets.
    Import,
    /// A table of elements that becomes the array.
    Elements,
    /// A table of the board's channels.
    Wiring,
    /// Drives to be played instead of solved ones.
    Drive,
    /// Readings of a microphone.
    Scan,
    /// Drives that were played during the scan.
    ScanDrive,
    /// Waveform of the scene's modulation, or of a target's own.
    Waveform(Option<usize>),
    /// Thresholds of the skin.
    Thresholds,
    /// Directivity of an element.
    Directivity,
    /// Surface of a body, or of a new one.
    Body(Option<usize>),
    /// Path of a target's own motion, or of the scene's.
    Path(Option<usize>),
    Export(Export),
}

impl Purpose {
    /// For a file dropped on the window.
    pub fn of_dropped(path: &Path) -> Self {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match ending.as_str() {
            drawing if IMPORTED.contains(&drawing) => Self::Import,
            table if DRIVES.contains(&table) && is_scan(path) => Self::Scan,
            table if DRIVES.contains(&table) && is_drive(path) => Self::Drive,
            table if ELEMENTS.contains(&table) => Self::Elements,
            mesh if surfaces::ENDINGS.contains(&mesh) => Self::Body(None),
            _ => Self::Open,
        }
    }

    pub fn title(self) -> &'static str {
        match self {
            Self::Open => "Open a scene",
            Self::SaveAs => "Save the scene as",
            Self::Elements => "Open a table of elements (CSV, XML of Ultraino or acoular, PAT of OpenMPD)",
            Self::Wiring => "Open a wiring (CSV with element and channel, or PAT of OpenMPD)",
            Self::Drive => "Open a drive: phases and amplitudes of the elements (CSV)",
            Self::Scan => "Open a scan: readings of a microphone (CSV)",
            Self::ScanDrive => "Open the drives that were played during the scan (CSV)",
            Self::Import => "Import a drawing (SVG) or a picture of strokes (PNG, JPEG, BMP)",
            Self::Waveform(_) => "Open a waveform of the modulation (WAV)",
            Self::Directivity => {
                "Open a directivity (CSV with angle in degrees, amplitude or level in dB, and phase)"
            }
            Self::Body(_) => "Open the surface of a body (STL or OBJ)",
            Self::Thresholds => "Open thresholds (CSV with frequency in Hz and displacement in m, peak)",
            Self::Path(_) => "Open a path (CSV with x, y, z in m and perhaps t in s, or G-code)",
            Self::Export(Export::Figure(_)) => "Export the figure",
            Self::Export(Export::Map) => "Export the view as PNG",
            Self::Export(Export::Sheet) => "Export the sheet as PNG",
            Self::Export(Export::Numbers) => "Export the map data as NPY",
            Self::Export(Export::Drive) => "Export phases and amplitudes as CSV",
            Self::Export(Export::Elements) => "Export the elements as CSV",
            Self::Export(Export::Profile) => "Export the line profile as CSV",
            Self::Export(Export::Calibration { .. }) => "Save the calibration as CSV",
            Self::Export(Export::Report) => "Save the report as PDF, HTML, SVG or PNG",
            Self::Export(Export::Motion(_)) => "Export the motion",
        }
    }

    /// Accepted extensions, the default first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Open | Self::SaveAs => opening::ENDINGS,
            Self::Import => IMPORTED,
            Self::Elements | Self::Wiring => ELEMENTS,
            Self::Drive | Self::Scan | Self::ScanDrive => DRIVES,
            Self::Waveform(_) => &["wav"],
            Self::Thresholds | Self::Directivity => &["csv"],
            Self::Path(_) => routes::ENDINGS,
            Self::Body(_) => &surfaces::ENDINGS,
            Self::Export(Export::Figure(Format::Pdf)) => &["pdf"],
            Self::Export(Export::Figure(Format::Svg)) => &["svg"],
            Self::Export(Export::Figure(Format::Png) | Export::Map | Export::Sheet) => &["png"],
            Self::Export(Export::Numbers) => &["npy"],
            Self::Export(Export::Drive | Export::Profile | Export::Elements | Export::Calibration { .. }) => {
                &["csv"]
            }
            Self::Export(Export::Report) => &["pdf", "html", "svg", "png"],
            Self::Export(Export::Motion(kind)) => kind.endings(),
        }
    }

    /// Whether the file must exist.
    pub fn reads(self) -> bool {
        matches!(
            self,
            Self::Open
                | Self::Import
                | Self::Elements
                | Self::Wiring
                | Self::Drive
                | Self::Scan
                | Self::ScanDrive
                | Self::Waveform(_)
                | Self::Thresholds
                | Self::Directivity
                | Self::Body(_)
                | Self::Path(_)
        )
    }

    pub(super) fn verb(self) -> &'static str {
        match self {
            Self::Open | Self::Drive | Self::Scan | Self::ScanDrive => "Open",
            Self::SaveAs | Self::Export(Export::Calibration { .. } | Export::Report) => "Save",
            Self::Import
            | Self::Elements
            | Self::Wiring
            | Self::Waveform(_)
            | Self::Thresholds
            | Self::Directivity
            | Self::Body(_)
            | Self::Path(_) => "Read",
            Self::Export(_) => "Export",
        }
    }

    pub fn command(self, path: PathBuf) -> Command {
        match self {
            Self::Open => Command::Open(path),
            Self::SaveAs => Command::SaveAs(path),
            Self::Import => Command::Import(path),
            Self::Elements => Command::TakeElements(path),
            Self::Wiring => Command::TakeWiring(path),
            Self::Drive => Command::OpenDrive(path),
            Self::Scan => Command::OpenScan(path),
            Self::ScanDrive => Command::OpenScanDrive(path),
            Self::Waveform(target) => Command::Waveform(target, path),
            Self::Thresholds => Command::Thresholds(path),
            Self::Directivity => Command::Directivity(path),
            Self::Body(body) => Command::Body(body, path),
            Self::Path(target) => Command::Path(target, path),
            Self::Export(export) => Command::Export(export, path),
        }
    }

    /// The path with the default extension, if an output has none.
    pub fn with_ending(self, path: PathBuf) -> PathBuf {
        match path.extension() {
            None if !self.reads() => path.with_extension(self.extensions()[0]),
            _ => path,
        }
    }

    pub(super) fn takes(self, name: &str) -> bool {
        let ending = Path::new(name).extension().unwrap_or_default().to_string_lossy().to_lowercase();
        self.extensions().contains(&ending.as_str())
    }
}
