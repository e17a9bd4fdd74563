//! The layout of a text table, from its first lines: separator, names or none, rows or columns.
//!
//! Commas separate numbers with decimal points only. With semicolons, tabs or blanks between them, numbers may have
//! decimal commas. Which it is, is what makes all of the first rows equally long rows of numbers.

use crate::table::records::Records;

/// Markers of comments, and Excel's line of the separator.
pub(crate) const COMMENTS: [&str; 4] = ["#", "%", "//", "sep="];
/// Stands for blanks and tabs, which may be repeated.
pub(crate) const BLANK: u8 = b' ';
/// Separators in the order in which they are tried.
const SEPARATORS: [u8; 4] = [b'\t', b';', b',', BLANK];
/// Rows that must count for their first column to be a number.
const COUNTING: usize = 2;
/// Columns of the longest table of elements: three longer lines are coordinates.
const MOST_COLUMNS: usize = 14;

/// How a table is written.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Layout {
    pub separator: u8,
    /// Names of a first line, or of a comment before the numbers.
    pub names: Option<Vec<String>>,
    /// The line of names is the first row.
    pub has_header: bool,
    pub columns: usize,
    /// Rows whose first column counts from 0 or 1, if all of the first do.
    pub counted: usize,
}

/// Content of the first lines, and the last comment before them.
struct Head<'a> {
    comment: Option<&'a str>,
    lines: Vec<&'a str>,
}

impl<'a> Head<'a> {
    fn of(text: &'a str) -> Self {
        let (mut comment, mut lines) = (None, Vec::new());
        for line in text.lines().map(|line| line.trim_matches(['\u{feff}', ' ', '\r', '\0'])) {
            if line.trim().is_empty() {
                continue;
            }
            match comment_of(line) {
                Some(text) if lines.is_empty() => comment = Some(text),
                Some(_) => {}
                None => lines.push(line),
            }
        }
        Self { comment, lines }
    }
}

/// The text of a line that is a comment.
pub(crate) fn comment_of(line: &str) -> Option<&str> {
    let line = line.trim_start();
    COMMENTS.iter().find_map(|marker| line.strip_prefix(marker))
}

/// The layout of a table that begins with some lines; they may be all of it.
pub(crate) fn of(text: &str) -> Layout {
    let Head { comment, lines } = Head::of(text);
    let Some((&first, rest)) = lines.split_first() else { return Layout::default() };
    if is_numbers(first) {
        let separator = SEPARATORS
            .into_iter()
            .find(|&separator| evenly(&lines, separator, |columns| columns >= 2))
            .unwrap_or(if first.contains(';') { b';' } else { b',' });
        let columns = split(first, separator).len();
        let names = comment.map(|comment| in_unit(names(comment))).filter(|names| names.len() == columns);
        return Layout { separator, names, has_header: false, columns, counted: counted(&lines, separator) };
    }
    let (own, names) = (separator_of_names(first), names(first));
    let columns = names.len();
    let has_own = own != BLANK && rest.iter().any(|line| line.contains(own as char));
    let separator = if has_own || rest.is_empty() || (own != BLANK && columns == 1) {
        own
    } else {
        let fits = |&separator: &u8| evenly(rest, separator, |own| own == columns);
        SEPARATORS.into_iter().find(fits).unwrap_or(own)
    };
    Layout { separator, names: Some(names), has_header: true, columns, counted: 0 }
}

/// Three lines of coordinates, as k-Wave and MATLAB have them: a column per place, if the text is all of a table.
pub(crate) fn in_columns(text: &str, layout: &Layout) -> Option<Records> {
    let Head { lines, .. } = Head::of(text);
    if layout.has_header || lines.len() != 3 || layout.columns <= MOST_COLUMNS {
        return None;
    }
    let rows: Vec<_> = lines.iter().map(|line| split(line, layout.separator)).collect();
    let is_even = rows.iter().all(|row| row.len() == layout.columns);
    let place = |n: usize| (1, rows.iter().map(|row| row[n].to_owned()).collect());
    is_even.then(|| Records {
        names: Some(["x", "y", "z"].map(str::to_owned).to_vec()),
        rows: (0..layout.columns).map(place).collect(),
        separator: layout.separator,
    })
}

