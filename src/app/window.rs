//! The window on the screen: the editor, what is shown, and the work behind it, frame by frame.

use std::cell::RefCell;
use std::num::NonZeroUsize;
use std::path::Path;
use std::rc::Rc;

use eframe::egui;

#[cfg(target_arch = "wasm32")]
use crate::app::browser;
use crate::app::errand::{Errand, Film, Outcome};
use crate::app::examples::{EXAMPLES, example, linked};
use crate::app::figure::{Previews, Recipe};
use crate::app::link::Board;
use crate::app::measured_figures::MeasuredFigures;
use crate::app::recovery::Recovery;
use crate::app::screen::Screen;
use crate::app::serving::Serving;
use crate::app::settings::{self, Memory, Settings};
use crate::app::thumbnails::Thumbnails;
use crate::app::workshop::{Seen, Workshop};
use crate::field::{Evaluator, Gpu, Work};
use crate::picture::Picture;
use crate::scene::Scene;
use crate::studio::link as link_text;
use crate::ui::document::Document;
use crate::ui::{
    self, Command, Dialog, Editor, Notice, Purpose, Shown, canvas, compare, legend, level, theme,
};

pub(super) const TITLE: &str = "Sonoglyph";
/// Limit of layout passes per frame: after the third, egui's requests of the first two are settled.
const PASSES: usize = 3;
/// State passed to the next window, which another renderer draws.
pub(super) type Legacy = Rc<RefCell<Option<(Editor, Notice)>>>;

/// The program's state.
#[derive(Debug)]
pub struct Window {
    pub(super) editor: Editor,
    pub(super) shown: Shown,
    pub(super) workshop: Workshop,
    pub(super) board: Board,
    pub(super) serving: Serving,
    /// The window may close without another question.
    pub(super) may_close: bool,
    /// An action awaits a reaction of the windowing system or of the next frame.
    pub(super) owes_frame: bool,
    pub(super) title: String,
    pub(super) recovery: Option<Recovery>,
    /// Whether the recovery offer is still open.
    pub(super) offers_recovery: bool,
    /// The answer to a file dialog being processed.
    pub(super) answered: Option<(Purpose, String)>,
    pub(super) memory: Option<Memory>,
    pub(super) errands: Vec<Errand<Outcome>>,
    pub(super) thumbnails: Thumbnails,
    pub(super) filming: Option<Film>,
    pub(super) previews: Previews<Recipe>,
    pub(super) measured: MeasuredFigures,
    /// Destination of the editor if the drawing device is lost.
    pub(super) legacy: Option<Legacy>,
}

impl Window {
    /// In a window without its own device: pictures go through egui.
    pub fn new(ctx: &egui::Context, document: Document, evaluator: Evaluator) -> Self {
        Self::with(ctx, Editor::new(document), evaluator, None)
    }

