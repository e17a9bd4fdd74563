//! A thousand hostile scenes and settings, through the library and some as runs of the program.
//!
//! `SONOGLYPH_HOSTILE=1000 cargo test --test faults crowd -- --nocapture` runs all of them as programs, with
//! statistics.

use std::fs;
use std::panic::catch_unwind;
use std::path::Path;
use std::time::{Duration, Instant};

use sonoglyph::echo;
use sonoglyph::studio::opening;

use crate::hostile::LONGEST;
use crate::hostile::generator::{Case, case};
use crate::program_after;

const CASES: u64 = 1000;
/// Number of these run as programs.
const PROGRAMS: u64 = 150;
/// KiB of writable memory of a program, including stacks.
const LIMIT: &str = "ulimit -d 204800";

fn folder_of(case: &Case) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    case.place.make(&folder.path().join(if case.is_settings { "settings.toml" } else { "a.toml" }));
    case.picture.make(&folder.path().join("picture"));
    folder
}

/// The library's error for a case, if any.
fn of_library(case: &Case, folder: &Path) -> Option<String> {
    #[cfg(feature = "window")]
    if case.is_settings {
        return sonoglyph::app::settings::Memory::at(folder).2;
    }
    opening::open(&folder.join("a.toml")).err().map(|error| error.to_string())
}

fn is_plain(message: &str) -> bool {
    !message.chars().any(|c| c != '\n' && c.is_control())
}

#[test]
fn a_thousand_hostile_scenes_and_settings_give_errors_of_one_line() {
    let mut refused = 0;
    for number in 0..CASES {
        let case = case(number);
        let folder = folder_of(&case);
        let said =
            catch_unwind(|| of_library(&case, folder.path())).unwrap_or_else(|_| panic!("case {number}"));
        if let Some(error) = said {
            let message = echo::message(&error);
            assert!(
                !message.is_empty() && message.len() < LONGEST && !message.contains('\n'),
                "case {number}"
            );
            assert!(is_plain(&message), "case {number}: {message:?}");
            refused += 1;
        }
    }
    assert!(refused > CASES / 2, "{refused} of {CASES} are hostile");
}

/// Statistics of the programs' runs.
#[derive(Default)]
struct Tally {
    refused: u64,
    longest: (usize, u64),
    slowest: (Duration, u64),
    /// KiB, if measured.
    largest: (u64, u64),
}

#[test]
fn hostile_cases_as_programs_end_with_one_message_and_status_2() {
    let asked = std::env::var("SONOGLYPH_HOSTILE").ok().and_then(|count| count.parse().ok());
    // A prime stride covers all kinds.
    let numbers = (0..asked.unwrap_or(PROGRAMS)).map(|index| index * 7 % CASES);
    let mut tally = Tally::default();
    for number in numbers {
        let case = case(number);
        if case.is_settings {
            continue;
        }
        one(number, &case, asked.is_some(), &mut tally);
    }
    assert!(tally.refused > 0);
    if asked.is_some() {
        let Tally { refused, longest, slowest, largest } = tally;
        eprintln!(
            "{refused} refused; longest message {longest:?} B, slowest {slowest:?}, largest {largest:?} KiB"
        );
    }
}

fn one(number: u64, case: &Case, is_measured: bool, tally: &mut Tally) {
    let folder = folder_of(case);
    let mut args =
        vec!["render", "a.toml", "-o", "x.png", "--quantity", "drive", "--method", "focus", "--size", "200"];
    if number.is_multiple_of(3) {
        args = vec!["solve", "a.toml", "--method", "focus", "--csv", "x.csv"];
    }
    let first = match is_measured {
        true => format!("{LIMIT}; exec timeout 60 /usr/bin/time -f %M -o peak \"$0\" \"$@\""),
        false => format!("{LIMIT}; exec timeout 60 \"$0\" \"$@\""),
    };
    let begun = Instant::now();
    let output = program_after(&first, folder.path(), &args).output().unwrap();
    let lasted = begun.elapsed();
    let said = String::from_utf8(output.stderr).unwrap_or_else(|_| panic!("case {number}: no text"));
    let peak = fs::read_to_string(folder.path().join("peak")).unwrap_or_default();
    let peak = peak.lines().last().and_then(|line| line.parse().ok()).unwrap_or(0);
    let code = output.status.code();
    assert!([Some(0), Some(2)].contains(&code), "case {number}: {:?}: {said:.2000}", output.status);
    assert!(
        said.len() < LONGEST && is_plain(&said) && !said.contains("panicked"),
        "case {number}: {said:.3000}"
    );
    if code == Some(2) {
        let errors = said.lines().filter(|line| line.starts_with("error: ")).count();
        assert_eq!(errors, 1, "case {number}: {said}");
        assert!(
            !folder.path().join("x.png").exists() && !folder.path().join("x.csv").exists(),
            "case {number}"
        );
        tally.refused += 1;
        tally.longest = tally.longest.max((said.len(), number));
        tally.slowest = tally.slowest.max((lasted, number));
        tally.largest = tally.largest.max((peak, number));
    }
}
