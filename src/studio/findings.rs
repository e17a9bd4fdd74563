//! Figures of a solution beside its own quality, for people and for programs.

use serde_json::{Value, json};

use crate::acoustics::{Aperture, response::responding};
use crate::drive::{Drive, delay_level};
use crate::field::harmonic::NoHarmonic;
use crate::field::{FieldError, NoSideLobe, SideLobe, Stages, side_lobe};
use crate::rounding::percent_at_most;
use crate::scene::{Pressures, Scene, motion, outline};
use crate::solver::frames;
use crate::solver::levels::{self, Reached};
use crate::solver::{Limits, Problem, Ranges, Solution, SolveError, room, shape};
use crate::studio::bodies::{self, Pushed};
use crate::studio::demodulation::Demodulated;
use crate::studio::felt::{self, Felt};
use crate::studio::levitation::{self, Held, Neighbour};
use crate::studio::nonlinear::Nonlinear;
use crate::studio::probe::{self, Reading};
use crate::studio::response::Moving;
use crate::studio::{json, reach};

/// A solution, and what is known of it beside its own quality.
#[derive(Debug)]
pub struct Findings {
    pub solution: Solution,
    pub limits: Limits,
    pub side_lobe: Result<SideLobe, NoSideLobe>,
    pub heard: Option<Reading>,
    /// 5, 50 and 95 % of the figures, if elements differ.
    pub ranges: Option<Ranges>,
    /// The bead in every trap.
    pub traps: Vec<Held>,
    /// The force between beads, if it counts.
    pub neighbour: Option<Neighbour>,
    /// What pushes the bodies.
    pub bodies: Vec<Pushed>,
    /// Of a motion, or of drives in turn, of elements with a response.
    pub moving: Option<Moving>,
    /// By a hand, if the scene has a skin.
    pub felt: Option<Result<Felt, FieldError>>,
    pub nonlinear: Result<Nonlinear, NoHarmonic>,
    /// Of the modulation.
    pub demodulated: Option<Demodulated>,
    /// Warnings about all of it, a sentence each.
    pub warnings: Vec<String>,
}

impl Findings {
    /// `limits` are those of the problem, and `stages` those of the map that side lobes are searched on.
    pub fn new(
        scene: &Scene,
        problem: &Problem<'_>,
        limits: Limits,
        stages: &mut Stages,
        solution: Solution,
    ) -> Self {
        let aperture = problem.aperture;
        let drives = responding(scene, solution.drives(), false);
        let side_lobe = match &solution.figures {
            Some(figures) if figures.side_lobe > 0.0 => {
                let (part, position) = (figures.side_lobe, figures.side_lobe_position);
                Ok(SideLobe { position, pressure: part * solution.quality.mean_pressure, part })
            }
            Some(_) | None => {
                let plane = shape::judged_plane(scene, &solution.foci);
                side_lobe(stages, aperture, &plane, &drives, &solution.foci)
            }
        };
        let ranges = Ranges::new(scene, problem, (&solution, side_lobe.as_ref().ok()), stages);
        let heard = scene.listener.as_ref().map(|listener| probe::reading(aperture, &drives, listener.at));
        let traps = levitation::held(scene, aperture, &drives);
        let neighbour = levitation::neighbour(scene, aperture, &drives, &traps);
        let bodies = bodies::pushed(scene, aperture, &drives);
        let nonlinear = Nonlinear::of_solution(scene, aperture, &solution);
        let demodulated = Demodulated::new(scene, aperture, &solution);
        let of_drive = solution.warnings.iter().cloned().chain(limits.warning(problem));
        let mut warnings: Vec<_> = of_drive.map(|warning| warning.to_string()).collect();
        if scene.solver.pressures == Pressures::Pascal && limits.bound < 1.0 {
            warnings.push(format!(
                "no drive of this array brings every focus to more than {} of what is asked",
                percent_at_most(limits.bound, 2)
            ));
        }
        warnings.extend(heard.and_then(|heard| heard.warning()));
        warnings.extend(reach::of_targets(scene).iter().map(ToString::to_string));
        warnings.extend(bodies::warning(aperture));
        warnings.extend(levitation::warning(scene).filter(|_| !traps.is_empty()));
        Self {
            solution,
            limits,
            side_lobe,
            heard,
            ranges,
            traps,
            neighbour,
            bodies,
            moving: None,
            felt: None,
            nonlinear,
            demodulated,
            warnings,
        }
    }

