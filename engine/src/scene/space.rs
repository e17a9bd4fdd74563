//! Boards and reflectors in space, and arrays with arbitrary element positions.

use std::collections::HashSet;

use crate::scene::board::{Board, PARALLEL, Placed, Reflector};
use crate::scene::range::{Key, KeyError, direction, point, refuse, within};
use crate::scene::{array::Array, content::Scene, wires::Wires};
use glam::{DMat3, DVec3};

/// Limit of elements on all boards: 256 x 256.
pub const MOST_ELEMENTS: u64 = 65_536;

/// Limits of boards and reflectors.
const MOST_BOARDS: usize = 64;

const MOST_REFLECTORS: usize = 16;

/// Tolerated overlap of boards and reflectors (m), for rounding.
const SLACK: f64 = 1e-6;

/// The size of an array, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// The longest side of its bounding box.
    pub extent: f64,
    /// Distance of neighbours: the median of some elements; 0 for a single one.
    pub spacing: f64,
}

impl Size {
    pub fn of(places: &[Placed]) -> Self {
        /// Elements whose neighbours are searched.
        const SAMPLES: usize = 16;
        let bounds =
            places.iter().fold((DVec3::MAX, DVec3::MIN), |(low, high), it| (low.min(it.at), high.max(it.at)));
        let nearest = |n: usize| {
            let others = (0..places.len()).filter(|&other| other != n);
            others.map(|other| places[n].at.distance(places[other].at)).fold(f64::INFINITY, f64::min)
        };
        let step = places.len().div_ceil(SAMPLES).max(1);
        let mut distances: Vec<_> = (0..places.len()).step_by(step).map(nearest).collect();
        distances.sort_unstable_by(f64::total_cmp);
        let spacing = if places.len() > 1 { distances[distances.len() / 2] } else { 0.0 };
        Self { extent: (bounds.1 - bounds.0).max_element().max(0.0), spacing }
    }
}

/// The region of sound: in front of some board, or of some element of a curved board.
#[derive(Clone, Debug)]
pub struct Front(Vec<(DVec3, DVec3)>);

impl Front {
    pub fn contains(&self, place: DVec3) -> bool {
        self.0.iter().any(|(at, normal)| is_before(normal.dot(place - at)))
    }

    /// A point of an object that is not entirely in front of any board; `lowest` finds its lowest point along a
    /// direction.
    pub fn outside(&self, lowest: impl FnMut(DVec3) -> Option<DVec3>) -> Option<DVec3> {
        self.outside_moved(&self.lowest(lowest), DVec3::ZERO)
    }

    /// The lowest points of an object along the direction of radiation of each board.
    pub fn lowest(&self, lowest: impl FnMut(DVec3) -> Option<DVec3>) -> Vec<DVec3> {
        self.0.iter().map(|(_, normal)| *normal).filter_map(lowest).collect()
    }

    /// The answer of [`Front::outside`] for a moved object with known lowest points.
    pub fn outside_moved(&self, lowest: &[DVec3], by: DVec3) -> Option<DVec3> {
        let is_in_front =
            |((at, normal), place): (&(DVec3, DVec3), &DVec3)| is_before(normal.dot(*place + by - at));
        let first = lowest.first()? + by;
        (!self.0.iter().zip(lowest).any(is_in_front)).then_some(first)
    }

    /// Whether some board radiates towards a direction.
    pub(crate) fn is_ahead(&self, direction: DVec3) -> bool {
        self.0.iter().any(|(_, normal)| is_before(normal.dot(direction)))
    }

    /// Text for directions away from all boards.
    pub(crate) fn ahead(&self) -> &'static str {
        match &self.0[..] {
            [(_, normal)] if *normal == DVec3::Z => {
                "the array radiates towards +z, so give a positive z, and no reflector across it"
            }
            _ => "it points away from every board, or behind a reflector",
        }
    }

    /// Text for objects behind all boards.
    pub fn behind(&self) -> &'static str {
        match &self.0[..] {
            [face] if *face == (DVec3::ZERO, DVec3::Z) => {
                "on or behind the array, which lies in z = 0 and radiates towards +z"
            }
            [_] => "on or behind the array",
            _ => "on or behind every board of the array",
        }
    }
}

/// Whether a height (m) is in front of a board. NaN counts as in front and is refused elsewhere.
fn is_before(height: f64) -> bool {
    height > 0.0 || height.is_nan()
}

impl Array {
    /// Whether its element table is not yet loaded.
    pub fn lacks_elements(&self) -> bool {
        self.file.is_some() && self.placed.get().is_none()
    }

    /// Whether its table of wires is not yet loaded.
    pub fn lacks_wires(&self) -> bool {
        self.wiring.is_some() && self.wires.get().is_none()
    }

