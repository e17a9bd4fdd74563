//! The font of figures: widths of texts, and outlines of glyphs.

use std::sync::LazyLock;

use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// Inter, regular.
pub const DATA: &[u8] = include_bytes!("../../../assets/fonts/Inter-Regular.otf");

static FACE: LazyLock<Face<'static>> = LazyLock::new(|| match Face::parse(DATA, 0) {
    Ok(face) => face,
    Err(_) => unreachable!("the font in assets/ is a font"),
});

pub fn face() -> &'static Face<'static> {
    &FACE
}

/// The glyph of a character, with its advance in ems.
pub fn glyph(character: char) -> (GlyphId, f64) {
    let glyph = FACE.glyph_index(character).unwrap_or(GlyphId(0));
    let advance = f64::from(FACE.glyph_hor_advance(glyph).unwrap_or(0));
    (glyph, advance / f64::from(FACE.units_per_em()))
}

/// The width of a text of this height.
pub fn width(text: &str, height: f64) -> f64 {
    height * text.chars().map(|character| glyph(character).1).sum::<f64>()
}

/// The height of a text, at most this one, with which it is no wider than its room.
pub fn fitted(text: &str, height: f64, room: f64) -> f64 {
    height * (room / width(text, height).max(1e-9)).min(1.0)
}

/// Hands the outline of a glyph out, in ems upwards from its origin on the baseline.
pub fn outline(glyph: GlyphId, builder: &mut dyn OutlineBuilder) {
    let _is_empty = FACE.outline_glyph(glyph, builder).is_none();
}
