//! Paths (tables of places, G-code): places are within reach, and every moment has one.

use sonoglyph::scene::motion::{self, Routes};
use sonoglyph::scene::{Motion, MotionPath, Scene, Shape, Target};
use sonoglyph::studio::routes;

use super::is_one_line;

/// m
const FARTHEST: f64 = 10.0 + 1e-9;

pub fn run(bytes: &[u8]) {
    for is_program in [false, true] {
        let (traces, remarks) = match routes::decode(bytes, is_program) {
            Ok(read) => read,
            Err(error) => {
                is_one_line(&error.to_string());
                continue;
            }
        };
        remarks.iter().for_each(|remark| is_one_line(remark));
        let places = || traces.iter().flat_map(|trace| &trace.places);
        assert!(places().next().is_some());
        let targets = vec![Target::new(Shape::Point { at: Default::default() }); 2];
        let routes = Routes::new("a.csv".into(), &traces, remarks);
        let motion = Motion { path: MotionPath::File, routes, ..Motion::default() };
        let scene = Scene { targets, motion, ..Scene::default() };
        for part in (0..100).map(|n| f64::from(n) * 0.01) {
            let at = motion::pose_of(&scene, 0, part).at;
            assert!(at.abs().max_element() <= 3.0 * FARTHEST, "{part}: {at}");
        }
        assert!((1..=4096).contains(&scene.motion.frame_count()));
    }
}
