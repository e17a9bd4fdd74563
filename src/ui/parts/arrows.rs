//! Arrows over the map: the vectors of the displayed quantity in its plane, or the force on the scene's bead.

use egui::{Color32, Painter, Stroke, Vec2, vec2};
use glam::{DVec2, DVec3};

use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::scene::{Bead, Scene};
use crate::studio::vectors::{self, Vector};
use crate::ui::part::{Now, Part};
use crate::ui::view::{Axes, Lens};

/// Points of the screen from arrow to arrow, and of the longest.
const APART: f32 = 26.0;
const LONGEST: f32 = 23.0;
/// Points of the screen; shorter ones are dots.
const SHORTEST: f32 = 3.0;
const INK: Color32 = Color32::from_rgb(250, 250, 250);
const EDGE: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 150);

/// Display of the arrows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arrows {
    /// Of the force on the bead.
    pub is_shown: bool,
    /// Of the displayed quantity, if it has a vector.
    pub is_of_quantity: bool,
}

/// The drives, the bead, and the positions of the arrows.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    vector: Vector,
    air: Air,
    bead: Bead,
    aperture: Aperture,
    drives: Vec<Drive>,
    /// Of the plane.
    axes: [DVec3; 2],
    /// m
    places: Vec<DVec3>,
}

/// Vectors at points (m) of the plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    pub places: Vec<DVec3>,
    pub vectors: Vec<DVec3>,
}

impl Part for Arrows {
    type Input = Input;
    type Output = Field;

    fn input(&self, now: &Now<'_>) -> Option<Input> {
        let of_quantity = Vector::of(now.view.quantity).filter(|_| self.is_of_quantity);
        let vector = of_quantity.or_else(|| self.is_shown.then_some(Vector::Force))?;
        let lens = now.lens.filter(|_| !now.view.is_shaded())?;
        let sound = now.sound?;
        let axes = now.view.axes(now.scene);
        Some(Input {
            vector,
            air: sound.air,
            bead: sound.bead.clone(),
            aperture: sound.aperture.clone(),
            drives: sound.heard.clone(),
            axes: [axes.x, axes.y],
            places: places(now.scene, &axes, lens),
        })
    }

    fn computation(&self) -> impl FnOnce(&Input) -> Field + Send + 'static {
        |Input { vector, air, bead, aperture, drives, axes, places }| Field {
            vectors: vector.at((aperture, air, bead), drives, *axes, places),
            places: places.clone(),
        }
    }
}

/// Positions of arrows (m) on the visible part of the plane, in front of the array.
fn places(scene: &Scene, axes: &Axes, lens: &Lens) -> Vec<DVec3> {
    let count = [lens.rect.width(), lens.rect.height()].map(|side| ((side / APART) as i32 / 2).max(1));
    let at = |i: i32, j: i32| {
        let offset = vec2(i as f32, j as f32) * APART;
        axes.world(lens.flat(lens.rect.center() + offset))
    };
    let rows = (-count[1]..=count[1]).flat_map(|j| (-count[0]..=count[0]).map(move |i| (i, j)));
    let lowest = scene.wavelength() / 2.0;
    let is_home = scene.is_home();
    rows.map(|(i, j)| at(i, j)).filter(|place| !is_home || place.z > lowest).collect()
}

pub fn paint(arrows: &Field, axes: &Axes, painter: &Painter, lens: &Lens) {
    let along = |vector: &DVec3| DVec2::new(vector.dot(axes.x), vector.dot(axes.y));
    let flat: Vec<_> = arrows.vectors.iter().map(along).collect();
    let usual = vectors::usual(&flat);
    if usual == 0.0 {
        return;
    }
    for (place, vector) in arrows.places.iter().zip(&flat) {
        // Roots, so that weak vectors have a direction too.
        let size = LONGEST * vectors::part(*vector, usual) as f32;
        let way = vector.normalize_or_zero();
        let way = vec2(way.x as f32, -way.y as f32);
        let middle = lens.screen(axes.flat(*place));
        if size < SHORTEST || way == Vec2::ZERO {
            painter.circle_filled(middle, 1.2, INK);
            continue;
        }
        let (tail, tip) = (middle - way * size / 2.0, middle + way * size / 2.0);
        let head = 0.36 * size.max(9.0);
        let wings = [0.5f32, -0.5].map(|side| tip - way * head + way.rot90() * (side * head));
        for (width, colour) in [(3.2, EDGE), (1.3, INK)] {
            let stroke = Stroke::new(width, colour);
            painter.line_segment([tail, tip], stroke);
            painter.line(vec![wings[0], tip, wings[1]], stroke);
        }
    }
}
