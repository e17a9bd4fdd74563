//! Modulation waveforms from WAV files: PCM of 8 to 32 bits or 32-bit floating point, with channels averaged.

use std::io::Cursor;
use std::path::Path;

use hound::{SampleFormat, WavReader};

use crate::echo;
use crate::scene::{Wave, Waveform};
use crate::source;

/// Bytes of a file, at most.
const MOST_BYTES: u64 = 64 << 20;
/// Samples of a waveform, at most: 21 s at 48 kHz.
pub const MOST_SAMPLES: usize = 1_000_000;
/// Samples per second: enough to count as a time, and less than a carrier has periods.
const RATES: std::ops::RangeInclusive<u32> = 1..=1_000_000;

/// The waveform of a file.
///
/// # Errors
/// An error with the file's name: unreadable, unsupported, empty or too long, or with a value outside -1 to 1.
pub fn read(path: &Path) -> Result<Wave, String> {
    let named = |error: String| format!("{}: {error}", path.display());
    let bytes = source::read(path, MOST_BYTES).map_err(|error| named(error.to_string()))?;
    let (rate, values) = decode(&bytes).map_err(named)?;
    Ok(Wave::new(Waveform { file: path.to_owned(), rate, values }))
}

/// Samples per second, and the samples, of the bytes of a file.
///
/// # Errors
/// The errors of [`read`].
pub fn decode(bytes: &[u8]) -> Result<(f64, Vec<f32>), String> {
    let broken = |error: hound::Error| {
        format!(
            "this is no WAV file that is read here: {}; save it as PCM of 8 to 32 bits, or as 32-bit floating point",
            echo::value(&error.to_string())
        )
    };
    let mut reader = WavReader::new(Cursor::new(bytes)).map_err(broken)?;
    let spec = reader.spec();
    let channels = usize::from(spec.channels);
    if channels == 0 || !RATES.contains(&spec.sample_rate) {
        return Err(format!(
            "{channels} channels at {} Hz: a waveform has one at least, at up to 1 MHz",
            spec.sample_rate
        ));
    }
    let count = reader.len() as usize / channels;
    if count == 0 {
        return Err("there are no samples in it".to_owned());
    }
    if count > MOST_SAMPLES {
        let seconds = |count: usize| count as f64 / f64::from(spec.sample_rate);
        return Err(format!(
            "{count} samples, {:.1} s, are more than the {MOST_SAMPLES} that a waveform may have, {:.1} s at {} Hz: cut it, or \
             resample it",
            seconds(count),
            seconds(MOST_SAMPLES),
            spec.sample_rate
        ));
    }
    let samples: Vec<f32> = match spec.sample_format {
        SampleFormat::Float => reader.samples::<f32>().collect::<Result<_, _>>().map_err(broken)?,
        SampleFormat::Int => {
            let full = f64::from(2u32.pow(u32::from(spec.bits_per_sample.clamp(1, 32)) - 1));
            let part = |sample: i32| (f64::from(sample) / full) as f32;
            reader
                .samples::<i32>()
                .map(|sample| sample.map(part))
                .collect::<Result<_, _>>()
                .map_err(broken)?
        }
    };
    let mean = |frame: &[f32]| frame.iter().sum::<f32>() / channels as f32;
    let values: Vec<f32> = samples.chunks_exact(channels).map(mean).collect();
    if let Some(index) = values.iter().position(|value| !(-1.0..=1.0).contains(value)) {
        return Err(format!("sample {} is {}: samples are numbers from -1 to 1", index + 1, values[index]));
    }
    Ok((spec.sample_rate.into(), values))
}

#[cfg(test)]
mod tests {
    use hound::{WavSpec, WavWriter};

    use super::*;

    fn spec(channels: u16, bits_per_sample: u16, sample_format: SampleFormat) -> WavSpec {
        WavSpec { channels, sample_rate: 8000, bits_per_sample, sample_format }
    }

    fn file(spec: WavSpec, write: impl FnOnce(&mut WavWriter<&mut Cursor<Vec<u8>>>)) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let mut writer = WavWriter::new(&mut bytes, spec).unwrap();
        write(&mut writer);
        writer.finalize().unwrap();
        bytes.into_inner()
    }

    #[test]
    fn every_width_of_samples_is_read_in_parts_of_full_scale() {
        for bits in [8u16, 16, 24, 32] {
            let full = 1i64 << (bits - 1);
            let bytes = file(spec(2, bits, SampleFormat::Int), |writer| {
                for value in [-full, 0, full / 2, full / 2] {
                    writer.write_sample(value as i32).unwrap();
                }
            });
            assert_eq!(decode(&bytes).unwrap(), (8000.0, vec![-0.5, 0.5]), "{bits} bits");
        }
        let bytes = file(spec(1, 32, SampleFormat::Float), |writer| {
            for value in [-1.0f32, 0.25, 1.0] {
                writer.write_sample(value).unwrap();
            }
        });
        assert_eq!(decode(&bytes).unwrap(), (8000.0, vec![-1.0, 0.25, 1.0]));
    }

    #[test]
    fn what_is_no_waveform_is_refused() {
        let error = |bytes: &[u8]| decode(bytes).unwrap_err();
        assert!(error(b"no sound at all").contains("no WAV file"));
        let empty = file(spec(1, 16, SampleFormat::Int), |_| {});
        assert!(error(&empty).contains("no samples"));
        for (value, says) in [(1.5f32, "sample 2 is 1.5"), (f32::NAN, "sample 2 is NaN")] {
            let loud = file(spec(1, 32, SampleFormat::Float), |writer| {
                writer.write_sample(0.0f32).unwrap();
                writer.write_sample(value).unwrap();
            });
            assert!(error(&loud).contains(says), "{}", error(&loud));
        }
        let long = file(spec(1, 8, SampleFormat::Int), |writer| {
            for _ in 0..=MOST_SAMPLES {
                writer.write_sample(0i8).unwrap();
            }
        });
        assert!(
            error(&long).contains("1000001 samples, 125.0 s, are more than the 1000000"),
            "{}",
            error(&long)
        );
        let cut = file(spec(1, 16, SampleFormat::Int), |writer| {
            (0..100).for_each(|i| writer.write_sample(i as i16).unwrap());
        });
        assert!(error(&cut[..cut.len() - 50]).contains("no WAV file"));
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let error = read(Path::new("nowhere/buzz.wav")).unwrap_err();
        assert!(error.contains("buzz.wav: no such file"), "{error}");
    }
}
