//! The fuzz targets: each takes any bytes, and panics if the program breaks a promise.
//!
//! `tests/scenes/fuzz/mod.rs` runs them on the corpus and on mutations of it, and `fuzz/` under libFuzzer.

mod batch;
mod control;
mod drawing;
mod link;
mod native;
mod picture;
mod route;
mod scene;
mod settings;
mod stock;
mod tables;
mod waveform;

/// A target takes any bytes.
type Target = fn(&[u8]);

/// The targets by name; a corpus has the name of its target.
pub const TARGETS: [(&str, Target); 17] = [
    ("scene", scene::run),
    ("points", tables::points),
    ("drive", tables::drive),
    ("calibration", tables::calibration),
    ("elements", tables::elements),
    ("native", native::run),
    ("stock", stock::run),
    ("drawing", drawing::run),
    ("picture", picture::run),
    ("link", link::run),
    ("batch", batch::run),
    ("settings", settings::run),
    ("route", route::run),
    ("waveform", waveform::run),
    ("osc", control::osc),
    ("ultraino", control::ultraino),
    ("json", control::json),
];

/// Runs the target of this name.
///
/// # Panics
/// An unknown name, and failures of the target.
pub fn run(name: &str, bytes: &[u8]) {
    let (_, target) = TARGETS.iter().find(|(own, _)| *own == name).expect("no target of this name");
    target(bytes);
}

/// Asserts that a message is one non-empty line.
fn is_one_line(message: &str) {
    assert!(!message.trim().is_empty() && !message.contains('\n'), "{message:?}");
}

/// Asserts that a text has a line with this number, counted from 1.
fn has_line(bytes: &[u8], line: usize) {
    let lines = bytes.iter().filter(|&&byte| byte == b'\n').count() + 1;
    assert!((1..=lines).contains(&line), "line {line} of {lines}");
}
