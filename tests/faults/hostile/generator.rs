//! Hostile scenes and settings, each generated from its number.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use crate::dice::Dice;
use crate::hostile::make_pipe;

const SEED: u64 = 0x1234_5678;

/// Below `count`.
fn below(dice: &mut Dice, count: usize) -> usize {
    dice.whole(0, count.max(1) as u32 - 1) as usize
}

fn byte(dice: &mut Dice) -> u8 {
    dice.whole(0, 255) as u8
}

const SETTINGS: &str = "size = [1280.0, 800.0]\nposition = [10.0, 20.0]\nmaximized = false\ntheme = \"dark\"\npanel = \"Scene\"\n\
    panel_width = 352.0\nsection = true\ncolours = \"inferno\"\ngrid = 0.005\nrecent = [\"a.toml\"]\n";
const NUMBERS: [&str; 16] = [
    "1e308",
    "-1e308",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "-9223372036854775808",
    "1e-308",
    "0",
    "-0.0",
    "18446744073709551616",
    "4294967296",
    "65537",
    "0x7fffffffffffffff",
    "1e999",
];
const VALUES: [&str; 12] = [
    "\"x\"",
    "true",
    "[]",
    "{}",
    "[[[]]]",
    "1979-05-27T07:32:00Z",
    "{ a = { b = 1 } }",
    "''",
    "[nan, nan, nan]",
    "[1, \"2\", 3]",
    "\"\"\"\n\n\"\"\"",
    "-1",
];
const ESCAPES: [&str; 5] =
    ["\\u001b[2J\\u001b]0;x\\u0007", "\\u202e\\u2066txt", "\\u0000", "\\u009b31m", "\\U000e0041\\ufeff"];
/// Keys that count something, with their tables.
const COUNTS: [(&str, &str); 13] = [
    ("array", "rows"),
    ("array", "columns"),
    ("solver", "iterations"),
    ("solver", "frames"),
    ("solver", "search"),
    ("motion", "frames"),
    ("motion", "foci"),
    ("motion", "rate"),
    ("motion", "angle"),
    ("array", "off"),
    ("plane", "size"),
    ("plane", "tolerance"),
    ("array", "frequency"),
];

fn examples() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes");
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    paths.iter().map(|path| fs::read_to_string(path).unwrap()).collect()
}

/// The object at a path where the program expects a file.
pub enum Place {
    File(Vec<u8>),
    Pipe,
    Folder,
    Nothing,
    /// A link to itself.
    Circle,
    Device,
}

impl Place {
    pub fn make(&self, path: &Path) {
        match self {
            Self::File(bytes) => fs::write(path, bytes).unwrap(),
            Self::Pipe => make_pipe(path),
            Self::Folder => fs::create_dir(path).unwrap(),
            Self::Nothing => {}
            Self::Circle => symlink(path.file_name().unwrap(), path).unwrap(),
            Self::Device => symlink("/dev/zero", path).unwrap(),
        }
    }
}

pub struct Case {
    /// The window's settings instead of a scene.
    pub is_settings: bool,
    pub place: Place,
    /// In the same folder, in place of a picture.
    pub picture: Place,
}

pub fn case(number: u64) -> Case {
    let mut dice = Dice::new(SEED, number as usize);
    let is_settings = number % 8 == 7;
    let examples = examples();
    let text =
        if is_settings { SETTINGS.to_owned() } else { examples[below(&mut dice, examples.len())].clone() };
    let picture = match below(&mut dice, 5) {
        0 => Place::Pipe,
        1 => Place::Folder,
        2 => Place::Circle,
        3 => Place::Device,
        _ => Place::File((0..below(&mut dice, 5000)).map(|_| byte(&mut dice)).collect()),
    };
    let place = match below(&mut dice, 20) {
        0 => dice.one_of(&[0, 1, 2, 3, 4]).into(),
        kind => Place::File(mutated(kind, text, &mut dice)),
    };
    Case { is_settings, place, picture }
}

impl From<usize> for Place {
    fn from(number: usize) -> Self {
        match number {
            0 => Self::Pipe,
            1 => Self::Folder,
            2 => Self::Nothing,
            3 => Self::Circle,
            _ => Self::Device,
        }
    }
}

