// Sound (Pa, peak) that the sources of a surface emit to many points, added to the existing values:
// -s e^{-jπr}/r (n·d (1 + jπr)/r² + jπβ), with all lengths in half turns, and no distance below `least`.
//
// A source has two vectors: place and real part of its strength, normal and imaginary part. Every invocation computes
// four or eight points, LANES apart, as in `field.wgsl`, and SLICES invocations divide the sources. CPU twin:
// `engine/src/scatter/emission.rs`.

struct EmissionParams {
    // The run adds the sources first_source .. last_source to the points first .. first + count.
    first_source: u32,
    last_source: u32,
    first: u32,
    count: u32,
    // πβ
    leak: f32,
    least: f32,
}

@group(0) @binding(0) var<uniform> params: EmissionParams;
@group(0) @binding(1) var<storage, read> sources: array<vec4f>;
@group(0) @binding(2) var<storage, read> points: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> pressure: array<vec2f>;

struct Four {
    x: vec4f,
    y: vec4f,
    z: vec4f,
}

// Beyond the end the last point is computed again and not written.
fn point(offset: u32) -> vec3f {
    return points[params.first + min(offset, params.count - 1u)].xyz;
}

fn four(offset: u32) -> Four {
    let a = point(offset);
    let b = point(offset + LANES);
    let c = point(offset + 2u * LANES);
    let d = point(offset + 3u * LANES);
    return Four(vec4f(a.x, b.x, c.x, d.x), vec4f(a.y, b.y, c.y, d.y), vec4f(a.z, b.z, c.z, d.z));
}

fn heard(at: Four, place: vec4f, normal: vec4f) -> Phasor {
    let dx = place.x - at.x;
    let dy = place.y - at.y;
    let dz = place.z - at.z;
    let r = sqrt(max(dx * dx + dy * dy + dz * dz, vec4f(params.least * params.least)));
    let inverse = 1.0 / r;
    let along = (dx * normal.x + dy * normal.y + dz * normal.z) * inverse;
    let onward = phasor(-0.5 * r);
    let a = -along * inverse * inverse;
    let b = -(along * PI + params.leak) * inverse;
    let re = a * onward.re - b * onward.im;
    let im = a * onward.im + b * onward.re;
    return Phasor(place.w * re - normal.w * im, place.w * im + normal.w * re);
}

fn write(offset: u32, sum: Phasor) {
    for (var i = 0u; i < 4u; i++) {
        let at = offset + i * LANES;
        if at < params.count {
            pressure[params.first + at] += vec2f(sum.re[i], sum.im[i]);
        }
    }
}

@compute @workgroup_size(LANES, SLICES)
fn emission_main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let start = group.x * (select(4u, 8u, EIGHT_SAMPLES) * LANES) + local.x;
    let low_at = four(start);
    var high_at = low_at;
    if EIGHT_SAMPLES {
        high_at = four(start + 4u * LANES);
    }
    var low = Phasor(vec4f(0.0), vec4f(0.0));
    var high = Phasor(vec4f(0.0), vec4f(0.0));
    // group.z is 0: no loop may end by uniforms alone.
    let last_source = params.last_source + group.z;
    for (var n = params.first_source + local.y; n < last_source; n += SLICES) {
        let place = sources[2u * n];
        let normal = sources[2u * n + 1u];
        let to_low = heard(low_at, place, normal);
        low.re += to_low.re;
        low.im += to_low.im;
        if EIGHT_SAMPLES {
            let to_high = heard(high_at, place, normal);
            high.re += to_high.re;
            high.im += to_high.im;
        }
    }
    low = over_slices(low, local);
    if EIGHT_SAMPLES {
        high = over_slices(high, local);
    }
    if local.y > 0u {
        return;
    }
    write(start, low);
    if EIGHT_SAMPLES {
        write(start + 4u * LANES, high);
    }
}
