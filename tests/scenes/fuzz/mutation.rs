//! Mutations of a corpus: inputs cut, spliced, repeated, and with awkward words inserted.

/// Reproducible random numbers (Steele, Lea and Flood 2014, `SplitMix64`).
#[derive(Clone, Debug)]
pub struct Dice(pub u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Below `end`, or 0 if that is 0.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    fn byte(&mut self) -> u8 {
        self.next().to_le_bytes()[0]
    }

    fn one<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }

    /// A range within `length` bytes, mostly short.
    fn part(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length);
        let longest = if self.below(4) == 0 { length - start } else { (length - start).min(16) };
        start..start + self.below(longest + 1)
    }
}

/// Maximum size of a mutation, bytes.
const LONGEST: usize = 1 << 16;
const MOST_STEPS: usize = 8;

/// An input of the corpus with a few changes.
pub fn mutated(corpus: &[Vec<u8>], words: &[Vec<u8>], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = dice.one(corpus).clone();
    for _ in 0..=dice.below(MOST_STEPS) {
        change(&mut bytes, corpus, words, dice);
        bytes.truncate(LONGEST);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, corpus: &[Vec<u8>], words: &[Vec<u8>], dice: &mut Dice) {
    let at = dice.below(bytes.len() + 1);
    match dice.below(9) {
        0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << dice.below(8)),
        1 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte = dice.byte()),
        2 => drop(bytes.splice(at..at, dice.one(words).iter().copied())),
        3 | 4 => drop(bytes.splice(token(bytes, at), dice.one(words).iter().copied())),
        5 => drop(bytes.drain(dice.part(bytes.len()))),
        6 => {
            let part = bytes[dice.part(bytes.len())].to_vec();
            let times = if dice.below(8) == 0 { 200 } else { 1 + dice.below(4) };
            drop(bytes.splice(at..at, part.repeat(times)));
        }
        7 => {
            let other = dice.one(corpus);
            drop(bytes.splice(at..at, other[dice.part(other.len())].iter().copied()));
        }
        _ => {
            let other = dice.one(corpus);
            bytes.truncate(at);
            bytes.extend_from_slice(&other[dice.below(other.len() + 1)..]);
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
