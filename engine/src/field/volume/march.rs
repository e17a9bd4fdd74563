//! The CPU renderer of 3D pictures, by ray marching: for machines without a GPU, and as the reference for the GPU's
//! pictures.

use glam::{UVec3, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use crate::field::volume::Volume;
use crate::field::volume::bricks::BRICK;
use crate::field::volume::scenery::{
    Body, DISC, DOT, FACET, LINE, MOST_MET, PANEL, SLICE, Shot, ShotParams, TILE, Thing,
};

/// Positions of the rays in a pixel with antialiasing.
pub const SMOOTH: [[f32; 2]; 4] = [[0.125, -0.375], [0.375, 0.125], [-0.125, 0.375], [-0.375, -0.125]];
/// Limits of steps within a brick and of bricks along a ray; bisection steps for a surface between two steps.
pub const MOST_STEPS: u32 = 64;
pub const MOST_BRICKS: u32 = 4096;
pub const HALVINGS: u32 = 5;
/// Step of a ray in lattice steps: towards a surface, and towards the maximum.
pub const SURFACE_STRIDE: f32 = 0.8;
pub const PROJECTION_STRIDE: f32 = 0.8;
/// Offset (in steps) beyond a brick's face for the lookup of the next brick, and smallest advance of a ray.
pub const NUDGE: f32 = 1e-3;
pub const LEAST: f32 = 1e-2;
/// Slope of a ray across a brick's faces, relative to its steepest, up to which it leaves through none of them. Within
/// rounding of a face it would advance by [`LEAST`] only.
pub const LEAST_SLOPE: f32 = 1e-5;
/// Fraction of the largest value that is opaque in a projection, and smallest opacity of a slice.
pub const OPAQUE: f32 = 0.6;
pub const FAINT: f32 = 0.4;
/// Overlap of facets relative to their sides, so that no ray passes between them.
pub const OVERLAP: f32 = 2e-3;
/// Grey of a body, and its part in the colour of no pressure, so that silent ones are seen.
pub const SKIN: f32 = 0.62;
pub const SKIN_PART: f32 = 0.55;
/// Difference of neighbours, of 255, above which a pixel gets more rays.
const CONTRAST: u8 = 10;
/// Opacity that hides everything behind it.
pub const SOLID: f32 = 0.995;

/// The colours r, g, b, a of a picture from the top left, antialiased or fast.
pub fn picture(shot: &Shot, volume: &Volume, table: &[[u8; 4]; 256], is_smooth: bool) -> Vec<u8> {
    let table = table.map(|[r, g, b, _]| Vec3::new(f32::from(r), f32::from(g), f32::from(b)) / 255.0);
    let (width, height) = shot.size;
    let painter = Painter { shot, params: &shot.params, volume, table: &table };
    let mut rgba = vec![0; width * height * 4];
    let rows = |rgba: &mut Vec<u8>, paint: &(dyn Fn(usize, usize) -> Option<[u8; 4]> + Sync)| {
        let each = |(y, row): (usize, &mut [u8])| {
            for (x, pixel) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                if let Some(colour) = paint(x, y) {
                    *pixel = colour;
                }
            }
        };
        rgba.par_chunks_mut((width * 4).max(1)).enumerate().for_each(each);
    };
    rows(&mut rgba, &|x, y| Some(painter.pixel(x, y, &[[0.0, 0.0]])));
    if is_smooth {
        // Between equal neighbours, more rays would add nothing.
        let first = rgba.clone();
        rows(&mut rgba, &|x, y| is_edge(&first, width, height, x, y).then(|| painter.pixel(x, y, &SMOOTH)));
    }
    rgba
}

/// Whether a pixel differs from one beside it.
fn is_edge(rgba: &[u8], width: usize, height: usize, x: usize, y: usize) -> bool {
    let pixel = |x: usize, y: usize| &rgba[(y * width + x) * 4..][..3];
    let own = pixel(x, y);
    let differs = |other: &[u8]| own.iter().zip(other).any(|(a, b)| a.abs_diff(*b) > CONTRAST);
    (x > 0 && differs(pixel(x - 1, y)))
        || (x + 1 < width && differs(pixel(x + 1, y)))
        || (y > 0 && differs(pixel(x, y - 1)))
        || (y + 1 < height && differs(pixel(x, y + 1)))
}

struct Painter<'a> {
    shot: &'a Shot,
    params: &'a ShotParams,
    volume: &'a Volume,
    table: &'a [Vec3; 256],
}

/// A ray, with a direction scaled to a forward component of 1.
#[derive(Clone, Copy)]
struct Ray {
    start: Vec3,
    direction: Vec3,
}

