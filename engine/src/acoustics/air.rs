//! Air: sound speed, density and absorption from temperature, humidity and pressure.

use crate::scene::Medium;

/// dB per neper, 20/ln 10.
const DB_PER_NEPER: f64 = 20.0 / std::f64::consts::LN_10;

/// The properties of the air for a wave of one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// m/s
    pub sound_speed: f64,
    /// kg/m³
    pub density: f64,
    /// Np/m: pressure falls by e^{-attenuation · r}.
    pub attenuation: f64,
    /// The same at twice the frequency, Np/m.
    pub attenuation_of_second: f64,
}

impl Air {
    /// The medium at `frequency` (Hz); given properties override derived ones.
    ///
    /// Sound speed ([`Medium::speed_of_sound`]) and density, ρ = p/(287.05 T), are those of dry air: humidity would raise c by
    /// less than 0.3 % below 30 °C.
    pub fn new(medium: &Medium, frequency: f64) -> Self {
        let kelvin = medium.kelvin();
        let of_weather =
            |frequency: f64| absorption(frequency, medium.temperature, medium.humidity, medium.pressure);
        let [own, second] = [frequency, 2.0 * frequency].map(of_weather);
        // A given absorption rises with the frequency as that of the weather.
        let absorption = medium.absorption.unwrap_or(own);
        Self {
            sound_speed: medium.speed_of_sound(),
            density: medium.density.unwrap_or_else(|| medium.pressure / (287.05 * kelvin)),
            attenuation: absorption / DB_PER_NEPER,
            attenuation_of_second: second * (absorption / own) / DB_PER_NEPER,
        }
    }

    /// Derived from the weather alone, ignoring given properties.
    pub fn of_weather(medium: &Medium, frequency: f64) -> Self {
        let weather = Medium { sound_speed: None, density: None, absorption: None, ..medium.clone() };
        Self::new(&weather, frequency)
    }

    /// dB/m
    pub fn absorption(&self) -> f64 {
        self.attenuation * DB_PER_NEPER
    }
}

/// Viscosity of air, Pa·s, by Sutherland's law with the constants of the U.S. Standard Atmosphere, 1976.
pub fn viscosity(medium: &Medium) -> f64 {
    const OF_ROOT: f64 = 1.458e-6;
    const SUTHERLAND: f64 = 110.4;
    let kelvin = medium.kelvin();
    OF_ROOT * kelvin.powf(1.5) / (kelvin + SUTHERLAND)
}

/// Atmospheric absorption in dB/m by ISO 9613-1, equations (3) to (5) and (B.1) to (B.3).
///
/// `frequency` in Hz, `temperature` in °C, relative `humidity` in %, `pressure` in Pa.
pub fn absorption(frequency: f64, temperature: f64, humidity: f64, pressure: f64) -> f64 {
    let kelvin = temperature + Medium::ZERO_CELSIUS;
    let (relative_temperature, relative_pressure) = (kelvin / 293.15, pressure / 101_325.0);
    let saturation = 10f64.powf(-6.8346 * (273.16 / kelvin).powf(1.261) + 4.6151);
    let vapour = humidity * saturation / relative_pressure;
    let oxygen = relative_pressure * (24.0 + 4.04e4 * vapour * (0.02 + vapour) / (0.391 + vapour));
    let nitrogen = relative_pressure
        * relative_temperature.powf(-0.5)
        * (9.0 + 280.0 * vapour * (-4.170 * (relative_temperature.powf(-1.0 / 3.0) - 1.0)).exp());
    let square = frequency * frequency;
    let relaxation = 0.01275 * (-2239.1 / kelvin).exp() / (oxygen + square / oxygen)
        + 0.1068 * (-3352.0 / kelvin).exp() / (nitrogen + square / nitrogen);
    8.686
        * square
        * (1.84e-11 / relative_pressure * relative_temperature.sqrt()
            + relative_temperature.powf(-2.5) * relaxation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_air_is_that_of_the_design() {
        let air = Air::new(&Medium::default(), 40_000.0);
        assert!((air.sound_speed - 343.2).abs() < 0.05, "{air:?}");
        assert!((air.density - 1.204).abs() < 5e-4, "{air:?}");
        assert!((air.attenuation - 0.152).abs() < 1e-3, "{air:?}");
    }

    /// ISO 9613-2, table 2: dB/km in octaves from 63 Hz to 8 kHz, by °C and %.
    #[test]
    fn absorption_is_that_of_the_standards_table() {
        const PRESSURE: f64 = 101_325.0;
        for (temperature, humidity, row) in [
            (10.0, 70.0, [0.1, 0.4, 1.0, 1.9, 3.7, 9.7, 32.8, 117.0]),
            (20.0, 70.0, [0.1, 0.3, 1.1, 2.8, 5.0, 9.0, 22.9, 76.6]),
            (30.0, 70.0, [0.1, 0.3, 1.0, 3.1, 7.4, 12.7, 23.1, 59.3]),
            (15.0, 20.0, [0.3, 0.6, 1.2, 2.7, 8.2, 28.2, 88.8, 202.0]),
            (15.0, 50.0, [0.1, 0.5, 1.2, 2.2, 4.2, 10.8, 36.2, 129.0]),
            (15.0, 80.0, [0.1, 0.3, 1.1, 2.4, 4.1, 8.3, 23.7, 82.8]),
        ] {
            for (octave, expected) in row.into_iter().enumerate() {
                let frequency = 1000.0 * 10f64.powf(0.3 * (octave as f64 - 4.0));
                let own = 1000.0 * absorption(frequency, temperature, humidity, PRESSURE);
                let digit = if expected > 100.0 { 1.0 } else { 0.1 };
                assert!(
                    (own - expected).abs() < 0.6 * digit,
                    "{temperature} °C, {humidity} %: {own}, not {expected}"
                );
            }
        }
    }

    #[test]
    fn what_the_scene_gives_goes_first() {
        let medium = Medium {
            sound_speed: Some(346.0),
            density: Some(1.184),
            absorption: Some(8.0),
            ..Medium::default()
        };
        let air = Air::new(&medium, 40_000.0);
        assert_eq!((air.sound_speed, air.density), (346.0, 1.184));
        assert!((air.absorption() - 8.0).abs() < 1e-12, "{air:?}");
        assert!(((-air.attenuation).exp() - 10f64.powf(-8.0 / 20.0)).abs() < 1e-15);
    }

    /// U.S. Standard Atmosphere, 1976: at sea level, and at 11 km.
    #[test]
    fn viscosity_is_that_of_the_standard_atmosphere() {
        for (temperature, expected) in [(15.0, 1.7894e-5), (-56.5, 1.4216e-5)] {
            let own = viscosity(&Medium { temperature, ..Medium::default() });
            assert!((own - expected).abs() < 1e-9, "{temperature} °C: {own:e}, not {expected:e}");
        }
    }
}
