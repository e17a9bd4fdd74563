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
}
