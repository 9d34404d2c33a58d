//! `atlas fmu m.toml`: the drive as a functional mock-up unit for other simulators.

use super::manifest_args::ManifestArgs;
use super::point::{self, number};
use super::{
    BAD_INPUT, OrFail, Status, answer, either, fail, refuse_existing, scratch_folder, with_causes,
};
use crate::fmu::{Description, Drive, FmuError, Platform, Role, Version, export};
use crate::input;
use crate::store::{TableStore, write_atomically};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `atlas fmu`.
#[derive(Debug, Args)]
pub struct FmuArgs {
    #[command(flatten)]
    manifest: ManifestArgs,
    /// Start at this operating point: its point_id, or values of axes such as load=0.05,speed="9000 rpm" [default: the
    /// first point].
    #[arg(long = "point", value_name = "ID|AXIS=VALUE,...")]
    point: Option<String>,
    /// Write this file [default: JOB.fmu].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Use this version of FMI.
    #[arg(long, value_enum, default_value_t = Fmi::Two)]
    fmi: Fmi,
    /// Include this library in the FMU [default: libatlas_fmu.so beside the program].
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    /// Replace a file that already exists.
    #[arg(long)]
    overwrite: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// A version of FMI, as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Fmi {
    /// FMI 2.0, which most simulators read.
    #[value(name = "2")]
    Two,
    /// FMI 3.0.
    #[value(name = "3")]
    Three,
}

impl Fmi {
    fn version(self) -> Version {
        match self {
            Self::Two => Version::Two,
            Self::Three => Version::Three,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Two => "2.0",
            Self::Three => "3.0",
        }
    }
}

/// File name of the library.
const LIBRARY: &str = "libatlas_fmu.so";

/// Largest size of the library \[bytes\].
const LARGEST_LIBRARY: u64 = 1 << 30;

/// Writes the file: status 0, 2 for bad input, 1 if it cannot be written.
pub fn run(args: &FmuArgs) -> Status {
    let job = args.manifest.read_job()?;
    let point = point::read_point(&job, args.point.as_deref().unwrap_or("0"))?.spec;
    let out = (args.out.clone()).unwrap_or_else(|| PathBuf::from(format!("{}.fmu", job.name)));
    refuse_existing(&out, args.overwrite, "choose another file with --out")?;
    let version = args.fmi.version();
    let Some(platform) = Platform::current(version) else {
        let message =
            "FMI 2.0 has no name for the processors of this machine; write FMI 3.0 with --fmi 3";
        return Err(fail(BAD_INPUT, message));
    };
    let (path, library) = library(args).or_fail(BAD_INPUT)?;
    // The file contains only the tables that this point needs.
    let tables = scratch_folder()?;
    let written = Drive::new(job, point, TableStore::open(tables.path())).and_then(|drive| {
        let folders = (args.manifest.base(), tables.path());
        let bytes = export(&drive, folders, (library, platform), version)?;
        Ok((drive, bytes))
    });
    let (drive, bytes) = match written {
        Ok(written) => written,
        Err(error @ FmuError::OtherLibrary { .. }) => {
            return Err(fail(BAD_INPUT, &format!("`{}`: {error}", path.display())));
        }
        Err(error) => return Err(fail(BAD_INPUT, &with_causes(&error))),
    };
    write_atomically(&out, &bytes).or_explain(1)?;
    let summary = Summary {
        out,
        fmi: args.fmi,
        drive: &drive,
        size: bytes.len(),
    };
    let text = either(args.json, || summary.json(), || summary.text());
    Ok(answer(&text, ExitCode::SUCCESS))
}

/// The library's path and bytes.
fn library(args: &FmuArgs) -> Result<(PathBuf, Vec<u8>), String> {
    let sibling = || {
        Some(
            std::env::current_exe()
                .ok()?
                .canonicalize()
                .ok()?
                .with_file_name(LIBRARY),
        )
    };
    let path = args.library.clone().or_else(sibling);
    let path = path.unwrap_or_else(|| PathBuf::from(LIBRARY));
    match input::read(&path, LARGEST_LIBRARY) {
        Ok(bytes) => Ok((path, bytes)),
        Err(error) => Err(format!(
            "the library `{}` cannot be read: {error}; build it with `cargo build --release`, or name it with --library",
            path.display()
        )),
    }
}

/// Summary of the written file.
struct Summary<'a> {
    out: PathBuf,
    fmi: Fmi,
    drive: &'a Drive,
    size: usize,
}

impl Summary<'_> {
    fn description(&self) -> &Description {
        self.drive.description()
    }

    /// Names of the variables whose role satisfies `is`.
    fn names(&self, is: impl Fn(Role) -> bool) -> Vec<&str> {
        let variables = self.description().variables.iter();
        let own = variables.filter(|own| is(own.role));
        own.map(|own| own.name.as_str()).collect()
    }

    fn text(&self) -> String {
        let point = self.drive.point();
        let list = |is: fn(Role) -> bool| self.names(is).join(", ");
        format!(
            "{}\nversion     FMI {}, co-simulation, {:.1} MB\nstart       load {}, speed {} rad/s\nparameters  {}\ninputs      {}\noutputs     {}\n",
            self.out.display(),
            self.fmi.name(),
            self.size as f64 / 1e6,
            number(point.load),
            number(point.speed),
            list(|role| matches!(role, Role::Parameter(_))),
            list(|role| matches!(role, Role::Input(_))),
            list(Role::is_output),
        )
    }

    fn json(&self) -> Value {
        let point = self.drive.point();
        json!({
            "file": self.out,
            "fmi": self.fmi.name(),
            "bytes": self.size,
            "load": point.load,
            "speed": point.speed,
            "parameters": self.names(|role| matches!(role, Role::Parameter(_))),
            "inputs": self.names(|role| matches!(role, Role::Input(_))),
            "outputs": self.names(Role::is_output),
        })
    }
}
