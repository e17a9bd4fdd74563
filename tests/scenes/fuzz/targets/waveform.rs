//! Waveforms of modulations (WAV): their length is bounded, and the envelope stays between 0 and 1.

use sonoglyph::scene::{Envelope, Modulation, Wave, Waveform};
use sonoglyph::studio::waveform::{self, MOST_SAMPLES};

use super::is_one_line;

pub fn run(bytes: &[u8]) {
    match waveform::decode(bytes) {
        Ok((rate, values)) => {
            assert!(
                rate > 0.0 && (1..=MOST_SAMPLES).contains(&values.len()),
                "{} at {rate} Hz",
                values.len()
            );
            assert!(values.iter().all(|value| (-1.0..=1.0).contains(value)));
            let wave = Wave::new(Waveform { file: "a.wav".into(), rate, values });
            let modulation = Modulation { shape: Envelope::File, wave, ..Modulation::default() };
            assert!((0.0..=1.0).contains(&modulation.mean_square()));
            assert!((0..100).all(|n| (0.0..=1.0).contains(&modulation.envelope(f64::from(n) * 1e-3))));
        }
        Err(error) => is_one_line(&error),
    }
}
