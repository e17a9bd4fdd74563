//! Published arrays, as scenes without targets.

use std::path::Path;

use crate::scene::{Array, Board};
use crate::studio::opening;

/// A published array.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    pub title: &'static str,
    /// A scene file, whose first line names the source.
    text: &'static str,
}

macro_rules! known {
    ($($title:literal: $name:literal),* $(,)?) => {
        /// All of them.
        pub const KNOWN: &[Known] = &[$(Known {
            title: $title,
            text: include_str!(concat!("../../assets/arrays/", $name, ".toml")),
        }),*];
    };
}

known! {
    "SonicSurface, 16 x 16": "sonicsurface",
    "Two SonicSurfaces face to face": "two-sonicsurfaces",
    "Ultraino, 8 x 8": "ultraino-8",
    "TinyLev, 2 x 36": "tinylev-72",
    "BigLev, 2 x 36": "biglev-72",
    "AUTD3, 249": "autd3-249",
    "Bowl of 64": "bowl-64",
    "Hexagon of 91": "hexagon-91",
    "Spiral of 64": "spiral-64",
}

impl Known {
    /// Source of its geometry.
    pub fn source(&self) -> &'static str {
        self.text.lines().next().map_or("", |line| line.trim_start_matches("# "))
    }

    /// The array, loaded, and its boards.
    pub fn array(&self) -> Option<(Array, Vec<Board>)> {
        let scene = opening::parse(self.text, Path::new(self.title)).ok()?;
        Some((scene.array, scene.boards))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::Scene;
    use crate::studio::elements;

    #[test]
    fn what_is_written_is_read_again() {
        let (array, boards) =
            KNOWN.iter().find(|known| known.title.starts_with("TinyLev")).unwrap().array().unwrap();
        let scene = Scene { array, boards, ..Scene::default() };
        let again = elements::read(elements::of_scene(&scene).as_bytes()).unwrap();
        let places = scene.array.places();
        let again = again.get().unwrap();
        assert_eq!(again.len(), places.len());
        for (again, it) in again.iter().zip(&places) {
            assert!(again.at == it.at && again.normal.distance(it.normal) < 1e-15, "{again:?} is not {it:?}");
        }
    }

    #[test]
    fn every_known_array_names_its_source_and_has_room_for_its_elements() {
        for known in KNOWN {
            assert!(known.source().len() > 20, "{}", known.title);
            let (array, boards) = known.array().unwrap_or_else(|| panic!("{}", known.title));
            let scene = Scene { array, boards, ..Scene::default() };
            let Aperture { positions, .. } = Aperture::new(&scene);
            for (n, place) in positions.iter().enumerate() {
                let nearest = positions[..n].iter().map(|other| other.distance(*place)).fold(1.0, f64::min);
                assert!(nearest >= 2.0 * scene.array.element_radius - 1e-6, "{}: {nearest}", known.title);
            }
        }
    }
}
