//! The view of the field: plane, visible part, quantity and colours.

use std::f64::consts::FRAC_PI_4;

use egui::{Pos2, Rect, Vec2, vec2};
use glam::{DQuat, DVec2, DVec3};
use strum::{IntoStaticStr, VariantArray};

use crate::field::{Colouring, FLOOR, Quantity, Range, Scale};
use crate::picture::relief::{self, Place};
use crate::picture::{ColourMap, veil};
use crate::scene::{Array, Channel, Plane, Scene, outline};
use crate::studio::convention::Convention;
use crate::studio::map;
use crate::ui::measure::ProfileLine;

/// Margin factor of a fitted view.
const MARGIN: f64 = 1.08;
/// m per point of the screen.
const FINEST: f64 = 2e-6;
const COARSEST: f64 = 5e-3;

/// A plane to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "UPPERCASE", const_into_str)]
pub enum Cut {
    /// Parallel to the array.
    Xy,
    Xz,
    Yz,
    /// The plane of [`FreePlane`].
    #[strum(serialize = "Oblique plane")]
    Free,
    /// The scene plane, at any tilt.
    #[strum(serialize = "Scene plane")]
    Own,
}

impl Cut {
    pub fn tooltip(self) -> &'static str {
        match self {
            Self::Xy => "Parallel to the array, at a distance z from it",
            Self::Xz => "Upright, seen from the front: the array lies along the bottom",
            Self::Yz => "Upright, seen from the side: the array lies along the bottom",
            Self::Free => "Through any point, at any tilt and turn",
            Self::Own => "The plane of the scene file",
        }
    }

    /// The axis along which the plane moves.
    pub fn normal(self) -> Option<&'static str> {
        match self {
            Self::Xy => Some("z"),
            Self::Xz => Some("y"),
            Self::Yz => Some("x"),
            Self::Free | Self::Own => None,
        }
    }

    /// The horizontal and the vertical axis.
    pub fn axes(self) -> (&'static str, &'static str) {
        match self {
            Self::Xy => ("x / mm", "y / mm"),
            Self::Xz => ("x / mm", "z / mm"),
            Self::Yz => ("y / mm", "z / mm"),
            Self::Free | Self::Own => ("along the plane / mm", "across the plane / mm"),
        }
    }
}

/// An oblique plane through a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreePlane {
    /// m
    pub centre: DVec3,
    /// Tilt from the array's plane (rad), raising the vertical screen axis.
    pub tilt: f64,
    /// rad about the array's normal, counter-clockwise.
    pub turn: f64,
}

impl FreePlane {
    pub fn axes(&self) -> Axes {
        let (sine, cosine) = self.tilt.sin_cos();
        let turned = DQuat::from_rotation_z(self.turn);
        Axes { origin: self.centre, x: turned * DVec3::X, y: turned * DVec3::new(0.0, cosine, sine) }
    }
}

/// Coordinates on a cut: a point is origin + x u + y v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    pub origin: DVec3,
    pub x: DVec3,
    pub y: DVec3,
}

impl Axes {
    pub fn world(&self, uv: DVec2) -> DVec3 {
        self.origin + self.x * uv.x + self.y * uv.y
    }

    pub fn flat(&self, point: DVec3) -> DVec2 {
        let offset = point - self.origin;
        DVec2::new(offset.dot(self.x), offset.dot(self.y))
    }

    /// Distance (m) of a point from the plane.
    pub fn height(&self, point: DVec3) -> f64 {
        (point - self.origin).dot(self.x.cross(self.y))
    }
}

/// The visible part of a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// m
    pub centre: DVec2,
    /// m per point of the screen.
    pub scale: f64,
}

impl Window {
    /// With this size around a point (m) on a rectangle of the screen, plus a margin.
    pub fn around(centre: DVec2, size: DVec2, rect: Rect) -> Self {
        let scale =
            (size.x / f64::from(rect.width().max(1.0))).max(size.y / f64::from(rect.height().max(1.0)));
        Self { centre, scale: (scale * MARGIN).clamp(FINEST, COARSEST) }
    }
}

