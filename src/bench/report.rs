//! The records of a run, as words, JSON and charts.

use comfy_table::{CellAlignment, Table};
use serde_json::Value;

use crate::picture::chart::Chart;
use crate::studio::output::say;

/// Results of a benchmark.
#[derive(Debug)]
pub struct Report {
    pub header: Vec<&'static str>,
    pub rows: Vec<Vec<String>>,
    /// Explanations of the columns, a paragraph each.
    pub notes: Vec<String>,
    pub records: Vec<Value>,
    /// Charts with their file names without extension.
    pub charts: Vec<(String, Chart)>,
}

impl Report {
    /// Prints the table without empty columns, and the notes.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn show(&self) -> anyhow::Result<()> {
        let mut table = Table::new();
        let is_shown = |column: &usize| self.rows.iter().any(|row| row[*column] != "-");
        let columns: Vec<_> = (0..self.header.len()).filter(is_shown).collect();
        table.set_header(columns.iter().map(|&column| self.header[column]));
        table.add_rows(self.rows.iter().map(|row| columns.iter().map(|&column| &row[column])));
        for (&index, column) in columns.iter().zip(table.column_iter_mut()) {
            if self.holds_numbers(index) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        say!("{table}")?;
        self.notes.iter().try_for_each(|line| say!("{line}"))
    }

    /// Whether a column is aligned to the right.
    pub fn holds_numbers(&self, column: usize) -> bool {
        let is_number =
            |cell: &String| cell == "exact" || cell.starts_with(|c: char| c.is_ascii_digit() || c == '-');
        self.rows.iter().filter_map(|row| row.get(column)).all(is_number)
    }
}