/// The fields of a line, without blanks and quotation marks around them, and without empty ones at the end.
pub(crate) fn split(line: &str, separator: u8) -> Vec<&str> {
    if separator == BLANK {
        let fields = line.split_ascii_whitespace();
        return fields.take_while(|field| comment_of(field).is_none()).collect();
    }
    let mut is_quoted = false;
    let ends = |c: char| {
        is_quoted ^= c == '"';
        !is_quoted && c == separator as char
    };
    let mut fields: Vec<_> = line.split(ends).map(|field| field.trim().trim_matches('"').trim()).collect();
    while fields.len() > 1 && fields.last().is_some_and(|last| last.is_empty()) {
        fields.pop();
    }
    fields
}

/// The separator of a line of names.
fn separator_of_names(line: &str) -> u8 {
    let named = [b'\t', b';', b','].into_iter().find(|&separator| split(line, separator).len() > 1);
    named.unwrap_or(if line.contains(',') { b',' } else { BLANK })
}

/// The names of a line; a unit in brackets belongs to the name before it.
fn names(line: &str) -> Vec<String> {
    let separator = separator_of_names(line);
    if separator != BLANK {
        return split(line, separator).into_iter().map(str::to_owned).collect();
    }
    let mut names: Vec<String> = Vec::new();
    for word in line.split_ascii_whitespace() {
        match names.last_mut() {
            Some(last) if word.starts_with(['[', '(']) => {
                last.push(' ');
                last.push_str(word);
            }
            Some(_) | None => names.push(word.trim_matches('"').to_owned()),
        }
    }
    names
}

/// The names of a comment; of `x y z in mm` with the unit each.
fn in_unit(names: Vec<String>) -> Vec<String> {
    match &names[..] {
        [own @ .., word, unit] if word == "in" => own.iter().map(|name| format!("{name} [{unit}]")).collect(),
        _ => names,
    }
}

/// Whether a line has nothing but numbers, however they are separated.
fn is_numbers(line: &str) -> bool {
    let mut fields = line.split([',', ';', '\t', ' ', '"']).filter(|field| !field.is_empty()).peekable();
    fields.peek().is_some()
        && fields.take_while(|field| comment_of(field).is_none()).all(|field| plain(field).is_some())
}

/// Whether all lines have an accepted number of fields, each a number, a word or empty.
fn evenly(lines: &[&str], separator: u8, accepts: impl Fn(usize) -> bool) -> bool {
    let columns = lines.first().map_or(0, |line| split(line, separator).len());
    let is_plausible = |field: &str| {
        let is_word = field.contains(char::is_alphabetic);
        field.is_empty() || is_word || number(field, separator != b',').is_some()
    };
    let is_row = |line: &&str| {
        let fields = split(line, separator);
        fields.len() == columns && fields.into_iter().all(is_plausible)
    };
    accepts(columns) && lines.iter().all(is_row)
}

/// A number, perhaps with a decimal comma.
pub(crate) fn number(text: &str, decimal_comma: bool) -> Option<f64> {
    match decimal_comma && text.contains(',') {
        true if text.contains('.') => None,
        true => plain(&text.replace(',', ".")),
        false => plain(text),
    }
}

/// A number with a decimal point, and a minus sign of either kind.
fn plain(text: &str) -> Option<f64> {
    match text.strip_prefix('\u{2212}') {
        Some(rest) => rest.parse::<f64>().ok().map(|number| -number),
        None => text.parse().ok(),
    }
}

fn counted(lines: &[&str], separator: u8) -> usize {
    let first = |line: &&str| split(line, separator).first().and_then(|field| field.parse::<u64>().ok());
    let numbers: Option<Vec<_>> = lines.iter().map(first).collect();
    let Some(numbers) = numbers.filter(|numbers| numbers.len() >= COUNTING && numbers[0] <= 1) else {
        return 0;
    };
    let counts = numbers.windows(2).all(|pair| pair[1] == pair[0] + 1);
    if counts { numbers.len() } else { 0 }
}
