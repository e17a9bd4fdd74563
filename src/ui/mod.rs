//! The window's panels, canvas and tools. They edit an [`Editor`], show a [`Shown`] and return [`Command`]s; files, threads,
//! solving and the field are elsewhere.

pub mod action;
mod arrangement;
mod array;
pub mod arrows;
pub mod beside;
pub mod board;
pub mod bring_up;
pub mod brush;
pub mod canvas;
mod clipboard;
pub mod compare;
mod context;
mod cursor;
mod dialog;
mod dimensions;
pub mod document;
mod edit;
mod element_map;
mod expression;
pub mod gallery;
mod gesture;
mod group;
mod guides;
mod handle;
mod icon;
pub mod keys;
pub mod legend;
mod looking;
mod map;
mod marks;
pub mod measure;
mod menu;
pub mod number;
mod palm;
mod panels;
mod path_marks;
pub mod section;
mod segments;
mod shown;
pub mod space;
mod status;
pub mod theme;
mod ticks;
mod timeline;
pub mod tool;
mod transform;
mod typing;
pub mod view;
mod view_bar;
mod way;

use std::collections::BTreeSet;
use std::path::PathBuf;

use egui::{CentralPanel, Color32, Frame, Ui};
use glam::{DVec2, DVec3};

use crate::picture::figure::Format;
use crate::scene::{Scene, Target};
use crate::studio::animate::Kind;
use board::{BoardCommand, BoardForm};
use brush::Brush;
use document::Document;
use gesture::Gesture;
use guides::Guide;
use looking::Fitted;
use space::SpaceView;
use tool::Tool;
use typing::Typing;
use view::View;

pub use arrangement::Layout;
pub use dialog::Dialog;
pub use dialog::figure::{FigureForm, Preview};
pub use dialog::file::{Asking, ELEMENTS, Entry, Folder, IMPORTED, Purpose};
pub use dialog::film::FilmForm;
pub use dialog::import::Import;
pub use map::{Map, Texture};
pub use panels::{bead, course};
pub use shown::{
    Arrows, Course, Extremes, Levitated, MethodRow, Notice, Pressed, ServingShown, Shown, Sound,
};

/// Whether the window is a page of a browser.
pub const IN_PAGE: bool = cfg!(target_arch = "wasm32");

/// Everything that the user edits, and how it is looked at.
#[derive(Debug)]
pub struct Editor {
    pub document: Document,
    /// Targets by their place in the scene.
    pub selection: BTreeSet<usize>,
    pub view: View,
    fitted: Option<Fitted>,
    /// How space is looked at.
    pub space: SpaceView,
    /// What the map is compared with.
    pub compare: Option<beside::Compare>,
    pub tool: Tool,
    pub panel: Panel,
    pub layout: Layout,
    /// m, between the places to which the pointer snaps.
    pub grid: f64,
    pub snaps: bool,
    pub brush: Brush,
    /// What was copied last: pixels are not part of the text on the clipboard.
    copied: Vec<Target>,
    gesture: Option<Gesture>,
    /// What lines up while something is dragged.
    guides: Vec<Guide>,
    typing: Option<Typing>,
    /// m, on the cut: where keys draw, and where the menu was asked for.
    cursor: Option<DVec2>,
    asked: DVec2,
    pub dialog: Option<Dialog>,
    pub asking: Asking,
    /// The hints of the first start are to be seen.
    pub hints: bool,
    /// s on the window's clock: the last Escape while a board sounds.
    escaped: Option<f64>,
    /// The user was told in this run how loud a board is.
    pub was_warned: bool,
    /// What figures look like, while the program runs.
    pub figure: FigureForm,
    /// How films are written, while the program runs.
    pub film: FilmForm,
    /// What to do once the scene is saved.
    pub after_saving: Option<Command>,
    pub playback: Playback,
    pub oscillation: Oscillation,
    pub course: CourseForm,
    pub bead: BeadForm,
    /// m: where the pointer was last on the map.
    pub pointed: Option<DVec3>,
    /// What of a motion's path was taken hold of last.
    vertex: Option<way::Vertex>,
    /// The drive as a board with so many phases per period plays it.
    pub levels: Option<u32>,
    pub board: BoardForm,
    /// What other programs ask for, which the user may have to agree to first.
    pub asked_by_others: Vec<Command>,
}

