//! `sonoglyph batch`: scenes as JSON lines in, results as JSON lines out, in order, on all cores, in constant memory.

use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use anyhow::{Context, anyhow, bail};
use serde_json::{Value, json};

use crate::acoustics::Aperture;
use crate::cli::{BatchArgs, json, output};
use crate::drive::Drive;
use crate::field::{Evaluator, Quantity, Samples, Stages, Wanted};
use crate::picture::export;
use crate::scene::{Method, Scene, file};
use crate::solver::{self, Limits, Problem};

/// Pixels that a field may have along y.
const MOST_ROWS: usize = 1 << 14;
/// Bytes that a line may have; the largest scene has far fewer.
const LONGEST_LINE: u64 = 16 << 20;
/// Lines on their way per thread: enough that none waits for a slow one in front, few enough for little memory.
const LINES_PER_THREAD: usize = 32;

pub fn run(args: &BatchArgs) -> anyhow::Result<()> {
    if let Some(folder) = &args.data {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let task = Task {
        method: args.method,
        limits: !args.no_limits,
        field: args.field,
        data: args.data.clone(),
        size: args.size.into(),
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    write(&start(BufReader::new(std::io::stdin()), threads, task)?)
}

/// Writes answers in the order of their lines, and shows what is written before it waits.
fn write(answers: &Receiver<Receiver<Value>>) -> anyhow::Result<()> {
    let mut out = BufWriter::new(std::io::stdout().lock());
    loop {
        let answer = match answers.try_recv() {
            Err(TryRecvError::Empty) => {
                out.flush()?;
                answers.recv().ok()
            }
            answer => answer.ok(),
        };
        let Some(answer) = answer else { break };
        let value = match answer.try_recv() {
            Ok(value) => value,
            Err(_) => {
                out.flush()?;
                answer.recv().context("a worker stopped")?
            }
        };
        writeln!(out, "{value}")?;
    }
    Ok(out.flush()?)
}

/// What is done with every scene.
#[derive(Clone, Debug)]
struct Task {
    /// Instead of the scene's.
    method: Option<Method>,
    limits: bool,
    field: bool,
    /// The folder of the numbers.
    data: Option<PathBuf>,
    /// Pixels per side of a field.
    size: usize,
}

/// A line of the input, counted from 1, or why it is none.
struct Line {
    number: u64,
    text: Result<String, String>,
}

/// A line, and where its answer is waited for.
type Job = (Line, SyncSender<Value>);

/// Reads and answers on threads of their own and returns at once. The answers are promised in the order of the lines.
fn start(
    input: impl BufRead + Send + 'static,
    threads: usize,
    task: Task,
) -> anyhow::Result<Receiver<Receiver<Value>>> {
    let most = threads * LINES_PER_THREAD;
    let (promise, promises) = sync_channel(most);
    let (hand_out, jobs) = sync_channel::<Job>(most);
    let (jobs, task) = (Arc::new(Mutex::new(jobs)), Arc::new(task));
    for _ in 0..threads {
        let (jobs, task) = (Arc::clone(&jobs), Arc::clone(&task));
        thread::Builder::new().name("batch".to_owned()).spawn(move || work(&jobs, &task))?;
    }
    thread::Builder::new().name("lines".to_owned()).spawn(move || {
        for line in lines(input) {
            let (sender, receiver) = sync_channel(1);
            // Nobody may be left who reads the answers.
            if promise.send(receiver).is_err() || hand_out.send((line, sender)).is_err() {
                break;
            }
        }
    })?;
    Ok(promises)
}

/// The lines that are not empty, up to one that cannot be read.
fn lines(mut input: impl BufRead) -> impl Iterator<Item = Line> {
    let mut number = 0;
    let mut is_readable = true;
    let next = move || {
        number += 1;
        let text = if is_readable { read_line(&mut input).transpose()? } else { return None };
        is_readable = text.is_ok();
        let text = text.unwrap_or_else(|error| Err(format!("cannot read: {error}")));
        Some(Line { number, text })
    };
    std::iter::from_fn(next).filter(|line| !line.text.as_ref().is_ok_and(|text| text.trim().is_empty()))
}

/// A line, or what is wrong with it; `None` at the end. Takes little memory, whatever comes.
fn read_line(input: &mut impl BufRead) -> std::io::Result<Option<Result<String, String>>> {
    let mut bytes = Vec::new();
    input.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes)?;
    if bytes.is_empty() {
        return Ok(None);
    }
    if bytes.len() as u64 == LONGEST_LINE && bytes.last() != Some(&b'\n') {
        input.skip_until(b'\n')?;
        return Ok(Some(Err(format!("a line of more than {} MiB", LONGEST_LINE >> 20))));
    }
    Ok(Some(String::from_utf8(bytes).map_err(|error| format!("no text: {error}"))))
}

/// Answers lines until none comes any more.
fn work(jobs: &Mutex<Receiver<Job>>, task: &Task) {
    let mut stages = Stages::new(Evaluator::Cpu);
    loop {
        let job = jobs.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok((line, sender)) = job else { break };
        // A fault in one scene must not take the others with it.
        let answer = catch_unwind(AssertUnwindSafe(|| task.answer(&line, &mut stages)));
        let answer = answer.unwrap_or_else(|_| {
            stages = Stages::new(Evaluator::Cpu);
            json!({ "line": line.number, "error": "an internal error; please report the scene" })
        });
        if sender.send(answer).is_err() {
            break;
        }
    }
}

impl Task {
    fn answer(&self, line: &Line, stages: &mut Stages) -> Value {
        let mut id = None;
        let mut answer = self
            .result(line, &mut id, stages)
            .unwrap_or_else(|error| json!({ "error": format!("line {}: {error:#}", line.number) }));
        answer["line"] = line.number.into();
        if let Some(id) = id {
            answer["id"] = id;
        }
        answer
    }

    /// The result for a line; `id` is what the line calls itself.
    fn result(&self, line: &Line, id: &mut Option<Value>, stages: &mut Stages) -> anyhow::Result<Value> {
        let text = line.text.as_ref().map_err(|error| anyhow!(error.clone()))?;
        let mut tables: Value = serde_json::from_str(text).context("no JSON")?;
        let Some(keys) = tables.as_object_mut() else { bail!("a scene is an object, {{…}}") };
        *id = keys.remove("id");
        keys.entry("format").or_insert_with(|| file::FORMAT.into());
        let mut scene = file::from_tables(tables)?;
        scene.solver.method = self.method.unwrap_or(scene.solver.method);
        let solution = solver::solve(&scene)?;
        let limits =
            self.limits.then(|| Limits::new(&Problem::new(&Aperture::new(&scene), solution.foci.clone())));
        let mut answer = json::solution(&solution, limits.as_ref());
        if !solution.warnings.is_empty() {
            answer["warnings"] = json!(solution.warnings);
        }
        if self.field || self.data.is_some() {
            answer["field"] = self.field(line.number, &scene, &solution.drive, stages)?;
        }
        Ok(answer)
    }

    /// Statistics of the RMS pressure on the scene's plane, and where its numbers are.
    fn field(&self, number: u64, scene: &Scene, drive: &Drive, stages: &mut Stages) -> anyhow::Result<Value> {
        let shape = scene.plane.size.y / scene.plane.size.x;
        let (width, height) = (self.size, ((self.size as f64 * shape).round() as usize).clamp(1, MOST_ROWS));
        let aperture = Aperture::new(scene);
        let wanted = Wanted { aperture: &aperture, plane: &scene.plane, drive, width, height };
        let error = stages.map(&wanted)?.error;
        let rms: Vec<f32> = stages.read(&wanted)?.iter().map(|&p| Quantity::Rms.of(p)).collect();
        let (loudest, peak) =
            rms.iter().copied().enumerate().fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        let mean_square = rms.iter().map(|&p| f64::from(p).powi(2)).sum::<f64>() / rms.len() as f64;
        let place = Samples::on_plane(&scene.plane, width, height).context("no plane")?.point(loudest);
        let mut statistics = json!({
            "peak": peak, "at": place.to_array(), "rms": mean_square.sqrt(), "error": error,
            "width": width, "height": height,
        });
        if let Some(folder) = &self.data {
            let path = folder.join(format!("{number}.npy"));
            output::write(&path, &export::npy(&[height as u64, width as u64], &rms)?)?;
            statistics["file"] = json!(path);
        }
        Ok(statistics)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::SQRT_2;
    use std::io::Cursor;

    use super::*;

    const TASK: Task = Task { method: None, limits: true, field: false, data: None, size: 64 };

    fn answers(text: &str, threads: usize, task: &Task) -> Vec<Value> {
        let promises = start(Cursor::new(text.to_owned()), threads, task.clone()).unwrap();
        promises.iter().map(|answer| answer.recv().unwrap()).collect()
    }

    #[test]
    fn answers_keep_the_order_of_their_lines() {
        let line = |i: usize| {
            let points = if i.is_multiple_of(7) { 40 } else { 3 };
            format!(
                "{{\"id\": {i}, \"target\": [{{\"kind\": \"circle\", \"radius\": 0.02, \"points\": {points}}}]}}\n"
            )
        };
        let text: String = (0..100).map(line).collect();
        let answers = answers(&text, 3, &TASK);
        let ids: Vec<_> = answers.iter().map(|answer| answer["id"].as_u64().unwrap()).collect();
        assert_eq!(ids, (0..100).collect::<Vec<_>>());
        assert_eq!(answers[7]["foci"].as_array().unwrap().len(), 40);
        assert_eq!(answers[8]["foci"].as_array().unwrap().len(), 3);
    }

    #[test]
    fn a_line_that_is_no_scene_is_named_and_costs_nothing_else() {
        let text = [
            r#"{"target": [{"kind": "point"}]}"#,
            "",
            r#"{"target": [{"kind": "point", "at": [0, 0, -1]}], "id": "behind"}"#,
            r#"{"colour": 3}"#,
            "[1, 2",
            "[]",
            r#"{"array": {"pitch": 1e999}}"#,
            r#"{"format": 2}"#,
            r#"{"format": 1}"#,
            r#"{"target": [{"kind": "point"}]}"#,
        ]
        .join("\n");
        let answers = answers(&text, 2, &TASK);
        let errors: Vec<_> = answers.iter().map(|answer| answer["error"].as_str().unwrap_or("-")).collect();
        let parts = ["-", "target[1]", "colour", "no JSON", "object", "no JSON", "format 1", "target", "-"];
        for (error, part) in errors.iter().zip(parts) {
            assert!(error.contains(part), "{error}: {part}");
        }
        assert_eq!((answers.len(), &answers[1]["id"], &answers[1]["line"]), (9, &json!("behind"), &json!(3)));
        assert!(errors[1].starts_with("line 3: "), "{errors:?}");
    }

    #[test]
    fn bytes_that_are_no_text_and_endless_lines_are_survived() {
        let mut bytes = b"\xff\xfe\n".to_vec();
        bytes.extend(vec![b'x'; LONGEST_LINE as usize + 100]);
        bytes.extend(b"\n{}\n");
        let lines: Vec<_> = lines(Cursor::new(bytes)).collect();
        assert!(lines[0].text.as_ref().unwrap_err().starts_with("no text"));
        assert!(lines[1].text.as_ref().unwrap_err().contains("16 MiB"));
        assert_eq!((lines[2].number, lines[2].text.as_deref().unwrap(), lines.len()), (3, "{}\n", 3));
    }

    #[test]
    fn the_field_of_one_focus_peaks_there() {
        let folder = tempfile::tempdir().unwrap();
        let task = Task { field: true, data: Some(folder.path().to_owned()), size: 101, ..TASK };
        let text =
            r#"{"target": [{"kind": "point", "at": [0.01, -0.02, 0.1]}], "plane": {"size": [0.1, 0.2]}}"#;
        let [answer] = &answers(text, 1, &task)[..] else { panic!("one line") };
        let field = &answer["field"];
        let pressure = answer["foci"][0]["pressure"].as_f64().unwrap() / SQRT_2;
        assert!((field["peak"].as_f64().unwrap() / pressure - 1.0).abs() < 0.02, "{field} {pressure}");
        let at: Vec<_> = field["at"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        assert!((at[0] - 0.01).abs() < 0.002 && (at[1] + 0.02).abs() < 0.002 && (at[2] - 0.1).abs() < 0.003);
        assert_eq!((field["width"].as_u64(), field["height"].as_u64()), (Some(101), Some(202)));
        let bytes = std::fs::read(folder.path().join("1.npy")).unwrap();
        assert!(bytes.len() > 4 * 101 * 202);
    }
}
