//! Scans of the Measure page: opening them, their calibrations and reports.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, anyhow, bail};
use eframe::egui;

use crate::app::figure::Previews;
use crate::app::measured_figures::{MeasuredFigures, Sketch};
use crate::app::window::Window;
use crate::studio::figure;
use crate::studio::measurement::report;
use crate::ui::{Dialog, Panel};

impl Window {
    /// Shows a scan on the Measure page, which says what is wrong with it.
    pub(super) fn open_scan(&mut self, path: PathBuf) {
        let editor = &mut self.editor;
        editor.parts.measuring.open(path);
        (editor.panel, editor.layout.is_drawn_out, editor.layout.is_folded) = (Panel::Measure, true, false);
    }

    /// The calibration of the displayed result.
    pub(super) fn calibration_csv(&self) -> anyhow::Result<Vec<u8>> {
        let measuring = &self.editor.parts.measuring;
        let finding = measuring.exact().context("the scan is not fitted yet")?;
        let measured = &finding.map_err(|problem| anyhow!("{problem}"))?.measured;
        if let Some(reason) = measured.unidentifiable() {
            bail!("the scan does not tell the elements apart: {reason}");
        }
        let elements = measured.scene.elements();
        Ok(measured.calibration(measuring.with_gains).to_csv(elements).into_bytes())
    }

    /// Remembers a calibration that was written, for the board if wanted.
    pub(super) fn keep_calibration(&mut self, path: &Path, is_used: bool) {
        self.editor.parts.measuring.saved_as(path.to_owned());
        if is_used {
            self.editor.board.calibration = path.display().to_string();
            self.tell(&format!("{} is used from the next connection on", path.display()), false);
        }
    }

    /// Writes the report of the displayed result on a thread: HTML, or a figure, by the ending.
    pub(super) fn print_measured(&mut self, path: &Path, ctx: &egui::Context) {
        let Some(Ok(finding)) = self.editor.parts.measuring.exact() else {
            return self.refuse("Nothing was exported", &anyhow!("the scan is not fitted yet"));
        };
        let (finding, title) = (Arc::clone(finding), self.title_of_scan());
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("html")) {
            return self.print(path, ctx, move || Ok(report::html(&finding.measured, &title)?.into_bytes()));
        }
        match figure::format(path) {
            Ok(format) => self
                .print(path, ctx, move || Ok(report::drawn(&finding.measured, &title, true)?.write(format)?)),
            Err(error) => self.refuse("Nothing was exported", &error),
        }
    }

    fn title_of_scan(&self) -> String {
        let name = self.editor.parts.measuring.form.scan.as_deref().and_then(Path::file_name);
        name.map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }

    /// Updates the figures while they are displayed.
    pub(super) fn preview_measured(&mut self, ctx: &egui::Context) {
        let is_shown = self.editor.panel == Panel::Measure && !self.editor.layout.presents;
        let finding = self.editor.parts.measuring.finding().filter(|_| is_shown);
        let Some(finding) = finding.filter(|finding| !finding.panels.is_empty()).cloned() else {
            if self.shown.measured.is_some() || self.shown.measured_large.is_some() || self.measured.is_busy()
            {
                self.measured = MeasuredFigures::default();
                (self.shown.measured, self.shown.measured_large) = (None, None);
            }
            return;
        };
        let sketch = Sketch { finding, title: self.title_of_scan() };
        let MeasuredFigures { page, dialog } = &mut self.measured;
        page.update(sketch.clone(), Sketch::column, &mut self.shown.measured, ctx);
        if self.editor.dialog == Some(Dialog::Measured) {
            dialog.update(sketch, Sketch::whole, &mut self.shown.measured_large, ctx);
        } else if self.shown.measured_large.is_some() || dialog.is_busy() {
            (*dialog, self.shown.measured_large) = (Previews::default(), None);
        }
    }
}
