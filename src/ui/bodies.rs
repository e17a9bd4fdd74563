//! Bodies on the map: where the plane cuts them, or else their outlines, by which they are picked, moved and turned.

use std::f64::consts::TAU;
use std::sync::Arc;

use egui::{Painter, Pos2, Rect, Shape, Stroke, pos2};
use glam::{DQuat, DVec2, DVec3};

use crate::mesh::Mesh;
use crate::scene::{Body, BodyKind, Scene, check, outline};
use crate::ui::parts::solids;
use crate::ui::view::{Axes, Lens};
use crate::ui::{editor::Editor, handle, theme};

/// Corners of a circle.
const CORNERS: usize = 96;
/// Points of the screen: of dashes and gaps, and from an outline to the handle that turns it.
const DASH: [f32; 2] = [7.0, 5.0];
const ABOVE: f32 = 30.0;
/// Steps of turning with Shift, rad.
const STEP: f64 = TAU / 24.0;
/// Offset of a copy from its original, in reaches.
const ASIDE: f64 = 2.2;

/// A body on a plane.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// Closed, m; outer ones and holes run oppositely.
    pub lines: Vec<Vec<DVec2>>,
    /// Whether the plane cuts it.
    pub is_cut: bool,
}

impl Outline {
    /// Whether a point is inside: where lines wind around it.
    fn contains(&self, at: DVec2) -> bool {
        let turns = |line: &Vec<DVec2>| -> i32 {
            let ends = |i: usize| (line[i], line[(i + 1) % line.len()]);
            (0..line.len())
                .map(|i| crossing(ends(i), at.y).map_or(0, |(x, way)| if x > at.x { way } else { 0 }))
                .sum()
        };
        self.lines.iter().map(turns).sum::<i32>() != 0
    }
}

/// Where an edge crosses a height, and whether upwards (1) or downwards (-1).
fn crossing((from, to): (DVec2, DVec2), y: f64) -> Option<(f64, i32)> {
    ((from.y <= y) != (to.y <= y)).then(|| {
        let x = from.x + (to.x - from.x) * (y - from.y) / (to.y - from.y);
        (x, if to.y > from.y { 1 } else { -1 })
    })
}

/// The coarse surface of a body in its own coordinates: that of its shape before while it changes.
pub fn solid(editor: &Editor, index: usize) -> Option<Arc<Mesh>> {
    let shape = solids::shape(editor.scene().bodies.get(index)?);
    let known = editor.parts.solids.newest()?;
    let found = known.iter().find(|(own, _)| *own == shape);
    let before = known.get(index).filter(|(own, _)| own.kind == shape.kind);
    found.or(before).and_then(|(_, mesh)| mesh.clone())
}

/// The surfaces of all bodies at their places, m.
pub fn placed(editor: &Editor) -> Vec<Mesh> {
    let of = |(index, body): (usize, &Body)| {
        let (axes, mesh) = (body.axes()?, solid(editor, index)?);
        Some(Mesh::clone(&mesh).mapped(|at| body.at + axes * at))
    };
    editor.scene().bodies.iter().enumerate().filter_map(of).collect()
}

/// The nearest body that a ray meets: its start (m) and direction.
pub fn hit(editor: &Editor, (start, direction): (DVec3, DVec3)) -> Option<usize> {
    let depth = |index: usize| {
        let body = &editor.scene().bodies[index];
        let (axes, mesh) = (body.axes()?, solid(editor, index)?);
        let inverse = axes.transpose();
        let ray = (inverse * (start - body.at), inverse * direction);
        let met = (0..mesh.triangles.len()).filter_map(|triangle| meets(mesh.corners(triangle), ray));
        met.min_by(f64::total_cmp)
    };
    let hits = (0..editor.scene().bodies.len()).filter_map(|index| Some((index, depth(index)?)));
    hits.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}

/// Depth along a ray, in its direction's length, at which it meets a triangle.
fn meets([a, b, c]: [DVec3; 3], (start, direction): (DVec3, DVec3)) -> Option<f64> {
    let (first, second, off) = (b - a, c - a, start - a);
    let (across, round) = (direction.cross(second), off.cross(first));
    let scale = first.dot(across);
    let [s, t, depth] = [off.dot(across), direction.dot(round), second.dot(round)].map(|part| part / scale);
    (s >= 0.0 && t >= 0.0 && s + t <= 1.0 && depth > 0.0).then_some(depth)
}

