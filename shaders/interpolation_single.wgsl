// From samples to pixels along one axis, a pixel for every invocation: what suits adapters with many invocations at once.
//
// Neighbouring invocations take neighbours in memory, pixels of a line or lines of a pixel, so that their reads join.

struct SingleParams {
    // Along x and y of the dispatch.
    across: u32,
    up: u32,
    // 1 if pixels run along x, 0 if lines do.
    pixels_run_along_x: u32,
    pixels: u32,
    taps: u32,
    // Of the first sample and the first pixel.
    start: u32,
    out_start: u32,
    // From one sample to the next along the axis, and from one line to the next.
    tap_stride: u32,
    line_stride: u32,
    // The same for the pixels.
    pixel_stride: u32,
    pixel_line_stride: u32,
}

@group(0) @binding(0) var<uniform> params: SingleParams;
@group(0) @binding(1) var<storage, read> samples: array<vec2f>;
// The first sample of every pixel, and then the bits of all first weights, all second ones, and so on.
@group(0) @binding(2) var<storage, read> weights: array<u32>;
@group(0) @binding(3) var<storage, read_write> interpolated: array<vec2f>;

@compute @workgroup_size(WORKGROUP)
fn resample_main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= params.across || id.y >= params.up {
        return;
    }
    let pixel = select(id.y, id.x, params.pixels_run_along_x == 1u);
    let line = select(id.x, id.y, params.pixels_run_along_x == 1u);
    var at = params.start + weights[pixel] * params.tap_stride + line * params.line_stride;
    var sum = vec2f(0.0);
    // group.z is 0; see the field's loop.
    let taps = params.taps + id.z;
    for (var tap = 1u; tap <= taps; tap++) {
        sum += bitcast<f32>(weights[tap * params.pixels + pixel]) * samples[at];
        at += params.tap_stride;
    }
    interpolated[params.out_start + pixel * params.pixel_stride + line * params.pixel_line_stride] = sum;
}
