// The same as `curved.wgsl` with a complex directivity in cosθ.

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
    // A D in cosθ, other than one in its square, shows that heights are clamped.
    let cosine = max(ahead, vec4f(NEAREST)) * inverse;
    let amplitude = select(vec4f(0.0), element.w * inverse * decay(r), ahead >= vec4f(-NEAREST));
    let shape = complex_directivity(2.0 * cosine - 1.0);
    let wave = phasor(element.z - beyond2 * (r * both) * params.turns_per_metre);
    let re = shape.re * wave.re - shape.im * wave.im;
    let im = shape.re * wave.im + shape.im * wave.re;
    return Phasor(amplitude * re, amplitude * im);
}
