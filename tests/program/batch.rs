//! `sonoglyph batch` in pipelines: answers, their order and latency, and memory.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};
use sonoglyph::scene::file;

/// A scene with a fast solution.
const SMALL: &str = r#"{"target": [{}], "array": {"rows": 2, "columns": 2}, "solver": {"method": "focus"}}"#;
/// Upper limit of every wait.
const EVER: Duration = Duration::from_secs(120);

fn start(args: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_sonoglyph"))
        .arg("batch")
        .args(args)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// The program between two pipes. Answers are read on a thread, so that a missing one is noticed.
struct Batch {
    child: Child,
    input: Option<ChildStdin>,
    answers: Receiver<String>,
}

impl Batch {
    fn new(args: &[&str]) -> Self {
        let mut child = start(args);
        let (input, output) = (child.stdin.take(), child.stdout.take().unwrap());
        Self { child, input, answers: read_lines(output) }
    }

    fn say(&mut self, text: &[u8]) {
        let input = self.input.as_mut().unwrap();
        input.write_all(text).unwrap();
        input.flush().unwrap();
    }

    fn hear(&self) -> Value {
        serde_json::from_str(&self.answers.recv_timeout(EVER).expect("no answer in time")).unwrap()
    }

    fn end(mut self) -> Vec<Value> {
        drop(self.input.take());
        let rest = self.answers.iter().map(|line| serde_json::from_str(&line).unwrap()).collect();
        assert_eq!(self.child.wait().unwrap().code(), Some(0));
        let mut said = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        assert_eq!(said, "", "no messages besides the answers");
        rest
    }
}

/// Reads every line, and buffers one.
fn read_lines(output: ChildStdout) -> Receiver<String> {
    let (sender, lines) = sync_channel(1);
    thread::Builder::new()
        .spawn(move || {
            for line in BufReader::new(output).lines() {
                if sender.send(line.unwrap()).is_err() {
                    break;
                }
            }
        })
        .unwrap();
    lines
}

fn answers(args: &[&str], input: impl Into<Vec<u8>>) -> Vec<Value> {
    let mut batch = Batch::new(args);
    let (mut stdin, input) = (batch.input.take().unwrap(), input.into());
    let writer = thread::Builder::new().spawn(move || stdin.write_all(&input)).unwrap();
    let answers = batch.end();
    writer.join().unwrap().unwrap();
    answers
}

/// Resident memory of a process, MiB.
#[cfg(target_os = "linux")]
fn resident(child: &Child) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() >> 10
}

#[test]
fn answers_are_those_of_solve() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes");
    for (index, name) in ["focus-off-centre", "points-4", "letter-i", "water-two-points", "levitated-beads"]
        .into_iter()
        .enumerate()
    {
        let path = folder.join(name).with_extension("toml");
        let mut line = serde_json::to_value(file::read(&path).unwrap()).unwrap();
        line["id"] = json!(name);
        let mut answer = answers(&[], format!("{}{line}\n", "\n".repeat(index))).pop().unwrap();
        let solve =
            Command::new(env!("CARGO_BIN_EXE_sonoglyph")).arg("solve").arg(path).arg("--json").output();
        let mut solved: Value = serde_json::from_slice(&solve.unwrap().stdout).unwrap();
        let own = answer.as_object_mut().unwrap();
        assert_eq!((own.remove("id"), own.remove("line")), (Some(json!(name)), Some(json!(index + 1))));
        assert_eq!(own.remove("warnings"), None);
        assert!(solved["quality"]["widths"].is_array());
        assert_eq!(solved.get("traps").is_some(), name == "levitated-beads", "{name}");
        for value in [&mut answer, &mut solved] {
            assert!(value["seconds"].take().is_number());
        }
        assert_eq!(answer, solved, "{name}");
    }
}

