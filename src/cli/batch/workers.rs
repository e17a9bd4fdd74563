//! Threads that answer the lines of a batch in parallel, with answers in input order and bounded memory.

use std::io::BufRead;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use serde_json::{Value, json};

use crate::cli::batch::lines::{Line, lines};
use crate::field::{Evaluator, Stages};

/// Lines in progress per thread: enough to pass a slow line, few enough for little memory.
const LINES_PER_THREAD: usize = 32;

/// A line, and the channel for its answer.
type Job = (Line, SyncSender<String>);

/// Reads and answers on its own threads. The receiver yields one receiver per line, in input order, for its answer as
/// JSON.
///
/// # Errors
/// Threads that cannot be started.
pub fn start(
    input: impl BufRead + Send + 'static,
    threads: usize,
    answer: impl Fn(&Line, &mut Stages) -> Value + Send + Sync + 'static,
) -> std::io::Result<Receiver<Receiver<String>>> {
    let most = threads * LINES_PER_THREAD;
    let (promise, promises) = sync_channel(most);
    let (hand_out, jobs) = sync_channel::<Job>(most);
    let (jobs, answer) = (Arc::new(Mutex::new(jobs)), Arc::new(answer));
    for _ in 0..threads {
        let (jobs, answer) = (Arc::clone(&jobs), Arc::clone(&answer));
        thread::Builder::new().name("batch".to_owned()).spawn(move || work(&jobs, &*answer))?;
    }
    thread::Builder::new().name("lines".to_owned()).spawn(move || {
        for line in lines(input) {
            let (sender, receiver) = sync_channel(1);
            // Fails once the reader of the answers has gone.
            if promise.send(receiver).is_err() || hand_out.send((line, sender)).is_err() {
                break;
            }
        }
    })?;
    Ok(promises)
}

/// Answers lines until the end of the input.
fn work(jobs: &Mutex<Receiver<Job>>, answer: &impl Fn(&Line, &mut Stages) -> Value) {
    let mut stages = Stages::new(Evaluator::Cpu);
    loop {
        let job = jobs.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok((line, sender)) = job else { break };
        // A panic in one scene must not end the others.
        let answer = catch_unwind(AssertUnwindSafe(|| answer(&line, &mut stages)));
        let answer = answer.unwrap_or_else(|_| {
            stages = Stages::new(Evaluator::Cpu);
            let number = line.number;
            json!({ "line": number, "error": format!("line {number}: an internal error; please report the scene") })
        });
        // Serialised here, in parallel. Fails once the reader of the answers has gone.
        if sender.send(answer.to_string()).is_err() {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::sync::Barrier;
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::time::Duration;

    use super::*;

    fn numbered(count: usize) -> Cursor<String> {
        Cursor::new((0..count).map(|i| format!("{i}\n")).collect())
    }

    fn echo(line: &Line) -> Value {
        json!(line.text.as_deref().unwrap_or_default().trim())
    }

    fn all(promises: &Receiver<Receiver<String>>) -> Vec<String> {
        promises.iter().map(|answer| answer.recv().unwrap()).collect()
    }

    #[test]
    fn answers_keep_the_order_of_their_lines() {
        // The first line is answered after the second, the third after the fourth, and so on.
        let gates: Arc<Vec<Barrier>> = Arc::new((0..50).map(|_| Barrier::new(2)).collect());
        let order = Arc::new(Mutex::new(Vec::new()));
        let done = Arc::clone(&order);
        let answer = move |line: &Line, _: &mut Stages| {
            let index = line.number as usize - 1;
            if index.is_multiple_of(2) {
                gates[index / 2].wait();
            }
            done.lock().unwrap().push(index);
            if !index.is_multiple_of(2) {
                gates[index / 2].wait();
            }
            echo(line)
        };
        let answers = all(&start(numbered(100), 2, answer).unwrap());
        assert_eq!(answers, (0..100).map(|i| format!("\"{i}\"")).collect::<Vec<_>>());
        assert!(!order.lock().unwrap().is_sorted(), "the answers were found in order");
    }

    #[test]
    fn a_panic_is_an_error_of_its_own_line() {
        let answer = |line: &Line, _: &mut Stages| {
            assert!(!line.number.is_multiple_of(3), "the third");
            echo(line)
        };
        let answers = all(&start(numbered(30), 2, answer).unwrap());
        assert_eq!(answers.len(), 30);
        for (index, answer) in answers.iter().enumerate() {
            let number = index + 1;
            let expected = if number.is_multiple_of(3) {
                json!({ "line": number, "error": format!("line {number}: an internal error; please report the scene") })
            } else {
                json!(index.to_string())
            };
            assert_eq!(*answer, expected.to_string());
        }
    }

    /// An endless input that counts the lines read from it.
    struct Endless(Arc<AtomicU64>);

    impl std::io::Read for Endless {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            let line = b"1\n";
            buffer[..2].copy_from_slice(line);
            self.0.fetch_add(1, Ordering::Relaxed);
            Ok(2)
        }
    }

    #[test]
    fn the_number_of_lines_in_progress_is_bounded() {
        const THREADS: usize = 2;
        let taken = Arc::new(AtomicU64::new(0));
        let input = std::io::BufReader::with_capacity(2, Endless(Arc::clone(&taken)));
        let promises = start(input, THREADS, |line: &Line, _: &mut Stages| echo(line)).unwrap();
        // Queues of answers and of lines, one line per worker, and one in the reading thread.
        let most = (2 * THREADS * LINES_PER_THREAD + THREADS + 1) as u64;
        for read in 1..=3 {
            promises.recv().unwrap().recv().unwrap();
            let mut before = u64::MAX;
            while taken.load(Ordering::Relaxed) != before {
                before = taken.load(Ordering::Relaxed);
                thread::sleep(Duration::from_millis(50));
            }
            assert!(before <= most + read, "{before} lines are read for {read} answers");
        }
    }
}
