//! The input of a method, and its result before amplitudes are made uniform.

use std::ops::RangeInclusive;

use num_complex::Complex64;

use crate::acoustics::{Aperture, Transfer};
use crate::scene::{Focus, Scene};
use crate::solver::shape::surroundings::Surroundings;
use crate::solver::trap::traps::Traps;

/// The input of a method.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    pub aperture: &'a Aperture,
    pub foci: Vec<Focus>,
    /// Foci x driven elements.
    pub transfer: Transfer,
    /// The quiet region and areas, if the foci are samples of a shape.
    #[doc(hidden)]
    pub surroundings: Option<Surroundings>,
    /// The traps whose lobes are among the foci: traps have one solution for all methods.
    #[doc(hidden)]
    pub traps: Option<Traps>,
    /// Numbers of drives in turn of a drag's frame and of a whole search; more than 1 for shapes only.
    pub drives: RangeInclusive<usize>,
}

impl<'a> Problem<'a> {
    /// The foci of [`crate::scene::outline::foci`], or others like them.
    ///
    /// # Panics
    /// No foci, a focus beyond 1000 km or NaN, or a target that is not positive.
    pub fn new(aperture: &'a Aperture, foci: Vec<Focus>) -> Self {
        /// Limit of a focus' distance from the origin, m.
        const FARTHEST: f64 = 1e6;
        assert!(!foci.is_empty(), "a problem needs a focus");
        for Focus { position, target, .. } in &foci {
            assert!(position.is_finite() && position.abs().max_element() <= FARTHEST, "no focus: {position}");
            assert!(target.is_finite() && *target > 0.0, "no target: {target}");
        }
        Self {
            aperture,
            transfer: aperture.transfer_to(&foci),
            foci,
            surroundings: None,
            traps: None,
            drives: 1..=1,
        }
    }

    /// The problem of a scene, with surroundings if it has continuous strokes, quiet zones or drives in turn.
    pub fn of_scene(scene: &Scene, aperture: &'a Aperture, foci: Vec<Focus>) -> Self {
        let drives = scene.drives_in_turn();
        let is_shape = !scene.quiet.is_empty()
            || *drives.start() > 1
            || scene.aims_at_depression()
            || foci.iter().any(|focus| !focus.is_separate());
        let surroundings = is_shape.then(|| Surroundings::new(scene, &foci));
        let traps = Traps::of_scene(scene, aperture, &foci);
        Self { surroundings, traps, drives, ..Self::new(aperture, foci) }
    }

    /// Adds surroundings to foci of shapes and separate foci: `best` is then [`crate::solver::shape::best`].
    #[doc(hidden)]
    pub fn with_surroundings(self, surroundings: Surroundings) -> Self {
        Self { surroundings: Some(surroundings), ..self }
    }

    /// Target pressure of every focus: ratios, or Pa (peak).
    pub fn targets(&self) -> Vec<f64> {
        self.foci.iter().map(|focus| focus.target).collect()
    }
}

/// A method's drive of the elements, before amplitudes are made uniform.
#[derive(Clone, Debug)]
pub struct Excitation {
    /// u of each driven element, to any scale; several drives in turn are concatenated.
    pub values: Vec<Complex64>,
    pub iterations: u32,
    /// ‖H u - p‖/‖p‖ for methods that prescribe the complex p.
    pub residual: Option<f64>,
    /// Levelling weights of the foci, if the method has any, for [`crate::solver::excite_from`].
    pub weights: Option<Vec<f64>>,
}
