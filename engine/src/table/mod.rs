//! Numeric tables: columns found by name, with units, and errors with line numbers.
//!
//! One reader for every table of the program: of elements, points, drives, wirings, calibrations, thresholds, readings and
//! heights. `source` opens the file, packed or not, `layout` finds out how a text is written, `column` reads headings
//! with their units, and `xml`, `json` and `npy` are the formats of other programs. `format` names files that are none.

mod column;
mod error;
mod format;
mod json;
mod layout;
#[doc(hidden)]
pub mod npy;
mod records;
mod source;
mod ultraino;
mod xml;

use std::io::Read;

use csv::{ReaderBuilder, StringRecord, Terminator, Trim};

use crate::echo;
use column::Column;
pub use error::TableError;
use layout::{BLANK, Layout};
use records::Records;
use source::{Bytes, Content, Lines};

/// Columns of a table without names, in their order: `""` is left out, and `"#"` counts the rows from 0 or 1.
pub type Order = &'static [&'static str];

/// A table read row by row: `N` required and `M` optional columns, in any order, besides others.
///
/// Columns are separated by commas, by semicolons, tabs or blanks (numbers may then have decimal commas), or those of
/// another format. Names have letters of either case and may have units. Empty lines and comments (`#`, `%`, `//`) are
/// counted but ignored, except for names before the first numbers.
#[derive(Debug)]
pub struct Table<R: Read, const N: usize, const M: usize> {
    rows: Rows<R>,
    separator: u8,
    record: StringRecord,
    /// Line of the record.
    line: u64,
    columns: usize,
    /// Headings; empty without names.
    names: Vec<String>,
    /// Factors of the columns to their own units, by place.
    factors: Vec<f64>,
    /// Name and index.
    required: [(&'static str, usize); N],
    /// Name, and index if the column exists.
    optional: [(&'static str, Option<usize>); M],
    has_unit: bool,
    /// A column of units, which must be metres.
    unit: Option<usize>,
}

#[derive(Debug)]
enum Rows<R: Read> {
    Text { reader: Box<csv::Reader<Lines<Bytes<R>>>>, has_header: bool },
    Given(std::vec::IntoIter<(u64, Vec<String>)>),
}

/// The finite numbers of a row, in the requested order; `None` of columns that do not exist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<const N: usize, const M: usize> {
    pub required: [f64; N],
    pub optional: [Option<f64>; M],
}

impl<R: Read, const N: usize, const M: usize> Table<R, N, M> {
    /// # Errors
    /// A file of another format, no line that names every column of `required`, or one that names a column twice.
    pub fn open(
        file: R,
        required: [&'static str; N],
        optional: [&'static str; M],
    ) -> Result<Self, TableError> {
        Self::in_order(file, required, optional, &[])
    }

    /// The same of a table that may have no names: then its columns are those of the order with as many.
    ///
    /// # Errors
    /// The errors of [`Self::open`], or columns without names that may be several things.
    pub fn in_order(
        file: R,
        required: [&'static str; N],
        optional: [&'static str; M],
        orders: &[Order],
    ) -> Result<Self, TableError> {
        let (rows, layout) = match source::open(file)? {
            Content::Text(lines, layout) => {
                let reader = ReaderBuilder::new()
                    .delimiter(layout.separator)
                    .has_headers(false)
                    .flexible(true)
                    .trim(Trim::All)
                    .terminator(Terminator::Any(b'\n'))
                    .from_reader(lines);
                (Rows::Text { reader: Box::new(reader), has_header: layout.has_header }, layout)
            }
            Content::Rows(Records { names, rows, separator }) => {
                let columns = names.as_ref().or(rows.first().map(|(_, row)| row)).map_or(0, Vec::len);
                let layout = Layout { separator, names, has_header: false, columns, counted: 0 };
                (Rows::Given(rows.into_iter()), layout)
            }
        };
        let mut table = Self {
            rows,
            separator: layout.separator,
            record: StringRecord::new(),
            line: 1,
            columns: layout.columns,
            names: Vec::new(),
            factors: vec![1.0; layout.columns],
            required: required.map(|name| (name, 0)),
            optional: optional.map(|name| (name, None)),
            has_unit: false,
            unit: None,
        };
        if layout.columns == 0 {
            return Err(table.refusal("the table is empty"));
        }
        if layout.has_header && !table.read_record()? {
            return Err(table.refusal("the table is empty"));
        }
        match layout.names {
            Some(names) if layout.has_header || orders.is_empty() => table.find_columns(names),
            // A comment may be names, or any words.
            Some(names) if required.iter().all(|name| has_heading(&names, name)) => table.find_columns(names),
            Some(_) | None => table.find_places(orders, layout.counted),
        }?;
        Ok(table)
    }

    fn find_columns(&mut self, names: Vec<String>) -> Result<(), TableError> {
        self.columns = names.len();
        self.factors = vec![1.0; self.columns];
        self.names = names;
        self.unit = self.place(&["unit", "units"]);
        let mut coordinates = Vec::new();
        let mut find = |name: &'static str| -> Result<Option<usize>, TableError> {
            let is_named =
                |(place, heading): (usize, &String)| Some((place, column::of_heading(heading, name)?));
            let mut places = self.names.iter().enumerate().filter_map(is_named);
            let Some((place, column)) = places.next() else { return Ok(None) };
            if places.next().is_some() {
                let reason = format!("the column `{name}` is there twice");
                return Err(TableError { line: self.line, reason });
            }
            let Column { factor, has_unit } =
                column.map_err(|reason| TableError { line: self.line, reason })?;
            self.factors[place] = factor;
            self.has_unit |= has_unit;
            if ["x", "y", "z"].contains(&name) {
                coordinates.push(has_unit);
            }
            Ok(Some(place))
        };
        let mut missing = Vec::new();
        for (name, place) in &mut self.required {
            match find(name)? {
                Some(found) => *place = found,
                None => missing.push(format!("`{name}`")),
            }
        }
        for (name, place) in &mut self.optional {
            *place = find(name)?;
        }
        if missing.is_empty() {
            return match coordinates.windows(2).all(|pair| pair[0] == pair[1]) {
                true => Ok(()),
                false => Err(self.refusal("only some of the columns x, y and z have a unit")),
            };
        }
        let short = |name: &String| format!("`{}`", echo::value(&name.chars().take(20).collect::<String>()));
        let own: Vec<_> = self.names.iter().take(4).map(short).collect();
        let more = if self.names.len() > own.len() { ", …" } else { "" };
        let (missing, own) = (missing.join(", "), own.join(", "));
        Err(self.refusal(format!("the column {missing} is missing; the first line has {own}{more}")))
    }

    /// Finds the columns of a table without names, of whose first rows `counted` count.
    fn find_places(&mut self, orders: &[Order], counted: usize) -> Result<(), TableError> {
        /// Rows that count by chance.
        const CHANCE: usize = 2;
        let wanted: Vec<_> = self.required.iter().map(|(name, _)| *name).collect();
        let line = if wanted.is_empty() {
            "a line of names".to_owned()
        } else {
            format!("a line `{}`", wanted.join(","))
        };
        let named = format!("{line} must stand before the numbers");
        let columns = self.columns;
        let fits = |order: &&Order| order.len() == columns && (order[0] != "#" || counted > 0);
        let Some(order) = orders.iter().find(fits) else {
            return Err(self.refusal(format!("{columns} columns without names: {named}")));
        };
        // Times may count, too.
        if !["#", "time"].contains(&order[0]) && counted > CHANCE {
            let reason = format!("the first of {columns} columns counts, and they have no names: {named}");
            return Err(self.refusal(reason));
        }
        let place = |name: &str| order.iter().position(|own| *own == name);
        self.required = self.required.map(|(name, own)| (name, place(name).unwrap_or(own)));
        self.optional = self.optional.map(|(name, _)| (name, place(name)));
        Ok(())
    }

    /// The next row; `None` at the end.
    ///
    /// # Errors
    /// A row of another length than the first, an empty value, or one that is not a finite number.
    pub fn next_row(&mut self) -> Result<Option<Row<N, M>>, TableError> {
        if !self.read_record()? {
            return Ok(None);
        }
        if self.record.len() != self.columns {
            let (own, columns) = (self.record.len(), self.columns);
            return Err(self.refusal(format!("the row has {own} values, and the columns are {columns}")));
        }
        if let Some(unit) = self.unit.map(|place| self.text(place)).filter(|unit| !["", "m"].contains(unit)) {
            let unit = echo::value(unit);
            return Err(self.refusal(format!("unit = `{unit}`: must be in the headings, as `x [{unit}]`")));
        }
        let mut row = Row { required: [0.0; N], optional: [None; M] };
        for (value, (name, place)) in row.required.iter_mut().zip(self.required) {
            *value = self.number(name, place)?;
        }
        for (value, (name, place)) in row.optional.iter_mut().zip(self.optional) {
            *value = place.map(|place| self.number(name, place)).transpose()?;
        }
        Ok(Some(row))
    }

    /// The line of the last row, counted from 1.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// An error in the last row.
    pub fn refusal(&self, reason: impl Into<String>) -> TableError {
        TableError { line: self.line, reason: reason.into() }
    }

    /// Whether an optional column exists.
    pub fn has(&self, name: &str) -> bool {
        self.optional.iter().any(|(column, place)| *column == name && place.is_some())
    }

    /// Whether a requested column's heading names its unit.
    pub fn has_unit(&self) -> bool {
        self.has_unit
    }

    /// The places of the columns of a prefix and numbers from `first`, in their order.
    ///
    /// # Errors
    /// A unit that the columns cannot have.
    pub fn series(&mut self, prefix: &str, first: usize) -> Result<Vec<usize>, TableError> {
        let mut places = Vec::new();
        loop {
            let name = format!("{prefix}{}", first + places.len());
            // They are usually in order.
            let next = places.last().map_or(0, |last| last + 1);
            let found = (next..self.columns)
                .chain(0..next)
                .find_map(|place| Some((place, column::of_heading(self.names.get(place)?, &name)?)));
            let Some((place, column)) = found else { return Ok(places) };
            self.factors[place] = column.map_err(|reason| self.refusal(reason))?.factor;
            places.push(place);
        }
    }

    /// The place of the first of some columns that exists.
    pub fn place(&self, names: &[&str]) -> Option<usize> {
        let is_named = |name: &&str| self.names.iter().position(|own| own.eq_ignore_ascii_case(name));
        names.iter().find_map(is_named)
    }

    /// A row's text in a column.
    pub fn text(&self, place: usize) -> &str {
        self.record.get(place).unwrap_or("")
    }

    /// A row's value in a column of a [`Self::series`]; `None` for `nan`.
    ///
    /// # Errors
    /// The errors of [`Self::next_row`].
    pub fn value(&self, name: &str, place: usize) -> Result<Option<f64>, TableError> {
        let is_nan = self.record[place].eq_ignore_ascii_case("nan");
        if is_nan { Ok(None) } else { self.number(name, place).map(Some) }
    }

    fn number(&self, name: &str, place: usize) -> Result<f64, TableError> {
        let text = &self.record[place];
        if text.is_empty() {
            return Err(self.refusal(format!("{name} is empty: must be a number in every row")));
        }
        let digits = text.trim_start_matches(['-', '+']);
        let is_cut =
            digits.len() > 1 && digits.starts_with('0') && digits.bytes().all(|c| c.is_ascii_digit());
        if is_cut && self.separator == b',' && column::is_measure(name) {
            let reason = format!(
                "{name} = `{}`: part of a number with a decimal comma? Separate the columns by semicolons, tabs or blanks",
                echo::value(text)
            );
            return Err(self.refusal(reason));
        }
        match layout::number(text, self.separator != b',') {
            Some(number) if number.is_finite() => Ok(number * self.factors[place]),
            Some(_) | None => {
                Err(self.refusal(format!("{name} = `{}`: not a finite number", echo::value(text))))
            }
        }
    }

    /// Whether there is another non-empty record.
    fn read_record(&mut self) -> Result<bool, TableError> {
        let (reader, has_header) = match &mut self.rows {
            Rows::Given(rows) => {
                let next = rows.next();
                if let Some((line, fields)) = &next {
                    (self.line, self.record) = (*line, StringRecord::from(fields.as_slice()));
                }
                return Ok(next.is_some());
            }
            Rows::Text { reader, has_header } => (reader, std::mem::take(has_header)),
        };
        loop {
            let read = reader.read_record(&mut self.record);
            if read.as_ref().is_ok_and(|found| !found) {
                return Ok(false);
            }
            // The reader's position is the beginning of the next line.
            self.line = reader.position().line().saturating_sub(1).max(1);
            read.map_err(|error| TableError { line: self.line, reason: reason(&error) })?;
            if self.separator == BLANK {
                let fields = self.record.iter().take_while(|field| layout::comment_of(field).is_none());
                self.record = fields.filter(|field| !field.is_empty()).collect();
                if self.record.is_empty() {
                    continue;
                }
            }
            if self.record.len() > 1 || !self.record[0].is_empty() {
                // Some programs end every row with a separator.
                while !has_header
                    && self.record.len() > self.columns
                    && self.record.iter().next_back() == Some("")
                {
                    self.record.truncate(self.record.len() - 1);
                }
                return Ok(true);
            }
        }
    }
}

fn has_heading(names: &[String], name: &str) -> bool {
    names.iter().any(|heading| column::of_heading(heading, name).is_some())
}

/// The reader's error without its position.
fn reason(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Utf8 { .. } => "this is not a text file (UTF-8)".to_owned(),
        csv::ErrorKind::Io(error) => error.to_string(),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Result<Vec<Row<2, 1>>, TableError> {
        let mut table = Table::open(text.as_bytes(), ["x", "y"], ["gain"])?;
        std::iter::from_fn(|| table.next_row().transpose()).collect()
    }

    fn row(x: f64, y: f64, gain: Option<f64>) -> Row<2, 1> {
        Row { required: [x, y], optional: [gain] }
    }

    #[test]
    fn columns_are_found_by_name_in_any_order_and_beside_others() {
        assert_eq!(rows("y, x\n1,2\n3 , 4"), Ok(vec![row(2.0, 1.0, None), row(4.0, 3.0, None)]));
        let text = "\u{feff}# by hand\r\n\r\n\"x\",remark,gain,y\r\n1,left,0.5,2\r\n\r\n-0.0,,1,1e-3\r\n";
        assert_eq!(rows(text), Ok(vec![row(1.0, 2.0, Some(0.5)), row(-0.0, 1e-3, Some(1.0))]));
        assert_eq!(rows("x,y\n"), Ok(vec![]));
    }

    #[test]
    fn columns_of_any_usual_separator_are_told_apart() {
        let both = Ok(vec![row(1.5, 2.0, None), row(-3.0, 4e-3, None)]);
        for text in [
            "x;y\n1,5;2\n-3;4e-3\n",
            "X\tY\n1.5\t2\n-3\t4e-3\n",
            "# made, by; hand\n\n  y   x\n\n 2  1.5\n4e-3 -3  \n",
            "\u{feff}x y\r\n1.5 2\r\n-3 4e-3\r\n",
        ] {
            assert_eq!(rows(text), both, "{text:?}");
        }
        assert_eq!(rows("x;y\n\n1;2;3\n").unwrap_err().line, 3);
        assert_eq!(rows("x,y\n1;5,2\n").unwrap_err().to_string(), "2: x = `1;5`: not a finite number");
    }

    #[test]
    fn errors_name_the_line_however_lines_end_and_whatever_stands_between() {
        for (text, error) in [
            ("", "1: the table is empty"),
            ("a,b\n1,2\n", "1: the column `x`, `y` is missing; the first line has `a`, `b`"),
            ("# no\n\nx,z\n", "3: the column `y` is missing; the first line has `x`, `z`"),
            ("x,y,x\n", "1: the column `x` is there twice"),
            ("x,y\n1,2\n1\n", "3: the row has 1 values, and the columns are 2"),
            ("x,y\n1,2,3\n", "2: the row has 3 values, and the columns are 2"),
            ("x,y\n\n# of\n\n1,zero", "5: y = `zero`: not a finite number"),
            ("x,y\r\n1,2\r\n\r\n1,nan\r\n", "4: y = `nan`: not a finite number"),
            ("x,y\r\n,2\r\n", "2: x is empty: must be a number in every row"),
            ("x,y,gain\n1,2,0\n1,2,\n", "3: gain is empty: must be a number in every row"),
            ("x,y\n1,\"a\nb\"\n", "3: y = `a\\nb`: not a finite number"),
        ] {
            assert_eq!(rows(text).unwrap_err().to_string(), error, "{text:?}");
        }
        let mut table = Table::<_, 1, 0>::open(&b"x\n1\n\xff\n"[..], ["x"], []).unwrap();
        table.next_row().unwrap();
        assert_eq!(table.next_row().unwrap_err().to_string(), "3: this is not a text file (UTF-8)");
        let long = format!("x,y\n1,{}\n", "9e".repeat(1000));
        assert!(rows(&long).unwrap_err().to_string().len() < 200);
    }
}
