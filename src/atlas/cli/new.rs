//! `atlas new`: writes a commented manifest as a starting point.

use super::{BAD_INPUT, OrFail, Status, answer, refuse_existing};
use crate::manifest;
use crate::store::write_atomically;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `atlas new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// Name of the job, or of its file. The file is NAME.toml in the current folder.
    #[arg(value_name = "NAME")]
    pub name: String,
    /// Start from this drive.
    #[arg(long, value_enum, default_value_t = Template::Pair)]
    pub from: Template,
    /// Replace a file that already exists.
    #[arg(long)]
    pub overwrite: bool,
}

/// A shipped manifest that stands alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// A gear pair on two shafts, with twelve points.
    Pair,
    /// The same pair with its mesh computed from the drawing of the gears.
    Drawing,
    /// A two-stage reducer on three shafts.
    Train,
    /// A planetary set whose ring is held.
    Planetary,
    /// A wind turbine gearbox: two planetary sets and a helical stage.
    WindTurbine,
    /// An idling gearbox with loose gears.
    IdleRattle,
    /// A two-stage clutch damper and the gearbox behind it.
    Clutch,
}

impl Template {
    /// Path and text of the manifest.
    fn manifest(self) -> (&'static str, &'static str) {
        macro_rules! shipped {
            ($path:literal) => {
                ($path, include_str!(concat!("../../../", $path)))
            };
        }
        match self {
            Self::Pair => shipped!("manifests/quickstart.toml"),
            Self::Drawing => shipped!("manifests/flex80-table.toml"),
            Self::Train => shipped!("manifests/trains/two-stage.toml"),
            Self::Planetary => shipped!("manifests/trains/planetary.toml"),
            Self::WindTurbine => shipped!("manifests/trains/wind-turbine.toml"),
            Self::IdleRattle => shipped!("manifests/trains/idle-rattle.toml"),
            Self::Clutch => shipped!("manifests/trains/clutch.toml"),
        }
    }

    /// The manifest with its job renamed to `name`, for the file `NAME.toml`.
    fn named(self, name: &str) -> String {
        let (path, text) = self.manifest();
        let old = Path::new(path).file_stem().unwrap_or_default();
        let old = old.to_string_lossy();
        let lines = text.lines().filter(|line| !line.starts_with("#:schema"));
        let text = lines.collect::<Vec<_>>().join("\n") + "\n";
        text.replace(path, &format!("{name}.toml"))
            .replacen(&format!("# {old}:"), &format!("# {name}:"), 1)
            .replacen(
                &format!("name = \"{old}\""),
                &format!("name = \"{name}\""),
                1,
            )
    }
}

/// Writes the manifest: status 0; 2 if the name does not fit a job or the file exists; 1 if it cannot be written.
pub fn run(args: &NewArgs) -> Status {
    let name = args.name.strip_suffix(".toml").unwrap_or(&args.name);
    let text = args.from.named(name);
    let file = PathBuf::from(format!("{name}.toml"));
    manifest::parse(&text, &file.to_string_lossy(), Path::new(".")).or_explain(BAD_INPUT)?;
    refuse_existing(&file, args.overwrite, "choose another name")?;
    write_atomically(&file, text.as_bytes()).or_explain(1)?;
    let next = format!(
        "{0}\nNext: atlas check {0}, then atlas run {0}\n",
        file.display()
    );
    Ok(answer(&next, ExitCode::SUCCESS))
}
