//! What holds of every solution: what it says of the foci is what the model says, and nobody does better than the bound.

use std::f64::consts::PI;

use glam::{DQuat, DVec3, EulerRot};
use num_complex::Complex64;
use rayon::ThreadPool;
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::scene::{
    Amplitudes, Board, ElementModel, Elements, Focus, Method, Motion, Placed, Pressures, Scene, Shape,
    Target, motion,
};
use sonoglyph::solver::frames::follow;
use sonoglyph::solver::{Limits, Problem, Solution, SolveError, solve};

use crate::dice::Dice;
use crate::random::draw::{Case, Family};
use crate::random::oracle::Oracle;
use crate::random::tally::{count, within};
use crate::random::traps;

/// A scene with its drive, and the same model twice.
#[derive(Debug)]
pub struct Solved {
    /// With a method that its foci allow.
    pub scene: Scene,
    pub aperture: Aperture,
    pub oracle: Oracle,
    pub solution: Solution,
}

/// The solution of a drawn scene; `None` where it is refused, with a reason, as it should be.
pub fn solved(case: &Case, two: &ThreadPool) -> Option<Solved> {
    let mut scene = case.scene.clone();
    let solution = match solve(&scene) {
        Err(SolveError::SeveralFoci(foci)) => {
            assert!(scene.solver.method == Method::Focus && foci > 1);
            count("`focus` refused: several foci");
            scene.solver.method = Method::Naive;
            solve(&scene)
        }
        other => other,
    };
    let solution = match solution {
        Ok(solution) => solution,
        Err(error) => {
            assert_eq!(case.family, Family::Ill, "refused: {error}");
            assert!(error.to_string().starts_with("target"), "which key? {error}");
            count("refused: no focus, or one behind the array");
            return None;
        }
    };
    count(scene.solver.method.into_str());
    let (aperture, oracle) = (Aperture::new(&scene), Oracle::new(&scene));
    let solved = Solved { scene, aperture, oracle, solution };
    solved.is_the_same_on_two_threads(two);
    solved.drive_is_playable();
    solved.pressures_are_those_of_the_field();
    solved.figures_are_those_of_the_pressures();
    solved.foci_get_the_pascals_asked_for();
    solved.nothing_beats_the_bound(&mut case.dice.clone());
    Some(solved)
}

/// Relative to the sum of moduli, what f64 leaves of a sum over waves that ran `distance` (m): what the polynomials in vector code
/// and the oracle's own directivity are off, and the rounding of the phase and of ka sinθ, 2⁻⁵² of each in
/// several steps; and of the exact piston's terms several such roundings, each as many times as large as their sum as the way is
/// longer than the disk is wide.
pub fn rounding(oracle: &Oracle, distance: f64) -> f64 {
    let disk = match oracle.model {
        ElementModel::ExactPiston => distance / oracle.radius,
        ElementModel::Piston
        | ElementModel::Point
        | ElementModel::Rectangle
        | ElementModel::Cosine
        | ElementModel::Measured => 0.0,
    };
    4e-12 + 4e-15 * oracle.wavenumber * (distance + oracle.radius) + 2e-15 * disk
}

/// The same foci as points, in the same order.
pub fn as_points(foci: &[Focus]) -> Vec<Target> {
    let point =
        |focus: &Focus| Target { pressure: focus.target, ..Target::new(Shape::Point { at: focus.position }) };
    foci.iter().map(point).collect()
}

impl Solved {
    fn is_the_same_on_two_threads(&self, two: &ThreadPool) {
        let scene = &self.scene;
        let again = two.install(|| solve(scene)).unwrap();
        assert_eq!(again.drive, self.solution.drive, "found by another number of threads");
        if self.is_stroke_by_best() {
            count("continuous strokes by `best`");
        } else if !traps::are_in(scene) {
            let targets = as_points(&self.solution.foci);
            let points = Scene { targets, motion: Motion::default(), ..scene.clone() };
            let points = solve(&points).unwrap();
            assert_eq!(points.drive, self.solution.drive, "of the same foci, given as points");
        }
        let foci = motion::frames(scene).unwrap()[0].len();
        if motion::moves(scene) && foci < 12 {
            let alone = match follow(scene) {
                Err(SolveError::SeveralFoci(_)) => return,
                other => other.unwrap(),
            };
            let together = two.install(|| follow(scene)).unwrap();
            assert_eq!(alone.frames, together.frames, "found by another number of threads");
            assert_eq!(alone.frames.len(), motion::count(scene));
            for frame in &alone.frames {
                is_playable(&self.aperture, &frame.drive);
                assert!(frame.pressures.iter().all(|p| p.is_finite()));
            }
            count("motions");
            if motion::runs(scene) {
                count("motions along outlines");
            }
            if scene.targets.iter().any(|target| target.motion.is_some()) {
                count("motions of targets");
            }
        }
    }

