// The sum over all elements, where one invocation has added all of them.

fn over_slices(own: Phasor, local: vec3u) -> Phasor {
    return own;
}
