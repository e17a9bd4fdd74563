//! The open dialog, and what the file dialog keeps.

use std::path::{Path, PathBuf};

use crate::studio::opening;
use crate::ui::board::BoardCommand;
use crate::ui::command::{Command, Purpose};
use crate::ui::dialog::import::Import;
use crate::ui::document::Document;

/// A modal dialog or message.
#[derive(Clone, Debug, PartialEq)]
pub enum Dialog {
    /// Choice of a file.
    Path {
        purpose: Purpose,
        text: String,
    },
    /// The file already exists.
    Replace {
        purpose: Purpose,
        /// The typed text.
        text: String,
        path: PathBuf,
    },
    /// Unsaved changes would be lost by this command.
    Unsaved(Command),
    /// Another program has changed the file to be saved.
    Changed(PathBuf),
    /// A failure and its reason.
    Message {
        title: String,
        text: String,
    },
    /// A scene that the last run did not save.
    Recovered {
        name: String,
        targets: usize,
    },
    /// The loudness warning.
    Loud(BoardCommand),
    /// All actions, searched by name.
    Palette {
        text: String,
        chosen: usize,
    },
    /// Placement of a drawing.
    Import(Box<Import>),
    /// Options of a figure of the map.
    Figure,
    /// Options of a film of the motion.
    Film,
    /// The figure of a measured field, enlarged.
    Measured,
    /// The examples with pictures.
    Examples,
    /// A page of the manual, by its index.
    Manual(usize),
    Help,
    About,
}

impl Dialog {
    /// Whether it requires an answer, since data may be lost: Escape and clicks outside do not close it.
    pub(super) fn insists(&self) -> bool {
        matches!(self, Self::Recovered { .. })
    }
}

impl Dialog {
    /// Opens the dialog with a suggestion.
    pub fn path(purpose: Purpose, document: &Document) -> Self {
        let name = document.name();
        let has_ending = Path::new(&name)
            .extension()
            .is_some_and(|ending| opening::ENDINGS.iter().any(|own| ending == *own));
        let stem = if has_ending { opening::stem(Path::new(&name)) } else { name };
        let text = match (purpose, document.path()) {
            (purpose, _) if purpose.reads() => String::new(),
            (Purpose::SaveAs, Some(path)) => path.display().to_string(),
            (_, path) => {
                let file = format!("{stem}.{}", purpose.extensions()[0]);
                let folder = path.and_then(|path| path.parent());
                folder.map_or_else(|| PathBuf::from(&file), |folder| folder.join(&file)).display().to_string()
            }
        };
        Self::Path { purpose, text }
    }
}

/// The files of a folder, folders first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Folder {
    pub path: PathBuf,
    pub home: Option<PathBuf>,
    pub entries: Vec<Entry>,
    /// The reason for not showing the requested folder.
    pub problem: Option<String>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    pub name: String,
    pub is_folder: bool,
}

/// The persistent state of the dialog.
#[derive(Clone, Debug, Default)]
pub struct Asking {
    /// The question was there in the frame before.
    pub(in crate::ui) is_open: bool,
    /// A rejected answer with the reason.
    pub problem: Option<(String, String)>,
    /// The folder exported to last.
    pub exported_to: Option<PathBuf>,
}
