//! Colour maps: one table of 256 colours for the GPU, the legend and the PNG.

/// A table of colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourMap {
    #[default]
    Inferno,
    Viridis,
    Magma,
    Grey,
    /// The only one whose ends meet, for phases.
    Cyclic,
    /// Dark in the middle: from the most negative (blue) to the most positive (red).
    Diverging,
}

impl ColourMap {
    /// r, g, b, a of 256 steps.
    pub fn table(self) -> [[u8; 4]; 256] {
        let gradient = match self {
            Self::Inferno => colorous::INFERNO,
            Self::Viridis => colorous::VIRIDIS,
            Self::Magma => colorous::MAGMA,
            // A straight line in sRGB is even to the eye.
            Self::Grey => return std::array::from_fn(|i| [i as u8, i as u8, i as u8, 255]),
            Self::Cyclic => colorous::RAINBOW,
            Self::Diverging => return std::array::from_fn(|i| diverging(i as f64 / 127.5 - 1.0)),
        };
        // The last of a cyclic map is one step before the first.
        let steps = if self == Self::Cyclic { 257 } else { 256 };
        std::array::from_fn(|i| {
            let colorous::Color { r, g, b } = gradient.eval_rational(i, steps);
            [r, g, b, 255]
        })
    }
}

/// The colour of a part of the largest, -1 to 1. Both arms get lighter alike.
fn diverging(part: f64) -> [u8; 4] {
    const MIDDLE: [f64; 3] = [14.0, 14.0, 18.0];
    const NEGATIVE: [[f64; 3]; 2] = [[38.0, 100.0, 214.0], [182.0, 228.0, 255.0]];
    const POSITIVE: [[f64; 3]; 2] = [[206.0, 56.0, 40.0], [255.0, 214.0, 150.0]];
    let [half, end] = if part < 0.0 { NEGATIVE } else { POSITIVE };
    let place = 2.0 * part.abs();
    let (from, to, place) = if place < 1.0 { (MIDDLE, half, place) } else { (half, end, place - 1.0) };
    let channel = |i: usize| (from[i] + (to[i] - from[i]) * place).round() as u8;
    [channel(0), channel(1), channel(2), 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_run_from_dark_to_light_and_the_cyclic_one_closes() {
        let lightness =
            |[r, g, b, _]: [u8; 4]| 0.21 * f64::from(r) + 0.72 * f64::from(g) + 0.07 * f64::from(b);
        for map in [ColourMap::Inferno, ColourMap::Viridis, ColourMap::Magma, ColourMap::Grey] {
            let table = map.table();
            assert!(table.windows(2).all(|pair| lightness(pair[1]) > lightness(pair[0]) - 1.0), "{map:?}");
            assert!(lightness(table[255]) - lightness(table[0]) > 150.0, "{map:?}");
        }
        let diverging = ColourMap::Diverging.table();
        for i in 0..128 {
            let (low, high) = (lightness(diverging[127 - i]), lightness(diverging[128 + i]));
            assert!((low - high).abs() < 12.0, "{i}: {low} {high}");
            assert!(i == 0 || high >= lightness(diverging[127 + i]), "{i}");
        }
        assert!(diverging[0][2] > diverging[0][0] && diverging[255][0] > diverging[255][2]);
        let cyclic = ColourMap::Cyclic.table();
        let step = |a: [u8; 4], b: [u8; 4]| a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(step(cyclic[0], cyclic[255]) <= Some(8));
    }
}