/// A window on a rectangle of the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    pub rect: Rect,
    pub window: Window,
}

impl Lens {
    pub fn screen(&self, uv: DVec2) -> Pos2 {
        let offset = (uv - self.window.centre) / self.window.scale;
        self.rect.center() + vec2(offset.x as f32, -offset.y as f32)
    }

    pub fn flat(&self, at: Pos2) -> DVec2 {
        let offset = at - self.rect.center();
        self.window.centre + DVec2::new(f64::from(offset.x), -f64::from(offset.y)) * self.window.scale
    }

    /// m
    pub fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.rect.width()), f64::from(self.rect.height())) * self.window.scale
    }

    /// The window zoomed about the pointer.
    pub fn zoomed(&self, at: Pos2, factor: f64) -> Window {
        let scale = (self.window.scale / factor).clamp(FINEST, COARSEST);
        let fixed = self.flat(at);
        Window { centre: fixed + (self.window.centre - fixed) * (scale / self.window.scale), scale }
    }

    pub fn moved(&self, by: Vec2) -> Window {
        let offset = DVec2::new(f64::from(by.x), -f64::from(by.y)) * self.window.scale;
        Window { centre: self.window.centre - offset, ..self.window }
    }
}

/// The view of the field; not part of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    pub cut: Cut,
    /// Positions of XY, XZ and YZ along their normals, m.
    pub heights: [f64; 3],
    pub free: FreePlane,
    /// `None`: fitted.
    pub window: Option<Window>,
    pub quantity: Quantity,
    pub colours: ColourMap,
    pub scale: Scale,
    /// Convention of pressures in the whole window.
    pub convention: Convention,
    /// The value of the last colour (Pa RMS, Pa or m); `None`: the largest value.
    pub full: Option<f64>,
    /// The value of the first colour of a linear scale with a given `full`; `None`: as in [`Colouring::low`].
    pub low: Option<f64>,
    /// The part of the largest value that gets the first colour of a logarithmic scale.
    pub floor: f64,
    /// Whether silence is white, as in print.
    pub is_light: bool,
    /// The brightness of a phase map follows the amplitude.
    pub fades: bool,
    /// The depression as a shaded relief instead of a map.
    pub shaded: bool,
    /// Side and height of that relief.
    pub relief: relief::Look,
    /// Whether contour lines are drawn.
    pub contours: bool,
    /// dB from the largest value to that one.
    pub contour_level: f64,
    /// Whether levels over the threshold have contour lines.
    pub threshold_contours: bool,
    /// The frequencies of the skin's motion in maps of the skin.
    pub channel: Channel,
    /// Focal points and outlines over the map.
    pub marks: bool,
    /// Whether the snap grid is shown and active.
    pub grid: bool,
    /// Whether dragged targets align with other targets and the array's axis.
    pub guides: bool,
    /// The array's elements in the colours of their phases.
    pub elements: bool,
    /// Whether the maximum and the peak side lobe are marked.
    pub extremes: bool,
    /// An adult's hand to scale.
    pub palm: bool,
    /// The curve along a line is shown.
    pub section: bool,
    /// Where.
    pub line: ProfileLine,
}

