//! Limits of bodies, and their distance from boards, reflectors and each other.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::mesh::{Mesh, shapes};
use crate::scene::board::Reflector;
use crate::scene::body::{Body, BodyKind};
use crate::scene::content::Scene;
use crate::scene::range::{Key, KeyError, direction, point, refuse, within};

/// Limit of bodies per scene.
const MOST_BODIES: usize = 16;
/// Limits of radii, m.
const RADII: [f64; 2] = [1e-5, 1.0];
/// Limits of a palm's sides, m.
const SIDES: [f64; 2] = [1e-4, 1.0];
/// Limits of the longest side of a file's body, m.
const SPANS: [f64; 2] = [1e-5, 1.0];
/// The least edge of triangles is above this, m.
const LEAST_EDGE: f64 = 1e-5;
/// Limit of triangles of one body with a given edge.
const MOST_TRIANGLES: f64 = 2e5;
/// Fingers with the largest angles by which they bend, degrees.
pub const FINGERS: [(&str, f64); 5] =
    [("thumb", 90.0), ("index", 110.0), ("middle", 110.0), ("ring", 110.0), ("little", 110.0)];
/// Tolerated overlap (m), for rounding.
const SLACK: f64 = 1e-6;
/// Limit of pairs of points and triangles in the search for overlaps; denser meshes are searched with fewer points.
const MOST_PAIRS: usize = 1_000_000;

/// Checks bodies, one by one and together; those of files once they are loaded.
pub(crate) fn check(scene: &Scene) -> Result<(), KeyError> {
    if scene.bodies.len() > MOST_BODIES {
        let message = format!("{} are more than the {MOST_BODIES} that a scene may have", scene.bodies.len());
        return refuse("body", message);
    }
    let under = |index: usize| move |e: KeyError| e.under(&["body".into(), index.into()]);
    for (index, body) in scene.bodies.iter().enumerate() {
        numbers(body).map_err(under(index))?;
    }
    let solids: Vec<_> = scene.bodies.iter().map(Solid::new).collect();
    for (index, solid) in solids.iter().enumerate() {
        let Some(solid) = solid else { continue };
        clear(scene, solid).map_err(under(index))?;
        let meets = |other: &Option<Solid<'_>>| other.as_ref().is_some_and(|other| solid.meets(other));
        if let Some(other) = solids[..index].iter().position(meets) {
            return refuse("at", format!("the body overlaps body {}", other + 1)).map_err(under(index));
        }
    }
    Ok(())
}

fn numbers(body: &Body) -> Result<(), KeyError> {
    point("at", body.at)?;
    if let Some(normal) = body.normal {
        direction("normal", normal)?;
    }
    direction("x_axis", body.x_axis)?;
    if body.axes().is_none() {
        return refuse("x_axis", "runs along `normal`: it has to run across it");
    }
    let [least, most] = RADII;
    within("radius", body.radius, least, most, "m")?;
    if body.kind == BodyKind::Capsule {
        let unit = "m, from end to end: twice the radius at least";
        within("length", body.length, 2.0 * body.radius, 2.0 * most, unit)?;
    }
    for (side, name) in ["along x", "across", "thickness"].into_iter().enumerate() {
        within("size", body.size[side], SIDES[0], SIDES[1], "m")
            .map_err(|e| KeyError::new([Key::from("size")], format!("{name}: {}", e.message)))?;
    }
    for (index, (name, most)) in FINGERS.into_iter().enumerate() {
        within("fingers", body.fingers[index], 0.0, most, "degrees").map_err(|e| {
            KeyError::new([Key::from("fingers"), Key::from(index)], format!("{name}: {}", e.message))
        })?;
    }
    within("scale", body.scale, 1e-9, 1e3, "m per unit of the file")?;
    if !(body.coefficient > -1.0 && body.coefficient <= 1.0) {
        return refuse("coefficient", "must be a number above -1 and at most 1 (1: rigid, 0: none)");
    }
    if body.kind == BodyKind::Mesh && body.file.as_ref().is_none_or(String::is_empty) {
        return refuse("file", "`kind = \"mesh\"` needs the name of an STL or OBJ file");
    }
    span(body)?;
    edge(body)
}

/// The size of a loaded file's body.
fn span(body: &Body) -> Result<(), KeyError> {
    if body.kind != BodyKind::Mesh || body.lacks_surface() {
        return Ok(());
    }
    let (low, high) = bounds(body.surface.hull());
    let span = (high - low).max_element() * body.scale;
    let [least, most] = SPANS;
    if span > most {
        let unit =
            if body.scale == 1.0 { "; if its file is in millimetres, write scale = 0.001" } else { "" };
        return refuse("scale", format!("the body spans {span:.3} m, more than {most} m{unit}"));
    }
    if span < least {
        return refuse("scale", format!("the body spans {span:.1e} m, less than {least} m"));
    }
    Ok(())
}

