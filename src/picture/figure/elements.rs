//! The plot of an array seen from the front, every driven element a disc in the colour of its phase or amplitude.

use std::f64::consts::PI;

use glam::DVec2;

use crate::field::phase_index;
use crate::picture::ColourMap;
use crate::picture::figure::layout::{Axis, Bar, Frame, Pen, Room};
use crate::picture::figure::mark::{BLACK, Ink, Mark};
use crate::scene::{ElementModel, Scene, chart};

const EMPTY: Ink = [244, 244, 246];
const SILENT: Ink = [214, 214, 218];

/// Elements with their colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Elements {
    axes: [Axis; 2],
    /// Centres, mm on the axes, with their colours.
    discs: Vec<([f64; 2], Ink)>,
    /// Half the sides of an element, mm on the axes.
    half: DVec2,
    is_round: bool,
    bar: Bar,
}

impl Elements {
    /// The phases of a drive; elements without amplitude are grey.
    pub fn phases(scene: &Scene, phases: &[f64], amplitudes: &[f64]) -> Self {
        let table = ColourMap::Cyclic.table();
        let numbers = [(-PI, "−π"), (-PI / 2.0, "−π/2"), (0.0, "0"), (PI / 2.0, "π/2"), (PI, "π")];
        let numbers = Some(numbers.map(|(value, text)| (value, text.to_owned())).to_vec());
        let bar = Bar { table, ends: [-PI, PI], label: "phase / rad".to_owned(), numbers, mark: None };
        Self::new(scene, bar, amplitudes, |n| table[phase_index(phases[n])])
    }

    /// The amplitudes `of` elements, relative to the largest; those that a drive leaves silent are grey.
    pub fn amplitudes(scene: &Scene, of: &[f64], amplitudes: &[f64]) -> Self {
        let table = ColourMap::Viridis.table();
        let bar = Bar { table, ends: [0.0, 1.0], label: "amplitude".to_owned(), numbers: None, mark: None };
        Self::new(scene, bar, amplitudes, |n| table[(of[n].clamp(0.0, 1.0) * 255.0).round() as usize])
    }

    /// Values between two ends, NaN grey.
    pub fn values(scene: &Scene, values: &[f64], ends: [f64; 2], label: &str, colours: ColourMap) -> Self {
        let table = colours.table();
        let bar = Bar { table, ends, label: label.to_owned(), numbers: None, mark: None };
        let known: Vec<_> = values.iter().map(|value| f64::from(u8::from(!value.is_nan()))).collect();
        let [low, high] = ends;
        let place = |n: usize| ((values[n] - low) / (high - low)).clamp(0.0, 1.0) * 255.0;
        Self::new(scene, bar, &known, |n| table[place(n).round() as usize])
    }

    fn new(scene: &Scene, bar: Bar, amplitudes: &[f64], colour: impl Fn(usize) -> [u8; 4]) -> Self {
        let chart = chart::Chart::new(scene);
        let axis =
            |size: f64, label: &str| Axis { ends: [-500.0 * size, 500.0 * size], label: label.to_owned() };
        let axes = [axis(chart.size.x, "x / mm"), axis(chart.size.y, "y / mm")];
        let disc = |(n, &place): (usize, &DVec2)| {
            let DVec2 { x, y } = (place - chart.size / 2.0) * 1e3;
            let [r, g, b, _] = colour(n);
            ([x, y], if amplitudes[n] > 0.0 { [r, g, b] } else { SILENT })
        };
        let discs = chart.places.iter().enumerate().map(disc).collect();
        let half = scene.array.element_half().min(DVec2::splat(chart.cell * 0.5)) * 1e3;
        Self { axes, discs, half, is_round: scene.array.element != ElementModel::Rectangle, bar }
    }

    /// Height over width.
    pub(in crate::picture) fn shape(&self) -> f64 {
        self.axes[1].ends[1] / self.axes[0].ends[1]
    }

    pub(in crate::picture) fn room(&self) -> Room {
        Room::of_axes(&self.axes, Some(&self.bar))
    }

    pub(in crate::picture) fn marks(&self, frame: &Frame) -> Vec<Mark> {
        let mut pen = Pen::new(frame);
        let [x, _] = &self.axes;
        let half = self.half * frame.size()[0] / (x.ends[1] - x.ends[0]);
        pen.list.push(Mark::Block { corner: frame.corner(), size: frame.size(), ink: EMPTY });
        let disc = |&(at, ink): &([f64; 2], Ink)| {
            let centre = frame.place(&self.axes, at);
            if self.is_round {
                return Mark::Disc { centre, radius: half.x, ink };
            }
            let corner = [centre[0] - half.x, centre[1] - half.y];
            Mark::Block { corner, size: [2.0 * half.x, 2.0 * half.y], ink }
        };
        pen.list.extend(self.discs.iter().map(disc));
        pen.frame(BLACK);
        pen.axes(&self.axes);
        pen.bar(&self.bar);
        pen.list
    }
}
