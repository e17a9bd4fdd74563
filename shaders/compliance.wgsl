// From the modes of a pressure to those of the dent under it: 1/(ρ g + σ q²) of each.

struct ComplianceParams {
    count: u32,
    invocations: u32,
    // Modes in a row.
    columns: u32,
    // ρ g
    weight: f32,
    // σ
    tension: f32,
    padding: u32,
    // q of the first mode along each axis; that of the others is a multiple.
    wavenumber: vec2f,
}

@group(0) @binding(0) var<uniform> params: ComplianceParams;
// Of |p|² and of the radiation pressure.
@group(0) @binding(1) var<storage, read> modes: array<vec2f>;
// Of the depth, and nothing.
@group(0) @binding(2) var<storage, read_write> dent: array<vec2f>;

@compute @workgroup_size(WORKGROUP)
fn compliance_main(@builtin(global_invocation_id) id: vec3u) {
    for (var i = id.x; i < params.count; i += params.invocations) {
        let q = params.wavenumber * vec2f(vec2u(i % params.columns, i / params.columns));
        dent[i] = vec2f(modes[i].y / (params.weight + params.tension * dot(q, q)), 0.0);
    }
}
