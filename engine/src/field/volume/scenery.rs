//! The objects of a 3D picture, and the numbers from which CPU and GPU draw it.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec3, Vec4};

use crate::field::volume::camera::Projection;
use crate::field::volume::{Block, Camera, Volume};

/// Pixels along the side of a tile with its own list of visible objects.
pub const TILE: usize = 16;
/// Limit of drawn hits per ray, the nearest ones.
pub const MOST_MET: usize = 12;
/// The light on a facet that faces away from it, of 1.
const DARKEST: f32 = 0.42;
/// Forward offset of lines and dots relative to their distance, so that coplanar objects do not hide them.
const FORWARD: f64 = 1e-3;

/// The representation of the field in the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Body {
    /// The field on the slices alone.
    Hidden,
    /// The isosurface at this fraction of its peak.
    Surface(f32),
    /// The largest value along every ray.
    Projection,
}

/// An object in space; colours are r, g, b and opacity, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Item {
    /// Between two points (m), `width` pixels wide; `through` is its visibility behind other objects.
    Line { ends: [DVec3; 2], width: f64, colour: Vec4, shine: f32 },
    /// A ball of a radius in pixels, likewise.
    Dot { at: DVec3, radius: f64, colour: Vec4, shine: f32 },
    /// A flat disc of a radius in m.
    Disc { centre: DVec3, normal: DVec3, radius: f64, colour: Vec4 },
    /// A rectangle with half sides.
    Panel { centre: DVec3, half: [DVec3; 2], colour: Vec4 },
    /// A rectangle coloured by the field, with this opacity at its peak.
    Slice { centre: DVec3, half: [DVec3; 2], opacity: f32 },
    /// A triangle of a body's surface, seen from outside, with normals and RMS pressures (Pa) at its corners; grey
    /// without these.
    Facet { corners: [DVec3; 3], normals: [Vec3; 3], pressures: Option<[f32; 3]> },
}

/// Everything in a picture of space but the field's values and the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenery {
    pub items: Vec<Item>,
    pub body: Body,
    /// The visible part of the field.
    pub clip: Block,
    /// r, g, b of the surface.
    pub surface: Vec3,
    /// Colours from zero to the peak.
    pub table: [[u8; 4]; 256],
    /// r, g, b at the top and at the bottom of the picture, behind everything.
    pub ground: [Vec3; 2],
}

/// An item as programs read it; the same struct as in `shaders/volume.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Thing {
    /// On the picture: a line's beginning (pixels, pixels, depth as [`Shot`] has it) or a dot's middle; in space a centre. Then its kind.
    pub place: [f32; 4],
    /// A line's end and half width; a dot's radius; a disc's normal and radius; the first half side of a rectangle over its square; of a facet, whose
    /// place is a corner, what gives the part of its first side, and the pressure at the corner.
    pub first: [f32; 4],
    /// The second half side likewise; the opacity of a slice; the visibility of lines and dots behind objects. Of a facet
    /// what gives the part of its second side, and the pressure at the second corner.
    pub second: [f32; 4],
    /// Of a facet the pressure at the third corner, below 0 without pressures, and the light at all three.
    pub colour: [f32; 4],
}

/// Kinds of [`Thing`].
pub const LINE: u32 = 0;
pub const DOT: u32 = 1;
pub const DISC: u32 = 2;
pub const PANEL: u32 = 3;
pub const SLICE: u32 = 4;
pub const FACET: u32 = 5;

/// The same struct as in `shaders/volume.wgsl`. Positions are in m from the centre of the clipping box.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShotParams {
    pub eye: [f32; 3],
    pub aside: f32,
    pub right: [f32; 3],
    pub spread: f32,
    pub up: [f32; 3],
    /// Pa of the surface.
    pub level: f32,
    pub forward: [f32; 3],
    pub per_peak: f32,
    pub low: [f32; 3],
    pub width: f32,
    pub high: [f32; 3],
    pub height: f32,
    pub first: [f32; 3],
    pub tiles: u32,
    /// Steps per m.
    pub per_metre: [f32; 3],
    pub more: f32,
    pub counts: [u32; 3],
    pub columns: u32,
    pub bricks: [u32; 3],
    pub rows: u32,
    pub surface: [f32; 4],
    pub top: [f32; 4],
    pub bottom: [f32; 4],
}

/// The inputs of a picture except the field and the colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    pub params: ShotParams,
    pub body: Body,
    pub things: Vec<Thing>,
    /// The start of each tile's list, then the end of the last; then the lists.
    pub tiles: Vec<u32>,
    pub size: (usize, usize),
}

