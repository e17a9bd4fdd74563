//! The number of drives that take turns.

use std::fmt;

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

const AUTO: &str = "auto";

/// Number of drives in turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Turns {
    /// The number that pays for areas at rest, and one for everything else.
    #[default]
    Auto,
    Count(u32),
}

impl Turns {
    /// Whether the scene asks for several.
    pub fn are_several(self) -> bool {
        match self {
            Self::Auto => false,
            Self::Count(count) => count > 1,
        }
    }
}

impl Serialize for Turns {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str(AUTO),
            Self::Count(count) => serializer.serialize_u32(*count),
        }
    }
}

impl<'de> Deserialize<'de> for Turns {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OfTurns)
    }
}

struct OfTurns;

impl Visitor<'_> for OfTurns {
    type Value = Turns;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\"auto\" or a whole number of drives")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Turns, E> {
        if text == AUTO { Ok(Turns::Auto) } else { Err(E::invalid_value(Unexpected::Str(text), &self)) }
    }

    fn visit_i64<E: Error>(self, count: i64) -> Result<Turns, E> {
        let taken = u32::try_from(count);
        taken.map(Turns::Count).map_err(|_| E::invalid_value(Unexpected::Signed(count), &self))
    }

    fn visit_u64<E: Error>(self, count: u64) -> Result<Turns, E> {
        let taken = u32::try_from(count);
        taken.map(Turns::Count).map_err(|_| E::invalid_value(Unexpected::Unsigned(count), &self))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::scene::file::{parse, write};
    use crate::scene::rewrite::rewrite;
    use crate::scene::{content::Scene, turns::Turns};

    fn read(turns: &str) -> Result<Scene, String> {
        let text = format!("format = 1\n[solver]\nframes = {turns}\n");
        parse(&text, Path::new("a.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn turns_are_a_number_or_automatic() {
        for (text, turns) in [("\"auto\"", Turns::Auto), ("1", Turns::Count(1)), ("32", Turns::Count(32))] {
            let scene = read(text).unwrap();
            assert_eq!(scene.solver.frames, turns);
            assert_eq!(parse(&write(&scene), Path::new("a.toml")).unwrap(), scene, "{text}");
        }
        assert_eq!(Scene::default().solver.frames, Turns::Auto);
        for text in ["\"many\"", "0", "33", "-1", "1.5", "true", "[4]"] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with("a.toml:3") && error.contains("frames"), "{text}: {error}");
        }
    }

    #[test]
    fn a_rewritten_file_keeps_its_turns() {
        for turns in ["\"auto\"", "4", "1"] {
            let text = format!("format = 1\n\n[solver]\nframes = {turns} # drives\n");
            let mut scene = parse(&text, Path::new("a.toml")).unwrap();
            scene.solver.search = 1.0;
            let written = rewrite(&text, &scene);
            assert!(written.contains(&format!("frames = {turns} # drives")), "{written}");
            scene.solver.frames = Turns::Count(7);
            assert!(rewrite(&written, &scene).contains("frames = 7 # drives"), "{written}");
        }
    }
}
