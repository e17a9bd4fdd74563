//! OSC 1.0: packets as commands, and replies as packets. Time tags are ignored; a bundle is one change.

use glam::{DVec2, DVec3};
use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType};
use serde_json::{Map, Value, json};

use crate::control::edit::Edit;
use crate::control::refusal::Number;
use crate::control::report::Report;
use crate::control::table::{self, Table};
use crate::echo;

/// Bytes of a packet, at most.
pub const LONGEST: usize = 16 << 10;
/// Bundles in a packet, and brackets of arrays, at most: the decoder descends into each.
const MOST_NESTED: usize = 32;
/// Prefix of all addresses.
const ROOT: &str = "/sonoglyph/";
/// Foci in an answer, at most: it fits into one packet.
const MOST_FOCI: usize = 128;

/// A parsed message.
#[derive(Clone, Debug, PartialEq)]
pub enum Word {
    Edit(Edit),
    Token(String),
    State,
}

/// The words of a packet, in its order.
///
/// # Errors
/// Invalid OSC, an unknown address, or invalid arguments.
pub fn words(bytes: &[u8]) -> Result<Vec<Word>, String> {
    if bytes.len() > LONGEST {
        return Err(format!("a packet of more than {LONGEST} bytes"));
    }
    let bundles = bytes.chunks(4).collect::<Vec<_>>();
    let bundles = bundles.windows(2).filter(|pair| pair == &[b"#bun", b"dle\0"]).count();
    let brackets = bytes.iter().filter(|&&byte| byte == b'[').count();
    if bundles.max(brackets) > MOST_NESTED {
        return Err(format!("more than {MOST_NESTED} bundles or arrays in a packet"));
    }
    let packet = match rosc::decoder::decode_udp(bytes) {
        Ok(([], packet)) => packet,
        Ok(_) => return Err("the packet is longer than its message, or holds a broken one".to_owned()),
        Err(error) => match without_tags(bytes) {
            Some(message) => OscPacket::Message(message),
            None => return Err(format!("no OSC: {}", echo::message(&error.to_string()))),
        },
    };
    let mut words = Vec::new();
    collect(packet, &mut words)?;
    Ok(words)
}

/// Old senders omit the type tags of messages without arguments.
fn without_tags(bytes: &[u8]) -> Option<OscMessage> {
    let addr = std::str::from_utf8(bytes).ok()?.trim_end_matches('\0');
    let is_address = addr.starts_with('/') && !addr.contains('\0') && bytes.len() == (addr.len() / 4 + 1) * 4;
    is_address.then(|| OscMessage { addr: addr.to_owned(), args: Vec::new() })
}

fn collect(packet: OscPacket, words: &mut Vec<Word>) -> Result<(), String> {
    match packet {
        OscPacket::Message(message) => words.extend(word(&message)?),
        OscPacket::Bundle(bundle) => bundle.content.into_iter().try_for_each(|part| collect(part, words))?,
    }
    Ok(())
}

/// The word of a message; a released button says none.
fn word(message: &OscMessage) -> Result<Option<Word>, String> {
    let OscMessage { addr, args } = message;
    let what = || echo::value(addr);
    let Some(path) = addr.strip_prefix(ROOT) else {
        return Err(format!("{}: addresses begin with {ROOT}", what()));
    };
    let parts: Vec<_> = path.split('/').collect();
    if let ["clear" | "state"] | ["target", _, "remove"] = parts[..]
        && is_released(args)
    {
        return Ok(None);
    }
    let word = match (&parts[..], &args[..]) {
        (["target", "add"], args) => added(args).map(Word::Edit),
        (["target", number, key], args) => {
            let number = number.parse().map_err(|_| format!("{}: targets are numbered from 1", what()))?;
            of_target(number, key, args).map(Word::Edit)
        }
        (["clear"], _) => Some(Word::Edit(Edit::Clear)),
        (["motion"], [on]) => truth(on).map(Edit::Motion).map(Word::Edit),
        (["send"], []) => Some(Word::Edit(Edit::Send(true))),
        (["send"], [on]) => truth(on).map(Edit::Send).map(Word::Edit),
        // With any arguments: a stop must not fail.
        (["stop"], _) => Some(Word::Edit(Edit::Stop)),
        (["state"], _) => Some(Word::State),
        (["token"], [OscType::String(token)]) => Some(Word::Token(token.clone())),
        ([table, key], args) => match table.parse::<Table>() {
            Ok(table) => value(args).map(|value| {
                let keys = Map::from_iter([((*key).to_owned(), value)]);
                Word::Edit(Edit::Table(table, keys))
            }),
            Err(_) => return Err(format!("{}: there is no such address", what())),
        },
        (["motion" | "send" | "token"], _) => None,
        (_, _) => return Err(format!("{}: there is no such address", what())),
    };
    word.map(Some).ok_or_else(|| format!("{}: other arguments belong to it", what()))
}

fn of_target(number: Number, key: &str, args: &[OscType]) -> Option<Edit> {
    match (key, args) {
        ("at", [x, y, z]) => Some(Edit::At(number, DVec3::new(real(x)?, real(y)?, real(z)?))),
        // A pad.
        ("at", [x, y]) => Some(Edit::Across(number, DVec2::new(real(x)?, real(y)?))),
        ("pressure", [pressure]) => Some(Edit::Pressure(number, real(pressure)?)),
        ("angle", [angle]) => Some(Edit::Angle(number, real(angle)?)),
        ("visible", [on]) => Some(Edit::Visible(number, truth(on)?)),
        ("text", [OscType::String(text)]) => Some(Edit::Text(number, text.clone())),
        ("remove", _) => Some(Edit::Remove(number)),
        (_, _) => None,
    }
}

