// The sum over all elements, of which each row of invocations in a workgroup has added a slice.

var<workgroup> of_slices: array<Phasor, LANES * SLICES>;

// Valid in the first row.
fn over_slices(own: Phasor, local: vec3u) -> Phasor {
    // The memory may still be read for the previous sum.
    workgroupBarrier();
    let place = local.y * LANES + local.x;
    of_slices[place] = own;
    workgroupBarrier();
    for (var rows = SLICES / 2u; rows > 0u; rows /= 2u) {
        if local.y < rows {
            let other = of_slices[place + rows * LANES];
            of_slices[place].re += other.re;
            of_slices[place].im += other.im;
        }
        workgroupBarrier();
    }
    return of_slices[place];
}