impl View {
    /// The plane of a scene.
    pub fn of(scene: &Scene) -> Self {
        let plane = &scene.plane;
        let mut view = Self {
            cut: Cut::Own,
            heights: [0.1, 0.0, 0.0],
            free: FreePlane { centre: plane.centre, tilt: FRAC_PI_4, turn: 0.0 },
            window: None,
            quantity: Quantity::Rms,
            colours: ColourMap::Inferno,
            scale: Scale::Linear,
            convention: Convention::Rms,
            full: None,
            low: None,
            floor: FLOOR.into(),
            is_light: false,
            fades: false,
            shaded: false,
            relief: relief::Look::default(),
            contours: false,
            contour_level: -6.0,
            threshold_contours: true,
            channel: Channel::All,
            marks: true,
            grid: false,
            guides: true,
            elements: false,
            extremes: false,
            palm: false,
            section: false,
            line: ProfileLine::Across(0.0),
        };
        let (x, y) = plane.axes().unwrap_or((DVec3::X, DVec3::Y));
        let lies = |a: DVec3, b: DVec3| x.dot(a) > 1.0 - 1e-9 && y.dot(b) > 1.0 - 1e-9;
        let cuts = [
            (Cut::Xy, DVec3::X, DVec3::Y, plane.centre.z),
            (Cut::Xz, DVec3::X, DVec3::Z, plane.centre.y),
            (Cut::Yz, DVec3::Y, DVec3::Z, plane.centre.x),
        ];
        for (index, (cut, x, y, height)) in cuts.into_iter().enumerate() {
            if lies(x, y) {
                view.cut = cut;
                view.heights[index] = height;
            }
        }
        if view.cut != Cut::Xy
            && let Some(target) = scene.targets.first()
        {
            view.heights[0] = outline::centre(&target.shape).z;
        }
        view.line = view.middle(scene);
        view
    }

    /// The line through the first visible target, or else through the centre of the scene plane.
    pub fn middle(&self, scene: &Scene) -> ProfileLine {
        let shown = scene.targets.iter().find(|target| target.visible);
        let at = shown.map_or(scene.plane.centre, |target| outline::centre(&target.shape));
        ProfileLine::Across(self.axes(scene).flat(at).y)
    }

    /// Position of the plane along its normal, m.
    pub fn height_mut(&mut self) -> Option<&mut f64> {
        match self.cut {
            Cut::Xy => Some(&mut self.heights[0]),
            Cut::Xz => Some(&mut self.heights[1]),
            Cut::Yz => Some(&mut self.heights[2]),
            Cut::Free | Cut::Own => None,
        }
    }

    pub fn axes(&self, scene: &Scene) -> Axes {
        let [z, y, x] = self.heights;
        match self.cut {
            Cut::Xy => Axes { origin: DVec3::new(0.0, 0.0, z), x: DVec3::X, y: DVec3::Y },
            Cut::Xz => Axes { origin: DVec3::new(0.0, y, 0.0), x: DVec3::X, y: DVec3::Z },
            Cut::Yz => Axes { origin: DVec3::new(x, 0.0, 0.0), x: DVec3::Y, y: DVec3::Z },
            Cut::Free => self.free.axes(),
            Cut::Own => {
                let (x, y) = scene.plane.axes().unwrap_or((DVec3::X, DVec3::Y));
                Axes { origin: scene.plane.centre, x, y }
            }
        }
    }

    /// Whether the plane is parallel to the array's.
    pub fn is_level(&self, scene: &Scene) -> bool {
        let axes = self.axes(scene);
        axes.x.cross(axes.y).z.abs() >= 1.0 - 1e-9
    }

    /// Whether the plane can show the quantity.
    pub fn suits(&self, scene: &Scene) -> bool {
        !self.quantity.declaration().of_liquid || self.is_level(scene)
    }

    /// The window on this rectangle of the screen: as it was set, or everything.
    pub fn lens(&self, scene: &Scene, rect: Rect) -> Lens {
        match self.window {
            Some(window) => Lens { rect, window },
            None => {
                let (centre, size) = self.whole(scene);
                Lens { rect, window: Window::around(centre, size, rect) }
            }
        }
    }