    /// `best` keeps what is beside a stroke quiet: its samples are no points.
    pub fn is_stroke_by_best(&self) -> bool {
        self.scene.solver.method == Method::Best
            && self.solution.foci.iter().any(|focus| !focus.is_separate())
    }

    fn drive_is_playable(&self) {
        let Self { scene, aperture, solution, .. } = self;
        is_playable(aperture, &solution.drive);
        let loudest = solution.drive.amplitudes.iter().copied().fold(0.0, f64::max);
        if scene.solver.amplitudes == Amplitudes::Uniform {
            let of = |&n: &usize| (solution.drive.amplitudes[n] - loudest).abs();
            within("uniform amplitudes", aperture.driven.iter().map(of).fold(0.0, f64::max), 1e-12);
        }
        assert!((0.0..=1.0).contains(&solution.turned_down), "{}", solution.turned_down);
        let is_heard = solution.pressures.iter().any(|p| p.norm() > 0.0);
        if scene.solver.pressures == Pressures::Relative && is_heard {
            within("ratios are played at full drive", (loudest - 1.0).abs(), 1e-12);
        }
    }

    /// P = Σ H u by the oracle, at every focus.
    fn pressures_are_those_of_the_field(&self) {
        let Self { scene, oracle, solution, .. } = self;
        for (focus, p) in solution.foci.iter().zip(&solution.pressures) {
            let Some((expected, moduli)) = oracle.pressure(&solution.drive, focus.position) else { continue };
            let rounding = match scene.array.element {
                ElementModel::ExactPiston => DISK,
                _ => rounding(oracle, oracle.reach + focus.position.length()),
            };
            within("pressure at a focus", (expected - p).norm(), rounding * moduli + f64::MIN_POSITIVE);
        }
    }

    fn figures_are_those_of_the_pressures(&self) {
        let Self { aperture, solution: Solution { foci, pressures, quality, excitation, .. }, .. } = self;
        let count = foci.len() as f64;
        let moduli: Vec<_> = pressures.iter().map(|p| p.norm()).collect();
        let relative: Vec<_> = moduli.iter().zip(foci).map(|(p, focus)| p / focus.target).collect();
        let mean = relative.iter().sum::<f64>() / count;
        let spread = (relative.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / count).sqrt();
        let largest = moduli.iter().copied().fold(0.0, f64::max);
        within("mean", (quality.mean_pressure - moduli.iter().sum::<f64>() / count).abs(), 1e-12 * largest);
        assert_eq!(quality.min_pressure, moduli.iter().copied().fold(f64::INFINITY, f64::min));
        within("spread", (quality.spread * mean - spread).abs(), 1e-12 * spread);
        assert!(quality.residual.is_finite(), "{quality:?}");
        let power = excitation.iter().map(|u| u * u).sum::<f64>() / aperture.driven.len() as f64;
        within("efficiency", (quality.efficiency - power).abs(), 1e-12);
        assert!(quality.efficiency <= 1.0 + 1e-12, "{quality:?}");
        assert!(quality.relative_to_single <= count.sqrt() * (1.0 + 1e-12), "{quality:?}");
    }

    fn foci_get_the_pascals_asked_for(&self) {
        let Self { scene, solution: Solution { foci, pressures, turned_down, .. }, .. } = self;
        if scene.solver.pressures == Pressures::Relative || *turned_down == 1.0 {
            return;
        }
        // The least Σ (|p| - A)²: turning the drive up or down does no good.
        let miss = |part: f64| {
            let of = |(p, focus): (&Complex64, &Focus)| (part * p.norm() - focus.target).powi(2);
            pressures.iter().zip(foci).map(of).sum::<f64>()
        };
        assert!(miss(1.001) >= miss(1.0) && miss(0.999) >= miss(1.0), "{pressures:?} for {foci:?}");
        if let ([p], [focus]) = (&pressures[..], &foci[..]) {
            within("pascals at one focus", (p.norm() / focus.target - 1.0).abs(), 1e-12);
        }
        count("turned down to the pascals asked for");
    }

