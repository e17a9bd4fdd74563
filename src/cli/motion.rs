//! `sonoglyph solve --motion`: the drives of all frames of a cycle and their quality, as a table, JSON or CSV.

use std::io::{BufWriter, Write};

use anyhow::bail;
use serde_json::{Value, json};

use crate::cli::solve::Methods;
use crate::cli::{COLUMN, SolveArgs, progress, read_scene};
use crate::picture::sheet::pascals;
use crate::scene::motion::{Cycle, Group};
use crate::scene::{Scene, motion};
use crate::solver::frames::{Frame, Sequence};
use crate::studio::motion::{SOLVING, follow};
use crate::studio::output::{self, Files, say, warn};

/// m/s at which a moving focus is felt most: about the speed of waves on skin (Frier et al. 2018).
const FELT_MOST: (f64, f64) = (5.0, 8.0);
/// Frames per second of 256 elements that serial links carry, the slowest first.
const LINKS: [(f64, &str); 2] =
    [(89.0, "SonicSurface at 230400 baud"), (1124.0, "Sonoglyph's own protocol at 3 Mbaud")];

pub fn run(args: &SolveArgs) -> anyhow::Result<()> {
    let method = match args.method {
        Some(Methods::All) => bail!("--motion follows one solution from frame to frame: name one method"),
        Some(Methods::One(method)) => Some(method),
        None => None,
    };
    let mut files = Files::new();
    let scene = read_scene(&args.scene, method, &mut files)?;
    if let Some(path) = &args.csv {
        files.writes(path)?;
    }
    let sequence = follow(&scene, &args.scene.display().to_string(), &progress::begin(SOLVING))?;
    warn_of_rate(&scene);
    if let Some(path) = &args.csv {
        output::write_by(path, |file| Ok(write_csv(file, &scene, &sequence)?))?;
    }
    if args.json {
        let mut out = BufWriter::new(output::standard()?);
        write_json(&mut out, &scene, &sequence).and_then(|()| out.flush()).map_err(output::unsaid)?;
    } else {
        print(&scene, &sequence)?;
    }
    Ok(())
}

fn warn_of_rate(scene: &Scene) {
    let carrier = scene.array.frequency;
    let rate = motion::cycle(scene).map(|cycle| cycle.frames_per_second());
    if let Some(rate) = rate.filter(|&rate| rate > carrier) {
        warn(&format!(
            "{rate:.0} frames/s are more than the {carrier:.0} periods that the array plays in a second: none can follow; \
             take fewer frames or a lower rate"
        ));
    }
}

/// What could play so many frames per second.
fn playable(rate: f64, carrier: f64) -> String {
    if rate > carrier {
        return "by no array".to_owned();
    }
    match LINKS.iter().find(|(most, _)| rate <= *most) {
        Some((most, link)) => format!("over {link}, which carries {most} frames/s of 256 elements"),
        None => format!(
            "only from a board's memory: {} carries {} frames/s of 256 elements",
            LINKS[1].1, LINKS[1].0
        ),
    }
}

/// What is said of the whole cycle.
struct Summary {
    mean_pressure: f64,
    weakest: Extreme,
    spread: Extreme,
    searched: usize,
    /// s per frame
    seconds: f64,
}

/// A figure and the frame, counted from 0, that it is of.
#[derive(Clone, Copy)]
struct Extreme {
    frame: usize,
    value: f64,
}

impl Summary {
    fn new(sequence: &Sequence) -> Self {
        let frames = &sequence.frames;
        let largest = |of: &dyn Fn(&Frame) -> f64| {
            let values = frames.iter().map(of).enumerate().map(|(frame, value)| Extreme { frame, value });
            values
                .reduce(|a, b| if b.value > a.value { b } else { a })
                .unwrap_or(Extreme { frame: 0, value: 0.0 })
        };
        let weakest = largest(&|frame| -frame.min_pressure());
        Self {
            mean_pressure: frames.iter().map(Frame::mean_pressure).sum::<f64>() / frames.len() as f64,
            weakest: Extreme { value: -weakest.value, ..weakest },
            spread: largest(&Frame::spread),
            searched: frames.iter().filter(|frame| frame.cold).count(),
            seconds: sequence.seconds / frames.len() as f64,
        }
    }
}