    /// The same from a scene and its solution, whose figures it completes.
    ///
    /// # Errors
    /// A scene without targets, or too large for memory.
    pub fn of_scene(scene: &Scene, stages: &mut Stages, mut solution: Solution) -> Result<Self, SolveError> {
        if solution.foci.is_empty() {
            // Without foci there are no figures: the error says so.
            outline::foci(scene)?;
        }
        let _room = room::of_limits(scene, solution.foci.len())?;
        let aperture = Aperture::new(scene);
        let problem = Problem::of_scene(scene, &aperture, solution.foci.clone());
        solution.judge(scene, &problem);
        let has_frames = motion::moves(scene) || !solution.others.is_empty();
        let sequence = match has_frames && (scene.array.response.is_some() || scene.skin.is_some()) {
            true => Some(frames::follow(scene)?),
            false => None,
        };
        let moving = sequence.as_ref().and_then(|sequence| Moving::new(scene, sequence));
        let felt = scene.skin.as_ref().map(|_| {
            let drives = sequence.as_ref().map_or_else(|| solution.drives(), felt::drives);
            Felt::with_speeds(scene, &drives, stages)
        });
        let mut found = Self::new(scene, &problem, Limits::new(&problem), stages, solution);
        if let Some(Ok(felt)) = &felt {
            found.warnings.extend(felt.warnings(scene, &found.solution.foci));
        }
        Ok(Self { moving, felt, ..found })
    }

    /// The object that design and other programs know.
    pub fn json(&self, aperture: &Aperture) -> Value {
        let mut value = json::solution(&self.solution, Some(&self.limits));
        json::add_widths(&mut value, aperture, &self.solution);
        json::set_side_lobe(
            &mut value["quality"],
            self.side_lobe.as_ref().ok().map(|it| (it.part, it.position)),
        );
        if let Some(heard) = &self.heard {
            value["listener"] =
                json!({ "position": heard.position.to_array(), "rms": heard.rms(), "spl": heard.spl() });
        }
        if let Some(moving) = &self.moving {
            value["response"] = moving.json();
        }
        if let Some(Ok(felt)) = &self.felt {
            value["felt"] = felt.json();
        }
        if let Ok(nonlinear) = &self.nonlinear {
            value["harmonic"] = json!(nonlinear.harmonic);
            value["nonlinear"] = json::nonlinear(nonlinear);
        }
        if let Some(demodulated) = &self.demodulated {
            value["heard"] = demodulated.json();
        }
        if let Some(ranges) = &self.ranges {
            value["spread"] = ranges.named().map(|(name, range)| (name.to_owned(), json!(range))).collect();
        }
        if !self.traps.is_empty() {
            value["traps"] = self.traps.iter().map(json::trap).collect();
        }
        if !self.bodies.is_empty() {
            value["bodies"] = bodies::json(&self.bodies);
        }
        if let Some(Neighbour { target, force, part }) = self.neighbour {
            value["between_beads"] = json!({ "target": target, "force": force.to_array(), "weights": part });
        }
        value
    }
}

/// A drive on a board with few phase levels.
#[derive(Debug)]
pub struct Played {
    pub levels: u32,
    pub ideal: Reached,
    pub rounded: Reached,
    pub refined: (Drive, Reached),
}

impl Played {
    pub fn new(problem: &Problem<'_>, solution: &Solution, levels: u32) -> Self {
        let reached = |drive: &Drive| Reached::new(problem, drive);
        let refined = levels::refined(problem, &solution.drive, levels);
        Self {
            levels,
            ideal: reached(&solution.drive),
            rounded: reached(&solution.drive.at_levels(levels)),
            refined: (refined.clone(), reached(&refined)),
        }
    }

    pub fn json(&self) -> Value {
        let reached = |reached: Reached| {
            json!({
                "mean_pressure": reached.mean_pressure,
                "min_pressure": reached.weakest,
                "spread": reached.spread,
            })
        };
        let delays: Vec<_> =
            self.refined.0.phases.iter().map(|&phase| delay_level(phase, self.levels)).collect();
        json!({
            "levels": self.levels,
            "expected_part": levels::expected_part(self.levels),
            "rounded": reached(self.rounded),
            "refined": reached(self.refined.1),
            "delays": delays,
        })
    }
}
