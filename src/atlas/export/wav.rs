//! A signal of a run-up as a WAV file with 24 bits. The mean of the signal is removed. Full scale corresponds
//! to a given deviation from the mean.

use crate::store::{ResultTable, StoreError, TableKind, write_atomically};
use hound::{SampleFormat, WavSpec, WavWriter};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Columns of `signals.parquet` that are not signals.
const NO_SIGNALS: [&str; 3] = ["time", "speed", "load"];

/// Largest sample of 24 bits.
const LARGEST: f64 = 8_388_607.0;

/// A requested sound file.
#[derive(Debug)]
pub struct WavRequest<'a> {
    /// A folder that `atlas runup` wrote.
    pub folder: &'a Path,
    /// Column of `signals.parquet`; `None` for the first signal.
    pub signal: Option<&'a str>,
    /// Deviation from the mean at full scale, in the signal's unit; `None` for the largest deviation in the signal.
    pub full_scale: Option<f64>,
    /// The file; `None` for one beside the table.
    pub out: Option<&'a Path>,
    /// Whether an existing file is replaced.
    pub overwrite: bool,
}

/// The written file.
#[derive(Debug)]
pub struct WavFile {
    /// The column.
    pub signal: String,
    /// Unit of the signal.
    pub unit: String,
    /// Deviation from the mean at full scale, in the unit of the signal.
    pub full_scale: f64,
    /// Samples per second.
    pub rate: u32,
    /// Number of samples.
    pub samples: usize,
    /// Number of samples beyond full scale, which are clipped.
    pub clipped: usize,
    /// Path of the sound file.
    pub path: PathBuf,
}

/// A sound file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum SoundError {
    /// The table cannot be read, or the file cannot be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The column does not exist.
    #[error("there is no signal `{name}`; signals of this run-up: {known}")]
    Unknown {
        /// The name.
        name: String,
        /// Existing columns.
        known: String,
    },
    /// Full scale is not a positive number.
    #[error(
        "a full scale of {value} is not a positive number: give the value, about the mean, that the loudest sample has"
    )]
    Scale {
        /// The value.
        value: f64,
    },
    /// The signal is too short.
    #[error("the signal `{name}` has fewer than two samples")]
    Short {
        /// Name of the signal.
        name: String,
    },
    /// The signal does not vary.
    #[error("the signal `{name}` does not vary, so that there is nothing to hear")]
    Silent {
        /// Name of the signal.
        name: String,
    },
    /// The file exists.
    #[error("`{}` already exists; choose another file with --out, or replace it with --overwrite", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The signal cannot be encoded, for example because it is too long.
    #[error("cannot write a WAV file")]
    Encoding(#[from] hound::Error),
}

/// Writes a signal as a WAV file.
///
/// # Errors
/// [`SoundError`].
pub fn write_wav(request: &WavRequest<'_>) -> Result<WavFile, SoundError> {
    let table = ResultTable::read(request.folder, TableKind::Signals)?;
    let units = table.units()?;
    let heads = table.columns()?;
    let known: Vec<&str> = (heads.iter().map(|head| head.name.as_str()))
        .filter(|name| !NO_SIGNALS.contains(name))
        .collect();
    let name = request
        .signal
        .or(known.first().copied())
        .unwrap_or_default()
        .to_owned();
    if !known.contains(&name.as_str()) {
        return Err(SoundError::Unknown {
            name,
            known: known.join(", "),
        });
    }
    if let Some(value) = request
        .full_scale
        .filter(|value| !(value.is_finite() && *value > 0.0))
    {
        return Err(SoundError::Scale { value });
    }
    let deviations = deviations(&table.f64(&name)?);
    let largest = deviations.iter().map(|v| v.abs()).fold(0.0, f64::max);
    let times = table.f64("time")?;
    let [Some(first), Some(second)] = [0, 1].map(|at| *times.get(at)?) else {
        return Err(SoundError::Short { name });
    };
    if largest == 0.0 {
        return Err(SoundError::Silent { name });
    }
    let path = request.out.map_or_else(
        || request.folder.join(format!("{name}.wav")),
        Path::to_path_buf,
    );
    if path.exists() && !request.overwrite {
        return Err(SoundError::Exists { path });
    }
    let full_scale = request.full_scale.unwrap_or(largest);
    let rate = (1.0 / (second - first)).round() as u32;
    let scaled: Vec<f64> = deviations.iter().map(|v| v / full_scale).collect();
    write_atomically(&path, &encoded(rate, &scaled)?)?;
    Ok(WavFile {
        unit: units.get(&name).cloned().unwrap_or_default(),
        clipped: scaled.iter().filter(|v| v.abs() > 1.0).count(),
        samples: scaled.len(),
        signal: name,
        full_scale,
        rate,
        path,
    })
}

/// The deviations of a signal from the mean of its values; 0 for samples without a value.
fn deviations(signal: &[Option<f64>]) -> Vec<f64> {
    let values = signal.iter().flatten();
    let mean = values.clone().sum::<f64>() / values.count().max(1) as f64;
    let deviation = |value: &Option<f64>| value.map_or(0.0, |value| value - mean);
    signal.iter().map(deviation).collect()
}

/// The bytes of a WAV file with values in units of full scale; values beyond ±1 are clipped.
fn encoded(rate: u32, values: &[f64]) -> Result<Vec<u8>, hound::Error> {
    let spec = WavSpec {
        channels: 1,
        sample_rate: rate,
        bits_per_sample: 24,
        sample_format: SampleFormat::Int,
    };
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = WavWriter::new(&mut bytes, spec)?;
    for value in values {
        writer.write_sample((LARGEST * value.clamp(-1.0, 1.0)).round() as i32)?;
    }
    writer.finalize()?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_without_a_value_is_silent() {
        assert_eq!(deviations(&[Some(3.0), None, Some(5.0)]), [-1.0, 0.0, 1.0]);
        assert_eq!(deviations(&[None]), [0.0]);
    }

    #[test]
    fn samples_have_24_bits_and_are_clipped() {
        let bytes = encoded(8000, &[-1.0, 2.0]).unwrap();
        assert!(bytes.starts_with(b"RIFF"));
        assert!(bytes.ends_with(&[1, 0, 0x80, 0xff, 0xff, 0x7f]));
    }
}
