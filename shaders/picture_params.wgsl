// What the picture's programs need besides their buffers.

struct PictureParams {
    count: u32,
    invocations: u32,
    // e^(jωt) of an instantaneous pressure.
    turn: vec2f,
    // The number that gets the last colour.
    full: f32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> params: PictureParams;
