//! Figures and sheets of what is shown: the panels of a figure, and files made on a thread.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, bail};
use eframe::egui;

use crate::app::errand::Outcome;
use crate::app::figure::{Previews, Recipe};
use crate::app::window::Window;
use crate::field::{Evaluator, Quantity, Request, Stages};
use crate::picture::figure::Format;
use crate::picture::{export, sheet as page};
use crate::studio::figure::{Panel, Subject, Wish};
use crate::studio::{map, output, sheet};
use crate::ui::{Dialog, Piece, figure, sound, timeline};

const SHEET_WIDTH: usize = 1600;

impl Window {
    fn recipe(&self) -> anyhow::Result<Recipe> {
        let (editor, shown) = (&self.editor, &self.shown);
        let mut panels = Vec::new();
        for &piece in &editor.figure.pieces {
            match piece {
                Piece::Map => panels.push(self.map(self.own_request()?, false)),
                Piece::Second => panels.push(self.map(self.second_request()?, true)),
                Piece::Difference => {
                    let requests = Box::new([self.own_request()?, self.second_request()?]);
                    let name = "Difference, first minus second".to_owned();
                    panels.push(Panel { name, subject: Subject::Difference(requests) });
                }
                Piece::Relief => panels.push(self.relief(self.own_request()?, false)),
                Piece::SecondRelief => panels.push(self.relief(self.second_request()?, true)),
                Piece::Space => {
                    let spacing = &self.workshop.spacing;
                    let prospect = spacing.prospect(editor, shown, editor.figure.is_light);
                    let subject = Subject::Space(Box::new(prospect.context("there is no 3D view yet")?));
                    panels.push(Panel { name: "3D view".to_owned(), subject });
                }
                Piece::Profile
                | Piece::Phases
                | Piece::Amplitudes
                | Piece::Pattern
                | Piece::Polar
                | Piece::Methods => {
                    let plot = figure::plot(piece, editor, shown);
                    let (name, plot) =
                        plot.with_context(|| format!("{}: not there yet", piece.into_str()))?;
                    panels.push(Panel { name, subject: Subject::Plot(Box::new(plot)) });
                }
            }
        }
        if panels.is_empty() {
            bail!("Choose at least one panel");
        }
        let wish = Wish { moment: timeline::moment_in_words(editor), ..editor.figure.wish(&editor.view) };
        Ok(Recipe { panels, wish })
    }

    fn map(&self, request: Request, is_second: bool) -> Panel {
        let (beside, own) = (self.shown.beside.as_ref(), self.shown.sound.as_ref());
        let sound = if is_second { beside.and_then(|beside| beside.sound.as_ref()) } else { own };
        let foci = sound.map_or_else(Vec::new, |sound| sound.foci.clone());
        let scene = Arc::new(self.editor.scene().clone());
        Panel { name: self.name(is_second), subject: Subject::Map { scene, foci, request } }
    }

    fn relief(&self, request: Request, is_second: bool) -> Panel {
        Panel { name: self.name(is_second), subject: Subject::Shaded(request) }
    }

    /// The title of a map: in a comparison what differs, otherwise the quantity.
    fn name(&self, is_second: bool) -> String {
        let editor = &self.editor;
        let compare = editor.compare.as_ref().filter(|compare| compare.is_split && !editor.space.is_on);
        let Some(compare) = compare else {
            return editor.view.quantity.declaration().title.to_owned();
        };
        let scene = editor.scene();
        let own = if scene.drive.is_named() { "drive of a file" } else { scene.solver.method.title() };
        let [left, right] = compare.names(own, editor.levels, editor.view.cut);
        if is_second { right } else { left }
    }