/// Which frame of the motion is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// The scene at rest is shown if `None`.
    pub frame: Option<usize>,
    pub playing: bool,
    /// How much slower than it really is.
    pub slowness: f64,
    /// Of a cycle, in [0, 1).
    pub part: f64,
    /// It begins again after the last frame.
    pub loops: bool,
}

impl Default for Playback {
    fn default() -> Self {
        Self { frame: None, playing: false, slowness: 20.0, part: 0.0, loops: true }
    }
}

/// Whether and where the pressure is looked at in the course of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CourseForm {
    pub is_shown: bool,
    pub place: CoursePlace,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CoursePlace {
    /// Of the selected target, or the first.
    #[default]
    Focus,
    Pointer,
    Listener,
}

/// What is shown of the forces on the scene's bead, and where it is put.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BeadForm {
    pub is_shown: bool,
    pub place: BeadPlace,
    pub arrows: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BeadPlace {
    /// The selected one, or else the first trap or focus.
    #[default]
    Target,
    Pointer,
}

/// Which moment of the sound's period an instantaneous pressure is of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    pub playing: bool,
    /// Of a period, in [0, 1).
    pub part: f64,
}

/// What the panel on the right is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Panel {
    Scene,
    Solver,
    Drive,
    Liquid,
    Motion,
    Device,
}

impl Panel {
    pub const ALL: [Self; 6] =
        [Self::Scene, Self::Solver, Self::Drive, Self::Liquid, Self::Motion, Self::Device];

    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "Scene",
            Self::Solver => "Solver",
            Self::Drive => "Drive",
            Self::Liquid => "Liquid",
            Self::Motion => "Motion",
            Self::Device => "Device",
        }
    }
}

/// What the panels ask for and cannot do.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    New,
    Open(PathBuf),
    /// By its place in the list.
    Example(usize),
    /// Makes the picture of an example, by its place in the list.
    Thumbnail(usize),
    Save,
    SaveAs(PathBuf),
    /// Saves over what another program has written there meanwhile.
    Overwrite(PathBuf),
    /// Reads a drawing and asks where it is to stand.
    Import(PathBuf),
    /// Makes a table of elements the array.
    TakeElements(PathBuf),
    Export(Export, PathBuf),
    /// Forgets the files that were open last.
    ForgetRecent,
    /// Takes a WAV file as the modulation's waveform.
    Waveform(PathBuf),
    /// Puts a link that holds the scene on the clipboard.
    CopyLink,
    /// Opens the scene that a link holds.
    OpenLink(String),
    /// Ends the export that is under way, without its file.
    CallOff,
    /// What was typed or chosen where a file was asked for.
    Answer(Purpose, String),
    /// Lists the files of a folder; of the one that was shown last if `None`.
    List(Option<PathBuf>),
    /// Asks the desktop for a file; the answer so far comes back if it gives none.
    Browse(Purpose, String),
    /// Puts the figure on the clipboard.
    CopyFigure,
    CompareMethods,
    Board(BoardCommand),
    /// Whether other programs may edit the scene.
    Serve(bool),
    /// Asks the desktop for what is on its clipboard.
    Paste,
    /// Goes on with what the last run left.
    Recover(Box<Scene>),
    /// Deletes what the last run left.
    Discard,
    Close,
}

impl Command {
    /// Whether the current scene is gone afterwards.
    pub fn replaces_scene(&self) -> bool {
        matches!(self, Self::New | Self::Open(_) | Self::OpenLink(_) | Self::Example(_) | Self::Close)
    }
}

/// What can be written beside the scene itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Export {
    /// The map with axes, as [`Editor::figure`] says.
    Figure(Format),
    /// The map as it is on the screen.
    Map,
    /// Wanted points, drive and map on one page.
    Sheet,
    /// The map's numbers.
    Numbers,
    /// Phase and amplitude per element.
    Drive,
    /// The values along the line that is shown.
    Profile,
    /// Places and directions of the elements.
    Elements,
    /// Every frame of the motion, as [`Editor::film`] says, of what is on the screen.
    Motion(Kind),
}

