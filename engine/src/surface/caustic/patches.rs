//! Tests of the light of single patches, wide and narrow, turned over or not.

use super::*;

const SIDE: usize = 8;

#[test]
fn a_patch_that_shrinks_or_turns_over_keeps_its_light_and_its_place() {
    let slopes = [[0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
    for size in [0.9, 0.3, 0.01, 1e-4, 1e-5, 1e-8, 1e-11, 1e-13] {
        for sign in [1.0, -1.0] {
            // Of its image, 3/10 lie to the left of x = 4, or of its mirror image.
            let first = if sign > 0.0 { 4.0 - 0.3 * size } else { 4.0 + 0.7 * size };
            let rays = Rays {
                counts: [2, 2],
                first: [first, 3.05],
                step: [1.0, 1.0],
                slopes: [&slopes[0], &slopes[1]],
                throw: [1.0 - sign * size, 1.0 - size],
            };
            let mut values = vec![0.0; SIDE * SIDE];
            let light = light(&[rays], SIDE, &mut values);
            let own = [values[3 * SIDE + 3], values[3 * SIDE + 4]].map(f64::from);
            assert_eq!(light.crosses, sign < 0.0, "{sign} {size}");
            assert!((light.landed - 1.0).abs() < 1e-6, "{sign} {size}: {light:?}");
            assert!((own[0] + own[1] - 1.0).abs() < 1e-6, "{sign} {size}: {values:?}");
            // The smallest count as two points.
            if size > 1e-3 {
                assert!((own[0] - 0.3).abs() < 1e-6, "{sign} {size}: {own:?}");
            }
        }
    }
}
