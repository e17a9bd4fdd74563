// The baffled circular piston at four points, by McGough's single integral with the midpoint rule; the formula is
// derived in `engine/src/acoustics/element.rs`. With h = (R - z)/λ half-turns its wave is e^{-jkz} e^{-jπh}, and its sinc is
// that of the same angle.

// cos ψ and 4 a sin²(ψ/2) at the nodes.
@group(0) @binding(5) var<uniform> nodes: array<vec4f, MOST_NODES>;

fn wave(x: vec4f, y: vec4f, z: vec4f, element: vec4f, tilt: vec4f) -> Phasor {
    let dx = x - element.x;
    let dy = y - element.y;
    let rho2 = dx * dx + dy * dy;
    let rho = sqrt(rho2);
    let r = sqrt(rho2 + z * z);
    let beyond = rho - params.radius;
    var sum = Phasor(vec4f(0.0), vec4f(0.0));
    for (var i = 0u; i < params.nodes; i++) {
        let node = nodes[i];
        let rim2 = rho * node.y + beyond * beyond;
        let inverse = 1.0 / (sqrt(rim2 + z * z) + z);
        // Small enough for a sinc of 1, large enough as a divisor.
        let h = max(rim2 * inverse * params.turns_per_metre, vec4f(1e-6));
        let turned = phasor(0.5 * h);
        let weight = (params.radius - rho * node.x) * inverse * turned.im / (PI * h);
        sum.re += weight * turned.re;
        sum.im -= weight * turned.im;
    }
    let amplitude = element.w * params.piston_scale * decay(r);
    let own = phasor(vec4f(element.z));
    return Phasor(amplitude * (own.re * sum.re - own.im * sum.im), amplitude * (own.re * sum.im + own.im * sum.re));
}
