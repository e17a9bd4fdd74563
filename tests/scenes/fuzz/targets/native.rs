//! The native protocol: accepted packets encode to the received bytes, and the device answers every packet.

use sonoglyph::device::native::line::{self, LONGEST, Splitter, Spoiled};
use sonoglyph::device::native::model::Model;
use sonoglyph::device::native::packet::{Kind, Packet, REPLY, Reply};

/// Bytes of a packet before its payload, and of its CRC.
const HEAD: usize = 7;
const CRC: usize = 4;
const REPLY_BYTES: usize = 16;
/// The unused byte of a reply.
const UNUSED: usize = 15;

pub fn run(bytes: &[u8]) {
    let mut splitter = Splitter::default();
    for part in bytes.iter().filter_map(|&byte| splitter.push(byte)) {
        is_what_it_encodes_to(&part);
    }
    comes_back_from_its_frame(bytes);
    answers_every_packet(bytes);
}

/// The bytes between two delimiters, if a valid packet, are its encoding.
fn is_what_it_encodes_to(part: &[u8]) {
    if let Ok(packet) = Packet::of_line(part) {
        assert_eq!(Packet::of_line(&undelimited(packet.to_line())), Ok(packet));
    }
    if let Ok(reply) = Reply::of_line(part) {
        assert_eq!(Reply::of_line(&undelimited(reply.to_line())), Ok(reply));
    }
}

fn undelimited(mut line: Vec<u8>) -> Vec<u8> {
    assert_eq!(line.pop(), Some(0));
    assert!(!line.contains(&0), "a delimiter within {line:?}");
    line
}

/// Any bytes survive framing.
fn comes_back_from_its_frame(body: &[u8]) {
    let line = undelimited(line::framed(body.to_vec()));
    let fits = body.len() <= LONGEST - CRC;
    assert_eq!(line::checked(&line), if fits { Ok(body.to_vec()) } else { Err(Spoiled) });
    match Packet::of_line(&line) {
        Ok(packet) => {
            assert!(fits && body.len() >= HEAD);
            assert_eq!(undelimited(packet.to_line()), line);
        }
        Err(Spoiled) => assert!(!fits || body.len() < HEAD, "{body:?}"),
    }
    match Reply::of_line(&line) {
        Ok(reply) => {
            let mut own = body.to_vec();
            own[UNUSED] = 0;
            assert_eq!(undelimited(reply.to_line()), undelimited(line::framed(own)));
        }
        Err(Spoiled) => assert!(body.len() != REPLY_BYTES || body[0] < REPLY || body[3] > 6, "{body:?}"),
    }
}

/// Any bytes as a sequence of packets and the periods between them.
fn answers_every_packet(bytes: &[u8]) {
    let Some((&[bits], script)) = bytes.split_first_chunk() else { return };
    let mut model = Model::new(5 + bits % 4).with_address(bits >> 4 & 7);
    model.follow(bits >> 7 == 1);
    for &[kind, seq, a, b, c, d, fill, periods] in script.as_chunks().0 {
        let known = (0..REPLY).filter_map(Kind::from_repr).nth(usize::from(kind) % 32);
        let code = known.map_or(kind, Kind::code);
        let length = Kind::from_repr(code).map_or(usize::from(fill), Kind::payload);
        // One in sixteen is one byte short.
        let length = if fill % 16 == 7 { length.saturating_sub(1) } else { length };
        let payload = (0..length).map(|n| fill.wrapping_mul(n.to_le_bytes()[0] | 1)).collect();
        let packet = Packet { code, address: seq % 16, seq, arguments: [a, b, c, d], payload };
        let reply = model.hear(&packet);
        assert_eq!(reply.is_some(), code < REPLY && packet.address == bits >> 4 & 7);
        if let Some(reply) = reply {
            assert_eq!((reply.code, reply.address, reply.seq), (code + REPLY, packet.address, seq));
            assert_eq!(Reply::of_line(&undelimited(reply.to_line())), Ok(reply));
        }
        if fill % 32 == 5 {
            model.mark();
        }
        for _ in 0..periods % 8 {
            plays_pulses(&mut model);
        }
    }
}

fn plays_pulses(model: &mut Model) {
    let levels = model.levels();
    for pulse in model.period() {
        assert!(
            u16::from(pulse.rise) < levels && u16::from(pulse.width) <= levels / 2,
            "{pulse:?} of {levels}"
        );
    }
    assert!(model.baud() > 0.0 && model.baud().is_finite());
}
