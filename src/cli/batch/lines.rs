//! Lines of a possibly endless input, in bounded memory and with an error for each invalid line.

use std::io::{BufRead, Read};

/// Limit of a line in bytes; many lines are in memory at a time.
const LONGEST: u64 = 1 << 20;

/// A line of the input, counted from 1, or its error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    pub number: u64,
    pub text: Result<String, String>,
}

/// All lines, up to a read error.
pub fn lines(mut input: impl BufRead) -> impl Iterator<Item = Line> {
    let mut number = 0;
    let mut is_readable = true;
    let next = move || {
        number += 1;
        let text = if is_readable { read(&mut input).transpose()? } else { return None };
        is_readable = text.is_ok();
        let text = text.unwrap_or_else(|error| Err(format!("cannot read: {error}")));
        Some(Line { number, text })
    };
    std::iter::from_fn(next)
}

/// A line, or its error; `None` at the end.
fn read(input: &mut impl BufRead) -> std::io::Result<Option<Result<String, String>>> {
    let mut bytes = Vec::new();
    input.by_ref().take(LONGEST).read_until(b'\n', &mut bytes)?;
    if bytes.is_empty() {
        return Ok(None);
    }
    if bytes.len() as u64 == LONGEST && bytes.last() != Some(&b'\n') {
        input.skip_until(b'\n')?;
        return Ok(Some(Err(format!("a line of more than {} MiB", LONGEST >> 20))));
    }
    Ok(Some(String::from_utf8(bytes).map_err(|error| format!("not UTF-8: {error}"))))
}

#[cfg(test)]
mod tests {
    use std::io::{BufReader, Cursor};

    use super::*;

    #[test]
    fn binary_and_overlong_lines_are_errors_of_their_own() {
        let mut bytes = b"\xff\xfe\n\n \r\n".to_vec();
        bytes.extend(vec![b'x'; LONGEST as usize + 100]);
        bytes.extend(b"\n{}\n");
        bytes.extend(vec![b'y'; LONGEST as usize - 1]);
        bytes.extend(b"\n{}");
        let lines: Vec<_> = lines(Cursor::new(bytes)).collect();
        assert!(lines[0].text.as_ref().unwrap_err().starts_with("not UTF-8"));
        assert_eq!([&lines[1], &lines[2]].map(|line| line.text.as_deref()), [Ok("\n"), Ok(" \r\n")]);
        assert!(lines[3].text.as_ref().unwrap_err().contains("1 MiB"));
        assert_eq!((lines[4].number, lines[4].text.as_deref()), (5, Ok("{}\n")));
        assert!(lines[5].text.as_ref().is_ok_and(|text| text.len() == LONGEST as usize), "just short enough");
        assert_eq!((lines[6].number, lines[6].text.as_deref(), lines.len()), (7, Ok("{}"), 7));
    }

    struct Unreadable;

    impl Read for Unreadable {
        fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
            Err(std::io::Error::other("the disk is gone"))
        }
    }

    #[test]
    fn a_read_error_is_reported_once_and_ends_the_input() {
        let lines: Vec<_> = lines(BufReader::new(Cursor::new(b"{}\n").chain(Unreadable))).collect();
        assert_eq!(lines[0].text.as_deref(), Ok("{}\n"));
        assert_eq!(lines[1].text.as_deref().unwrap_err(), "cannot read: the disk is gone");
        assert_eq!((lines[1].number, lines.len()), (2, 2));
    }
}
