//! The content of a table's file: unpacked, in UTF-8, by lines without comments; or the rows of another format.

use std::io::{self, BufRead, BufReader, Chain, Cursor, Read};

use flate2::read::MultiGzDecoder;

use crate::table::error::TableError;
use crate::table::layout::{self, Layout};
use crate::table::records::Records;
use crate::table::{format, json, npy, xml};

/// Bytes that tell a format.
const SNIFFED: usize = 4096;
/// First lines of numbers or names that tell a layout, and their bytes, at most.
const LINES: usize = 8;
const LONGEST_HEAD: usize = 4 << 20;
/// Limit of unpacked bytes: a packed file may claim any number.
const MOST_UNPACKED: u64 = 512 << 20;
/// Limit of files that are read as a whole: XML, JSON, NPY, UTF-16.
const MOST_WHOLE: u64 = 256 << 20;
const GZIP: &[u8] = b"\x1f\x8b";
const UTF_8: &[u8] = "\u{feff}".as_bytes();

/// What a file has.
pub(crate) enum Content<R: Read> {
    Text(Lines<Bytes<R>>, Layout),
    Rows(Records),
}

/// The file, after the part that told its format.
pub(crate) type Bytes<R> = BufReader<Chain<Cursor<Vec<u8>>, Unpacked<R>>>;

/// A file, or the content of a packed one.
#[derive(Debug)]
pub(crate) enum Unpacked<R: Read> {
    Plain(Chain<Cursor<Vec<u8>>, R>),
    Gzip(Box<MultiGzDecoder<Chain<Cursor<Vec<u8>>, R>>>, u64),
    /// Nothing more.
    Done,
}

impl<R: Read> Read for Unpacked<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(file) => file.read(buffer),
            Self::Gzip(file, left) => {
                let read = file.read(buffer)?;
                *left = left.checked_sub(read as u64).ok_or_else(|| {
                    io::Error::other(format!("more than {} MiB when unpacked", MOST_UNPACKED >> 20))
                })?;
                Ok(read)
            }
            Self::Done => Ok(0),
        }
    }
}

/// # Errors
/// An unreadable file, or one of another format, which the message names.
pub(crate) fn open<R: Read>(mut file: R) -> Result<Content<R>, TableError> {
    let refused = |error: io::Error| TableError::of_file(error.to_string());
    let start = beginning(&mut file).map_err(refused)?;
    let is_packed = start.starts_with(GZIP);
    let file = Cursor::new(start).chain(file);
    let mut file = match is_packed {
        true => Unpacked::Gzip(Box::new(MultiGzDecoder::new(file)), MOST_UNPACKED),
        false => Unpacked::Plain(file),
    };
    let in_gzip = |error: io::Error| match is_packed {
        true => TableError::of_file(format!("a broken gzip file: {error}")),
        false => refused(error),
    };
    let mut head = beginning(&mut file).map_err(in_gzip)?;
    if let Some(order) = of_utf_16(&head) {
        head = utf_8(&whole(head, &mut file).map_err(in_gzip)?, order);
        file = Unpacked::Done;
    }
    if let Some(name) = format::name(&head) {
        return Err(TableError::of_file(name));
    }
    let is_array = head.starts_with(npy::MAGIC);
    let first = head.strip_prefix(UTF_8).unwrap_or(&head).trim_ascii_start().first().copied();
    if is_array || matches!(first, Some(b'<' | b'{' | b'[')) {
        let bytes = whole(head, &mut file).map_err(in_gzip)?;
        if is_array {
            return npy::table(&bytes).map(Content::Rows).map_err(TableError::of_file);
        }
        let text = String::from_utf8_lossy(bytes.strip_prefix(UTF_8).unwrap_or(&bytes));
        let rows = if first == Some(b'<') { xml::table(&text) } else { json::table(&text) };
        return rows.map(Content::Rows).map_err(|(line, reason)| TableError { line, reason });
    }
    let mut file = BufReader::new(file);
    let is_whole = read_lines(&mut head, &mut file).map_err(in_gzip)?;
    let complete = head.iter().rposition(|&byte| byte == b'\n').filter(|_| !is_whole);
    let text = String::from_utf8_lossy(&head[..complete.unwrap_or(head.len())]);
    let text = if text.contains('\n') { text } else { text.replace('\r', "\n").into() };
    let layout = layout::of(&text);
    if is_whole && let Some(rows) = layout::in_columns(&text, &layout) {
        return Ok(Content::Rows(rows));
    }
    let ends_with_return = !head.contains(&b'\n') && head.contains(&b'\r');
    // What the reader above has taken stands before what it left.
    let buffered = file.buffer().to_vec();
    head.extend(buffered);
    let bytes = BufReader::new(Cursor::new(head).chain(file.into_inner()));
    Ok(Content::Text(Lines::new(bytes, layout.separator == layout::BLANK, ends_with_return), layout))
}