/// A body on a plane.
pub fn outline_on(editor: &Editor, index: usize, axes: &Axes) -> Option<Outline> {
    let body = editor.scene().bodies.get(index)?;
    if body.kind == BodyKind::Sphere {
        let height = axes.height(body.at);
        let is_cut = height.abs() < body.radius;
        let radius = if is_cut { (body.radius * body.radius - height * height).sqrt() } else { body.radius };
        let middle = axes.flat(body.at);
        let corner = |i: usize| middle + DVec2::from_angle(TAU * i as f64 / CORNERS as f64) * radius;
        return Some(Outline { lines: vec![(0..CORNERS).map(corner).collect()], is_cut });
    }
    let (own, mesh) = (body.axes()?, solid(editor, index)?);
    let inverse = own.transpose();
    let normal = inverse * axes.x.cross(axes.y);
    let section = mesh.section(inverse * (axes.origin - body.at), normal);
    let is_cut = !section.is_empty();
    let lines = if is_cut { section } else { mesh.silhouette(normal) };
    let flat = |line: Vec<DVec3>| line.into_iter().map(|at| axes.flat(body.at + own * at)).collect();
    Some(Outline { lines: lines.into_iter().map(flat).collect(), is_cut })
}

/// The topmost body with a point of the plane inside its outline; those that the plane cuts are above the others.
pub fn at(editor: &Editor, axes: &Axes, uv: DVec2) -> Option<usize> {
    let hits = (0..editor.scene().bodies.len()).rev().filter_map(|index| {
        let outline = outline_on(editor, index, axes)?;
        outline.contains(uv).then_some((index, outline.is_cut))
    });
    let hits: Vec<_> = hits.collect();
    hits.iter().find(|(_, is_cut)| *is_cut).or(hits.first()).map(|(index, _)| *index)
}

/// The handle that turns the chosen body; round ones have none.
fn turner(editor: &Editor, axes: &Axes, lens: &Lens) -> Option<(Rect, Pos2)> {
    let index = editor.chosen_body()?;
    if editor.scene().bodies[index].kind == BodyKind::Sphere {
        return None;
    }
    let outline = outline_on(editor, index, axes)?;
    let rect =
        outline.lines.iter().flatten().fold(Rect::NOTHING, |rect, at| rect.union(of_point(lens.screen(*at))));
    rect.is_finite().then(|| (rect, pos2(rect.center().x, rect.top() - ABOVE)))
}

fn of_point(at: Pos2) -> Rect {
    Rect::from_min_max(at, at)
}

/// Whether the handle that turns the chosen body is under the pointer.
pub fn is_on_turner(editor: &Editor, axes: &Axes, lens: &Lens, pointer: Pos2) -> bool {
    turner(editor, axes, lens).is_some_and(|(_, at)| at.distance(pointer) <= handle::REACH)
}

/// A body after a turn (rad) about its place, in the plane; in steps if wanted.
pub fn turned_in(before: &Body, axes: &Axes, angle: f64, in_steps: bool) -> Body {
    let angle = if in_steps { (angle / STEP).round() * STEP } else { angle };
    let normal = axes.x.cross(axes.y).normalize_or(DVec3::Z);
    turned(before, DQuat::from_axis_angle(normal, angle))
}

/// A body after a turn about its place.
pub fn turned(before: &Body, turn: DQuat) -> Body {
    // Right angles are exact.
    let whole = |way: DVec3| {
        DVec3::from_array(way.to_array().map(|part| if part.abs() < 1e-15 { 0.0 } else { part }))
    };
    let normal = whole(turn * before.normal());
    let has_normal = match before.kind {
        BodyKind::Sphere | BodyKind::Capsule => false,
        BodyKind::Palm | BodyKind::Hand | BodyKind::Mesh => normal.distance(before.normal()) > 1e-12,
    };
    let x_axis = match before.kind {
        BodyKind::Sphere => before.x_axis,
        BodyKind::Capsule | BodyKind::Palm | BodyKind::Hand | BodyKind::Mesh => whole(turn * before.x_axis),
    };
    Body { normal: if has_normal { Some(normal) } else { before.normal }, x_axis, ..before.clone() }
}

pub fn title(kind: BodyKind) -> &'static str {
    match kind {
        BodyKind::Sphere => "Sphere",
        BodyKind::Capsule => "Capsule",
        BodyKind::Palm => "Palm",
        BodyKind::Hand => "Hand",
        BodyKind::Mesh => "Mesh",
    }
}

/// A new body of a kind: palms and hands lie on the first focus, others stand where there is room in the plane.
pub fn usual(editor: &Editor, kind: BodyKind) -> Body {
    /// m, from a focus to the skin.
    const OFF: f64 = 1e-3;
    let scene = editor.scene();
    let usual = Body { kind, ..Body::default() };
    match kind {
        BodyKind::Palm | BodyKind::Hand => {
            let focus = scene.targets.iter().find(|target| target.visible && !target.shape.is_direction());
            let at = focus.map_or(scene.plane.centre, |target| outline::centre(&target.shape));
            Body { at: at + DVec3::Z * OFF, ..usual }
        }
        BodyKind::Sphere | BodyKind::Capsule | BodyKind::Mesh => in_plane(editor, &usual),
    }
}

