//! Mutations of a corpus: inputs cut, spliced, repeated, and with awkward words inserted.

use crate::dice::Dice;

fn one<'a, T>(of: &'a [T], dice: &mut Dice) -> &'a T {
    &of[dice.index(of.len())]
}

/// A range within `length` bytes, mostly short.
fn part(length: usize, dice: &mut Dice) -> std::ops::Range<usize> {
    let start = dice.index(length);
    let longest = if dice.below(4) == 0 { length - start } else { (length - start).min(16) };
    start..start + dice.index(longest + 1)
}

/// Maximum size of a mutation, bytes.
const LONGEST: usize = 1 << 16;
const MOST_STEPS: usize = 8;

/// An input of the corpus with a few changes.
pub fn mutated(corpus: &[Vec<u8>], words: &[Vec<u8>], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = one(corpus, dice).clone();
    for _ in 0..=dice.index(MOST_STEPS) {
        change(&mut bytes, corpus, words, dice);
        bytes.truncate(LONGEST);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, corpus: &[Vec<u8>], words: &[Vec<u8>], dice: &mut Dice) {
    let at = dice.index(bytes.len() + 1);
    match dice.below(9) {
        0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << dice.below(8)),
        1 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte = dice.byte()),
        2 => drop(bytes.splice(at..at, one(words, dice).iter().copied())),
        3 | 4 => drop(bytes.splice(token(bytes, at), one(words, dice).iter().copied())),
        5 => drop(bytes.drain(part(bytes.len(), dice))),
        6 => {
            let part = bytes[part(bytes.len(), dice)].to_vec();
            let times = if dice.below(8) == 0 { 200 } else { 1 + dice.index(4) };
            drop(bytes.splice(at..at, part.repeat(times)));
        }
        7 => {
            let other = one(corpus, dice);
            drop(bytes.splice(at..at, other[part(other.len(), dice)].iter().copied()));
        }
        _ => {
            let other = one(corpus, dice);
            bytes.truncate(at);
            bytes.extend_from_slice(&other[dice.index(other.len() + 1)..]);
        }
    }
}

/// The word or number around a position.
fn token(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let is_part = |byte: &&u8| byte.is_ascii_alphanumeric() || b"+-._".contains(byte);
    let before = bytes[..at].iter().rev().take_while(is_part).count();
    let after = bytes[at..].iter().take_while(is_part).count();
    at - before..at + after
}

/// The words of a libFuzzer dictionary: one quoted word per line, with bytes as `\xAB`.
pub fn dictionary(text: &str) -> Vec<Vec<u8>> {
    let quoted = |line: &str| {
        let line = line.trim().strip_prefix('"')?.strip_suffix('"')?;
        Some(unescaped(line))
    };
    text.lines().filter_map(quoted).collect()
}

fn unescaped(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    loop {
        rest = match rest {
            [b'\\', b'x', high, low, rest @ ..] => {
                let digit = |byte: u8| char::from(byte).to_digit(16).expect("hexadecimal digits") as u8;
                bytes.push(16 * digit(*high) + digit(*low));
                rest
            }
            [b'\\', byte, rest @ ..] | [byte, rest @ ..] => {
                bytes.push(*byte);
                rest
            }
            [] => return bytes,
        };
    }
}
