//! The edited document and the state of its display.

use std::collections::BTreeSet;
use std::path::Path;

use glam::{DVec2, DVec3};

use crate::scene::{Scene, Target, motion};
use crate::ui::IN_PAGE;
use crate::ui::beside;
use crate::ui::board::BoardForm;
use crate::ui::command::{Command, Purpose};
use crate::ui::dialog::options::{FigureForm, FilmForm};
use crate::ui::dialog::state::{Asking, Dialog};
use crate::ui::document::Document;
use crate::ui::fitted::Fitted;
use crate::ui::gesture::{Gesture, Pen, Typing, Vertex};
use crate::ui::guides::Guide;
use crate::ui::layout::{Layout, Panel};
use crate::ui::parts::Parts;
use crate::ui::playback::{Moment, Oscillation, Playback};
use crate::ui::space::view::SpaceView;
use crate::ui::tool::{Brush, Tool};
use crate::ui::view::View;

/// The edited document and the state of its display.
#[derive(Debug)]
pub struct Editor {
    pub document: Document,
    /// Selected targets by index.
    pub selection: BTreeSet<usize>,
    /// The body chosen last, by its index: see [`Editor::chosen_body`].
    pub(super) body: Option<usize>,
    pub view: View,
    pub(super) fitted: Option<Fitted>,
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
    pub(super) copied: Vec<Target>,
    pub(super) gesture: Option<Gesture>,
    /// The current guides during a drag.
    pub(super) guides: Vec<Guide>,
    pub(super) typing: Option<Typing>,
    pub(super) pen: Option<Pen>,
    /// Keyboard cursor, or position of the context menu, m in the plane.
    pub(super) cursor: Option<DVec2>,
    pub(super) asked: DVec2,
    pub dialog: Option<Dialog>,
    pub asking: Asking,
    /// Whether the hints of the first start are shown.
    pub hints: bool,
    /// Whether the gallery over the empty scene was closed.
    pub has_closed_gallery: bool,
    /// Time (s) of the last Escape while a board sounds.
    pub(super) escaped: Option<f64>,
    /// Whether the space bar is down and nothing was dragged with it: its release plays or pauses.
    pub(super) is_space_down: bool,
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
    pub parts: Box<Parts>,
    /// Last position of the pointer on the map, m.
    pub pointed: Option<DVec3>,
    /// The last grabbed vertex of a motion's path.
    pub(super) vertex: Option<Vertex>,
    /// Number of phase levels of the displayed drive.
    pub levels: Option<u32>,
    pub board: BoardForm,
    /// Commands of other programs, possibly awaiting the user's consent.
    pub asked_by_others: Vec<Command>,
}