    fn nothing_beats_the_bound(&self, dice: &mut Dice) {
        let Self { aperture, solution, .. } = self;
        let problem = Problem::new(aperture, solution.foci.clone());
        let limits = Limits::new(&problem);
        let (foci, elements) = (problem.foci.len(), aperture.driven.len());
        assert!(limits.bound.is_finite() && limits.bound >= 0.0, "{limits:?}");
        assert!(limits.rank <= foci.min(elements) && limits.condition >= 1.0, "{limits:?}");
        let certified = solution.certified(limits.bound);
        assert!((0.0..=1.0 + 1e-9).contains(&certified), "certified {certified}: {limits:?}");
        for _ in 0..3 {
            let any: Vec<_> = (0..elements)
                .map(|_| Complex64::from_polar(dice.one_of(&[1.0, 1.0, 0.5]), dice.between(-PI, PI)))
                .collect();
            let reached = problem.transfer.pressure(&any);
            let relative = reached.iter().zip(&problem.foci).map(|(p, focus)| p.norm() / focus.target);
            let weakest = relative.fold(f64::INFINITY, f64::min);
            assert!(weakest <= limits.bound * (1.0 + 1e-9), "{weakest} by chance, {limits:?}");
        }
    }
}

/// What the oracle's integral of a disk is off by, of what the element sends straight ahead: at ka = 6 and three radii away 16
/// spokes and 8 rings leave 1e-9.
pub const DISK: f64 = 1e-8;

fn is_playable(aperture: &Aperture, drive: &Drive) {
    assert_eq!(
        (drive.amplitudes.len(), drive.phases.len()),
        (aperture.positions.len(), aperture.positions.len())
    );
    assert!(drive.amplitudes.iter().all(|amplitude| (0.0..=1.0).contains(amplitude)), "{drive:?}");
    assert!(drive.phases.iter().all(|phase| (-PI..=PI).contains(phase)), "{drive:?}");
    let mut driven = aperture.driven.iter().peekable();
    for n in 0..aperture.positions.len() {
        if driven.next_if(|&&it| it == n).is_none() {
            assert_eq!(drive.amplitudes[n], 0.0, "element {n} is off");
        }
    }
}

/// A solved scene under a map of space that the array does not see: elements in another order, and every place elsewhere.
pub struct Moved {
    pub scene: Scene,
    /// Of every element of the moved scene, the one of the other that it corresponds to.
    pub element: Vec<Option<usize>>,
    /// Whether positions are rounded, so that another of nearly equal starts may win.
    pub is_rounded: bool,
    pub place: Box<dyn Fn(DVec3) -> DVec3>,
    pub direction: Box<dyn Fn(DVec3) -> DVec3>,
}

impl Moved {
    /// x becomes -x.
    pub fn mirrored(scene: &Scene) -> Self {
        let (columns, each) = (scene.array.columns as usize, scene.array.elements());
        let is_table = scene.array.placed.get().is_some();
        let other = |n: usize| if is_table { n } else { n / each * each + mirrored(n % each, columns) };
        let mirror = DVec3::new(-1.0, 1.0, 1.0);
        let mut moved = scene.clone();
        moved.array.off = scene.array.off.iter().map(|&n| other(n)).collect();
        if let Some(placed) = scene.array.placed.get() {
            let image = |it: &Placed| Placed { at: it.at * mirror, normal: it.normal * mirror };
            moved.array.placed = Elements::new(placed.iter().map(image).collect(), None);
        }
        for board in &mut moved.boards {
            // A board's own axes stay right-handed: its elements are mirrored too.
            *board = Board {
                at: board.at * mirror,
                normal: board.normal * mirror,
                x_axis: -(board.x_axis * mirror),
            };
        }
        for reflector in &mut moved.reflectors {
            (reflector.point, reflector.normal) = (reflector.point * mirror, reflector.normal * mirror);
        }
        Self {
            scene: moved,
            element: (0..scene.elements()).map(|n| Some(other(n))).collect(),
            is_rounded: false,
            place: Box::new(move |at| at * mirror),
            direction: Box::new(move |at| at * mirror),
        }
    }

