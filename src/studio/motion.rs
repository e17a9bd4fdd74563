//! The drives of all frames of a cycle, with warnings.

use crate::acoustics::Aperture;
use crate::gauge::Gauge;
use crate::rounding::pascals;
use crate::scene::{Motion, Pressures, Scene, motion};
use crate::solver::frames::{self, Frame, Sequence};
use crate::solver::{warning_of_drive, warnings_of_foci};
use crate::studio::output::{note, warn};

/// Name of the solving step in progress messages.
pub const SOLVING: &str = "the drives of all frames";

/// Solves all frames and prints warnings; `name` is the scene's name.
///
/// # Errors
/// A scene that cannot be solved.
pub fn follow(scene: &Scene, name: &str, progress: &Gauge) -> anyhow::Result<Sequence> {
    let sequence =
        frames::follow_with(scene, progress).map_err(|error| anyhow::anyhow!("{name}: {error}"))?;
    if !motion::moves(scene) && sequence.frames.len() == 1 {
        note(&format!("nothing moves: {}, so there is one frame", at_rest(scene)));
    }
    remarks(scene).iter().for_each(|remark| warn(remark));
    warning_of_drive(scene).iter().for_each(|warning| warn(&warning.to_string()));
    for warning in warnings_of_foci(&Aperture::new(scene), &sequence.frames[0].foci) {
        warn(&format!("in the first frame, {warning}"));
    }
    if scene.solver.pressures == Pressures::Pascal && !scene.drive.is_named() {
        warn_of_shortfall(&sequence);
    }
    warn_of_rates(scene);
    Ok(sequence)
}

/// The reason why nothing moves.
pub fn at_rest(scene: &Scene) -> &'static str {
    match scene.drive.is_named() {
        true => "the file of the drive has a single one, or drives without times",
        false => "`path` in [motion] is \"none\"",
    }
}

/// Remarks on the files of paths.
pub fn remarks(scene: &Scene) -> Vec<String> {
    let shown = scene.targets.iter().filter(|target| target.visible);
    let own = shown.filter_map(|target| target.motion.as_ref());
    own.chain([&scene.motion]).flat_map(Motion::remarks).collect()
}

/// Warns of targets with a rate other than requested.
fn warn_of_rates(scene: &Scene) {
    /// Relative: neither seen nor felt.
    const APART: f64 = 1e-3;
    let Some(cycle) = motion::cycle(scene) else { return };
    for group in &cycle.groups {
        let (asked, played) = (group.asked(), cycle.played(group));
        if let Some(target) = group.target.filter(|_| (played / asked - 1.0).abs() > APART) {
            warn(&format!(
                "target {} makes {played:.3} rounds per second instead of {asked:.3}: the common cycle of {:.3} per second holds a \
                 whole number of its rounds, {}",
                target + 1,
                group.rounds,
                cycle.rate
            ));
        }
    }
}

/// Warns of frames that do not reach their targets in pascals.
fn warn_of_shortfall(sequence: &Sequence) {
    let asked =
        |frame: &Frame| frame.foci.iter().map(|focus| focus.target).sum::<f64>() / frame.foci.len() as f64;
    let part = |frame: &Frame| frame.mean_pressure() / asked(frame);
    let heard = sequence.frames.iter().filter(|frame| asked(frame) > 0.0);
    if let Some(worst) = heard.min_by(|a, b| part(a).total_cmp(&part(b)))
        && part(worst) < 0.999
    {
        warn(&format!(
            "in the worst frame the foci need {} (mean, peak), but full drive reaches {}",
            pascals(asked(worst)),
            pascals(worst.mean_pressure())
        ));
    }
}
