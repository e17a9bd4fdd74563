// The far field of one rectangle at four points: S D/r e^{-αr} e^{j(φ - k(r - z))}, D a sinc of x/r times one of y/r. The
// phase holds the transfer's j.

fn wave(x: vec4f, y: vec4f, z: vec4f, element: vec4f, tilt: vec4f) -> Phasor {
    let dx = x - element.x;
    let dy = y - element.y;
    let rho2 = dx * dx + dy * dy;
    let r = sqrt(rho2 + z * z);
    let path = r + z;
    // One division for the two that are needed.
    let both = 1.0 / (r * path);
    let inverse = path * both;
    let along = dx * inverse;
    let across = dy * inverse;
    let shape = directivity(2.0 * along * along - 1.0) * second(2.0 * across * across - 1.0);
    let amplitude = element.w * inverse * shape * decay(r);
    let wave = phasor(element.z - rho2 * (r * both) * params.turns_per_metre);
    return Phasor(amplitude * wave.re, amplitude * wave.im);
}