    /// The request of the map on the screen. Behind a 3D view, that of its plane with the drives of now.
    fn own_request(&self) -> anyhow::Result<Request> {
        let (editor, shown) = (&self.editor, &self.shown);
        let kept = self.workshop.mapping.request().context("there is no map")?.clone();
        let sound = shown.sound.as_ref().filter(|_| editor.space.is_on);
        let Some(sound) = sound else { return Ok(self.within(kept)) };
        let quantity = editor.view.quantity;
        let drives = sound::drives(shown.round.as_ref(), Some(sound), editor.playback, quantity);
        let Request { plane, moment, channel, .. } = kept;
        let aperture = sound.aperture.clone();
        let request = Request::new(editor.scene(), drives, quantity, (1, 1));
        Ok(self.within(Request { plane, moment, channel, aperture, ..request }))
    }

    fn second_request(&self) -> anyhow::Result<Request> {
        let request = self.workshop.second_request().context("the second map is not there yet")?;
        Ok(self.within(request.clone()))
    }

    /// The chosen part of the plane; the figure has its own size in pixels.
    fn within(&self, request: Request) -> Request {
        let plane = self.editor.figure.plane(&request.plane, self.editor.scene());
        Request { plane, size: (1, 1), ..request }
    }

    /// Updates the preview while it is displayed.
    pub(super) fn preview_figure(&mut self, ctx: &egui::Context) {
        if self.editor.dialog != Some(Dialog::Figure) {
            if self.shown.figure.is_some() {
                (self.previews, self.shown.figure) = (Previews::default(), None);
            }
            return;
        }
        let recipe = match self.recipe() {
            Ok(recipe) => recipe,
            Err(error) => return self.shown.figure = Some(Err(format!("{error:#}"))),
        };
        self.previews.update(recipe, Recipe::preview, &mut self.shown.figure, ctx);
    }

    /// Writes the figure on a thread.
    pub(super) fn print_figure(&mut self, format: Format, path: &Path, ctx: &egui::Context) {
        match self.recipe() {
            Ok(recipe) => self.print(path, ctx, move || Ok(recipe.figure()?.write(format)?)),
            Err(error) => self.refuse("Nothing was exported", &error),
        }
    }

    /// Copies the figure's pixels, which a thread makes.
    pub(super) fn copy_figure(&mut self, ctx: &egui::Context) {
        match self.recipe() {
            Ok(recipe) => {
                let picture = move || Ok(recipe.figure()?.picture()?);
                self.send(ctx, move |_| Outcome::Copied(picture()));
            }
            Err(error) => self.refuse("The figure cannot be copied", &error),
        }
    }

    /// Writes the sheet of the scene at rest, on the scene plane and in the view's convention.
    pub(super) fn print_sheet(&mut self, path: &Path, ctx: &egui::Context) {
        let Some(solution) = self.shown.solution.clone() else {
            return self.refuse("Nothing was exported", &anyhow::anyhow!("nothing is played"));
        };
        let (scene, name) = (self.editor.scene().clone(), self.editor.document.name());
        let (colours, convention) = (self.editor.view.colours, self.editor.view.convention);
        self.print(path, ctx, move || {
            let size = (SHEET_WIDTH, page::height(SHEET_WIDTH));
            let pixels = page::map_size(&scene.plane, size.0, size.1);
            let request = Request::new(&scene, solution.drives(), Quantity::Rms, pixels);
            let drawn = map::draw(&request, colours, &mut Stages::new(Evaluator::Cpu), false)?;
            let words = sheet::words(&scene, &solution, &name, convention);
            let map = sheet::pressure(drawn.picture, &drawn.map, colours, convention);
            Ok(export::png(&page::sheet(&scene, &solution, &words, map, size)?)?)
        });
    }

    pub(super) fn print(
        &mut self,
        path: &Path,
        ctx: &egui::Context,
        bytes: impl FnOnce() -> anyhow::Result<Vec<u8>> + Send + 'static,
    ) {
        let path = path.to_owned();
        self.send(ctx, move |_| {
            let written = bytes().and_then(|bytes| output::write(&path, &bytes));
            Outcome::Printed(path, written)
        });
    }
}
