// Complex pressure (Pa, peak) at many points by direct summation over the elements, added to what is there.
//
// Sample i stands at columns[i % width] + rows[i / width]. Every invocation takes eight samples, a workgroup's width
// apart: one element is then read once for eight points, which on software drivers is worth a factor of four.

@group(0) @binding(2) var<storage, read> columns: array<vec4f>;
@group(0) @binding(3) var<storage, read> rows: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> pressure: array<vec2f>;

fn sample(offset: u32) -> vec3f {
    // Beyond the end the last sample is computed again and not written.
    let index = params.first + min(offset, params.count - 1u);
    return columns[index % params.columns].xyz + rows[index / params.columns].xyz;
}

fn write(offset: u32, z: f32, re: f32, im: f32) {
    if offset < params.count {
        // The array stands in a baffle: nothing goes backwards.
        let in_front = z >= -NEAREST;
        pressure[params.written + offset] += select(vec2f(0.0), vec2f(re, im), in_front);
    }
}

@compute @workgroup_size(WORKGROUP)
fn field_main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) local: u32) {
    let start = group.x * (8u * WORKGROUP) + local;
    let p0 = sample(start);
    let p1 = sample(start + WORKGROUP);
    let p2 = sample(start + 2u * WORKGROUP);
    let p3 = sample(start + 3u * WORKGROUP);
    let p4 = sample(start + 4u * WORKGROUP);
    let p5 = sample(start + 5u * WORKGROUP);
    let p6 = sample(start + 6u * WORKGROUP);
    let p7 = sample(start + 7u * WORKGROUP);
    let x_low = vec4f(p0.x, p1.x, p2.x, p3.x);
    let y_low = vec4f(p0.y, p1.y, p2.y, p3.y);
    let z_low = vec4f(p0.z, p1.z, p2.z, p3.z);
    let x_high = vec4f(p4.x, p5.x, p6.x, p7.x);
    let y_high = vec4f(p4.y, p5.y, p6.y, p7.y);
    let z_high = vec4f(p4.z, p5.z, p6.z, p7.z);
    let front_low = max(z_low, vec4f(0.0));
    let front_high = max(z_high, vec4f(0.0));

    var re_low = vec4f(0.0);
    var im_low = vec4f(0.0);
    var re_high = vec4f(0.0);
    var im_high = vec4f(0.0);
    for (var n = params.first_element; n < params.last_element; n++) {
        let element = elements[n];
        let low = wave(x_low, y_low, front_low, element);
        let high = wave(x_high, y_high, front_high, element);
        re_low += low.re;
        im_low += low.im;
        re_high += high.re;
        im_high += high.im;
    }

    write(start, z_low.x, re_low.x, im_low.x);
    write(start + WORKGROUP, z_low.y, re_low.y, im_low.y);
    write(start + 2u * WORKGROUP, z_low.z, re_low.z, im_low.z);
    write(start + 3u * WORKGROUP, z_low.w, re_low.w, im_low.w);
    write(start + 4u * WORKGROUP, z_high.x, re_high.x, im_high.x);
    write(start + 5u * WORKGROUP, z_high.y, re_high.y, im_high.y);
    write(start + 6u * WORKGROUP, z_high.z, re_high.z, im_high.z);
    write(start + 7u * WORKGROUP, z_high.w, re_high.w, im_high.w);
}
