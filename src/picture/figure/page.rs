//! A page of panels in a grid. All plots of a column are equally wide and all panels of a row begin at one height, so
//! that maps beside each other can be compared.

use crate::picture::Picture;
use crate::picture::figure::curve::{self, Curve};
use crate::picture::figure::elements::Elements;
use crate::picture::figure::font;
use crate::picture::figure::layout::{Content, Frame, GAP, MARGIN, Paper, Room, TITLE};
use crate::picture::figure::mark::{Anchor, BLACK, Figure, Mark};
use crate::picture::figure::polar::Polar;
use crate::picture::figure::space::Space;
use crate::picture::figure::surface::Surface;
use crate::picture::figure::table::Table;

/// Limit of a plot's height relative to the width of its column.
const TALLEST: f64 = 2.0;
/// The least width of a plot, mm.
const LEAST: f64 = 10.0;
/// Space between rows, mm.
const ROWS: f64 = 1.5;

/// A plot without its pixels.
#[derive(Clone, Debug, PartialEq)]
pub enum Plot {
    Map(Content),
    Surface(Surface),
    Space(Space),
    Elements(Elements),
    Curve(Curve),
    Polar(Polar),
    Table(Table),
}

impl Plot {
    fn room(&self) -> Room {
        match self {
            Self::Map(content) => Room::of_axes(&content.axes, content.bar.as_ref()),
            Self::Surface(surface) => surface.room(),
            Self::Space(space) => space.room(),
            Self::Elements(elements) => elements.room(),
            Self::Curve(curve) => curve.room(),
            Self::Polar(polar) => polar.room(),
            Self::Table(_) => Room::default(),
        }
    }

    /// The height of a plot of this width, mm.
    fn height(&self, width: f64) -> f64 {
        match self {
            Self::Map(content) => width * content.shape(),
            Self::Surface(surface) => width * surface.shape(),
            Self::Space(space) => width * space.shape,
            Self::Elements(elements) => width * elements.shape(),
            Self::Curve(_) => width * curve::SHAPE,
            Self::Polar(polar) => polar.height(width),
            Self::Table(table) => table.height(width),
        }
    }

    /// Whether it is drawn on pixels.
    fn has_pixels(&self) -> bool {
        match self {
            Self::Map(_) | Self::Surface(_) | Self::Space(_) => true,
            Self::Elements(_) | Self::Curve(_) | Self::Polar(_) | Self::Table(_) => false,
        }
    }

    fn marks(&self, frame: &Frame, picture: Option<Picture>) -> Vec<Mark> {
        match (self, picture) {
            (Self::Map(content), Some(picture)) => content.marks(frame, picture),
            (Self::Surface(surface), Some(picture)) => surface.marks(frame, picture),
            (Self::Space(space), Some(picture)) => space.marks(frame, picture),
            (Self::Map(_) | Self::Surface(_) | Self::Space(_), None) => Vec::new(),
            (Self::Elements(elements), _) => elements.marks(frame),
            (Self::Curve(curve), _) => curve.marks(frame),
            (Self::Polar(polar), _) => polar.marks(frame),
            (Self::Table(table), _) => table.marks(frame),
        }
    }
}

/// A plot below its title.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    pub title: Option<String>,
    pub plot: Plot,
}

/// Panels in a grid, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    pub paper: Paper,
    pub title: Option<String>,
    /// From 1.
    pub columns: usize,
    pub panels: Vec<Panel>,
}

/// The number of columns for so many panels, unless chosen.
pub fn columns(panels: usize) -> usize {
    (panels as f64).sqrt().ceil().max(1.0) as usize
}

/// The position of a panel.
struct Place {
    frame: Frame,
    /// Edge of its column, mm.
    right: f64,
}

