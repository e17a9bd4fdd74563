//! Numeric CSV files: columns found by name, and errors with line numbers.

use std::io::{self, BufRead, BufReader, Chain, Cursor, Read};

use csv::{ReaderBuilder, StringRecord, Terminator, Trim};

use crate::echo;

/// An error with its line, counted from 1. Displayed as `line: reason`, to follow the file's name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{line}: {reason}")]
pub struct TableError {
    pub line: u64,
    pub reason: String,
}

/// Characters that may separate columns: the first of these that the line of names has. Blanks may be repeated.
const SEPARATORS: [u8; 4] = [b',', b';', b'\t', BLANK];
const BLANK: u8 = b' ';
/// Bytes before the end of the line of names, at most.
const LONGEST_HEAD: u64 = 1 << 20;

/// The file, after the part in which the separator was found, and before a line feed: the last row ends with one,
/// too, so that the lines can be counted.
type Rows<R> = Chain<Chain<Cursor<Vec<u8>>, BufReader<R>>, &'static [u8]>;

/// A table read row by row: `N` required and `M` optional columns, in any order, besides others.
///
/// Columns are separated by commas, semicolons (numbers may then have decimal commas), tabs or blanks. Names have
/// letters of either case. Empty lines and lines that begin with `#` are counted but ignored.
#[derive(Debug)]
pub struct Table<R, const N: usize, const M: usize> {
    reader: csv::Reader<Rows<R>>,
    separator: u8,
    record: StringRecord,
    /// Line of the record.
    line: u64,
    columns: usize,
    /// Name and index.
    required: [(&'static str, usize); N],
    /// Name, and index if the column exists.
    optional: [(&'static str, Option<usize>); M],
}

/// The finite numbers of a row, in the requested order; `None` of columns that do not exist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<const N: usize, const M: usize> {
    pub required: [f64; N],
    pub optional: [Option<f64>; M],
}

impl<R: Read, const N: usize, const M: usize> Table<R, N, M> {
    /// # Errors
    /// No line that names every column of `required`, or one that names a column twice.
    pub fn open(
        csv: R,
        required: [&'static str; N],
        optional: [&'static str; M],
    ) -> Result<Self, TableError> {
        let mut csv = BufReader::new(csv);
        let unreadable = |error: io::Error| TableError { line: 1, reason: error.to_string() };
        let (head, separator) = head(&mut csv).map_err(unreadable)?;
        let reader = ReaderBuilder::new()
            .delimiter(separator)
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .comment(Some(b'#'))
            .terminator(Terminator::Any(b'\n'))
            .from_reader(Cursor::new(head).chain(csv).chain(&b"\n"[..]));
        let mut table = Self {
            reader,
            separator,
            record: StringRecord::new(),
            line: 1,
            columns: 0,
            required: required.map(|name| (name, 0)),
            optional: optional.map(|name| (name, None)),
        };
        if !table.read_record()? {
            return Err(table.refusal("the table is empty"));
        }
        table.find_columns()?;
        Ok(table)
    }

    fn find_columns(&mut self) -> Result<(), TableError> {
        self.columns = self.record.len();
        let named = |name: &str| {
            let is_named = |&place: &usize| self.record[place].eq_ignore_ascii_case(name);
            let mut places = (0..self.columns).filter(is_named);
            (places.next(), places.next().is_some())
        };
        let wanted = self.required.iter().map(|(name, _)| *name);
        if let Some(twice) = wanted.chain(self.optional.map(|(name, _)| name)).find(|name| named(name).1) {
            return Err(self.refusal(format!("the column `{twice}` is there twice")));
        }
        let missing: Vec<_> = self.required.iter().filter(|(name, _)| named(name).0.is_none()).collect();
        if !missing.is_empty() {
            let names: Vec<_> = missing.iter().map(|(name, _)| format!("`{name}`")).collect();
            return Err(self.refusal(format!("the column {} is missing", names.join(", "))));
        }
        self.required = self.required.map(|(name, place)| (name, named(name).0.unwrap_or(place)));
        self.optional = self.optional.map(|(name, _)| (name, named(name).0));
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

    /// The places of the columns `prefix0`, `prefix1` and so on. Only the line of names has them, before any row.
    pub fn series(&self, prefix: &str) -> Vec<usize> {
        let place = |name: String| self.record.iter().position(|column| column.eq_ignore_ascii_case(&name));
        (0..).map_while(|number: usize| place(format!("{prefix}{number}"))).collect()
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
        let parsed = |text: &str| match self.separator {
            b';' => text.replace(',', ".").parse::<f64>(),
            _ => text.parse::<f64>(),
        };
        match &self.record[place] {
            "" => Err(self.refusal(format!("{name} is empty: must be a number in every row"))),
            text => match parsed(text) {
                Ok(number) if number.is_finite() => Ok(number),
                _ => Err(self.refusal(format!("{name} = `{}`: not a finite number", echo::value(text)))),
            },
        }
    }

    /// Whether there is another non-empty record.
    fn read_record(&mut self) -> Result<bool, TableError> {
        loop {
            let read = self.reader.read_record(&mut self.record);
            if read.as_ref().is_ok_and(|found| !found) {
                return Ok(false);
            }
            // The reader's position is the beginning of the next line.
            self.line = self.reader.position().line().saturating_sub(1).max(1);
            read.map_err(|error| self.refusal(reason(&error)))?;
            if self.separator == BLANK {
                self.record = self.record.iter().filter(|field| !field.is_empty()).collect();
                if self.record.is_empty() {
                    continue;
                }
            }
            if self.record.len() > 1 || !self.record[0].is_empty() {
                return Ok(true);
            }
        }
    }
}

/// The beginning of a table up to the line of names, and the separator of its columns.
fn head(csv: &mut impl BufRead) -> io::Result<(Vec<u8>, u8)> {
    let mut head = Vec::new();
    loop {
        let start = head.len();
        let read = csv.by_ref().take(LONGEST_HEAD - start as u64).read_until(b'\n', &mut head)?;
        let line = head[start..].trim_ascii();
        let line = line.strip_prefix("\u{feff}".as_bytes()).unwrap_or(line);
        if read > 0 && (line.is_empty() || line.starts_with(b"#")) {
            continue;
        }
        let separator = SEPARATORS.into_iter().find(|separator| line.contains(separator));
        return Ok((head, separator.unwrap_or(SEPARATORS[0])));
    }
}

/// The reader's error without its position.
fn reason(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Utf8 { .. } => "this is not a text file (UTF-8)".to_owned(),
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
            ("a,b\n1,2\n", "1: the column `x`, `y` is missing"),
            ("# no\n\nx,z\n", "3: the column `y` is missing"),
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