impl Editor {
    pub fn new(document: Document) -> Self {
        Self {
            view: View::of(&document.scene),
            playback: Playback::opening(&document.scene),
            fitted: None,
            space: SpaceView::default(),
            compare: None,
            document,
            selection: BTreeSet::new(),
            body: None,
            tool: Tool::Select,
            panel: Panel::Scene,
            layout: Layout {
                panel: 352.0,
                section: 210.0,
                is_folded: false,
                is_drawn_out: false,
                presents: false,
                has_timeline: false,
            },
            grid: 0.005,
            snaps: false,
            brush: Brush::default(),
            copied: Vec::new(),
            gesture: None,
            guides: Vec::new(),
            typing: None,
            pen: None,
            cursor: None,
            asked: DVec2::ZERO,
            dialog: None,
            asking: Asking::default(),
            hints: false,
            has_closed_gallery: false,
            escaped: None,
            is_space_down: false,
            was_warned: false,
            figure: FigureForm::default(),
            film: FilmForm::default(),
            after_saving: None,
            oscillation: Oscillation { playing: true, part: 0.0 },
            parts: Box::default(),
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
        self.has_closed_gallery = false;
        self.document = document;
        self.forget_places();
        self.parts.forget_scene();
        self.playback = Playback::opening(self.scene());
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
        self.step(Document::undo);
    }

    pub fn redo(&mut self) {
        self.step(Document::redo);
    }

    /// A step in the history; targets that are still there stay selected.
    fn step(&mut self, go: fn(&mut Document)) {
        let (mut selection, body) = (std::mem::take(&mut self.selection), self.body);
        self.forget_places();
        go(&mut self.document);
        self.body = body;
        selection.retain(|&index| index < self.scene().targets.len());
        self.selection = selection;
    }

    /// Opens the file dialog with a suggestion; exports go to the folder of the last one.
    pub fn ask_for_file(&mut self, purpose: Purpose) {
        let mut dialog = Dialog::path(purpose, &self.document);
        if let (false, Purpose::Export(_), Dialog::Path { text, .. }) = (IN_PAGE, purpose, &mut dialog)
            && let Some(folder) = &self.asking.exported_to
            && let Some(name) = Path::new(text.as_str()).file_name()
        {
            *text = folder.join(name).display().to_string();
        }
        self.dialog = Some(dialog);
    }

    /// Clears references to target indices.
    fn forget_places(&mut self) {
        self.selection.clear();
        self.body = None;
        self.vertex = None;
        self.typing = None;
        self.pen = None;
        self.gesture = None;
        self.space.let_go();
    }

    /// Puts a target being drawn into the scene, replacing its previous state.
    pub(super) fn put(&mut self, index: &mut Option<usize>, target: Target) {
        let targets = &mut self.document.scene.targets;
        match index.and_then(|index| targets.get_mut(index)) {
            Some(place) => *place = target,
            None => {
                targets.push(target);
                *index = Some(targets.len() - 1);
            }
        }
        self.selection = index.iter().copied().collect();
    }

    /// The chosen body; selected targets come first.
    pub fn chosen_body(&self) -> Option<usize> {
        self.body.filter(|&index| self.selection.is_empty() && index < self.scene().bodies.len())
    }

    /// Chooses a body, and nothing else.
    pub fn choose_body(&mut self, index: usize) {
        self.selection.clear();
        self.body = Some(index);
    }

    /// Whether targets or a body are chosen.
    pub(super) fn has_choice(&self) -> bool {
        !self.selection.is_empty() || self.chosen_body().is_some()
    }

    /// Moves what is chosen (m).
    pub(super) fn translate_chosen(&mut self, by: DVec3) {
        for &index in &self.selection {
            if let Some(target) = self.document.scene.targets.get_mut(index) {
                target.shape.translate(by);
            }
        }
        if let Some(index) = self.chosen_body() {
            self.document.scene.bodies[index].at += by;
        }
    }

    /// Shows the page with the numbers of a target just drawn, unless the page of its motion is open.
    pub(super) fn show_target(&mut self) {
        let moves = self.panel == Panel::Motion && motion::moves(self.scene());
        if !self.selection.is_empty() && !moves {
            self.panel = Panel::Scene;
        }
    }

    /// Whether two maps are seen.
    pub fn is_comparing(&self) -> bool {
        self.compare.as_ref().is_some_and(|compare| compare.is_split)
    }

    pub fn scene(&self) -> &Scene {
        &self.document.scene
    }

    /// The displayed state, without running moments of a motion and of the wave.
    pub fn seen(&self) -> (Scene, View, Playback, bool) {
        let runs = self.playback.playing;
        let moment = match self.playback.moment {
            Moment::Frame(_) if runs => Moment::Frame(0),
            Moment::Wave(_) if runs => Moment::Wave(0),
            own @ (Moment::Rest | Moment::Mean | Moment::Frame(_) | Moment::Wave(_)) => own,
        };
        let part = if runs { 0.0 } else { self.playback.part };
        let playback = Playback { moment, part, ..self.playback };
        (self.document.scene.clone(), self.view.clone(), playback, self.oscillation.playing)
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
        self.gesture.is_some() || self.typing.is_some() || self.pen.is_some() || self.space.is_held()
    }
}
