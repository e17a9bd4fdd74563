//! Fault injection for virtual boards: line errors, unplugging, emergency stop.

use fastrand::Rng;
use web_time::Duration;

/// Per byte on its way to the board, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Faults {
    /// It gets lost.
    pub drop: f64,
    /// One of its bits is flipped.
    pub flip: f64,
    /// An additional byte is inserted before it.
    pub insert: f64,
    /// It and some that follow become noise.
    pub burst: f64,
    /// The board starts by sending garbage.
    pub garbage: bool,
    /// The board accepts nothing for this time, once.
    pub stall: Duration,
    /// The board is unplugged for this time, once.
    pub unplug: Duration,
    /// Its emergency stop is pressed for this time, once.
    pub press: Duration,
}

impl Faults {
    /// The faults of a text such as "drop=0.001,unplug=2,garbage".
    ///
    /// # Errors
    /// Names the invalid part.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut faults = Self::default();
        for part in text.split(',').map(str::trim) {
            let (name, value) = part.split_once('=').unwrap_or((part, "1"));
            let number = value.parse::<f64>().ok().filter(|number| (0.0..=3600.0).contains(number));
            let number = number.ok_or_else(|| format!("{part}: {value} is not a number from 0 to 3600"))?;
            let chance = || {
                if number <= 1.0 { Ok(number) } else { Err(format!("{part}: a probability is 1 at most")) }
            };
            match name {
                "drop" => faults.drop = chance()?,
                "flip" => faults.flip = chance()?,
                "insert" => faults.insert = chance()?,
                "burst" => faults.burst = chance()?,
                "garbage" => faults.garbage = number > 0.0,
                "stall" => faults.stall = Duration::from_secs_f64(number),
                "unplug" => faults.unplug = Duration::from_secs_f64(number),
                "press" => faults.press = Duration::from_secs_f64(number),
                _ => {
                    return Err(format!(
                        "{part}: faults are drop, flip, insert, burst, garbage, stall, unplug, press"
                    ));
                }
            }
        }
        Ok(faults)
    }
}

/// The way of bytes to the board.
#[derive(Clone, Debug)]
pub struct Damage {
    pub faults: Faults,
    chance: Rng,
    /// Remaining bytes of a burst.
    noisy: usize,
}

impl Damage {
    pub fn new(faults: Faults, seed: u64) -> Self {
        Self { faults, chance: Rng::with_seed(seed), noisy: 0 }
    }

    /// The bytes that arrive in place of a byte.
    pub fn pass(&mut self, byte: u8, arrived: &mut Vec<u8>) {
        const BURST: usize = 24;
        if self.happens(self.faults.burst) {
            self.noisy = BURST;
        }
        if self.noisy > 0 {
            self.noisy -= 1;
            arrived.push(self.chance.u8(..));
            return;
        }
        if self.happens(self.faults.insert) {
            arrived.push(self.chance.u8(..));
        }
        let flipped = if self.happens(self.faults.flip) { 1 << self.chance.u8(..8) } else { 0 };
        if !self.happens(self.faults.drop) {
            arrived.push(byte ^ flipped);
        }
    }

    /// Whether an event of this probability happens.
    fn happens(&mut self, probability: f64) -> bool {
        self.chance.f64() < probability
    }

    /// The byte that arrives at different bit rates: noise.
    pub fn garble(&mut self, arrived: &mut Vec<u8>) {
        arrived.push(self.chance.u8(..));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_read_and_nonsense_is_refused() {
        let faults = Faults::parse("drop=0.25, unplug=2,garbage").unwrap();
        assert_eq!((faults.drop, faults.unplug, faults.garbage), (0.25, Duration::from_secs(2), true));
        assert_eq!(Faults::parse("drop").unwrap().drop, 1.0, "the largest probability");
        for nonsense in ["", "drop=2", "drop=nan", "drop=-1", "melt=1", "stall=1e300"] {
            assert!(Faults::parse(nonsense).is_err(), "{nonsense}");
        }
    }

    #[test]
    fn damage_is_as_frequent_as_asked() {
        let passed = |faults| {
            let mut damage = Damage::new(faults, 5);
            let mut arrived = Vec::new();
            (0..100_000).for_each(|_| damage.pass(7, &mut arrived));
            arrived
        };
        assert_eq!(passed(Faults::default()), vec![7; 100_000]);
        let near = |count: usize, wanted: usize| count.abs_diff(wanted) < wanted / 5;
        assert!(near(100_000 - passed(Faults { drop: 0.01, ..Faults::default() }).len(), 1000));
        assert!(near(passed(Faults { insert: 0.01, ..Faults::default() }).len() - 100_000, 1000));
        let flipped = passed(Faults { flip: 0.01, ..Faults::default() });
        assert!(near(flipped.iter().filter(|&&byte| byte != 7).count(), 1000));
        let mut garbled = Vec::new();
        (0..1000).for_each(|_| Damage::new(Faults::default(), garbled.len() as u64).garble(&mut garbled));
        assert!(garbled.len() == 1000 && garbled.iter().any(|&byte| byte != garbled[0]));
        let noisy = passed(Faults { burst: 0.001, ..Faults::default() });
        assert!(near(noisy.iter().filter(|&&byte| byte != 7).count(), 2350));
    }
}
