//! One map to be made: its request, and what all stages may need.

use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use crate::field::Quantity;
use crate::field::quantity::Constants;
use crate::field::stages::Request;
use crate::field::stages::probes::Probes;
use crate::field::stages::site::{Frame, Site, SiteKey};
use crate::field::vicinity::LeftOut;

/// Everything that a stage may need.
pub(super) struct Job<'a> {
    pub(super) request: &'a Request,
    pub(super) key: &'a SiteKey,
    pub(super) site: &'a Site,
    pub(super) frame: &'a Frame,
    /// The pixels that do not count for the peak.
    pub(super) left_out: &'a LeftOut,
    pub(super) probes: &'a Probes,
    /// The pixels within bodies, ascending.
    pub(super) within: &'a [usize],
    /// Where the sound presses on the skin of bodies, at every cell; empty if it presses on the plane.
    pub(super) skin: &'a [Option<DVec3>],
    /// Excitations u of every element, for each drive that counts.
    pub(super) excitations: &'a Arc<Vec<Vec<Complex64>>>,
}

/// The inputs of the means at the cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FormedKey {
    site: SiteKey,
    quantity: Quantity,
    excitations: Arc<Vec<Vec<Complex64>>>,
    constants: Constants<f64>,
    pub(super) double: bool,
}

impl FormedKey {
    pub(super) fn new(job: &Job<'_>, double: bool) -> Self {
        Self {
            site: job.key.clone(),
            quantity: job.request.quantity.pressed_by(),
            excitations: Arc::clone(job.excitations),
            constants: job.request.constants(),
            double,
        }
    }
}
