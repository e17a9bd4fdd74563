//! Opening, saving and exporting.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, anyhow};
use eframe::egui;

#[cfg(target_arch = "wasm32")]
use crate::app::browser;
use crate::app::errand::{Errand, Film, Outcome, Progress, State};
use crate::app::figure::image;
use crate::app::window::Window;
use crate::app::{folders, settings};
use crate::drive::Drive;
use crate::field::{Colouring, Evaluator, Request, Stages};
use crate::import::{self, Drawing};
use crate::picture::{Picture, export, numbers};
use crate::scene::motion::Routes;
use crate::scene::{
    Array, Body, BodyKind, Curve, Directivity, ElementModel, Elements, Envelope, Motion, MotionPath, Surface,
};
use crate::scene::{Scene, Tempo, Wave, Wires, check};
use crate::solver::frames;
use crate::source;
use crate::studio::animate::{self, Look};
use crate::studio::opening::stem;
use crate::studio::paintings::Placed;
use crate::studio::{
    directivity, elements, figure, link, liquid, opening, output, routes, surfaces, thresholds, waveform,
};
use crate::ui::bodies;
use crate::ui::document::Document;
use crate::ui::section::Profile;
use crate::ui::view::Lens;
use crate::ui::way;
use crate::ui::{self, Command, Dialog, Export, Purpose};

/// Opens the file dialog of the desktop or browser.
#[cfg(not(target_arch = "wasm32"))]
fn ask_for_file(
    purpose: Purpose,
    document: &Document,
) -> impl Future<Output = Option<PathBuf>> + Send + use<> {
    let extensions = purpose.extensions();
    let mut dialog =
        rfd::AsyncFileDialog::new().set_title(purpose.title()).add_filter(extensions.join(", "), extensions);
    if let Some(folder) = document.path().and_then(Path::parent).filter(|folder| folder.is_dir()) {
        dialog = dialog.set_directory(folder);
    }
    // Some desktops require dialogs on the window's own thread.
    let (pick, save) =
        if purpose.reads() { (Some(dialog.pick_file()), None) } else { (None, Some(dialog.save_file())) };
    async move {
        let file = match (pick, save) {
            (Some(pick), _) => pick.await,
            (_, Some(save)) => save.await,
            _ => None,
        };
        file.map(|file| file.path().to_owned())
    }
}

/// Opens the browser's file dialog. Outputs only have a name.
#[cfg(target_arch = "wasm32")]
fn ask_for_file(purpose: Purpose, _: &Document) -> impl Future<Output = Option<PathBuf>> + use<> {
    async move { if purpose.reads() { browser::pick(purpose.extensions()).await } else { None } }
}

/// Whether no file is overwritten: browsers choose unused names for downloads.
fn becomes_download(purpose: Purpose) -> bool {
    ui::IN_PAGE && matches!(purpose, Purpose::Export(_))
}

/// Two pictures beside each other.
fn joined(left: &Picture, right: &Picture) -> Picture {
    /// Pixels.
    const GAP: usize = 12;
    let (width, height) = (left.width + GAP + right.width, left.height.max(right.height));
    let mut rgba = vec![255; 4 * width * height];
    for (picture, from) in [(left, 0), (right, left.width + GAP)] {
        let rows = picture.rgba.chunks_exact(4 * picture.width.max(1));
        for (row, pixels) in rgba.chunks_exact_mut(4 * width).zip(rows) {
            row[4 * from..][..pixels.len()].copy_from_slice(pixels);
        }
    }
    Picture { width, height, rgba }
}

/// The drawing in a file.
fn read_drawing(path: &Path) -> anyhow::Result<Drawing> {
    let bytes = source::read(path, import::MOST_BYTES as u64)
        .map_err(|error| anyhow!("{}: {error}", path.display()))?;
    import::read(&bytes).map_err(|error| anyhow!("{}: {error}", path.display()))
}

