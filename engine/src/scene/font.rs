//! The stroke font of `assets/stroke_font.toml`: every letter as pen strokes.
//!
//! Coordinates are in cap heights, baseline at y = 0. The asset's head describes its syntax.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::LazyLock;

use glam::{DVec2, dvec2};
use serde::Deserialize;

/// Segments per arc; a quarter circle is approximated within 1.2e-3 of its radius.
const PIECES_PER_ARC: usize = 16;

static FONT: LazyLock<Font> = LazyLock::new(|| {
    Font::parse(include_str!("../../../assets/stroke_font.toml"))
        .expect("the font in assets/ follows its own syntax")
});

/// A polyline in the plane of the text.
pub type Stroke = Vec<DVec2>;

struct Font {
    gap: f64,
    space: f64,
    glyphs: BTreeMap<char, Glyph>,
}

struct Glyph {
    width: f64,
    strokes: Vec<Stroke>,
}

/// The strokes of `text` with capitals `height` high, the line's box (cap height by advance) centred on the origin.
///
/// # Errors
/// The first missing character.
pub fn lay_out(text: &str, height: f64) -> Result<Vec<Stroke>, char> {
    let font = &*FONT;
    let mut strokes = Vec::new();
    let mut pen = 0.0;
    for (index, character) in text.trim().chars().enumerate() {
        if index > 0 {
            pen += font.gap;
        }
        if character == ' ' {
            pen += font.space;
            continue;
        }
        let glyph = font.glyphs.get(&character).ok_or(character)?;
        let place = |vertex: &DVec2| *vertex + dvec2(pen, 0.0);
        strokes.extend(glyph.strokes.iter().map(|stroke| stroke.iter().map(place).collect::<Stroke>()));
        pen += glyph.width;
    }
    let centre = dvec2(pen / 2.0, 0.5);
    for vertex in strokes.iter_mut().flatten() {
        *vertex = (*vertex - centre) * height;
    }
    Ok(strokes)
}

/// The missing characters of a text, each once.
pub fn lacking(text: &str) -> Vec<char> {
    let mut lacking: Vec<char> =
        text.chars().filter(|letter| *letter != ' ' && !FONT.glyphs.contains_key(letter)).collect();
    lacking.sort_unstable();
    lacking.dedup();
    lacking
}

/// A sentence about missing characters.
pub fn lacks(characters: &[char]) -> String {
    /// The last character drawn by the window's font.
    const LAST: char = '\u{3ff}';
    let named = |&letter: &char| match letter {
        _ if letter > LAST => format!("U+{:04X}", u32::from(letter)),
        _ => format!("“{}”", letter.escape_debug()),
    };
    let quoted: Vec<_> = characters.iter().take(5).map(named).collect();
    format!("the stroke font has no {}", quoted.join(", "))
}

impl Font {
    fn parse(text: &str) -> Result<Self, String> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct FontTable {
            gap: f64,
            space: f64,
            glyphs: BTreeMap<char, String>,
        }
        let FontTable { gap, space, glyphs } = toml::from_str(text).map_err(|e| e.to_string())?;
        let glyphs = glyphs
            .into_iter()
            .map(|(name, text)| Ok((name, Glyph::parse(&text).map_err(|e| format!("glyph {name}: {e}"))?)))
            .collect::<Result<_, String>>()?;
        Ok(Self { gap, space, glyphs })
    }
}

impl Glyph {
    fn parse(text: &str) -> Result<Self, String> {
        let mut fields = text.split('|');
        let width = number(fields.next().unwrap_or_default())?;
        let strokes = fields.map(parse_stroke).collect::<Result<Vec<_>, _>>()?;
        if strokes.is_empty() { Err("no stroke".to_owned()) } else { Ok(Self { width, strokes }) }
    }
}

/// Reads `x,y` vertices and `*x,y` control points into a polyline.
fn parse_stroke(text: &str) -> Result<Stroke, String> {
    let mut stroke = Stroke::new();
    let mut control = None;
    for word in text.split_whitespace() {
        let (is_control, pair) = match word.strip_prefix('*') {
            Some(pair) => (true, pair),
            None => (false, word),
        };
        let (x, y) = pair.split_once(',').ok_or_else(|| format!("`{word}` is no vertex"))?;
        let vertex = dvec2(number(x)?, number(y)?);
        match (is_control, control.take()) {
            (true, None) if !stroke.is_empty() => control = Some(vertex),
            (true, _) => return Err(format!("control point `{word}` is not between two vertices")),
            (false, None) => stroke.push(vertex),
            (false, Some(control)) => {
                let start = stroke[stroke.len() - 1];
                let at = |piece| arc(start, control, vertex, piece as f64 / PIECES_PER_ARC as f64);
                stroke.extend((1..PIECES_PER_ARC).map(at));
                stroke.push(vertex);
            }
        }
    }
    match control {
        None if !stroke.is_empty() => Ok(stroke),
        _ => Err("a stroke begins and ends with a vertex".to_owned()),
    }
}

/// The quarter ellipse from `start` to `end` with the corner of its box at `control`: a rational quadratic of weight
/// √½.
fn arc(start: DVec2, control: DVec2, end: DVec2, t: f64) -> DVec2 {
    let (a, b, c) = ((1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t) * FRAC_1_SQRT_2, t * t);
    (start * a + control * b + end * c) / (a + b + c)
}

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| format!("`{text}` is no number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_lies_on_its_ellipse() {
        for piece in 0..=PIECES_PER_ARC {
            let p =
                arc(dvec2(3.0, 0.0), dvec2(3.0, 2.0), dvec2(0.0, 2.0), piece as f64 / PIECES_PER_ARC as f64);
            assert!(((p.x / 3.0).powi(2) + (p.y / 2.0).powi(2) - 1.0).abs() < 1e-12, "{p}");
        }
    }

    #[test]
    fn broken_glyphs_are_refused() {
        for text in
            ["", "0.7", "w | 0,0", "0.7 | 0;0", "0.7 | *0,0 1,1", "0.7 | 0,0 *1,1", "0.7 | 0,0 *1,0 *1,1 0,1"]
        {
            assert!(Glyph::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn every_glyph_stays_in_its_box() {
        for (name, glyph) in &FONT.glyphs {
            for vertex in glyph.strokes.iter().flatten() {
                assert!((-1e-9..=glyph.width + 1e-9).contains(&vertex.x), "{name}: {vertex}");
                assert!((-0.5..=1.6).contains(&vertex.y), "{name}: {vertex}");
            }
        }
    }

    #[test]
    fn the_promised_characters_are_there() {
        let promised =
            ('A'..='Z').chain('a'..='z').chain('0'..='9').chain(".,:;!?'\"-+=/()éäöüñαβλπΩ".chars());
        for character in promised {
            assert!(FONT.glyphs.contains_key(&character), "{character}");
        }
    }

    #[test]
    fn text_is_centred_and_scaled() {
        let strokes = lay_out("H", 0.04).unwrap();
        let (low, high) =
            strokes.iter().flatten().fold((DVec2::MAX, DVec2::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        assert!((low + high).length() < 1e-12, "{low} {high}");
        assert!((high.y - low.y - 0.04).abs() < 1e-12);
    }
}
