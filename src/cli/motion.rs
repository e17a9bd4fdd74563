//! `sonoglyph solve --motion`: drives and quality of all frames of a cycle, as a table, JSON or CSV.

use std::io::{BufWriter, Write};

use anyhow::bail;

use crate::cli::progress;
use crate::cli::scene::{COLUMN, Source, read_scene};
use crate::cli::solve::{Methods, SolveArgs};
use crate::rounding::{millimetres, milliseconds, pascals};
use crate::scene::motion::{Cycle, Group};
use crate::scene::{Scene, motion};
use crate::solver::frames::Sequence;
use crate::studio::felt::{self, Felt};
use crate::studio::frames::{Summary, playable, write_csv, write_json};
use crate::studio::motion::{SOLVING, follow};
use crate::studio::output::{self, Files, say, warn};
use crate::studio::response::Moving;

/// m/s of a focus that feels strongest, about the speed of waves on skin (Frier et al. 2018).
const FELT_MOST: (f64, f64) = (5.0, 8.0);

pub fn run(args: &SolveArgs) -> anyhow::Result<()> {
    let method = match args.method {
        Some(Methods::All) => bail!("--motion follows one solution from frame to frame: name one method"),
        Some(Methods::One(method)) => Some(method),
        None => None,
    };
    let mut files = Files::new();
    let scene = read_scene(&args.scene, Source { method, drive: None }, &mut files)?;
    if let Some(path) = &args.csv {
        files.writes(path)?;
    }
    let sequence = follow(&scene, &args.scene.display().to_string(), &progress::begin(SOLVING))?;
    warn_of_rate(&scene);
    let felt = Felt::of_sequence(&scene, &sequence);
    if let Some(Ok(felt)) = &felt {
        felt.warnings(&scene, &[]).iter().for_each(|warning| warn(warning));
    }
    if let Some(path) = &args.csv {
        output::write_by(path, |file| Ok(write_csv(file, &scene, &sequence)?))?;
    }
    if args.json {
        let mut out = BufWriter::new(output::standard()?);
        let felt = felt.as_ref().and_then(|felt| felt.as_ref().ok());
        write_json(&mut out, &scene, &sequence, felt).and_then(|()| out.flush()).map_err(output::unsaid)?;
    } else {
        print(&scene, &sequence, felt::rows(felt.as_ref()))?;
    }
    Ok(())
}

fn warn_of_rate(scene: &Scene) {
    let carrier = scene.array.frequency;
    let rate = motion::cycle(scene).map(|cycle| cycle.frames_per_second());
    if let Some(rate) = rate.filter(|&rate| rate > carrier) {
        warn(&format!(
            "{rate:.0} frames/s are more than the {carrier:.0} carrier periods per second: \
             take fewer frames or a lower rate"
        ));
    }
}

fn print(scene: &Scene, sequence: &Sequence, felt: Vec<(&'static str, String)>) -> anyhow::Result<()> {
    let (summary, count) = (Summary::new(sequence), sequence.frames.len());
    let mut rows = vec![("path", scene.motion.path.into_str().to_owned())];
    match motion::cycle(scene) {
        Some(cycle) => rates(&cycle, scene.array.frequency, &mut rows),
        None => rows.push(("frames", count.to_string())),
    }
    rows.extend([
        (
            "method",
            format!(
                "{}, {} per frame{}",
                scene.solver.method.into_str(),
                milliseconds(summary.seconds, 3),
                match count - summary.searched {
                    0 => String::new(),
                    followed =>
                        format!("; {followed} of {count} start from a neighbour, the others from a search"),
                }
            ),
        ),
        ("mean pressure", pascals(summary.mean_pressure)),
        (
            "weakest focus",
            format!("{}, in frame {}", pascals(summary.weakest.value), summary.weakest.frame + 1),
        ),
        (
            "least uniform",
            format!("std/mean {:.2} %, in frame {}", 100.0 * summary.spread.value, summary.spread.frame + 1),
        ),
    ]);
    if count > 1 {
        rows.push((
            "phase per frame",
            format!(
                "changes by {:.3} rad RMS; by {:.3} rad at most, of one element into frame {}",
                sequence.steps.rms,
                sequence.steps.largest,
                sequence.steps.to + 1
            ),
        ));
    }
    rows.extend(Moving::new(scene, sequence).iter().flat_map(Moving::rows));
    rows.extend(felt);
    for (name, value) in rows {
        say!("{name:<COLUMN$}{value}")?;
    }
    Ok(())
}

/// Rows for frame rate and speeds: of the scene's motion, and of targets with their own.
fn rates(cycle: &Cycle<'_>, carrier: f64, rows: &mut Vec<(&'static str, String)>) {
    let (from, to) = FELT_MOST;
    let of_scene = cycle.groups.iter().find(|group| group.target.is_none() && group.length > 0.0);
    if let (Some(group), Some((_, path))) = (of_scene, rows.first_mut()) {
        *path += &format!(", {} mm a cycle", millimetres(group.length, 1));
    }
    let (frames, rate) = (cycle.frames, cycle.frames_per_second());
    rows.push((
        "rate",
        format!("{} cycles/s of {frames} frames: {} frames/s", figure(cycle.rate), figure(rate)),
    ));
    rows.push(("can be played", playable(rate, carrier)));
    if let Some(group) = of_scene {
        let speed = group.length * cycle.rate;
        rows.push(("focus speed", format!("{speed:.3} m/s; {from} to {to} m/s feel strongest")));
    }
    for (group, target) in cycle.groups.iter().filter_map(|group| Some((group, group.target?))) {
        let Group { motion, length, rounds, .. } = group;
        let (path, rate) = (motion.path.into_str(), cycle.played(group));
        let times = if *rounds == 1 { "once".to_owned() } else { format!("{rounds} times") };
        rows.push((
            "own motion",
            format!(
                "target {}: {path}, {} mm, {times} a cycle: {} Hz, {:.3} m/s",
                target + 1,
                millimetres(*length, 1),
                figure(rate),
                length * rate
            ),
        ));
    }
}

/// A number with three decimals, without trailing zeros.
fn figure(value: f64) -> String {
    let text = format!("{value:.3}");
    match text.trim_end_matches('0').trim_end_matches('.') {
        "0" => format!("{value:e}"),
        short => short.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short() {
        for (value, text) in [(24.0, "24"), (36.833_16, "36.833"), (100.5, "100.5"), (1e-6, "1e-6")] {
            assert_eq!(figure(value), text);
        }
    }
}
