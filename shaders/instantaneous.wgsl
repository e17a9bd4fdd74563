// The colour of the pressure at one moment, Re{p e^(jωt)}: silence has the middle of the table.

fn colour_index(p: vec2f) -> u32 {
    let now = p.x * params.turn.x - p.y * params.turn.y;
    return u32(clamp(0.5 + 0.5 * now / max(params.full, 1e-30), 0.0, 1.0) * 255.0 + 0.5);
}