/// A body where there is room for it in the displayed plane.
pub fn in_plane(editor: &Editor, body: &Body) -> Body {
    let axes = editor.view.axes(editor.scene());
    let middle = axes.world(axes.flat(editor.scene().plane.centre));
    beside(editor.scene(), &Body { at: middle, ..body.clone() }, &axes)
}

/// Adds a body and chooses it.
pub fn add(editor: &mut Editor, body: Body) {
    editor.document.scene.bodies.push(body);
    editor.choose_body(editor.scene().bodies.len() - 1);
}

/// The body where there is room for it: at its place, or else beside it along the plane.
pub fn beside(scene: &Scene, body: &Body, axes: &Axes) -> Body {
    /// Places tried on each side.
    const TRIED: i32 = 12;
    let reach = body.reach();
    let is_free = |body: &Body| {
        let near = |at: &DVec3| at.distance(body.at) <= reach + scene.wavelength();
        let meets = |target| outline::strokes(target).is_ok_and(|lines| lines.iter().flatten().any(near));
        let on_target = scene.targets.iter().any(meets);
        let bodies = scene.bodies.iter().chain([body]).cloned().collect();
        !on_target && check::check(&Scene { bodies, ..scene.clone() }).is_ok()
    };
    let place = |i: i32| Body { at: body.at + axes.x * (ASIDE * reach * f64::from(i)), ..body.clone() };
    let places = (0..=TRIED).flat_map(|i| if i == 0 { vec![0] } else { vec![i, -i] });
    places.map(place).find(is_free).unwrap_or_else(|| body.clone())
}

/// Draws all bodies, and the handle of the chosen one.
pub fn paint(editor: &Editor, painter: &Painter, lens: &Lens) {
    let axes = editor.view.axes(editor.scene());
    let chosen = editor.chosen_body();
    for index in 0..editor.scene().bodies.len() {
        let Some(Outline { lines, is_cut }) = outline_on(editor, index, &axes) else { continue };
        let lines: Vec<Vec<_>> =
            lines.iter().map(|line| line.iter().map(|at| lens.screen(*at)).collect()).collect();
        let (ink, edge) = (theme::line(editor.view.is_light, 210), theme::line(!editor.view.is_light, 130));
        let colour = if chosen == Some(index) { theme::CHOSEN } else { ink };
        for mut line in lines {
            line.extend(line.first().copied());
            if is_cut {
                painter.add(Shape::line(line.clone(), Stroke::new(3.4, edge)));
                painter.add(Shape::line(line, Stroke::new(1.6, colour)));
            } else {
                let [dash, gap] = DASH;
                painter.extend(Shape::dashed_line(&line, Stroke::new(2.6, edge), dash, gap));
                painter.extend(Shape::dashed_line(&line, Stroke::new(1.2, colour), dash, gap));
            }
        }
    }
    if let Some((rect, at)) = turner(editor, &axes, lens) {
        painter.line_segment([rect.center_top(), at], Stroke::new(1.0, theme::CHOSEN.gamma_multiply(0.7)));
        painter.circle(at, handle::HALF, theme::MARK, Stroke::new(1.5, theme::ACCENT));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::view::View;

    #[test]
    fn turning_moves_the_axes_that_a_kind_has() {
        let scene = Scene::default();
        let axes = View::of(&scene).axes(&scene);
        let quarter = |kind: BodyKind| turned_in(&Body { kind, ..Body::default() }, &axes, TAU / 4.1, true);
        let palm = quarter(BodyKind::Palm);
        assert!(palm.normal.is_none() && palm.x_axis.distance(DVec3::Y) < 1e-12, "{palm:?}");
        assert_eq!(quarter(BodyKind::Sphere), Body::default());
        let tipped = turned(&palm, DQuat::from_rotation_y(TAU / 4.0));
        assert!(tipped.normal.is_some_and(|way| way.distance(DVec3::NEG_X) < 1e-12), "{tipped:?}");
        assert_eq!(tipped.axes().map(|axes| axes.x_axis.distance(DVec3::Y) < 1e-12), Some(true));
    }

    #[test]
    fn points_are_inside_lines_that_wind_around_them() {
        let square = |half: f64| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec2::new(x, y) * half)
        };
        let mut hole = square(0.5);
        hole.reverse();
        let ring = Outline { lines: vec![square(1.0).to_vec(), hole.to_vec()], is_cut: true };
        let is_in = |x: f64, y: f64| ring.contains(DVec2::new(x, y));
        assert!(is_in(0.7, 0.1) && is_in(0.1, -0.8) && !is_in(0.1, 0.2) && !is_in(1.2, 0.0));
        let whole = Outline { lines: vec![square(1.0).to_vec(), square(0.5).to_vec()], is_cut: false };
        assert!(whole.contains(DVec2::ZERO), "two layers");
    }
}
