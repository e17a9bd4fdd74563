//! The options of exported figures and films.

use egui::TextureHandle;

use crate::picture::figure::{Format, Paper};
use crate::scene::{Scene, motion};
use crate::studio::animate::Kind;
use crate::studio::figure::Wish;
use crate::studio::map;
use crate::studio::swell::Schedule;
use crate::ui::map::Map;
use crate::ui::view::View;

/// The options of a figure; map, colours, range and contours are those of the view.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureForm {
    pub(super) paper: Paper,
    pub(super) title: String,
    pub(super) colour_bar: bool,
    pub(super) scale_bar: bool,
    pub(super) contours: bool,
    pub(super) targets: bool,
    pub(super) widths: bool,
    pub(super) is_light: bool,
    pub(super) format: Format,
}

impl Default for FigureForm {
    fn default() -> Self {
        Self {
            paper: Paper::default(),
            title: String::new(),
            colour_bar: true,
            scale_bar: false,
            contours: false,
            targets: false,
            widths: false,
            is_light: false,
            format: Format::Pdf,
        }
    }
}

impl FigureForm {
    /// Colours for the ground of the view.
    pub fn follow(&mut self, view: &View) {
        self.is_light = view.is_light;
    }

    /// The figure of a view.
    pub fn wish(&self, view: &View) -> Wish {
        let declaration = view.quantity.declaration();
        let is_shaded = view.is_shaded();
        let contours: &[f64] = match declaration.is_level() {
            true => &map::OVER_THRESHOLD,
            false if declaration.has_mean && !is_shaded => std::slice::from_ref(&view.contour_level),
            false => &[],
        };
        Wish {
            paper: self.paper,
            title: Some(self.title.clone()),
            is_shaded,
            colours: view.colours,
            is_light: self.is_light,
            scale: view.colouring().scale(),
            range: None,
            full: view.full,
            low: view.low.filter(|_| view.full.is_some()),
            floor: view.floor,
            fades: view.fades,
            contours: contours.iter().copied().filter(|_| self.contours).collect(),
            convention: view.convention,
            has_colour_bar: self.colour_bar,
            has_scale_bar: self.scale_bar,
            has_targets: self.targets && !is_shaded,
            has_widths: self.widths && !is_shaded,
        }
    }
}

/// A figure as written, in screen pixels.
#[derive(Clone)]
pub struct Preview {
    pub texture: TextureHandle,
    /// Size of the figure, mm.
    pub size: [f64; 2],
}

impl std::fmt::Debug for Preview {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Preview").field("size", &self.size).finish_non_exhaustive()
    }
}

/// The options of a film; quantity, colours, range and shading are those of the view.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmForm {
    pub(super) kind: Kind,
    /// Pixels; `None`: as on the screen.
    pub(super) width: Option<usize>,
    /// Displayed frames per second; `None`: real time, as far as viewers allow.
    pub(super) rate: Option<f64>,
    pub(super) waves: bool,
    /// Duration of waves; `None`: the scene's default.
    pub(super) seconds: Option<f64>,
}

impl FilmForm {
    /// Pixels of a film of a map, in the shape that it has on the screen.
    pub fn size(&self, map: &Map, pixels_per_point: f32) -> (usize, usize) {
        let [width, height] = [map.rect.width(), map.rect.height()]
            .map(|points| f64::from(points * pixels_per_point).round().max(1.0));
        let own = self.width.map_or(width, |width| width as f64);
        self.kind.pixels((own as usize, (own * height / width).round().max(1.0) as usize))
    }

    pub fn rate(&self) -> Option<f64> {
        self.rate.map(|rate| rate.min(self.kind.most_rate()))
    }

    /// The schedule of waves, if shown.
    ///
    /// # Errors
    /// More pictures than waves may have.
    pub fn schedule(&self, scene: &Scene, view: &View) -> Result<Option<Schedule>, String> {
        let has_waves = view.quantity.declaration().of_liquid && (self.waves || !motion::moves(scene));
        let schedule = has_waves.then(|| Schedule::new(scene, self.seconds)).transpose();
        schedule.map_err(|error| format!("{error:#}"))
    }
}
