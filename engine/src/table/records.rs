//! Rows of other formats than text, as fields of text.

/// A table in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Records {
    /// `None` for rows of numbers without names.
    pub names: Option<Vec<String>>,
    /// Fields with the line that they come from.
    pub rows: Vec<(u64, Vec<String>)>,
    /// Stands between fields of the file: tells whether commas may be decimal ones.
    pub separator: u8,
}
