//! The places of a map that are within bodies, and the skin of bodies on its plane.

use glam::DVec3;
use rayon::prelude::*;

use crate::acoustics::Aperture;
use crate::field::raster::Raster;
use crate::field::samples::Samples;
use crate::scene::Plane;

/// Distance (m) of a body's skin from the plane up to which it is the skin on the plane, and from it of the sound there.
const BESIDE: f64 = 1e-3;
const JUST_OUTSIDE: f64 = 1e-5;

/// The pixels of a frame that are within bodies.
pub(super) fn within(aperture: &Aperture, raster: &Raster) -> Vec<usize> {
    let Some(bodies) = aperture.bodies.bodies() else { return Vec::new() };
    let pixels = raster.pixels();
    (0..pixels.len()).into_par_iter().filter(|&pixel| bodies.contains(pixels.point(pixel))).collect()
}

/// The pixels of a map from cells that are within bodies. Skin within a body's is that of the body.
pub(super) fn within_cells(
    aperture: &Aperture,
    (plane, [x, y, normal]): (&Plane, [DVec3; 3]),
    (width, height): (usize, usize),
    of_skin: bool,
) -> Vec<usize> {
    let Some(bodies) = aperture.bodies.bodies() else { return Vec::new() };
    let along = |index: usize, count: usize| (index as f64 + 0.5) / count as f64 - 0.5;
    let is_within = |pixel: &usize| {
        let [x_part, y_part] = [along(pixel % width, width), along(pixel / width, height)];
        let at = plane.centre + x * (plane.size.x * x_part) + y * (plane.size.y * y_part);
        match of_skin {
            true => [-BESIDE, BESIDE].iter().all(|way| bodies.contains(at + normal * *way)),
            false => bodies.contains(at),
        }
    };
    (0..width * height).into_par_iter().filter(is_within).collect()
}

/// Where the sound presses on the skin of bodies that lies on a plane with a normal, at some of its places: just outside
/// the body, `None` elsewhere. Empty if no skin lies on the plane.
pub(super) fn skin(aperture: &Aperture, places: &Samples, normal: DVec3) -> Vec<Option<DVec3>> {
    let Some(bodies) = aperture.bodies.bodies() else { return Vec::new() };
    let on_skin = |place: usize| {
        let at = places.point(place);
        let is_in = |way: f64| bodies.contains(at + normal * way);
        let [mut outside, mut inside] = match [-BESIDE, BESIDE].map(is_in) {
            [false, true] => [-BESIDE, BESIDE],
            [true, false] => [BESIDE, -BESIDE],
            [true, true] | [false, false] => return None,
        };
        while (outside - inside).abs() > JUST_OUTSIDE {
            let middle = f64::midpoint(outside, inside);
            if is_in(middle) { inside = middle } else { outside = middle }
        }
        Some(at + normal * outside)
    };
    let skin: Vec<_> = (0..places.len()).into_par_iter().map(on_skin).collect();
    if skin.iter().any(Option::is_some) { skin } else { Vec::new() }
}
