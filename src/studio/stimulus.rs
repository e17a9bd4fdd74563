//! The ways of playing a drawing for a hand, and which of them is felt most.
//!
//! Ways are the drawing switched on and off (AM), moved in small circles (LM), drawn by running foci (STM), and, if it has several drives,
//! switched while these take turns. Ways that differ in tempo or modulation alone share their drives.

use serde_json::{Value, json};
use strum::IntoStaticStr;

use crate::drive::Drive;
use crate::field::{Evaluator, Stages};
use crate::scene::{
    Envelope, Method, Modulation, Motion, MotionPath, Scene, Skin, Target, Tempo, Turns, motion, outline,
};
use crate::solver;
use crate::solver::frames::{self, Sequence};
use crate::studio::felt::{self, Felt, Unknown};
use crate::studio::response::Moving;

/// Hz, of AM and LM.
const FREQUENCIES: [f64; 5] = [30.0, 60.0, 125.0, 200.0, 250.0];
/// m, diameters of LM.
const CIRCLES: [f64; 2] = [0.008, 0.016];
const FRAMES_OF_CIRCLE: u32 = 16;
/// m/s, relative to surface waves, of STM; and numbers of running foci.
const SPEEDS: [f64; 6] = [0.6, 0.8, 1.0, 1.15, 1.3, 1.5];
const FOCI: [u32; 3] = [1, 2, 3];
/// Wavelengths between the frames of STM, and limits of their number.
const APART: f64 = 0.25;
const FRAMES: [f64; 2] = [32.0, 256.0];
/// Drives in turn.
const TURNS: [u32; 2] = [2, 4];

/// A way of playing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "UPPERCASE", const_into_str)]
pub enum Kind {
    Am,
    Lm,
    Stm,
    Turns,
}

/// A drawing played in one way, and what is felt of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stimulus {
    pub kind: Kind,
    pub scene: Scene,
    pub felt: Felt,
    /// RMS pressure at moving foci relative to foci at rest, of elements with a response.
    pub kept: Option<f64>,
}

impl Stimulus {
    /// The keys of a scene that plays it.
    pub fn keys(&self) -> String {
        let Scene { modulation, motion, solver, .. } = &self.scene;
        let am = || {
            format!(
                "[modulation] shape = \"{}\", frequency = {:?}",
                modulation.shape.into_str(),
                modulation.frequency
            )
        };
        match (self.kind, motion.tempo, solver.frames) {
            (Kind::Am, ..) => am(),
            (Kind::Turns, _, Turns::Count(frames)) => format!("{}, [solver] frames = {frames}", am()),
            (Kind::Turns, _, Turns::Auto) => am(),
            (Kind::Lm | Kind::Stm, tempo, _) => {
                let (path, Motion { frames, .. }) = (motion.path.into_str(), motion);
                let tempo = match tempo {
                    Tempo::Rate(rate) => format!("size = {:?}, rate = {rate:?}", motion.size),
                    Tempo::Own => format!("file = {:?}", motion.file),
                    Tempo::Speed(speed) => format!("foci = {}, speed = {speed:.2}", motion.foci),
                };
                format!("[motion] path = \"{path}\", {tempo}, frames = {frames}")
            }
        }
    }

    /// The object that other programs know.
    pub fn json(&self) -> Value {
        let Scene { modulation, motion, solver, .. } = &self.scene;
        json!({
            "kind": <&str>::from(self.kind),
            "modulation": modulation,
            "motion": motion,
            "solver": solver,
            "felt": self.felt.json(),
            "kept": self.kept,
        })
    }
}

/// Every way of playing the targets of a scene, the one that is felt most first.
///
/// # Errors
/// The errors of solving, and of [`Felt::new`].
pub fn ranked(scene: &Scene) -> Result<Vec<Stimulus>, Unknown> {
    let mut all = Vec::new();
    for Family { kind, ways } in families(scene) {
        let Some(first) = ways.first() else { continue };
        let sequence = motion::moves(first).then(|| frames::follow(first)).transpose()?;
        let drives: Vec<Drive> = match &sequence {
            Some(sequence) => felt::drives(sequence),
            None => solver::solve(first)?.drives(),
        };
        let mut stages = Stages::new(Evaluator::Cpu);
        let kept = |way: &Scene, sequence: &Sequence| Moving::new(way, sequence).map(|moving| moving.kept);
        for way in ways {
            let felt = Felt::new(&way, drives.clone(), &mut stages)?;
            let kept = sequence.as_ref().and_then(|sequence| kept(&way, sequence));
            all.push(Stimulus { kind, scene: way, felt, kept });
        }
    }
    all.sort_by(|a, b| b.felt.level.total_cmp(&a.felt.level));
    Ok(all)
}

/// Ways that share their drives.
struct Family {
    kind: Kind,
    ways: Vec<Scene>,
}

fn families(scene: &Scene) -> Vec<Family> {
    let at_rest = |target: &Target| Target { motion: None, modulation: None, ..target.clone() };
    let skin = scene.skin.clone().unwrap_or_default();
    let still = Scene {
        targets: scene.targets.iter().map(at_rest).collect(),
        modulation: Modulation::default(),
        motion: Motion::default(),
        skin: Some(skin.clone()),
        ..scene.clone()
    };
    let switched = |base: &Scene| {
        let shapes = [Envelope::Sine, Envelope::Square];
        let all = FREQUENCIES.iter().flat_map(|frequency| shapes.map(|shape| (shape, *frequency)));
        all.map(|(shape, frequency)| {
            let modulation = Modulation { shape, frequency, ..Modulation::default() };
            Scene { modulation, ..base.clone() }
        })
        .collect()
    };
    let mut all = vec![Family { kind: Kind::Am, ways: switched(&still) }];
    for size in CIRCLES {
        let moved = |&rate: &f64| {
            let path = MotionPath::Circle;
            let motion = Motion {
                path,
                size,
                frames: FRAMES_OF_CIRCLE,
                tempo: Tempo::Rate(rate),
                ..Motion::default()
            };
            Scene { motion, ..still.clone() }
        };
        all.push(Family { kind: Kind::Lm, ways: FREQUENCIES.iter().map(moved).collect() });
    }
    all.extend(FOCI.iter().filter_map(|&foci| running(&still, &skin, foci)));
    if still.solver.method == Method::Best && outline::is_continuous(&still) {
        for count in TURNS {
            let mut base = still.clone();
            base.solver.frames = Turns::Count(count);
            all.push(Family { kind: Kind::Turns, ways: switched(&base) });
        }
    }
    all
}

/// Foci along the outlines; `None` of drawings without length.
fn running(still: &Scene, skin: &Skin, foci: u32) -> Option<Family> {
    let at = |frames: u32, speed: f64| {
        let tempo = Tempo::Speed(speed);
        let motion = Motion { path: MotionPath::Outline, foci, frames, tempo, ..Motion::default() };
        Scene { motion, ..still.clone() }
    };
    let probe = at(1, skin.wave_speed);
    let length = motion::cycle(&probe)?.groups.first()?.length;
    if length <= 0.0 {
        return None;
    }
    let frames = (length / (APART * still.wavelength())).ceil().clamp(FRAMES[0], FRAMES[1]);
    let ways = SPEEDS.iter().map(|speed| at(frames as u32, speed * skin.wave_speed)).collect();
    Some(Family { kind: Kind::Stm, ways })
}