impl Shot {
    pub fn new(scenery: &Scenery, volume: &Volume, camera: &Camera, size: (usize, usize)) -> Self {
        let projection = camera.projection(DVec2::new(size.0 as f64, size.1 as f64));
        let middle = scenery.clip.centre;
        let mut placed: Vec<(Thing, [DVec2; 2])> = Vec::new();
        for item in &scenery.items {
            placed.extend(place(item, &projection, middle));
        }
        let is_silent = volume.peak <= 0.0;
        let (body, level) = match scenery.body {
            _ if is_silent => (Body::Hidden, 0.0),
            Body::Surface(part) => (scenery.body, part * volume.peak),
            Body::Hidden | Body::Projection => (scenery.body, 0.0),
        };
        let of = |point: DVec3| (point - middle).as_vec3().to_array();
        let direction = |direction: DVec3| direction.as_vec3().to_array();
        let lattice = &volume.lattice;
        let across = size.0.div_ceil(TILE);
        let params = ShotParams {
            eye: of(projection.eye),
            aside: projection.aside as f32,
            right: direction(projection.right),
            spread: projection.spread as f32,
            up: direction(projection.up),
            level,
            forward: direction(projection.forward),
            per_peak: if is_silent { 0.0 } else { 1.0 / volume.peak },
            low: of(scenery.clip.low()),
            width: size.0 as f32,
            high: of(scenery.clip.high()),
            height: size.1 as f32,
            first: of(lattice.first),
            tiles: across as u32,
            per_metre: lattice.step.recip().as_vec3().to_array(),
            more: 0.0,
            counts: lattice.counts.to_array(),
            columns: size.0 as u32,
            bricks: volume.brick_counts().to_array(),
            rows: size.1 as u32,
            surface: scenery.surface.extend(1.0).to_array(),
            top: scenery.ground[0].extend(1.0).to_array(),
            bottom: scenery.ground[1].extend(1.0).to_array(),
        };
        let tiles = tiles(&placed, across, size.1.div_ceil(TILE));
        Self { params, body, things: placed.into_iter().map(|(thing, _)| thing).collect(), tiles, size }
    }
}

/// An item in a picture, with its bounding pixels; `None` if invisible.
fn place(item: &Item, projection: &Projection, middle: DVec3) -> Option<(Thing, [DVec2; 2])> {
    let words = |v: DVec3, w: f32| {
        let v = v.as_vec3();
        [v.x, v.y, v.z, w]
    };
    let all = [DVec2::ZERO, projection.size];
    // Quantities linear along a line in the picture.
    let even = |depth: f64| {
        let depth = depth * (1.0 - FORWARD);
        (if projection.spread > 0.0 { 1.0 / depth } else { depth }) as f32
    };
    let (thing, bounds) = match *item {
        Item::Line { ends, width, colour, shine } => {
            let [a, b] = projection.in_front(ends)?;
            let ((a, near), (b, far)) = (projection.screen(a)?, projection.screen(b)?);
            let half = width / 2.0;
            let thing = Thing {
                place: [a.x as f32, a.y as f32, even(near), LINE as f32],
                first: [b.x as f32, b.y as f32, even(far), half as f32],
                second: [shine, 0.0, 0.0, 0.0],
                colour: colour.to_array(),
            };
            let more = DVec2::splat(half + 1.0);
            (thing, [a.min(b) - more, a.max(b) + more])
        }
        Item::Dot { at, radius, colour, shine } => {
            let (at, depth) = projection.screen(at)?;
            let thing = Thing {
                place: [at.x as f32, at.y as f32, even(depth), DOT as f32],
                first: [radius as f32, 0.0, 0.0, 0.0],
                second: [shine, 0.0, 0.0, 0.0],
                colour: colour.to_array(),
            };
            let more = DVec2::splat(radius + 1.0);
            (thing, [at - more, at + more])
        }
        Item::Disc { centre, normal, radius, colour } => {
            let (at, depth) = projection.screen(centre)?;
            let thing = Thing {
                place: words(centre - middle, DISC as f32),
                first: words(normal, radius as f32),
                second: [0.0; 4],
                colour: colour.to_array(),
            };
            let nearest = projection.per_pixel(depth - radius);
            let more = DVec2::splat(radius / nearest + 1.0);
            (thing, if nearest > 0.0 { [at - more, at + more] } else { all })
        }
        Item::Panel { centre, half, colour } => {
            let thing = Thing {
                place: words(centre - middle, PANEL as f32),
                first: words(half[0] / half[0].length_squared(), 0.0),
                second: words(half[1] / half[1].length_squared(), 0.0),
                colour: colour.to_array(),
            };
            (thing, rectangle(centre, half, projection).unwrap_or(all))
        }
        Item::Slice { centre, half, opacity } => {
            let thing = Thing {
                place: words(centre - middle, SLICE as f32),
                first: words(half[0] / half[0].length_squared(), 0.0),
                second: words(half[1] / half[1].length_squared(), opacity),
                colour: [0.0; 4],
            };
            (thing, rectangle(centre, half, projection).unwrap_or(all))
        }
        Item::Facet { corners: [a, b, c], normals, pressures } => {
            let (first, second) = (b - a, c - a);
            let normal = first.cross(second);
            let towards = if projection.spread > 0.0 { a - projection.eye } else { projection.forward };
            let square = normal.length_squared();
            if normal.dot(towards) >= 0.0 || square == 0.0 {
                return None;
            }
            let [p, q, r] = pressures.unwrap_or([-1.0; 3]);
            let light = light(projection).as_vec3();
            let [at_a, at_b, at_c] = normals.map(|normal| DARKEST + (1.0 - DARKEST) * lit(normal.dot(light)));
            let thing = Thing {
                place: words(a - middle, FACET as f32),
                first: words(second.cross(normal) / square, p),
                second: words(normal.cross(first) / square, q),
                colour: [r, at_a, at_b, at_c],
            };
            (thing, around([a, b, c], projection).unwrap_or(all))
        }
    };
    let [low, high] = bounds;
    let is_seen = low.cmplt(projection.size).all() && high.cmpgt(DVec2::ZERO).all();
    is_seen.then_some((thing, [low.max(DVec2::ZERO), high.min(projection.size)]))
}