    /// Positions (m) and directions of radiation of its elements in its own coordinates.
    pub fn places(&self) -> Vec<Placed> {
        if let Some(placed) = self.placed.get() {
            return placed.to_vec();
        }
        let last = DVec3::new(f64::from(self.columns - 1), f64::from(self.rows - 1), 0.0);
        let at = |row: u32, column: u32| {
            (DVec3::new(f64::from(column), f64::from(row), 0.0) - last / 2.0) * self.pitch
        };
        let of_row = |row: u32| (0..self.columns).map(move |column| (row, column));
        let places = (0..self.rows).flat_map(of_row);
        places.map(|(row, column)| Placed { at: at(row, column), normal: DVec3::Z }).collect()
    }
}

impl Scene {
    /// Elements of all boards, driven or not.
    pub fn elements(&self) -> usize {
        self.array.elements() * self.boards.len().max(1)
    }

    /// The wires of its elements: of the named table, or else of the board's own file. Without, a board's own order
    /// applies.
    pub fn wires(&self) -> Option<&Wires> {
        let array = &self.array;
        let wires = if array.wiring.is_some() { &array.wires } else { &array.placed.wires };
        wires.get().map(|_| wires)
    }

    /// Elements that are wired and not off, in ascending order.
    pub fn driven(&self) -> Vec<usize> {
        let off: HashSet<_> = self.array.off.iter().collect();
        let (wires, each) = (self.wires(), self.array.elements());
        let is_wired = |n: usize| wires.is_none_or(|wires| wires.wire(n, each).is_some());
        (0..self.elements()).filter(|n| !off.contains(n) && is_wired(*n)).collect()
    }

    /// The boards of the scene, or the default board.
    pub fn standing(&self) -> Vec<Board> {
        if self.boards.is_empty() { vec![Board::default()] } else { self.boards.clone() }
    }

    /// Whether the array is a single flat board of rows and columns, centred in z = 0 and radiating towards +z.
    pub fn is_home(&self) -> bool {
        (self.boards.is_empty() || self.boards == [Board::default()]) && self.array.file.is_none()
    }

    /// The region in front of the boards.
    pub fn front(&self) -> Front {
        let mut faces: Vec<(DVec3, DVec3)> = Vec::new();
        let placed = if self.array.file.is_some() { self.array.places() } else { Vec::new() };
        for board in self.standing() {
            let axes = board.axes().unwrap_or(DMat3::IDENTITY);
            if self.array.file.is_none() {
                faces.push((board.at, axes.z_axis));
            }
            for it in &placed {
                let face = (board.at + axes * it.at, axes * it.normal);
                // All elements of a flat board have the same front.
                if faces.last().is_none_or(|last| last.1 != face.1 || last.1.dot(face.0 - last.0) != 0.0) {
                    faces.push(face);
                }
            }
        }
        Front(faces)
    }

    /// Whether sound goes to infinity in a direction: radiated by some board, and behind no reflector.
    pub(crate) fn hears(&self, direction: DVec3) -> bool {
        self.front().is_ahead(direction)
            && self.mirrors().iter().all(|mirror| mirror.normal.dot(direction) >= 0.0)
    }

    /// All reflectors, the liquid's surface last.
    pub fn mirrors(&self) -> Vec<Reflector> {
        let surface = self.liquid.reflects.then(|| self.surface());
        self.reflectors.iter().cloned().chain(surface).collect()
    }

    /// The liquid's surface, which is the scene's plane, as a reflector.
    pub fn surface(&self) -> Reflector {
        let (point, up) = (self.plane.centre, self.plane.axes().map_or(DVec3::Z, |(x, y)| x.cross(y)));
        let first = self.boards.first().map_or(DVec3::ZERO, |board| board.at);
        let normal = if up.dot(first - point) < 0.0 { -up } else { up };
        Reflector { point, normal, coefficient: crate::scene::liquid::REFLECTION }
    }
}

/// Checks boards and reflectors, one by one and together.
pub(crate) fn check(scene: &Scene) -> Result<(), KeyError> {
    limit("board", scene.boards.len(), MOST_BOARDS)?;
    limit("reflector", scene.reflectors.len(), MOST_REFLECTORS)?;
    for (index, board) in scene.boards.iter().enumerate() {
        self::board(board).map_err(|e| e.under(&["board".into(), index.into()]))?;
    }
    for (index, reflector) in scene.reflectors.iter().enumerate() {
        self::reflector(reflector).map_err(|e| e.under(&["reflector".into(), index.into()]))?;
    }
    let all = scene.elements() as u64;
    if all > MOST_ELEMENTS {
        let (boards, each) = (scene.boards.len(), scene.array.elements());
        let message = format!("{boards} boards of {each} elements have {all}: the limit is {MOST_ELEMENTS}");
        return refuse("board", message);
    }
    if scene.liquid.reflects
        && scene.plane.axes().is_none_or(|(x, y)| x.cross(y).truncate().length() > PARALLEL)
    {
        let message = "the liquid's surface is the scene's plane, which has to be level for that: `plane.x_axis` and \
                       `plane.y_axis` are not; draw other planes with a [[reflector]] in the place of the surface";
        return Err(KeyError::new([Key::from("liquid"), Key::from("reflects")], message));
    }
    if scene.array.lacks_elements() {
        return Ok(());
    }
    apart(scene)?;
    clear_of_reflectors(scene)?;
    converges(scene)
}

