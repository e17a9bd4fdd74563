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
use strum::{EnumString, IntoStaticStr, VariantArray};

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

/// The edited document and the state of its display.
#[derive(Debug)]
pub struct Editor {
    pub document: Document,
    /// Selected targets by index.
    pub selection: BTreeSet<usize>,
    pub view: View,
    fitted: Option<Fitted>,
    /// How space is looked at.
    pub space: SpaceView,
    /// The comparison map.
    pub compare: Option<beside::Compare>,
    pub tool: Tool,
    pub panel: Panel,
    pub layout: Layout,
    /// Spacing of the snap grid, m.
    pub grid: f64,
    pub snaps: bool,
    pub brush: Brush,
    /// The last copied targets: pixels are not part of the clipboard's text.
    copied: Vec<Target>,
    gesture: Option<Gesture>,
    /// The current guides during a drag.
    guides: Vec<Guide>,
    typing: Option<Typing>,
    /// Keyboard cursor, or position of the context menu, m in the plane.
    cursor: Option<DVec2>,
    asked: DVec2,
    pub dialog: Option<Dialog>,
    pub asking: Asking,
    /// Whether the hints of the first start are shown.
    pub hints: bool,
    /// Time (s) of the last Escape while a board sounds.
    escaped: Option<f64>,
    /// Whether the loudness warning was answered in this run.
    pub was_warned: bool,
    /// Figure options of this run.
    pub figure: FigureForm,
    /// Film options of this run.
    pub film: FilmForm,
    /// Command to run after saving.
    pub after_saving: Option<Command>,
    pub playback: Playback,
    pub oscillation: Oscillation,
    pub course: CourseForm,
    pub bead: BeadForm,
    /// Last position of the pointer on the map, m.
    pub pointed: Option<DVec3>,
    /// The last grabbed vertex of a motion's path.
    vertex: Option<way::Vertex>,
    /// Number of phase levels of the displayed drive.
    pub levels: Option<u32>,
    pub board: BoardForm,
    /// Commands of other programs, possibly awaiting the user's consent.
    pub asked_by_others: Vec<Command>,
}

/// The displayed frame of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// `None` shows the scene at rest.
    pub frame: Option<usize>,
    pub playing: bool,
    /// Slowdown of the playback.
    pub slowness: f64,
    /// Of a cycle, in [0, 1).
    pub part: f64,
    /// Whether playback repeats.
    pub loops: bool,
}

impl Default for Playback {
    fn default() -> Self {
        Self { frame: None, playing: false, slowness: 20.0, part: 0.0, loops: true }
    }
}

/// Display and position of the pressure over time.
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

/// Displayed forces on the scene's bead, and its position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BeadForm {
    pub is_shown: bool,
    pub place: BeadPlace,
    pub arrows: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BeadPlace {
    /// The selected target, or else the first trap or focus.
    #[default]
    Target,
    Pointer,
}

/// The phase of an instantaneous pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    pub playing: bool,
    /// Of a period, in [0, 1).
    pub part: f64,
}

/// The page of the right panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(const_into_str)]
pub enum Panel {
    Scene,
    Solver,
    Drive,
    Liquid,
    Motion,
    Device,
}

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
    /// The map with axes, with the options of [`Editor::figure`].
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
    /// Every frame of the displayed motion, with the options of [`Editor::film`].
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

    /// Replaces the document. Tool, colours and panel are kept.
    pub fn replace(&mut self, document: Document) {
        let View { cut, heights, free, window, line, full, .. } = View::of(&document.scene);
        self.view = View { cut, heights, free, window, line, full, ..self.view.clone() };
        self.fitted = None;
        self.space.camera = None;
        self.document = document;
        self.forget_places();
        self.playback = Playback::default();
    }

    /// Takes a scene changed by other programs.
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

    /// Clears references to target indices.
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

    /// The displayed state, without a running moment of the wave.
    pub fn seen(&self) -> (Scene, View, Playback, bool) {
        (self.document.scene.clone(), self.view.clone(), self.playback, self.oscillation.playing)
    }

    /// Passes on a command, after a confirmation if unsaved changes would be lost.
    pub fn ask(&mut self, command: Command, commands: &mut Vec<Command>) {
        if command.replaces_scene() && self.document.is_unsaved() {
            self.dialog = Some(Dialog::Unsaved(command));
        } else {
            commands.push(command);
        }
    }

    /// Whether a text is being typed on the canvas, so that keys are letters.
    pub fn is_typing(&self) -> bool {
        self.typing.is_some()
    }

    /// Whether an edit is in progress, to become one undo step.
    pub fn is_in_gesture(&self) -> bool {
        self.gesture.is_some() || self.typing.is_some() || self.space.is_held()
    }
}

/// Draws everything around the canvas and passes the remaining space to `canvas`.
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
    // The window is cleared to the panels' colour: filling every pixel again would cost a software driver half a
    // frame.
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
        // A range in pascals is meaningless in metres.
        editor.view.forget_range();
    }
    commands.append(&mut editor.asked_by_others);
    dialog::warn_of_loudness(editor, &mut commands);
    commands
}
