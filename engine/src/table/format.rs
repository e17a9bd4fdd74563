//! Names of files that are no tables, by their first bytes, with what to do instead.

/// Beginnings of binary files.
const BINARY: [(&[u8], &str); 26] = [
    (b"\xd0\xcf\x11\xe0", "an Excel workbook (.xls): save it as CSV"),
    (b"MATLAB 5.0", "a MATLAB file (.mat): write the array with writematrix(array, 'array.csv')"),
    (b"MATLAB 7.3", "a MATLAB file (.mat): write the array with writematrix(array, 'array.csv')"),
    (b"\x89HDF", "an HDF5 file (of MATLAB, k-Wave or acoular): write the array as CSV"),
    (b"%PDF", "a PDF file"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"RIFF", "a RIFF file (WAV, WebP or AVI)"),
    (b"OggS", "an Ogg file"),
    (b"\x7fELF", "a program"),
    (b"MZ\x90", "a program"),
    (b"PAR1", "a Parquet file: write the columns as CSV"),
    (b"ARROW1", "an Arrow file: write the columns as CSV"),
    (b"FEA1", "a Feather file: write the columns as CSV"),
    (b"SQLite format 3", "an SQLite database: export the table as CSV"),
    (b"7z\xbc\xaf", "a 7z archive: unpack it"),
    (b"Rar!", "a RAR archive: unpack it"),
    (b"BZh", "a bzip2 file: unpack it"),
    (b"\xfd7zXZ", "an xz file: unpack it"),
    (b"\x28\xb5\x2f\xfd", "a Zstandard file: unpack it"),
    (b"{\\rtf", "an RTF document: save it as plain text"),
    (b"glTF", "a glTF model: its vertices are not elements"),
    (b"\x80\x04\x95", "a Python pickle: write the array with numpy.savetxt"),
];

/// Beginnings of text files, in small letters.
const TEXT: [(&str, &str); 10] = [
    ("<!doctype html", "an HTML page"),
    ("<html", "an HTML page"),
    ("solid ", "an STL model: its triangles are not elements"),
    ("ply", "a PLY model: write its vertices as CSV"),
    ("# vtk datafile", "a VTK file: write its points as CSV"),
    ("iso-10303-21", "a STEP model"),
    ("%!ps", "a PostScript file"),
    ("%%matrixmarket", "a Matrix Market file: write the array as CSV"),
    ("#!", "a script"),
    ("import ", "a Python program: run it, and write its positions as CSV"),
];

/// What a file is, if it is no table; `head` is its beginning, unpacked.
pub(crate) fn name(head: &[u8]) -> Option<String> {
    let binary = BINARY.iter().find(|(magic, _)| head.starts_with(magic)).map(|(_, name)| *name);
    if let Some(name) = binary.or_else(|| archive(head)) {
        return Some(format!("this is {name}"));
    }
    let text = String::from_utf8_lossy(head);
    let start = text.trim_start_matches(['\u{feff}', ' ', '\r', '\n', '\t']).to_lowercase();
    let is_word = |word: &str| {
        let rest = start.strip_prefix(word).unwrap_or("x");
        word.ends_with(' ') || !rest.starts_with(char::is_alphanumeric)
    };
    let named = TEXT.iter().find(|(word, _)| start.starts_with(word) && is_word(word));
    if let Some((_, name)) = named {
        return Some(format!("this is {name}"));
    }
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let first = lines.next().unwrap_or("");
    if is_scene(first) {
        return Some("this is a scene (TOML), not a table".to_owned());
    }
    if lines.nth(2).is_some_and(|places| places.starts_with('(')) {
        return Some(
            "this is a board of OpenMPD (.pat), which gives elements, wires and corrections".to_owned(),
        );
    }
    if head.contains(&0) {
        return Some("this is a binary file, not a table of text".to_owned());
    }
    None
}

/// ZIP archives are many things.
fn archive(head: &[u8]) -> Option<&'static str> {
    if !head.starts_with(b"PK\x03\x04") {
        return None;
    }
    let has = |part: &[u8]| head.windows(part.len()).any(|window| window == part);
    Some(match () {
        () if has(b"opendocument") => "an OpenDocument spreadsheet (.ods): save it as CSV",
        () if has(b"[Content_Types]") || has(b"xl/") || has(b"_rels/") => {
            "an Excel workbook (.xlsx): save it as CSV"
        }
        () if has(b".npy") => "a NumPy archive (.npz): save one array with numpy.save or numpy.savetxt",
        () => "a ZIP archive: unpack it",
    })
}

fn is_scene(line: &str) -> bool {
    let is_name =
        |name: &str| !name.is_empty() && name.chars().all(|c| c.is_ascii_alphabetic() || "_.".contains(c));
    let header = line.strip_prefix('[').and_then(|line| line.strip_suffix(']'));
    let header = header.map(|name| name.trim_matches(['[', ']', ' ']));
    let key = line.split_once('=').map_or("", |(key, _)| key.trim());
    key == "format" || header.is_some_and(is_name)
}
