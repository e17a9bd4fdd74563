//! What holds of every trap: its drive balances the weight or is no less stiff than the first, the maps show the bead's potential, and a move changes no force.

use std::f64::consts::PI;

use glam::DVec3;
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::{Quantity, Request, Samples, Stages};
use sonoglyph::force::Levitation;
use sonoglyph::scene::{
    Bead, ElementModel, Focus, Material, Motion, MotionPath, Part, Scene, Shape, Target, Trap,
};
use sonoglyph::solver::{Problem, trap};
use strum::VariantArray;

use crate::dice::Dice;
use crate::random::fields::{Evaluators, WIDEST, f32_error, moduli};
use crate::random::solving::{Moved, Solved, rounding};
use crate::random::tally::{count, within};

const SIZE: (usize, usize) = (12, 9);
/// The finest tolerance of what is formed at cells.
const FINEST: f64 = 1e-6;
/// Wavelengths, within which a trap of any drawn kind has its lobes.
const WIDE: f64 = 1.2;

/// The same scene with a bead and up to three traps, sometimes beside a point, instead of its targets.
pub fn trapped(scene: &Scene, dice: &mut Dice) -> Scene {
    let wavelength = scene.wavelength();
    let centre = scene.plane.centre.with_z(scene.plane.centre.z.max(3.0 * wavelength));
    let mut place = |i: u32| {
        let mut part = || dice.between(-0.5, 0.5) * wavelength;
        let beside = DVec3::X * f64::from(i) * 2.0 * WIDE * wavelength;
        centre + beside + DVec3::new(part(), part(), part())
    };
    let places: Vec<_> = (0..4).map(&mut place).collect();
    let traps = dice.whole(1, 3) as usize;
    let mut targets: Vec<_> = places[..traps].iter().map(|&at| target(at, dice)).collect();
    if dice.of(0.3) {
        targets.push(Target::new(Shape::Point { at: places[3] }));
    }
    let motion = match scene.motion.path {
        MotionPath::Circle | MotionPath::Line | MotionPath::Square => scene.motion.clone(),
        _ => Motion::default(),
    };
    Scene { targets, motion, bead: bead(dice), ..scene.clone() }
}

fn target(at: DVec3, dice: &mut Dice) -> Target {
    let (trap, charge) = (dice.one_of(Trap::VARIANTS), dice.one_of(&[1, 1, -1, 2]));
    let tilt = DVec3::new(dice.between(-0.3, 0.3), dice.between(-0.3, 0.3), 1.0);
    let normal = if dice.of(0.3) { tilt } else { DVec3::Z };
    Target { angle: dice.between(-PI, PI), normal, ..Target::new(Shape::Trap { at, trap, charge }) }
}

fn bead(dice: &mut Dice) -> Bead {
    let given = dice.of(0.3);
    Bead {
        material: dice.one_of(Material::VARIANTS),
        density: given.then(|| dice.magnitude(1e-2, 1e5)),
        sound_speed: given.then(|| dice.magnitude(1.0, 1e5)),
        radius: dice.magnitude(1e-6, 1e-3),
    }
}

pub fn are_in(scene: &Scene) -> bool {
    scene.targets.iter().any(|target| matches!(target.shape, Shape::Trap { .. }))
}

/// Every invariant of a scene's traps and its bead.
pub fn hold(evaluators: &mut Evaluators, solved: &Solved, moved: &Moved, dice: &mut Dice) {
    if !are_in(&solved.scene) {
        return;
    }
    count("traps");
    let levitation = of(&solved.scene, &solved.aperture, &solved.solution.drive);
    the_drive_balances_or_is_no_less_stiff_than_the_first(solved);
    moves_change_no_force(solved, &levitation, moved);
    the_map_is_the_beads_potential(&mut evaluators.cpu, solved, &levitation, dice);
    if let Some(gpu) = &mut evaluators.gpu {
        the_map_is_the_beads_potential(gpu, solved, &levitation, dice);
    }
}

fn of(scene: &Scene, aperture: &Aperture, drive: &Drive) -> Levitation {
    Levitation::new(scene, aperture, std::slice::from_ref(drive))
}

/// J: the bound of the potential where all elements' waves arrive in phase.
fn energy(solved: &Solved, levitation: &Levitation, point: DVec3) -> f64 {
    let arriving = moduli(solved, &solved.solution.drive, point);
    arriving * arriving * levitation.sphere.bounds()[0]
}

