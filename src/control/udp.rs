//! The UDP sockets of OSC and of Ultraino's commands: a thread each, which decodes, applies and replies.

use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::control::desk::Desk;
use crate::control::edit::Edit;
use crate::control::gate::Gate;
use crate::control::limiter::Limiter;
use crate::control::osc::{self, Word};
use crate::control::ultraino::{self, Draft};

/// Interval at which a thread checks for its end.
const LOOK: Duration = Duration::from_millis(50);
/// The same while clients wait for an answer.
const SOON: Duration = Duration::from_millis(1);
/// Limits of answers per second: errors, states, and rebuffs without the token.
const ERRORS: f64 = 50.0;
const STATES: f64 = 200.0;
const REBUFFS: f64 = 5.0;
/// A state is answered once the preceding changes are solved, or after this time.
const PATIENCE: Duration = Duration::from_millis(100);
/// Limit of clients waiting for a state.
const MOST_WAITING: usize = 64;

/// A socket with its desk, gate and rate limits.
struct Post {
    socket: UdpSocket,
    desk: Arc<Desk>,
    gate: Arc<Gate>,
    errors: Limiter,
    rebuffs: Limiter,
}

impl Post {
    fn new(socket: UdpSocket, desk: Arc<Desk>, gate: Arc<Gate>) -> io::Result<Self> {
        socket.set_read_timeout(Some(LOOK))?;
        let (errors, rebuffs) = (Limiter::new(ERRORS), Limiter::new(REBUFFS));
        Ok(Self { socket, desk, gate, errors, rebuffs })
    }

    /// The next packet within the timeout; `None` after other errors.
    fn next(&self, bytes: &mut [u8]) -> Option<(usize, SocketAddr)> {
        match self.socket.recv_from(bytes) {
            Ok(packet) => {
                self.desk.counts.packets.add();
                Some(packet)
            }
            Err(error) => {
                // Some systems report closed ports of earlier recipients this way.
                let is_usual = matches!(
                    error.kind(),
                    ErrorKind::WouldBlock
                        | ErrorKind::TimedOut
                        | ErrorKind::Interrupted
                        | ErrorKind::ConnectionReset
                );
                if !is_usual {
                    std::thread::sleep(LOOK);
                }
                None
            }
        }
    }

    fn answer(&self, to: SocketAddr, bytes: &[u8], may: bool) {
        if may && !bytes.is_empty() && self.socket.send_to(bytes, to).is_ok() {
            self.desk.counts.answers.add();
        } else {
            self.desk.counts.unanswered.add();
        }
    }

    fn refuse(&mut self, to: SocketAddr, bytes: &[u8]) {
        let may = self.errors.takes(Instant::now());
        self.answer(to, bytes, may);
    }

    /// An answer to an unknown sender, whose address may be forged.
    fn rebuff(&mut self, to: SocketAddr, bytes: &[u8]) {
        self.desk.counts.strangers.add();
        let may = self.rebuffs.takes(Instant::now());
        self.answer(to, bytes, may);
    }
}

/// Listens for OSC until the desk closes.
///
/// # Errors
/// A system without another thread.
pub fn osc(socket: UdpSocket, desk: Arc<Desk>, gate: Arc<Gate>) -> io::Result<JoinHandle<()>> {
    let mut post = Post::new(socket, desk, gate)?;
    let listen = move || {
        let mut bytes = vec![0; osc::LONGEST + 1];
        let mut waiting = Waiting { states: Limiter::new(STATES), who: VecDeque::new() };
        while !post.desk.is_closing() {
            if let Some((length, from)) = post.next(&mut bytes) {
                hear_osc(&mut post, &bytes[..length], from, &mut waiting);
            }
            waiting.serve(&post);
        }
    };
    std::thread::Builder::new().name("osc".to_owned()).spawn(listen)
}

/// A client waiting for the state: address, change, and time.
struct Waiting {
    states: Limiter,
    who: VecDeque<(SocketAddr, u64, Instant)>,
}

impl Waiting {
    fn add(&mut self, who: SocketAddr, post: &Post) {
        if self.who.len() >= MOST_WAITING || !self.states.takes(Instant::now()) {
            return post.desk.counts.unanswered.add();
        }
        if self.who.is_empty() {
            // A failure only delays the answer.
            let _ = post.socket.set_read_timeout(Some(SOON));
        }
        self.who.push_back((who, post.desk.generation(), Instant::now()));
    }

    fn serve(&mut self, post: &Post) {
        if self.who.is_empty() {
            return;
        }
        let report = post.desk.report();
        self.who.retain(|&(who, generation, since)| {
            let is_due = report.solved >= generation || since.elapsed() > PATIENCE;
            if is_due {
                post.answer(who, &osc::state(&report), true);
            }
            !is_due
        });
        if self.who.is_empty() {
            let _ = post.socket.set_read_timeout(Some(LOOK));
        }
    }
}

fn hear_osc(post: &mut Post, bytes: &[u8], from: SocketAddr, waiting: &mut Waiting) {
    let words = match osc::words(bytes) {
        Ok(words) => words,
        Err(_) if !post.gate.knows(from) => return post.rebuff(from, &osc::error(NO_TOKEN)),
        Err(text) => {
            post.desk.counts.malformed.add();
            return post.refuse(from, &osc::error(&text));
        }
    };
    let mut edits: Vec<Edit> = Vec::new();
    let mut wants_state = false;
    for word in words {
        match word {
            Word::Token(token) => {
                if post.gate.token().is_some() && !post.gate.admit(from, &token) {
                    return post.rebuff(from, &osc::error("this is not the token"));
                }
            }
            Word::Edit(edit) => edits.push(edit),
            Word::State => wants_state = true,
        }
    }
    if !post.gate.knows(from) {
        return post.rebuff(from, &osc::error(NO_TOKEN));
    }
    if !edits.is_empty()
        && let Err(error) = post.desk.change(&edits)
    {
        post.refuse(from, &osc::error(&error.to_string()));
    }
    if wants_state {
        waiting.add(from, post);
    }
}