impl Window {
    /// An unreadable file leaves the current scene unchanged.
    pub(super) fn open(&mut self, path: &Path) {
        if let Err(error) = output::refuse_stream(path) {
            return self.refuse("The scene cannot be opened", &error);
        }
        match Document::read(path) {
            Ok(document) => {
                self.editor.replace(document);
                settings::remember(&mut self.shown.recent, path);
                self.tell(&format!("Opened {}", path.display()), false);
            }
            Err(error) => {
                // A vanished file is removed from the recent files.
                self.shown.recent.retain(|recent| recent != path || source::exists(recent));
                self.refuse("The scene cannot be opened", &anyhow!(error));
            }
        }
    }

    pub(super) fn send(
        &mut self,
        ctx: &egui::Context,
        work: impl FnOnce(&Progress) -> Outcome + Send + 'static,
    ) -> Option<Progress> {
        match Errand::start(ctx, work) {
            Ok(errand) => {
                let progress = errand.progress.clone();
                self.errands.push(errand);
                Some(progress)
            }
            Err(error) => {
                self.refuse("The task cannot be started", &error.into());
                None
            }
        }
    }

    /// A file that was dropped.
    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn receive(
        &mut self,
        file: &egui::DroppedFileHandle,
        _: &egui::Context,
        commands: &mut Vec<Command>,
    ) {
        self.editor.ask(Purpose::of_dropped(file.path()).command(file.path().to_owned()), commands);
    }

    /// The same for a file read by the browser.
    #[cfg(target_arch = "wasm32")]
    pub(super) fn receive(
        &mut self,
        file: &egui::DroppedFileHandle,
        ctx: &egui::Context,
        _: &mut Vec<Command>,
    ) {
        let file = Arc::clone(file);
        let read = async move {
            let bytes = file.bytes_async().await?;
            Ok(browser::take(file.path(), bytes))
        };
        let outcome = async move {
            match read.await {
                Ok(path) => Outcome::Chosen(Purpose::of_dropped(&path), Ok(path)),
                Err(reason) => Outcome::Unreadable(reason),
            }
        };
        match Errand::wait(ctx, outcome) {
            Ok(errand) => self.errands.push(errand),
            Err(error) => self.refuse("The file cannot be read", &error.into()),
        }
    }

    /// Opens the file dialog of the desktop or browser in the background.
    pub(super) fn browse(&mut self, purpose: Purpose, text: String, ctx: &egui::Context) {
        let chosen = ask_for_file(purpose, &self.editor.document);
        match Errand::wait(ctx, async move { Outcome::Chosen(purpose, chosen.await.ok_or(text)) }) {
            Ok(errand) => self.errands.push(errand),
            Err(error) => self.refuse("The task cannot be started", &error.into()),
        }
    }

    /// Lists a folder, or the last one again, initially the scene's.
    pub(super) fn list(&mut self, folder: Option<PathBuf>, ctx: &egui::Context) {
        let own = || self.editor.document.path().and_then(Path::parent).map(Path::to_owned);
        let last = || self.shown.folder.as_ref().map(|folder| folder.path.clone());
        let recent = || self.shown.recent.first().and_then(|path| path.parent()).map(Path::to_owned);
        let folder = folder
            .or_else(last)
            .or_else(own)
            .or_else(folders::here)
            .or_else(recent)
            .or_else(std::env::home_dir);
        self.send(ctx, move |_| Outcome::Listed(folders::list(&folder.unwrap_or_default())));
    }

