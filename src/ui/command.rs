//! What the user wants beyond the window: files, boards, other programs.

use std::path::PathBuf;

use crate::picture::figure::Format;
use crate::scene::Scene;
use crate::studio::animate::Kind;
use crate::ui::board::BoardCommand;
use crate::ui::dialog::file::Purpose;

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
    Export(Export, PathBuf),
    /// Forgets the files that were open last.
    ForgetRecent,
    /// Takes a WAV file as the modulation's waveform.
    Waveform(PathBuf),
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
    Recover(Box<Scene>),
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
    /// The map with axes, with the options of [`crate::ui::Editor::figure`].
    Figure(Format),
    /// The map as displayed.
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
    /// Every frame of the displayed motion, with the options of [`crate::ui::Editor::film`].
    Motion(Kind),
}
