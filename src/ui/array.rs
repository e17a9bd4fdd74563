//! The array's boards on the canvas: their edges, and their elements in the colours of their phases.

use std::f64::consts::TAU;
use std::ops::Range;

use egui::{Color32, Painter, Shape, Stroke};
use glam::{DMat3, DVec2, DVec3};

use crate::field::Quantity;
use crate::picture::ColourMap;
use crate::scene::{Board, ElementModel, Placed, Reflector, Scene};
use crate::studio::map;
use crate::ui::theme;
use crate::ui::view::{Axes, Lens, array_size};
use crate::ui::{editor::Editor, shown::Shown, sound::Sound};

/// Thickness of elements seen from the side, in points.
const THICK: f32 = 5.0;
/// Spacing and length of the hatching behind a reflector.
const HATCH: f32 = 7.0;
const SILENT: Color32 = Color32::from_rgb(110, 116, 128);
/// Limit of individually drawn elements.
const MOST: usize = 1024;

pub fn paint(editor: &Editor, shown: &Shown, painter: &Painter, lens: &Lens) {
    let axes = editor.view.axes(editor.scene());
    let sound = shown.sound.as_ref().filter(|sound| sound.aperture.positions.len() <= MOST);
    let view = Seen { editor, axes: &axes, painter, lens };
    let placed = editor.scene().array.places();
    for (number, board) in editor.scene().standing().iter().enumerate() {
        let elements = number * placed.len()..(number + 1) * placed.len();
        let sound = sound.filter(|sound| sound.aperture.positions.len() >= elements.end);
        view.board(board, &placed, sound.map(|sound| (sound, elements)));
    }
    editor.scene().mirrors().iter().for_each(|mirror| view.mirror(mirror));
}

/// A view that boards are drawn in.
struct Seen<'a> {
    editor: &'a Editor,
    axes: &'a Axes,
    painter: &'a Painter,
    lens: &'a Lens,
}

