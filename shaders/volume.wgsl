// 3D pictures by ray marching: the twin of engine/src/field/volume/march.rs. Its constants, the choice of isosurface or
// projection, and the rays per pixel are prepended.

struct ShotParams {
    // m from the centre of the clipping box.
    eye: vec3f,
    // Offset (m) of a ray's start, and its spread per m, for a pixel beside the centre.
    aside: f32,
    right: vec3f,
    spread: f32,
    up: vec3f,
    level: f32,
    forward: vec3f,
    per_peak: f32,
    low: vec3f,
    width: f32,
    high: vec3f,
    height: f32,
    first: vec3f,
    tiles: u32,
    per_metre: vec3f,
    more: f32,
    counts: vec3u,
    columns: u32,
    bricks: vec3u,
    rows: u32,
    surface: vec4f,
    top: vec4f,
    bottom: vec4f,
}

struct Thing {
    place: vec4f,
    first: vec4f,
    second: vec4f,
    colour: vec4f,
}

struct Ray {
    start: vec3f,
    direction: vec3f,
}

// A ray in steps of the lattice.
struct Grid {
    start: vec3f,
    direction: vec3f,
    inverse: vec3f,
    never: vec3f,
    ahead: vec3f,
    step: f32,
}

// Hits of a ray, nearest first.
struct Met {
    count: u32,
    depths: array<f32, MOST_MET>,
    colours: array<vec4f, MOST_MET>,
}

// A colour at a depth; none at FARTHEST.
struct Hit {
    depth: f32,
    colour: vec4f,
}

const FARTHEST: f32 = 3.0e38;

@group(0) @binding(0) var<uniform> params: ShotParams;
@group(0) @binding(1) var<storage, read> values: array<f32>;
// The largest value of every brick.
@group(0) @binding(2) var<storage, read> bricks: array<f32>;
@group(0) @binding(3) var<storage, read> things: array<Thing>;
// The start of each tile's list, then the end of the last; then the lists.
@group(0) @binding(4) var<storage, read> tiles: array<u32>;
@group(0) @binding(5) var colours: texture_2d<f32>;
@group(0) @binding(6) var picture: texture_storage_2d<rgba8unorm, write>;

fn add(met: ptr<function, Met>, hit: Hit) {
    var place = min((*met).count, MOST_MET - 1u);
    if (*met).count == MOST_MET && hit.depth >= (*met).depths[place] {
        return;
    }
    for (var i = 0u; i < MOST_MET; i++) {
        if place == 0u || (*met).depths[place - 1u] <= hit.depth {
            break;
        }
        (*met).depths[place] = (*met).depths[place - 1u];
        (*met).colours[place] = (*met).colours[place - 1u];
        place -= 1u;
    }
    (*met).depths[place] = hit.depth;
    (*met).colours[place] = hit.colour;
    (*met).count = min((*met).count + 1u, MOST_MET);
}

// Limit of depth.
fn solid(met: ptr<function, Met>) -> f32 {
    for (var i = 0u; i < MOST_MET; i++) {
        if i >= (*met).count {
            break;
        }
        if (*met).colours[i].w >= SOLID {
            return (*met).depths[i];
        }
    }
    return FARTHEST;
}

// A colour of the table at a fraction of the peak.
fn tint(part: f32) -> vec3f {
    return textureLoad(colours, vec2u(u32(clamp(part, 0.0, 1.0) * 255.0 + 0.5), 0u), 0).xyz;
}

// Lattice coordinates in steps from the first point.
fn steps(point: vec3f) -> vec3f {
    return (point - params.first) * params.per_metre;
}

