//! A report: what was found in words, with the figure, as HTML or PDF.

use anyhow::Context;

use crate::field::{Evaluator, Stages};
use crate::picture::figure::page::Plot;
use crate::picture::figure::table::Table;
use crate::picture::figure::{Figure, Format, Paper};
use crate::studio::figure::{self, Panel, Subject, Wish};
use crate::studio::measurement::{Measured, panels};

/// mm
const WIDTH: f64 = 260.0;
const DPI: f64 = 150.0;
const COLUMNS: usize = 3;

/// Measured, model and difference with profile, elements and bench on one page; with findings in words below, if wanted.
///
/// # Errors
/// Too little memory for its pixels.
pub fn drawn(measured: &Measured, title: &str, has_words: bool) -> anyhow::Result<Figure> {
    let mut panels = panels(measured);
    if has_words {
        let lines = measured.findings().into_iter().chain(measured.warnings());
        let rows = lines.flat_map(|line| wrapped(&line)).map(|line| vec![line]).collect();
        let table = Plot::Table(Table { head: vec!["Findings".to_owned()], rows });
        panels.push(Panel { name: "Findings".to_owned(), subject: Subject::Plot(Box::new(table)) });
    }
    page(&panels, title)
}

/// Panels on a page.
///
/// # Errors
/// Too little memory for its pixels.
pub fn page(panels: &[Panel], title: &str) -> anyhow::Result<Figure> {
    let wish = Wish {
        paper: Paper { width: WIDTH, dpi: DPI },
        columns: Some(COLUMNS.min(panels.len())),
        title: Some(title.to_owned()),
        ..Wish::default()
    };
    Ok(figure::draw(panels, &wish, &mut Stages::new(Evaluator::Cpu), false)?.figure)
}

/// A text in lines of a panel's width.
fn wrapped(text: &str) -> Vec<String> {
    /// Letters.
    const LINE: usize = 60;
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(last) if last.is_empty() => last.push_str(word),
            Some(last) if last.chars().count() + word.chars().count() < LINE => {
                last.push(' ');
                last.push_str(word);
            }
            _ => lines.push(format!("   {word}")),
        }
    }
    lines
}

/// A page of HTML with the figure in it.
///
/// # Errors
/// As [`drawn`].
pub fn html(measured: &Measured, title: &str) -> anyhow::Result<String> {
    let figure = drawn(measured, title, false)?.write(Format::Svg)?;
    let figure = String::from_utf8(figure).context("the figure is no text")?;
    // Declarations have no place within a page.
    let figure = figure.find("<svg").map_or(figure.as_str(), |start| &figure[start..]);
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let item = |line: String| format!("<li>{}</li>\n", escaped(&line));
    let findings: String = measured.lines().into_iter().map(item).collect();
    let warnings: String = measured.warnings().into_iter().map(item).collect();
    let care = if warnings.is_empty() {
        String::new()
    } else {
        format!("<h2>Take care</h2>\n<ul>\n{warnings}</ul>\n")
    };
    let title = escaped(title);
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>body {{ font-family: \
         sans-serif; max-width: 70rem; margin: 2rem auto; padding: 0 1rem; }} svg {{ width: 100%; height: auto; }}</style>\n</head>\n\
         <body>\n<h1>{title}</h1>\n<ul>\n{findings}</ul>\n{care}{figure}\n</body>\n</html>\n"
    ))
}
