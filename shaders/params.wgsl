// Parameters of one run of the field besides its buffers. `engine/src/field/gpu/program.rs` holds the same struct; a test
// compares the two.

struct Params {
    // Coefficients of the directivity's two polynomials, such as 2 J1(x)/x in 2 sin²θ - 1, and of e^{-α(r - near)} in a
    // distance scaled to [-1, 1], lowest first.
    directivity: array<vec4f, 6>,
    second: array<vec4f, 6>,
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

fn second(s: vec4f) -> vec4f {
    var sum = vec4f(0.0);
    if MANY_TERMS {
        for (var i = 5u; i > 1u; i--) {
            sum = four_terms(sum, s, params.second[i]);
        }
    }
    sum = four_terms(sum, s, params.second[1]);
    return four_terms(sum, s, params.second[0]);
}

// A directivity by its real and imaginary part, sums of Chebyshev polynomials in s = 2 cosθ - 1, by Clenshaw's rule.
fn complex_directivity(s: vec4f) -> Phasor {
    let twice = 2.0 * s;
    var re = array<vec4f, 2>(vec4f(0.0), vec4f(0.0));
    var im = array<vec4f, 2>(vec4f(0.0), vec4f(0.0));
    if MANY_TERMS {
        for (var i = 5u; i > 1u; i--) {
            re = four_chebyshev(re, twice, params.directivity[i]);
            im = four_chebyshev(im, twice, params.second[i]);
        }
    }
    re = four_chebyshev(re, twice, params.directivity[1]);
    im = four_chebyshev(im, twice, params.second[1]);
    // The last step is half a step: c0 + s b1 - b2.
    re = four_chebyshev(re, twice, params.directivity[0]);
    im = four_chebyshev(im, twice, params.second[0]);
    return Phasor(re[0] - s * re[1], im[0] - s * im[1]);
}

// Four steps of Clenshaw's rule on the latest sum and the one before.
fn four_chebyshev(sums: array<vec4f, 2>, twice: vec4f, c: vec4f) -> array<vec4f, 2> {
    let b3 = twice * sums[0] + (c.w - sums[1]);
    let b2 = twice * b3 + (c.z - sums[0]);
    let b1 = twice * b2 + (c.y - b3);
    let b0 = twice * b1 + (c.x - b2);
    return array<vec4f, 2>(b0, b1);
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