/// A ray in steps of the lattice.
#[derive(Clone, Copy)]
struct Grid {
    start: Vec3,
    direction: Vec3,
    /// 1 over the direction; 0 for zero components, with their faces out of reach.
    inverse: Vec3,
    never: Vec3,
    /// The faces of a brick ahead of it: 0 or the brick's side.
    ahead: Vec3,
    /// Depth of one step along its dominant axis.
    step: f32,
}

/// Hits of a ray, nearest first.
#[derive(Default)]
struct Met {
    count: usize,
    depths: [f32; MOST_MET],
    colours: [Vec4; MOST_MET],
}

impl Met {
    fn add(&mut self, depth: f32, colour: Vec4) {
        let mut place = self.count.min(MOST_MET - 1);
        if self.count == MOST_MET && depth >= self.depths[place] {
            return;
        }
        while place > 0 && self.depths[place - 1] > depth {
            self.depths[place] = self.depths[place - 1];
            self.colours[place] = self.colours[place - 1];
            place -= 1;
        }
        self.depths[place] = depth;
        self.colours[place] = colour;
        self.count = (self.count + 1).min(MOST_MET);
    }

    /// Depth of the first solid hit.
    fn solid(&self) -> f32 {
        (0..self.count).find(|&i| self.colours[i].w >= SOLID).map_or(f32::MAX, |i| self.depths[i])
    }

    fn over(&self, ground: Vec3) -> Vec3 {
        let (mut sum, mut left) = (Vec3::ZERO, 1.0);
        for colour in &self.colours[..self.count] {
            sum += colour.truncate() * (colour.w * left);
            left *= 1.0 - colour.w;
        }
        sum + ground * left
    }
}