/// The edge of its triangles, if it is given.
fn edge(body: &Body) -> Result<(), KeyError> {
    let Some(edge) = body.edge else { return Ok(()) };
    if !(edge > LEAST_EDGE && edge <= 1.0) {
        return refuse("edge", format!("must be a length above {LEAST_EDGE} and at most 1 m"));
    }
    let [x, y, z] = body.size.to_array();
    let palm = 2.0 * (x * y + y * z + z * x);
    let area = match body.kind {
        BodyKind::Sphere => 4.0 * PI * body.radius * body.radius,
        BodyKind::Capsule => 2.0 * PI * body.radius * body.length,
        BodyKind::Palm => palm,
        // Fingers have about as much skin as their palm.
        BodyKind::Hand => 2.0 * palm,
        BodyKind::Mesh => body.surface.get().map_or(0.0, |mesh| mesh.area() * body.scale * body.scale),
    };
    let of_area = |edge: f64| area / (3f64.sqrt() / 4.0 * edge * edge);
    if of_area(edge) <= MOST_TRIANGLES {
        return Ok(());
    }
    let message = format!(
        "gives some {:.0} triangles, more than {MOST_TRIANGLES}: give at least {:.1e} m",
        of_area(edge),
        1.05 * edge * (of_area(edge) / MOST_TRIANGLES).sqrt()
    );
    refuse("edge", message)
}

/// The body stands in front of a board, contains no element, and is on the sound side of all reflectors.
fn clear(scene: &Scene, solid: &Solid<'_>) -> Result<(), KeyError> {
    if !scene.array.lacks_elements() {
        let front = scene.front();
        if front.outside(|up| Some(solid.lowest(up))).is_some() {
            return refuse("at", format!("the body reaches {}", front.behind()));
        }
        // The front of a single flat board has none of its elements.
        let boards = if scene.is_home() { Vec::new() } else { scene.standing() };
        let placed = if boards.is_empty() { Vec::new() } else { scene.array.places() };
        for (number, board) in boards.iter().enumerate() {
            let is_inside = |at: DVec3| at.distance(solid.middle) < solid.reach && solid.contains_any(&[at]);
            if let Some(element) = placed.iter().position(|it| is_inside(board.world(it.at))) {
                let element = number * placed.len() + element;
                return refuse("at", format!("element {element} of the array is inside the body"));
            }
        }
    }
    for (index, mirror) in scene.mirrors().iter().enumerate() {
        let normal = mirror.normal.normalize_or_zero();
        if Reflector::height(mirror, solid.lowest(normal)) < -SLACK {
            let name = match scene.reflectors.get(index) {
                Some(_) => format!("reflector {}", index + 1),
                None => "the liquid's surface, which reflects".to_owned(),
            };
            return refuse("at", format!("the body reaches behind {name}"));
        }
    }
    Ok(())
}

fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    points.iter().fold((DVec3::MAX, DVec3::MIN), |(low, high), at| (low.min(*at), high.max(*at)))
}

/// A body in its place.
struct Solid<'a> {
    body: &'a Body,
    axes: DMat3,
    /// A hand's surface, in its own coordinates.
    hand: Option<Mesh>,
    /// m: a sphere around it.
    middle: DVec3,
    reach: f64,
}

impl<'a> Solid<'a> {
    /// `None` of a body whose file is not loaded.
    fn new(body: &'a Body) -> Option<Self> {
        /// Thicknesses of a palm: the edges of a hand's triangles.
        const COARSE: f64 = 0.4;
        if body.lacks_surface() {
            return None;
        }
        let edge = COARSE * body.size.min_element();
        let hand = (body.kind == BodyKind::Hand).then(|| shapes::hand(body.size, body.fingers, edge));
        let mut solid =
            Self { body, axes: body.axes().unwrap_or(DMat3::IDENTITY), hand, middle: body.at, reach: 0.0 };
        (solid.middle, solid.reach) = match body.kind {
            BodyKind::Sphere => (body.at, body.radius),
            BodyKind::Capsule => (body.at, body.length / 2.0),
            BodyKind::Palm => (solid.palm_middle(), body.size.length() / 2.0),
            BodyKind::Hand | BodyKind::Mesh => {
                let points = solid.samples();
                let (low, high) = bounds(&points);
                let middle = low.midpoint(high);
                (middle, points.iter().map(|at| at.distance(middle)).fold(0.0, f64::max))
            }
        };
        Some(solid)
    }

    fn palm_middle(&self) -> DVec3 {
        self.body.at - self.axes.z_axis * (self.body.size.z / 2.0)
    }

    /// A palm: all points within a margin of a box with these half sides, m.
    fn palm(&self) -> (DVec3, f64) {
        let margin = 0.5 * self.body.size.min_element();
        (self.body.size / 2.0 - DVec3::splat(margin), margin)
    }

    /// The ends of the line that a sphere's or capsule's points are within a radius of.
    fn line(&self) -> Option<[DVec3; 2]> {
        let body = self.body;
        match body.kind {
            BodyKind::Sphere => Some([body.at; 2]),
            BodyKind::Capsule => {
                let half = self.axes.x_axis * (body.length / 2.0 - body.radius).max(0.0);
                Some([body.at - half, body.at + half])
            }
            BodyKind::Palm | BodyKind::Hand | BodyKind::Mesh => None,
        }
    }

