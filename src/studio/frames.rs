//! The drives of all frames of a cycle as JSON and CSV, with the figures of the cycle.

use std::io::Write;

use serde_json::{Value, json};

use crate::scene::motion::{Cycle, Group};
use crate::scene::{Scene, motion};
use crate::solver::frames::{Frame, Sequence};
use crate::studio::felt::Felt;
use crate::studio::response::Moving;

/// Frames per second of 256 elements that serial links carry, the slowest first.
const LINKS: [(f64, &str); 2] =
    [(89.0, "SonicSurface at 230400 baud"), (1124.0, "Sonoglyph's own protocol at 3 Mbaud")];

/// Figures of the whole cycle.
#[derive(Debug)]
pub struct Summary {
    pub mean_pressure: f64,
    pub weakest: Extreme,
    pub spread: Extreme,
    pub searched: usize,
    /// s per frame
    pub seconds: f64,
}

/// A figure and the frame, counted from 0, that it is of.
#[derive(Clone, Copy, Debug)]
pub struct Extreme {
    pub frame: usize,
    pub value: f64,
}

impl Summary {
    pub fn new(sequence: &Sequence) -> Self {
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

/// Targets with motions of their own.
fn own_motions(cycle: &Cycle<'_>) -> Vec<Value> {
    let own = cycle.groups.iter().filter_map(|group| Some((group, group.target?)));
    let one = |(group, target): (&Group<'_>, usize)| {
        let rate = cycle.played(group);
        json!({
            "target": target,
            "path": group.motion.path.into_str(),
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
///
/// # Errors
/// If the writer fails.
pub fn write_json(
    out: &mut dyn Write,
    scene: &Scene,
    sequence: &Sequence,
    felt: Option<&Felt>,
) -> std::io::Result<()> {
    let (cycle, summary) = (motion::cycle(scene), Summary::new(sequence));
    let of_scene = cycle.iter().flat_map(|cycle| &cycle.groups).find(|group| group.target.is_none());
    let length = of_scene.map_or(0.0, |group| group.length);
    let rate = cycle.as_ref().map(|cycle| cycle.rate);
    let head = json!({
        "method": scene.solver.method.into_str(),
        "elements": scene.elements(),
        "path": scene.motion.path.into_str(),
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
    if let Some(moving) = Moving::new(scene, sequence) {
        writeln!(out, "  \"response\": {},", moving.json())?;
    }
    if let Some(felt) = felt {
        writeln!(out, "  \"felt\": {},", felt.json())?;
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
    let mut value =
        json!({ "time": time, "foci": foci, "pressures": pressures, "phases": frame.drive.phases });
    if !is_full(frame) {
        value["amplitudes"] = json!(frame.drive.amplitudes);
    }
    value
}

/// Whether all that is driven is at full drive.
fn is_full(frame: &Frame) -> bool {
    frame.drive.amplitudes.iter().all(|&amplitude| amplitude == 0.0 || amplitude > 1.0 - 1e-9)
}

/// A row per frame: the phase (rad) of every element, and `nan` for those that are off; unless all are at full drive, also the
/// amplitude of every element.
///
/// # Errors
/// If the writer fails.
pub fn write_csv(out: &mut dyn Write, scene: &Scene, sequence: &Sequence) -> std::io::Result<()> {
    write!(out, "frame,time")?;
    for element in 0..scene.elements() {
        write!(out, ",phase_{element}")?;
    }
    let has_amplitudes = !sequence.frames.iter().all(is_full);
    for element in (0..scene.elements()).filter(|_| has_amplitudes) {
        write!(out, ",amplitude_{element}")?;
    }
    writeln!(out)?;
    let frames_per_second = frames_per_second(scene);
    for (index, frame) in sequence.frames.iter().enumerate() {
        write!(out, "{index},{:?}", index as f64 / frames_per_second)?;
        for (phase, amplitude) in frame.drive.phases.iter().zip(&frame.drive.amplitudes) {
            if *amplitude > 0.0 { write!(out, ",{phase:?}")? } else { write!(out, ",nan")? }
        }
        for amplitude in frame.drive.amplitudes.iter().filter(|_| has_amplitudes) {
            write!(out, ",{amplitude:?}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Boards that could play so many frames per second.
pub fn playable(rate: f64, carrier: f64) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

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
