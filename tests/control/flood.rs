//! Random and mutated packets: counted, refused, and without lasting effect.

use std::io::Write;
use std::net::{TcpStream, UdpSocket};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rosc::OscType;
use sonoglyph::control::desk::Desk;
use sonoglyph::control::edit::Edit;
use sonoglyph::control::json;
use sonoglyph::control::osc::{self, Word};
use sonoglyph::control::ultraino::Draft;

use crate::dice::Dice;
use crate::mutation::mutated;
use crate::waiting::PATIENCE;
use crate::{Serving, TWO, floats, message, scene};

/// Packets of a default run; `SONOGLYPH_MUTATIONS=10` makes ten times as many.
const PACKETS: u64 = 500_000;
/// Bytes of growth allowed to allocators.
const ALLOWED: usize = 16 << 20;

fn corpus() -> Vec<Vec<u8>> {
    let word = |text: &str| OscType::String(text.to_owned());
    let [x, y, z] = floats([0.01, 0.0, 0.1]);
    let at = |number| message(&format!("target/{number}/at"), &floats([0.01, 0.0, 0.1]));
    let messages = [
        at(1),
        at(2),
        message("target/1/pressure", &[OscType::Double(2.0)]),
        message("target/2/text", &[word("B")]),
        message("target/add", &[word("circle"), x, y, z, word("radius"), OscType::Float(0.03)]),
        message("target/2/remove", &[]),
        message("modulation/frequency", &[OscType::Int(200)]),
        message("send", &[OscType::Bool(true)]),
        message("state", &[]),
    ];
    let bundle = |content| rosc::OscPacket::Bundle(rosc::OscBundle { timetag: (0, 1).into(), content });
    let nested = bundle(vec![at(1), bundle(vec![at(2), bundle(vec![at(1)])])]);
    let osc = messages.into_iter().chain([nested]).map(|packet| rosc::encoder::encode(&packet).unwrap());
    let texts = [
        "clear",
        "create 3\nplace 0 0.01 0.1 0\nplace 2 0 0.12 0.03\ncommit",
        "delete 1\nupdate\ncommit",
        r#"{"targets": {"1": {"at": [0.01, 0, 0.1], "pressure": 2}, "2": {"text": "B"}}, "id": 3}"#,
        r#"{"scene": {"target": [{"kind": "line", "points": 4}, {"kind": "text", "text": "A", "points": 5}]}}"#,
        r#"{"add": [{"kind": "polygon", "sides": 5, "points": 5}], "remove": [1], "motion": {"path": "circle"}, "watch": true}"#,
        r#"{"plane": {"size": [0.1, 0.1]}, "modulation": {"shape": "sine"}, "map": {"size": [9, 9]}, "stop": true}"#,
    ];
    osc.chain(texts.into_iter().map(|text| text.as_bytes().to_vec())).collect()
}

/// Awkward values of every protocol.
fn awkward() -> Vec<Vec<u8>> {
    let mut words: Vec<Vec<u8>> =
        ["#bundle\0", "/sonoglyph/", ",f\0\0", "[[[[[[[[", "1e309", "-1", "\"", "null", "commit\n", "{}"]
            .map(|word| word.as_bytes().to_vec())
            .to_vec();
    words.extend([f32::NAN, f32::INFINITY, -0.0, 1e30, 0.0].map(|value| value.to_be_bytes().to_vec()));
    words.extend([0, u32::MAX, 1 << 31, 16].map(|value| value.to_be_bytes().to_vec()));
    words
}

/// A mutated packet of the corpus, or random bytes.
fn packet(corpus: &[Vec<u8>], words: &[Vec<u8>], seed: u64) -> Vec<u8> {
    match seed % 8 {
        1..=3 => {
            // Flip one bit.
            let mixed = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 24;
            let mut bytes = corpus[(mixed % corpus.len() as u64) as usize].clone();
            let place = (mixed >> 8) as usize % bytes.len();
            bytes[place] ^= 1 << (mixed >> 5 & 7);
            bytes
        }
        0 => mutated(&[vec![b'\xa5'; (seed / 8 % 600) as usize]], words, &mut Dice::seeded(seed)),
        _ => mutated(corpus, words, &mut Dice::seeded(seed)),
    }
}

/// Resident memory of this process, bytes.
fn resident() -> usize {
    let pages = std::fs::read_to_string("/proc/self/statm").expect("Linux reports memory in /proc");
    pages
        .split(' ')
        .nth(1)
        .and_then(|pages| pages.parse::<usize>().ok())
        .expect("statm holds a number of pages")
        * 4096
}

/// Handles a packet like the sockets' threads.
fn hear(desk: &Desk, draft: &mut Draft, bytes: &[u8]) -> bool {
    let of_osc = osc::words(bytes).unwrap_or_default();
    let edit = |word| match word {
        Word::Edit(edit) => Some(edit),
        Word::Token(_) | Word::State => None,
    };
    let of_osc: Vec<Edit> = of_osc.into_iter().filter_map(edit).collect();
    let of_ultraino = draft.take(bytes).ok().flatten().unwrap_or_default();
    let text = std::str::from_utf8(bytes).unwrap_or_default();
    let of_json = json::message(text, &mut None)
        .map_or_else(|error| vec_of(&error.to_string()), |message| message.edits);
    let changes = [of_osc, of_ultraino, of_json].into_iter().filter(|edits| !edits.is_empty());
    // The desk counts errors, and each is one line.
    changes
        .map(|edits| desk.change(&edits).map_err(|error| assert!(!error.to_string().contains('\n'))).is_ok())
        .fold(false, |a, b| a | b)
}