const NO_TOKEN: &str = "give the token first: /sonoglyph/token";

/// Listens for Ultraino's words until the desk closes.
///
/// # Errors
/// A system without another thread.
pub fn ultraino(socket: UdpSocket, desk: Arc<Desk>, gate: Arc<Gate>) -> io::Result<JoinHandle<()>> {
    let mut post = Post::new(socket, desk, gate)?;
    let listen = move || {
        let mut bytes = vec![0; ultraino::LONGEST + 1];
        let mut draft = Draft::default();
        while !post.desk.is_closing() {
            if let Some((length, from)) = post.next(&mut bytes) {
                hear_ultraino(&mut post, &bytes[..length], from, &mut draft);
            }
        }
    };
    std::thread::Builder::new().name("ultraino".to_owned()).spawn(listen)
}

fn hear_ultraino(post: &mut Post, bytes: &[u8], from: SocketAddr, draft: &mut Draft) {
    if !post.gate.knows_host(from.ip()) {
        return post.rebuff(from, b"ERR the token is missing");
    }
    let refusal = match draft.take(bytes) {
        Ok(None) => None,
        Ok(Some(edits)) => post.desk.change(&edits).err().map(|error| error.to_string()),
        Err(text) => {
            post.desk.counts.malformed.add();
            Some(text)
        }
    };
    if let Some(text) = refusal {
        post.refuse(from, format!("ERR {}", crate::echo::message(&text)).as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::report::Report;
    use crate::scene::Scene;

    /// A post whose desk has no loop, so that no change is ever reported as solved.
    fn post(listen: [u8; 4]) -> Post {
        let desk = Arc::new(Desk::new(Arc::new(Scene::default()), Box::new(|| {})));
        let gate = Arc::new(Gate::new(listen.into(), None).unwrap());
        Post::new(UdpSocket::bind("127.0.0.1:0").unwrap(), desk, gate).unwrap()
    }

    fn waiting() -> Waiting {
        Waiting { states: Limiter::new(STATES), who: VecDeque::new() }
    }

    fn client() -> (UdpSocket, SocketAddr) {
        let client = UdpSocket::bind("127.0.0.1:0").unwrap();
        client.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let address = client.local_addr().unwrap();
        (client, address)
    }

    #[test]
    fn so_many_wait_for_a_state_and_all_have_it_once_the_changes_are_solved() {
        let (post, mut waiting, (client, address)) = (post([127, 0, 0, 1]), waiting(), client());
        // As the system rounds it.
        let timeout = || post.socket.read_timeout().unwrap().unwrap();
        let usual = timeout();
        for count in 1..=MOST_WAITING + 6 {
            waiting.add(address, &post);
            assert_eq!(waiting.who.len(), count.min(MOST_WAITING));
            assert!(timeout() < usual, "an answer is looked for more often");
        }
        assert_eq!(post.desk.counts.unanswered.get(), 6);
        let generation = post.desk.generation();
        post.desk.tell(Report { generation, solved: generation, ..Report::default() });
        waiting.serve(&post);
        assert_eq!((waiting.who.len(), post.desk.counts.answers.get()), (0, MOST_WAITING as u64));
        assert_eq!(timeout(), usual);
        let state = osc::state(&post.desk.report());
        for _ in 0..MOST_WAITING {
            let mut bytes = [0; 1024];
            let length = client.recv(&mut bytes).unwrap();
            assert_eq!(bytes[..length], state);
        }
    }

    #[test]
    fn only_a_patient_client_gets_a_state_from_before_its_change() {
        let (post, mut waiting, (_client, address)) = (post([127, 0, 0, 1]), waiting(), client());
        let now = Instant::now();
        let generation = post.desk.generation();
        waiting.who.push_back((address, generation, now.checked_sub(2 * PATIENCE).unwrap()));
        // This one has not even asked yet.
        waiting.who.push_back((address, generation, now + Duration::from_secs(3600)));
        waiting.serve(&post);
        assert_eq!((waiting.who.len(), post.desk.counts.answers.get()), (1, 1));
    }

    #[test]
    fn bytes_that_are_no_osc_are_counted_and_refused() {
        let (mut post, mut waiting, (_client, address)) = (post([127, 0, 0, 1]), waiting(), client());
        hear_osc(&mut post, b"no OSC", address, &mut waiting);
        let tally = post.desk.counts.tally();
        assert_eq!((tally.malformed, tally.answers, tally.refused), (1, 1, 0));
    }

    #[test]
    fn strangers_change_nothing_by_either_protocol() {
        let (mut post, mut waiting, mut draft) = (post([0, 0, 0, 0]), waiting(), Draft::default());
        let before = post.desk.wish();
        // An address for documentation: no network carries the answer.
        let stranger = SocketAddr::from(([192, 0, 2, 1], 9));
        hear_ultraino(&mut post, b"clear\ncommit", stranger, &mut draft);
        assert_eq!((post.desk.counts.strangers.get(), &draft), (1, &Draft::default()));
        hear_osc(&mut post, b"/sonoglyph/send\0", stranger, &mut waiting);
        hear_osc(&mut post, b"no OSC", stranger, &mut waiting);
        assert_eq!((post.desk.counts.strangers.get(), post.desk.wish()), (3, before));
    }
}
