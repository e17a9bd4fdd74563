//! What holds of every scene as a file: it comes back as it was, whatever it is written into.

use std::path::Path;

use glam::DVec3;
use sonoglyph::scene::{Body, BodyKind, Elements, Scene, check, file, rewrite};

use crate::dice::Dice;
use crate::random::draw::{Case, Family};
use crate::random::tally::count;

pub fn hold(case: &Case) {
    check::check(&case.scene).unwrap();
    // The elements of a table are not part of the scene's file.
    let mut scene = case.scene.clone();
    scene.array.placed = Elements::default();
    scene.bodies = bodies(&scene, &mut case.dice.clone());
    let scene = &scene;
    let text = file::write(scene);
    match file::parse(&text, Path::new("scene.toml")) {
        Ok(read) => assert_eq!(read, *scene, "{text}"),
        Err(error) => {
            // Foci behind the array, which a file may not have: they are its only error, and it has a line.
            assert_eq!(case.family, Family::Ill, "{error}");
            assert!(error.to_string().contains("behind the array"), "{error}");
            return count("files refused: a focus behind the array");
        }
    }
    let other = "format = 1 # a comment\n\n[[target]]\nat = [0, 0.01, 0.2] # m\n\n[array]\nrows = 3\n";
    for before in [other, &text] {
        let rewritten = rewrite::rewrite(before, scene);
        assert_eq!(file::parse(&rewritten, Path::new("scene.toml")).unwrap(), *scene, "{rewritten}");
    }
    let tables = serde_json::to_value(scene).unwrap();
    let read: Scene = file::from_tables(tables).unwrap();
    assert_eq!(read, *scene, "as JSON");
}

/// Bodies of all kinds that a valid scene of these targets can have; none where no attempt finds any.
fn bodies(scene: &Scene, dice: &mut Dice) -> Vec<Body> {
    let mut found = Vec::new();
    for _ in 0..dice.whole(0, 4) {
        let place = |dice: &mut Dice| DVec3::from_array([(); 3].map(|()| dice.between(-1.0, 1.0)));
        let kind = dice.one_of(&[BodyKind::Sphere, BodyKind::Capsule, BodyKind::Palm, BodyKind::Mesh]);
        let own = Body { kind, at: scene.plane.centre + place(dice), ..Body::default() };
        let own = match kind {
            BodyKind::Sphere => Body { radius: dice.magnitude(1e-4, 0.1), ..own },
            BodyKind::Capsule => {
                let radius = dice.magnitude(1e-4, 0.1);
                Body { radius, length: radius * dice.between(2.0, 9.0), x_axis: place(dice), ..own }
            }
            BodyKind::Palm | BodyKind::Hand => {
                let normal = dice.of(0.5).then(|| place(dice));
                Body { normal, x_axis: place(dice), size: DVec3::splat(dice.magnitude(1e-3, 0.1)), ..own }
            }
            BodyKind::Mesh => {
                Body { file: Some("part.obj".to_owned()), scale: dice.magnitude(1e-6, 1.0), ..own }
            }
        };
        let own = Body { coefficient: dice.one_of(&[1.0, 0.5, -0.5]), ..own };
        let bodies: Vec<_> = found.iter().cloned().chain([own]).collect();
        if check::check(&Scene { bodies: bodies.clone(), ..scene.clone() }).is_ok() {
            found = bodies;
        }
    }
    if !found.is_empty() {
        count("bodies");
    }
    found
}
