//! The sound at the samples of a plan, on the CPU.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex32;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::plan::{Grid, TABLE_CEILING};
use crate::field::quantity::Part;
use crate::field::slope::part_on_cpu;
use crate::field::sources::Wave;
use crate::field::stages::Work;
use crate::field::stages::job::Job;
use crate::field::stages::kept::Kept;
use crate::field::transfer::{Layout, Transfer};
use crate::gauge::Gauge;

/// The pressure at the samples, and its slope along the plane's normal; empty if not needed.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    pressure: Vec<Complex32>,
    normal: Vec<Complex32>,
}

impl Samples {
    pub(super) fn of(&self, part: Part) -> &[Complex32] {
        match part {
            Part::Pressure | Part::AlongX | Part::AlongY => &self.pressure,
            Part::Normal => &self.normal,
        }
    }
}

/// Sums over the elements at the samples of a plan, from tables if memory allows: one per contributing board.
#[derive(Debug, Default)]
pub(super) struct Superposition {
    pressure: Kept<TableKey, Vec<Transfer>>,
    normal: Kept<TableKey, Vec<Transfer>>,
    pub(super) work: Work,
}

/// The inputs of tables. One plane may have several grids: quantities weigh samples against pixels differently.
#[derive(Clone, Debug, PartialEq)]
struct TableKey {
    /// The aperture with every element driven, which makes no difference here.
    aperture: Aperture,
    grid: Grid,
    /// Direction of a slope.
    direction: Option<DVec3>,
}

impl Superposition {
    /// Drops everything except the memory of its tables and the counters.
    pub(super) fn forget(&mut self) {
        (self.pressure.key, self.normal.key) = (None, None);
    }

    /// One part of the sound at the samples, for every drive.
    fn at(
        &mut self,
        job: &Job<'_>,
        grid: &Grid,
        drives: Range<usize>,
        part: Part,
        double: bool,
    ) -> Vec<Vec<Complex32>> {
        let Self { pressure, normal, work } = self;
        work.superposition += 1;
        let aperture = &job.request.aperture.without_bodies();
        let played = &job.request.counted()[drives.clone()];
        let gauge = Gauge::current();
        let each = |(index, drive): (usize, &Drive)| {
            let of_drive = || part_on_cpu(aperture, drive, &grid.samples, part, job.site.axes, double);
            gauge.part(index..index + 1, played.len()).lead(of_drive)
        };
        if double {
            return played.iter().enumerate().map(each).collect();
        }
        let (kept, direction) = match part {
            Part::Pressure | Part::AlongX | Part::AlongY => (pressure, None),
            Part::Normal => (normal, Some(job.site.axes[2])),
        };
        let key =
            TableKey { aperture: job.key.setting.aperture.without_bodies(), grid: grid.clone(), direction };
        let tables = kept.update(&key, |tables| {
            let old = std::mem::take(tables);
            if key.fits() {
                work.transfer += 1;
                *tables = key.tables(old);
            }
        });
        if tables.is_empty() {
            return played.iter().enumerate().map(each).collect();
        }
        let mut fields = vec![vec![Complex32::ZERO; grid.samples.len()]; played.len()];
        for (table, (number, _)) in tables.iter().zip(&grid.heard) {
            table.superpose(&aperture.faces[*number], &job.excitations[drives.clone()], &mut fields);
        }
        fields
    }
}

impl TableKey {
    /// Whether the tables of all boards may be kept.
    fn fits(&self) -> bool {
        let Self { aperture, grid, .. } = self;
        let layouts = grid.heard.iter().map(|&(number, shared)| {
            let face = &aperture.faces[number];
            let samples = grid.samples.seen_from(&face.pose);
            Wave::new(&aperture.element, &face.layout, &samples)?;
            Some(Layout::new(face, &samples, shared))
        });
        let layouts: Option<Vec<_>> = layouts.collect();
        layouts.is_some_and(|layouts| Layout::fit(&layouts, TABLE_CEILING))
    }

    /// The tables of all boards, in the memory of others; none if f32 declines.
    fn tables(&self, old: Vec<Transfer>) -> Vec<Transfer> {
        let Self { aperture, grid, direction } = self;
        let mut old = old.into_iter();
        let table = |&(number, shared): &(usize, _)| {
            let board = (&aperture.element, &aperture.faces[number]);
            Transfer::of_part(board, &grid.samples, shared, *direction, old.next())
        };
        grid.heard.iter().map(table).collect::<Option<_>>().unwrap_or_default()
    }
}

/// The samples of every drive required for the parts.
pub(super) fn sampled(
    superposition: &mut Superposition,
    job: &Job<'_>,
    grid: &Grid,
    drives: Range<usize>,
    double: bool,
) -> Vec<Samples> {
    let mut needs = |normal: bool| {
        let part = Part::of(job.key.parts).find(|&part| (part == Part::Normal) == normal);
        let half = usize::from(normal);
        let mut at = |part| superposition.at(job, grid, drives.clone(), part, double);
        match part {
            Some(part) => Gauge::current().part(half..half + 1, 2).lead(|| at(part)),
            None => vec![Vec::new(); drives.len()],
        }
    };
    let (pressures, normals) = (needs(false), needs(true));
    let pairs = pressures.into_iter().zip(normals);
    pairs.map(|(pressure, normal)| Samples { pressure, normal }).collect()
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::field::plan::Costs;
    use crate::field::plan::Plan;
    use crate::scene::{Array, Board, Scene};

    #[test]
    fn every_board_has_a_table_wherever_tables_fit() {
        let array = Array { columns: 3, rows: 2, ..Array::default() };
        let boards = [-0.03, 0.03].map(|x| Board { at: DVec3::X * x, ..Board::default() }).to_vec();
        let scene = Scene { array, boards, ..Scene::default() };
        let aperture = Aperture::new(&scene);
        let grid = Plan::new(&aperture, &scene.plane, Costs::CPU).unwrap().grid.unwrap();
        for direction in [None, Some(DVec3::Z)] {
            let key = TableKey { aperture: aperture.clone(), grid: grid.clone(), direction };
            assert!(key.fits());
            assert_eq!(key.tables(Vec::new()).len(), 2, "{direction:?}");
        }
    }
}
