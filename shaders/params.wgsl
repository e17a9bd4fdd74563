// Parameters of one run of the field besides its buffers. `engine/src/field/gpu/program.rs` holds the same struct; a test
// compares the two.

struct Params {
    // Coefficients of 2 J1(x)/x in 2 sin²θ - 1, and of e^{-α(r - near)} in a distance scaled to
    // [-1, 1], lowest first.
    directivity: array<vec4f, 6>,
    decay: array<vec4f, 4>,
    decay_scale: vec2f,
    turns_per_metre: f32,
    // The run adds the elements first_element .. last_element to the samples' existing values.
    first_element: u32,
    last_element: u32,
    columns: u32,
    // The run computes samples first .. first + count.
    first: u32,
    count: u32,
    nodes: u32,
    radius: f32,
    piston_scale: f32,
    // Factor on the added values.
    gain: f32,
}

@group(0) @binding(0) var<uniform> params: Params;

fn directivity(s: vec4f) -> vec4f {
    var sum = vec4f(0.0);
    if MANY_TERMS {
        for (var i = 5u; i > 1u; i--) {
            sum = four_terms(sum, s, params.directivity[i]);
        }
    }
    sum = four_terms(sum, s, params.directivity[1]);
    return four_terms(sum, s, params.directivity[0]);
}

fn decay(distance: vec4f) -> vec4f {
    let s = distance * params.decay_scale.x + params.decay_scale.y;
    var sum = vec4f(0.0);
    if MANY_TERMS {
        for (var i = 3u; i > 0u; i--) {
            sum = four_terms(sum, s, params.decay[i]);
        }
    }
    return four_terms(sum, s, params.decay[0]);
}

// Four steps of Horner's rule.
fn four_terms(sum: vec4f, s: vec4f, coefficients: vec4f) -> vec4f {
    return (((sum * s + coefficients.w) * s + coefficients.z) * s + coefficients.y) * s + coefficients.x;
}
