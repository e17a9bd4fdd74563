//! A scene in 3D: its objects, camera and labels.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3, Vec4};

use crate::acoustics::{Aperture, Face};
use crate::drive::Drive;
use crate::field::volume::camera::Projection;
use crate::field::volume::scenery::{Body, Item, Shot};
use crate::field::volume::{Block, Camera, Fineness, Scenery, Volume, march};
use crate::mesh::Mesh;
use crate::picture::{ColourMap, Picture};
use crate::rounding::millimetres;
use crate::scatter::Skin;
use crate::scene::{ElementModel, Focus, Scene, outline};

/// m, sides of a box.
pub const SIDES: [f64; 2] = [1e-4, 10.0];

/// The displayed contents of a scene in 3D.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    pub body: Body,
    /// Positions of slices across x, y and z, m.
    pub slices: [Option<f64>; 3],
    pub has_plane: bool,
    pub has_targets: bool,
    pub has_elements: bool,
    pub has_box: bool,
    pub colours: ColourMap,
    pub is_light: bool,
    /// Pixels per point of the screen, for the size of lines and dots.
    pub scale: f64,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            body: Body::Surface(surface_part(-6.0)),
            slices: [None; 3],
            has_plane: true,
            has_targets: true,
            has_elements: true,
            has_box: true,
            colours: ColourMap::Inferno,
            is_light: false,
            scale: 1.0,
        }
    }
}

/// A 3D view of a sound, to be drawn at any size.
#[derive(Clone, Debug)]
pub struct Prospect {
    pub scene: Arc<Scene>,
    pub aperture: Aperture,
    /// The drive that colours the elements.
    pub drive: Drive,
    /// The drives in turn whose field is drawn.
    pub heard: Vec<Drive>,
    pub foci: Vec<Focus>,
    pub block: Block,
    pub clip: Block,
    pub camera: Camera,
    pub look: Look,
    /// Points of the screen, width and height.
    pub points: DVec2,
    /// The field in the box, and the surfaces of bodies, if they are there already: they follow from the rest.
    pub volume: Option<Arc<Volume>>,
    pub skins: Option<Arc<Vec<Item>>>,
}

impl PartialEq for Prospect {
    fn eq(&self, other: &Self) -> bool {
        let inputs = |it: &Self| (it.block, it.clip, it.camera, it.points);
        inputs(self) == inputs(other)
            && self.look == other.look
            && self.scene == other.scene
            && self.aperture == other.aperture
            && self.drive == other.drive
            && self.heard == other.heard
            && self.foci == other.foci
    }
}

impl Prospect {
    /// The field in the box.
    pub fn volume(&self) -> Arc<Volume> {
        let sampled = || Arc::new(Volume::new(&self.aperture, &self.heard, &self.block, Fineness::of(false)));
        self.volume.clone().unwrap_or_else(sampled)
    }

    /// The objects of a picture that is so many pixels wide.
    pub fn scenery(&self, width: usize) -> Scenery {
        let look = Look { scale: width as f64 / self.points.x, ..self.look.clone() };
        let sound = (&self.aperture, &self.drive);
        let skins = self.skins.clone().unwrap_or_else(|| Arc::new(skins(&self.aperture, &self.heard)));
        scenery(&self.scene, sound, &self.foci, (&self.block, &self.clip), &skins, &look)
    }

    /// The picture of this many pixels, and the field in it.
    pub fn draw(&self, size: (usize, usize)) -> (Picture, Arc<Volume>) {
        let (volume, scenery) = (self.volume(), self.scenery(size.0));
        let shot = Shot::new(&scenery, &volume, &self.camera, size);
        let rgba = march::picture(&shot, &volume, &scenery.table, true);
        (Picture { width: size.0, height: size.1, rgba }, volume)
    }

    /// The labels of the box on a picture of this many pixels.
    pub fn labels(&self, size: (usize, usize), scale: f64) -> Vec<Label> {
        let projection = self.camera.projection(DVec2::new(size.0 as f64, size.1 as f64));
        if self.look.has_box { labels(&self.block, &projection, scale) } else { Vec::new() }
    }
}

