// The colour of a magnitude.

fn colour_index(p: vec2f) -> u32 {
    return u32(clamp(sqrt(dot(p, p)) / max(params.full, 1e-30), 0.0, 1.0) * 255.0 + 0.5);
}
