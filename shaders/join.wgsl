// What pixels are interpolated from: a dent or a mean square, and beside it the radiation pressure.

struct JoinParams {
    count: u32,
    invocations: u32,
    // Factors on both.
    of_shape: f32,
    of_radiation: f32,
}

@group(0) @binding(0) var<uniform> params: JoinParams;
@group(0) @binding(1) var<storage, read> shape: array<vec2f>;
@group(0) @binding(2) var<storage, read> squares: array<vec2f>;
@group(0) @binding(3) var<storage, read_write> joined: array<vec2f>;

@compute @workgroup_size(WORKGROUP)
fn join_main(@builtin(global_invocation_id) id: vec3u) {
    for (var i = id.x; i < params.count; i += params.invocations) {
        joined[i] = vec2f(params.of_shape * shape[i].x, params.of_radiation * squares[i].y);
    }
}
