//! Board tests that were left, in a file beside the settings: each of a board at a port, to be continued in a later run.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::device::calibration::Calibration;
use crate::device::port;
use crate::device::profile::Profile;
use crate::scene::strict::Strict;
use crate::source;
use crate::studio::bring_up::{Finding, Report};
use crate::studio::output;
use crate::ui::board::BoardForm;
use crate::ui::bring_up::{BringUp, KeptTest, Step};

/// Bytes of the file, at most.
const MOST_BYTES: u64 = 1 << 20;
/// Tests that are kept, the newest last.
const MOST: usize = 20;
/// Elements that marks are read for.
const MOST_ELEMENTS: usize = 1 << 16;

/// The file's contents.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct Tests {
    test: Vec<Row>,
}

/// A test, with its marks as a letter per element: `y` signal, `n` none, `-` not tested.
#[derive(Debug, Serialize, Deserialize)]
struct Row {
    port: String,
    board: String,
    step: Step,
    element: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    baud: Option<u32>,
    marks: String,
    file: String,
    findings: Vec<Finding>,
}

impl Row {
    fn of(kept: &KeptTest) -> Self {
        let KeptTest { port, profile, run } = kept;
        Self {
            port: port.clone(),
            board: profile.name().to_owned(),
            step: run.step,
            element: run.element,
            baud: run.baud,
            marks: run
                .signals
                .iter()
                .map(|mark| mark.map_or('-', |seen| if seen { 'y' } else { 'n' }))
                .collect(),
            file: run.file.clone(),
            findings: run.report.findings.clone(),
        }
    }

    fn test(self) -> Option<KeptTest> {
        let profile = Profile::of_name(&self.board)?;
        let mark = |letter| match letter {
            'y' => Some(true),
            'n' => Some(false),
            _ => None,
        };
        let mut run = BringUp {
            step: self.step,
            element: self.element,
            baud: self.baud,
            signals: self.marks.chars().take(MOST_ELEMENTS).map(mark).collect(),
            file: self.file,
            report: Report { findings: self.findings },
            ..BringUp::default()
        };
        run.start_from(Calibration::default());
        Some(KeptTest { port: self.port, profile, run })
    }
}

/// The tests that outlive the program: those that were left, and the running one. A virtual board does not.
pub fn lasting(board: &BoardForm) -> Vec<KeptTest> {
    let running = board.bring_up.as_deref().filter(|run| run.has_results());
    let running = running.map(|run| KeptTest {
        port: board.port().to_owned(),
        profile: board.profile,
        run: run.clone(),
    });
    let is_other = |kept: &&KeptTest| {
        running.as_ref().is_none_or(|own| (&own.port, own.profile) != (&kept.port, kept.profile))
    };
    let is_real = |kept: &KeptTest| Path::new(&kept.port) != port::virtual_board(kept.profile);
    let mut all: Vec<_> = board.tests.iter().filter(is_other).cloned().collect();
    all.extend(running);
    all.retain(is_real);
    let old = all.len().saturating_sub(MOST);
    all.split_off(old)
}

fn file(folder: &Path) -> PathBuf {
    folder.join("board-tests.toml")
}

/// The tests in this folder's file; none if there is no file or it is broken.
pub fn read(folder: &Path) -> Vec<KeptTest> {
    let Ok(text) = source::read_text(&file(folder), MOST_BYTES) else { return Vec::new() };
    let tests = toml::Deserializer::parse(&text).and_then(|table| Tests::deserialize(Strict(table)));
    tests.unwrap_or_default().test.into_iter().filter_map(Row::test).collect()
}

/// Writes the tests; without any, removes the file.
pub fn write(folder: &Path, tests: &[KeptTest]) {
    let path = file(folder);
    if tests.is_empty() {
        return source::remove(&path);
    }
    let rows = Tests { test: tests.iter().map(Row::of).collect() };
    // If writing fails, the next run starts without them.
    if let Ok(text) = toml::to_string(&rows) {
        let _ = std::fs::create_dir_all(folder);
        let _ = output::refuse_stream(&path).and_then(|()| output::write(&path, text.as_bytes()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::wiring::Wiring;
    use crate::studio::bring_up::Verdict;

    #[test]
    fn a_test_survives_the_program_a_virtual_one_not() {
        let folder = tempfile::tempdir().unwrap();
        let mut run = BringUp { step: Step::Elements, baud: Some(3_000_000), ..BringUp::default() };
        run.report.note(Verdict::Passed, "a board answers");
        let wiring = Wiring::own(Profile::SonicSurface);
        run.mark(0..40, &wiring, true);
        run.mark([40, 42], &wiring, false);
        let mut board = BoardForm { port: "/dev/ttyUSB0".to_owned(), ..BoardForm::default() };
        board.profile = Profile::SonicSurface;
        board.bring_up = Some(Box::new(run.clone()));
        write(folder.path(), &lasting(&board));
        let [read] = &read(folder.path())[..] else { panic!("no test") };
        assert_eq!(
            (read.port.as_str(), read.profile, &read.run),
            ("/dev/ttyUSB0", Profile::SonicSurface, &run)
        );
        assert_eq!(read.run.calibration.off(), [40, 42]);
        board.virtual_port = Some(port::virtual_board(Profile::SonicSurface).display().to_string());
        write(folder.path(), &lasting(&board));
        assert!(self::read(folder.path()).is_empty());
    }
}
