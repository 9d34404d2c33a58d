//! `atlas sound results/x/runup`: a signal of a run-up as a WAV file.

use super::process::begin_writing;
use super::{BAD_INPUT, answer, fail, with_causes};
use crate::export::{SoundError, WavRequest, write_wav};
use crate::store::StoreError;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `atlas sound`.
#[derive(Debug, Args)]
pub struct SoundArgs {
    /// A folder that `atlas runup` wrote.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Write this column of signals.parquet [default: the first signal].
    #[arg(long, value_name = "COLUMN")]
    signal: Option<String>,
    /// Deviation from the mean at full scale, in the unit of the signal [default: the largest deviation].
    #[arg(long, value_name = "VALUE")]
    full_scale: Option<f64>,
    /// Write this file [default: FOLDER/COLUMN.wav].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace a file that already exists.
    #[arg(long)]
    overwrite: bool,
}

/// Writes the sound file: status 0 if done, 2 for bad input, 1 if it cannot be written.
pub fn run(args: &SoundArgs) -> ExitCode {
    begin_writing();
    let request = WavRequest {
        folder: &args.folder,
        signal: args.signal.as_deref(),
        full_scale: args.full_scale,
        out: args.out.as_deref(),
        overwrite: args.overwrite,
    };
    match write_wav(&request) {
        Ok(written) => {
            let clipped = match written.clipped {
                0 => String::new(),
                count => {
                    format!("clipped   {count} samples beyond full scale; raise --full-scale\n")
                }
            };
            let text = format!(
                "sound     {}, {} s at {} samples per second, 24 bit\nscale     full scale is {} {} about the mean\n{clipped}file      {}\n",
                written.signal,
                written.samples as f64 / f64::from(written.rate),
                written.rate,
                written.full_scale,
                written.unit,
                written.path.display()
            );
            answer(&text, ExitCode::SUCCESS)
        }
        Err(error @ (SoundError::Store(StoreError::Io(_)) | SoundError::Encoding(_))) => {
            fail(1, &with_causes(&error))
        }
        Err(error) => fail(BAD_INPUT, &with_causes(&error)),
    }
}
