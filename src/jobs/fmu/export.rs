//! Writes an FMU.

use super::FmuError;
use super::archive::archive;
use super::drive::Drive;
use super::resources::Resources;
use super::xml::{MODEL_IDENTIFIER, Version};
use std::path::Path;

/// Text in the library with its version. The program looks for this text before it packs the library.
pub const MARK: &str = concat!("gearatlas-fmu ", env!("CARGO_PKG_VERSION"), " #");

/// A platform that a library can be built for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Platform {
    two: &'static str,
    three: &'static str,
}

impl Platform {
    /// The platform of this machine; `None` if no folder is known for its processor in this version of FMI.
    pub fn current(version: Version) -> Option<Self> {
        let (two, three) = match std::env::consts::ARCH {
            "x86_64" => ("linux64", "x86_64-linux"),
            "aarch64" => ("", "aarch64-linux"),
            _ => ("", ""),
        };
        let libraries = Self { two, three };
        (!libraries.folder(version).is_empty()).then_some(libraries)
    }

    /// Name of the folder below `binaries`; empty if the version of FMI has none.
    fn folder(self, version: Version) -> &'static str {
        match version {
            Version::Two => self.two,
            Version::Three => self.three,
        }
    }
}

/// The bytes of the FMU of a drive. `base` is the folder in which relative paths of its manifest start, and
/// `tables` is the folder of its tables. `library` has the bytes of the library for `platform`.
///
/// # Errors
/// The drive cannot be stepped, a file cannot be read, or the library belongs to another version.
pub fn export(
    drive: &Drive,
    (base, tables): (&Path, &Path),
    (library, platform): (Vec<u8>, Platform),
    version: Version,
) -> Result<Vec<u8>, FmuError> {
    let has = |mark: &str| {
        library
            .windows(mark.len())
            .any(|known| known == mark.as_bytes())
    };
    if !has(MARK) {
        return Err(FmuError::OtherLibrary {
            mark: MARK.trim_end_matches(" #"),
        });
    }
    let description = drive.description();
    // This step also computes the mesh tables, which the resources need.
    drive.plant(&description.parameters_at_start())?;
    let resources = Resources::gather(drive.job(), drive.point(), base, tables)?;
    let token = resources.token(description);
    let mut files = vec![
        (
            "modelDescription.xml".to_owned(),
            description.xml(version, &token).into_bytes(),
        ),
        (
            format!(
                "binaries/{}/{MODEL_IDENTIFIER}.so",
                platform.folder(version)
            ),
            library,
        ),
    ];
    let resources = resources.into_files().into_iter();
    files.extend(resources.map(|(path, bytes)| (format!("resources/{path}"), bytes)));
    archive(&files)
}