    /// Centre and size of the fitted view: the scene plane if displayed, otherwise the space above the array.
    pub fn whole(&self, scene: &Scene) -> (DVec2, DVec2) {
        let plane = &scene.plane;
        let of_plane = Self::of(scene).cut == self.cut;
        let axes = self.axes(scene);
        match self.cut {
            _ if of_plane => (axes.flat(plane.centre), plane.size),
            Cut::Free => (DVec2::ZERO, plane.size),
            Cut::Xy | Cut::Xz | Cut::Yz | Cut::Own if !scene.is_home() => around(scene, &axes),
            Cut::Xy | Cut::Own => (DVec2::ZERO, array_size(&scene.array) * 1.2),
            Cut::Xz | Cut::Yz => {
                let side = array_size(&scene.array).max_element() * 1.2;
                let top = scene
                    .targets
                    .iter()
                    .map(|target| outline::centre(&target.shape).z * 1.5)
                    .fold(side, f64::max);
                (DVec2::new(0.0, top / 2.0), DVec2::new(side, top))
            }
        }
    }

    /// The plane that fills the lens.
    pub fn plane(&self, scene: &Scene, lens: &Lens) -> Plane {
        let axes = self.axes(scene);
        Plane {
            centre: axes.world(lens.window.centre),
            x_axis: axes.x,
            y_axis: axes.y,
            size: if self.is_shaded() { relief_size(lens) } else { lens.size() },
            tolerance: scene.plane.tolerance,
        }
    }

    /// The scale of the colours: levels in dB have logarithms already.
    pub fn scale(&self) -> Scale {
        if self.quantity.declaration().is_level() { Scale::Linear } else { self.scale }
    }

    /// Over the whole range.
    pub fn colouring(&self) -> Colouring {
        Colouring {
            scale: self.scale(),
            floor: self.floor as f32,
            ..Colouring::new(self.quantity, self.table())
        }
    }

    /// The colours, for the ground that is chosen.
    pub fn table(&self) -> [[u8; 4]; 256] {
        self.colour_map().on(self.is_light)
    }

    /// Colouring of the RMS pressure as a veil over a phase map, if brightness follows it.
    pub fn veil(&self) -> Option<Colouring> {
        let is_wanted = self.fades && self.quantity.declaration().range == Range::Cyclic;
        is_wanted.then(|| Colouring::new(Quantity::Rms, veil(self.is_light)))
    }

    /// Colours over the whole range of the map.
    pub fn forget_range(&mut self) {
        (self.full, self.low) = (None, None);
    }

    /// The colour map: sequential, cyclic or diverging.
    pub fn colour_map(&self) -> ColourMap {
        map::colours(self.quantity, self.colours)
    }

    /// Whether a liquid is shown as a shaded relief.
    pub fn is_shaded(&self) -> bool {
        self.shaded && self.quantity.declaration().is_surface()
    }

    /// Levels of the contour lines (dB), as [`map::contour`] has them; empty without contours.
    pub fn contour_levels(&self) -> &[f64] {
        let declaration = self.quantity.declaration();
        match declaration.is_level() {
            true if self.threshold_contours => &map::OVER_THRESHOLD,
            false if self.contours && declaration.has_mean && !self.is_shaded() => {
                std::slice::from_ref(&self.contour_level)
            }
            true | false => &[],
        }
    }
}

/// The size (m) of a surface that fills the screen as a relief.
fn relief_size(lens: &Lens) -> DVec2 {
    let [width, height] = [lens.rect.width(), lens.rect.height()].map(|side| side.max(1.0) as usize);
    Place::on_screen(width, height, [0; 3]).filled(lens.size().x)
}

/// Centre and size of all boards and targets, with a margin.
fn around(scene: &Scene, axes: &Axes) -> (DVec2, DVec2) {
    let placed = scene.array.places();
    let boards = scene.standing();
    let elements = boards.iter().flat_map(|board| placed.iter().map(|it| board.world(it.at)));
    let targets = scene.targets.iter().map(|target| outline::centre(&target.shape));
    let flat = elements.chain(targets).map(|place| axes.flat(place));
    let (low, high) =
        flat.fold((DVec2::MAX, DVec2::MIN), |(low, high), place| (low.min(place), high.max(place)));
    ((low + high) / 2.0, (high - low + 4.0 * scene.array.element_half()) * 1.1)
}