/// The default box of a scene: its targets, its plane and most of the distance to the boards, extended by a quarter
/// on sides without boards.
pub fn block_of(scene: &Scene, aperture: &Aperture, foci: &[Focus]) -> Block {
    /// Least side relative to the longest.
    const FLATTEST: f64 = 0.5;
    /// Component of a mirror's normal along an axis beyond which it counts as perpendicular.
    const UPRIGHT: f64 = 0.999;
    const BEYOND: f64 = 0.3;
    /// Omitted part of the distance from a board to its targets: the near field is uninformative and hides the rest.
    const NEAR: f64 = 0.15;
    let (x, y) = scene.plane.axes().unwrap_or((DVec3::X, DVec3::Y));
    let half = (x * scene.plane.size.x).abs() / 2.0 + (y * scene.plane.size.y).abs() / 2.0;
    let (mut low, mut high) = (scene.plane.centre - half, scene.plane.centre + half);
    for focus in foci.iter().filter(|focus| !focus.is_direction()) {
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
    // There is no sound behind reflectors.
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
    // A vertical plane has no depth; its width is used instead.
    for axis in 0..2 {
        let side = (high[axis] - low[axis]).max(least);
        (low[axis], high[axis]) = (centre[axis] - side / 2.0, centre[axis] + side / 2.0);
    }
    let side = (high - low).clamp(DVec3::splat(SIDES[0]), DVec3::splat(SIDES[1]));
    Block { centre: (low + high) / 2.0, size: side }
}

/// The fraction of the peak at this level in dB.
pub fn surface_part(decibels: f64) -> f32 {
    10f64.powf(decibels / 20.0) as f32
}

/// Limit of individually drawn elements.
const MOST_ELEMENTS: usize = 16_384;
/// Margin of a board beyond its outermost elements, in pitches.
const RIM: f64 = 0.6;
const WATER: Vec3 = Vec3::new(0.16, 0.45, 0.85);
const WALL: Vec3 = Vec3::new(0.55, 0.6, 0.68);
const SILENT: Vec3 = Vec3::new(0.33, 0.35, 0.39);

/// The surfaces of all bodies with the RMS pressure of drives in turn on them.
pub fn skins(aperture: &Aperture, drives: &[Drive]) -> Vec<Item> {
    /// Triangles of spheres per wavelength.
    const FINENESS: f64 = 8.0;
    if aperture.bodies.is_empty() {
        return Vec::new();
    }
    let edge = aperture.wavelength() / FINENESS;
    let of_drive = |drive: &Drive| aperture.skins(&drive.excitation(&aperture.driven), edge);
    let all: Vec<_> = drives.iter().map(of_drive).collect();
    let Some(first) = all.first() else { return Vec::new() };
    let of_body = |(body, skin): (usize, &Skin)| {
        let square =
            |vertex: usize| all.iter().map(|skins| skins[body].pressures[vertex].norm_sqr()).sum::<f64>();
        let rms = |vertex: usize| (0.5 * square(vertex) / all.len() as f64).sqrt() as f32;
        let pressures: Vec<_> = (0..skin.mesh.vertices.len()).map(rms).collect();
        facets(&skin.mesh, Some(&pressures))
    };
    first.iter().enumerate().flat_map(of_body).collect()
}

/// A surface with RMS pressures (Pa) at its vertices, or grey.
pub fn facets(mesh: &Mesh, pressures: Option<&[f32]>) -> Vec<Item> {
    let normals: Vec<_> = mesh.normals().into_iter().map(|normal| normal.as_vec3()).collect();
    let facet = |(triangle, corners): (usize, &[u32; 3])| Item::Facet {
        corners: mesh.corners(triangle),
        normals: corners.map(|vertex| normals[vertex as usize]),
        pressures: pressures.map(|pressures| corners.map(|vertex| pressures[vertex as usize])),
    };
    mesh.triangles.iter().enumerate().map(facet).collect()
}

/// All objects of a scene in 3D, with the surfaces of its bodies.
pub fn scenery(
    scene: &Scene,
    (aperture, drive): (&Aperture, &Drive),
    foci: &[Focus],
    (block, clip): (&Block, &Block),
    skins: &[Item],
    look: &Look,
) -> Scenery {
    let mut items = Items { items: skins.to_vec(), look };
    if look.has_elements {
        for board in aperture.boards() {
            items.board(aperture, board, drive);
        }
    }
    for mirror in &scene.reflectors {
        items.plane_in(block, mirror.point, mirror.normal.normalize_or_zero(), WALL, 0.16);
    }
    if let (true, Some((x, y))) = (scene.liquid.reflects, scene.plane.axes()) {
        let half = [x * (scene.plane.size.x / 2.0), y * (scene.plane.size.y / 2.0)];
        items.panel(scene.plane.centre, half, WATER.extend(0.28));
    }
    if look.has_plane
        && let Some((x, y)) = scene.plane.axes()
    {
        let half = [x * (scene.plane.size.x / 2.0), y * (scene.plane.size.y / 2.0)];
        items.slice(scene.plane.centre, half);
    }
    for (axis, place) in look.slices.iter().enumerate() {
        if let Some(place) = place {
            items.slice_across(clip, axis, *place);
        }
    }
    if look.has_targets {
        items.targets(scene, foci);
    }
    if look.has_box {
        let colour = items.ink(0.34);
        for [a, b] in edges(block) {
            items.line([a, b], 1.0, colour, 0.0);
        }
        if clip != block {
            let colour = items.ink(0.7);
            for [a, b] in edges(clip) {
                items.line([a, b], 1.2, colour, 0.0);
            }
        }
    }
    let ground = if look.is_light {
        [Vec3::ONE, Vec3::new(0.925, 0.935, 0.95)]
    } else {
        [Vec3::new(0.085, 0.09, 0.115), Vec3::new(0.035, 0.035, 0.047)]
    };
    let table = look.colours.on(look.is_light);
    let [r, g, b, _] = table[if look.is_light { 112 } else { 172 }];
    let surface = Vec3::new(f32::from(r), f32::from(g), f32::from(b)) / 255.0;
    Scenery { items: items.items, body: look.body, clip: *clip, surface, table, ground }
}

struct Items<'a> {
    items: Vec<Item>,
    look: &'a Look,
}