fn value_at(wanted: vec3f) -> f32 {
    let place = clamp(wanted, vec3f(0.0), vec3f(params.counts - 1u));
    let cell = min(vec3u(place), params.counts - 2u);
    let part = place - vec3f(cell);
    let row = params.counts.x;
    let layer = row * params.counts.y;
    let corner = cell.x + cell.y * row + cell.z * layer;
    let low = vec4f(values[corner], values[corner + row], values[corner + layer], values[corner + row + layer]);
    let next = corner + 1u;
    let high = vec4f(values[next], values[next + row], values[next + layer], values[next + row + layer]);
    let along = low + (high - low) * part.x;
    let across = along.xz + (along.yw - along.xz) * part.y;
    return across.x + (across.y - across.x) * part.z;
}

fn slope_at(place: vec3f) -> vec3f {
    let x = value_at(place + vec3f(1.0, 0.0, 0.0)) - value_at(place - vec3f(1.0, 0.0, 0.0));
    let y = value_at(place + vec3f(0.0, 1.0, 0.0)) - value_at(place - vec3f(0.0, 1.0, 0.0));
    let z = value_at(place + vec3f(0.0, 0.0, 1.0)) - value_at(place - vec3f(0.0, 0.0, 1.0));
    return 0.5 * vec3f(x, y, z);
}

fn cover(colour: vec4f, part: f32) -> vec4f {
    return vec4f(colour.xyz, colour.w * clamp(part, 0.0, 1.0));
}

// Depth from quantities linear along a line in the picture.
fn depth_of(even: f32) -> f32 {
    return select(even, 1.0 / even, params.spread > 0.0);
}

fn meet(thing: Thing, at: vec2f, ray: Ray) -> Hit {
    let nothing = Hit(FARTHEST, vec4f(0.0));
    let kind = u32(thing.place.w);
    if kind == LINE {
        let along = thing.first.xy - thing.place.xy;
        let part = clamp(dot(at - thing.place.xy, along) / max(dot(along, along), 1e-6), 0.0, 1.0);
        let covered = thing.first.w + 0.5 - distance(thing.place.xy + along * part, at);
        if covered > 0.0 {
            let even = thing.place.z + (thing.first.z - thing.place.z) * part;
            return Hit(depth_of(even), cover(thing.colour, covered));
        }
        return nothing;
    }
    if kind == DOT {
        let off = distance(thing.place.xy, at);
        let covered = thing.first.x + 0.5 - off;
        let slant = min(off / thing.first.x, 1.0);
        let shade = 0.62 + 0.38 * sqrt(1.0 - slant * slant);
        if covered > 0.0 {
            return Hit(depth_of(thing.place.z), cover(vec4f(thing.colour.xyz * shade, thing.colour.w), covered));
        }
        return nothing;
    }
    let centre = thing.place.xyz;
    if kind == DISC {
        let normal = thing.first.xyz;
        let depth = dot(centre - ray.start, normal) / dot(ray.direction, normal);
        let off = distance(ray.start + ray.direction * depth, centre);
        let covered = (thing.first.w - off) / (params.aside + params.spread * depth) + 0.5;
        if depth > 0.0 && covered > 0.0 {
            return Hit(depth, cover(thing.colour, covered));
        }
        return nothing;
    }
    let normal = cross(thing.first.xyz, thing.second.xyz);
    let depth = dot(centre - ray.start, normal) / dot(ray.direction, normal);
    let point = ray.start + ray.direction * depth;
    if kind == FACET {
        let s = dot(point - centre, thing.first.xyz);
        let t = dot(point - centre, thing.second.xyz);
        if depth > 0.0 && s >= -OVERLAP && t >= -OVERLAP && s + t <= 1.0 + OVERLAP {
            let rest = 1.0 - s - t;
            let pressure = rest * thing.first.w + s * thing.second.w + t * thing.colour.x;
            let light = rest * thing.colour.y + s * thing.colour.z + t * thing.colour.w;
            let part = clamp(pressure * params.per_peak, 0.0, 1.0);
            let coloured = mix(tint(part), vec3f(SKIN), SKIN_PART * (1.0 - part));
            return Hit(depth, vec4f(select(coloured, vec3f(SKIN), thing.colour.x < 0.0) * light, 1.0));
        }
        return nothing;
    }
    let place = abs(vec2f(dot(point - centre, thing.first.xyz), dot(point - centre, thing.second.xyz)));
    let is_met = depth > 0.0 && max(place.x, place.y) <= 1.0;
    if !is_met {
        return nothing;
    }
    if kind == PANEL {
        return Hit(depth, thing.colour);
    }
    if all(point >= params.low - 1e-5) && all(point <= params.high + 1e-5) {
        let part = value_at(steps(point)) * params.per_peak;
        return Hit(depth, vec4f(tint(part), thing.second.w * (FAINT + (1.0 - FAINT) * min(part, 1.0))));
    }
    return nothing;
}

