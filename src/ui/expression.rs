//! Numbers as people type them: `12,5`, `2 cm`, `3*7`, `(1 + 2) / 4`.

/// Kinds of units, with factors to the first of each kind.
const KINDS: &[&[(&str, f64)]] = &[
    &[
        ("m", 1.0),
        ("cm", 1e-2),
        ("mm", 1e-3),
        ("µm", 1e-6),
        ("μm", 1e-6),
        ("um", 1e-6),
        ("nm", 1e-9),
        ("in", 0.0254),
    ],
    &[("°", 1.0), ("deg", 1.0), ("rad", 180.0 / std::f64::consts::PI)],
    &[("Pa", 1.0), ("hPa", 1e2), ("mbar", 1e2), ("kPa", 1e3), ("MPa", 1e6)],
    &[("Hz", 1.0), ("kHz", 1e3), ("MHz", 1e6)],
    &[("s", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("μs", 1e-6), ("us", 1e-6)],
    &[("", 1.0), ("%", 1e-2)],
];
/// Brackets within brackets.
const DEEPEST: usize = 32;

/// The value of a text in a field's unit, which is the default unit of numbers.
///
/// # Errors
/// The unreadable part, as a sentence.
pub fn parse(text: &str, unit: &str) -> Result<f64, String> {
    let mut reader = Reader { rest: text.trim(), unit: unit.trim(), depth: 0 };
    if reader.rest.is_empty() {
        return Err("A number is missing".to_owned());
    }
    let value = reader.sum()?;
    match reader.rest {
        "" if value.is_finite() => Ok(value),
        "" => Err("The result is not a finite number".to_owned()),
        rest => Err(format!("“{}” is not a number or a unit", crate::echo::value(rest))),
    }
}

struct Reader<'a> {
    rest: &'a str,
    unit: &'a str,
    depth: usize,
}

impl Reader<'_> {
    /// Consumes the next sign if it is one of these synonyms.
    fn takes(&mut self, signs: &[char]) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(signs) {
            Some(rest) => {
                self.rest = rest.trim_start();
                true
            }
            None => false,
        }
    }

    fn sum(&mut self) -> Result<f64, String> {
        let mut value = self.product()?;
        loop {
            if self.takes(&['+']) {
                value += self.product()?;
            } else if self.takes(&['-', '−']) {
                value -= self.product()?;
            } else {
                return Ok(value);
            }
        }
    }

    fn product(&mut self) -> Result<f64, String> {
        let mut value = self.factor()?;
        loop {
            if self.takes(&['*', '×', '·']) {
                value *= self.factor()?;
            } else if self.takes(&['/', '÷', ':']) {
                value /= self.factor()?;
            } else {
                return Ok(value);
            }
        }
    }

    fn factor(&mut self) -> Result<f64, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err("Too many signs and brackets".to_owned());
        }
        let value = if self.takes(&['-', '−']) {
            -self.factor()?
        } else if self.takes(&['+']) {
            self.factor()?
        } else if self.takes(&['(']) {
            let value = self.sum()?;
            if !self.takes(&[')']) {
                return Err("A closing bracket is missing".to_owned());
            }
            value * self.unit_behind()?
        } else {
            self.number()? * self.unit_behind()?
        };
        self.depth -= 1;
        Ok(value)
    }

    fn number(&mut self) -> Result<f64, String> {
        let bytes = self.rest.as_bytes();
        let mut end = 0;
        while end < bytes.len() {
            let is_exponent = end > 0
                && matches!(bytes[end], b'e' | b'E')
                && matches!(bytes.get(end + 1..), Some([b'0'..=b'9', ..] | [b'+' | b'-', b'0'..=b'9', ..]));
            match bytes[end] {
                b'0'..=b'9' | b'.' | b',' => end += 1,
                _ if is_exponent => end += 2,
                _ => break,
            }
        }
        let (number, rest) = self.rest.split_at(end);
        if number.is_empty() {
            let what = if rest.is_empty() {
                "A number is missing at the end".to_owned()
            } else {
                format!("“{}” is not a number", crate::echo::value(rest))
            };
            return Err(what);
        }
        self.rest = rest.trim_start();
        let plain = number.replace(',', ".");
        plain.parse().map_err(|_| {
            format!(
                "“{}” is not a number: one point or comma, before the decimals",
                crate::echo::value(number)
            )
        })
    }

    /// Applies a unit behind a number or a bracket, converting to the field's unit.
    fn unit_behind(&mut self) -> Result<f64, String> {
        let own = self.unit;
        if !own.is_empty()
            && let Some(rest) = self.rest.strip_prefix(own).filter(|rest| ends(rest))
        {
            self.rest = rest;
            return Ok(1.0);
        }
        let end =
            self.rest.find(|c: char| !(c.is_alphabetic() || "°%".contains(c))).unwrap_or(self.rest.len());
        let (name, rest) = self.rest.split_at(end);
        if name.is_empty() {
            return Ok(1.0);
        }
        let kind = KINDS.iter().find(|kind| kind.iter().any(|(unit, _)| *unit == name));
        let size = |wanted: &str| kind?.iter().find(|(unit, _)| *unit == wanted).map(|(_, size)| *size);
        let Some(given) = size(name) else {
            return Err(format!("“{}” is not a unit that is known here", crate::echo::value(name)));
        };
        let Some(own) = size(own) else {
            return Err(match own {
                "" => format!("“{name}” does not fit: this value has no unit"),
                own => format!("“{name}” does not fit: this value is in {own}"),
            });
        };
        self.rest = rest;
        Ok(given / own)
    }
}

