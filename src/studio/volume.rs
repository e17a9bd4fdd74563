//! The field in space: the box that suits a scene, and its values at a lattice as a file.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, bail};
use glam::{DVec3, UVec3};

use crate::acoustics::Aperture;
use crate::field::volume::{Block, Lattice, MOST_POINTS, MOST_POINTS_ALONG};
use crate::field::{Quantity, Request, Stages, missed};
use crate::picture::export::Numbers;
use crate::picture::vti::ImageData;
use crate::scene::{Focus, Scene};
use crate::studio::evaluator::{Backend, or_by_cpu};
use crate::studio::still::{Diagram, Look, Solved};
use crate::studio::{figure, map, output};

/// m, sides of a box.
pub const SIDES: [f64; 2] = [1e-4, 10.0];

/// How a volume is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// VTK ImageData.
    Vti,
    /// NumPy's, shape (NZ, NY, NX).
    Npy,
}

impl Format {
    /// By a file's ending.
    ///
    /// # Errors
    /// Another ending, or none.
    pub fn of(path: &Path) -> anyhow::Result<Self> {
        figure::refuse_ending(path, &["vti", "npy"])?;
        match path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).as_deref() {
            Some("vti") => Ok(Self::Vti),
            Some(_) => Ok(Self::Npy),
            None => bail!("{}: name the volume .vti (VTK ImageData) or .npy (NumPy)", path.display()),
        }
    }
}

/// The box of a scene: its targets and its plane, most of the way to the boards, and a quarter more beyond where no board ends it.
pub fn block_of(scene: &Scene, aperture: &Aperture, foci: &[Focus]) -> Block {
    /// Of its longest side, the least that a side is.
    const FLATTEST: f64 = 0.5;
    /// Of a mirror's normal, what runs along an axis where it counts as across it.
    const UPRIGHT: f64 = 0.999;
    const BEYOND: f64 = 0.3;
    /// Of the way from a board to what it sounds on, what is left out: the near field tells little, and hides much.
    const NEAR: f64 = 0.15;
    let (x, y) = scene.plane.axes().unwrap_or((DVec3::X, DVec3::Y));
    let half = (x * scene.plane.size.x).abs() / 2.0 + (y * scene.plane.size.y).abs() / 2.0;
    let (mut low, mut high) = (scene.plane.centre - half, scene.plane.centre + half);
    for focus in foci {
        (low, high) = (low.min(focus.position), high.max(focus.position));
    }
    let wavelength = aperture.wavelength();
    let mut is_closed_above = false;
    for board in aperture.boards() {
        let normal = board.pose.world_direction(DVec3::Z);
        let axis = normal.abs().max_position();
        let places = aperture.positions[board.elements()].iter().map(|at| at[axis]);
        if normal[axis] > 0.0 {
            let first = places.fold(f64::INFINITY, f64::min) + wavelength;
            low[axis] = low[axis].min(first + NEAR * (low[axis] - first));
        } else {
            let last = places.fold(f64::NEG_INFINITY, f64::max) - wavelength;
            high[axis] = high[axis].max(last - NEAR * (last - high[axis]));
            is_closed_above |= axis == 2;
        }
    }
    // Behind what reflects there is no sound.
    for mirror in scene.mirrors() {
        let normal = mirror.normal.normalize_or_zero();
        let axis = normal.abs().max_position();
        let place = mirror.point[axis];
        if normal[axis] < -UPRIGHT
            && place > low[axis]
            && place <= high[axis] + BEYOND * (high[axis] - low[axis])
        {
            high[axis] = place;
            is_closed_above |= axis == 2;
        } else if normal[axis] > UPRIGHT && (low[axis]..high[axis]).contains(&place) {
            low[axis] = place;
        }
    }
    if !is_closed_above {
        high.z += BEYOND * (high.z - low.z);
    }
    let least = FLATTEST * (high - low).max_element();
    let centre = (low + high) / 2.0;
    // A vertical plane has no depth, which is as wide as it is then.
    for axis in 0..2 {
        let side = (high[axis] - low[axis]).max(least);
        (low[axis], high[axis]) = (centre[axis] - side / 2.0, centre[axis] + side / 2.0);
    }
    let side = (high - low).clamp(DVec3::splat(SIDES[0]), DVec3::splat(SIDES[1]));
    Block { centre: (low + high) / 2.0, size: side }
}