fn in_steps(ray: Ray) -> Grid {
    let direction = ray.direction * params.per_metre;
    let along = abs(direction);
    let most = max(max(along.x, along.y), along.z);
    let is_along = along > vec3f(LEAST_SLOPE * most);
    return Grid(
        steps(ray.start),
        direction,
        select(vec3f(0.0), 1.0 / direction, is_along),
        select(vec3f(FARTHEST), vec3f(0.0), is_along),
        select(vec3f(0.0), vec3f(BRICK), direction > vec3f(0.0)),
        1.0 / most,
    );
}

// The largest value in the brick of a ray just beyond a depth, and the exit depth.
fn brick(grid: Grid, depth: f32) -> vec2f {
    let place = grid.start + grid.direction * (depth + NUDGE * grid.step);
    let brick = clamp(floor(place * (1.0 / BRICK)), vec3f(0.0), vec3f(params.bricks - 1u));
    let cell = vec3u(brick);
    let number = cell.x + params.bricks.x * (cell.y + params.bricks.y * cell.z);
    let exits = (brick * BRICK + grid.ahead - grid.start) * grid.inverse + grid.never;
    return vec2f(bricks[number], min(min(exits.x, exits.y), exits.z));
}

// A colour lit from above the eye's left.
fn lit(colour: vec3f, slope: vec3f, direction: vec3f) -> vec3f {
    let towards = -direction / length(direction);
    let outward = -slope / max(length(slope), 1e-20);
    let normal = select(outward, -outward, dot(outward, towards) < 0.0);
    let light = params.up * 0.64 - params.right * 0.44 - params.forward * 0.63;
    let facing = 0.5 + 0.5 * dot(normal, light);
    let between = light + towards;
    let once = max(dot(normal, between / length(between)), 0.0);
    let twice = once * once;
    let fourth = twice * twice;
    let eighth = fourth * fourth;
    let sixteenth = eighth * eighth;
    let glint = sixteenth * sixteenth;
    let rim = 1.0 - dot(normal, towards);
    let sum = colour * (0.22 + 0.86 * facing * facing) + 0.28 * glint + 0.16 * rim * rim * rim;
    return clamp(sum, vec3f(0.0), vec3f(1.0));
}

