// The depth of a dent, which an average holds first.

fn shown(p: vec2f) -> f32 {
    return p.x;
}
