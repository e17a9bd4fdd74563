//! The drives of all frames of a cycle, with what the user should know of them.

use crate::acoustics::Aperture;
use crate::picture::sheet::pascals;
use crate::scene::{MotionPath, Pressures, Scene};
use crate::solver;
use crate::solver::frames::{self, Frame, Sequence};
use crate::studio::output::{note, warn};

/// Solves all frames and passes on what the user should know; `name` tells whose they are.
///
/// # Errors
/// A scene that cannot be solved.
pub fn follow(scene: &Scene, name: &str) -> anyhow::Result<Sequence> {
    if scene.motion.path == MotionPath::None && scene.solver.frames == 1 {
        note("nothing moves: `path` in [motion] is \"none\", so there is one frame");
    }
    let sequence = frames::follow(scene).map_err(|error| anyhow::anyhow!("{name}: {error}"))?;
    for warning in solver::warnings(&Aperture::new(scene), &sequence.frames[0].foci) {
        warn(&format!("in the first frame, {warning}"));
    }
    if scene.solver.pressures == Pressures::Pascal {
        warn_of_shortfall(&sequence);
    }
    Ok(sequence)
}

/// Says how much of the pascals asked for the worst frame gets.
fn warn_of_shortfall(sequence: &Sequence) {
    let asked =
        |frame: &Frame| frame.foci.iter().map(|focus| focus.target).sum::<f64>() / frame.foci.len() as f64;
    let part = |frame: &Frame| frame.mean_pressure() / asked(frame);
    if let Some(worst) = sequence.frames.iter().min_by(|a, b| part(a).total_cmp(&part(b)))
        && part(worst) < 0.999
    {
        warn(&format!(
            "in the worst frame the foci are to get {} (mean, peak), and full drive brings them {}",
            pascals(asked(worst)),
            pascals(worst.mean_pressure())
        ));
    }
}
