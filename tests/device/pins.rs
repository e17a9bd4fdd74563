//! The pin files of the boards against the sites that their published files give (`tests/reference/board_pins.json`).

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

#[derive(Deserialize)]
struct Published {
    files: BTreeMap<String, Board>,
}

#[derive(Deserialize)]
struct Board {
    /// Published signal and its site by port.
    ports: BTreeMap<String, (String, String)>,
}

/// Sites by port, of lines such as `LOCATE COMP "port" SITE "site"`, `IO_LOC "port" site;` and
/// `NET "port" LOC = "site"`.
fn sites(text: &str) -> Vec<(String, String)> {
    let lines = text.lines().map(|line| line.replace([';', '='], " "));
    let of_line = |line: String| {
        let words: Vec<_> = line.split_whitespace().map(|word| word.trim_matches('"').to_owned()).collect();
        match &words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            ["LOCATE", "COMP", port, "SITE", site]
            | ["IO_LOC", port, site]
            | ["NET", port, "LOC", site, ..] => Some(((*port).to_owned(), (*site).to_owned())),
            _ => None,
        }
    };
    lines.filter_map(of_line).collect()
}

#[test]
fn pin_files_have_the_published_sites() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(folder.join("tests/reference/board_pins.json")).unwrap();
    let published: Published = serde_json::from_str(&text).unwrap();
    let boards = folder.join("gateware/boards");
    for (file, board) in &published.files {
        let ours = sites(&std::fs::read_to_string(boards.join(file)).unwrap());
        let theirs = board.ports.iter().map(|(port, (_, site))| (port.clone(), site.clone()));
        assert_eq!(ours.iter().cloned().collect::<BTreeMap<_, _>>(), theirs.collect(), "{file}");
        let mut used: Vec<_> = ours.iter().map(|(_, site)| site).collect();
        used.sort();
        used.dedup();
        assert_eq!(used.len(), ours.len(), "{file}: a site is used twice");
    }
    let pin_files =
        std::fs::read_dir(&boards).unwrap().filter_map(|folder| folder.unwrap().path().read_dir().ok());
    let is_one = |path: &Path| {
        path.extension().is_some_and(|end| ["lpf", "cst", "ucf"].iter().any(|&known| end == known))
    };
    let count = pin_files.flatten().filter(|file| is_one(&file.as_ref().unwrap().path())).count();
    assert_eq!(count, published.files.len(), "pin files without published sites");
}
