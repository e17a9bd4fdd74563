//! Control by other programs: edits of the scene, access, floods of packets, and a board that follows.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod board;
mod desk;
#[path = "../dice/mod.rs"]
#[expect(dead_code, reason = "used by other test binaries")]
mod dice;
mod doors;
mod flood;
#[path = "../scenes/fuzz/mutation.rs"]
#[expect(dead_code, reason = "the fuzz targets have a dictionary")]
mod mutation;
mod packets;
#[path = "../waiting/mod.rs"]
mod waiting;
mod words;

use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType};
use serde_json::Value;
use sonoglyph::control::desk::Desk;
use sonoglyph::control::live::Live;
use sonoglyph::control::server::{Server, Settings};
use sonoglyph::scene::{Scene, file};
use sonoglyph::solver;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};
use waiting::{PATIENCE, eventually};

const TWO: &str =
    "format = 1\n[[target]]\nat = [-0.02, 0, 0.1]\n[[target]]\nkind = \"text\"\ntext = \"A\"\npoints = 6\n";

fn scene(text: &str) -> Scene {
    file::parse(text, Path::new("test.toml")).unwrap()
}

/// A server on free ports, with the loop that solves for it.
struct Serving {
    server: Option<Server>,
    desk: Arc<Desk>,
    over: Arc<AtomicBool>,
    live: Option<JoinHandle<()>>,
}

impl Serving {
    fn new(text: &str, settings: Settings) -> Self {
        let desk = Arc::new(Desk::new(Arc::new(scene(text)), Box::new(|| {})));
        let all = Settings { osc: Some(0), websocket: Some(0), ultraino: Some(0), ..settings };
        let server = Some(Server::start(all, Arc::clone(&desk)).unwrap());
        let over = Arc::new(AtomicBool::new(false));
        let (its, its_desk) = (Arc::clone(&over), Arc::clone(&desk));
        let run = move || {
            let mut live = Live::new(its_desk, None);
            while !its.load(Ordering::Relaxed) {
                live.turn();
            }
        };
        let live = std::thread::Builder::new().name("live".to_owned()).spawn(run).unwrap();
        Self { server, desk, over, live: Some(live) }
    }

    fn local(text: &str) -> Self {
        Self::new(text, Settings::default())
    }

    fn address(&self, of: &str) -> SocketAddr {
        let addresses = self.server.as_ref().unwrap().addresses();
        let address = match of {
            "osc" => addresses.osc,
            "websocket" => addresses.websocket,
            "ultraino" => addresses.ultraino,
            _ => None,
        };
        let port = address.unwrap().port();
        SocketAddr::from(([127, 0, 0, 1], port))
    }

    fn udp(&self, of: &str) -> Udp {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(self.address(of)).unwrap();
        socket.set_read_timeout(Some(PATIENCE)).unwrap();
        Udp(socket)
    }

    fn web(&self) -> Web {
        Web::new(&format!("ws://{}", self.address("websocket")))
    }

    /// Waits until the reported foci equal those of another scene, to the last digit.
    fn has_foci_of(&self, text: &str) {
        let expected = solver::solve(&scene(text)).unwrap();
        let expected: Vec<_> = expected
            .foci
            .iter()
            .map(|focus| focus.position)
            .zip(expected.pressures.iter().map(|p| p.norm()))
            .collect();
        eventually(&format!("the foci of {text}"), || self.desk.report().foci() == expected);
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        self.server.take();
        self.live.take().into_iter().for_each(|live| drop(live.join()));
    }
}

/// A client by UDP.
struct Udp(UdpSocket);

impl Udp {
    fn send(&self, bytes: &[u8]) {
        self.0.send(bytes).unwrap();
    }

    fn osc(&self, address: &str, args: &[OscType]) {
        self.send(&rosc::encoder::encode(&message(address, args)).unwrap());
    }

    fn bundle(&self, content: Vec<OscPacket>) {
        let timetag = OscTime { seconds: 0, fractional: 1 };
        self.send(&rosc::encoder::encode(&OscPacket::Bundle(OscBundle { timetag, content })).unwrap());
    }

    fn answer(&self) -> Vec<u8> {
        let mut bytes = vec![0; 65536];
        let length = self.0.recv(&mut bytes).unwrap();
        bytes.truncate(length);
        bytes
    }

    /// The messages in the next answer.
    fn heard(&self) -> Vec<OscMessage> {
        let bytes = self.answer();
        let (_, packet) = rosc::decoder::decode_udp(&bytes).unwrap();
        let parts = match packet {
            OscPacket::Message(message) => vec![OscPacket::Message(message)],
            OscPacket::Bundle(bundle) => bundle.content,
        };
        let message = |part| match part {
            OscPacket::Message(message) => message,
            OscPacket::Bundle(_) => panic!("a bundle in a bundle"),
        };
        parts.into_iter().map(message).collect()
    }

    /// The error in the next answer.
    fn error(&self) -> String {
        match &self.heard()[..] {
            [OscMessage { addr, args }] if addr == "/sonoglyph/error" => args[0].clone().string().unwrap(),
            other => panic!("{other:?}"),
        }
    }

    fn is_silent(&self) -> bool {
        self.0.set_read_timeout(Some(Duration::from_millis(300))).unwrap();
        let silent = self.0.recv(&mut [0; 100]).is_err();
        self.0.set_read_timeout(Some(PATIENCE)).unwrap();
        silent
    }
}

fn message(address: &str, args: &[OscType]) -> OscPacket {
    OscPacket::Message(OscMessage { addr: format!("/sonoglyph/{address}"), args: args.to_vec() })
}

fn floats<const N: usize>(values: [f32; N]) -> [OscType; N] {
    values.map(OscType::Float)
}

/// A client by WebSocket.
struct Web(WebSocket<MaybeTlsStream<TcpStream>>);

impl Web {
    fn new(address: &str) -> Self {
        let (socket, _) = tungstenite::connect(address).unwrap();
        let web = Self(socket);
        web.expect_within(PATIENCE);
        web
    }

    fn expect_within(&self, time: Duration) {
        if let MaybeTlsStream::Plain(stream) = self.0.get_ref() {
            stream.set_read_timeout(Some(time)).unwrap();
        }
    }

    fn send(&mut self, text: &str) {
        self.0.send(Message::text(text)).unwrap();
    }

    fn heard(&mut self) -> Value {
        loop {
            match self.0.read().unwrap() {
                Message::Text(text) => return serde_json::from_str(&text).unwrap(),
                Message::Ping(_) | Message::Pong(_) => {}
                other => panic!("{other:?}"),
            }
        }
    }

    fn ask(&mut self, text: &str) -> Value {
        self.send(text);
        self.heard()
    }
}