    /// Processes the answer to a file dialog, which stays open with the reason if it fails.
    pub(super) fn answer(&mut self, purpose: Purpose, text: &str, ctx: &egui::Context) {
        let folder = self.shown.folder.as_ref().map(|folder| folder.path.as_path());
        let path = folders::meant(text, folder);
        if path.is_dir() {
            self.editor.dialog = Some(Dialog::Path { purpose, text: String::new() });
            return self.list(Some(path), ctx);
        }
        self.answered = Some((purpose, text.to_owned()));
        if purpose == Purpose::Open && link::is_link(text) {
            match link::read(text) {
                Ok(_) => {
                    self.editor.dialog = None;
                    let mut commands = Vec::new();
                    self.editor.ask(Command::OpenLink(text.to_owned()), &mut commands);
                    commands.into_iter().for_each(|command| self.execute(command, ctx));
                }
                Err(error) => self.refuse("The link cannot be opened", &error.into()),
            }
            self.answered = None;
            return;
        }
        let typed = path;
        let path = purpose.with_ending(typed.clone());
        if purpose.reads() {
            // An unreadable file replaces nothing, so the confirmation for unsaved changes comes only after reading.
            let readable = match purpose {
                Purpose::Open => Document::read(&path).map(drop).map_err(anyhow::Error::new),
                _ => source::open(&path).map(drop).map_err(|error| anyhow!("{}: {error}", path.display())),
            };
            match readable {
                Ok(()) => self.go_on(purpose, path, ctx),
                Err(error) => self.refuse("The file cannot be read", &error),
            }
        } else if let Err(error) =
            [&typed, &path].into_iter().try_for_each(|path| output::refuse_stream(path))
        {
            self.refuse("This is not a regular file", &error);
        } else if !becomes_download(purpose)
            && source::exists(&path)
            && self.editor.document.path() != Some(path.as_path())
        {
            let text = text.to_owned();
            self.editor.dialog = Some(Dialog::Replace { purpose, text, path });
        } else {
            self.go_on(purpose, path, ctx);
        }
        self.answered = None;
    }

    fn go_on(&mut self, purpose: Purpose, path: PathBuf, ctx: &egui::Context) {
        self.editor.dialog = None;
        let mut commands = Vec::new();
        self.editor.ask(purpose.command(path), &mut commands);
        commands.into_iter().for_each(|command| self.execute(command, ctx));
    }

    /// Reads a drawing, then opens the import dialog.
    pub(super) fn import(&mut self, path: PathBuf, ctx: &egui::Context) {
        self.send(ctx, move |_| {
            let drawing = read_drawing(&path);
            Outcome::Read(path, drawing)
        });
    }

    /// Reads a waveform, then applies it to the scene's modulation, or to a target's own.
    pub(super) fn read_waveform(&mut self, target: Option<usize>, path: PathBuf, ctx: &egui::Context) {
        self.send(ctx, move |_| Outcome::Heard(target, waveform::read(&path)));
    }

    fn take_waveform(&mut self, target: Option<usize>, wave: Wave) {
        let Some(samples) = wave.get() else { return };
        let name = self.beside_document(&samples.file);
        let mut all = self.editor.document.scene.modulations_mut();
        // A target may be gone.
        let Some((_, modulation)) = all.find(|(of, _)| *of == target) else { return };
        (modulation.file, modulation.wave, modulation.shape) = (name, wave, Envelope::File);
    }

    /// Reads thresholds, then applies them to the skin.
    pub(super) fn read_thresholds(&mut self, path: PathBuf, ctx: &egui::Context) {
        self.send(ctx, move |_| Outcome::Felt(thresholds::read(&path)));
    }

    fn take_thresholds(&mut self, curve: Curve) {
        let Some(file) = &curve.from else { return };
        let name = self.beside_document(file);
        let skin = self.editor.document.scene.skin.get_or_insert_default();
        (skin.threshold, skin.curve) = (name, curve);
    }

    /// Reads a directivity, then applies it to the elements.
    pub(super) fn read_directivity(&mut self, path: PathBuf, ctx: &egui::Context) {
        self.send(ctx, move |_| Outcome::Directed(directivity::read(&path)));
    }

    fn take_directivity(&mut self, measured: Directivity) {
        let Some(file) = &measured.from else { return };
        let name = Some(self.beside_document(file));
        let array = &mut self.editor.document.scene.array;
        (array.directivity, array.measured, array.element) = (name, measured, ElementModel::Measured);
    }

