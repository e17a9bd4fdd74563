//! Simulated flights of a scene's bead: released in its traps, or carried along its motion.

use std::fmt::Write;

use anyhow::{anyhow, bail};
use glam::DVec3;
use serde_json::{Value, json};

use crate::acoustics::{Air, Aperture, response::responding, viscosity};
use crate::drive::Drive;
use crate::force::{Carriage, Drag, Flight, Levitation};
use crate::gauge::Gauge;
use crate::rounding::millimetres;
use crate::scene::{Focus, Part, Scene, motion};
use crate::solver;
use crate::studio::motion::follow;

/// Simulated repetitions of the motion.
const ROUNDS: f64 = 2.0;
/// Limit of speed factors tried, and bisection steps of that range.
const FASTEST: f64 = 1024.0;
const HALVINGS: usize = 6;
/// Moments of a table, at most.
const MOST_MOMENTS: usize = 2_000_000;

/// The fields of a scene in sequence, with the position of one of its targets in each.
#[derive(Debug)]
pub struct Course {
    fields: Vec<Levitation>,
    wanted: Vec<DVec3>,
    /// Duration of a field (s); infinite for a scene at rest.
    pub span: f64,
    drag: Drag,
}

impl Course {
    /// For the target with this number, or the first trap, or else the first focus.
    ///
    /// # Errors
    /// A scene that cannot be solved, or a target missing in some frame.
    pub fn new(scene: &Scene, name: &str, target: Option<usize>, progress: &Gauge) -> anyhow::Result<Self> {
        let (drives, foci, span): (Vec<_>, Vec<_>, _) = if motion::moves(scene) {
            let cycle = motion::cycle(scene).ok_or_else(|| anyhow!("{name}: nothing moves"))?;
            let frames = follow(scene, name, progress)?.frames;
            let (drives, foci): (Vec<_>, _) =
                frames.into_iter().map(|frame| (frame.drive, frame.foci)).unzip();
            let heard = responding(scene, drives, false).into_iter().map(|drive| vec![drive]).collect();
            (heard, foci, cycle.frames_per_second().recip())
        } else {
            let solution = solver::solve(scene).map_err(|error| anyhow!("{name}: {error}"))?;
            (vec![responding(scene, solution.drives(), false)], vec![solution.foci], f64::INFINITY)
        };
        if foci.iter().any(Vec::is_empty) {
            bail!("{name}: target: the scene has no target, and a bead needs its place");
        }
        let wanted = foci.iter().map(|foci| place(foci, target));
        let Some(wanted) = wanted.collect::<Option<Vec<_>>>() else {
            bail!("{name}: target {} is no trap of every frame", target.map_or(1, |target| target + 1));
        };
        Ok(Self::playing(scene, &drives, wanted, span))
    }

    /// Of solved drives behind the elements' response, those of each field in turn, with the trap's position (m) in each.
    pub fn playing(scene: &Scene, drives: &[Vec<Drive>], wanted: Vec<DVec3>, span: f64) -> Self {
        let bead = Levitation::new(scene, &Aperture::new(scene), &[]);
        let fields: Vec<_> = drives.iter().map(|drives| bead.playing(drives)).collect();
        let air = Air::new(&scene.medium, scene.array.frequency);
        let drag = Drag::new(&bead.sphere, viscosity(&scene.medium), air.density);
        Self { fields, wanted, span, drag }
    }

    pub fn moves(&self) -> bool {
        self.span.is_finite()
    }

    /// The equilibrium of a bead in the first field, or else the target's position; m.
    pub fn start(&self) -> DVec3 {
        self.fields[0].hold(self.wanted[0]).rest
    }

    /// Duration of a repetition (s); infinite for a scene at rest.
    pub fn round(&self) -> f64 {
        self.span * self.fields.len() as f64
    }

    /// Releases a bead at a point (m) while the motion runs at a multiple of its speed.
    pub fn fly(&self, from: DVec3, seconds: f64, faster: f64, progress: &Gauge) -> Flight {
        let Self { fields, wanted, span, drag } = self;
        Carriage { fields, wanted, span: span / faster, drag: *drag }.fly(from, seconds, progress)
    }

