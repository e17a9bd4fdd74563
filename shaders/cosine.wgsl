// The far field of one element with a complex directivity in cosθ, at four points: S D(θ)/r e^{-αr} e^{j(φ - k(r - z))}.
// The phase holds the transfer's j.

fn wave(x: vec4f, y: vec4f, z: vec4f, element: vec4f, tilt: vec4f) -> Phasor {
    let dx = x - element.x;
    let dy = y - element.y;
    let rho2 = dx * dx + dy * dy;
    let r = sqrt(rho2 + z * z);
    let path = r + z;
    // One division for the two that are needed.
    let both = 1.0 / (r * path);
    let inverse = path * both;
    let amplitude = element.w * inverse * decay(r);
    let shape = complex_directivity(2.0 * z * inverse - 1.0);
    let wave = phasor(element.z - rho2 * (r * both) * params.turns_per_metre);
    let re = shape.re * wave.re - shape.im * wave.im;
    let im = shape.re * wave.im + shape.im * wave.re;
    return Phasor(amplitude * re, amplitude * im);
}