/// m, over all elements.
pub fn array_size(array: &Array) -> DVec2 {
    DVec2::new(f64::from(array.columns), f64::from(array.rows)) * array.pitch
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    #[test]
    fn the_screen_and_the_cut_are_each_others_inverse_and_zooming_keeps_the_pointer() {
        let scene = Scene::default();
        let rect = Rect::from_min_size(pos2(40.0, 20.0), vec2(800.0, 500.0));
        for &cut in Cut::VARIANTS {
            let view = View { cut, ..View::of(&scene) };
            let lens = view.lens(&scene, rect);
            let at = pos2(333.0, 111.0);
            assert!(lens.screen(lens.flat(at)).distance(at) < 1e-2);
            let nearer = Lens { window: lens.zoomed(at, 2.5), ..lens };
            assert!(nearer.flat(at).distance(lens.flat(at)) < 1e-12);
            let axes = view.axes(&scene);
            let uv = DVec2::new(0.012, 0.034);
            assert!(axes.flat(axes.world(uv)).distance(uv) < 1e-15 && axes.height(axes.world(uv)) < 1e-15);
        }
    }

    #[test]
    fn a_free_plane_lies_as_its_angles_say() {
        let free = |tilt: f64, turn: f64| {
            let centre = DVec3::new(0.01, 0.02, 0.1);
            FreePlane { centre, tilt: tilt.to_radians(), turn: turn.to_radians() }.axes()
        };
        let near = |a: DVec3, b: DVec3| a.distance(b) < 1e-12;
        for (tilt, turn, x, y) in [
            (0.0, 0.0, DVec3::X, DVec3::Y),
            (90.0, 0.0, DVec3::X, DVec3::Z),
            (90.0, 90.0, DVec3::Y, DVec3::Z),
            (30.0, 180.0, -DVec3::X, DVec3::new(0.0, -(0.75f64.sqrt()), 0.5)),
        ] {
            let axes = free(tilt, turn);
            assert!(near(axes.x, x) && near(axes.y, y), "{tilt}° {turn}°: {axes:?}");
        }
    }

    #[test]
    fn contours_of_pressure_and_of_its_square_are_at_the_same_place() {
        let view = View { contours: true, ..View::of(&Scene::default()) };
        let lines = |view: &View, quantity| {
            let view = View { quantity, ..view.clone() };
            view.contour_levels()
                .iter()
                .map(|level| map::contour(quantity, *level, 100.0))
                .collect::<Vec<_>>()
        };
        let of_pressure = lines(&view, Quantity::Rms)[0] / 100.0;
        assert!((of_pressure - 0.501).abs() < 1e-3);
        assert!((lines(&view, Quantity::Radiation)[0] / 100.0 - of_pressure.powi(2)).abs() < 1e-12);
        assert!(lines(&view, Quantity::Phase).is_empty() && lines(&view, Quantity::Instantaneous).is_empty());
        assert!(lines(&View { shaded: true, ..view.clone() }, Quantity::Depression).is_empty());
        assert_eq!(lines(&View { contours: false, ..view }, Quantity::Felt), [0.0, 10.0, 20.0], "always");
    }

    #[test]
    fn everything_is_in_the_first_view() {
        let scene = Scene::default();
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(640.0, 480.0));
        let lens = View::of(&scene).lens(&scene, rect);
        for corner in [scene.plane.size / 2.0, -scene.plane.size / 2.0] {
            assert!(rect.contains(lens.screen(corner)));
        }
        let plane = View::of(&scene).plane(&scene, &lens);
        assert!(plane.size.x > scene.plane.size.x && plane.centre == scene.plane.centre);
    }
}
