// From samples to pixels along one axis: every pixel is a weighted sum of neighbouring samples.
//
// An invocation makes 16 neighbouring pixels on each of 4 lines, a workgroup's width apart, from the samples that any of them
// needs, with weight 0 for the others. A sample is then read once for 16 pixels, and a weight for 4 lines: on software drivers
// reading is what takes the time.

struct ResampleParams {
    pixels: u32,
    lines: u32,
    // Of the first sample and the first pixel.
    start: u32,
    out_start: u32,
    // Samples that 16 pixels need.
    span: u32,
    // From one sample to the next along the axis, and from one line to the next.
    tap_stride: u32,
    line_stride: u32,
    // The same for the pixels.
    pixel_stride: u32,
    pixel_line_stride: u32,
}

@group(0) @binding(0) var<uniform> params: ResampleParams;
@group(0) @binding(1) var<storage, read> samples: array<vec2f>;
// Of every 16 pixels their first sample, and then the bits of 16 weights for every sample. One buffer, since adapters need not have
// more than four in a program.
@group(0) @binding(2) var<storage, read> weights: array<vec4u>;
@group(0) @binding(3) var<storage, read_write> interpolated: array<vec2f>;

// 16 pixels of one line.
struct Sums {
    re0: vec4f,
    im0: vec4f,
    re1: vec4f,
    im1: vec4f,
    re2: vec4f,
    im2: vec4f,
    re3: vec4f,
    im3: vec4f,
}

fn plus(sums: Sums, value: vec2f, w0: vec4f, w1: vec4f, w2: vec4f, w3: vec4f) -> Sums {
    return Sums(
        sums.re0 + w0 * value.x,
        sums.im0 + w0 * value.y,
        sums.re1 + w1 * value.x,
        sums.im1 + w1 * value.y,
        sums.re2 + w2 * value.x,
        sums.im2 + w2 * value.y,
        sums.re3 + w3 * value.x,
        sums.im3 + w3 * value.y,
    );
}

@compute @workgroup_size(WORKGROUP)
fn resample_main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) local: u32) {
    let line = group.x * (4u * WORKGROUP) + local;
    // Beyond the end the last line is made again and not written.
    let last = params.lines - 1u;
    var weight = group.y * (1u + params.span * 4u);
    let start = params.start + weights[weight].x * params.tap_stride;
    weight++;
    var at0 = start + min(line, last) * params.line_stride;
    var at1 = start + min(line + WORKGROUP, last) * params.line_stride;
    var at2 = start + min(line + 2u * WORKGROUP, last) * params.line_stride;
    var at3 = start + min(line + 3u * WORKGROUP, last) * params.line_stride;
    var sums0 = Sums(vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0));
    var sums1 = Sums(vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0));
    var sums2 = Sums(vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0));
    var sums3 = Sums(vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0), vec4f(0.0));
    // Not of uniforms alone, as in the field's.
    let span = params.span + group.z;
    for (var tap = 0u; tap < span; tap++) {
        let w0 = bitcast<vec4f>(weights[weight]);
        let w1 = bitcast<vec4f>(weights[weight + 1u]);
        let w2 = bitcast<vec4f>(weights[weight + 2u]);
        let w3 = bitcast<vec4f>(weights[weight + 3u]);
        sums0 = plus(sums0, samples[at0], w0, w1, w2, w3);
        at0 += params.tap_stride;
        sums1 = plus(sums1, samples[at1], w0, w1, w2, w3);
        at1 += params.tap_stride;
        sums2 = plus(sums2, samples[at2], w0, w1, w2, w3);
        at2 += params.tap_stride;
        sums3 = plus(sums3, samples[at3], w0, w1, w2, w3);
        at3 += params.tap_stride;
        weight += 4u;
    }
    let pixel = group.y * 16u;
    finish(pixel, line, sums0);
    finish(pixel, line + 1u * WORKGROUP, sums1);
    finish(pixel, line + 2u * WORKGROUP, sums2);
    finish(pixel, line + 3u * WORKGROUP, sums3);
}

// Writes the pixels of a line.
fn finish(pixel: u32, line: u32, sums: Sums) {
    if line < params.lines {
        write(pixel + 0u, line, sums.re0, sums.im0);
        write(pixel + 4u, line, sums.re1, sums.im1);
        write(pixel + 8u, line, sums.re2, sums.im2);
        write(pixel + 12u, line, sums.re3, sums.im3);
    }
}

fn write(pixel: u32, line: u32, re: vec4f, im: vec4f) {
    for (var i = 0u; i < 4u; i++) {
        if pixel + i < params.pixels {
            let at = params.out_start + (pixel + i) * params.pixel_stride + line * params.pixel_line_stride;
            interpolated[at] = vec2f(re[i], im[i]);
        }
    }
}