/// No edits, from an error that must be one line.
fn vec_of(error: &str) -> Vec<Edit> {
    assert!(!error.trim().is_empty() && !error.contains('\n'), "{error:?}");
    Vec::new()
}

#[test]
fn states_are_answered_at_their_rate_and_no_faster() {
    let serving = Serving::local(TWO);
    let osc = serving.udp("osc");
    let start = Instant::now();
    let mut answers = 0;
    for round in 0..20 {
        (0..50).for_each(|_| osc.osc("state", &[]));
        let patience = Duration::from_millis(if round < 19 { 2 } else { 300 });
        osc.0.set_read_timeout(Some(patience)).unwrap();
        answers += std::iter::from_fn(|| osc.0.recv(&mut [0; 100]).ok()).count();
    }
    // Half a second's worth at once, and 200 a second.
    let most = 101.0 + 200.0 * start.elapsed().as_secs_f64();
    assert!(answers >= 100 && answers as f64 <= most, "{answers}, and at most {most}");
}

#[test]
fn random_packets_keep_the_scene_valid_and_memory_bounded() {
    let times = std::env::var("SONOGLYPH_MUTATIONS").map_or(1, |times| times.parse().unwrap());
    let (corpus, words) = (corpus(), awkward());
    let desk = Desk::new(Arc::new(scene(TWO)), Box::new(|| {}));
    let mut draft = Draft::default();
    let (mut before, mut done) = (0, 0u64);
    let (begun, packets) = (Instant::now(), PACKETS * times);
    for seed in 0..packets {
        if seed == packets / 20 {
            before = resident();
        }
        if seed % 200 == 0 {
            desk.change(&[Edit::Scene(Box::new(scene(TWO)))]).unwrap();
        }
        done += u64::from(hear(&desk, &mut draft, &packet(&corpus, &words, seed)));
        let scene = desk.wish().0.scene;
        assert!(sonoglyph::scene::check::check(&scene).is_ok(), "seed {seed}");
    }
    let more = resident().saturating_sub(before);
    let tally = desk.counts.tally();
    eprintln!(
        "{packets} packets in {:.1} s: {done} changed the scene, {more} bytes more; {tally}",
        begun.elapsed().as_secs_f64()
    );
    assert!(more < ALLOWED, "{more} bytes");
    // Enough mutations are accepted, and enough refused.
    assert!(done > packets / 50 && tally.refused > packets / 100, "{done}, {tally}");
}

#[test]
fn a_flooded_server_keeps_answering() {
    let serving = Serving::local(TWO);
    let (corpus, words) = (corpus(), awkward());
    let [to_osc, to_ultraino] =
        ["osc", "ultraino"].map(|of| (UdpSocket::bind("127.0.0.1:0").unwrap(), serving.address(of)));
    for seed in 0..20_000 {
        let bytes = packet(&corpus, &words, seed);
        for (socket, address) in [&to_osc, &to_ultraino] {
            // Larger packets than UDP allows are not sent.
            let _ = socket.send_to(&bytes, address);
        }
        if seed % 200 == 0 {
            let mut stream = TcpStream::connect(serving.address("websocket")).unwrap();
            let _ = stream.write_all(&bytes);
        }
    }
    let osc = serving.udp("osc");
    osc.0.set_read_timeout(Some(Duration::from_millis(500))).unwrap();
    let until = Instant::now() + PATIENCE;
    loop {
        osc.osc("clear", &[]);
        osc.osc("state", &[]);
        let mut bytes = vec![0; 65536];
        // Queued packets of other protocols may add targets after this clear.
        if let Ok(length) = osc.0.recv(&mut bytes)
            && bytes[..length].windows(6).any(|part| part == b"/state")
            && serving.web().ask(r#"{"state": true}"#)["state"]["targets"].as_array().unwrap().is_empty()
        {
            break;
        }
        assert!(Instant::now() < until, "no answer, or targets after a clear");
    }
    let tally = serving.desk.counts.tally();
    assert!(tally.malformed > 1000 && tally.unanswered > tally.answers, "{tally:?}");
}

#[test]
fn deep_and_endless_packets_are_refused_before_they_are_read() {
    let bundle = b"#bundle\0\0\0\0\0\0\0\0\x01";
    let mut nested = Vec::new();
    for depth in (0..700u32).rev() {
        nested.extend(bundle);
        nested.extend((depth * 20).to_be_bytes());
    }
    assert!(osc::words(&nested).unwrap_err().contains("bundles or arrays"));
    let mut arrays = b"/sonoglyph/stop\0,".to_vec();
    arrays.extend(vec![b'['; 15_000]);
    arrays.resize(arrays.len().next_multiple_of(4) + 4, 0);
    assert!(osc::words(&arrays).unwrap_err().contains("bundles or arrays"));
    assert!(osc::words(&vec![b'/'; osc::LONGEST + 1]).unwrap_err().contains("more than"));
    // Old senders write no type tags, and a stop must work without.
    assert_eq!(osc::words(b"/sonoglyph/stop\0"), Ok(vec![Word::Edit(Edit::Stop)]));
    let mut draft = Draft::default();
    for _ in 0..100_000 {
        assert_eq!(draft.take(b"place 0 0 0.1 0"), Ok(None));
    }
    let error = (0..10).find_map(|_| draft.take(b"create 1000").err()).unwrap();
    assert!(error.contains("without a commit"), "{error}");
}
