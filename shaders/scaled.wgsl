// The colour of a number between 0 and the largest.

fn colour_index(p: vec2f) -> u32 {
    return u32(clamp(shown(p) / max(params.full, 1e-30), 0.0, 1.0) * 255.0 + 0.5);
}
