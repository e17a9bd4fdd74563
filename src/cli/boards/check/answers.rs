//! Answers of the person at the board, from standard input.

use std::io::{BufRead, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use anyhow::Context;

use crate::cli::interrupt::Interrupted;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    Yes,
    No,
    Again,
    Back,
    /// End of the questions: `q`, an interrupt, or the end of standard input.
    End,
}

/// Lines of standard input, read on a thread so that an interrupt need not wait for one.
#[derive(Debug)]
pub struct Answers(Option<Receiver<String>>);

impl Answers {
    pub fn new(listen: bool) -> Self {
        let (sender, lines) = sync_channel(0);
        let read = move || {
            for line in std::io::stdin().lock().lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        };
        let reads = listen && std::thread::Builder::new().name("answers".to_owned()).spawn(read).is_ok();
        Self(reads.then_some(lines))
    }

    /// Whether questions are asked.
    pub fn listen(&self) -> bool {
        self.0.is_some()
    }

    /// Repeats the question until the answer is valid.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn ask(&self, question: &str, interrupted: &Interrupted) -> anyhow::Result<Answer> {
        const POLL: Duration = Duration::from_millis(20);
        let Some(lines) = &self.0 else { return Ok(Answer::End) };
        loop {
            let mut out = std::io::stdout().lock();
            write!(out, "{question}").and_then(|()| out.flush()).context("standard output")?;
            drop(out);
            let line = loop {
                match lines.recv_timeout(POLL) {
                    Ok(line) => break line,
                    Err(RecvTimeoutError::Disconnected) => return Ok(Answer::End),
                    Err(RecvTimeoutError::Timeout) if interrupted.is_set() => return Ok(Answer::End),
                    Err(RecvTimeoutError::Timeout) => {}
                }
            };
            match line.trim() {
                "" | "y" | "yes" => return Ok(Answer::Yes),
                "n" | "no" => return Ok(Answer::No),
                "r" => return Ok(Answer::Again),
                "b" => return Ok(Answer::Back),
                "q" => return Ok(Answer::End),
                _ => {}
            }
        }
    }
}