fn print(scene: &Scene, sequence: &Sequence) -> anyhow::Result<()> {
    let (summary, count) = (Summary::new(sequence), sequence.frames.len());
    let mut rows = vec![("path", scene.motion.path.name().to_owned())];
    match motion::cycle(scene) {
        Some(cycle) => moving(&cycle, scene.array.frequency, &mut rows),
        None => rows.push(("frames", count.to_string())),
    }
    rows.extend([
        (
            "method",
            format!(
                "{}, {:.3} ms per frame{}",
                scene.solver.method.name(),
                summary.seconds * 1e3,
                match count - summary.searched {
                    0 => String::new(),
                    followed =>
                        format!("; {followed} of {count} go on from a neighbour, the rest is searched for"),
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
    for (name, value) in rows {
        say!("{name:<COLUMN$}{value}")?;
    }
    Ok(())
}

/// How fast what moves is, by the scene's motion and by those of targets.
fn moving(cycle: &Cycle<'_>, carrier: f64, rows: &mut Vec<(&'static str, String)>) {
    let (from, to) = FELT_MOST;
    let of_scene = cycle.groups.iter().find(|group| group.target.is_none() && group.length > 0.0);
    if let (Some(group), Some((_, path))) = (of_scene, rows.first_mut()) {
        *path += &format!(", {:.1} mm a cycle", group.length * 1e3);
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
        let (path, rate) = (motion.path.name(), cycle.played(group));
        let times = if *rounds == 1 { "once".to_owned() } else { format!("{rounds} times") };
        rows.push((
            "own motion",
            format!(
                "target {}: {path}, {:.1} mm, {times} a cycle: {} Hz, {:.3} m/s",
                target + 1,
                length * 1e3,
                figure(rate),
                length * rate
            ),
        ));
    }
}

/// A number to three decimals, or fewer where the rest is 0.
fn figure(value: f64) -> String {
    let text = format!("{value:.3}");
    match text.trim_end_matches('0').trim_end_matches('.') {
        "0" => format!("{value:e}"),
        short => short.to_owned(),
    }
}

/// The same of targets with motions of their own, for scripts.
fn own_motions(cycle: &Cycle<'_>) -> Vec<Value> {
    let own = cycle.groups.iter().filter_map(|group| Some((group, group.target?)));
    let one = |(group, target): (&Group<'_>, usize)| {
        let rate = cycle.played(group);
        json!({
            "target": target,
            "path": group.motion.path.name(),
            "length": group.length,
            "rounds": group.rounds,
            "rate": rate,
            "asked_rate": group.asked(),
            "speed": group.length * rate,
        })
    };
    own.map(one).collect()
}

/// One object; its frames stand a line each, and are never all in memory as text.
fn write_json(out: &mut dyn Write, scene: &Scene, sequence: &Sequence) -> std::io::Result<()> {
    let (cycle, summary) = (motion::cycle(scene), Summary::new(sequence));
    let of_scene = cycle.iter().flat_map(|cycle| &cycle.groups).find(|group| group.target.is_none());
    let length = of_scene.map_or(0.0, |group| group.length);
    let rate = cycle.as_ref().map(|cycle| cycle.rate);
    let head = json!({
        "method": scene.solver.method.name(),
        "elements": scene.elements(),
        "path": scene.motion.path.name(),
        "rate": rate,
        "frames_per_second": cycle.as_ref().map(|cycle| cycle.frames_per_second()),
        "length": length,
        "speed": rate.unwrap_or(0.0) * length,
        "own_motions": cycle.as_ref().map_or_else(Vec::new, own_motions),
        "seconds": sequence.seconds,
        "searched": summary.searched,
        "mean_pressure": summary.mean_pressure,
        "min_pressure": summary.weakest.value,
        "spread": summary.spread.value,
        "largest_phase_step": sequence.steps.largest,
        "rms_phase_step": sequence.steps.rms,
        "amplitudes": sequence.frames[0].drive.amplitudes,
    });
    writeln!(out, "{{")?;
    for (key, value) in head.as_object().into_iter().flatten() {
        writeln!(out, "  {}: {value},", Value::from(key.as_str()))?;
    }
    writeln!(out, "  \"frames\": [")?;
    let frames_per_second = frames_per_second(scene);
    for (index, frame) in sequence.frames.iter().enumerate() {
        let comma = if index + 1 < sequence.frames.len() { "," } else { "" };
        writeln!(out, "    {}{comma}", frame_json(frame, index as f64 / frames_per_second))?;
    }
    writeln!(out, "  ]\n}}")?;
    Ok(())
}

/// Infinite where there is one frame, which begins at 0 s.
fn frames_per_second(scene: &Scene) -> f64 {
    motion::cycle(scene).map_or(f64::INFINITY, |cycle| cycle.frames_per_second())
}

fn frame_json(frame: &Frame, time: f64) -> Value {
    let foci = frame.foci.iter().map(|focus| json!(focus.position.to_array())).collect::<Vec<_>>();
    let pressures = frame.pressures.iter().map(|p| p.norm()).collect::<Vec<_>>();
    json!({ "time": time, "foci": foci, "pressures": pressures, "phases": frame.drive.phases })
}

/// A row per frame: the phase (rad) of every element, and `nan` for those that are off.
fn write_csv(out: &mut dyn Write, scene: &Scene, sequence: &Sequence) -> std::io::Result<()> {
    write!(out, "frame,time")?;
    for element in 0..scene.elements() {
        write!(out, ",phase_{element}")?;
    }
    writeln!(out)?;
    let frames_per_second = frames_per_second(scene);
    for (index, frame) in sequence.frames.iter().enumerate() {
        write!(out, "{index},{:?}", index as f64 / frames_per_second)?;
        for (phase, amplitude) in frame.drive.phases.iter().zip(&frame.drive.amplitudes) {
            if *amplitude > 0.0 { write!(out, ",{phase:?}")? } else { write!(out, ",nan")? }
        }
        writeln!(out)?;
    }
    Ok(())
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

    #[test]
    fn what_can_play_it_depends_on_the_rate() {
        for (rate, part) in [
            (89.0, "SonicSurface"),
            (320.0, "3 Mbaud, which carries 1124"),
            (5000.0, "memory"),
            (40_000.0, "memory"),
            (40_001.0, "no array"),
        ] {
            let said = playable(rate, 40_000.0);
            assert!(said.contains(part), "{rate}: {said}");
        }
    }
}
