//! A signal of a run-up as a WAV file with 24 bits. The mean of the signal is removed. Full scale corresponds
//! to a given deviation from the mean.

use crate::store::{ResultTable, StoreError, TableKind};
use hound::{SampleFormat, WavSpec, WavWriter};
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
    /// The table cannot be read.
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
    /// The file cannot be written.
    #[error("cannot write `{}`: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: hound::Error,
    },
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
    let column = |name: &str| -> Result<Vec<f64>, StoreError> {
        Ok(table
            .f64(name)?
            .into_iter()
            .map(Option::unwrap_or_default)
            .collect())
    };
    let (values, times) = (column(&name)?, column("time")?);
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let largest = values.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
    let [Some(first), Some(second)] = [0, 1].map(|at| times.get(at)) else {
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
    let scaled: Vec<f64> = values.iter().map(|v| (v - mean) / full_scale).collect();
    write(&path, rate, &scaled).map_err(|source| SoundError::Write {
        path: path.clone(),
        source,
    })?;
    Ok(WavFile {
        unit: units.get(&name).cloned().unwrap_or_default(),
        clipped: scaled.iter().filter(|v| v.abs() > 1.0).count(),
        samples: values.len(),
        signal: name,
        full_scale,
        rate,
        path,
    })
}

/// Writes values in units of full scale as a WAV file; values beyond ±1 are clipped.
fn write(path: &Path, rate: u32, values: &[f64]) -> Result<(), hound::Error> {
    let spec = WavSpec {
        channels: 1,
        sample_rate: rate,
        bits_per_sample: 24,
        sample_format: SampleFormat::Int,
    };
    let mut writer = WavWriter::create(path, spec)?;
    for value in values {
        writer.write_sample((LARGEST * value.clamp(-1.0, 1.0)).round() as i32)?;
    }
    writer.finalize()
}