    /// Distance (m) of a point from its surface, negative inside; `None` of hands and files.
    fn distance(&self, at: DVec3) -> Option<f64> {
        if let Some([from, to]) = self.line() {
            let way = to - from;
            let part = ((at - from).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            return Some(at.distance(from + way * part) - self.body.radius);
        }
        if self.body.kind != BodyKind::Palm {
            return None;
        }
        let (half, margin) = self.palm();
        let over = (self.axes.transpose() * (at - self.palm_middle())).abs() - half;
        Some(over.max(DVec3::ZERO).length() + over.max_element().min(0.0) - margin)
    }

    /// Its lowest point along a unit vector.
    fn lowest(&self, up: DVec3) -> DVec3 {
        let lowest = |points: &[DVec3]| {
            let lower = |a: &&DVec3, b: &&DVec3| up.dot(**a).total_cmp(&up.dot(**b));
            points.iter().min_by(lower).copied().unwrap_or(self.body.at)
        };
        if let Some(ends) = self.line() {
            return lowest(&ends) - up * self.body.radius;
        }
        if self.body.kind == BodyKind::Palm {
            let (half, margin) = self.palm();
            let own = self.axes.transpose() * up;
            let corner = half * own.map(|x| if x > 0.0 { -1.0 } else { 1.0 });
            return self.palm_middle() + self.axes * corner - up * margin;
        }
        lowest(&self.samples())
    }

    /// Points of its surface.
    fn samples(&self) -> Vec<DVec3> {
        let directions = || shapes::geodesic(1.0, 3).vertices.into_iter().map(DVec3::normalize_or_zero);
        if let Some([from, to]) = self.line() {
            let along = (0..=8).map(|i| from.lerp(to, f64::from(i) / 8.0));
            return along.flat_map(|at| directions().map(move |way| at + way * self.body.radius)).collect();
        }
        let world = |at: &DVec3| self.body.world(*at);
        match (self.body.kind, &self.hand) {
            (BodyKind::Palm, _) => {
                let (half, margin) = self.palm();
                let grid = (0..125)
                    .map(|i| DVec3::from([i % 5, i / 5 % 5, i / 25].map(|i| f64::from(i) / 2.0 - 1.0)));
                let edge = grid.filter(|at| at.abs().max_element() == 1.0);
                let out = |at: DVec3| {
                    self.palm_middle() + self.axes * (at * half + at.normalize_or_zero() * margin)
                };
                edge.map(out).collect()
            }
            (_, Some(hand)) => hand.vertices.iter().map(world).collect(),
            (_, None) => self.body.surface.hull().iter().map(|at| world(&(*at * self.body.scale))).collect(),
        }
    }

    /// Whether one of these points is inside.
    fn contains_any(&self, points: &[DVec3]) -> bool {
        if self.distance(DVec3::ZERO).is_some() {
            return points.iter().any(|at| self.distance(*at).is_some_and(|distance| distance < -SLACK));
        }
        let (mesh, scale) = match (&self.hand, self.body.surface.get()) {
            (Some(hand), _) => (hand, 1.0),
            (None, Some(mesh)) => (mesh, self.body.scale),
            (None, None) => return false,
        };
        let (low, high) = if self.hand.is_some() { mesh.extent() } else { bounds(self.body.surface.hull()) };
        let own = points.iter().map(|at| self.axes.transpose() * (*at - self.body.at) / scale);
        let near = own.filter(|at| at.cmpge(low).all() && at.cmple(high).all());
        near.take((MOST_PAIRS / mesh.triangles.len().max(1)).max(1)).any(|at| mesh.contains(at))
    }

    /// Whether two bodies overlap: exact for spheres and capsules among themselves and with palms, by points of their
    /// surfaces otherwise.
    fn meets(&self, other: &Self) -> bool {
        if self.middle.distance(other.middle) > self.reach + other.reach - SLACK {
            return false;
        }
        let by_points = |one: &Self, other: &Self| {
            // A little inside, so that bodies may touch.
            let points: Vec<_> = other.samples().iter().map(|at| at.lerp(other.middle, 1e-3)).collect();
            one.contains_any(&points)
        };
        let exact = self.line_meets(other).or_else(|| other.line_meets(self));
        exact.unwrap_or_else(|| by_points(self, other) || by_points(other, self))
    }

    /// Whether a sphere or capsule overlaps a body whose distance is known. That is convex along a line.
    fn line_meets(&self, other: &Self) -> Option<bool> {
        let [from, to] = self.line()?;
        other.distance(from)?;
        let distance = |part: f64| other.distance(from.lerp(to, part)).unwrap_or(f64::INFINITY);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..64 {
            let third = (high - low) / 3.0;
            if distance(low + third) < distance(high - third) { high -= third } else { low += third }
        }
        let least = distance(0.0).min(distance(1.0)).min(distance(f64::midpoint(low, high)));
        Some(least < self.body.radius - SLACK)
    }
}
