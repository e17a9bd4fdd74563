// Complex pressure (Pa, peak) at samples from a table of transfer values, added to what is there.
//
// Sample i is `i % line` on line `i / line`. Every invocation takes eight samples, a workgroup's width apart, so that an
// element's excitation is read once for eight of them.

struct SuperpositionParams {
    samples: u32,
    line: u32,
    line_stride: u32,
    first_term: u32,
    last_term: u32,
}

@group(0) @binding(0) var<uniform> params: SuperpositionParams;
@group(0) @binding(1) var<storage, read> table: array<vec2f>;
// Where an element's run for the first line starts, and the bits of the real and imaginary parts of its excitation.
@group(0) @binding(2) var<storage, read> terms: array<vec4u>;
@group(0) @binding(3) var<storage, read_write> pressure: array<vec2f>;

// Where a sample stands in a run that starts at 0.
fn place(sample: u32) -> u32 {
    // Beyond the end the last sample is computed again and not written.
    let i = min(sample, params.samples - 1u);
    return i / params.line * params.line_stride + i % params.line;
}

fn write(sample: u32, value: vec2f) {
    if sample < params.samples {
        pressure[sample] += value;
    }
}

@compute @workgroup_size(WORKGROUP)
fn superposition_main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) local: u32) {
    let start = group.x * (8u * WORKGROUP) + local;
    let p0 = place(start);
    let p1 = place(start + WORKGROUP);
    let p2 = place(start + 2u * WORKGROUP);
    let p3 = place(start + 3u * WORKGROUP);
    let p4 = place(start + 4u * WORKGROUP);
    let p5 = place(start + 5u * WORKGROUP);
    let p6 = place(start + 6u * WORKGROUP);
    let p7 = place(start + 7u * WORKGROUP);
    var re_low = vec4f(0.0);
    var im_low = vec4f(0.0);
    var re_high = vec4f(0.0);
    var im_high = vec4f(0.0);
    for (var n = params.first_term; n < params.last_term; n++) {
        let term = terms[n];
        let re = bitcast<f32>(term.y);
        let im = bitcast<f32>(term.z);
        let h0 = table[term.x + p0];
        let h1 = table[term.x + p1];
        let h2 = table[term.x + p2];
        let h3 = table[term.x + p3];
        let h4 = table[term.x + p4];
        let h5 = table[term.x + p5];
        let h6 = table[term.x + p6];
        let h7 = table[term.x + p7];
        let h_re_low = vec4f(h0.x, h1.x, h2.x, h3.x);
        let h_im_low = vec4f(h0.y, h1.y, h2.y, h3.y);
        let h_re_high = vec4f(h4.x, h5.x, h6.x, h7.x);
        let h_im_high = vec4f(h4.y, h5.y, h6.y, h7.y);
        re_low += h_re_low * re - h_im_low * im;
        im_low += h_re_low * im + h_im_low * re;
        re_high += h_re_high * re - h_im_high * im;
        im_high += h_re_high * im + h_im_high * re;
    }
    for (var i = 0u; i < 4u; i++) {
        write(start + i * WORKGROUP, vec2f(re_low[i], im_low[i]));
        write(start + (i + 4u) * WORKGROUP, vec2f(re_high[i], im_high[i]));
    }
}
