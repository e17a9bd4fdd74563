//! Radiation force and torque on a scene's bodies, with the error of what they scatter.

use glam::DVec3;
use serde_json::{Value, json};

use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::field::Quantity;
use crate::force::Push;
use crate::rounding::percent_at_most;
use crate::scene::{BodyKind, Scene};

/// Drives, at most, whose errors are compared: those of others in turn are alike.
const MOST_DRIVES: usize = 4;

/// A body in the sound of drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pushed {
    pub kind: BodyKind,
    pub push: Push,
    /// Bound on the error of the sound that it scatters, relative to that on its surface; 0 by a series.
    pub error: f64,
    /// Bound on the error of the pressure on its surface, relative to it.
    pub surface_error: f64,
    /// 0 of a sphere, whose sound is a series.
    pub triangles: usize,
}

/// All bodies of a scene, in the mean of drives in turn.
pub fn pushed(scene: &Scene, aperture: &Aperture, drives: &[Drive]) -> Vec<Pushed> {
    let Some(bodies) = aperture.bodies.bodies() else { return Vec::new() };
    let air = Air::new(&scene.medium, scene.array.frequency);
    let pushes = Push::on_bodies(aperture, &air, drives);
    let mut all: Vec<_> = aperture
        .bodies
        .of()
        .iter()
        .zip(pushes)
        .zip(bodies.triangles_of_each())
        .map(|((body, push), triangles)| Pushed {
            kind: body.kind,
            push,
            error: 0.0,
            surface_error: 0.0,
            triangles,
        })
        .collect();
    for drive in drives.iter().take(MOST_DRIVES) {
        let errors = aperture.body_errors(&drive.excitation(&aperture.driven));
        for (body, error) in all.iter_mut().zip(errors) {
            body.error = body.error.max(error.outside);
            body.surface_error = body.surface_error.max(error.surface);
        }
    }
    all
}

/// The array that `solve --json` writes under `bodies`.
pub fn json(all: &[Pushed]) -> Value {
    all.iter().map(Pushed::json).collect()
}

/// The warning about bodies that the memory does not hold.
pub fn warning(aperture: &Aperture) -> Option<String> {
    aperture.bodies.check().err().map(|error| format!("{error}; until then bodies scatter nothing"))
}

impl Pushed {
    /// In N and N m.
    pub fn json(&self) -> Value {
        json!({
            "kind": <&str>::from(self.kind),
            "force": self.push.force.to_array(),
            "torque": self.push.torque.to_array(),
            "force_error": self.force_error(),
            "error": self.error,
            "surface_error": self.surface_error,
            "triangles": self.triangles,
        })
    }

    /// N, twice the error of the pressure on all that presses.
    fn force_error(&self) -> f64 {
        2.0 * self.surface_error * self.push.gross
    }

    /// Force, torque and error, as text.
    pub fn words(&self) -> String {
        let Push { force, torque, .. } = self.push;
        let (factor, unit) = Quantity::Force.declaration().unit.scaled(force.length());
        let turning = torque.length();
        let (per_torque, of_torque) = if turning >= 1e-9 { (1e9, "nN m") } else { (1e12, "pN m") };
        let parts = |vector: DVec3| vector.to_array().map(|part| format!("{part:.3}"));
        let ([x, y, z], [a, b, c]) = (parts(force * factor), parts(torque * per_torque));
        let how = match self.triangles {
            0 => "exact series".to_owned(),
            count => {
                let off = Quantity::Force.at_most(self.force_error());
                format!("{count} triangles, force within {off}, {}", within(self.error))
            }
        };
        format!("force ({x}, {y}, {z}) {unit}, torque ({a}, {b}, {c}) {of_torque}; {how}")
    }
}

/// The bound on what all bodies scatter, beside a map; `None` without bodies.
pub fn remark(scene: &Scene, aperture: &Aperture, drives: &[Drive]) -> Option<String> {
    let all = pushed(scene, aperture, &drives[..drives.len().min(1)]);
    let worst = all.iter().map(|body| body.error).fold(0.0, f64::max);
    let how = if worst > 0.0 { within(worst) } else { "scattered sound by exact series".to_owned() };
    (!all.is_empty()).then(|| format!("bodies: {how}"))
}

fn within(error: f64) -> String {
    format!("scattered sound within {}", percent_at_most(error, 1))
}