impl Painter<'_> {
    /// The mean of some rays through a pixel.
    fn pixel(&self, x: usize, y: usize, rays: &[[f32; 2]]) -> [u8; 4] {
        let middle = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let tile = y / TILE * self.params.tiles as usize + x / TILE;
        let sum: Vec3 = rays.iter().map(|&ray| self.colour(middle + Vec2::from(ray), tile)).sum();
        let [r, g, b] = (sum * (255.0 / rays.len() as f32) + 0.5).to_array().map(|c| c as u8);
        [r, g, b, 255]
    }

    fn colour(&self, at: Vec2, tile: usize) -> Vec3 {
        let params = self.params;
        let offset = at - Vec2::new(params.width, params.height) / 2.0;
        let across = Vec3::from(params.right) * offset.x - Vec3::from(params.up) * offset.y;
        let ray = Ray {
            start: Vec3::from(params.eye) + across * params.aside,
            direction: Vec3::from(params.forward) + across * params.spread,
        };
        let mut met = Met::default();
        // The nearest that shines through.
        let (mut shining, mut shine) = (f32::MAX, Vec4::ZERO);
        let tiles = &self.shot.tiles;
        for &number in &tiles[tiles[tile] as usize..tiles[tile + 1] as usize] {
            let thing = &self.shot.things[number as usize];
            let Some((depth, colour)) = self.meet(thing, at, ray) else { continue };
            met.add(depth, colour);
            if thing.place[3] as u32 <= DOT && thing.second[0] > 0.0 && depth < shining {
                (shining, shine) = (depth, colour.truncate().extend(colour.w * thing.second[0]));
            }
        }
        if let Some((near, far)) = self.inside(ray) {
            let far = far.min(met.solid());
            let body = match self.shot.body {
                Body::Hidden => None,
                Body::Surface(_) => self.surface(ray, near, far),
                Body::Projection => self.projection(ray, near, far),
            };
            if let Some((depth, colour)) = body {
                met.add(depth, colour);
            }
        }
        let height = (at.y / params.height).clamp(0.0, 1.0);
        let ground = Vec4::from(params.top).lerp(Vec4::from(params.bottom), height);
        let colour = met.over(ground.truncate());
        if shining > met.solid() { colour.lerp(shine.truncate(), shine.w) } else { colour }
    }

    /// The interval of a ray within the clipping box.
    fn inside(&self, ray: Ray) -> Option<(f32, f32)> {
        let inverse = ray.direction.recip();
        let a = (Vec3::from(self.params.low) - ray.start) * inverse;
        let b = (Vec3::from(self.params.high) - ray.start) * inverse;
        let near = a.min(b).max_element().max(0.0);
        let far = a.max(b).min_element();
        (near < far).then_some((near, far))
    }

    /// A colour of the table, by a part of the peak.
    fn tint(&self, part: f32) -> Vec3 {
        self.table[(part.clamp(0.0, 1.0) * 255.0 + 0.5) as usize]
    }

    /// The intersection of a ray with an object, and its colour there.
    fn meet(&self, thing: &Thing, at: Vec2, ray: Ray) -> Option<(f32, Vec4)> {
        let [x, y, z, kind] = thing.place;
        let colour = Vec4::from(thing.colour);
        let cover = |colour: Vec4, part: f32| colour.truncate().extend(colour.w * part.clamp(0.0, 1.0));
        let depth_of = |even: f32| if self.params.spread > 0.0 { 1.0 / even } else { even };
        let [a, b, c, d] = thing.first;
        match kind as u32 {
            LINE => {
                let (from, to) = (Vec2::new(x, y), Vec2::new(a, b));
                let along = to - from;
                let part = ((at - from).dot(along) / along.length_squared().max(1e-6)).clamp(0.0, 1.0);
                let off = (from + along * part).distance(at);
                let covered = d + 0.5 - off;
                (covered > 0.0).then(|| (depth_of(z + (c - z) * part), cover(colour, covered)))
            }
            DOT => {
                let off = Vec2::new(x, y).distance(at);
                let covered = a + 0.5 - off;
                let slant = (off / a).min(1.0);
                let shade = 0.62 + 0.38 * (1.0 - slant * slant).sqrt();
                let colour = (colour.truncate() * shade).extend(colour.w);
                (covered > 0.0).then(|| (depth_of(z), cover(colour, covered)))
            }
            DISC => {
                let (centre, normal) = (Vec3::new(x, y, z), Vec3::new(a, b, c));
                let depth = (centre - ray.start).dot(normal) / ray.direction.dot(normal);
                let off = (ray.start + ray.direction * depth).distance(centre);
                let pixel = self.params.aside + self.params.spread * depth;
                let covered = (d - off) / pixel + 0.5;
                (depth > 0.0 && covered > 0.0).then(|| (depth, cover(colour, covered)))
            }
            FACET => {
                let corner = Vec3::new(x, y, z);
                let (first, second) = (Vec3::new(a, b, c), Vec4::from(thing.second));
                let normal = first.cross(second.truncate());
                let depth = (corner - ray.start).dot(normal) / ray.direction.dot(normal);
                let point = ray.start + ray.direction * depth - corner;
                let (s, t) = (point.dot(first), point.dot(second.truncate()));
                let is_met = depth > 0.0 && s >= -OVERLAP && t >= -OVERLAP && s + t <= 1.0 + OVERLAP;
                is_met.then(|| {
                    let rest = 1.0 - s - t;
                    let pressure = rest * d + s * second.w + t * colour.x;
                    let light = rest * colour.y + s * colour.z + t * colour.w;
                    let grey = Vec3::splat(SKIN);
                    let part = (pressure * self.params.per_peak).clamp(0.0, 1.0);
                    let tint = self.tint(part).lerp(grey, SKIN_PART * (1.0 - part));
                    (depth, (if colour.x < 0.0 { grey } else { tint } * light).extend(1.0))
                })
            }
            PANEL | SLICE => {
                let centre = Vec3::new(x, y, z);
                let (first, second) = (Vec3::new(a, b, c), Vec4::from(thing.second));
                let normal = first.cross(second.truncate());
                let depth = (centre - ray.start).dot(normal) / ray.direction.dot(normal);
                let point = ray.start + ray.direction * depth;
                let place = Vec2::new((point - centre).dot(first), (point - centre).dot(second.truncate()));
                let is_met = depth > 0.0 && place.abs().max_element() <= 1.0;
                if !is_met {
                    return None;
                }
                if kind as u32 == PANEL {
                    return Some((depth, colour));
                }
                let (low, high) = (Vec3::from(self.params.low), Vec3::from(self.params.high));
                const SLACK: f32 = 1e-5;
                let is_inside = point.cmpge(low - SLACK).all() && point.cmple(high + SLACK).all();
                is_inside.then(|| {
                    let part = self.volume.at(self.place(point)) * self.params.per_peak;
                    (depth, self.tint(part).extend(second.w * (FAINT + (1.0 - FAINT) * part.min(1.0))))
                })
            }
            _ => None,
        }
    }

    /// Steps of the lattice from its first point.
    fn place(&self, point: Vec3) -> Vec3 {
        (point - Vec3::from(self.params.first)) * Vec3::from(self.params.per_metre)
    }

    /// The same ray in steps of the lattice.
    fn in_steps(&self, ray: Ray) -> Grid {
        let direction = ray.direction * Vec3::from(self.params.per_metre);
        let most = direction.abs().max_element();
        let is_along = direction.abs().cmpgt(Vec3::splat(LEAST_SLOPE * most));
        Grid {
            start: self.place(ray.start),
            direction,
            inverse: Vec3::select(is_along, direction.recip(), Vec3::ZERO),
            never: Vec3::select(is_along, Vec3::ZERO, Vec3::MAX),
            ahead: Vec3::select(direction.cmpgt(Vec3::ZERO), Vec3::splat(BRICK as f32), Vec3::ZERO),
            step: 1.0 / most,
        }
    }

    /// The largest value in the brick of a ray just beyond a depth, and the exit depth.
    fn brick(&self, grid: &Grid, depth: f32) -> (f32, f32) {
        let bricks = UVec3::from(self.params.bricks);
        let place = grid.start + grid.direction * (depth + NUDGE * grid.step);
        let brick = (place * (1.0 / BRICK as f32)).floor().clamp(Vec3::ZERO, (bricks - UVec3::ONE).as_vec3());
        let cell = brick.as_uvec3();
        let number = cell.x + bricks.x * (cell.y + bricks.y * cell.z);
        let exits = (brick * BRICK as f32 + grid.ahead - grid.start) * grid.inverse + grid.never;
        (self.volume.bricks[number as usize], exits.min_element())
    }

    /// The isosurface, or the clipping face that cuts its inside.
    fn surface(&self, ray: Ray, near: f32, far: f32) -> Option<(f32, Vec4)> {
        let level = self.params.level;
        let grid = self.in_steps(ray);
        let step = grid.step;
        let at = |depth: f32| self.volume.at(grid.start + grid.direction * depth);
        let value = at(near);
        if near < far && value >= level {
            return Some((near, self.tint(value * self.params.per_peak).extend(1.0)));
        }
        let mut depth = near;
        for _ in 0..MOST_BRICKS {
            if depth >= far {
                return None;
            }
            let (largest, exit) = self.brick(&grid, depth);
            let end = exit.max(depth + LEAST * step).min(far);
            if largest >= level {
                let mut before = depth;
                for i in 1..=MOST_STEPS {
                    let here = (depth + i as f32 * SURFACE_STRIDE * step).min(end);
                    if at(here) >= level {
                        return Some(self.hit(ray, grid, (before, here)));
                    }
                    before = here;
                    if here >= end {
                        break;
                    }
                }
            }
            depth = end;
        }
        None
    }

    /// The shaded surface between two depths.
    fn hit(&self, ray: Ray, grid: Grid, (mut outside, mut inside): (f32, f32)) -> (f32, Vec4) {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (outside + inside);
            if self.volume.at(grid.start + grid.direction * middle) >= self.params.level {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        let slope =
            self.volume.slope(grid.start + grid.direction * inside) * Vec3::from(self.params.per_metre);
        let colour = lit(self.params, slope, ray.direction);
        (inside, colour.extend(1.0))
    }

    /// The largest value along a ray.
    fn projection(&self, ray: Ray, near: f32, far: f32) -> Option<(f32, Vec4)> {
        let grid = self.in_steps(ray);
        let step = grid.step;
        let at = |depth: f32| self.volume.at(grid.start + grid.direction * depth);
        let (mut largest, mut place) = (if near < far { at(near) } else { 0.0 }, near);
        let mut depth = near;
        for _ in 0..MOST_BRICKS {
            if depth >= far {
                break;
            }
            let (most, exit) = self.brick(&grid, depth);
            let end = exit.max(depth + LEAST * step).min(far);
            if most > largest {
                for i in 1..=MOST_STEPS {
                    let here = (depth + i as f32 * PROJECTION_STRIDE * step).min(end);
                    let value = at(here);
                    if value > largest {
                        (largest, place) = (value, here);
                    }
                    if here >= end {
                        break;
                    }
                }
            }
            depth = end;
        }
        let part = largest * self.params.per_peak;
        (largest > 0.0).then(|| (place, self.tint(part).extend((part / OPAQUE).min(1.0))))
    }
}

/// The colour of the surface where the field has this slope, lit from above the left of an eye that looks along
/// `direction`.
fn lit(params: &ShotParams, slope: Vec3, direction: Vec3) -> Vec3 {
    let colour = Vec4::from(params.surface).truncate();
    let (right, up, forward) = (Vec3::from(params.right), Vec3::from(params.up), Vec3::from(params.forward));
    let towards = -direction * direction.length_recip();
    let mut normal = -slope / slope.length().max(1e-20);
    if normal.dot(towards) < 0.0 {
        normal = -normal;
    }
    let light = up * 0.64 - right * 0.44 - forward * 0.63;
    let facing = 0.5 + 0.5 * normal.dot(light);
    let between = light + towards;
    let glint = normal.dot(between * between.length_recip()).max(0.0);
    let glint = glint * glint;
    let glint = glint * glint;
    let glint = glint * glint;
    let glint = glint * glint;
    let glint = glint * glint;
    let rim = 1.0 - normal.dot(towards);
    let lit = colour * (0.22 + 0.86 * facing * facing) + 0.28 * glint + 0.16 * rim * rim * rim;
    lit.clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests;
