//! A figure as PDF: vector lines, text with embedded font subsets, and losslessly compressed pixels.

use std::collections::BTreeMap;

use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{CidFontType, FontFlags, LineCapStyle, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use subsetter::GlyphRemapper;
use ttf_parser::{RawFace, Tag};

use crate::picture::figure::mark::{Anchor, Ink, Mark};
use crate::picture::figure::{Figure, font};
use crate::picture::{Picture, PictureError};

/// Points in a millimetre.
const POINTS: f64 = 72.0 / 25.4;
const COMPRESSION: u8 = 6;
const FONT: Name<'static> = Name(b"F0");
/// A prefix of six letters and a plus marks a font subset.
const FONT_NAME: Name<'static> = Name(b"SONOGL+Inter-Regular");
const IDENTITY: SystemInfo<'static> =
    SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

const CATALOGUE: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const TYPE0: Ref = Ref::new(5);
const CID: Ref = Ref::new(6);
const DESCRIPTOR: Ref = Ref::new(7);
const OUTLINES: Ref = Ref::new(8);
const UNICODE: Ref = Ref::new(9);
const INFO: Ref = Ref::new(10);
const FIRST_IMAGE: i32 = 11;

/// The PDF, of one page.
///
/// # Errors
/// A font that cannot be subset.
pub fn write(figure: &Figure) -> Result<Vec<u8>, PictureError> {
    let size = figure.size().map(|mm| (mm * POINTS) as f32);
    let mut letters = Letters::default();
    let (content, images) = content(figure, &mut letters);
    let mut pdf = Pdf::new();
    pdf.catalog(CATALOGUE).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let mut info = pdf.document_info(INFO);
    info.producer(TextStr("Sonoglyph"));
    if !figure.title.is_empty() {
        info.title(TextStr(&figure.title));
    }
    info.finish();
    let mut page = pdf.page(PAGE);
    page.media_box(Rect::new(0.0, 0.0, size[0], size[1])).parent(PAGES).contents(CONTENT);
    let mut resources = page.resources();
    resources.fonts().pair(FONT, TYPE0);
    let mut objects = resources.x_objects();
    for index in 0..images.len() {
        objects.pair(Name(image_name(index).as_bytes()), image_ref(index));
    }
    objects.finish();
    resources.finish();
    page.finish();
    pdf.stream(CONTENT, &compress_to_vec_zlib(&content, COMPRESSION)).filter(Filter::FlateDecode);
    for (index, picture) in images.into_iter().enumerate() {
        image(&mut pdf, image_ref(index), picture);
    }
    letters.embed(&mut pdf)?;
    Ok(pdf.finish())
}

fn image_name(index: usize) -> String {
    format!("I{index}")
}

fn image_ref(index: usize) -> Ref {
    Ref::new(FIRST_IMAGE + index as i32)
}

fn image(pdf: &mut Pdf, at: Ref, picture: &Picture) {
    let rgb: Vec<u8> =
        picture.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let data = compress_to_vec_zlib(&rgb, COMPRESSION);
    let mut image = pdf.image_xobject(at, &data);
    image.filter(Filter::FlateDecode);
    image.width(picture.width as i32);
    image.height(picture.height as i32);
    image.color_space().device_rgb();
    image.bits_per_component(8);
}

/// The operators that draw the page, and the pictures among them.
fn content<'a>(figure: &'a Figure, letters: &mut Letters) -> (Vec<u8>, Vec<&'a Picture>) {
    let height = figure.size()[1];
    let (mut content, mut images) = (Content::new(), Vec::new());
    // Upwards from the lower left corner.
    let x = |mm: f64| (mm * POINTS) as f32;
    let y = |mm: f64| ((height - mm) * POINTS) as f32;
    let fill = |content: &mut Content, ink: Ink| {
        let [r, g, b] = ink.map(|channel| f32::from(channel) / 255.0);
        content.set_fill_rgb(r, g, b);
    };
    content.set_line_join(LineJoinStyle::RoundJoin);
    for mark in &figure.marks {
        match mark {
            Mark::Pixels { corner, size, picture } => {
                content.save_state();
                content.transform([x(size[0]), 0.0, 0.0, x(size[1]), x(corner[0]), y(corner[1] + size[1])]);
                content.x_object(Name(image_name(images.len()).as_bytes()));
                content.restore_state();
                images.push(picture);
            }
            Mark::Line { points, is_closed, width, ink } => {
                let [r, g, b] = ink.map(|channel| f32::from(channel) / 255.0);
                content.set_stroke_rgb(r, g, b);
                content.set_line_width(x(*width));
                for (index, point) in points.iter().enumerate() {
                    match index {
                        0 => content.move_to(x(point[0]), y(point[1])),
                        _ => content.line_to(x(point[0]), y(point[1])),
                    };
                }
                if *is_closed {
                    content.close_path();
                }
                content.stroke();
            }
            Mark::Block { corner, size, ink } => {
                fill(&mut content, *ink);
                content.rect(x(corner[0]), y(corner[1] + size[1]), x(size[0]), x(size[1]));
                content.fill_nonzero();
            }
            // A point with a round end.
            Mark::Disc { centre: [u, v], radius, ink } => {
                let [r, g, b] = ink.map(|channel| f32::from(channel) / 255.0);
                content.save_state();
                content.set_line_cap(LineCapStyle::RoundCap);
                content.set_stroke_rgb(r, g, b);
                content.set_line_width(x(2.0 * radius));
                content.move_to(x(*u), y(*v)).line_to(x(*u), y(*v)).stroke();
                content.restore_state();
            }
            Mark::Text { at, height, anchor, is_turned, ink, text } => {
                let part = match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => 0.5,
                    Anchor::End => 1.0,
                };
                let back = part * font::width(text, *height);
                let place = match is_turned {
                    false => [1.0, 0.0, 0.0, 1.0, x(at[0] - back), y(at[1])],
                    true => [0.0, 1.0, -1.0, 0.0, x(at[0]), y(at[1] + back)],
                };
                fill(&mut content, *ink);
                content.begin_text();
                content.set_font(FONT, x(*height));
                content.set_text_matrix(place);
                content.show(Str(&letters.encode(text)));
                content.end_text();
            }
        }
    }
    (content.finish().to_vec(), images)
}

