//! The field in a box: a box that suits a scene, and its values on a lattice as a file.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, bail};
use glam::{DVec3, UVec3};

use crate::field::volume::{Block, Lattice, MOST_POINTS, MOST_POINTS_ALONG};
use crate::field::{Map, Quantity, Request, Stages, missed};
use crate::picture::numbers::Numbers;
use crate::picture::vti::ImageData;
use crate::rounding::millimetres;
use crate::studio::evaluator::{Backend, or_by_cpu};
use crate::studio::space::block_of;
use crate::studio::still::{Diagram, Look, Solved};
use crate::studio::{figure, map, output};

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
    /// An unknown or missing extension.
    pub fn of(path: &Path) -> anyhow::Result<Self> {
        figure::refuse_ending(path, &["vti", "npy"])?;
        match path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).as_deref() {
            Some("vti") => Ok(Self::Vti),
            Some(_) => Ok(Self::Npy),
            None => bail!("{}: name the volume .vti (VTK ImageData) or .npy (NumPy)", path.display()),
        }
    }
}

/// The request for a volume.
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
    /// A quantity without a volume, or too many points.
    pub fn check(&self) -> anyhow::Result<()> {
        let Self { quantity, counts, output, .. } = self;
        Format::of(output)?;
        let declaration = quantity.declaration();
        if declaration.is_pressed() {
            let surface = if declaration.of_skin { "the skin" } else { "a liquid's surface" };
            bail!("{} is of {surface} and has no volume", declaration.words);
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
    /// A warning if the tolerance was not kept.
    pub missed: Option<String>,
}

/// Computes a volume, layer by layer, and writes it.
///
/// # Errors
/// The errors of [`Wish::check`], a field that cannot be computed, or a file that cannot be written.
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
    let mut layers = Vec::new();
    let mut layer = |z: u32| {
        request.plane = lattice.layer(z, scene.plane.tolerance);
        let map = or_by_cpu(stages, gpu_is_asked_for, |stages| stages.map(&request).cloned())?;
        layers.push(map.without_values());
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
    let Whole { peak, loudest, error } = Whole::of(&layers);
    let missed = missed(error, quantity.declaration().tolerance(scene));
    let mm = |v: DVec3| v.to_array().map(|length| millimetres(length, 1)).join(", ");
    let line = format!(
        "{}: {} x {} x {} points from ({}) mm, ({}) mm apart, {}",
        crate::echo::path(path),
        counts.x,
        counts.y,
        counts.z,
        mm(lattice.first),
        mm(lattice.step),
        match peak {
            0.0 => "no sound reaches the box".to_owned(),
            _ if loudest > peak => format!("{}, {}", map::extent(quantity, peak), map::LARGER),
            _ => map::extent(quantity, peak),
        }
    );
    Ok(Written { line, missed })
}

/// The figures of all layers, as those of a [`Map`].
struct Whole {
    peak: f64,
    loudest: f64,
    /// Relative to the peak or to a larger value itself.
    error: f64,
}

impl Whole {
    fn of(layers: &[Map]) -> Self {
        // Where all pixels of a layer are near elements, its peak is of them.
        let is_clear = |layer: &&Map| layer.near < layer.width * layer.height;
        let has_clear = layers.iter().any(|layer| is_clear(&layer));
        let counted = layers.iter().filter(|layer| is_clear(layer) || !has_clear);
        let peak = counted.map(|layer| f64::from(layer.peak)).fold(0.0, f64::max);
        let loudest = layers.iter().map(|layer| f64::from(layer.loudest)).fold(0.0, f64::max);
        let part = |layer: &Map| if peak > 0.0 { (f64::from(layer.peak) / peak).min(1.0) } else { 0.0 };
        let error = layers.iter().map(|layer| layer.error * part(layer)).fold(0.0, f64::max);
        Self { peak, loudest, error }
    }
}
