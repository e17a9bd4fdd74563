//! Positions of errors in a scene file: line, key and value as written.

use std::fmt;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use crate::echo;
use crate::scene::range::{Key, KeyError};

/// Errors of reading a scene file.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    #[error("{}: {cause}", file.display())]
    Read { file: PathBuf, cause: io::Error },
    #[error("{}", Place(file, *line, key.as_deref().map(|key| (key, None)), message))]
    Syntax { file: PathBuf, line: usize, key: Option<String>, message: String },
    #[error("{}", Place(file, *line, Some((key, value.as_deref())), message))]
    Value { file: PathBuf, line: usize, key: String, value: Option<String>, message: String },
}

/// `file:line: key = value: message`, without unknown parts.
struct Place<'a>(&'a Path, usize, Option<(&'a str, Option<&'a str>)>, &'a str);

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(file, line, key, message) = self;
        write!(f, "{}:{line}: ", file.display())?;
        match key {
            Some((key, Some(value))) => write!(f, "{key} = {}: ", echo::value(value))?,
            Some((key, None)) => write!(f, "{key}: ")?,
            None => {}
        }
        f.write_str(message)
    }
}

/// The message of TOML or serde, with the key concerned.
pub fn misread(error: &toml::de::Error, text: &str, file: &Path) -> FileError {
    let span = error.span();
    FileError::Syntax {
        file: file.to_owned(),
        line: span.clone().map_or(1, |span| line_of(text, span.start)),
        key: span.and_then(|span| key_at(&span, text)),
        message: error.message().trim().replace('\n', ", "),
    }
}

/// Finds the line and the value, as written, of an error's key.
pub fn located(error: &KeyError, text: &str, path: &Path) -> FileError {
    let span = span_of(&error.path, text);
    // The text of a whole table adds nothing to the key.
    let value = span
        .clone()
        .map(|span| text[span].to_owned())
        .filter(|value| !value.contains(['\n', '[']) || is_array(value));
    FileError::Value {
        file: path.to_owned(),
        line: span.map_or(1, |span| line_of(text, span.start)),
        key: error.key(),
        value,
        message: error.message.clone(),
    }
}

fn is_array(value: &str) -> bool {
    value.starts_with('[') && value.ends_with(']') && value.contains(',') && !value.contains('\n')
}

/// The span of the value at `path`; of a missing key, that of the innermost existing table.
fn span_of(path: &[Key], text: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let (first, rest) = path.split_first()?;
    let Key::Name(name) = first else { return None };
    let mut value = document.get_ref().get(*name)?;
    for key in rest {
        let next = match (key, value.get_ref()) {
            (Key::Name(name), DeValue::Table(table)) => table.get(*name),
            (Key::Index(index), DeValue::Array(array)) => array.get(*index),
            _ => None,
        };
        match next {
            Some(next) => value = next,
            None => break,
        }
    }
    Some(value.span())
}

/// The key at this span, or of the value there, in the form of [`KeyError::key`].
fn key_at(span: &Range<usize>, text: &str) -> Option<String> {
    let document = DeTable::parse(text).ok()?;
    let key = of_table(document.get_ref(), span)?;
    Some(key.trim_start_matches('.').to_owned())
}

fn of_table(table: &DeTable<'_>, span: &Range<usize>) -> Option<String> {
    let entry = |(name, value): (&toml::Spanned<std::borrow::Cow<'_, str>>, &toml::Spanned<DeValue<'_>>)| {
        let is_it = || (name.span() == *span).then(String::new);
        let rest = of_value(value, span).or_else(is_it)?;
        Some(format!(".{}{rest}", echo::value(name.get_ref())))
    };
    table.iter().find_map(entry)
}

fn of_value(value: &toml::Spanned<DeValue<'_>>, span: &Range<usize>) -> Option<String> {
    let inside = match value.get_ref() {
        DeValue::Table(table) => of_table(table, span),
        DeValue::Array(array) => {
            let element = |(index, value)| of_value(value, span).map(|rest| format!("[{}]{rest}", index + 1));
            array.iter().enumerate().find_map(element)
        }
        DeValue::String(_)
        | DeValue::Integer(_)
        | DeValue::Float(_)
        | DeValue::Boolean(_)
        | DeValue::Datetime(_) => None,
    };
    inside.or_else(|| (value.span() == *span).then(String::new))
}

fn line_of(text: &str, offset: usize) -> usize {
    text[..offset].matches('\n').count() + 1
}