/// Kind, position, and further keys with their values: `"circle" x y z "radius" 0.02`.
fn added(args: &[OscType]) -> Option<Edit> {
    let [OscType::String(kind), rest @ ..] = args else { return None };
    let count = rest.iter().take_while(|arg| real(arg).is_some()).count();
    let (numbers, mut rest) = rest.split_at(count);
    let numbers: Vec<_> = numbers.iter().filter_map(real).collect();
    let mut keys = Map::from_iter([("kind".to_owned(), json!(kind))]);
    match (kind.as_str(), &numbers[..]) {
        (_, []) => {}
        ("line", [from @ .., _, _, _]) if from.len() == 3 => {
            keys.insert("from".to_owned(), json!(from));
            keys.insert("to".to_owned(), json!(numbers[3..]));
        }
        ("path", all) if all.len().is_multiple_of(3) => {
            keys.insert("vertices".to_owned(), all.chunks(3).map(|at| json!(at)).collect());
        }
        (_, [_, _, _]) => {
            keys.insert("at".to_owned(), json!(numbers));
        }
        (_, _) => return None,
    }
    while let [OscType::String(key), more @ ..] = rest {
        let count = more.iter().take_while(|arg| real(arg).is_some()).count().max(1);
        let (values, after) = more.split_at_checked(count)?;
        keys.insert(key.clone(), value(values)?);
        rest = after;
    }
    if !rest.is_empty() {
        return None;
    }
    table::target(keys, 0).ok().map(|target| Edit::Add(Box::new(target)))
}

/// One argument as itself, several numbers as a list.
fn value(args: &[OscType]) -> Option<Value> {
    match args {
        [OscType::String(text)] => Some(json!(text)),
        [OscType::Bool(on)] => Some(json!(on)),
        [OscType::Int(whole)] => Some(json!(whole)),
        [OscType::Long(whole)] => Some(json!(whole)),
        [number] => Some(json!(real(number)?)),
        [] => None,
        numbers => numbers.iter().map(real).collect::<Option<Vec<_>>>().map(|list| json!(list)),
    }
}

/// A number of any type. Non-finite values are refused with their key.
fn real(arg: &OscType) -> Option<f64> {
    match *arg {
        // As the decimals that were meant: 0.1 and not 0.10000000149.
        OscType::Float(value) => value.to_string().parse().ok(),
        OscType::Double(value) => Some(value),
        OscType::Int(value) => Some(value.into()),
        OscType::Long(value) => Some(value as f64),
        OscType::String(_)
        | OscType::Blob(_)
        | OscType::Time(_)
        | OscType::Char(_)
        | OscType::Color(_)
        | OscType::Midi(_)
        | OscType::Bool(_)
        | OscType::Array(_)
        | OscType::Nil
        | OscType::Inf => None,
    }
}

/// T or F, or a number (0 is false).
fn truth(arg: &OscType) -> Option<bool> {
    match arg {
        OscType::Bool(on) => Some(*on),
        number => real(number).map(|number| number != 0.0),
    }
}

/// Whether these are the arguments of a button that is let go: F or 0 first. Surfaces send a value with every button.
fn is_released(args: &[OscType]) -> bool {
    args.first().and_then(truth) == Some(false)
}

/// An error message.
pub fn error(text: &str) -> Vec<u8> {
    encoded(&message("error", vec![OscType::String(echo::message(text))]))
}

/// The state as a bundle.
pub fn state(report: &Report) -> Vec<u8> {
    let float = |value: f64| OscType::Float(value as f32);
    let count = |count: usize| OscType::Int(i32::try_from(count).unwrap_or(i32::MAX));
    let text = |text: Option<String>| OscType::String(text.unwrap_or_default());
    let foci = report.foci();
    let head = vec![
        count(report.wish.as_ref().map_or(0, |wish| wish.scene.targets.len())),
        count(foci.len()),
        OscType::Bool(report.wish.as_ref().is_some_and(|wish| wish.sends)),
        OscType::Bool(report.wish.as_ref().is_some_and(|wish| wish.moves)),
        text(report.board.as_ref().map(|board| board.words())),
        text(report.problem.as_deref().map(echo::message)),
    ];
    let focus = |(index, (at, pressure)): (usize, &(DVec3, f64))| {
        let args = [at.x, at.y, at.z, *pressure].map(float).to_vec();
        message(&format!("focus/{}", index + 1), args)
    };
    let foci = foci.iter().take(MOST_FOCI).enumerate().map(focus);
    let content = std::iter::once(message("state", head)).chain(foci).collect();
    // The time tag for immediate execution.
    let timetag = OscTime { seconds: 0, fractional: 1 };
    encoded(&OscPacket::Bundle(OscBundle { timetag, content }))
}

fn message(path: &str, args: Vec<OscType>) -> OscPacket {
    OscPacket::Message(OscMessage { addr: format!("{ROOT}{path}"), args })
}

/// Empty if OSC cannot represent it; then nothing is sent.
fn encoded(packet: &OscPacket) -> Vec<u8> {
    rosc::encoder::encode(packet).unwrap_or_default()
}