/// Bounds of a rectangle; `None` if it reaches behind the eye.
fn rectangle(centre: DVec3, [a, b]: [DVec3; 2], projection: &Projection) -> Option<[DVec2; 2]> {
    around([centre - a - b, centre - a + b, centre + a - b, centre + a + b], projection)
}

/// Bounds of what is between points, likewise.
fn around<const N: usize>(corners: [DVec3; N], projection: &Projection) -> Option<[DVec2; 2]> {
    let (mut low, mut high) = (DVec2::MAX, DVec2::MIN);
    for corner in corners {
        let (at, _) = projection.screen(corner)?;
        (low, high) = (low.min(at), high.max(at));
    }
    Some([low - 1.0, high + 1.0])
}

/// The direction to the light: above the left of the eye.
fn light(projection: &Projection) -> DVec3 {
    projection.up * 0.64 - projection.right * 0.44 - projection.forward * 0.63
}

/// How bright a surface is, by the cosine between its normal and the light.
fn lit(cosine: f32) -> f32 {
    0.5 + 0.5 * cosine.clamp(-1.0, 1.0)
}

/// The lists of all tiles.
fn tiles(placed: &[(Thing, [DVec2; 2])], across: usize, up: usize) -> Vec<u32> {
    let mut lists = vec![Vec::new(); across * up];
    for (number, (thing, [low, high])) in placed.iter().enumerate() {
        let tile = |pixel: f64, most: usize| ((pixel.max(0.0) as usize) / TILE).min(most - 1);
        for row in tile(low.y, up)..=tile(high.y, up) {
            for column in tile(low.x, across)..=tile(high.x, across) {
                if is_near(thing, column, row) {
                    lists[row * across + column].push(number as u32);
                }
            }
        }
    }
    let mut tiles = Vec::with_capacity(lists.len() + 1 + lists.iter().map(Vec::len).sum::<usize>());
    let mut place = lists.len() as u32 + 1;
    for list in &lists {
        tiles.push(place);
        place += list.len() as u32;
    }
    tiles.push(place);
    tiles.extend(lists.into_iter().flatten());
    tiles
}