impl Items<'_> {
    /// The ink of lines.
    fn ink(&self, alpha: f32) -> Vec4 {
        let ink = if self.look.is_light { Vec3::splat(0.08) } else { Vec3::ONE };
        ink.extend(alpha)
    }

    fn line(&mut self, ends: [DVec3; 2], width: f64, colour: Vec4, shine: f32) {
        self.items.push(Item::Line { ends, width: width * self.look.scale, colour, shine });
    }

    fn frame(&mut self, centre: DVec3, [a, b]: [DVec3; 2], colour: Vec4) {
        let corners = [centre - a - b, centre + a - b, centre + a + b, centre - a + b];
        for i in 0..4 {
            self.line([corners[i], corners[(i + 1) % 4]], 1.2, colour, 0.0);
        }
    }

    fn panel(&mut self, centre: DVec3, half: [DVec3; 2], colour: Vec4) {
        self.items.push(Item::Panel { centre, half, colour });
        self.frame(centre, half, colour.truncate().extend(0.7));
    }

    fn slice(&mut self, centre: DVec3, half: [DVec3; 2]) {
        self.items.push(Item::Slice { centre, half, opacity: 0.94 });
        let ink = self.ink(0.5);
        self.frame(centre, half, ink);
    }

    /// A slice of the box across an axis.
    fn slice_across(&mut self, clip: &Block, axis: usize, place: f64) {
        let half = clip.size / 2.0;
        let (a, b) = [(DVec3::Y, DVec3::Z), (DVec3::X, DVec3::Z), (DVec3::X, DVec3::Y)][axis];
        let mut centre = clip.centre;
        centre[axis] = place;
        self.slice(centre, [a * half, b * half]);
    }

    /// The part of an infinite plane near the box.
    fn plane_in(&mut self, block: &Block, point: DVec3, normal: DVec3, colour: Vec3, alpha: f32) {
        if normal == DVec3::ZERO {
            return;
        }
        let centre = block.centre - normal * normal.dot(block.centre - point);
        let across = if normal.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
        let a = (across - normal * normal.dot(across)).normalize_or_zero();
        let b = normal.cross(a);
        let reach = |axis: DVec3| axis * (axis.abs().dot(block.size) / 2.0 * 1.04);
        self.panel(centre, [reach(a), reach(b)], colour.extend(alpha));
    }

    fn board(&mut self, aperture: &Aperture, board: &Face, drive: &Drive) {
        let radius = aperture.element.radius;
        if board.layout.is_flat() {
            let (low, high) = board.corners();
            let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0 + RIM * aperture.pitch);
            let [x, y, normal] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| board.pose.world_direction(axis));
            // A little behind its elements.
            let centre = board.pose.world(middle.extend(0.0)) - normal * (0.1 * radius);
            let plate = if self.look.is_light { Vec3::splat(0.62) } else { Vec3::splat(0.16) };
            self.items.push(Item::Panel {
                centre,
                half: [x * half.x, y * half.y],
                colour: plate.extend(0.72),
            });
            let ink = self.ink(0.4);
            self.frame(centre, [x * half.x, y * half.y], ink);
        }
        if board.layout.positions.len() > MOST_ELEMENTS {
            return;
        }
        let table = ColourMap::Cyclic.table();
        let is_driven: std::collections::HashSet<_> = aperture.driven.iter().collect();
        for n in board.elements() {
            let loud = drive.amplitudes.get(n).copied().unwrap_or(0.0).clamp(0.0, 1.0) as f32;
            let phase = drive.phases.get(n).copied().unwrap_or(0.0);
            let [r, g, b, _] = table[((phase / TAU + 0.5).rem_euclid(1.0) * 255.0).round() as usize];
            let tint = Vec3::new(f32::from(r), f32::from(g), f32::from(b)) / 255.0;
            let colour = if is_driven.contains(&n) { SILENT.lerp(tint, loud.sqrt()) } else { SILENT };
            let (centre, colour) = (aperture.positions[n], colour.extend(1.0));
            self.items.push(match aperture.element.model {
                ElementModel::Rectangle => {
                    let x = board.pose.world_direction(board.layout.aside(n - board.first));
                    let y = aperture.normals[n].cross(x);
                    let half = aperture.element.size / 2.0;
                    Item::Panel { centre, half: [x * half.x, y * half.y], colour }
                }
                ElementModel::Piston
                | ElementModel::ExactPiston
                | ElementModel::Point
                | ElementModel::Cosine
                | ElementModel::Measured => {
                    Item::Disc { centre, normal: aperture.normals[n], radius, colour }
                }
            });
        }
    }

    fn targets(&mut self, scene: &Scene, foci: &[Focus]) {
        /// Visibility of objects inside a surface.
        const SHINE: f32 = 0.55;
        let (ink, edge) =
            (self.ink(0.92), if self.look.is_light { Vec3::ONE } else { Vec3::ZERO }.extend(0.5));
        for target in scene.targets.iter().filter(|target| target.visible) {
            for stroke in outline::strokes(target).unwrap_or_default() {
                for ends in stroke.windows(2) {
                    self.line([ends[0], ends[1]], 1.7, ink, SHINE);
                }
            }
        }
        for focus in foci.iter().filter(|focus| focus.is_placed()) {
            let dot = |radius: f64, colour: Vec4, shine: f32| Item::Dot {
                at: focus.position,
                radius: radius * self.look.scale,
                colour,
                shine,
            };
            let both = [dot(4.4, edge, 0.0), dot(3.2, ink, SHINE)];
            self.items.extend(both);
        }
    }
}

