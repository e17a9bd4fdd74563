// |p| of a pressure.

fn shown(p: vec2f) -> f32 {
    return sqrt(dot(p, p));
}
