// Pressure, and its slopes along the plane's axes and its normal. `engine/src/field/gpu/program.rs` defines which of them a
// program needs, and their indices: PRESSURE, ALONG_X, ALONG_Y and NORMAL, or NOWHERE.
struct Sound {
    p: vec2f,
    x: vec2f,
    y: vec2f,
    n: vec2f,
}