#[test]
fn options_leave_out_and_add() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("fields").display().to_string();
    let [plain] = &answers(&["--no-limits", "--threads", "1"], SMALL)[..] else { panic!("one line") };
    assert!(plain["quality"].get("bound").is_none() && plain.get("field").is_none(), "{plain}");
    let [full] = &answers(&["--data", &data, "--size", "9", "--method", "gs"], SMALL)[..] else {
        panic!("one line")
    };
    assert!(full["quality"]["bound"].is_f64() && full["method"] == "gs", "{full}");
    assert_eq!(
        (&full["field"]["width"], &full["field"]["file"]),
        (&json!(9), &json!(format!("{data}/1.npy")))
    );
    assert_eq!(fs::read_dir(data).unwrap().count(), 1);
}

#[test]
fn every_line_is_answered_at_once() {
    let mut batch = Batch::new(&[]);
    for number in 1..=5 {
        let (text, is_error) = if number == 3 { ("{", true) } else { (SMALL, false) };
        batch.say(text.as_bytes());
        batch.say(b"\n");
        // The answer comes while the input is still open.
        let answer = batch.hear();
        assert_eq!(answer.get("error").is_some(), is_error, "{answer}");
        assert_eq!(answer["line"], number);
    }
    assert_eq!(batch.end(), Vec::<Value>::new());
}

