// Complex pressure (Pa, peak) at many points by direct summation over the elements, added to the existing values.
//
// Sample i is at columns[i % width] + rows[i / width]; the fourth component is the fraction of a turn of its height
// above the array, which is common to all elements and applied last. Every invocation computes four or eight samples,
// LANES apart: each element is then read once for all of them, which gains a factor of four on software drivers. A
// map has too few samples to fill a hardware GPU, so there SLICES invocations divide the elements.

@group(0) @binding(2) var<storage, read> columns: array<vec4f>;
@group(0) @binding(3) var<storage, read> rows: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> pressure: array<vec2f>;

fn sample(offset: u32) -> vec4f {
    // Beyond the end the last sample is recomputed and not written.
    let index = params.first + min(offset, params.count - 1u);
    return columns[index % params.columns] + rows[index / params.columns];
}

// Four sums, rotated by the common phase and added to the existing values.
fn write(offset: u32, z: vec4f, turns: vec4f, sum: Phasor) {
    let nearest = vec4f(-NEAREST * params.turns_per_metre);
    // The array has a baffle: nothing is radiated backwards. On a curved board every element checks this itself, and
    // the path is |z|.
    var way = select(turns, -turns, z >= vec4f(0.0));
    var in_front = vec4f(params.gain);
    if IS_FLAT {
        way = select(-turns, nearest, z < vec4f(NEAREST));
        in_front = select(vec4f(0.0), in_front, z >= vec4f(-NEAREST));
    }
    let onward = phasor(way);
    let re = in_front * (sum.re * onward.re - sum.im * onward.im);
    let im = in_front * (sum.re * onward.im + sum.im * onward.re);
    for (var i = 0u; i < 4u; i++) {
        let at = offset + i * LANES;
        if at < params.count {
            pressure[params.first + at] += vec2f(re[i], im[i]);
        }
    }
}

@compute @workgroup_size(LANES, SLICES)
fn field_main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let start = group.x * (select(4u, 8u, EIGHT_SAMPLES) * LANES) + local.x;
    let p0 = sample(start);
    let p1 = sample(start + LANES);
    let p2 = sample(start + 2u * LANES);
    let p3 = sample(start + 3u * LANES);
    let x_low = vec4f(p0.x, p1.x, p2.x, p3.x);
    let y_low = vec4f(p0.y, p1.y, p2.y, p3.y);
    let z_low = vec4f(p0.z, p1.z, p2.z, p3.z);
    let front_low = select(z_low, max(z_low, vec4f(NEAREST)), vec4<bool>(IS_FLAT));
    var x_high = vec4f(0.0);
    var y_high = vec4f(0.0);
    var z_high = vec4f(0.0);
    var turns_high = vec4f(0.0);
    if EIGHT_SAMPLES {
        let p4 = sample(start + 4u * LANES);
        let p5 = sample(start + 5u * LANES);
        let p6 = sample(start + 6u * LANES);
        let p7 = sample(start + 7u * LANES);
        x_high = vec4f(p4.x, p5.x, p6.x, p7.x);
        y_high = vec4f(p4.y, p5.y, p6.y, p7.y);
        z_high = vec4f(p4.z, p5.z, p6.z, p7.z);
        turns_high = vec4f(p4.w, p5.w, p6.w, p7.w);
    }
    let front_high = select(z_high, max(z_high, vec4f(NEAREST)), vec4<bool>(IS_FLAT));

    var low = Phasor(vec4f(0.0), vec4f(0.0));
    var high = Phasor(vec4f(0.0), vec4f(0.0));
    // group.z is 0. lavapipe specialises on loops that end by uniforms alone at every dispatch, and leaks the
    // variants.
    let last_element = params.last_element + group.z;
    for (var n = params.first_element + local.y; n < last_element; n += SLICES) {
        let element = elements[n * VECTORS];
        let tilt = elements[n * VECTORS + VECTORS - 1u];
        let to_low = wave(x_low, y_low, front_low, element, tilt);
        low.re += to_low.re;
        low.im += to_low.im;
        if EIGHT_SAMPLES {
            let to_high = wave(x_high, y_high, front_high, element, tilt);
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
    write(start, z_low, vec4f(p0.w, p1.w, p2.w, p3.w), low);
    if EIGHT_SAMPLES {
        write(start + 4u * LANES, z_high, turns_high, high);
    }
}