    /// The highest speed factor of the motion at which a bead, starting at rest, stays for two repetitions, and the
    /// lowest tried factor at which it is lost; `None` if it is lost at any speed, infinite if it always stays.
    pub fn fastest(&self) -> Option<[f64; 2]> {
        let start = self.start();
        let stays =
            |faster: f64| !self.fly(start, ROUNDS * self.round() / faster, faster, &Gauge::default()).is_lost;
        let (mut stayed, mut lost) = if stays(1.0) {
            let Some(lost) = powers().find(|&faster| !stays(faster)) else {
                return Some([FASTEST, f64::INFINITY]);
            };
            (lost / 2.0, lost)
        } else {
            let stayed = powers().map(f64::recip).find(|&faster| stays(faster))?;
            (stayed, 2.0 * stayed)
        };
        for _ in 0..HALVINGS {
            let middle = (stayed * lost).sqrt();
            *(if stays(middle) { &mut stayed } else { &mut lost }) = middle;
        }
        Some([stayed, lost])
    }
}

/// 2, 4, 8 … up to the fastest.
fn powers() -> impl Iterator<Item = f64> {
    (1..).map(|power| f64::from(power).exp2()).take_while(|&faster| faster <= FASTEST)
}

/// The centre of a trap's lobes, or the first focus; m.
pub fn place(foci: &[Focus], target: Option<usize>) -> Option<DVec3> {
    let of = |focus: &Focus| match focus.part {
        Part::Trap(index) => Some(index),
        Part::Point | Part::Stroke | Part::Area(_) | Part::Direction => None,
    };
    let Some(index) = target.or_else(|| foci.iter().find_map(of)) else {
        return foci.first().map(|focus| focus.position);
    };
    let own: Vec<_> =
        foci.iter().filter(|focus| of(focus) == Some(index)).map(|focus| focus.position).collect();
    (!own.is_empty()).then(|| own.iter().sum::<DVec3>() / own.len() as f64)
}

/// A flight from a place, in words.
pub fn words(scene: &Scene, flight: &Flight, from: DVec3) -> String {
    let mm = |place: DVec3| {
        let [x, y, z] = place.to_array().map(|length| millimetres(length, 2));
        format!("({x}, {y}, {z}) mm")
    };
    let bead = &scene.bead;
    let radius = millimetres(bead.radius, 3);
    let mut text = format!("{:<14}  {}, radius {radius} mm\n", "bead", bead.material.title());
    let _ = writeln!(text, "{:<14}  {}, at rest", "released", mm(from));
    let Some(last) = flight.moments.last() else { return text };
    let end = if flight.is_lost {
        format!("lost after {:.4} s at {}", last.time, mm(last.at))
    } else {
        format!(
            "stays: after {:.4} s at {}, never more than {} mm from its place",
            last.time,
            mm(last.at),
            millimetres(flight.farthest, 2)
        )
    };
    let _ = write!(text, "{:<14}  {end}", "flight");
    text
}

/// Result of [`Course::fastest`] in words; `round`: cycles per second of the scene.
pub fn limit(fastest: Option<[f64; 2]>, round: f64) -> String {
    match fastest {
        None => "the bead is lost at any speed that was tried".to_owned(),
        Some([stays, lost]) if lost.is_infinite() => {
            format!("the bead stays at {stays:.0} times the speed: {:.1} rounds per second", stays * round)
        }
        Some([stays, lost]) => format!(
            "the bead stays up to {stays:.3} times the speed ({:.3} rounds per second), and is lost at {lost:.3}",
            stays * round
        ),
    }
}

/// A flight for programs, and what [`Course::fastest`] found if it was asked for.
pub fn answer(flight: &Flight, from: DVec3, fastest: Option<Option<[f64; 2]>>) -> Value {
    let last = flight.moments.last();
    let mut value = json!({
        "released": from.to_array(),
        "stays": !flight.is_lost,
        "seconds": last.map(|last| last.time),
        "at": last.map(|last| last.at.to_array()),
        "farthest": flight.farthest,
    });
    if let Some(fastest) = fastest {
        let finite = |value: f64| value.is_finite().then_some(value);
        value["fastest"] = json!({
            "stays": fastest.map(|[stays, _]| stays),
            "lost": fastest.and_then(|[_, lost]| finite(lost)),
        });
    }
    value
}

/// Moments at an even rate and the last as CSV: all, or as many as fit.
pub fn table(flight: &Flight) -> String {
    let mut text = "time,x,y,z,vx,vy,vz,wanted_x,wanted_y,wanted_z\n".to_owned();
    let apart = flight.moments.len().div_ceil(MOST_MOMENTS).max(1);
    let last = flight.moments.len().saturating_sub(1);
    let rows = flight.moments.iter().enumerate().filter(|(row, _)| row % apart == 0 || *row == last);
    for (_, moment) in rows {
        let _ = write!(text, "{}", moment.time);
        for value in [moment.at, moment.velocity, moment.wanted].iter().flat_map(|vector| vector.to_array()) {
            let _ = write!(text, ",{value}");
        }
        text.push('\n');
    }
    text
}