fn mutated(kind: usize, text: String, dice: &mut Dice) -> Vec<u8> {
    let text = match kind {
        1 | 2 => with_value(&text, dice.one_of(&NUMBERS), dice),
        3 => with_value(&text, dice.one_of(&VALUES), dice),
        4 => with_surplus(&text, dice),
        5 => nested(&text, dice),
        6 => with_value(&text, &format!("\"{}\"", "x".repeat(below(dice, 1_900_000))), dice),
        7 => format!("{text}\n{} = 1\n", "k".repeat(1 + below(dice, 1_900_000))),
        8 => {
            let escape = dice.one_of(&ESCAPES);
            with_value(&text, &format!("\"{escape}\""), dice)
        }
        9 => format!("\"{}\" = 3\n{text}", dice.one_of(&ESCAPES)),
        10 => format!("{text}\n[solver]\nunknown = 1\n"),
        11 => return (0..below(dice, 100_000)).map(|_| byte(dice)).collect(),
        12 => {
            let mut bytes = text.into_bytes();
            for _ in 0..=below(dice, 20) {
                let place = below(dice, bytes.len());
                bytes[place] = byte(dice);
            }
            return bytes;
        }
        13 => return text.as_bytes()[..below(dice, text.len())].to_vec(),
        14 => {
            let (table, key) = dice.one_of(&COUNTS);
            let value = dice.one_of(&NUMBERS);
            format!("format = 1\n[[target]]\n[{table}]\n{key} = {value}\n")
        }
        15 if below(dice, 2) == 0 => {
            let (key, value) = (dice.one_of(&["time", "at", "pressure", "easing"]), dice.one_of(&NUMBERS));
            let many = format!("{{ time = 0.1, {key} = {value} }},").repeat(1 + below(dice, 2000));
            format!("format = 1\n[[target]]\n[motion]\npath = \"keyframes\"\nkeyframes = [{many}]\n")
        }
        15 => format!("format = 1\n{}", "[[target]]\n".repeat(1 + below(dice, 180_000))),
        16 => {
            let count = 1 + below(dice, 1_000_000);
            format!("format = 1\n[[target]]\n[array]\noff = [{}0]\n", "0,".repeat(count))
        }
        17 => {
            let file = dice.one_of(&["a.toml", "picture", "../..", "/dev/zero", "gone", ""]);
            format!("format = 1\n[[target]]\nkind = \"picture\"\nfile = \"{file}\"\nat = [0, 0, 0.1]\n")
        }
        18 => text.repeat(2 + below(dice, 50)),
        _ => format!("format = 1\n# {}\n", "\u{0}\u{1b}".repeat(below(dice, 4_000_000))),
    };
    text.into_bytes()
}

/// Replaces one value of the text.
fn with_value(text: &str, value: &str, dice: &mut Dice) -> String {
    let places: Vec<_> = text.match_indices(" = ").map(|(place, _)| place + 3).collect();
    let place = if places.is_empty() { text.len() } else { dice.one_of(&places) };
    let end = text[place..].find('\n').map_or(text.len(), |end| place + end);
    format!("{}{value}{}", &text[..place], &text[end..])
}

/// Adds values at the end of one list.
fn with_surplus(text: &str, dice: &mut Dice) -> String {
    let places: Vec<_> = text.match_indices(']').map(|(place, _)| place).collect();
    let place = if places.is_empty() { text.len() } else { dice.one_of(&places) };
    format!("{}{}{}", &text[..place], ", 9".repeat(1 + below(dice, 9)), &text[place..])
}

fn nested(text: &str, dice: &mut Dice) -> String {
    let depth = 1 + below(dice, 600_000);
    let (open, close) = dice.one_of(&[("[", "]"), ("{a=", "}"), ("a.", ""), ("[[", "")]);
    let ends = if below(dice, 2) == 0 { close.repeat(depth.min(400_000)) } else { String::new() };
    format!("x = {}1{ends}\n{text}", open.repeat(depth))
}