    /// Reads the surface of a body, or of a new one, then applies it.
    pub(super) fn read_surface(&mut self, body: Option<usize>, path: PathBuf, ctx: &egui::Context) {
        self.send(ctx, move |_| Outcome::Shaped(body, surfaces::read(&path)));
    }

    fn take_surface(&mut self, body: Option<usize>, surface: Surface) {
        /// m, of the longest side: larger bodies are in millimetres.
        const LARGEST: f64 = 2.0;
        let Some(file) = &surface.from else { return };
        let file = Some(self.beside_document(file));
        let has_scale = body.and_then(|index| self.editor.scene().bodies.get(index)?.file.as_ref()).is_some();
        let span = surface.get().map_or(0.0, |mesh| {
            let (low, high) = mesh.extent();
            (high - low).max_element()
        });
        let scale = if span > LARGEST { 1e-3 } else { 1.0 };
        let of = |own: &Body| {
            let scale = if has_scale { own.scale } else { scale };
            Body { kind: BodyKind::Mesh, file, surface, scale, ..own.clone() }
        };
        let own = body.and_then(|index| self.editor.document.scene.bodies.get_mut(index));
        match (own, body) {
            (Some(own), Some(index)) => {
                *own = of(own);
                self.editor.choose_body(index);
            }
            (None, _) | (_, None) => {
                let body = bodies::in_plane(&self.editor, &of(&Body::default()));
                bodies::add(&mut self.editor, body);
            }
        }
    }

    /// Reads the path of a target's own motion, or of the scene's, then applies it.
    pub(super) fn read_routes(&mut self, target: Option<usize>, path: PathBuf, ctx: &egui::Context) {
        self.send(ctx, move |_| Outcome::Routed(target, routes::read(&path)));
    }

    fn take_routes(&mut self, target: Option<usize>, routes: Routes) {
        let Some(file) = routes.file() else { return };
        let name = self.beside_document(file);
        let Some(motion) = way::motion_mut(&mut self.editor.document.scene, target) else { return };
        // Another file has its own tempo, and needs as many frames as it has places.
        motion.tempo = Tempo::usual(MotionPath::File);
        (motion.path, motion.frames) = (MotionPath::File, Motion::AUTOMATIC);
        (motion.file, motion.routes) = (name, routes);
    }

    /// The name of a file in the scene: relative to the scene's folder, if it lies there.
    fn beside_document(&self, file: &Path) -> String {
        let folder = self.editor.document.path().and_then(Path::parent);
        let name = file.strip_prefix(folder.unwrap_or(Path::new(""))).unwrap_or(file);
        name.to_string_lossy().into_owned()
    }

    /// Processes finished errands.
    pub(super) fn collect(&mut self, commands: &mut Vec<Command>, ctx: &egui::Context) {
        let count = self.errands.len();
        for errand in std::mem::take(&mut self.errands) {
            match errand.state() {
                State::UnderWay => self.errands.push(errand),
                State::Done(outcome) => self.take(outcome, commands, ctx),
                State::Failed => {
                    self.filming = None;
                    self.refuse("Something went wrong", &anyhow!("this is a bug in Sonoglyph"));
                }
            }
        }
        if self.errands.len() < count {
            // The panels of this frame were drawn without the results.
            ctx.request_repaint();
        }
        let film = |film: &Film| (film.name.clone(), film.progress.part());
        self.shown.export = self.filming.as_ref().map(film);
    }

