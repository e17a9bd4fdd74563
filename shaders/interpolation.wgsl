// From samples to pixels along one axis: every pixel is a weighted sum of neighbouring samples. `across.wgsl` or
// `form.wgsl` processes the result.
//
// An invocation makes four neighbouring pixels of a line, or 16, from all samples that any of them needs, with weight
// 0 for the others. Each sample is then read once for all of them; neighbouring invocations make neighbouring lines.
// With a single part of the sound, an invocation may make them on four lines, a workgroup's width apart, and read
// each weight once: on software drivers reading dominates.

struct InterpolationParams {
    pixels: u32,
    lines: u32,
    // Samples required by a block of pixels.
    span: u32,
    // Offset from the weights of values to those of slopes.
    slopes: u32,
    // Strides of samples along the axis, of lines, and of parts of the sound.
    tap_stride: u32,
    line_stride: u32,
    part_stride: u32,
    first_pixel: u32,
    // Strides of pixels along the axis, and of lines.
    pixel_stride: u32,
    pixel_line_stride: u32,
}

@group(0) @binding(0) var<uniform> params: InterpolationParams;
@group(0) @binding(1) var<storage, read> samples: array<vec2f>;
// For every block its first sample, then the bits of a weight of every pixel for every sample. One buffer, since
// adapters may be limited to four per program.
@group(0) @binding(2) var<storage, read> weights: array<vec4u>;

// Of four pixels.
struct Four {
    re: vec4f,
    im: vec4f,
}

// A part of the sound at a block.
struct Sums {
    four0: Four,
    four1: Four,
    four2: Four,
    four3: Four,
}

// Weights of a sample for a block.
struct Weights {
    four0: vec4f,
    four1: vec4f,
    four2: vec4f,
    four3: vec4f,
}

fn weights_at(place: u32) -> Weights {
    let four0 = bitcast<vec4f>(weights[place]);
    if SIXTEEN_PIXELS {
        let four1 = bitcast<vec4f>(weights[place + 1u]);
        let four2 = bitcast<vec4f>(weights[place + 2u]);
        let four3 = bitcast<vec4f>(weights[place + 3u]);
        return Weights(four0, four1, four2, four3);
    }
    return Weights(four0, vec4f(0.0), vec4f(0.0), vec4f(0.0));
}

fn plus(sums: Sums, at: u32, w: Weights) -> Sums {
    let value = samples[at];
    return Sums(
        Four(sums.four0.re + w.four0 * value.x, sums.four0.im + w.four0 * value.y),
        Four(sums.four1.re + w.four1 * value.x, sums.four1.im + w.four1 * value.y),
        Four(sums.four2.re + w.four2 * value.x, sums.four2.im + w.four2 * value.y),
        Four(sums.four3.re + w.four3 * value.x, sums.four3.im + w.four3 * value.y),
    );
}

@compute @workgroup_size(WORKGROUP)
fn interpolation_main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) local: u32) {
    let line = group.x * (select(1u, 4u, FOUR_LINES) * WORKGROUP) + local;
    let fours = select(1u, 4u, SIXTEEN_PIXELS);
    var weight = group.y * (1u + params.span * fours);
    let start = weights[weight].x * params.tap_stride;
    weight++;
    // Beyond the end the last line is recomputed and not written.
    let last = params.lines - 1u;
    // Indices of the four parts, or of four lines.
    var p_at = start + min(line, last) * params.line_stride;
    var x_at = p_at + ALONG_X * params.part_stride;
    var y_at = p_at + ALONG_Y * params.part_stride;
    var n_at = p_at + NORMAL * params.part_stride;
    if FOUR_LINES {
        x_at = start + min(line + WORKGROUP, last) * params.line_stride;
        y_at = start + min(line + 2u * WORKGROUP, last) * params.line_stride;
        n_at = start + min(line + 3u * WORKGROUP, last) * params.line_stride;
    }
    let zero = Four(vec4f(0.0), vec4f(0.0));
    let nothing = Sums(zero, zero, zero, zero);
    var p = nothing;
    var x = nothing;
    var y = nothing;
    var n = nothing;
    // Not on uniforms alone, as in the field's.
    let span = params.span + group.z;
    for (var tap = 0u; tap < span; tap++) {
        let values = weights_at(weight);
        if FOUR_LINES || PRESSURE != NOWHERE {
            p = plus(p, p_at, values);
            p_at += params.tap_stride;
        }
        if FOUR_LINES || ALONG_X != NOWHERE {
            x = plus(x, x_at, values);
            x_at += params.tap_stride;
        }
        if FOUR_LINES {
            y = plus(y, y_at, values);
            y_at += params.tap_stride;
        } else if ALONG_Y != NOWHERE {
            y = plus(y, y_at, weights_at(weight + params.slopes));
            y_at += params.tap_stride;
        }
        if FOUR_LINES || NORMAL != NOWHERE {
            n = plus(n, n_at, values);
            n_at += params.tap_stride;
        }
        weight += fours;
    }
    let pixel = group.y * 4u * fours;
    if FOUR_LINES {
        put_alone(pixel, line, p);
        put_alone(pixel, line + WORKGROUP, x);
        put_alone(pixel, line + 2u * WORKGROUP, y);
        put_alone(pixel, line + 3u * WORKGROUP, n);
    } else {
        put_block(pixel, line, p, x, y, n);
    }
}

// A block with a single part of the sound.
fn put_alone(pixel: u32, line: u32, sums: Sums) {
    put_block(pixel, line, sums, sums, sums, sums);
}

fn put_block(pixel: u32, line: u32, p: Sums, x: Sums, y: Sums, n: Sums) {
    if line >= params.lines {
        return;
    }
    var largest = put_four(pixel, line, p.four0, x.four0, y.four0, n.four0);
    if SIXTEEN_PIXELS {
        largest = max(largest, put_four(pixel + 4u, line, p.four1, x.four1, y.four1, n.four1));
        largest = max(largest, put_four(pixel + 8u, line, p.four2, x.four2, y.four2, n.four2));
        largest = max(largest, put_four(pixel + 12u, line, p.four3, x.four3, y.four3, n.four3));
    }
    // Interpolated pixels are farther than a wavelength from all elements.
    finish(largest, 0u);
}

fn put_four(pixel: u32, line: u32, p: Four, x: Four, y: Four, n: Four) -> f32 {
    var largest = 0.0;
    for (var i = 0u; i < 4u; i++) {
        if pixel + i < params.pixels {
            let at = params.first_pixel + (pixel + i) * params.pixel_stride + line * params.pixel_line_stride;
            let sound = Sound(
                vec2f(p.re[i], p.im[i]),
                vec2f(x.re[i], x.im[i]),
                vec2f(y.re[i], y.im[i]),
                vec2f(n.re[i], n.im[i]),
            );
            largest = max(largest, put(at, sound));
        }
    }
    return largest;
}
