//! Colour maps: one table of 256 colours for the GPU, the legend and the PNG.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use num_complex::Complex32;

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
        };
        // The last of a cyclic map is one step before the first.
        let steps = if self == Self::Cyclic { 257 } else { 256 };
        std::array::from_fn(|i| {
            let colorous::Color { r, g, b } = gradient.eval_rational(i, steps);
            [r, g, b, 255]
        })
    }
}

/// What of a complex pressure is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// |P|/√2, from 0 to the field's peak.
    Rms,
    /// arg P, once round the cyclic map.
    Phase,
}

impl Quantity {
    /// The number that is shown: Pa, or rad in (-π, π].
    pub fn of(self, p: Complex32) -> f32 {
        match self {
            Self::Rms => p.norm() * FRAC_1_SQRT_2 as f32,
            Self::Phase => p.arg(),
        }
    }
}

/// The field as colours r, g, b, a, in its own order; `full` is the |p| (Pa, peak) that gets the last colour. What
/// `shaders/picture.wgsl` does.
pub fn colours(field: &[Complex32], quantity: Quantity, table: &[[u8; 4]; 256], full: f32) -> Vec<u8> {
    let per_pascal = 255.0 / full.max(1e-30);
    let coloured: Vec<[u8; 4]> = match quantity {
        // No hypotenuse that guards against overflow: pressures are nowhere near it.
        Quantity::Rms => field
            .iter()
            .map(|p| table[(p.norm_sqr().sqrt() * per_pascal + 0.5).min(255.0) as usize])
            .collect(),
        Quantity::Phase => field.iter().map(|p| table[phase_index(f64::from(p.arg()))]).collect(),
    };
    coloured.into_flattened()
}

/// The place of a phase (rad) in a cyclic table.
pub fn phase_index(phase: f64) -> usize {
    (((phase / TAU + 0.5).rem_euclid(1.0) * 256.0) as usize).min(255)
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
        let cyclic = ColourMap::Cyclic.table();
        let step = |a: [u8; 4], b: [u8; 4]| a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(step(cyclic[0], cyclic[255]) <= Some(8));
    }

    #[test]
    fn the_peak_gets_the_last_colour_and_silence_the_first() {
        let field = [Complex32::new(0.0, -3.0), Complex32::ZERO, Complex32::new(1.5, 0.0)];
        let table = ColourMap::Grey.table();
        let colours = colours(&field, Quantity::Rms, &table, 3.0);
        assert_eq!([colours[0], colours[4], colours[8]], [255, 0, 128]);
    }

    #[test]
    fn phases_next_to_the_cut_get_neighbouring_places() {
        let cut = std::f64::consts::PI - 1e-4;
        assert_eq!((phase_index(cut), phase_index(-cut), phase_index(1e-4)), (255, 0, 128));
    }
}