/// Whether a unit ends here.
fn ends(rest: &str) -> bool {
    !rest.starts_with(char::is_alphabetic)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_units_and_sums_are_read() {
        for (text, unit, value) in [
            ("12,5", " mm", 12.5),
            ("2cm", " mm", 20.0),
            ("1.5 in", "mm", 38.1),
            ("3*7", "", 21.0),
            ("(1+2)/4", "", 0.75),
            ("-3", " mm", -3.0),
            ("−3 + 5", " mm", 2.0),
            ("--2", "", 2.0),
            ("2 cm + 3", " mm", 23.0),
            ("2 * (1 + 1) cm", " mm", 40.0),
            ("1e-3 m", " mm", 1.0),
            ("250 µm", " mm", 0.25),
            ("0,5 rad", "°", 90.0 / std::f64::consts::PI),
            ("45deg", "°", 45.0),
            ("2 kPa", " Pa", 2000.0),
            ("40000 Hz", " kHz", 40.0),
            ("5ms", " s", 0.005),
            ("50 %", "", 0.5),
            ("50 %", " %", 50.0),
            ("50", " %", 50.0),
            ("340 m/s", " m/s", 340.0),
            ("1,2 Pa·m", " Pa·m", 1.2),
            (" 8 ÷ 2 × 3 ", "", 12.0),
            (".5", "", 0.5),
            ("10 - 2 - 3", "", 5.0),
        ] {
            let read = parse(text, unit).unwrap_or_else(|error| panic!("{text}: {error}"));
            assert!((read - value).abs() < 1e-9, "{text}: {read}, not {value}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_explained() {
        for (text, unit, why) in [
            ("abc", " mm", "“abc” is not a number"),
            ("", " mm", "missing"),
            ("3*", " mm", "missing at the end"),
            ("(1+2", "", "closing bracket"),
            ("12x", "", "“x” is not a unit"),
            ("1.2.3", "", "“1.2.3” is not a number"),
            ("1,000.5", "", "one point or comma"),
            ("2 kg", " mm", "“kg” is not a unit"),
            ("3 Hz", " mm", "this value is in mm"),
            ("3 mm", "", "has no unit"),
            ("1/0", "", "finite"),
            ("1e999", "", "finite"),
            ("2 3", "", "“3” is not"),
            ("NaN", "", "“NaN” is not a number"),
        ] {
            let error = parse(text, unit).unwrap_err();
            assert!(error.contains(why), "{text}: {error}");
        }
        assert!(parse(&"(".repeat(100_000), "").is_err());
        assert!(parse(&"-".repeat(100_000), "").is_err());
    }
}
