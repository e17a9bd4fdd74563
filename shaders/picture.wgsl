// From complex pressure to colour: one quantity, scaled, looked up in a table of 256 colours.

struct PictureParams {
    count: u32,
    invocations: u32,
    quantity: u32,
    // |p| that gets the last colour.
    full: f32,
}

const QUANTITY_PHASE: u32 = 1u;

@group(0) @binding(0) var<uniform> params: PictureParams;
@group(0) @binding(1) var<storage, read> pressure: array<vec2f>;
@group(0) @binding(2) var<storage, read> colours: array<u32, 256>;
@group(0) @binding(3) var<storage, read_write> picture: array<u32>;

fn colour_index(p: vec2f) -> u32 {
    if params.quantity == QUANTITY_PHASE {
        // A cyclic map: every colour has the same share of a turn.
        return min(u32((atan2(p.y, p.x) / (2.0 * PI) + 0.5) * 256.0), 255u);
    }
    return u32(clamp(length(p) / max(params.full, 1e-30), 0.0, 1.0) * 255.0 + 0.5);
}

@compute @workgroup_size(WORKGROUP)
fn picture_main(@builtin(global_invocation_id) id: vec3u) {
    for (var i = id.x; i < params.count; i += params.invocations) {
        picture[i] = colours[colour_index(pressure[i])];
    }
}
