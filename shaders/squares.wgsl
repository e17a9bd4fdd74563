// Squares of the pressure at cells: adds one drive's share of the mean |p|² and of the mean radiation pressure.

struct SquaresParams {
    count: u32,
    invocations: u32,
    // What |p|² and |∇p|² give to the radiation pressure.
    of_pressure: f32,
    of_gradient: f32,
    // One over the number of drives.
    share: f32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> params: SquaresParams;
@group(0) @binding(1) var<storage, read> pressure: array<vec2f>;
// Its slopes along the plane's axes.
@group(0) @binding(2) var<storage, read> along_x: array<vec2f>;
@group(0) @binding(3) var<storage, read> along_y: array<vec2f>;
// Mean |p|² and radiation pressure.
@group(0) @binding(4) var<storage, read_write> squares: array<vec2f>;

@compute @workgroup_size(WORKGROUP)
fn squares_main(@builtin(global_invocation_id) id: vec3u) {
    for (var i = id.x; i < params.count; i += params.invocations) {
        let square = dot(pressure[i], pressure[i]);
        let gradient = dot(along_x[i], along_x[i]) + dot(along_y[i], along_y[i]);
        let radiation = params.of_pressure * square - params.of_gradient * gradient;
        squares[i] += params.share * vec2f(square, radiation);
    }
}
