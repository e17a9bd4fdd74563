// From samples to pixels along one axis: every pixel is a weighted sum of `taps` neighbouring samples.

struct ResampleParams {
    // Pixels along the axis, and lines across it.
    pixels: u32,
    lines: u32,
    taps: u32,
    // From one sample to the next along the axis, and from one line to the next.
    tap_stride: u32,
    line_stride: u32,
    // 1 where the pixels of a line are neighbours in the output, 0 where the lines are.
    across: u32,
    invocations: u32,
}

@group(0) @binding(0) var<uniform> params: ResampleParams;
@group(0) @binding(1) var<storage, read> samples: array<vec2f>;
@group(0) @binding(2) var<storage, read> first: array<u32>;
@group(0) @binding(3) var<storage, read> weights: array<f32>;
@group(0) @binding(4) var<storage, read_write> interpolated: array<vec2f>;

@compute @workgroup_size(WORKGROUP)
fn resample_main(@builtin(global_invocation_id) id: vec3u) {
    let count = params.pixels * params.lines;
    for (var i = id.x; i < count; i += params.invocations) {
        var pixel = i / params.lines;
        var line = i % params.lines;
        if params.across == 1u {
            pixel = i % params.pixels;
            line = i / params.pixels;
        }
        var at = first[pixel] * params.tap_stride + line * params.line_stride;
        var weight = pixel * params.taps;
        var sum = vec2f(0.0);
        for (var tap = 0u; tap < params.taps; tap++) {
            sum += weights[weight] * samples[at];
            at += params.tap_stride;
            weight++;
        }
        interpolated[i] = sum;
    }
}