    /// In eframe's window, on its drawing device if that is wgpu.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn of(context: &eframe::CreationContext<'_>, editor: Editor) -> Self {
        let screen = Screen::of(context);
        let evaluator = screen.as_ref().map_or(Evaluator::Cpu, Screen::evaluator);
        Self::with(&context.egui_ctx, editor, evaluator, screen)
    }

    pub(super) fn with(
        ctx: &egui::Context,
        editor: Editor,
        evaluator: Evaluator,
        screen: Option<Screen>,
    ) -> Self {
        theme::install(ctx);
        ctx.options_mut(|options| options.max_passes = NonZeroUsize::MIN.saturating_add(PASSES - 1));
        let workshop = Workshop::new(evaluator, screen);
        let shown = Shown {
            examples: EXAMPLES.iter().map(|example| example.card).collect(),
            evaluator: workshop.mapping.evaluator(),
            board: Board::shown(),
            ..Shown::default()
        };
        Self {
            editor,
            shown,
            workshop,
            board: Board::default(),
            serving: Serving::default(),
            may_close: false,
            owes_frame: false,
            title: String::new(),
            recovery: None,
            offers_recovery: false,
            answered: None,
            memory: None,
            errands: Vec::new(),
            thumbnails: Thumbnails::default(),
            filming: None,
            previews: Previews::default(),
            measured: MeasuredFigures::default(),
            legacy: None,
        }
    }

    /// If the device that draws the window is lost, its editor goes there, and the window closes.
    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn leave_to(&mut self, legacy: Legacy) {
        self.legacy = Some(legacy);
    }

    /// Restores and keeps the settings; `word` is a message about them.
    pub(super) fn remember(
        &mut self,
        memory: Option<Memory>,
        settings: &Settings,
        word: Option<String>,
        ctx: &egui::Context,
    ) {
        settings.apply(&mut self.editor, ctx);
        self.shown.recent.clone_from(&settings.recent);
        if let Some(path) = self.editor.document.path() {
            settings::remember(&mut self.shown.recent, path);
        }
        self.shown.notice = word.map(|text| Notice { text, is_error: true });
        if let Some(memory) = &memory {
            self.editor.board.tests = memory.board_tests().to_vec();
        }
        self.memory = memory;
    }

    /// The same with settings in this folder.
    pub fn remember_in(&mut self, folder: &Path, ctx: &egui::Context) {
        let (memory, settings, word) = Memory::at(folder);
        self.remember(Some(memory), &settings, word, ctx);
    }

    /// Keeps unsaved changes from now on, and offers those of the last run, if any.
    pub fn recover(&mut self, recovery: Option<Recovery>) {
        self.recovery = recovery;
        self.editor.dialog = self.recovery_offer();
        self.offers_recovery = self.editor.dialog.is_some();
    }

    fn recovery_offer(&self) -> Option<Dialog> {
        let left = self.recovery.as_ref()?.left()?;
        Some(Dialog::Recovered { name: left.name(), targets: left.scene.targets.len() })
    }

    pub fn editor(&self) -> &Editor {
        &self.editor
    }

    pub fn editor_mut(&mut self) -> &mut Editor {
        &mut self.editor
    }

    pub fn shown(&self) -> &Shown {
        &self.shown
    }

    /// The values of the map on the screen, height and width first, row 0 at the smallest y.
    pub fn numbers(&mut self) -> Option<(Vec<u64>, Vec<f32>)> {
        self.workshop.mapping.numbers()
    }

    /// The displayed map without overlays.
    pub fn picture(&mut self) -> Option<Picture> {
        self.workshop.mapping.picture()
    }

    /// The GPU that computes the field, if one does.
    pub fn gpu(&self) -> Option<&Gpu> {
        self.workshop.mapping.gpu()
    }

    /// Run counts of the field's stages.
    pub fn work(&self) -> Work {
        self.workshop.mapping.work()
    }

    /// Whether background work is running.
    pub fn is_busy(&self) -> bool {
        self.workshop.is_busy()
            || self.editor.parts.is_running()
            || self.previews.is_busy()
            || self.measured.is_busy()
            || !self.errands.is_empty()
    }

    pub(super) fn execute(&mut self, command: Command, ctx: &egui::Context) {
        if let Command::Thumbnail(index) = command {
            // The gallery repeats the request until the picture is available, so no wake-up is needed.
            return self.thumbnails.want(index, &self.shown, ctx);
        }
        self.shown.notice = None;
        match command {
            Command::ForgetRecent => self.shown.recent.clear(),
            Command::New => self.editor.replace(Document::new(Scene::default(), "untitled")),
            Command::Example(index) => match example(index) {
                Ok(document) => self.editor.replace(document),
                Err(error) => self.refuse("The example cannot be opened", &error),
            },
            Command::Open(path) => self.open(&path),
            Command::Thumbnail(_) => {}
            Command::Save => match self.editor.document.path().map(Path::to_owned) {
                Some(path) => self.save(&path, ctx),
                None => self.editor.dialog = Some(Dialog::path(Purpose::SaveAs, &self.editor.document)),
            },
            Command::SaveAs(path) => self.save(&path, ctx),
            Command::Overwrite(path) => self.overwrite(&path, ctx),
            Command::Import(path) => self.import(path, ctx),
            Command::TakeElements(path) => self.read_elements(&path, ctx),
            Command::TakeWiring(path) => self.read_wiring(&path, ctx),
            Command::OpenDrive(path) => self.read_drive(path, ctx),
            Command::Waveform(target, path) => self.read_waveform(target, path, ctx),
            Command::Thresholds(path) => self.read_thresholds(path, ctx),
            Command::Directivity(path) => self.read_directivity(path, ctx),
            Command::Body(body, path) => self.read_surface(body, path, ctx),
            Command::Path(target, path) => self.read_routes(target, path, ctx),
            Command::OpenScan(path) => self.open_scan(path),
            Command::OpenScanDrive(path) => self.editor.parts.measuring.take_drive(Some(path)),
            Command::Export(export, path) => self.export(export, &path, ctx),
            Command::CopyFigure => self.copy_figure(ctx),
            Command::CallOff => self.filming.iter().for_each(|film| film.progress.call_off()),
            Command::Answer(purpose, text) => self.answer(purpose, &text, ctx),
            Command::List(folder) => self.list(folder, ctx),
            Command::Browse(purpose, text) => self.browse(purpose, text, ctx),
            Command::CopyLink => match link_text::write(self.editor.scene()) {
                Ok(link) => {
                    #[cfg(target_arch = "wasm32")]
                    let link = browser::address()
                        .map_or_else(|| link.clone(), |page| link_text::of_page(&link, &page));
                    self.tell(&format!("Link copied ({} characters)", link.len()), false);
                    ctx.copy_text(link);
                }
                Err(error) => self.refuse("The scene does not fit in a link", &error.into()),
            },
            Command::OpenLink(link) => match linked(&link) {
                Ok(document) => {
                    self.editor.replace(document);
                    self.tell("Opened the scene of a link", false);
                }
                Err(error) => self.refuse("The link cannot be opened", &error),
            },
            Command::Board(command) => {
                let Self { board, editor, shown, .. } = self;
                board.execute(&command, editor, shown, ctx);
            }
            Command::Serve(on) => {
                let Self { serving, editor, shown, board, .. } = self;
                serving.switch(on, editor, shown, board.silencer(), ctx);
            }
            Command::CompareMethods => self.workshop.compare_methods(self.editor.scene()),
            Command::Recover => {
                if let Some(document) = self.recovery.as_ref().and_then(Recovery::left) {
                    self.editor.replace(document);
                }
                self.offers_recovery = false;
            }
            Command::Discard => {
                self.offers_recovery = false;
                self.recovery.iter_mut().for_each(Recovery::forget);
            }
            // The content arrives as an event in the next frame.
            Command::Paste => ctx.send_viewport_cmd(egui::ViewportCommand::RequestPaste),
            Command::Close => {
                self.forget_unsaved();
                self.close(ctx);
            }
        }
        self.owes_frame = true;
    }

    /// Closes the window at the next frame, without another question.
    pub(super) fn close(&mut self, ctx: &egui::Context) {
        self.may_close = true;
        self.owes_frame = true;
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }

    /// Discards this run's recovery data; that of the last run stays until answered.
    pub(super) fn forget_unsaved(&mut self) {
        if !self.offers_recovery {
            self.recovery.iter_mut().for_each(Recovery::forget);
        }
    }

    pub(super) fn tell(&mut self, text: &str, is_error: bool) {
        self.shown.notice = Some(Notice { text: text.to_owned(), is_error });
    }

    /// Reports a failure: in the file dialog if just answered, otherwise separately.
    pub(super) fn refuse(&mut self, title: &str, error: &anyhow::Error) {
        if let Some((purpose, text)) = self.answered.take() {
            self.editor.asking.problem = Some((text.clone(), format!("{error:#}")));
            self.editor.dialog = Some(Dialog::Path { purpose, text });
            return;
        }
        self.editor.dialog = Some(Dialog::Message { title: title.to_owned(), text: format!("{error:#}") });
    }

    /// Files dropped on the window, and its close button.
    pub(super) fn hear_outside(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        if let Some(file) = ctx.input(|input| input.raw.dropped_files.first().cloned()) {
            self.receive(&file, ctx, commands);
        }
        #[cfg(target_arch = "wasm32")]
        if let Some(link) = browser::new_link() {
            self.editor.ask(Command::OpenLink(link), commands);
        }
        let closes = ctx.input(|input| input.viewport().close_requested());
        if closes && !self.may_close && self.editor.document.is_unsaved() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.editor.dialog = Some(Dialog::Unsaved(Command::Close));
        } else if closes {
            self.forget_unsaved();
        }
    }

    /// Writes unsaved changes to the recovery file, unless the recovery offer is open.
    pub(super) fn keep(&mut self, ctx: &egui::Context) {
        if self.offers_recovery && self.editor.dialog.is_none() {
            self.editor.dialog = self.recovery_offer();
        }
        let Some(recovery) = &mut self.recovery else { return };
        if self.offers_recovery || self.may_close {
            return;
        }
        let document = &self.editor.document;
        let unsaved = document.is_unsaved().then_some(document);
        let before = recovery.trouble().map(str::to_owned);
        if let Some(seconds) = recovery.keep(unsaved, ctx.input(|input| input.time)) {
            ctx.request_repaint_after_secs(seconds as f32);
        }
        if let Some(trouble) = recovery.trouble().filter(|trouble| Some(*trouble) != before.as_deref()) {
            let text = format!("Unsaved changes would be lost in a crash: {trouble}");
            self.shown.notice = Some(Notice { text, is_error: true });
        }
    }

    /// Writes the window's state to the settings.
    pub(super) fn keep_settings(&mut self, ctx: &egui::Context) {
        let Some(memory) = &mut self.memory else { return };
        memory.keep_board_tests(&self.editor.board);
        let settings = Settings::of(&self.editor, &self.shown.recent, ctx);
        if let Some(seconds) = memory.keep(settings, ctx.input(|input| input.time)) {
            ctx.request_repaint_after_secs(seconds as f32);
        }
    }

    /// After a device loss, another window continues.
    pub(super) fn escape_lost_screen(&mut self, ctx: &egui::Context) {
        if !self.workshop.mapping.has_lost_screen() {
            return;
        }
        let Some(legacy) = self.legacy.take() else { return };
        let text =
            "The GPU was lost; OpenGL draws the window and the CPU computes the field from now on".to_owned();
        let blank = Editor::new(Document::new(Scene::default(), "untitled"));
        let editor = std::mem::replace(&mut self.editor, blank);
        *legacy.borrow_mut() = Some((editor, Notice { text, is_error: true }));
        self.close(ctx);
    }

    pub(super) fn name_window(&mut self, ctx: &egui::Context) {
        let document = &self.editor.document;
        let mark = if document.is_unsaved() { "• " } else { "" };
        let title = format!("{mark}{} – {TITLE}", document.name());
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.frame(ui);
    }

    /// For queries of the page's state.
    #[cfg(target_arch = "wasm32")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }

    /// The background of all panels.
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }
}

