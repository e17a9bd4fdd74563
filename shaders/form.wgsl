// What becomes of the sound at a pixel: its value. The largest of them is kept, so that a picture can be scaled without reading
// anything back. `src/field/quantity.rs` declares the formula; `formula` and `extent` are written by `src/field/gpu/program.rs`
// from that.

struct FormParams {
    // 1/(ρc²), 1/(ρω²) and 1/(ρω).
    of_pressure: f32,
    of_gradient: f32,
    of_velocity: f32,
    // On the formula.
    factor: f32,
    // e^(jωt) of an instantaneous pressure.
    turn: vec2f,
    // Of a bead's potential: of the square of the pressure, and less those of its slopes.
    of_potential: vec2f,
}

@group(0) @binding(3) var<uniform> c: FormParams;
@group(0) @binding(4) var<storage, read_write> values: array<f32>;
// Bits of a float that is not negative: they order as the float does.
@group(0) @binding(5) var<storage, read_write> peak: atomic<u32>;

// The extent of what was put there.
fn put(pixel: u32, sound: Sound) -> f32 {
    let mean = c.factor * formula(sound);
    let value = select(mean, sqrt(max(mean, 0.0)), IS_ROOT);
    values[pixel] = value;
    return extent(sound, value);
}

fn finish(largest: f32) {
    let bits = bitcast<u32>(largest);
    // A look is cheap, where all invocations wait for their turn to write.
    if bits > atomicLoad(&peak) {
        atomicMax(&peak, bits);
    }
}