/// The region of a fitted view: the box, and the boards.
pub fn whole(block: &Block, aperture: &Aperture) -> Block {
    let rim = DVec3::splat(RIM * aperture.pitch);
    let places = aperture.boards().flat_map(|board| &aperture.positions[board.elements()]);
    let grown = |(low, high): (DVec3, DVec3), at: &DVec3| (low.min(*at - rim), high.max(*at + rim));
    let (mut low, mut high) = places.fold((block.low(), block.high()), grown);
    for body in aperture.bodies.of() {
        (low, high) = (low.min(body.at - body.reach()), high.max(body.at + body.reach()));
    }
    Block::between(low, high)
}

/// The twelve edges of a box, those along x first, then along y and z.
pub fn edges(block: &Block) -> [[DVec3; 2]; 12] {
    let half = block.size / 2.0;
    std::array::from_fn(|i| {
        let (axis, corner) = (i / 4, i % 4);
        let sign = |bit: usize| if corner & bit == 0 { -1.0 } else { 1.0 };
        let others = [sign(1), sign(2)];
        let mut place = DVec3::ZERO;
        place[(axis + 1) % 3] = others[0];
        place[(axis + 2) % 3] = others[1];
        let end = |along: f64| {
            let mut end = place;
            end[axis] = along;
            block.centre + end * half
        };
        [end(-1.0), end(1.0)]
    })
}

