// From samples to pixels along one axis: every pixel is a weighted sum of neighbouring samples.
//
// Eight neighbouring pixels are made from the samples that any of them needs, with weight 0 for the others: when many
// pixels lie between two samples, each sample is then read once for eight of them.

struct ResampleParams {
    pixels: u32,
    lines: u32,
    // Of the first sample.
    start: u32,
    // Samples that eight pixels need.
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
// The first sample of every eight pixels.
@group(0) @binding(2) var<storage, read> first: array<u32>;
// Eight weights for every sample of every eight pixels.
@group(0) @binding(3) var<storage, read> weights: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> interpolated: array<vec2f>;

@compute @workgroup_size(WORKGROUP)
fn resample_main(@builtin(global_invocation_id) id: vec3u, @builtin(workgroup_id) group: vec3u) {
    let line = id.x;
    if line >= params.lines {
        return;
    }
    var at = params.start + first[group.y] * params.tap_stride + line * params.line_stride;
    var weight = group.y * params.span * 2u;
    var re_low = vec4f(0.0);
    var im_low = vec4f(0.0);
    var re_high = vec4f(0.0);
    var im_high = vec4f(0.0);
    for (var tap = 0u; tap < params.span; tap++) {
        let value = samples[at];
        let low = weights[weight];
        let high = weights[weight + 1u];
        re_low += low * value.x;
        im_low += low * value.y;
        re_high += high * value.x;
        im_high += high * value.y;
        at += params.tap_stride;
        weight += 2u;
    }
    for (var i = 0u; i < 4u; i++) {
        write(group.y * 8u + i, line, vec2f(re_low[i], im_low[i]));
        write(group.y * 8u + 4u + i, line, vec2f(re_high[i], im_high[i]));
    }
}

fn write(pixel: u32, line: u32, value: vec2f) {
    if pixel < params.pixels {
        interpolated[pixel * params.pixel_stride + line * params.pixel_line_stride] = value;
    }
}
