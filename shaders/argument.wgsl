// The colour of a phase. The map is cyclic: every colour has the same share of a turn.

fn colour_index(p: vec2f) -> u32 {
    return min(u32((atan2(p.y, p.x) / (2.0 * PI) + 0.5) * 256.0), 255u);
}
