//! Opening, saving and exporting.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use eframe::egui;

use crate::app::Window;
use crate::cli::map::{self, Look};
use crate::cli::{output, solve};
use crate::field::{Evaluator, Quantity, Stages};
use crate::picture::{export, sheet};
use crate::scene::{check, file};
use crate::ui::document::Document;
use crate::ui::{Export, Purpose};

const SHEET_WIDTH: usize = 1600;

/// Asks the desktop for a file. `None` where it has no such dialog, or nothing was chosen.
pub fn browse(purpose: Purpose, document: &Document) -> Option<PathBuf> {
    let mut dialog = rfd::FileDialog::new()
        .set_title(purpose.title())
        .add_filter(purpose.extension(), &[purpose.extension()]);
    if let Some(folder) = document.path().and_then(Path::parent).filter(|folder| folder.is_dir()) {
        dialog = dialog.set_directory(folder);
    }
    match purpose {
        Purpose::Open => dialog.pick_file(),
        Purpose::SaveAs | Purpose::Export(_) => dialog.save_file(),
    }
}

impl Window {
    /// A file that cannot be read leaves the scene that is there.
    pub(super) fn open(&mut self, path: &Path) {
        match file::read(path) {
            Ok(scene) => {
                self.editor.replace(Document::new(scene, Some(path.to_owned()), ""));
                self.tell(&format!("Opened {}", path.display()), false);
            }
            Err(error) => self.refuse("The scene cannot be opened", &anyhow!(error)),
        }
    }

    pub(super) fn save(&mut self, path: &Path, ctx: &egui::Context) {
        let then = self.editor.after_saving.take();
        let scene = self.editor.scene();
        let written = check::check(scene)
            .context("no program could read this scene again")
            .and_then(|()| output::write(path, file::write(scene).as_bytes()));
        match written {
            Ok(()) => {
                self.editor.document.saved_as(path.to_owned());
                self.tell(&format!("Saved {}", path.display()), false);
                if let Some(command) = then {
                    self.execute(command, ctx);
                }
            }
            Err(error) => self.refuse("The scene cannot be saved", &error),
        }
    }

    pub(super) fn export(&mut self, export: Export, path: &Path) {
        let bytes = match export {
            Export::Map => self.map_png(),
            Export::Sheet => self.sheet_png(),
            Export::Numbers => self.numbers_npy(),
            Export::Drive => self.drive_csv(),
        };
        match bytes.and_then(|bytes| output::write(path, &bytes)) {
            Ok(()) => self.tell(&format!("Wrote {}", path.display()), false),
            Err(error) => self.refuse("Nothing was exported", &error),
        }
    }

    fn map_png(&mut self) -> anyhow::Result<Vec<u8>> {
        Ok(export::png(&self.workshop.mapping.picture().context("there is no map")?)?)
    }

    fn numbers_npy(&mut self) -> anyhow::Result<Vec<u8>> {
        let (shape, values) = self.workshop.mapping.numbers().context("there is no map")?;
        Ok(export::npy(&shape, &values)?)
    }

    fn drive_csv(&self) -> anyhow::Result<Vec<u8>> {
        let sound = self.shown.sound.as_ref().context("nothing is played")?;
        Ok(solve::csv(&sound.aperture, &sound.drive).into_bytes())
    }

    /// The page of the scene at rest, on the scene's own plane.
    fn sheet_png(&self) -> anyhow::Result<Vec<u8>> {
        let solution = self.shown.solution.as_ref().context("nothing is played")?;
        let scene = self.editor.scene();
        let page = (SHEET_WIDTH, sheet::height(SHEET_WIDTH));
        let (width, height) = sheet::map_size(&scene.plane, page.0, page.1);
        let colours = self.editor.view.colours;
        let look = Look { width, height, quantity: Quantity::Rms, colours, numbers: false };
        let drives = [solution.drive.clone()];
        let sound = map::Sound { scene, drives: &drives };
        let map = map::draw_anyhow(sound, &mut Stages::new(Evaluator::Cpu), &look, false)?;
        let name = self.editor.document.name();
        let page = sheet::sheet(scene, solution, &name, &map.picture, (colours, map.largest), page)?;
        Ok(export::png(&page)?)
    }
}