/// A label beside an axis of the box.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Pixels, its middle.
    pub at: DVec2,
    pub text: String,
}

/// The scales of the box: along one edge of each axis the coordinates of both ends in mm, and in the middle the axis' name.
pub fn labels(block: &Block, projection: &Projection, scale: f64) -> Vec<Label> {
    /// Points of the screen between an edge and its words.
    const OFF: f64 = 16.0;
    /// Points from a corner to the numbers of its edges, which must not touch.
    const INWARD: f64 = 14.0;
    const LEAST: f64 = 46.0;
    let Some((middle, _)) = projection.screen(block.centre) else { return Vec::new() };
    let mut labels = Vec::new();
    for (axis, name) in ["x / mm", "y / mm", "z / mm"].into_iter().enumerate() {
        let seen = |edge: &[DVec3; 2]| {
            let ends = edge.map(|end| projection.screen(end));
            let [Some((a, near)), Some((b, far))] = ends else { return None };
            Some(([a, b], near + far))
        };
        let all: Vec<_> = edges(block)[4 * axis..4 * axis + 4].iter().filter_map(seen).collect();
        // The lowest edge; of vertical edges the leftmost; of several the nearest.
        let rank = |([a, b], depth): &([DVec2; 2], f64)| {
            let place = (*a + *b) / 2.0;
            let aside = if axis == 2 { -place.x } else { place.y };
            (aside / scale).round() - 1e-3 * depth
        };
        let Some(([a, b], _)) = all.into_iter().max_by(|a, b| rank(a).total_cmp(&rank(b))) else { continue };
        if a.distance(b) < LEAST * scale {
            continue;
        }
        let along = (b - a).normalize_or_zero();
        let outward = along.perp() * along.perp().dot((a + b) / 2.0 - middle).signum();
        let off = outward * OFF * scale;
        let ends = [block.low()[axis], block.high()[axis]].map(|place| millimetres(place, 0));
        let [low, high] = ends.map(|text| text.replace('-', "−"));
        labels.push(Label { at: a + off + along * INWARD * scale, text: low });
        labels.push(Label { at: b + off - along * INWARD * scale, text: high });
        labels.push(Label { at: (a + b) / 2.0 + off * 1.35, text: name.to_owned() });
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Body;
    use crate::studio::probe;

    #[test]
    fn the_pressure_on_a_body_is_that_of_the_air_just_before_it() {
        let body = Body { at: DVec3::new(0.004, 0.0, 0.09), radius: 0.006, ..Body::default() };
        let scene = Scene { bodies: vec![body.clone()], ..Scene::default() };
        let aperture = Aperture::new(&scene);
        let count = aperture.positions.len();
        let drive = |step: f64| Drive {
            amplitudes: vec![1.0; count],
            phases: (0..count).map(|n| (n as f64 * step).sin()).collect(),
        };
        let drives = [drive(0.7), drive(1.9)];
        let items = skins(&aperture, &drives);
        assert!(items.len() > 500);
        let mut pairs = Vec::new();
        for item in items.iter().step_by(97) {
            let Item::Facet { corners, normals, pressures: Some(pressures) } = item else {
                panic!("{item:?}")
            };
            let outwards = corners.map(|at| (at - body.at).normalize_or_zero());
            let before = outwards.map(|way| body.at + way * (body.radius * (1.0 + 1e-9)));
            let sums = probe::pressures(&aperture, &drives, &before);
            for i in 0..3 {
                pairs.push((f64::from(pressures[i]), sums[i].norm() / std::f64::consts::SQRT_2));
                assert!(normals[i].as_dvec3().distance(outwards[i]) < 0.1);
            }
        }
        let largest = pairs.iter().map(|(_, expected)| *expected).fold(0.0, f64::max);
        assert!(largest > 10.0 && pairs.len() > 15);
        for (own, expected) in pairs {
            assert!((own - expected).abs() < 1e-3 * largest, "{own}, not {expected} of {largest}");
        }
        assert_eq!(facets(&body.solid(0.002).expect("a sphere"), None).len() % 20, 0);
    }
}