fn beginning(file: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    file.take(SNIFFED as u64).read_to_end(&mut head)?;
    Ok(head)
}

/// All bytes.
fn whole(mut head: Vec<u8>, file: &mut impl Read) -> io::Result<Vec<u8>> {
    file.take(MOST_WHOLE).read_to_end(&mut head)?;
    match head.len() as u64 >= MOST_WHOLE {
        true => Err(io::Error::other(format!("more than {} MiB", MOST_WHOLE >> 20))),
        false => Ok(head),
    }
}

/// Adds the first lines with content. Returns whether these are all.
fn read_lines(head: &mut Vec<u8>, file: &mut impl BufRead) -> io::Result<bool> {
    // The first of them may end anywhere.
    let mut last = head.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
    let has_content = |line: &[u8]| {
        let line = String::from_utf8_lossy(line);
        let line = line.trim_matches(['\u{feff}', ' ', '\r', '\n', '\t']);
        !line.is_empty() && layout::comment_of(line).is_none()
    };
    let mut lines = head[..last].split(|&byte| byte == b'\n').filter(|line| has_content(line)).count();
    while lines < LINES && head.len() < LONGEST_HEAD {
        let room = (LONGEST_HEAD - head.len()) as u64;
        let read = file.by_ref().take(room).read_until(b'\n', head)?;
        if read == 0 {
            return Ok(true);
        }
        lines += usize::from(has_content(&head[last..]));
        last = head.len();
    }
    Ok(false)
}

/// The order of bytes.
#[derive(Clone, Copy)]
enum Order {
    Little,
    Big,
}

/// The order of a text of UTF-16: by its mark, or by the zeros beside its letters.
fn of_utf_16(head: &[u8]) -> Option<Order> {
    let is_letter = |byte: u8| byte == b'\n' || byte == b'\r' || (b' '..=b'~').contains(&byte);
    let is_all = |zero: usize| {
        head.len() >= 8 && head[..8].chunks_exact(2).all(|pair| pair[zero] == 0 && is_letter(pair[1 - zero]))
    };
    match head {
        [0xff, 0xfe, ..] => Some(Order::Little),
        [0xfe, 0xff, ..] => Some(Order::Big),
        _ if is_all(1) => Some(Order::Little),
        _ if is_all(0) => Some(Order::Big),
        _ => None,
    }
}

fn utf_8(bytes: &[u8], order: Order) -> Vec<u8> {
    let unit = |pair: &[u8; 2]| match order {
        Order::Little => u16::from_le_bytes(*pair),
        Order::Big => u16::from_be_bytes(*pair),
    };
    let units: Vec<_> = bytes.as_chunks::<2>().0.iter().map(unit).collect();
    String::from_utf16_lossy(&units).trim_start_matches('\u{feff}').to_owned().into_bytes()
}

/// The lines of a text: comments are empty lines, the last line ends, too, and between blanks there are no tabs.
#[derive(Debug)]
pub(crate) struct Lines<B> {
    bytes: B,
    has_blanks: bool,
    end: u8,
    is_first: bool,
    line: Vec<u8>,
    /// Bytes of the line that are read.
    read: usize,
}

impl<B: BufRead> Lines<B> {
    fn new(bytes: B, has_blanks: bool, ends_with_return: bool) -> Self {
        let end = if ends_with_return { b'\r' } else { b'\n' };
        Self { bytes, has_blanks, end, is_first: true, line: Vec::new(), read: 0 }
    }

    /// Whether there is another line.
    fn advance(&mut self) -> io::Result<bool> {
        self.line.clear();
        self.read = 0;
        if self.bytes.read_until(self.end, &mut self.line)? == 0 {
            return Ok(false);
        }
        if std::mem::take(&mut self.is_first) && self.line.starts_with(UTF_8) {
            self.line.drain(..UTF_8.len());
        }
        if self.line.ends_with(&[self.end]) {
            self.line.pop();
        }
        let text = self.line.trim_ascii_start();
        if layout::COMMENTS.iter().any(|marker| text.starts_with(marker.as_bytes())) {
            self.line.clear();
        }
        if self.has_blanks {
            self.line.iter_mut().filter(|byte| **byte == b'\t').for_each(|byte| *byte = b' ');
        }
        self.line.push(b'\n');
        Ok(true)
    }
}

impl<B: BufRead> Read for Lines<B> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut written = 0;
        while written < buffer.len() {
            if self.read == self.line.len() && !self.advance()? {
                break;
            }
            let count = (self.line.len() - self.read).min(buffer.len() - written);
            buffer[written..written + count].copy_from_slice(&self.line[self.read..self.read + count]);
            self.read += count;
            written += count;
        }
        Ok(written)
    }
}
