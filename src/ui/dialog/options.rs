//! The options of exported figures and films.

use egui::TextureHandle;
use glam::{DVec2, DVec3};
use strum::{IntoStaticStr, VariantArray};

use crate::picture::figure::{Format, Paper};
use crate::scene::{Plane, Scene, motion};
use crate::studio::animate::Kind;
use crate::studio::figure::Wish;
use crate::studio::map;
use crate::studio::swell::Schedule;
use crate::studio::vectors::Vector;
use crate::ui::map::Map;
use crate::ui::view::View;

/// Width of a figure of several panels, mm: both columns of a journal.
const DOUBLE: f64 = 174.0;
/// mm, sides of the part of a plane that a figure shows.
pub(super) const SPANS: [f64; 2] = [1.0, 10_000.0];

/// What a panel of a figure shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(const_into_str)]
pub enum Piece {
    Map,
    /// Of a comparison.
    #[strum(serialize = "Second map")]
    Second,
    Difference,
    #[strum(serialize = "Shaded relief")]
    Relief,
    #[strum(serialize = "Second relief")]
    SecondRelief,
    #[strum(serialize = "3D view")]
    Space,
    #[strum(serialize = "Line profile")]
    Profile,
    #[strum(serialize = "Phases")]
    Phases,
    #[strum(serialize = "Amplitudes")]
    Amplitudes,
    #[strum(serialize = "Beam pattern")]
    Pattern,
    #[strum(serialize = "Beam pattern, polar")]
    Polar,
    #[strum(serialize = "Methods table")]
    Methods,
}

impl Piece {
    /// Whether it is a plane in colours, with contours and targets.
    pub(super) fn is_map(self) -> bool {
        matches!(self, Self::Map | Self::Second | Self::Difference)
    }

    pub(super) fn is_relief(self) -> bool {
        matches!(self, Self::Relief | Self::SecondRelief)
    }

    /// Whether a part of the plane is chosen for it.
    pub(super) fn is_of_plane(self) -> bool {
        self.is_map() || self.is_relief()
    }
}

/// The part of the displayed plane that a figure shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(const_into_str)]
pub enum Extent {
    /// As on the screen.
    #[default]
    View,
    /// Of the size of the scene plane, about its centre.
    #[strum(serialize = "Scene plane")]
    ScenePlane,
    /// Of a typed size, about the centre of the scene plane.
    #[strum(serialize = "Width x height")]
    Typed,
}

/// The options of a figure; planes, colours, range and contours are those of the view.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureForm {
    pub pieces: Vec<Piece>,
    /// What could be shown, and what was, when the pieces were chosen.
    offer: [Vec<Piece>; 2],
    /// mm; `None`: a column, or both for several panels.
    pub(super) width: Option<f64>,
    pub(super) dpi: f64,
    /// `None`: as many as suit the panels.
    pub(super) columns: Option<usize>,
    pub(super) extent: Extent,
    /// Width and height of [`Extent::Typed`], mm.
    pub(super) span: [f64; 2],
    pub(super) title: String,
    pub(super) colour_bar: bool,
    pub(super) scale_bar: bool,
    pub(super) contours: bool,
    pub(super) targets: bool,
    pub(super) widths: bool,
    pub(super) arrows: bool,
    pub is_light: bool,
    pub(super) format: Format,
}

impl Default for FigureForm {
    fn default() -> Self {
        Self {
            pieces: Vec::new(),
            offer: [Vec::new(), Vec::new()],
            width: None,
            dpi: Paper::default().dpi,
            columns: None,
            extent: Extent::default(),
            span: [100.0; 2],
            title: String::new(),
            colour_bar: true,
            scale_bar: false,
            contours: false,
            targets: false,
            widths: false,
            arrows: false,
            is_light: false,
            format: Format::Pdf,
        }
    }
}

impl FigureForm {
    /// Colours for the ground of the view, and the pieces on the screen, of those that can be shown. While these stay
    /// the same, the last choice is kept.
    pub fn follow(&mut self, view: &View, scene: &Scene, [available, displayed]: [Vec<Piece>; 2]) {
        self.is_light = view.is_light;
        let offer = [available, displayed];
        if self.pieces.is_empty() || self.offer != offer {
            self.pieces.clone_from(&offer[1]);
            self.offer = offer;
        }
        if self.extent != Extent::Typed {
            self.span = (scene.plane.size * 1e3).to_array();
        }
    }

    /// mm
    pub(super) fn width(&self) -> f64 {
        let usual = if self.pieces.len() > 1 { DOUBLE } else { Paper::default().width };
        self.width.unwrap_or(usual)
    }

    /// The chosen part of a plane on the screen.
    pub fn plane(&self, shown: &Plane, scene: &Scene) -> Plane {
        let size = match self.extent {
            Extent::View => return shown.clone(),
            Extent::ScenePlane => scene.plane.size,
            Extent::Typed => DVec2::from_array(self.span) * 1e-3,
        };
        let (x, y) = shown.axes().unwrap_or((DVec3::X, DVec3::Y));
        let offset = scene.plane.centre - shown.centre;
        Plane { centre: shown.centre + x * x.dot(offset) + y * y.dot(offset), size, ..shown.clone() }
    }

    /// The figure of a view.
    pub fn wish(&self, view: &View) -> Wish {
        let declaration = view.quantity.declaration();
        let contours: &[f64] = match declaration.is_level() {
            true => &map::OVER_THRESHOLD,
            false if declaration.has_mean => std::slice::from_ref(&view.contour_level),
            false => &[],
        };
        Wish {
            paper: Paper { width: self.width(), dpi: self.dpi },
            columns: self.columns,
            title: Some(self.title.clone()),
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
            moment: None,
            has_colour_bar: self.colour_bar,
            has_scale_bar: self.scale_bar,
            has_targets: self.targets,
            has_widths: self.widths,
            has_arrows: self.arrows && Vector::of(view.quantity).is_some(),
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
