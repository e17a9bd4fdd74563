// The RMS value of a mean square of peak pressures, which an average holds first.

fn shown(p: vec2f) -> f32 {
    return sqrt(max(p.x, 0.0) * 0.5);
}