impl Editor {
    pub fn new(document: Document) -> Self {
        Self {
            view: View::of(&document.scene),
            fitted: None,
            space: SpaceView::default(),
            compare: None,
            document,
            selection: BTreeSet::new(),
            tool: Tool::Select,
            panel: Panel::Scene,
            layout: Layout {
                panel: 352.0,
                section: 210.0,
                is_folded: false,
                is_drawn_out: false,
                presents: false,
            },
            grid: 0.005,
            snaps: false,
            brush: Brush::default(),
            copied: Vec::new(),
            gesture: None,
            guides: Vec::new(),
            typing: None,
            cursor: None,
            asked: DVec2::ZERO,
            dialog: None,
            asking: Asking::default(),
            hints: false,
            escaped: None,
            was_warned: false,
            figure: FigureForm::default(),
            film: FilmForm::default(),
            after_saving: None,
            playback: Playback::default(),
            oscillation: Oscillation { playing: true, part: 0.0 },
            course: CourseForm::default(),
            bead: BeadForm::default(),
            pointed: None,
            vertex: None,
            levels: None,
            board: BoardForm::default(),
            asked_by_others: Vec::new(),
        }
    }

    /// Another scene. Tool, colours and panel stay as they are.
    pub fn replace(&mut self, document: Document) {
        let View { cut, heights, free, window, line, full, .. } = View::of(&document.scene);
        self.view = View { cut, heights, free, window, line, full, ..self.view.clone() };
        self.fitted = None;
        self.space.camera = None;
        self.document = document;
        self.forget_places();
        self.playback = Playback::default();
    }

    /// The scene as others have made it of this one.
    pub fn take(&mut self, scene: Scene) {
        let kind = |target: &Target| std::mem::discriminant(&target.shape);
        if !self.scene().targets.iter().map(kind).eq(scene.targets.iter().map(kind)) {
            self.forget_places();
        }
        self.document.scene = scene;
    }

    pub fn undo(&mut self) {
        self.forget_places();
        self.document.undo();
    }

    pub fn redo(&mut self) {
        self.forget_places();
        self.document.redo();
    }

    /// Targets may stand elsewhere in the list now.
    fn forget_places(&mut self) {
        self.selection.clear();
        self.vertex = None;
        self.typing = None;
        self.gesture = None;
        self.space.let_go();
    }

    pub fn scene(&self) -> &Scene {
        &self.document.scene
    }

    /// What the panels and the canvas show; a moment that runs by itself is none of it.
    pub fn seen(&self) -> (Scene, View, Playback, bool) {
        (self.document.scene.clone(), self.view.clone(), self.playback, self.oscillation.playing)
    }

    /// Passes a command on, or asks first where it would lose what is not saved.
    pub fn ask(&mut self, command: Command, commands: &mut Vec<Command>) {
        if command.replaces_scene() && self.document.is_unsaved() {
            self.dialog = Some(Dialog::Unsaved(command));
        } else {
            commands.push(command);
        }
    }

    /// Whether a text is being typed on the canvas: keys are letters then.
    pub fn is_typing(&self) -> bool {
        self.typing.is_some()
    }

    /// Whether an edit is under way that is to be one step of the history.
    pub fn is_in_gesture(&self) -> bool {
        self.gesture.is_some() || self.typing.is_some() || self.space.is_held()
    }
}

/// Draws everything around the canvas and hands the rest of the window to `canvas`.
pub fn show(
    editor: &mut Editor,
    shown: &mut Shown,
    ui: &mut Ui,
    canvas: impl FnOnce(&mut Editor, &mut Shown, &mut Ui),
) -> Vec<Command> {
    let mut commands = Vec::new();
    editor.view.follow_theme(ui.visuals().dark_mode);
    let quantity = editor.view.quantity;
    keys::press(editor, shown, ui.ctx(), &mut commands);
    // The window is cleared to the panels' colour: filling every pixel once more would take a software driver half a frame.
    let clear = Frame::side_top_panel(ui.style()).fill(Color32::TRANSPARENT);
    if editor.layout.presents {
        menu::presented_stop(shown, ui.ctx(), &mut commands);
    } else {
        arrangement::around(editor, shown, clear, ui, &mut commands);
    }
    let centre = CentralPanel::default().frame(Frame::NONE).show(ui, |ui| canvas(editor, shown, ui));
    gallery::show(centre.response.rect, editor, shown, ui, &mut commands);
    dialog::show(editor, shown, ui.ctx(), &mut commands);
    if editor.view.quantity != quantity {
        // A range in pascals does not fit metres.
        editor.view.forget_range();
    }
    commands.append(&mut editor.asked_by_others);
    dialog::warn_of_loudness(editor, &mut commands);
    commands
}
