//! External text in messages: truncated, with control and invisible characters escaped.

use std::path::Path;

/// Limit of displayed characters of a value.
const MOST_OF_VALUE: usize = 80;
/// Bytes kept of the beginning and of the end of a long message.
const HEAD: usize = 1000;
const TAIL: usize = 500;
const ELLIPSIS: char = '…';

/// Invisible characters: Unicode's formats (Cf), line separators, selectors and fillers; control characters (Cc) are
/// handled separately.
const HIDDEN: [(char, char); 24] = [
    ('\u{ad}', '\u{ad}'),
    ('\u{34f}', '\u{34f}'),
    ('\u{600}', '\u{605}'),
    ('\u{61c}', '\u{61c}'),
    ('\u{6dd}', '\u{6dd}'),
    ('\u{70f}', '\u{70f}'),
    ('\u{890}', '\u{891}'),
    ('\u{8e2}', '\u{8e2}'),
    ('\u{115f}', '\u{1160}'),
    ('\u{17b4}', '\u{17b5}'),
    ('\u{180b}', '\u{180f}'),
    ('\u{200b}', '\u{200f}'),
    ('\u{2028}', '\u{202e}'),
    ('\u{2060}', '\u{206f}'),
    ('\u{3164}', '\u{3164}'),
    ('\u{fe00}', '\u{fe0f}'),
    ('\u{feff}', '\u{feff}'),
    ('\u{ffa0}', '\u{ffa0}'),
    ('\u{fff0}', '\u{fffb}'),
    ('\u{110bd}', '\u{110cd}'),
    ('\u{13430}', '\u{1345f}'),
    ('\u{1bca0}', '\u{1bca3}'),
    ('\u{1d173}', '\u{1d17a}'),
    ('\u{e0000}', '\u{e0fff}'),
];

/// A value as a message names it: one line of at most 80 characters.
pub fn value(text: &str) -> String {
    let mut shown = String::new();
    let mut characters = text.chars();
    characters.by_ref().take(MOST_OF_VALUE).for_each(|c| push(&mut shown, c));
    if characters.next().is_some() {
        shown.push(ELLIPSIS);
    }
    shown
}

/// A whole message: one line of less than 2 kB, shortened in the middle.
pub fn message(text: &str) -> String {
    let line = line(bounded(text));
    if line.len() <= HEAD + TAIL {
        return line;
    }
    let (head, tail) = (line.floor_char_boundary(HEAD), line.ceil_char_boundary(line.len() - TAIL));
    format!("{} {ELLIPSIS} {}", &line[..head], &line[tail..])
}

/// Multi-line text of our own, such as a table, with its line feeds.
pub fn lines(text: &str) -> String {
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

/// A file's name on its own line, in full.
pub fn path(path: &Path) -> String {
    line(path.to_string_lossy())
}

/// All of a text on one line.
pub fn line(text: impl AsRef<str>) -> String {
    let mut shown = String::with_capacity(text.as_ref().len());
    text.as_ref().chars().for_each(|c| push(&mut shown, c));
    shown
}

/// The beginning and the end of a text, so that megabytes cost no time.
fn bounded(text: &str) -> std::borrow::Cow<'_, str> {
    const ENOUGH: usize = 4 * (HEAD + TAIL);
    if text.len() <= 2 * ENOUGH {
        return text.into();
    }
    let (head, tail) = (text.floor_char_boundary(ENOUGH), text.ceil_char_boundary(text.len() - ENOUGH));
    format!("{}{}", &text[..head], &text[tail..]).into()
}

fn push(shown: &mut String, c: char) {
    match c {
        ' '..='~' => shown.push(c),
        '\t' | '\n' | '\r' => shown.extend(c.escape_default()),
        _ if c.is_control() || is_hidden(c) => shown.extend(c.escape_unicode()),
        _ => shown.push(c),
    }
}

fn is_hidden(c: char) -> bool {
    HIDDEN.iter().any(|&(first, last)| (first..=last).contains(&c))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_steers_a_terminal_or_hides_is_shown_as_it_is() {
        for (text, shown) in [
            ("\u{1b}[31mred\u{7}", "\\u{1b}[31mred\\u{7}"),
            ("a\u{9b}2J\r\n\tb\u{0}", "a\\u{9b}2J\\r\\n\\tb\\u{0}"),
            ("\u{202e}txt.exe\u{2066}\u{200b}", "\\u{202e}txt.exe\\u{2066}\\u{200b}"),
            ("tag\u{e0041}\u{fe0f}\u{feff}", "tag\\u{e0041}\\u{fe0f}\\u{feff}"),
            ("é \"α\" 木 C:\\x µm² …", "é \"α\" 木 C:\\x µm² …"),
        ] {
            assert_eq!((value(text), message(text), line(text)), (shown.into(), shown.into(), shown.into()));
        }
        assert_eq!(lines("a\u{1b}\nb\r\n"), "a\\u{1b}\nb\\r\n");
    }

    #[test]
    fn a_megabyte_is_named_in_a_line_that_keeps_both_ends() {
        for c in ['x', '木', '\u{1b}', '\u{202e}'] {
            let text = format!("begin {} end", c.to_string().repeat(1 << 20));
            let message = message(&text);
            assert!(message.starts_with("begin ") && message.ends_with(" end"), "{message}");
            assert!(message.len() < 1600 && message.contains(" … "), "{}", message.len());
            let value = value(&text);
            assert!(value.starts_with("begin ") && value.ends_with('…') && value.len() < 800);
        }
        let longest = "x".repeat(HEAD + TAIL);
        assert_eq!(message(&longest), longest);
    }
}
