//! `sonoglyph batch`: solves scenes from JSON lines to JSON lines, in order, on all cores, in constant memory.

pub mod lines;
pub mod task;
mod workers;

use std::io::{BufReader, BufWriter, Write};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use anyhow::{Context, bail};
use clap::Args;

use crate::cli::batch::task::Task;
use crate::cli::interrupt::{self, Interrupted};
use crate::cli::names;
use crate::scene::Method;
use crate::studio::output::{self, Files};

/// Interval of checks for an interrupt.
const POLL: Duration = Duration::from_millis(50);

#[derive(Debug, Args)]
pub struct BatchArgs {
    /// Solver method, instead of the scenes'
    #[arg(long, value_parser = names::method())]
    pub method: Option<Method>,
    /// Omit what takes longer than the drive: bound, side lobe, traps and, without --field, widths
    #[arg(long)]
    pub no_limits: bool,
    /// Add peak, its position and the mean of the RMS pressure on the scene's plane
    #[arg(long)]
    pub field: bool,
    /// Also write the RMS pressure on the plane: FOLDER/LINE.npy, float32, row 0 at the smallest y; implies --field
    #[arg(long, value_name = "FOLDER")]
    pub data: Option<PathBuf>,
    /// Threads [default: number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Pixels of the field along x
    #[arg(long, value_name = "W", default_value_t = 256, value_parser = clap::value_parser!(u16).range(2..=4096))]
    pub size: u16,
}

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
