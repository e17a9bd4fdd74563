//! Radiation pressure of sound that grazes the plane, where the squares of pressure and slopes almost cancel, against
//! the closed form of a point source.

use glam::{DVec2, dvec3};
use sonoglyph::acoustics::{Air, Aperture};
use sonoglyph::drive::Drive;
use sonoglyph::field::plan::promised;
use sonoglyph::field::{Quantity, Request, Samples, Stages};
use sonoglyph::scene::{Array, ElementModel, Plane, Scene};

use crate::evaluators;

/// |P|²/(ρc²) - |∇P|²/(ρω²) along the plane, of S e^{-(α + jk)r}/r: with (∂P/∂r)² = |P|² ((α + 1/r)² + k²) and
/// cosθ = z/r, |P|²/(ρc²) (cos²θ - sin²θ (α + 1/r)²/k²).
fn closed(aperture: &Aperture, air: &Air, pixels: &Samples) -> Vec<f64> {
    let (element, source) = (&aperture.element, aperture.positions[0]);
    let at = |pixel: usize| {
        let way = pixels.point(pixel) - source;
        let r = way.length();
        let cos2 = (way.z / r).powi(2);
        let square = (element.strength * (-element.attenuation * r).exp() / r).powi(2);
        let falling = ((element.attenuation + 1.0 / r) / element.wavenumber).powi(2);
        square / (air.density * air.sound_speed.powi(2)) * (cos2 - (1.0 - cos2) * falling)
    };
    (0..pixels.len()).map(at).collect()
}

#[test]
fn grazing_radiation_is_that_of_the_closed_form() {
    const SIZE: (usize, usize) = (40, 32);
    let array = Array { rows: 1, columns: 1, element: ElementModel::Point, ..Array::default() };
    let mut stages: Vec<_> = evaluators().into_iter().map(Stages::new).collect();
    for (at, tolerance) in [
        (dvec3(0.5, 0.0, 0.004), 0.0),
        (dvec3(0.5, 0.0, 0.004), 1e-3),
        (dvec3(-0.3, 0.9, 0.001), 0.0),
        (dvec3(0.4, 0.3, 0.02), 0.0),
        (dvec3(0.4, 0.3, 0.02), 1e-3),
        (dvec3(0.01, 0.0, 0.03), 0.0),
    ] {
        let plane = Plane { centre: at, size: DVec2::splat(0.01), tolerance, ..Plane::default() };
        let scene = Scene { array: array.clone(), plane, ..Scene::default() };
        let pixels = Samples::on_plane(&scene.plane, SIZE.0, SIZE.1).unwrap();
        for count in [1, 3] {
            let drives = vec![Drive { amplitudes: vec![1.0], phases: vec![0.4] }; count];
            let request = Request::new(&scene, drives, Quantity::Radiation, SIZE);
            let expected = closed(&request.aperture, &request.air, &pixels);
            let peak = expected.iter().fold(0.0f64, |most, value| most.max(value.abs()));
            for stages in &mut stages {
                let map = stages.map(&request).unwrap();
                let off =
                    map.values.iter().zip(&expected).map(|(&got, value)| (f64::from(got) - value).abs());
                let off = off.fold(0.0, f64::max) / peak;
                let name = format!("{at}, {tolerance:e}, {count} by {:?}: {off:e}, {}", map.by, map.how);
                assert!(off <= promised(tolerance), "{name}");
                assert!(
                    off <= map.error && map.error <= promised(tolerance),
                    "{name}, stated {:e}",
                    map.error
                );
            }
        }
    }
}
