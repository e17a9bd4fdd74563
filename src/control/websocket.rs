//! WebSocket: a thread per connection, which decodes, applies and replies.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::handshake::server::{ErrorResponse, Request as Handshake, Response};
use tungstenite::http::StatusCode;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message as Packet, Utf8Bytes, WebSocket};

use crate::control::desk::Desk;
use crate::control::gate::Gate;
use crate::control::json::{self, MapWish, Message};
use crate::control::limiter::Limiter;
use crate::control::maps::Maps;

/// Connections at once.
const MOST_CONNECTIONS: usize = 32;
/// Time limit of a handshake, and of a required token.
const GREETING: Duration = Duration::from_secs(5);
/// A client that accepts no data for this time is disconnected.
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);
/// Interval at which a connection checks for its end, and for a state to send.
const LOOK: Duration = Duration::from_millis(50);
const WATCHING: Duration = Duration::from_millis(5);
/// Limit of unrequested states per second and connection.
const STATES: f64 = 60.0;
/// A state is answered once the preceding changes are solved, or after this time.
const PATIENCE: Duration = Duration::from_millis(100);
/// Limit of a first message with a token, in bytes.
const FIRST: usize = 64 << 10;
/// Bytes of the buffers of a connection.
const BUFFER: usize = 16 << 10;

/// Listens for connections until the desk closes.
///
/// # Errors
/// A system without another thread.
pub fn listen(listener: TcpListener, desk: Arc<Desk>, gate: Arc<Gate>) -> io::Result<JoinHandle<()>> {
    listener.set_nonblocking(true)?;
    let maps = Arc::new(Maps::default());
    let accept = move || {
        let open = Arc::new(AtomicUsize::new(0));
        while !desk.is_closing() {
            let Ok((stream, _)) = listener.accept() else {
                std::thread::sleep(LOOK);
                continue;
            };
            if open.load(Ordering::Relaxed) >= MOST_CONNECTIONS {
                desk.counts.unanswered.add();
                continue;
            }
            let place = Place::taken(&open);
            let (desk, gate, maps) = (Arc::clone(&desk), Arc::clone(&gate), Arc::clone(&maps));
            let serve = move || {
                let _place = place;
                // Errors end the connection; the other end has been informed.
                let _ = serve(stream, &desk, &gate, &maps);
            };
            // Without a thread the connection is dropped.
            let _ = std::thread::Builder::new().name("websocket".to_owned()).spawn(serve);
        }
    };
    std::thread::Builder::new().name("websockets".to_owned()).spawn(accept)
}

/// One of the connections that there may be.
struct Place(Arc<AtomicUsize>);

impl Place {
    fn taken(open: &Arc<AtomicUsize>) -> Self {
        open.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(open))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A stream with a deadline for reads.
struct Timed {
    stream: TcpStream,
    until: Option<Instant>,
}

impl Read for Timed {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if let Some(until) = self.until {
            let rest = until.saturating_duration_since(Instant::now());
            if rest.is_zero() {
                return Err(ErrorKind::ConnectionAborted.into());
            }
            self.stream.set_read_timeout(Some(rest))?;
        }
        self.stream.read(bytes)
    }
}

impl Write for Timed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

type Socket = WebSocket<Timed>;

fn serve(stream: TcpStream, desk: &Desk, gate: &Gate, maps: &Maps) -> Result<(), Error> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
    let until = Instant::now() + GREETING;
    let timed = Timed { stream, until: Some(until) };
    let mut is_known = false;
    #[expect(clippy::result_large_err, reason = "tungstenite's own type")]
    let greet = |handshake: &Handshake, response: Response| {
        is_known = welcome(handshake, gate).inspect_err(|_| desk.counts.strangers.add())?;
        Ok(response)
    };
    let longest = if gate.token().is_some() { FIRST } else { json::LONGEST };
    let accepted = tungstenite::accept_hdr_with_config(timed, greet, Some(config(longest)));
    let mut socket = match accepted {
        Ok(socket) => socket,
        Err(_) => {
            desk.counts.malformed.add();
            return Ok(());
        }
    };
    let mut first = None;
    if !is_known {
        first = message_with_token(&mut socket, gate)?;
        if first.is_none() {
            desk.counts.strangers.add();
            socket.send(json::error("give the token first: {\"token\": \"…\"}", None).into())?;
            return goodbye(&mut socket);
        }
    }
    socket.set_config(|set| *set = config(json::LONGEST));
    socket.get_mut().until = None;
    desk.counts.connections.add();
    Connection { socket, desk, gate, maps, watch: None }.talk(first)
}

fn config(longest: usize) -> WebSocketConfig {
    WebSocketConfig::default()
        .read_buffer_size(BUFFER)
        .write_buffer_size(0)
        .max_message_size(Some(longest))
        .max_frame_size(Some(longest))
}

/// Whether the handshake suffices, or a token must follow.
#[expect(clippy::result_large_err, reason = "tungstenite's own type")]
fn welcome(handshake: &Handshake, gate: &Gate) -> Result<bool, ErrorResponse> {
    let refusal = |text: &str| {
        let mut response = ErrorResponse::new(Some(format!("{text}\n")));
        *response.status_mut() = StatusCode::FORBIDDEN;
        response
    };
    // A non-text origin is not of this machine.
    let origin = handshake.headers().get("origin").map(|origin| origin.to_str().unwrap_or_default());
    let given = handshake.uri().query().into_iter().flat_map(|query| query.split('&'));
    let given = given.filter_map(|pair| pair.strip_prefix("token=")).next();
    match given {
        _ if !gate.asks(origin) => Ok(true),
        Some(token) if gate.fits(token) => Ok(true),
        Some(_) => Err(refusal("this is not the token")),
        None if gate.token().is_none() => {
            Err(refusal("pages of other machines need a token, and this server was started without one"))
        }
        None => Ok(false),
    }
}