#[test]
fn invalid_lines_are_answered_in_their_place() {
    let mut input = Vec::new();
    let (long, bytes) = (vec![b'['; 3 << 20], b"\xff\xfe{}".to_vec());
    let deep = format!("{{\"id\": 1, \"target\": {}1", "[".repeat(100_000)).into_bytes();
    let lines: [(&[u8], &str); 10] = [
        (SMALL.as_bytes(), "-"),
        (&bytes, "not UTF-8"),
        (&long, "more than 1 MiB"),
        (&deep, "recursion limit"),
        (br#"{"target": [{"at": [0, 0, -1]}]}"#, "target[1]"),
        (b"null", "a scene is an object"),
        (b"", "the line is blank"),
        (b" \t\r", "the line is blank"),
        (br#"{"target": [{}], "plain": 1}"#, "plain"),
        (SMALL.as_bytes(), "-"),
    ];
    for (line, _) in &lines {
        input.extend(*line);
        input.push(b'\n');
    }
    let answers = answers(&[], input);
    assert_eq!(answers.len(), lines.len());
    for ((answer, (_, part)), number) in answers.iter().zip(lines).zip(1..) {
        let error = answer["error"].as_str().unwrap_or("-");
        assert!(error.contains(part), "{error}: {part}");
        assert!(error == "-" || error.starts_with(&format!("line {number}: ")), "{error}");
        assert_eq!(answer["line"], number);
    }
}

#[test]
fn fields_that_cannot_be_written_are_errors_of_their_lines() {
    if cfg!(target_os = "linux") {
        // Not even root can create a file there.
        let [first, second] =
            &answers(&["--data", "/proc/self/task", "--size", "4"], format!("{SMALL}\n{{}}\n"))[..]
        else {
            panic!("two lines")
        };
        let error = first["error"].as_str().unwrap();
        assert!(error.starts_with("line 1: /proc/self/task/1.npy: cannot write: "), "{error}");
        assert!(second["error"].as_str().unwrap().contains("no target"), "{second}");
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let output = start(&["--data", file.to_str().unwrap()]).wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("/file: "), "{output:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_lines() {
    const LINES: u64 = 40_000;
    for line in [SMALL, "no scene"] {
        let mut batch = Batch::new(&["--no-limits"]);
        let mut input = batch.input.take().unwrap();
        let text = format!("{line}\n").repeat(100);
        let writer = thread::Builder::new()
            .spawn(move || (0..LINES / 100).try_for_each(|_| input.write_all(text.as_bytes())))
            .unwrap();
        let mut sizes = Vec::new();
        for number in 1..=LINES {
            assert_eq!(batch.hear()["line"], number);
            if number % (LINES / 10) == 0 && number < LINES {
                sizes.push(resident(&batch.child));
            }
        }
        writer.join().unwrap().unwrap();
        assert!(batch.end().is_empty());
        let (first, last) = (sizes[0], sizes[sizes.len() - 1]);
        assert!(last <= first + 8, "{line}: {sizes:?} MiB");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn answers_do_not_pile_up_before_a_stopped_reader() {
    const LINES: u64 = 60_000;
    let mut child = start(&["--no-limits"]);
    let written = Arc::new(AtomicU64::new(0));
    let (mut input, count) = (child.stdin.take().unwrap(), Arc::clone(&written));
    let writer = thread::Builder::new()
        .spawn(move || {
            for _ in 0..LINES {
                input.write_all(SMALL.as_bytes()).unwrap();
                input.write_all(b"\n").unwrap();
                count.fetch_add(1, Ordering::Relaxed);
            }
        })
        .unwrap();
    let mut before = 0;
    while written.load(Ordering::Relaxed) != before || before == 0 {
        before = written.load(Ordering::Relaxed);
        thread::sleep(Duration::from_millis(300));
    }
    // Only pipes and work in progress are filled.
    assert!(before < LINES / 2, "{before} lines were taken, and no answer was read");
    let size = resident(&child);
    assert!(size < 200, "{size} MiB");
    let lines = read_lines(child.stdout.take().unwrap());
    for number in 1..=LINES {
        let answer: Value = serde_json::from_str(&lines.recv_timeout(EVER).unwrap()).unwrap();
        assert_eq!(answer["line"], number);
    }
    writer.join().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

/// Kills a program that runs longer than [`EVER`] while this is held, so that a test that waits for its end fails.
#[cfg(unix)]
fn limited(child: &Child) -> SyncSender<()> {
    let (held, dropped) = sync_channel(0);
    let id = child.id().to_string();
    let limit = move || {
        if dropped.recv_timeout(EVER) == Err(RecvTimeoutError::Timeout) {
            Command::new("kill").args(["-KILL", &id]).status().unwrap();
        }
    };
    thread::Builder::new().spawn(limit).unwrap();
    held
}

/// Writes lines until the pipe is closed.
fn flood(mut input: ChildStdin) {
    thread::Builder::new().spawn(move || while writeln!(input, "{SMALL}").is_ok() {}).unwrap();
}

fn holds_only_whole_files(folder: &Path) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        assert!(path.extension().is_some_and(|extension| extension == "npy"), "{} is left", path.display());
        assert_eq!(npyz::NpyFile::new(&fs::read(&path).unwrap()[..]).unwrap().shape(), [64, 64]);
    }
}

#[test]
fn a_closed_pipe_ends_it_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = start(&["--data", folder.path().to_str().unwrap(), "--size", "64"]);
    flood(child.stdin.take().unwrap());
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.starts_with('{'), "{line}");
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()), (Some(0), ""));
    holds_only_whole_files(folder.path());
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_whole_lines_and_whole_files() {
    for is_flooded in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let mut child = start(&["--data", folder.path().to_str().unwrap(), "--size", "64"]);
        let limit = limited(&child);
        let mut input = child.stdin.take().unwrap();
        writeln!(input, "{SMALL}").unwrap();
        let kept = if is_flooded {
            flood(input);
            None
        } else {
            Some(input)
        };
        let mut output = BufReader::new(child.stdout.take().unwrap());
        let mut text = String::new();
        output.read_line(&mut text).unwrap();
        let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(killed.success());
        output.read_to_string(&mut text).unwrap();
        assert!(text.ends_with('\n') && text.lines().all(|line| serde_json::from_str::<Value>(line).is_ok()));
        let ended = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(2), "{said}");
        assert_eq!(said, format!("error: interrupted after {} answers\n", text.lines().count()));
        holds_only_whole_files(folder.path());
        drop((kept, limit));
    }
}