/// The letters that a figure uses.
#[derive(Default)]
struct Letters {
    glyphs: GlyphRemapper,
    /// Used glyphs by their number in the embedded font: character and advance in thousandths of an em.
    used: BTreeMap<u16, (char, f32)>,
}

impl Letters {
    /// Two bytes per letter.
    fn encode(&mut self, text: &str) -> Vec<u8> {
        let mut bytes = Vec::new();
        for character in text.chars() {
            let (glyph, advance) = font::glyph(character);
            let number = self.glyphs.remap(glyph.0);
            self.used.insert(number, (character, 1000.0 * advance as f32));
            bytes.extend(number.to_be_bytes());
        }
        bytes
    }

    fn embed(&self, pdf: &mut Pdf) -> Result<(), PictureError> {
        let face = font::face();
        let part = subsetter::subset(font::DATA, 0, &self.glyphs)
            .map_err(|error| PictureError(format!("the font cannot be embedded: {error}")))?;
        let mut font = pdf.type0_font(TYPE0);
        font.base_font(FONT_NAME).encoding_predefined(Name(b"Identity-H"));
        font.descendant_font(CID).to_unicode(UNICODE);
        font.finish();
        let mut font = pdf.cid_font(CID);
        font.subtype(CidFontType::Type0).base_font(FONT_NAME).system_info(IDENTITY);
        font.font_descriptor(DESCRIPTOR).default_width(0.0);
        let mut widths = font.widths();
        for (&number, &(_, advance)) in &self.used {
            widths.consecutive(number, [advance]);
        }
        widths.finish();
        font.finish();
        let thousandths = 1000.0 / f32::from(face.units_per_em());
        let bounds = face.global_bounding_box();
        let [left, bottom, right, top] = [bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max]
            .map(|units| f32::from(units) * thousandths);
        pdf.font_descriptor(DESCRIPTOR)
            .name(FONT_NAME)
            .flags(FontFlags::SYMBOLIC)
            .bbox(Rect::new(left, bottom, right, top))
            .italic_angle(0.0)
            .ascent(f32::from(face.ascender()) * thousandths)
            .descent(f32::from(face.descender()) * thousandths)
            .cap_height(727.0)
            .stem_v(90.0)
            .font_file3(OUTLINES);
        let table = RawFace::parse(&part, 0).ok().and_then(|face| face.table(Tag::from_bytes(b"CFF ")));
        let data = compress_to_vec_zlib(table.unwrap_or(&part), COMPRESSION);
        let mut outlines = pdf.stream(OUTLINES, &data);
        outlines.filter(Filter::FlateDecode);
        outlines.pair(Name(b"Subtype"), Name(b"CIDFontType0C"));
        outlines.finish();
        let mut unicode = UnicodeCmap::<u16>::new(Name(b"Custom"), IDENTITY);
        for (&number, &(character, _)) in &self.used {
            unicode.pair(number, character);
        }
        pdf.cmap(UNICODE, &unicode.finish());
        Ok(())
    }
}