/// The first message, if it has the token.
fn message_with_token(socket: &mut Socket, gate: &Gate) -> Result<Option<Utf8Bytes>, Error> {
    let Packet::Text(text) = socket.read()? else { return Ok(None) };
    let is_known = json::token(&text).is_some_and(|token| gate.fits(&token));
    Ok(is_known.then_some(text))
}

fn goodbye(socket: &mut Socket) -> Result<(), Error> {
    socket.close(None)?;
    socket.flush()
}

struct Connection<'a> {
    socket: Socket,
    desk: &'a Desk,
    gate: &'a Gate,
    maps: &'a Maps,
    /// State of a watching client: the last report sent, the rate limit, and the request's id.
    watch: Option<(u64, Limiter, Option<Value>)>,
}

impl Connection<'_> {
    /// `first`: the message that gave the token.
    fn talk(mut self, first: Option<Utf8Bytes>) -> Result<(), Error> {
        self.wait(LOOK)?;
        if let Some(text) = first {
            self.desk.counts.packets.add();
            self.hear(&text)?;
        }
        while !self.desk.is_closing() {
            match self.socket.read() {
                Ok(Packet::Text(text)) => {
                    self.desk.counts.packets.add();
                    self.hear(&text)?;
                }
                Ok(Packet::Binary(_)) => {
                    self.desk.counts.packets.add();
                    self.desk.counts.malformed.add();
                    self.say(json::error("messages are JSON, and text", None))?;
                }
                Ok(Packet::Ping(_) | Packet::Pong(_) | Packet::Frame(_)) => {}
                Ok(Packet::Close(_)) | Err(Error::ConnectionClosed) => return self.socket.flush(),
                Err(Error::Io(error))
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(error) => {
                    if matches!(error, Error::Capacity(_) | Error::Protocol(_) | Error::Utf8(_)) {
                        self.desk.counts.malformed.add();
                    }
                    return Err(error);
                }
            }
            self.tell()?;
        }
        goodbye(&mut self.socket)
    }

    fn wait(&self, time: Duration) -> io::Result<()> {
        self.socket.get_ref().stream.set_read_timeout(Some(time))
    }

    fn say(&mut self, text: String) -> Result<(), Error> {
        self.desk.counts.answers.add();
        self.socket.send(Packet::Text(text.into()))
    }

    fn hear(&mut self, text: &str) -> Result<(), Error> {
        let mut id = None;
        let message = match json::message(text, &mut id) {
            Ok(message) => message,
            Err(error) => {
                self.desk.counts.malformed.add();
                return self.say(json::error(&error.to_string(), id.as_ref()));
            }
        };
        let Message { id, token, edits, state, watch, map } = message;
        if token.is_some_and(|token| self.gate.token().is_some() && !self.gate.fits(&token)) {
            return self.say(json::error("this is not the token", id.as_ref()));
        }
        if !edits.is_empty() {
            match self.desk.change(&edits) {
                // Watching clients are informed anyway.
                Ok(change) if id.is_some() => self.say(json::done(change, id.as_ref()))?,
                Ok(_) => {}
                Err(error) => return self.say(json::error(&error.to_string(), id.as_ref())),
            }
        }
        if state {
            self.catch_up();
            let state = self.desk.report().state(self.desk.counts.tally());
            self.say(json::with_id(state, id.as_ref()))?;
        }
        if let Some(on) = watch {
            self.watch = on.then(|| (0, Limiter::new(STATES), id.clone()));
            self.wait(if on { WATCHING } else { LOOK })?;
        }
        map.map_or(Ok(()), |wish| self.map(wish, id.as_ref()))
    }

    /// Waits until the preceding changes are solved, within a time limit.
    fn catch_up(&self) {
        let (generation, until) = (self.desk.generation(), Instant::now() + PATIENCE);
        while self.desk.report().solved < generation && Instant::now() < until {
            std::thread::sleep(Duration::from_micros(500));
        }
    }

    /// Sends a new state to a watching client.
    fn tell(&mut self) -> Result<(), Error> {
        let Some((told, states, id)) = &mut self.watch else { return Ok(()) };
        let report = self.desk.report();
        if *told == report.serial || !states.takes(Instant::now()) {
            return Ok(());
        }
        *told = report.serial;
        let state = json::with_id(report.state(self.desk.counts.tally()), id.as_ref());
        self.say(state)
    }

    /// A text that describes the numbers, then the numbers.
    fn map(&mut self, wish: MapWish, id: Option<&Value>) -> Result<(), Error> {
        self.catch_up();
        match self.maps.draw(wish, &self.desk.report()) {
            Err(text) => self.say(json::error(&text, id)),
            Ok(drawn) => {
                self.say(json::with_id(json!({ "map": drawn.head }), id))?;
                self.desk.counts.answers.add();
                self.socket.send(Packet::Binary(drawn.numbers.into()))
            }
        }
    }
}
