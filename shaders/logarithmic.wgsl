// The colour of a number by its logarithm, from FLOOR of the largest to the largest.

fn colour_index(p: vec2f) -> u32 {
    let part = clamp(shown(p) / max(params.full, 1e-30), FLOOR, 1.0);
    return u32((1.0 - log2(part) / log2(FLOOR)) * 255.0 + 0.5);
}
