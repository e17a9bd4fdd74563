// The elements, few enough for a uniform array: x, y (m), phase (turns), amplitude (Pa·m); of a curved board then z (m) and the direction of
// radiation.

@group(0) @binding(1) var<uniform> elements: array<vec4f, UNIFORM_ELEMENTS>;
