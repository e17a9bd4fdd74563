//! `sonoglyph batch`: solves scenes from JSON lines to JSON lines, in order, on all cores, in constant memory.

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

/// Interval of checks for an interrupt.
const POLL: Duration = Duration::from_millis(50);

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
    // Until the program exits: waits for the file being written, and lets no worker begin another.
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

/// The next value; `None` at the end or on an interrupt. Flushes `out` before it waits.
fn next<T>(from: &Receiver<T>, out: &mut impl Write, interrupted: &Interrupted) -> anyhow::Result<Option<T>> {
    match from.try_recv() {
        Ok(value) => return Ok(Some(value)),
        Err(TryRecvError::Disconnected) => return Ok(None),
        Err(TryRecvError::Empty) => out.flush().map_err(output::unsaid)?,
    }
    while !interrupted.is_set() {
        match from.recv_timeout(POLL) {
            Ok(value) => return Ok(Some(value)),
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
    Ok(None)
}
