//! Numbers as text, with their units: rounded to decimals or significant digits; bounds are rounded outwards.

/// The largest number of `decimals` decimals that is at most a value, for lower bounds.
pub fn at_least(value: f64, decimals: usize) -> String {
    outwards(value, decimals, -1.0)
}

/// The smallest number of `decimals` decimals that is at least a value, for upper bounds.
pub fn at_most(value: f64, decimals: usize) -> String {
    outwards(value, decimals, 1.0)
}

/// A part of 1 in per cent, to two decimals.
pub fn percent(part: f64) -> String {
    format!("{:.2} %", 100.0 * part)
}

/// A lower bound of a part of 1 in per cent.
pub fn percent_at_least(part: f64, decimals: usize) -> String {
    format!("{} %", at_least(100.0 * part, decimals))
}

/// An upper bound of a part of 1 in per cent.
pub fn percent_at_most(part: f64, decimals: usize) -> String {
    format!("{} %", at_most(100.0 * part, decimals))
}

/// A length (m) in mm, without its unit and without a sign on zero.
pub fn millimetres(length: f64, decimals: usize) -> String {
    let unit = 10f64.powi(decimals as i32);
    format!("{:.decimals$}", (length * 1e3 * unit).round() / unit + 0.0)
}

/// A time (s) in ms, with its unit.
pub fn milliseconds(seconds: f64, decimals: usize) -> String {
    format!("{:.decimals$} ms", seconds * 1e3)
}

/// A pressure with the unit that suits it.
pub fn pascals(pressure: f64) -> String {
    pascals_by(pressure, |value, decimals| format!("{value:.decimals$}"))
}

/// An upper bound of a pressure, as text.
pub fn pascals_at_most(pressure: f64) -> String {
    pascals_by(pressure, at_most)
}

fn pascals_by(pressure: f64, rounded: impl Fn(f64, usize) -> String) -> String {
    let (value, unit) = if pressure >= 1000.0 { (pressure / 1000.0, "kPa") } else { (pressure, "Pa") };
    let decimals = if value >= 100.0 {
        1
    } else if value >= 10.0 {
        2
    } else {
        3
    };
    format!("{} {unit}", rounded(value, decimals))
}

/// A value to four digits; below a thousandth with its power of ten.
pub fn digits(value: f64) -> String {
    const DIGITS: i32 = 4;
    const SMALL: f64 = 1e-3;
    if value == 0.0 || !value.is_finite() {
        return format!("{}", value + 0.0);
    }
    if value.abs() < SMALL {
        return format!("{value:.*e}", DIGITS as usize - 1);
    }
    let decimals = (DIGITS - 1 - value.abs().log10().floor() as i32).max(0);
    format!("{value:.*}", decimals as usize)
}

/// The nearest number of `decimals` decimals on the side of `sign`.
fn outwards(value: f64, decimals: usize, sign: f64) -> String {
    /// Above, all neighbours are whole numbers.
    const EXACT: f64 = (1u64 << 53) as f64;
    let unit = 10f64.powi(decimals as i32);
    let scaled = sign * value * unit;
    if scaled.is_nan() || scaled.abs() >= EXACT {
        return format!("{value:.decimals$}");
    }
    // The product may have been rounded inwards.
    let whole = scaled.ceil();
    let whole = if whole / unit < sign * value { whole + 1.0 } else { whole };
    format!("{:.decimals$}", sign * whole / unit + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_never_inside_what_they_bound() {
        let mut value = 1e-7f64;
        while value < 1e18 {
            for decimals in 0..4 {
                for value in [value, -value] {
                    let least: f64 = at_least(value, decimals).parse().unwrap();
                    let most: f64 = at_most(value, decimals).parse().unwrap();
                    assert!(least <= value && value <= most, "{least} {value} {most}");
                    let unit = 10f64.powi(-(decimals as i32));
                    assert!(most - least <= unit * (1.0 + 1e-9) + 4.0 * f64::EPSILON * value.abs());
                }
            }
            value *= 1.37;
        }
        for (value, least, most) in [(0.0, "0.00", "0.00"), (0.285, "0.28", "0.29"), (1.0, "1.00", "1.00")] {
            assert_eq!((at_least(value, 2), at_most(value, 2)), (least.to_owned(), most.to_owned()));
        }
        assert_eq!(
            (percent_at_least(0.999_96, 2), percent_at_most(0.999_91, 2)),
            ("99.99 %".into(), "100.00 %".into())
        );
        assert_eq!((at_least(-0.001, 2), at_most(-0.001, 2)), ("-0.01".to_owned(), "0.00".to_owned()));
        assert_eq!((at_least(f64::NAN, 1), at_most(f64::INFINITY, 1)), ("NaN".to_owned(), "inf".to_owned()));
    }

    #[test]
    fn lengths_have_no_negative_zero() {
        let lengths = [-1e-9, 0.0, -1e-4, 0.0123].map(|length| millimetres(length, 1));
        assert_eq!(lengths, ["0.0", "0.0", "-0.1", "12.3"]);
    }

    #[test]
    fn values_have_four_digits() {
        for (value, text) in [
            (189.44, "189.4"),
            (0.30004, "0.3000"),
            (12.0, "12.00"),
            (98765.0, "98765"),
            (2.56e-21, "2.560e-21"),
            (0.0, "0"),
        ] {
            assert_eq!(digits(value), text);
        }
    }
}
