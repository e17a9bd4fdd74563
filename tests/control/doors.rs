//! Access: programs on this machine, pages of the same origin, and clients with the token.

use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream, UdpSocket};
use std::sync::Arc;

use rosc::OscType;
use sonoglyph::control::desk::Desk;
use sonoglyph::control::server::{Addresses, Server, Settings};
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::{Error, Message};

use crate::{Serving, TWO, Web, floats, scene};

const TOKEN: &str = "correct-horse";

fn with_token(listen: IpAddr) -> Settings {
    Settings { listen, token: Some(TOKEN.to_owned()), ..Settings::default() }
}

/// The HTTP status of a handshake with this origin: 101 if it is accepted.
fn status(address: &str, origin: Option<&str>) -> u16 {
    let mut request = address.into_client_request().unwrap();
    if let Some(origin) = origin {
        request.headers_mut().insert("Origin", HeaderValue::from_str(origin).unwrap());
    }
    match tungstenite::connect(request) {
        Ok((_, response)) => response.status().as_u16(),
        Err(Error::Http(response)) => response.status().as_u16(),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn a_server_listens_on_the_local_address_by_default() {
    let serving = Serving::local(TWO);
    let server = serving.server.as_ref().unwrap();
    let Addresses { osc, websocket, ultraino } = server.addresses();
    assert!([osc, websocket, ultraino].into_iter().all(|address| address.unwrap().ip().is_loopback()));
    assert_eq!(server.token(), None);
    let open = Serving::new(TWO, Settings { listen: Ipv4Addr::UNSPECIFIED.into(), ..Settings::default() });
    assert!(open.server.as_ref().unwrap().token().is_some_and(|token| token.len() == 32));
}

#[test]
fn a_dropped_server_closes_its_desk_and_ends_its_threads() {
    let desk = Arc::new(Desk::new(Arc::new(scene(TWO)), Box::new(|| {})));
    let all = Settings { osc: Some(0), websocket: Some(0), ultraino: Some(0), ..Settings::default() };
    let server = Server::start(all, Arc::clone(&desk)).unwrap();
    assert!(!desk.is_closing());
    drop(server);
    assert!(desk.is_closing());
    assert_eq!(Arc::strong_count(&desk), 1, "no thread has the desk any more");
}

#[test]
fn pages_of_other_origins_need_the_token() {
    let serving = Serving::local(TWO);
    let address = format!("ws://{}", serving.address("websocket"));
    for (origin, expected) in [
        (None, 101),
        (Some("http://localhost:8000"), 101),
        (Some("http://127.0.0.1"), 101),
        (Some("http://[::1]:3000"), 101),
        (Some("https://example.org"), 403),
        (Some("http://localhost.example.org"), 403),
        (Some("null"), 403),
    ] {
        assert_eq!(status(&address, origin), expected, "{origin:?}");
    }
    let serving = Serving::new(TWO, with_token(Ipv4Addr::LOCALHOST.into()));
    let address = format!("ws://{}", serving.address("websocket"));
    let page = Some("https://example.org");
    assert_eq!(status(&format!("{address}/?token={TOKEN}"), page), 101);
    assert_eq!(status(&format!("{address}/?token={TOKEN}x"), page), 403);
    assert_eq!(status(&format!("{address}/?token="), page), 403);
    assert_eq!(status(&address, None), 101, "a program of this machine");
    assert_eq!(serving.desk.counts.tally().strangers, 2);
}

#[test]
fn remote_connections_give_the_token_in_the_address_or_first() {
    let serving = Serving::new(TWO, with_token(Ipv4Addr::UNSPECIFIED.into()));
    let address = format!("ws://{}", serving.address("websocket"));
    let mut web = Web::new(&format!("{address}/control?a=b&token={TOKEN}"));
    assert_eq!(web.ask(r#"{"clear": true, "id": 1}"#)["done"], 2);
    let mut web = Web::new(&address);
    web.send(&format!("{{\"token\": \"{TOKEN}\"}}"));
    assert_eq!(web.ask(r#"{"stop": true, "id": 1}"#)["done"], 3);
    for first in [r#"{"stop": true}"#, r#"{"token": "wrong-horse"}"#, "no JSON"] {
        let mut web = Web::new(&address);
        assert_eq!(web.ask(first)["error"], "give the token first: {\"token\": \"…\"}");
        assert!(matches!(web.0.read(), Ok(Message::Close(_)) | Err(_)));
    }
    let mut web = Web::new(&address);
    // A client without the token is disconnected before a long message is read.
    let _ = web.0.send(Message::text(" ".repeat(1 << 20)));
    assert!(web.0.read().map_or(true, |answer| answer.is_close()));
    assert_eq!(serving.desk.generation(), 3);
}

#[test]
fn a_first_message_with_the_token_is_acted_upon() {
    let serving = Serving::new(TWO, with_token(Ipv4Addr::UNSPECIFIED.into()));
    let first = |keys: &str| {
        let mut web = Web::new(&format!("ws://{}", serving.address("websocket")));
        let answer = web.ask(&format!("{{\"token\": \"{TOKEN}\", {keys}}}"));
        // The connection stays open.
        web.send(r#"{"state": true, "id": 9}"#);
        while web.heard()["id"] != 9 {}
        answer
    };
    assert_eq!(first(r#""targets": {"1": {"at": [0.01, 0, 0.1]}}, "id": 1"#)["done"], 2);
    serving.has_foci_of(&TWO.replace("-0.02", "0.01"));
    assert_eq!(first(r#""state": true"#)["state"]["targets"][0]["number"], 1);
    assert!(first(r#""watch": true"#)["state"].is_object());
    for (keys, part) in [(r#""colour": 1"#, "there is no such key"), (r#""remove": [3]"#, "the scene has 2")]
    {
        let answer = first(keys);
        assert!(answer["error"].as_str().is_some_and(|error| error.contains(part)), "{answer}");
    }
    assert_eq!(serving.desk.counts.tally().strangers, 0);
}

#[test]
fn remote_packets_are_accepted_after_their_sender_gave_the_token() {
    let serving = Serving::new(TWO, with_token(Ipv4Addr::UNSPECIFIED.into()));
    let (osc, other) = (serving.udp("osc"), serving.udp("osc"));
    osc.osc("target/1/at", &floats([0.01, 0.0, 0.1]));
    assert_eq!(osc.error(), "give the token first: /sonoglyph/token");
    std::thread::sleep(std::time::Duration::from_millis(300));
    osc.osc("token", &[OscType::String("wrong-horse".to_owned())]);
    assert_eq!(osc.error(), "this is not the token");
    serving.has_foci_of(TWO);
    osc.osc("token", &[OscType::String(TOKEN.to_owned())]);
    osc.osc("target/1/at", &floats([0.01, 0.0, 0.1]));
    serving.has_foci_of(&TWO.replace("-0.02", "0.01"));
    other.osc("clear", &[]);
    other.osc("state", &[]);
    assert_eq!(other.error(), "give the token first: /sonoglyph/token");
    // Answers to senders without the token are limited.
    (0..100).for_each(|_| other.osc("state", &[]));
    let answered = std::iter::from_fn(|| (!other.is_silent()).then_some(())).count();
    assert!(answered < 10, "{answered}");
    serving.has_foci_of(&TWO.replace("-0.02", "0.01"));
}

#[test]
fn invalid_handshakes_end_and_slow_ones_do_not_block() {
    let serving = Serving::local(TWO);
    let address: SocketAddr = serving.address("websocket");
    for bytes in [
        &b"GET / HTTP/1.1\r\n\r\n"[..],
        b"POST / HTTP/1.1\r\nContent-Length: 5\r\n\r\n{\"a\":",
        &[0xff; 5000],
        b"\r\n\r\n",
    ] {
        let mut stream = TcpStream::connect(address).unwrap();
        // The server may close before all bytes are written.
        let _ = stream.write_all(bytes).and_then(|()| stream.shutdown(std::net::Shutdown::Write));
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        assert!(!answer.starts_with(b"HTTP/1.1 101"));
    }
    let idle: Vec<_> = (0..20).map(|_| TcpStream::connect(address).unwrap()).collect();
    assert_eq!(serving.web().ask(r#"{"id": 1, "stop": true}"#)["done"], 2);
    drop(idle);
    assert!(UdpSocket::bind(serving.address("osc")).is_err(), "the port is the server's");
}
