// From values to colours: one number of each, scaled, looked up in a table of 256 colours.

@group(0) @binding(1) var<storage, read> pressure: array<vec2f>;
@group(0) @binding(2) var<storage, read> colours: array<u32, 256>;
@group(0) @binding(3) var<storage, read_write> picture: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn picture_main(@builtin(global_invocation_id) id: vec3u) {
    for (var i = id.x; i < params.count; i += params.invocations) {
        picture[i] = colours[colour_index(pressure[i])];
    }
}