/// What a volume is asked for by.
#[derive(Clone, Debug)]
pub struct Wish<'a> {
    pub quantity: Quantity,
    /// Points along x, y and z.
    pub counts: UVec3,
    /// Instead of the scene's own box.
    pub block: Option<Block>,
    pub output: &'a Path,
}

impl Wish<'_> {
    /// # Errors
    /// What has no volume, or too many points.
    pub fn check(&self) -> anyhow::Result<()> {
        let Self { quantity, counts, output, .. } = self;
        Format::of(output)?;
        if quantity.declaration().of_liquid {
            bail!("{} is of a liquid's surface and has no volume", quantity.declaration().words);
        }
        let points = counts.as_u64vec3().element_product();
        if counts.min_element() < 1 || counts.max_element() > MOST_POINTS_ALONG || points > MOST_POINTS {
            bail!(
                "--volume {},{},{}: from 1 to {MOST_POINTS_ALONG} points along an axis, and at most {MOST_POINTS} in all",
                counts.x,
                counts.y,
                counts.z
            );
        }
        Ok(())
    }
}

/// A volume as it was written, for people.
#[derive(Debug)]
pub struct Written {
    pub line: String,
    /// Where the tolerance was not kept.
    pub missed: Option<String>,
}

/// Computes a volume, layer by layer, and writes it.
///
/// # Errors
/// As [`Wish::check`], a field that cannot be computed, or a file that cannot be written.
pub fn write(solved: &Solved, stages: &mut Stages, look: &Look, wish: &Wish<'_>) -> anyhow::Result<Written> {
    wish.check()?;
    let Solved { scene, solution, .. } = solved;
    let Wish { quantity, counts, output: path, .. } = *wish;
    let mut request = Request::new(
        scene,
        Look { diagram: Diagram::Map(quantity), ..look.clone() }.drives(solved)?,
        quantity,
        (counts.x as usize, counts.y as usize),
    );
    let block = wish.block.unwrap_or_else(|| block_of(scene, &request.aperture, &solution.foci));
    let lattice = Lattice::of_cells(&block, counts);
    let gauge = (look.begin)("the volume");
    let gpu_is_asked_for = look.backend == Backend::Gpu;
    let (mut peak, mut off) = (0.0f64, 0.0f64);
    let mut layer = |z: u32| {
        request.plane = lattice.layer(z, scene.plane.tolerance);
        let map = or_by_cpu(stages, gpu_is_asked_for, |stages| stages.map(&request).cloned())?;
        peak = peak.max(map.peak.into());
        off = off.max(map.error * f64::from(map.peak));
        gauge.tell(z as usize + 1, counts.z as usize);
        anyhow::Ok(map.values)
    };
    output::write_by(path, |file: &mut dyn Write| {
        match Format::of(path)? {
            Format::Vti => {
                let name = quantity.declaration().name;
                let mut data = ImageData::new(file, name, lattice.first, lattice.step, counts)?;
                (0..counts.z).try_for_each(|z| anyhow::Ok(data.add(&layer(z)?)?))?;
                data.finish()?;
            }
            Format::Npy => {
                let mut data = Numbers::new(file, &[counts.z, counts.y, counts.x].map(u64::from))?;
                (0..counts.z).try_for_each(|z| anyhow::Ok(data.add(&layer(z)?)?))?;
                data.finish()?;
            }
        }
        Ok(())
    })
    .with_context(|| solved.name.clone())?;
    let missed = if peak > 0.0 { missed(off / peak, scene.plane.tolerance) } else { None };
    let mm = |v: DVec3| format!("{:.1}, {:.1}, {:.1}", v.x * 1e3, v.y * 1e3, v.z * 1e3);
    let line = format!(
        "{}: {} x {} x {} points from ({}) mm, ({}) mm apart, {}",
        crate::echo::path(path),
        counts.x,
        counts.y,
        counts.z,
        mm(lattice.first),
        mm(lattice.step),
        if peak == 0.0 { "no sound reaches the box".to_owned() } else { map::extent(quantity, peak) }
    );
    Ok(Written { line, missed })
}