fn limit(key: &'static str, count: usize, most: usize) -> Result<(), KeyError> {
    if count <= most {
        Ok(())
    } else {
        refuse(key, format!("{count} are more than the {most} that a scene may have"))
    }
}

fn board(board: &Board) -> Result<(), KeyError> {
    point("at", board.at)?;
    direction("normal", board.normal)?;
    direction("x_axis", board.x_axis)?;
    if board.axes().is_none() {
        return refuse(
            "x_axis",
            "runs along `normal`: growing columns run across the direction of radiation",
        );
    }
    Ok(())
}

fn reflector(reflector: &Reflector) -> Result<(), KeyError> {
    point("point", reflector.point)?;
    direction("normal", reflector.normal)?;
    within("coefficient", reflector.coefficient, -1.0, 1.0, "(1: rigid, 0: none, -1: soft)")
}

/// Boards do not overlap.
fn apart(scene: &Scene) -> Result<(), KeyError> {
    if scene.boards.len() < 2 {
        return Ok(());
    }
    let (low, high) = bounds(scene);
    let slabs: Vec<_> = scene.boards.iter().map(|board| Slab::new(board, low, high)).collect();
    for (index, slab) in slabs.iter().enumerate() {
        if let Some(other) = slabs[..index].iter().position(|other| slab.meets(other)) {
            let message = format!("the board overlaps board {}", other + 1);
            return Err(KeyError::new([Key::from("board"), Key::from(index), Key::from("at")], message));
        }
    }
    Ok(())
}

/// The box around the centres of the array's elements, in its own coordinates, m.
fn bounds(scene: &Scene) -> (DVec3, DVec3) {
    let placed = scene.array.places();
    let places = placed.iter().map(|it| it.at);
    places.fold((DVec3::MAX, DVec3::MIN), |(low, high), at| (low.min(at), high.max(at)))
}

/// A board as a box.
struct Slab {
    middle: DVec3,
    axes: [DVec3; 3],
    half: DVec3,
}

impl Slab {
    fn new(board: &Board, low: DVec3, high: DVec3) -> Self {
        let axes = board.axes().unwrap_or(DMat3::IDENTITY);
        Self {
            middle: board.world((low + high) / 2.0),
            axes: [axes.x_axis, axes.y_axis, axes.z_axis],
            half: (high - low) / 2.0,
        }
    }

    /// Whether two boxes intersect, by the separating axis theorem.
    fn meets(&self, other: &Self) -> bool {
        let across = self.axes.iter().flat_map(|a| other.axes.iter().map(move |b| a.cross(*b)));
        let directions = self.axes.into_iter().chain(other.axes).chain(across);
        directions.filter_map(DVec3::try_normalize).all(|direction| {
            let between = direction.dot(other.middle - self.middle).abs();
            between < self.reach(direction) + other.reach(direction) + SLACK
        })
    }

    fn reach(&self, direction: DVec3) -> f64 {
        (0..3).map(|i| self.half[i] * self.axes[i].dot(direction).abs()).sum()
    }
}

/// All elements are on the sound side of all reflectors.
fn clear_of_reflectors(scene: &Scene) -> Result<(), KeyError> {
    let mirrors = scene.mirrors();
    if mirrors.is_empty() {
        return Ok(());
    }
    let placed = scene.array.places();
    for (number, board) in scene.standing().iter().enumerate() {
        let places: Vec<_> = placed.iter().map(|it| board.world(it.at)).collect();
        for (index, mirror) in mirrors.iter().enumerate() {
            let heights = places.iter().map(|&place| mirror.height(place));
            let (least, most) =
                heights.fold((f64::MAX, f64::MIN), |(least, most), it| (least.min(it), most.max(it)));
            if least > SLACK {
                continue;
            }
            let how = match most {
                _ if most <= -SLACK => "lies behind it: its normal points towards the sound",
                _ if most <= SLACK => "lies in it: `array.reflectivity` is that of the array's own face",
                _ => "is cut by it",
            };
            let message = format!("board {} {how}", number + 1);
            let key = match scene.reflectors.get(index) {
                Some(_) => vec![Key::from("reflector"), Key::from(index), Key::from("point")],
                None => vec![Key::from("liquid"), Key::from("reflects")],
            };
            return Err(KeyError::new(key, message));
        }
    }
    Ok(())
}

/// The series of reflections between the array's face and a parallel reflector converges.
fn converges(scene: &Scene) -> Result<(), KeyError> {
    /// Limit of the round-trip factor.
    const MOST: f64 = 1.0 - 1e-9;
    let own = scene.array.reflectivity;
    for mirror in scene.mirrors() {
        let is_between = scene.standing().iter().any(|board| mirror.faces(board));
        if is_between && (own * mirror.coefficient).abs() > MOST {
            let message = "the reflections between the array's face and an equally perfect reflector do not converge: one of \
                           them must be below 1";
            return Err(KeyError::new([Key::from("array"), Key::from("reflectivity")], message));
        }
    }
    Ok(())
}
