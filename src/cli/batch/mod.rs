//! `sonoglyph batch`: scenes as JSON lines in, results as JSON lines out, in order, on all cores, in constant memory.

pub mod lines;
pub mod task;
mod workers;

use std::io::{BufReader, BufWriter, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use anyhow::{Context, bail};

use crate::cli::BatchArgs;
use crate::cli::batch::task::Task;
use crate::cli::interrupt::{self, Interrupted};
use crate::studio::output::{self, Files};

/// How often a waiting thread looks for an interrupt.
const LOOK: Duration = Duration::from_millis(50);

pub(super) fn run(args: &BatchArgs) -> anyhow::Result<()> {
    if let Some(folder) = &args.data {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let task = Arc::new(Task {
        method: args.method,
        limits: !args.no_limits,
        field: args.field,
        data: args.data.clone(),
        size: args.size.into(),
        files: Mutex::new(Files::new()),
        ..Task::default()
    });
    let cores = || thread::available_parallelism().map_or(1, usize::from);
    let threads = args.threads.map_or_else(cores, usize::from);
    let interrupted = interrupt::watch()?;
    let worker = Arc::clone(&task);
    let answers = workers::start(BufReader::new(std::io::stdin()), threads, move |line, stages| {
        worker.answer(line, stages)
    })?;
    let written = write(&answers, output::standard()?, &interrupted);
    // The program ends now. A file that is being written is finished, and none is begun any more.
    std::mem::forget(task.writing.write());
    written
}

/// Writes answers in the order of their lines.
fn write(
    answers: &Receiver<Receiver<String>>,
    out: impl Write,
    interrupted: &Interrupted,
) -> anyhow::Result<()> {
    let mut out = BufWriter::new(out);
    let mut written = 0u64;
    while let Some(answer) = next(answers, &mut out, interrupted)?.filter(|_| !interrupted.is_set()) {
        match next(&answer, &mut out, interrupted)? {
            Some(text) => writeln!(out, "{text}").map_err(output::unsaid)?,
            None if interrupted.is_set() => break,
            None => bail!("a worker stopped after {written} answers"),
        }
        written += 1;
    }
    out.flush().map_err(output::unsaid)?;
    if interrupted.is_set() {
        bail!("interrupted after {written} answers");
    }
    Ok(())
}

/// What comes next, or nothing where nothing comes any more. What is written is shown before it is waited for.
fn next<T>(from: &Receiver<T>, out: &mut impl Write, interrupted: &Interrupted) -> anyhow::Result<Option<T>> {
    match from.try_recv() {
        Ok(value) => return Ok(Some(value)),
        Err(TryRecvError::Disconnected) => return Ok(None),
        Err(TryRecvError::Empty) => out.flush().map_err(output::unsaid)?,
    }
    while !interrupted.is_set() {
        match from.recv_timeout(LOOK) {
            Ok(value) => return Ok(Some(value)),
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
    Ok(None)
}