fn shaded(ray: Ray, grid: Grid, before: f32, here: f32) -> Hit {
    var outside = before;
    var inside = here;
    for (var i = 0u; i < HALVINGS; i++) {
        let middle = 0.5 * (outside + inside);
        if value_at(grid.start + grid.direction * middle) >= params.level {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    let slope = slope_at(grid.start + grid.direction * inside) * params.per_metre;
    return Hit(inside, vec4f(lit(params.surface.xyz, slope, ray.direction), 1.0));
}

fn body(ray: Ray, near: f32, far: f32) -> Hit {
    let grid = in_steps(ray);
    let step = grid.step;
    var depth = near;
    var largest = 0.0;
    var place = near;
    if near < far {
        let value = value_at(grid.start + grid.direction * near);
        if !IS_SURFACE {
            largest = value;
        } else if value >= params.level {
            return Hit(near, vec4f(tint(value * params.per_peak), 1.0));
        }
    }
    for (var n = 0u; n < MOST_BRICKS; n++) {
        if depth >= far {
            break;
        }
        let found = brick(grid, depth);
        let end = min(max(found.y, depth + LEAST * step), far);
        if IS_SURFACE {
            if found.x >= params.level {
                var before = depth;
                for (var i = 1u; i <= MOST_STEPS; i++) {
                    let here = min(depth + f32(i) * SURFACE_STRIDE * step, end);
                    if value_at(grid.start + grid.direction * here) >= params.level {
                        return shaded(ray, grid, before, here);
                    }
                    before = here;
                    if here >= end {
                        break;
                    }
                }
            }
        } else {
            if found.x > largest {
                for (var i = 1u; i <= MOST_STEPS; i++) {
                    let here = min(depth + f32(i) * PROJECTION_STRIDE * step, end);
                    let value = value_at(grid.start + grid.direction * here);
                    if value > largest {
                        largest = value;
                        place = here;
                    }
                    if here >= end {
                        break;
                    }
                }
            }
        }
        depth = end;
    }
    if largest > 0.0 {
        let part = largest * params.per_peak;
        return Hit(place, vec4f(tint(part), min(part / OPAQUE, 1.0)));
    }
    return Hit(FARTHEST, vec4f(0.0));
}

fn colour_at(at: vec2f, tile: u32) -> vec3f {
    let offset = at - vec2f(params.width, params.height) / 2.0;
    let across = params.right * offset.x - params.up * offset.y;
    let ray = Ray(params.eye + across * params.aside, params.forward + across * params.spread);
    var met: Met;
    met.count = 0u;
    // The nearest translucent hit.
    var shining = FARTHEST;
    var shine = vec4f(0.0);
    for (var i = tiles[tile]; i < tiles[tile + 1u]; i++) {
        let thing = things[tiles[i]];
        let hit = meet(thing, at, ray);
        if hit.depth < FARTHEST {
            add(&met, hit);
            if thing.place.w <= f32(DOT) && thing.second.x > 0.0 && hit.depth < shining {
                shining = hit.depth;
                shine = vec4f(hit.colour.xyz, hit.colour.w * thing.second.x);
            }
        }
    }
    if HAS_BODY {
        let a = (params.low - ray.start) / ray.direction;
        let b = (params.high - ray.start) / ray.direction;
        let enter = min(a, b);
        let leave = max(a, b);
        let near = max(max(max(enter.x, enter.y), enter.z), 0.0);
        let far = min(min(leave.x, leave.y), leave.z);
        if near < far {
            let hit = body(ray, near, min(far, solid(&met)));
            if hit.depth < FARTHEST {
                add(&met, hit);
            }
        }
    }
    var sum = vec3f(0.0);
    var left = 1.0;
    for (var i = 0u; i < MOST_MET; i++) {
        if i >= met.count {
            break;
        }
        sum += met.colours[i].xyz * (met.colours[i].w * left);
        left *= 1.0 - met.colours[i].w;
    }
    let ground = mix(params.top, params.bottom, clamp(at.y / params.height, 0.0, 1.0));
    let colour = sum + ground.xyz * left;
    return select(colour, mix(colour, shine.xyz, shine.w), shining > solid(&met));
}

@compute @workgroup_size(WORKGROUP)
fn volume_main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) number: u32) {
    let pixel = group.xy * 8u + vec2u(number % 8u, number / 8u);
    if pixel.x < params.columns && pixel.y < params.rows {
        let tile = pixel.y / TILE * params.tiles + pixel.x / TILE;
        let middle = vec2f(pixel) + 0.5;
        var sum = vec3f(0.0);
        for (var i = 0u; i < RAYS; i++) {
            sum += colour_at(middle + RAY[i], tile);
        }
        textureStore(picture, pixel, vec4f(sum / f32(RAYS), 1.0));
    }
}
