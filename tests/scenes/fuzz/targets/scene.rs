//! Scene files: accepted scenes are within their limits and survive writing, rewriting and JSON.

use std::path::Path;

use sonoglyph::scene::check::MOST_FOCI;
use sonoglyph::scene::file::{self, FileError};
use sonoglyph::scene::{Body, BodyKind, Listener, Method, Scene, motion, outline, rewrite};

use super::{has_line, is_one_line};

/// Limit of focal points over all frames that are checked.
const MOST_MOVED: usize = 20_000;

pub fn run(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match file::parse(text, Path::new("a.toml")) {
        Err(error) => is_located(text, &error),
        Ok(scene) => {
            is_within_limits(&scene);
            survives(text, &scene);
        }
    }
}

fn parse(text: &str) -> Scene {
    file::parse(text, Path::new("b.toml")).unwrap_or_else(|error| panic!("{error} in {text}"))
}

/// The message names the file, a line of it, and a value in that line.
fn is_located(text: &str, error: &FileError) {
    let message = error.to_string();
    is_one_line(&message);
    let (FileError::Syntax { line, .. } | FileError::Value { line, .. }) = error else {
        panic!("{message}: only syntax and values are expected errors")
    };
    has_line(text.as_bytes(), *line);
    assert!(message.starts_with(&format!("a.toml:{line}: ")), "{message}");
    if let FileError::Value { key, value, .. } = error {
        assert!(message.contains(key), "{message}");
        let own = text.split('\n').nth(line - 1).expect("the line exists");
        assert!(value.as_ref().is_none_or(|value| own.contains(value.trim_end())), "{message} in {own}");
    }
}

fn is_within_limits(scene: &Scene) {
    if scene.targets.iter().all(|target| !target.visible) {
        assert!(outline::foci(scene).is_err());
        return;
    }
    let foci = outline::foci(scene).expect("a valid scene has foci");
    assert!((1..=MOST_FOCI).contains(&foci.len()), "{} foci", foci.len());
    for focus in &foci {
        assert!(focus.position.is_finite() && focus.position.z > 0.0 && focus.target > 0.0, "{focus:?}");
    }
    if motion::count(scene) * foci.len() > MOST_MOVED {
        return;
    }
    let frames = motion::frames(scene).expect("a valid scene has frames");
    assert_eq!(frames.len(), motion::count(scene));
    for focus in frames.iter().flatten() {
        assert!(focus.position.is_finite() && focus.position.z > 0.0, "{focus:?}");
    }
}

fn survives(text: &str, scene: &Scene) {
    assert_eq!(parse(&file::write(scene)), *scene, "{text}");
    assert_eq!(file::parse_targets(&file::write_targets(&scene.targets)).as_ref(), Some(&scene.targets));
    let json = serde_json::to_string(scene).expect("a scene serialises");
    let tables: serde_json::Value = serde_json::from_str(&json).expect("the text is JSON");
    assert_eq!(file::from_tables(tables).expect("the tables are a scene"), *scene, "{json}");
    assert_eq!(rewrite::rewrite(text, scene), text);
    for edit in EDITS {
        let mut edited = scene.clone();
        edit(&mut edited);
        let Ok(again) = file::parse(&file::write(&edited), Path::new("b.toml")) else { continue };
        assert_eq!(again, edited);
        let rewritten = rewrite::rewrite(text, &edited);
        assert_eq!(parse(&rewritten), edited, "{text} became {rewritten}");
        assert_eq!(parse(&rewrite::rewrite(&rewritten, scene)), *scene, "{rewritten} and back to {text}");
    }
}

/// Edits that a window may do.
const EDITS: [fn(&mut Scene); 9] = [
    |scene| scene.solver.method = if scene.solver.method == Method::Gs { Method::Wgs } else { Method::Gs },
    |scene| scene.targets.reverse(),
    |scene| {
        scene.solver.quiet = if scene.solver.quiet == 0.25 { 0.5 } else { 0.25 };
        scene.quiet.reverse();
        scene.quiet.pop();
    },
    |scene| {
        scene.bodies.reverse();
        scene.bodies.pop();
    },
    |scene| {
        let at = glam::DVec3::new(0.0, 0.0, 50.0);
        scene.bodies.push(Body { kind: BodyKind::Palm, at, ..Body::default() });
        let spheres = scene.bodies.iter_mut().filter(|body| body.kind == BodyKind::Sphere);
        spheres.for_each(|body| body.radius *= 0.9);
    },
    |scene| scene.targets.extend(scene.targets.last().cloned()),
    |scene| drop(scene.targets.drain(..scene.targets.len().min(1))),
    |scene| {
        scene.listener = match scene.listener {
            Some(_) => None,
            None => Some(Listener { at: glam::DVec3::new(0.0, -0.3, 0.4) }),
        }
    },
    |scene| {
        (scene.medium.sound_speed, scene.liquid.depth, scene.array.rows) = (Some(340.0), 0.02, 3);
        scene.targets.iter_mut().for_each(|target| target.angle += 0.5);
    },
];
