// The far field of one element of a curved board at four points: S D(θ)/r e^{-αr} e^{j(φ - k(r - |z|))}. The second
// vector holds the element's height above the board's own plane and its direction of radiation.

fn wave(x: vec4f, y: vec4f, z: vec4f, element: vec4f, tilt: vec4f) -> Phasor {
    let dx = x - element.x;
    let dy = y - element.y;
    let dz = z - tilt.x;
    let rho2 = dx * dx + dy * dy;
    let r = max(sqrt(rho2 + dz * dz), vec4f(NEAREST));
    let path = r + abs(z);
    // r² - z²
    let beyond2 = rho2 + tilt.x * (tilt.x - 2.0 * z);
    // One division for the two that are needed.
    let both = 1.0 / (r * path);
    let inverse = path * both;
    let ahead = dx * tilt.y + dy * tilt.z + dz * tilt.w;
    let cosine = ahead * inverse;
    let amplitude = select(vec4f(0.0), element.w * inverse * directivity(1.0 - 2.0 * cosine * cosine) * decay(r), ahead >= vec4f(-NEAREST));
    let wave = phasor(element.z - beyond2 * (r * both) * params.turns_per_metre);
    return Phasor(amplitude * wave.re, amplitude * wave.im);
}
