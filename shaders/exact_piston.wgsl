// The baffled circular piston at four points, by McGough's single integral with the midpoint rule; the formula is
// derived in `src/acoustics/element.rs`.

// cos ψ and 4 a sin²(ψ/2) at the nodes.
@group(0) @binding(5) var<uniform> nodes: array<vec4f, MOST_NODES>;

fn wave(x: vec4f, y: vec4f, z: vec4f, element: vec4f) -> Phasor {
    let dx = x - element.x;
    let dy = y - element.y;
    let rho2 = dx * dx + dy * dy;
    let rho = sqrt(rho2);
    let r = sqrt(max(rho2 + z * z, vec4f(NEAREST * NEAREST)));
    let beyond = rho - params.radius;
    var sum = Phasor(vec4f(0.0), vec4f(0.0));
    for (var i = 0u; i < params.nodes; i++) {
        let node = nodes[i];
        let rim2 = rho * node.y + beyond * beyond;
        let path = sqrt(rim2 + z * z) + z;
        let wave = phasor(element.z - turns_along(0.5 * path));
        let weight = (params.radius - rho * node.x) / path * sinc(rim2 / path * params.turns_per_metre.x);
        sum.re += weight * wave.re;
        sum.im += weight * wave.im;
    }
    let amplitude = element.w * params.piston_scale * decay(r);
    return Phasor(amplitude * sum.re, amplitude * sum.im);
}

// sin(πh)/(πh), h ≥ 0; below 1e-6 it is 1 to f32.
fn sinc(half_turns: vec4f) -> vec4f {
    let h = max(half_turns, vec4f(1e-6));
    return phasor(0.5 * h).im / (PI * h);
}