/// Whether the last pass was not its layout's final one: a new grid is sized in one pass and drawn in the next.
fn is_unfinished(ctx: &egui::Context) -> bool {
    ctx.output(egui::PlatformOutput::requested_discard)
}

impl Window {
    /// One frame: input is processed, changed values are recomputed, and everything is drawn.
    pub fn frame(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        let (before, theme) = (self.editor.seen(), ctx.theme());
        self.board.attend(&mut self.shown);
        self.serving.exchange(&mut self.editor, &self.shown, &ctx);
        let Self { editor, shown, workshop, board, .. } = self;
        let mut commands = ui::show(editor, shown, ui, |editor, shown, ui| {
            if editor.space.is_on {
                let stage = ui::space::interact(editor, shown, ui);
                workshop.update(editor, shown, &Seen::Space(&stage), ui.ctx());
                board.update(editor, shown, ui.ctx());
                ui::space::paint(editor, shown, ui, &stage);
                return;
            }
            let (mut own, mut other) = compare::halves(editor, ui);
            let canvas = canvas::interact(editor, &mut own);
            let second = other.as_mut().and_then(|ui| compare::interact(editor, &canvas, ui));
            let beside = second.as_ref().map(|second| &second.lens);
            workshop.update(editor, shown, &Seen::Map { lens: &canvas.lens, beside }, ui.ctx());
            board.update(editor, shown, ui.ctx());
            canvas::paint(editor, shown, &own, &canvas);
            match (&mut other, &second) {
                (Some(ui), Some(second)) => compare::paint(editor, shown, ui, &canvas, second),
                _ => legend::controls(editor, shown, &mut own, &canvas.lens),
            }
            level::offer(editor, &own, canvas.lens.rect);
        });
        self.escape_lost_screen(&ctx);
        self.hear_outside(&ctx, &mut commands);
        self.collect(&mut commands, &ctx);
        self.thumbnails.collect(&mut self.shown, &ctx);
        commands.into_iter().for_each(|command| self.execute(command, &ctx));
        let is_held = ctx.input(|input| input.pointer.any_down());
        self.serving.tell(&self.editor, &mut self.shown);
        let is_in_burst = self.serving.is_in_burst(&ctx);
        if !is_held && !is_in_burst && !self.editor.is_in_gesture() && !ctx.text_edit_focused() {
            self.editor.document.settle();
        }
        self.preview_figure(&ctx);
        self.preview_measured(&ctx);
        self.name_window(&ctx);
        self.keep(&ctx);
        self.keep_settings(&ctx);
        // The ground of the panels is cleared before the first pass of a frame.
        self.owes_frame |= ctx.theme() != theme;
        self.settle(&ctx, before != self.editor.seen());
        #[cfg(target_arch = "wasm32")]
        browser::count_frame();
    }

    /// Repeats the layout before painting if an event or a change requires it: panels precede the map whose figures
    /// they show. egui alone would paint two more frames after every event, and painting dominates the cost of a
    /// frame on software drivers.
    pub(super) fn settle(&mut self, ctx: &egui::Context, has_changed: bool) {
        let passes = ctx.current_pass_index() + 1;
        // Later passes have no events of their own.
        let is_unsettled = passes > 1 || has_changed || ctx.input(|input| !input.events.is_empty());
        if is_unsettled && passes < PASSES {
            ctx.request_discard("settling");
        } else if std::mem::take(&mut self.owes_frame) || has_changed || is_unfinished(ctx) {
            // eframe forgets requests of earlier passes.
            ctx.request_repaint();
        }
    }
}