impl Seen<'_> {
    fn board(&self, board: &Board, placed: &[Placed], sound: Option<(&Sound, Range<usize>)>) {
        let facing = self.axes.x.cross(self.axes.y).dot(board.normal.normalize_or_zero()).abs();
        let is_flat = placed.iter().all(|it| it.normal == DVec3::Z);
        // Seen edge on, it is a bar.
        if facing < 1e-3 && is_flat {
            self.bar(board, sound);
            return;
        }
        self.outline(board, placed);
        let Some((sound, elements)) = sound else { return };
        if self.editor.view.elements && (facing > 1.0 - 1e-9 || !is_flat) {
            self.discs(sound, elements);
        }
    }

    fn outline(&self, board: &Board, placed: &[Placed]) {
        let (low, high) = edges(self.editor.scene(), placed);
        let corner = |x: f64, y: f64| self.lens.screen(self.axes.flat(board.world(DVec3::new(x, y, 0.0))));
        let closed = [
            corner(low.x, low.y),
            corner(high.x, low.y),
            corner(high.x, high.y),
            corner(low.x, high.y),
            corner(low.x, low.y),
        ];
        let stroke = Stroke::new(1.0, theme::line(self.editor.view.is_light, 70));
        self.painter.extend(Shape::dashed_line(&closed, stroke, 6.0, 4.0));
    }

    fn discs(&self, sound: &Sound, elements: Range<usize>) {
        let aperture = &sound.aperture;
        let radius = (aperture.element.radius / self.lens.window.scale) as f32;
        let half = aperture.element.size / 2.0;
        let Some(board) = aperture.boards().find(|board| board.elements().contains(&elements.start)) else {
            return;
        };
        for element in elements {
            let place = aperture.positions[element];
            let colour = colour(sound, element);
            let (fill, edge) = (colour.gamma_multiply(0.3), Stroke::new(1.0, colour.gamma_multiply(0.7)));
            if aperture.element.model == ElementModel::Rectangle {
                let x = board.pose.world_direction(board.layout.aside(element - board.first));
                let y = aperture.normals[element].cross(x);
                let corner = |[along, across]: [f64; 2]| {
                    let corner = place + x * (along * half.x) + y * (across * half.y);
                    self.lens.screen(self.axes.flat(corner))
                };
                let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner);
                self.painter.add(Shape::convex_polygon(corners.to_vec(), fill, edge));
            } else {
                self.painter.circle(self.lens.screen(self.axes.flat(place)), radius, fill, edge);
            }
        }
    }

    /// The intersection of a reflector with the displayed plane, hatched on the silent side.
    fn mirror(&self, mirror: &Reflector) {
        let Self { axes, lens, painter, .. } = self;
        let normal = mirror.normal.normalize_or_zero();
        let slope = DVec2::new(normal.dot(axes.x), normal.dot(axes.y));
        // Seen from the front, it fills the view.
        if slope.length() < 1e-3 {
            return;
        }
        let middle = lens.window.centre;
        let nearest = middle - slope * (mirror.height(axes.world(middle)) / slope.length_squared());
        let along = slope.perp().normalize_or_zero() * lens.size().length();
        let ends = [nearest - along, nearest + along].map(|place| lens.screen(place));
        let stroke = Stroke::new(1.5, theme::line(self.editor.view.is_light, 160));
        let clipped = painter.with_clip_rect(lens.rect);
        clipped.line_segment(ends, stroke);
        let (way, back) = (ends[1] - ends[0], lens.screen(nearest - slope) - lens.screen(nearest));
        let (step, hatch) = (way.normalized(), (back.normalized() - way.normalized()) * HATCH);
        let thin = Stroke::new(1.0, theme::line(self.editor.view.is_light, 90));
        for i in 0..(way.length() / HATCH) as usize {
            let at = ends[0] + step * (i as f32 * HATCH);
            clipped.line_segment([at, at + hatch], thin);
        }
    }

    /// The row of elements nearest to a plane across the board, behind the line of their faces.
    fn bar(&self, board: &Board, sound: Option<(&Sound, Range<usize>)>) {
        let scene = self.editor.scene();
        let half = array_size(&scene.array) / 2.0;
        let turn = board.axes().unwrap_or(DMat3::IDENTITY);
        let across = self.axes.x.cross(self.axes.y);
        let along = across.cross(turn.z_axis).normalize_or_zero();
        let reach = half.x * along.dot(turn.x_axis).abs() + half.y * along.dot(turn.y_axis).abs();
        // On the screen: positions along the board, and its back.
        let at = |place: DVec3| self.lens.screen(self.axes.flat(place));
        let back = at(board.at - turn.z_axis) - at(board.at);
        let back = back.normalized() * THICK;
        let strip = |from: DVec3, to: DVec3, colour: Color32| {
            let (from, to) = (at(from), at(to));
            let points = vec![from, to, to + back, from + back];
            self.painter.add(Shape::convex_polygon(points, colour, Stroke::NONE));
        };
        strip(board.at - along * reach, board.at + along * reach, Color32::from_gray(60));
        let Some((sound, elements)) = sound else { return };
        let radius = sound.aperture.element.radius;
        let height = |element: usize| self.axes.height(sound.aperture.positions[element]).abs();
        let nearest = elements.clone().map(height).fold(f64::INFINITY, f64::min);
        for element in elements.filter(|&element| height(element) <= nearest + 1e-6) {
            let place = sound.aperture.positions[element];
            strip(place - along * radius, place + along * radius, colour(sound, element));
        }
    }
}

/// Opposite corners of a board, m.
fn edges(scene: &Scene, placed: &[Placed]) -> (DVec2, DVec2) {
    if scene.array.file.is_none() {
        let half = array_size(&scene.array) / 2.0;
        return (-half, half);
    }
    let grow =
        |(low, high): (DVec2, DVec2), it: &Placed| (low.min(it.at.truncate()), high.max(it.at.truncate()));
    let (low, high) = placed.iter().fold((DVec2::MAX, DVec2::MIN), grow);
    (low - scene.array.element_half(), high + scene.array.element_half())
}

/// Colour of an element: its phase if it is driven.
fn colour(sound: &Sound, element: usize) -> Color32 {
    let drive = sound.drive();
    let amplitude = drive.amplitudes.get(element).copied().unwrap_or(0.0);
    let Some(phase) = drive.phases.get(element).filter(|_| amplitude > 0.0) else { return SILENT };
    let table = map::colours(Quantity::Phase, ColourMap::Inferno).table();
    let part = (phase / TAU + 0.5).rem_euclid(1.0);
    let [r, g, b, _] = table[((part * table.len() as f64) as usize).min(table.len() - 1)];
    Color32::from_rgb(r, g, b)
}