    fn take(&mut self, outcome: Outcome, commands: &mut Vec<Command>, ctx: &egui::Context) {
        if let Outcome::Filmed(..) = outcome {
            self.filming = None;
        }
        match outcome {
            Outcome::Chosen(purpose, Ok(path)) => {
                let whole = purpose.with_ending(path.clone());
                if whole != path && source::exists(&whole) {
                    // The desktop asked for confirmation of the name without its extension.
                    let text = whole.display().to_string();
                    self.editor.dialog = Some(Dialog::Replace { purpose, text, path: whole });
                } else {
                    self.editor.ask(purpose.command(whole), commands);
                }
            }
            Outcome::Chosen(purpose, Err(text)) => {
                let why = "No file was chosen there: choose one here".to_owned();
                self.editor.asking.problem = Some((text.clone(), why));
                self.editor.dialog = Some(Dialog::Path { purpose, text });
            }
            #[cfg(target_arch = "wasm32")]
            Outcome::Unreadable(reason) => self.refuse("The file cannot be read", &anyhow!(reason)),
            Outcome::Listed(folder) => self.shown.folder = Some(folder),
            Outcome::Read(path, Ok(drawing)) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let import = ui::Import::new(name, drawing, &self.editor.view, self.editor.scene());
                self.editor.dialog = Some(Dialog::Import(Box::new(import)));
            }
            Outcome::Heard(target, Ok(wave)) => self.take_waveform(target, wave),
            Outcome::Heard(_, Err(error)) => self.refuse("The waveform cannot be read", &anyhow!(error)),
            Outcome::Felt(Ok(curve)) => self.take_thresholds(curve),
            Outcome::Felt(Err(error)) => self.refuse("The thresholds cannot be read", &anyhow!(error)),
            Outcome::Directed(Ok(measured)) => self.take_directivity(measured),
            Outcome::Directed(Err(error)) => self.refuse("The directivity cannot be read", &anyhow!(error)),
            Outcome::Shaped(body, Ok(surface)) => self.take_surface(body, surface),
            Outcome::Shaped(_, Err(error)) => self.refuse("The surface cannot be read", &anyhow!(error)),
            Outcome::Routed(target, Ok(routes)) => self.take_routes(target, routes),
            Outcome::Routed(_, Err(error)) => self.refuse("The path cannot be read", &anyhow!(error)),
            Outcome::Placed(Ok(array)) => self.editor.document.scene.array = *array,
            Outcome::Wired(Ok(array)) => {
                let own = &mut self.editor.document.scene.array;
                (own.wiring, own.wires) = (array.wiring, array.wires);
            }
            Outcome::Wired(Err(error)) => self.refuse("The wiring cannot be read", &anyhow!(error)),
            Outcome::Placed(Err(error)) => self.refuse("The array cannot be read", &anyhow!(error)),
            Outcome::Driven(Ok(drive)) => {
                let name = drive.name.clone();
                self.editor.document.scene.drive = *drive;
                self.tell(&format!("Playing the drive of {name}; nothing is solved"), false);
            }
            Outcome::Driven(Err(error)) => {
                self.refuse("The drive cannot be read", &anyhow!(error));
            }
            Outcome::Filmed(path, Ok(Some(()))) => self.tell(&format!("Wrote {}", path.display()), false),
            Outcome::Filmed(path, Ok(None)) => {
                self.tell(&format!("Cancelled: {} was not written", path.display()), false);
            }
            Outcome::Filmed(_, Err(error)) => self.refuse("Nothing was exported", &error),
            Outcome::Printed(path, Ok(())) => self.tell(&format!("Wrote {}", path.display()), false),
            Outcome::Printed(_, Err(error)) => self.refuse("Nothing was exported", &error),
            Outcome::Copied(Ok(picture)) => {
                ctx.copy_image(image(&picture));
                self.tell(&format!("Copied {} × {} pixels", picture.width, picture.height), false);
            }
            Outcome::Copied(Err(error)) => self.refuse("The figure cannot be copied", &error),
            Outcome::Read(_, Err(error)) => self.refuse("The drawing cannot be imported", &error),
        }
    }

    /// Asks first if that would overwrite another program's changes.
    pub(super) fn save(&mut self, path: &Path, ctx: &egui::Context) {
        if let Err(error) = output::refuse_stream(path) {
            self.refuse("The scene cannot be saved", &error);
        } else if self.editor.document.was_changed_elsewhere(path) {
            self.editor.dialog = Some(Dialog::Changed(path.to_owned()));
        } else {
            self.overwrite(path, ctx);
        }
    }

    pub(super) fn overwrite(&mut self, path: &Path, ctx: &egui::Context) {
        let then = self.editor.after_saving.take();
        let document = &mut self.editor.document;
        let Placed { scene, files } = document.placed(path);
        let written = check::check(&scene)
            .context("no program could read this scene again")
            .and_then(|()| document.paintings.write(files, output::save))
            .and_then(|()| output::save(path, document.text_of(&scene).as_bytes()));
        match written {
            Ok(()) => {
                document.saved_as(path.to_owned(), scene);
                settings::remember(&mut self.shown.recent, path);
                self.tell(&format!("Saved {}", path.display()), false);
                if let Some(command) = then {
                    self.execute(command, ctx);
                }
            }
            Err(error) => self.refuse("The scene cannot be saved", &error),
        }
    }

    pub(super) fn export(&mut self, export: Export, path: &Path, ctx: &egui::Context) {
        let endings = Purpose::Export(export).extensions();
        if let Err(error) = output::refuse_stream(path).and_then(|()| figure::refuse_ending(path, endings)) {
            return self.refuse("Nothing was exported", &error);
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        self.editor.asking.exported_to = folder.map(Path::to_owned);
        let bytes = match export {
            Export::Figure(format) => return self.print_figure(format, path, ctx),
            Export::Sheet => return self.print_sheet(path, ctx),
            Export::Motion(_) => return self.film(path, ctx),
            Export::Report => return self.print_measured(path, ctx),
            Export::Calibration { .. } => self.calibration_csv(),
            Export::Map => self.view_png(),
            Export::Numbers => self.numbers_npy(),
            Export::Drive => self.drive_csv(),
            Export::Profile => self.profile_csv(),
            Export::Elements => Ok(elements::of_scene(self.editor.scene()).into_bytes()),
        };
        match bytes.and_then(|bytes| output::write(path, &bytes)) {
            Ok(()) => {
                self.tell(&format!("Wrote {}", path.display()), false);
                if let Export::Calibration { is_used } = export {
                    self.keep_calibration(path, is_used);
                }
            }
            Err(error) => self.refuse("Nothing was exported", &error),
        }
    }

    /// Exports the motion, or waves, on a thread, in the displayed plane and view.
    fn film(&mut self, path: &Path, ctx: &egui::Context) {
        if let Some(film) = &self.filming {
            let error = anyhow!("{} is being written: one motion is exported at a time", film.name);
            return self.refuse("Nothing was exported", &error);
        }
        let Some(map) = &self.shown.map else {
            return self.refuse("Nothing was exported", &anyhow!("there is no map"));
        };
        let (view, form) = (&self.editor.view, &self.editor.film);
        let schedule = match form.schedule(self.editor.scene(), view) {
            Ok(schedule) => schedule,
            Err(error) => return self.refuse("Nothing was exported", &anyhow!(error)),
        };
        let (size, rate) = (form.size(map, ctx.pixels_per_point()), form.rate());
        let lens = Lens { rect: map.rect, window: map.window };
        let scene = Scene { plane: view.plane(self.editor.scene(), &lens), ..self.editor.scene().clone() };
        let (points, look) = if view.is_shaded() {
            let name = stem(Path::new(&self.editor.document.name()));
            (liquid::points(&scene.plane), Look::Shaded { name, page: size })
        } else {
            let full = view.full.map(|full| full as f32);
            (size, Look::Flat(Box::new(Colouring { full, ..view.colouring() })))
        };
        let (quantity, moment, channel) = (map.quantity, map.phase, view.channel);
        let round = self.shown.round.clone();
        let (path, ctx_of_thread) = (path.to_owned(), ctx.clone());
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let progress = self.send(ctx, move |progress| {
            let tell = |part: f64| {
                progress.tell(part as f32);
                ctx_of_thread.request_repaint();
                if progress.is_off() { Err(anyhow!("called off")) } else { Ok(()) }
            };
            let write = || -> anyhow::Result<()> {
                check::check(&scene)?;
                let round = round.map_or_else(|| frames::follow(&scene).map(Arc::new), Ok)?;
                let drives = round.frames.iter().map(|frame| frame.drive.clone()).collect();
                let request = Request { moment, channel, ..Request::new(&scene, drives, quantity, points) };
                let mut film = animate::Film::new(&scene, request, Stages::new(Evaluator::Cpu), look);
                (film.rate, film.schedule) = (rate, schedule);
                animate::write(&mut film, &path, &tell)
            };
            let written = write();
            let outcome = if progress.is_off() && written.is_err() { Ok(None) } else { written.map(Some) };
            Outcome::Filmed(path, outcome)
        });
        self.filming = progress.map(|progress| Film { name, progress });
    }

    fn view_png(&mut self) -> anyhow::Result<Vec<u8>> {
        let picture = match self.editor.space.is_on {
            true => self.workshop.spacing.picture(&self.editor, &self.shown),
            false => self.workshop.pictures().map(|(own, second)| match second {
                Some(second) => joined(&own, &second),
                None => own,
            }),
        };
        Ok(export::png(&picture.context("no picture is shown")?)?)
    }

    fn numbers_npy(&mut self) -> anyhow::Result<Vec<u8>> {
        let (shape, values) = self.workshop.mapping.numbers().context("there is no map")?;
        Ok(numbers::npy(&shape, &values)?)
    }

    fn drive_csv(&self) -> anyhow::Result<Vec<u8>> {
        let sound = self.shown.sound.as_ref().context("nothing is played")?;
        Ok(Drive::write_in_turn(&sound.drives, &sound.aperture).into_bytes())
    }

    /// Reads an element table, then uses it as the array.
    pub(super) fn read_elements(&mut self, path: &Path, ctx: &egui::Context) {
        let file = Some(path.to_string_lossy().into_owned());
        let array = self.editor.scene().array.clone();
        // Other elements: undriven ones and wires are those of the former.
        let (wiring, wires) = (None, Wires::default());
        let mut array = Array { file, placed: Elements::default(), off: Vec::new(), wiring, wires, ..array };
        self.send(ctx, move |_| {
            let read = opening::load_elements(&mut array, Path::new(""));
            Outcome::Placed(read.map(|()| Box::new(array)).map_err(|error| error.message))
        });
    }

    /// Reads a table of wires, then uses it.
    pub(super) fn read_wiring(&mut self, path: &Path, ctx: &egui::Context) {
        let mut scene = self.editor.scene().clone();
        (scene.array.wiring, scene.array.wires) =
            (Some(path.to_string_lossy().into_owned()), Wires::default());
        self.send(ctx, move |_| {
            let read = opening::load_wires(&mut scene, Path::new(""));
            let read = read.and_then(|()| check::check(&scene));
            Outcome::Wired(read.map(|()| Box::new(scene.array)).map_err(|error| error.message))
        });
    }

    /// Reads drives, then plays them instead of solved ones.
    pub(super) fn read_drive(&mut self, path: PathBuf, ctx: &egui::Context) {
        let scene = self.editor.scene().clone();
        self.send(ctx, move |_| {
            let name = path.to_string_lossy().into_owned();
            Outcome::Driven(opening::read_drive(&path, name, &scene).map(Box::new))
        });
    }

    fn profile_csv(&self) -> anyhow::Result<Vec<u8>> {
        let profile = Profile::of(&self.editor, &self.shown);
        Ok(profile.context("there is no line profile: show one on a map")?.csv().into_bytes())
    }
}
