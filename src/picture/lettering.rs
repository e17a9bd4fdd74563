//! Pixel plots with text in the figure font, since plotters has no font in a browser.

use plotters::prelude::{BitMapBackend, DrawingBackend};
use plotters::style::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind};
use tiny_skia::{FillRule, Mask, Transform};

use crate::picture::figure::{Anchor, font, letters};

/// Relative to a text's size: the height of its box, and the baseline below the box's top.
const HEIGHT: f64 = 1.0 / 1.24;
const BASELINE: f64 = 0.5;
/// Sizes include ascenders and descenders: in ems of this font.
const REACH: f64 = 1.21;
/// Room for letters above and below the baseline, in text sizes.
const ROOM: f64 = 1.0;

type Drawn<'a> = Result<(), DrawingErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

/// Pixels that are drawn on.
pub struct Lettered<'a>(BitMapBackend<'a>);

impl<'a> Lettered<'a> {
    /// The plot on three bytes per pixel.
    pub fn on(rgb: &'a mut [u8], size: (u32, u32)) -> Self {
        Self(BitMapBackend::with_buffer(rgb, size))
    }
}

/// Width and height of a text of this size.
fn extent(text: &str, size: f64) -> (f64, f64) {
    (font::width(text, size / REACH), size * HEIGHT)
}

impl<'a> DrawingBackend for Lettered<'a> {
    type ErrorType = <BitMapBackend<'a> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.0.get_size()
    }

    fn ensure_prepared(&mut self) -> Drawn<'a> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> Drawn<'a> {
        self.0.present()
    }

    fn draw_pixel(&mut self, at: BackendCoord, colour: BackendColor) -> Drawn<'a> {
        self.0.draw_pixel(at, colour)
    }

    fn draw_line<S: BackendStyle>(&mut self, one: BackendCoord, other: BackendCoord, style: &S) -> Drawn<'a> {
        self.0.draw_line(one, other, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        one: BackendCoord,
        other: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn<'a> {
        self.0.draw_rect(one, other, style, fill)
    }

    fn blit_bitmap(&mut self, at: BackendCoord, size: (u32, u32), rgb: &[u8]) -> Drawn<'a> {
        self.0.blit_bitmap(at, size, rgb)
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Self::ErrorType>> {
        let (width, height) = extent(text, style.size());
        Ok((width as u32, height as u32))
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn<'a> {
        let size = style.size();
        let (width, height) = extent(text, size);
        let (room, em) = ((size * ROOM).ceil(), (size / REACH) as f32);
        let baseline = room + size * BASELINE;
        let sides = [width + 2.0 * room, height + 2.0 * room].map(|side| side.ceil() as u32);
        let Some(mut mask) = Mask::new(sides[0], sides[1]) else { return Ok(()) };
        if let Some(path) = letters(text, Anchor::Start) {
            let placed = Transform::from_row(em, 0.0, 0.0, -em, room as f32, baseline as f32);
            mask.fill_path(&path, FillRule::Winding, true, placed);
        }
        let left = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => width / 2.0,
            HPos::Right => width,
        };
        let top = match style.anchor().v_pos {
            VPos::Top => 0.0,
            VPos::Center => height / 2.0,
            VPos::Bottom => height,
        };
        let (left, top) = ((left + room) as i32, (top + room) as i32);
        let (colour, turn) = (style.color(), style.transform());
        let (most_x, most_y) = self.get_size();
        for (y, row) in mask.data().chunks_exact(sides[0] as usize).enumerate() {
            for (x, &covered) in row.iter().enumerate().filter(|&(_, &covered)| covered > 0) {
                let (x, y) = turn.transform(x as i32 - left, y as i32 - top);
                let (x, y) = (at.0 + x, at.1 + y);
                if (0..most_x as i32).contains(&x) && (0..most_y as i32).contains(&y) {
                    let alpha = colour.alpha * f64::from(covered) / 255.0;
                    self.draw_pixel((x, y), BackendColor { alpha, ..colour })?;
                }
            }
        }
        Ok(())
    }
}
