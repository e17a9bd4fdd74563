//! The response of a liquid at rest to a pressure on a grid: its depression relative to that under uniform pressure.

use crate::scene::Liquid;
use crate::solver::shape::grid::Layout;
use crate::solver::shape::real::Real;
use crate::surface::dent::{Tank, compliance};

/// A symmetric linear map: division of cosine modes by 1 + q² σ/(ρ g).
#[derive(Clone, Debug)]
pub struct Response {
    tank: Tank,
    /// Factor of every mode.
    factors: Vec<f64>,
    /// Indices of the samples in a field, row by row of the plane.
    places: Vec<usize>,
}

impl Response {
    /// The response at samples of a plane, with walls half a sample outside the outermost.
    pub fn new(liquid: &Liquid, layout: &Layout, pitch: f64) -> Self {
        let counts = layout.samples.map(|samples| samples * layout.grids);
        let tank = Tank::new(counts, [layout.spacing(pitch); 2]);
        let level = compliance(liquid, 0.0);
        let factors = tank.squares().map(|square| compliance(liquid, square) / level).collect();
        Self { tank, factors, places: layout.rows() }
    }

    /// Replaces values at the samples, in the layout of a field, by the response to them; padding stays 0.
    pub fn apply<T: Real>(&mut self, values: &mut [T]) {
        let pressure: Vec<_> = self.places.iter().map(|&place| values[place].wide()).collect();
        let mut modes = self.tank.modes(&pressure);
        modes.iter_mut().zip(&self.factors).for_each(|(mode, factor)| *mode *= factor);
        values.fill(T::default());
        for (&place, depth) in self.places.iter().zip(self.tank.surface(modes)) {
            values[place] = T::of(depth);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::Scene;
    use crate::solver::starts::scatter;

    fn layout() -> (Layout, Aperture) {
        let aperture = Aperture::new(&Scene::default());
        (Layout::new(&aperture, 0.1, DVec2::new(0.05, 0.03), 3), aperture)
    }

    #[test]
    fn an_even_pressure_stays_and_a_wave_falls_by_its_wavenumber() {
        let (layout, aperture) = layout();
        let liquid = Liquid::default();
        let mut response = Response::new(&liquid, &layout, aperture.pitch);
        let capillary = liquid.surface_tension() / (liquid.density() * liquid.gravity);
        let width = layout.spacing(aperture.pitch) * (layout.samples[0] * layout.grids) as f64;
        for half_waves in [0.0, 1.0, 6.0] {
            let q = std::f64::consts::PI * half_waves / width;
            let mut values = vec![0.0; layout.len()];
            let wave = |place: DVec2| (q * (place.x + width / 2.0)).cos();
            layout.places(aperture.pitch).for_each(|(index, place)| values[index] = wave(place));
            response.apply(&mut values);
            for (index, place) in layout.places(aperture.pitch) {
                let expected = wave(place) / (1.0 + capillary * q * q);
                assert!((values[index] - expected).abs() < 1e-12, "{half_waves}, {place}");
            }
        }
    }

    #[test]
    fn it_is_its_own_transpose() {
        let (layout, aperture) = layout();
        let mut response = Response::new(&Liquid::default(), &layout, aperture.pitch);
        let mut values = |seed: usize| {
            let mut values = vec![0.0; layout.len()];
            layout.places(aperture.pitch).for_each(|(index, _)| values[index] = scatter(index + seed) - 0.5);
            let mut answer = values.clone();
            response.apply(&mut answer);
            (values, answer)
        };
        let ((a, of_a), (b, of_b)) = (values(1), values(1000));
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((product(&a, &of_b) - product(&of_a, &b)).abs() < 1e-12 * product(&a, &of_a));
    }
}
