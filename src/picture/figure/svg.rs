//! A figure as SVG: vector lines and text, and pixels as an embedded PNG.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::picture::figure::Figure;
use crate::picture::figure::mark::{Ink, Mark};
use crate::picture::{PictureError, export};

/// Colour of the paper.
pub(in crate::picture) const PAPER: &str = "#fff";

/// The SVG; lengths are in mm.
///
/// # Errors
/// Pixels that cannot be encoded as PNG.
pub fn write(figure: &Figure) -> Result<Vec<u8>, PictureError> {
    Ok(format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}", element(figure)?).into_bytes())
}

/// The SVG as an element of a page.
///
/// # Errors
/// Pixels that cannot be encoded as PNG.
pub(in crate::picture) fn element(figure: &Figure) -> Result<String, PictureError> {
    let [width, height] = figure.size();
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" \
         xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{width:.4}mm\" height=\"{height:.4}mm\" \
         viewBox=\"0 0 {width:.4} {height:.4}\" font-family=\"Inter, Helvetica, Arial, sans-serif\">\n"
    );
    if !figure.title.is_empty() {
        line(&mut text, format_args!("<title>{}</title>", escaped(&figure.title)))?;
    }
    line(&mut text, format_args!("<rect width=\"100%\" height=\"100%\" fill=\"{PAPER}\"/>"))?;
    for mark in &figure.marks {
        match mark {
            Mark::Pixels { corner: [x, y], size: [width, height], picture } => {
                let png = export::png(picture).map_err(|error| PictureError(error.to_string()))?;
                let data = STANDARD.encode(png);
                line(
                    &mut text,
                    format_args!(
                        "<image x=\"{x:.4}\" y=\"{y:.4}\" width=\"{width:.4}\" height=\"{height:.4}\" \
                         preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
                         xlink:href=\"data:image/png;base64,{data}\"/>"
                    ),
                )?;
            }
            Mark::Line { points, is_closed, width, ink } => {
                let mut path = String::new();
                for (index, [x, y]) in points.iter().enumerate() {
                    let letter = if index == 0 { 'M' } else { 'L' };
                    write!(path, "{letter}{x:.3} {y:.3}").map_err(|error| PictureError(error.to_string()))?;
                }
                path.push_str(if *is_closed { "Z" } else { "" });
                line(
                    &mut text,
                    format_args!(
                        "<path d=\"{path}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"/>",
                        colour(*ink)
                    ),
                )?;
            }
            Mark::Block { corner: [x, y], size: [width, height], ink } => line(
                &mut text,
                format_args!(
                    "<rect x=\"{x:.3}\" y=\"{y:.3}\" width=\"{width:.3}\" height=\"{height:.3}\" fill=\"{}\"/>",
                    colour(*ink)
                ),
            )?,
            Mark::Disc { centre: [x, y], radius, ink } => line(
                &mut text,
                format_args!(
                    "<circle cx=\"{x:.3}\" cy=\"{y:.3}\" r=\"{radius:.3}\" fill=\"{}\"/>",
                    colour(*ink)
                ),
            )?,
            Mark::Text { at: [x, y], height, anchor, is_turned, ink, text: words } => {
                let anchor = anchor.into_str();
                let turn = if *is_turned {
                    format!(" transform=\"rotate(-90 {x:.3} {y:.3})\"")
                } else {
                    String::new()
                };
                line(
                    &mut text,
                    format_args!(
                        "<text x=\"{x:.3}\" y=\"{y:.3}\" font-size=\"{height}\" text-anchor=\"{anchor}\" \
                         fill=\"{}\"{turn}>{}</text>",
                        colour(*ink),
                        escaped(words)
                    ),
                )?;
            }
        }
    }
    text.push_str("</svg>\n");
    Ok(text)
}

fn line(text: &mut String, words: std::fmt::Arguments<'_>) -> Result<(), PictureError> {
    writeln!(text, "{words}").map_err(|error| PictureError(error.to_string()))
}

pub(in crate::picture) fn colour([r, g, b]: Ink) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Escaped for XML, without invalid characters.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars().filter(|character| !character.is_control()) {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            other => escaped.push(other),
        }
    }
    escaped
}
