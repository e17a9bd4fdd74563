//! Colour maps: one table of 256 colours for the GPU, the legend and the PNG.

use std::f64::consts::TAU;

use strum::IntoStaticStr;

use crate::field::Range;

/// A table of colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum ColourMap {
    #[default]
    Inferno,
    Viridis,
    /// Suitable for red-green colour blindness.
    Cividis,
    Magma,
    Grey,
    /// Cyclic, for phases: all hues at one lightness.
    Cyclic,
    /// Dark in the middle: from the most negative (blue) to the most positive (red).
    Diverging,
}

impl ColourMap {
    /// Choices for amounts; phases and signed values have their own map.
    pub const OF_AMOUNTS: [Self; 5] = [Self::Inferno, Self::Viridis, Self::Cividis, Self::Magma, Self::Grey];

    /// The name in menus.
    pub fn title(self) -> String {
        let (first, rest) = self.into_str().split_at(1);
        first.to_uppercase() + rest
    }

    /// Itself for amounts; other ranges have their own.
    pub fn suited_to(self, range: Range) -> Self {
        match range {
            Range::Amount => self,
            Range::Signed => Self::Diverging,
            Range::Cyclic => Self::Cyclic,
        }
    }

    /// r, g, b, a of 256 steps.
    pub fn table(self) -> [[u8; 4]; 256] {
        let gradient = match self {
            Self::Inferno => colorous::INFERNO,
            Self::Viridis => colorous::VIRIDIS,
            Self::Cividis => colorous::CIVIDIS,
            Self::Magma => colorous::MAGMA,
            // A straight line in sRGB is even to the eye.
            Self::Grey => return std::array::from_fn(|i| [i as u8, i as u8, i as u8, 255]),
            Self::Cyclic => return std::array::from_fn(|i| hue(i as f64 / 256.0)),
            Self::Diverging => return std::array::from_fn(|i| diverging(i as f64 / 127.5 - 1.0)),
        };
        std::array::from_fn(|i| {
            let colorous::Color { r, g, b } = gradient.eval_rational(i, 256);
            [r, g, b, 255]
        })
    }

    /// The table for a dark or a light ground.
    pub fn on(self, is_light: bool) -> [[u8; 4]; 256] {
        if is_light { self.table_on_light() } else { self.table() }
    }

    /// The table for a light ground, as in print: white at zero, darker with larger values.
    pub fn table_on_light(self) -> [[u8; 4]; 256] {
        /// Steps from white to the lightest colour of the table.
        const FADE: f64 = 64.0;
        let table = self.table();
        match self {
            Self::Inferno | Self::Viridis | Self::Cividis | Self::Magma | Self::Grey => {
                std::array::from_fn(|i| {
                    let white = (1.0 - i as f64 / FADE).max(0.0).powi(2);
                    let [r, g, b, _] = table[255 - i];
                    let mixed = |c: u8| (f64::from(c) + white * (255.0 - f64::from(c))).round() as u8;
                    [mixed(r), mixed(g), mixed(b), 255]
                })
            }
            Self::Diverging => std::array::from_fn(|i| diverging_on_light(i as f64 / 127.5 - 1.0)),
            Self::Cyclic => table,
        }
    }
}

/// The veil over a map with brightness by amount: opaque ground at zero, clear at the largest. Colours are
/// premultiplied by alpha.
pub fn veil(is_light: bool) -> [[u8; 4]; 256] {
    std::array::from_fn(|i| {
        let alpha = 255 - i as u8;
        let grey = if is_light { alpha } else { 0 };
        [grey, grey, grey, alpha]
    })
}

/// A colour under a veil.
pub fn veiled([r, g, b, a]: [u8; 4], [over_r, over_g, over_b, alpha]: [u8; 4]) -> [u8; 4] {
    let mixed =
        |under: u8, over: u8| over.saturating_add((u16::from(under) * u16::from(255 - alpha) / 255) as u8);
    [mixed(r, over_r), mixed(g, over_g), mixed(b, over_b), a]
}

/// The colour of a part of a turn, at one lightness and chroma of Oklab (B. Ottosson, "A perceptual color space for
/// image processing", 2020), the largest chroma available for all hues in sRGB. Phase 0, the middle, is orange.
fn hue(turn: f64) -> [u8; 4] {
    const LIGHTNESS: f64 = 0.74;
    const CHROMA: f64 = 0.12;
    const MIDDLE: f64 = 0.17;
    let angle = TAU * (turn - 0.5 + MIDDLE);
    let (a, b) = (CHROMA * angle.cos(), CHROMA * angle.sin());
    let l = (LIGHTNESS + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (LIGHTNESS - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (LIGHTNESS - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    let linear = [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ];
    let byte = |c: f64| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded).round() as u8
    };
    let [r, g, b] = linear.map(byte);
    [r, g, b, 255]
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

/// The same on a light ground: white in the middle, darker towards both ends.
fn diverging_on_light(part: f64) -> [u8; 4] {
    const NEGATIVE: [[f64; 3]; 2] = [[96.0, 156.0, 226.0], [10.0, 40.0, 110.0]];
    const POSITIVE: [[f64; 3]; 2] = [[234.0, 124.0, 92.0], [110.0, 12.0, 24.0]];
    let [half, end] = if part < 0.0 { NEGATIVE } else { POSITIVE };
    let place = 2.0 * part.abs();
    let (from, to, place) = if place < 1.0 { ([255.0; 3], half, place) } else { (half, end, place - 1.0) };
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
        for map in ColourMap::OF_AMOUNTS {
            let table = map.table();
            assert!(table.windows(2).all(|pair| lightness(pair[1]) > lightness(pair[0]) - 1.0), "{map:?}");
            assert!(lightness(table[255]) - lightness(table[0]) > 150.0, "{map:?}");
            let on_light = map.table_on_light();
            assert_eq!(on_light[0], [255; 4], "{map:?}");
            assert!(on_light.windows(2).all(|pair| lightness(pair[1]) < lightness(pair[0]) + 1.0), "{map:?}");
        }
        let diverging = ColourMap::Diverging.table();
        for i in 0..128 {
            let (low, high) = (lightness(diverging[127 - i]), lightness(diverging[128 + i]));
            assert!((low - high).abs() < 12.0, "{i}: {low} {high}");
            assert!(i == 0 || high >= lightness(diverging[127 + i]), "{i}");
        }
        assert!(diverging[0][2] > diverging[0][0] && diverging[255][0] > diverging[255][2]);
        let orange = ColourMap::Cyclic.table()[128];
        for (is_light, ground) in [(false, [0, 0, 0, 255]), (true, [255; 4])] {
            let veil = veil(is_light);
            assert_eq!([veiled(orange, veil[0]), veiled(orange, veil[255])], [ground, orange]);
        }
        let cyclic = ColourMap::Cyclic.table();
        let step = |a: [u8; 4], b: [u8; 4]| a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(step(cyclic[0], cyclic[255]) <= Some(8));
        // Relative luminance (IEC 61966-2-1) of one Oklab lightness: within a few per cent, where a rainbow has a factor of ten.
        let luminance = |[r, g, b, _]: [u8; 4]| {
            let linear = |c: u8| (f64::from(c) / 255.0 + 0.055).powf(2.4) / 1.055f64.powf(2.4);
            0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
        };
        let all = cyclic.map(luminance);
        let (least, most) = all.iter().fold((f64::MAX, 0.0f64), |(a, b), &l| (a.min(l), b.max(l)));
        assert!(most / least < 1.35, "{least} {most}");
    }
}