/// Whether an object may be visible in a tile within its bounds: long lines touch few of them.
fn is_near(thing: &Thing, column: usize, row: usize) -> bool {
    if thing.place[3] as u32 != LINE {
        return true;
    }
    let middle = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * TILE as f64;
    let point = |[x, y, ..]: [f32; 4]| DVec2::new(x.into(), y.into());
    let (a, b) = (point(thing.place), point(thing.first));
    let along = b - a;
    let part = ((middle - a).dot(along) / along.length_squared().max(1e-9)).clamp(0.0, 1.0);
    let reach = TILE as f64 * std::f64::consts::FRAC_1_SQRT_2 + f64::from(thing.first[3]) + 1.0;
    (a + along * part).distance(middle) <= reach
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::volume::Lattice;

    #[test]
    fn tiles_list_what_is_seen_in_them() {
        let clip = Block { centre: DVec3::new(0.0, 0.0, 0.1), size: DVec3::splat(0.1) };
        let colour = Vec4::ONE;
        let items = vec![
            Item::Dot { at: clip.centre, radius: 3.0, colour, shine: 0.0 },
            Item::Line { ends: [clip.low(), clip.high()], width: 1.0, colour, shine: 0.0 },
            Item::Dot { at: DVec3::new(9.0, 0.0, 0.0), radius: 3.0, colour, shine: 0.0 },
        ];
        let scenery = Scenery {
            items,
            body: Body::Projection,
            clip,
            surface: Vec3::ONE,
            table: [[0; 4]; 256],
            ground: [Vec3::ZERO; 2],
        };
        let lattice = Lattice::covering(&clip, DVec3::splat(0.01));
        let volume = Volume::of(lattice, vec![0.0; lattice.len()]);
        let camera = Camera::of(&clip, [0.0, 0.0], 1.0, false);
        let shot = Shot::new(&scenery, &volume, &camera, (160, 160));
        assert_eq!(shot.things.len(), 2, "what is beside the picture is left out");
        assert_eq!(shot.body, Body::Hidden, "silence has no body");
        let list = |column: usize, row: usize| {
            let tile = row * 10 + column;
            shot.tiles[shot.tiles[tile] as usize..shot.tiles[tile + 1] as usize].to_vec()
        };
        assert_eq!((list(4, 4), list(5, 5), list(0, 0)), (vec![0, 1], vec![0, 1], vec![]));
        assert_eq!((list(2, 7), list(2, 2)), (vec![1], vec![]), "the line rises to the right");
        assert_eq!(shot.tiles.last().map(|&last| last < 2), Some(true));
    }

    #[test]
    fn discs_and_rectangles_are_listed_in_the_tiles_of_all_their_pixels() {
        let clip = Block { centre: DVec3::ZERO, size: DVec3::splat(0.1) };
        let scattered =
            |n: usize| DVec3::from_array([0.618, 0.755, 0.57].map(|step| (n as f64 * step).fract() - 0.5));
        // Every other one faces the eye.
        let normal = |n: usize| match n % 2 {
            0 => DVec3::NEG_Y,
            _ => (scattered(n) + DVec3::NEG_Y).normalize_or_zero(),
        };
        let half = |n: usize| {
            let (a, b) = normal(n).any_orthonormal_pair();
            [a * (0.002 + 1e-4 * (n % 31) as f64), b * (0.002 + 1e-4 * (n % 37) as f64)]
        };
        let item = |n: usize| {
            let (centre, colour) = (0.08 * scattered(7 * n + 1), Vec4::ONE);
            match n % 4 {
                0 | 1 => {
                    Item::Disc { centre, normal: normal(n), radius: 1e-4 * (10 + n % 50) as f64, colour }
                }
                2 => Item::Panel { centre, half: half(n / 2), colour },
                _ => Item::Slice { centre, half: half(n / 2), opacity: 1.0 },
            }
        };
        let scenery = Scenery {
            items: (0..120).map(item).collect(),
            body: Body::Hidden,
            clip,
            surface: Vec3::ONE,
            table: [[0; 4]; 256],
            ground: [Vec3::ZERO; 2],
        };
        let lattice = Lattice::covering(&clip, DVec3::splat(0.05));
        let volume = Volume::of(lattice, vec![0.0; lattice.len()]);
        for is_perspective in [false, true] {
            let camera = Camera::of(&clip, [0.0, 0.0], 1.0, is_perspective);
            let shot = Shot::new(&scenery, &volume, &camera, (160, 160));
            assert_eq!(shot.things.len(), scenery.items.len());
            let projection = camera.projection(DVec2::splat(160.0));
            let (mut covered, mut listed) = (0, 0);
            for pixel in 0..160 * 160usize {
                let (x, y) = (pixel % 160, pixel / 160);
                let (start, direction) = projection.ray(DVec2::new(x as f64, y as f64) + 0.5);
                let meets = |centre: DVec3, normal: DVec3| {
                    let depth = (centre - start).dot(normal) / direction.dot(normal);
                    (start + direction * depth - centre, depth)
                };
                let tile = y / TILE * 10 + x / TILE;
                let list = &shot.tiles[shot.tiles[tile] as usize..shot.tiles[tile + 1] as usize];
                listed += list.len();
                for (number, item) in scenery.items.iter().enumerate() {
                    let is_covered = match *item {
                        Item::Disc { centre, normal, radius, .. } => {
                            let (off, depth) = meets(centre, normal);
                            off.length() < radius + 0.4 * projection.per_pixel(depth)
                        }
                        Item::Panel { centre, half, .. } | Item::Slice { centre, half, .. } => {
                            let (off, _) = meets(centre, half[0].cross(half[1]));
                            half.iter().all(|half| off.dot(*half).abs() < half.length_squared())
                        }
                        Item::Line { .. } | Item::Dot { .. } | Item::Facet { .. } => {
                            unreachable!("there are none")
                        }
                    };
                    assert!(!is_covered || list.contains(&(number as u32)), "{item:?} at {x}, {y}");
                    covered += usize::from(is_covered);
                }
            }
            assert!(covered > 5000 && listed < 120 * 160 * 160 / 8, "{covered} and {listed}");
        }
    }
}
