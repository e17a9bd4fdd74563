//! The manual: the guides of `docs`, built into the program, as plain pages.

use egui::{RichText, ScrollArea, Ui};

use crate::ui::{segments, theme};

/// Titles and Markdown of the pages.
const PAGES: [(&str, &str); 6] = [
    ("Glossary", include_str!("../../../docs/glossary.md")),
    ("Scenes", include_str!("../../../docs/scene.md")),
    ("Boards", include_str!("../../../docs/boards.md")),
    ("Felt level", include_str!("../../../docs/felt.md")),
    ("Remote control", include_str!("../../../docs/control.md")),
    ("Command line", include_str!("../../../docs/commands.md")),
];

/// Draws the page of this index with the choice of another one.
pub(super) fn show(page: &mut usize, ui: &mut Ui) {
    ui.heading("Manual");
    let choices: Vec<_> =
        PAGES.iter().enumerate().map(|(index, (title, _))| (index, *title, String::new())).collect();
    ui.horizontal_wrapped(|ui| segments::show(ui, "Page", page, &choices));
    ui.add_space(4.0);
    let height = (ui.ctx().content_rect().height() - 200.0).clamp(80.0, 600.0);
    let text = PAGES.get(*page).map_or("", |(_, text)| text);
    ScrollArea::both()
        .id_salt(*page)
        .max_height(height)
        .min_scrolled_height(height)
        .auto_shrink([false, true])
        .show(ui, |ui| {
            let width = ui.available_width();
            for block in blocks(text) {
                match block {
                    Block::Heading(text) => {
                        ui.add_space(8.0);
                        ui.label(theme::heading(&text));
                    }
                    Block::Text(text) => {
                        ui.scope(|ui| {
                            ui.set_max_width(width);
                            ui.label(text);
                        });
                    }
                    Block::Code(text) => {
                        ui.add(egui::Label::new(RichText::new(text).monospace()).extend());
                    }
                    Block::Table(rows) => table(&rows, ui),
                }
            }
        });
    ui.add_space(8.0);
}

fn table(rows: &[Vec<String>], ui: &mut Ui) {
    let id = ui.next_auto_id();
    egui::Grid::new(id).striped(true).max_col_width(270.0).show(ui, |ui| {
        for (index, row) in rows.iter().enumerate() {
            for cell in row {
                ui.label(if index == 0 { RichText::new(cell).strong() } else { RichText::new(cell) });
            }
            ui.end_row();
        }
    });
}

/// A piece of a page.
#[derive(Debug, PartialEq)]
enum Block {
    Heading(String),
    Text(String),
    Code(String),
    /// The first row names the columns.
    Table(Vec<Vec<String>>),
}

/// The pieces of a Markdown text. Lines of a paragraph are joined.
fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut is_code = false;
    // Whether the next line continues the last piece.
    let mut goes_on = false;
    for line in text.lines() {
        if line.starts_with("```") {
            is_code = !is_code;
            goes_on = false;
            continue;
        }
        let begins =
            !goes_on || line.starts_with("- ") || line.starts_with(|first: char| first.is_ascii_digit());
        match (blocks.last_mut(), line) {
            (Some(Block::Code(code)), _) if is_code && goes_on => {
                code.push('\n');
                code.push_str(line);
            }
            _ if is_code => blocks.push(Block::Code(line.to_owned())),
            (_, "") => {
                goes_on = false;
                continue;
            }
            _ if line.starts_with('#') => {
                blocks.push(Block::Heading(plain(line.trim_start_matches('#').trim())));
                goes_on = false;
                continue;
            }
            (last, _) if line.starts_with('|') => {
                let cells = line.trim_matches('|').split('|').map(|cell| plain(cell.trim()));
                let cells: Vec<String> = cells.collect();
                match last {
                    Some(Block::Table(_))
                        if cells.iter().all(|cell| cell.trim_matches(['-', ':']).is_empty()) => {}
                    Some(Block::Table(rows)) if goes_on => rows.push(cells),
                    _ => blocks.push(Block::Table(vec![cells])),
                }
            }
            (Some(Block::Text(text)), _) if !begins => {
                text.push(' ');
                text.push_str(&plain(line.trim()));
            }
            _ => blocks.push(Block::Text(plain(line.trim()).replacen("- ", "• ", 1))),
        }
        goes_on = true;
    }
    blocks
}

/// A line without its marks; of links their text.
fn plain(line: &str) -> String {
    let mut text = String::new();
    let mut rest = line;
    while let Some(start) = rest.find("](") {
        let Some(end) = rest[start..].find(')') else { break };
        text.push_str(&rest[..start]);
        rest = &rest[start + end + 1..];
    }
    text.push_str(rest);
    text.replace(['`', '['], "")
        .replace("**", "")
        .replace("\\|", "|")
        .replace("&#124;", "|")
        .replace(['*', ']'], "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_has_headings_paragraphs_code_and_tables() {
        let text =
            "# A\none\ntwo [b](c.md)\n\n- x\n- `y`\n```\nk = 1\n\nl\n```\n| n | m |\n|---|---|\n| 1 | 2 |";
        let words = |text: &str| Block::Text(text.to_owned());
        let row = |cells: [&str; 2]| cells.map(str::to_owned).to_vec();
        let expected = [
            Block::Heading("A".to_owned()),
            words("one two b"),
            words("• x"),
            words("• y"),
            Block::Code("k = 1\n\nl".to_owned()),
            Block::Table(vec![row(["n", "m"]), row(["1", "2"])]),
        ];
        assert_eq!(blocks(text), expected);
        assert!(PAGES.iter().all(|(_, page)| blocks(page).len() > 3));
    }
}
