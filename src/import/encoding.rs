//! The text of an SVG file: unpacked, and in the encoding that its byte order mark or its declaration names.

use std::borrow::Cow;
use std::io::Read;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use crate::import::drawing::{ImportError, MOST_BYTES};

/// Bytes at the beginning of a file that hold the declaration.
const HEAD: usize = 400;

/// The file without its gzip packing (`.svgz`), if it has one.
///
/// # Errors
/// A broken packing, or a content larger than files may be.
pub fn unpacked(bytes: &[u8]) -> Result<Cow<'_, [u8]>, ImportError> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut content = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes)
        .take(MOST_BYTES as u64 + 1)
        .read_to_end(&mut content)
        .map_err(|error| ImportError::Compressed(error.to_string()))?;
    if content.len() > MOST_BYTES {
        return Err(ImportError::TooLarge(content.len()));
    }
    Ok(Cow::Owned(content))
}

/// The text of XML. Without a mark and a declaration it is UTF-8, or Windows-1252 if it is not valid as such.
///
/// # Errors
/// An unknown encoding, or bytes that it has not.
pub fn text(bytes: &[u8]) -> Result<Cow<'_, str>, ImportError> {
    let (encoding, skipped) = match Encoding::for_bom(bytes) {
        Some((encoding, length)) => (encoding, length),
        None => (declared(bytes)?, 0),
    };
    let (text, has_errors) = encoding.decode_without_bom_handling(&bytes[skipped..]);
    if !has_errors {
        return Ok(text);
    }
    if encoding == UTF_8 && skipped == 0 {
        if bytes.contains(&0) {
            return Err(ImportError::UnknownFormat);
        }
        return Ok(WINDOWS_1252.decode_without_bom_handling(bytes).0);
    }
    Err(ImportError::Svg(format!("it is not {}, as it says", encoding.name())))
}

fn declared(bytes: &[u8]) -> Result<&'static Encoding, ImportError> {
    match bytes {
        [b'<', 0, ..] => return Ok(UTF_16LE),
        [0, b'<', ..] => return Ok(UTF_16BE),
        _ => {}
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD)]).into_owned();
    let declaration = head.trim_start().strip_prefix("<?xml").and_then(|rest| rest.split_once("?>"));
    let Some((_, value)) = declaration.and_then(|(inside, _)| inside.split_once("encoding")) else {
        return Ok(UTF_8);
    };
    let value = value.trim_start().trim_start_matches('=').trim_start();
    let quote = value.chars().next().filter(|letter| matches!(letter, '"' | '\''));
    let Some(name) = quote.and_then(|quote| value[1..].split(quote).next()) else { return Ok(UTF_8) };
    match Encoding::for_label(name.as_bytes()) {
        // A declaration that can be read byte by byte is not in UTF-16: whoever recoded the file left it.
        Some(encoding) if [UTF_16LE, UTF_16BE].contains(&encoding) => Ok(UTF_8),
        Some(encoding) => Ok(encoding),
        None => Err(ImportError::Svg(format!("its encoding {name:?} is unknown: save it as UTF-8"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_give_the_same_text() {
        let wide = |big: bool, mark: bool| {
            let text = format!("{}<svg id='Größe'/>", if mark { "\u{feff}" } else { "" });
            let bytes = |unit: u16| if big { unit.to_be_bytes() } else { unit.to_le_bytes() };
            text.encode_utf16().flat_map(bytes).collect::<Vec<_>>()
        };
        for (big, mark) in [(false, true), (true, true), (false, false), (true, false)] {
            assert_eq!(text(&wide(big, mark)).unwrap(), "<svg id='Größe'/>");
        }
        let narrow = |head: &str| [head.as_bytes(), b"<svg id='Gr\xf6\xdfe'/>"].concat();
        for head in ["<?xml version='1.0' encoding = \"ISO-8859-1\"?>", "<?xml encoding='windows-1252'?>", ""]
        {
            assert_eq!(text(&narrow(head)).unwrap(), format!("{head}<svg id='Größe'/>"));
        }
        let error = text(b"<?xml encoding='klingon'?>").unwrap_err().to_string();
        assert!(error.contains("klingon"), "{error}");
    }
}
