// Radiation pressure, which an average holds second.

fn shown(p: vec2f) -> f32 {
    return p.y;
}
