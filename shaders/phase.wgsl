// Cosine and sine of an angle in turns.
//
// The language guarantees little for sin and cos of small angles and nothing for large ones, so the angle is reduced
// exactly (t - round(t)) and both are polynomials, the same as on the CPU.

struct Phasor {
    re: vec4f,
    im: vec4f,
}

fn phasor(turns: vec4f) -> Phasor {
    let half_turns = 2.0 * (turns - round(turns));
    let whole = round(half_turns);
    let f = half_turns - whole;
    // An odd number of half-turns changes both signs.
    let sign = 1.0 - 2.0 * abs(whole);
    let f2 = f * f;
    let cosine = COSINE_0 + f2 * (COSINE_1 + f2 * (COSINE_2 + f2 * (COSINE_3 + f2 * (COSINE_4 + f2 * COSINE_5))));
    let sine = SINE_0 + f2 * (SINE_1 + f2 * (SINE_2 + f2 * (SINE_3 + f2 * SINE_4)));
    return Phasor(sign * cosine, sign * f * sine);
}
