//! Ticks with round values on the axes of figures.

/// 1, 2 or 5 times a power of ten, not less than `least`.
pub fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|step| step * power)
        .find(|&step| step >= least * 0.999)
        .unwrap_or(least)
}

/// Round values from `low` to `high`, at most about `most` of them but three if there are so many, as numbers and as text.
pub fn steps(low: f64, high: f64, most: f64) -> Vec<(f64, String)> {
    /// Numbers that show a scale.
    const LEAST: usize = 3;
    let coarse = multiples(low, high, most);
    if coarse.len() < LEAST { multiples(low, high, 2.0 * most) } else { coarse }
}

fn multiples(low: f64, high: f64, most: f64) -> Vec<(f64, String)> {
    let step = round_step(((high - low) / most).max(1e-12));
    let decimals = (-(step * 1.001).log10().floor()).clamp(0.0, 9.0) as usize;
    let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
    (first..=last).map(|index| index as f64 * step).map(|value| (value, number(value, decimals))).collect()
}

/// A number with these decimals, as [`signed`].
pub fn number(value: f64, decimals: usize) -> String {
    signed(&format!("{value:.decimals$}"))
}

/// A number as text, perhaps with its unit: a true minus sign, and none before zero.
pub fn signed(text: &str) -> String {
    let Some(rest) = text.strip_prefix('-') else { return text.to_owned() };
    let digits = rest.split(|sign: char| !sign.is_ascii_digit() && sign != '.').next().unwrap_or(rest);
    let is_zero = digits.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    if is_zero { rest.to_owned() } else { format!("−{rest}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_round_numbers() {
        assert_eq!((round_step(0.7), round_step(1.0), round_step(21.0)), (1.0, 1.0, 50.0));
        let words = |low, high, most| -> Vec<String> {
            steps(low, high, most).into_iter().map(|(_, word)| word).collect()
        };
        assert_eq!(words(-100.0, 100.0, 4.0), ["−100", "−50", "0", "50", "100"]);
        assert_eq!(words(0.0, 0.73, 5.0), ["0.0", "0.2", "0.4", "0.6"]);
        assert_eq!(words(-40.0, 0.0, 4.0), ["−40", "−30", "−20", "−10", "0"]);
        assert_eq!(words(0.0, 1234.0, 3.0), ["0", "500", "1000"]);
        assert_eq!(words(-460.0, 460.0, 4.0), ["−400", "−200", "0", "200", "400"], "not 0 alone");
    }
}