    /// Boards and reflectors turned about the origin and moved, with all the rest.
    pub fn turned(scene: &Scene, dice: &mut Dice) -> Self {
        let mut angle = || dice.between(-PI, PI);
        let turn = DQuat::from_euler(EulerRot::ZXZ, angle(), angle(), angle());
        let by = DVec3::new(dice.between(-0.1, 0.1), dice.between(-0.1, 0.1), dice.between(-0.1, 0.1));
        let mut moved = scene.clone();
        moved.boards = scene.standing();
        for board in &mut moved.boards {
            *board =
                Board { at: turn * board.at + by, normal: turn * board.normal, x_axis: turn * board.x_axis };
        }
        for reflector in &mut moved.reflectors {
            (reflector.point, reflector.normal) = (turn * reflector.point + by, turn * reflector.normal);
        }
        Self {
            scene: moved,
            element: (0..scene.elements()).map(Some).collect(),
            is_rounded: true,
            place: Box::new(move |at| turn * at + by),
            direction: Box::new(move |direction| turn * direction),
        }
    }

    /// Half a pitch towards -x or +x: one more column, which is off, on the other side.
    pub fn translated(scene: &Scene, to_the_right: bool) -> Self {
        let columns = scene.array.columns as usize;
        let first = usize::from(to_the_right);
        let mut moved = scene.clone();
        moved.array.columns += 1;
        let element: Vec<_> = (0..moved.array.elements())
            .map(|n| (n / (columns + 1), (n % (columns + 1)).checked_sub(first)))
            .map(|(row, column)| {
                column.filter(|&column| column < columns).map(|column| row * columns + column)
            })
            .collect();
        let is_off = |n: &usize| element[*n].is_none_or(|other| scene.array.off.contains(&other));
        moved.array.off = (0..element.len()).filter(is_off).collect();
        let by = DVec3::X * scene.array.pitch * if to_the_right { 0.5 } else { -0.5 };
        Self {
            scene: moved,
            element,
            is_rounded: false,
            place: Box::new(move |at| at + by),
            direction: Box::new(|at| at),
        }
    }

    pub fn drive(&self, drive: &Drive) -> Drive {
        let of = |values: &[f64]| self.element.iter().map(|n| n.map_or(0.0, |n| values[n])).collect();
        Drive { amplitudes: of(&drive.amplitudes), phases: of(&drive.phases) }
    }
}

/// The element of a board at the mirrored place.
fn mirrored(element: usize, columns: usize) -> usize {
    element / columns * columns + columns - 1 - element % columns
}

/// A moved scene is solved as well as the other.
pub fn moves_change_no_quality(solved: &Solved, moved: &Moved) {
    let Solved { scene, solution, .. } = solved;
    let method = scene.solver.method;
    if solved.is_stroke_by_best() || traps::are_in(scene) {
        return;
    }
    let foci: Vec<_> = solution
        .foci
        .iter()
        .map(|focus| Focus { position: (moved.place)(focus.position), ..*focus })
        .collect();
    if foci.iter().any(|focus| focus.position.abs().max_element() > 100.0) {
        return;
    }
    let (targets, motion) = (as_points(&foci), Motion::default());
    let other = solve(&Scene { targets, motion, ..moved.scene.clone() }).unwrap();
    let places = |foci: &[Focus]| foci.iter().map(|focus| (focus.position, focus.target)).collect::<Vec<_>>();
    assert_eq!(places(&other.foci), places(&foci));
    let moduli = |solution: &Solution| solution.pressures.iter().map(|p| p.norm()).collect::<Vec<_>>();
    let (before, after) = (moduli(solution), moduli(&other));
    let sum = before.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let what = format!("moved, {}", method.into_str());
    if method == Method::Greedy {
        // It takes the elements one after the other, in another order now: that it is not three times as loud is all there is to say.
        within(&what, (after.iter().sum::<f64>() / sum - 1.0).abs(), 2.0);
        return;
    }
    // What the others find depends on the foci and their transfer alone, which stay but for rounding, and iterations make more of that.
    let furthest = before.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let most = if moved.is_rounded && method == Method::Best { 0.1 } else { 1e-4 };
    within(&what, furthest / sum, most);
}