fn the_drive_balances_or_is_no_less_stiff_than_the_first(solved: &Solved) {
    let Solved { scene, aperture, solution, .. } = solved;
    let problem = Problem::of_scene(scene, aperture, solution.foci.clone());
    let traps = problem.traps.as_ref().unwrap();
    let least = |u: &[_]| traps.weakest(aperture, u).into_iter().fold(f64::INFINITY, f64::min);
    let first = least(&trap::signature(&problem, traps));
    // Pressures in pascals turn the drive down, and stiffness goes with its square.
    let mut drive = solution.drive.clone();
    drive.amplitudes.iter_mut().for_each(|amplitude| *amplitude /= solution.turned_down);
    let found = least(&drive.excitation(&aperture.driven));
    assert!(first.is_finite() && found.is_finite(), "{first} N/m, then {found}");
    let levitation = of(scene, aperture, &drive);
    let lobes = solution.foci.chunk_by(|a, b| a.part == b.part);
    let is_balanced = |lobes: &[Focus]| {
        // The lobes of any kind have their trap in the middle.
        let at = lobes.iter().map(|lobe| lobe.position).sum::<DVec3>() / lobes.len() as f64;
        levitation.net(at).length() < 1e-6 * found / solved.oracle.wavenumber
    };
    let mut traps = lobes.filter(|lobes| matches!(lobes[0].part, Part::Trap(_)));
    if found > 0.0 && traps.all(is_balanced) {
        count("traps that hold");
    } else {
        within("a trap's stiffness", first - found, 1e-9 * first.abs() + f64::MIN_POSITIVE);
    }
}

fn moves_change_no_force(solved: &Solved, levitation: &Levitation, moved: &Moved) {
    let Solved { scene, oracle, solution, .. } = solved;
    let other = of(&moved.scene, &Aperture::new(&moved.scene), &moved.drive(&solution.drive));
    for focus in &solution.foci {
        let at = focus.position;
        let (here, there) = (levitation.forces(at), other.forces((moved.place)(at)));
        assert!(here.force.is_finite() && here.stiffness.is_finite(), "{here:?}");
        let rounding = rounding(oracle, 4.0 * (at.length() + oracle.reach));
        let most = 10.0 * rounding * energy(solved, levitation, at) * oracle.wavenumber + f64::MIN_POSITIVE;
        let off = ((moved.direction)(here.force) - there.force).length();
        within(&format!("a moved force, {:?}", scene.array.element), off, most);
    }
}

/// The bead's potential at pixels, against that of its partial waves in f64.
fn the_map_is_the_beads_potential(
    stages: &mut Stages,
    solved: &Solved,
    levitation: &Levitation,
    dice: &mut Dice,
) {
    let Solved { scene, oracle, solution, .. } = solved;
    let request = Request::new(scene, vec![solution.drive.clone()], Quantity::Gorkov, SIZE);
    let map = stages.map(&request).unwrap();
    let pixels = Samples::on_plane(&scene.plane, SIZE.0, SIZE.1).unwrap();
    let points = (0..map.values.len()).map(|pixel| pixels.point(pixel));
    let largest = points.map(|point| energy(solved, levitation, point)).fold(0.0, f64::max);
    count(&format!("potentials by {:?}", map.by));
    for _ in 0..4 {
        let pixel = dice.whole(0, map.values.len() as u32 - 1) as usize;
        let point = pixels.point(pixel);
        let height = oracle.height(point);
        let is_wide = scene.array.element != ElementModel::Point && oracle.radius > WIDEST * height;
        // Slopes nearer to the array than that are those a little further away.
        if height < 0.5 * oracle.wavelength() || is_wide {
            continue;
        }
        let expected = levitation.forces(point).gorkov;
        let arriving = moduli(solved, &solution.drive, point).max(f64::MIN_POSITIVE);
        let in_f32 = f32_error(solved, &solution.drive, point) / arriving;
        let most = map.error.max(scene.plane.tolerance).max(FINEST) * largest
            + 4.0 * in_f32 * energy(solved, levitation, point);
        let off = (f64::from(map.values[pixel]) - expected).abs();
        within(&format!("potential by {:?}", map.by), off, most + 1e-37);
    }
}
