// The elements, too many for a uniform array: x, y (m), phase (turns), amplitude (Pa·m).

@group(0) @binding(1) var<storage, read> elements: array<vec4f>;