impl Page {
    fn places(&self) -> (Vec<Place>, [usize; 2]) {
        let density = self.paper.dpi / 25.4;
        let in_pixels = |mm: f64| ((mm * density).round() as usize).max(1);
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let rooms: Vec<_> = self.panels.iter().map(|panel| panel.plot.room()).collect();
        let side = |column: usize, of: fn(&Room) -> f64| {
            MARGIN + rooms.iter().skip(column).step_by(columns).map(of).fold(0.0, f64::max)
        };
        let sides: Vec<_> =
            (0..columns).map(|column| [side(column, |it| it.left), side(column, |it| it.right)]).collect();
        let beside: f64 = sides.iter().flatten().sum();
        let room = ((self.paper.width - beside) / columns as f64).max(LEAST);
        let tallest = TALLEST * self.paper.width / columns as f64;
        let mut places = Vec::new();
        let mut top = MARGIN + self.title.as_ref().map_or(0.0, |_| TITLE + 1.5 * GAP);
        let mut bottom = top;
        for (row, (panels, rooms)) in self.panels.chunks(columns).zip(rooms.chunks(columns)).enumerate() {
            // The title above has room for the uppermost number of an axis.
            let is_below_title = row == 0 && self.title.is_some();
            let above = |(panel, room): (&Panel, &Room)| match &panel.title {
                Some(_) => TITLE + 1.5 * GAP,
                None if is_below_title => 0.0,
                None => room.above,
            };
            let corner = top + panels.iter().zip(rooms).map(above).fold(0.0, f64::max);
            let (mut left, mut lowest) = (0.0, corner);
            for ((panel, own), [before, after]) in panels.iter().zip(rooms).zip(&sides) {
                let width = room.min(room * tallest / panel.plot.height(room).max(1e-9));
                let map = [width, panel.plot.height(width)].map(in_pixels);
                left += before;
                // A plot narrower than its space is centred.
                let corner = [in_pixels(left + (room - width) / 2.0), in_pixels(corner)];
                left += room + after;
                lowest = lowest.max((corner[1] + map[1]) as f64 / density + own.below);
                places.push(Place { frame: Frame { density, corner, map }, right: left - MARGIN });
            }
            bottom = lowest;
            top = lowest + ROWS;
        }
        let size = [self.paper.width.max(beside + room * columns as f64), bottom + MARGIN];
        (places, size.map(in_pixels))
    }

    /// Pixels of every panel that is drawn on pixels, width and height: compute it for that many.
    pub fn plots(&self) -> Vec<Option<[usize; 2]>> {
        let sizes = self.places().0.into_iter().map(|place| place.frame.map);
        sizes.zip(&self.panels).map(|(size, panel)| panel.plot.has_pixels().then_some(size)).collect()
    }

    /// Pixels of the PNG, width and height.
    pub fn pixels(&self) -> [usize; 2] {
        self.places().1
    }

    /// The figure with the pixels of [`Self::plots`].
    pub fn figure(&self, pictures: Vec<Option<Picture>>) -> Figure {
        let (places, pixels) = self.places();
        let density = self.paper.dpi / 25.4;
        let mut marks = Vec::new();
        if let (Some(title), Some(first)) = (&self.title, places.first()) {
            let at = [first.frame.corner()[0], MARGIN + TITLE * 0.85];
            let height = font::fitted(title, TITLE, pixels[0] as f64 / density - at[0] - MARGIN);
            marks.push(Mark::text(at, height, Anchor::Start, BLACK, title));
        }
        for ((panel, Place { frame, right }), picture) in self.panels.iter().zip(&places).zip(pictures) {
            marks.extend(panel.plot.marks(frame, picture));
            if let Some(title) = &panel.title {
                let [left, top] = frame.corner();
                let height = font::fitted(title, TITLE, right - left);
                marks.push(Mark::text([left, top - 1.5 * GAP], height, Anchor::Start, BLACK, title));
            }
        }
        Figure { pixels, density, title: self.title.clone().unwrap_or_default(), marks }
    }
}
