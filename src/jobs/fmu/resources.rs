//! The files of an FMU beside its library: the manifest, the files that it names, the tables of its meshes, and the
//! choice of a point.

use super::FmuError;
use super::description::Description;
use crate::input;
use crate::manifest::{Job, ManifestText, PointSpec};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

/// Name of the file that lists all others.
const LIST: &str = "drive.json";

/// Name of the file with the manifest as it was written.
const MANIFEST: &str = "manifest.toml";

/// Name of the folder of mesh tables.
pub const TABLES: &str = "tables";

/// Size limit of a file that is read \[bytes\].
const LARGEST_FILE: u64 = 1 << 30;

/// The point of the job that the FMU represents.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// Number of the point in the grid.
    pub point: u64,
    /// Load of the point, which need not be in the grid.
    pub load: f64,
    /// Speed of the point \[rad/s\], which need not be in the grid.
    pub speed: f64,
    /// Changes of keys of the manifest, `key=value`: those of the job, then the new path of every file that it names.
    pub changes: Vec<String>,
    /// Paths of all other files, below the folder of resources.
    files: Vec<String>,
}

/// The resources, by their paths below their folder.
#[derive(Debug, Clone)]
pub struct Resources {
    /// The chosen point.
    pub choice: Choice,
    files: BTreeMap<String, Vec<u8>>,
}

fn read(path: &Path) -> Result<Vec<u8>, FmuError> {
    input::read(path, LARGEST_FILE).map_err(|error| unreadable(path, &error))
}

fn unreadable(path: &Path, why: &dyn ToString) -> FmuError {
    FmuError::Unreadable {
        path: path.to_path_buf(),
        why: why.to_string(),
    }
}

/// Path below the resources of the file that this key of the manifest names.
fn place(key: &str) -> String {
    let suffix = if key.ends_with(".file") { "toml" } else { "csv" };
    format!("files/{}.{suffix}", key.replace('"', ""))
}

impl Resources {
    /// The resources of a point of a job. Relative paths in its manifest start at `base`; `tables` is the folder of its
    /// tables.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn gather(
        job: &Job,
        point: &PointSpec,
        base: &Path,
        tables: &Path,
    ) -> Result<Self, FmuError> {
        let mut files = BTreeMap::from([(MANIFEST.to_owned(), job.text.clone().into_bytes())]);
        let mut changes = job.changes.clone();
        for named in job.written().files() {
            let path = base.join(&named.path);
            let bytes = match input::read(&path, LARGEST_FILE) {
                Ok(bytes) => bytes,
                // The job was read without this file, so it does not need it.
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                Err(error) => return Err(unreadable(&path, &error)),
            };
            let place = place(&named.key);
            changes.push(format!("{}={place:?}", named.key));
            files.insert(place, bytes);
        }
        let kept = std::fs::read_dir(tables).into_iter().flatten().flatten();
        for entry in kept {
            let name = entry.file_name().to_string_lossy().into_owned();
            files.insert(format!("{TABLES}/{name}"), read(&entry.path())?);
        }
        let choice = Choice {
            point: point.point_id,
            load: point.load,
            speed: point.speed,
            changes,
            files: files.keys().cloned().collect(),
        };
        Ok(Self { choice, files })
    }

    /// Reads the resources in a folder.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn open(folder: &Path) -> Result<Self, FmuError> {
        let list = folder.join(LIST);
        let choice: Choice =
            serde_json::from_slice(&read(&list)?).map_err(|error| unreadable(&list, &error))?;
        let mut files = BTreeMap::new();
        for name in &choice.files {
            files.insert(name.clone(), read(&folder.join(name))?);
        }
        Ok(Self { choice, files })
    }

    /// Reads the job again. `folder` has the files that its manifest names.
    ///
    /// # Errors
    /// The manifest is missing or faulty.
    pub fn job(&self, folder: &Path) -> Result<Job, FmuError> {
        let path = folder.join(MANIFEST);
        let bytes = self
            .files
            .get(MANIFEST)
            .ok_or_else(|| unreadable(&path, &"it is not listed"))?;
        let text = std::str::from_utf8(bytes).map_err(|error| unreadable(&path, &error))?;
        let changes = &self.choice.changes;
        Ok(ManifestText { text, changes }.job(&path.display().to_string(), folder)?)
    }

    /// The chosen point of this job.
    ///
    /// # Errors
    /// The job has no such point.
    pub fn point(&self, job: &Job) -> Result<PointSpec, FmuError> {
        let id = usize::try_from(self.choice.point).unwrap_or(usize::MAX);
        if id >= job.points.len() {
            return Err(FmuError::Parameters(format!("there is no point {id}")));
        }
        Ok(PointSpec {
            load: self.choice.load,
            speed: self.choice.speed,
            ..job.points.at(id)
        })
    }

    /// The list of the files.
    fn list(&self) -> Vec<u8> {
        // Texts and numbers always convert to JSON.
        serde_json::to_vec_pretty(&self.choice).unwrap_or_default()
    }

    /// A hash that identifies these resources, this program and this list of variables.
    pub fn token(&self, description: &Description) -> String {
        let mut hash = blake3::Hasher::new();
        let mut add = |bytes: &[u8]| {
            hash.update(&(bytes.len() as u64).to_le_bytes());
            hash.update(bytes);
        };
        add(env!("CARGO_PKG_VERSION").as_bytes());
        add(&self.list());
        for (name, bytes) in &self.files {
            add(name.as_bytes());
            add(bytes);
        }
        add(format!("{:?}", description.variables).as_bytes());
        format!("{{atlas-{}}}", &hash.finalize().to_hex()[..32])
    }

    /// All files with their paths below the folder.
    pub fn into_files(self) -> Vec<(String, Vec<u8>)> {
        let list = (LIST.to_owned(), self.list());
        std::iter::once(list).chain(self.files).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest;
    use std::fs;

    /// Every named file has its own path in the FMU. A file that cannot be read is an error, unless it is missing.
    #[test]
    fn named_files_keep_their_contents() {
        let folder = tempfile::tempdir().unwrap();
        let base = folder.path();
        for name in ["speeds.csv", "loads.csv"] {
            fs::write(base.join(name), name).unwrap();
        }
        let quickstart = include_str!("../../../manifests/quickstart.toml");
        let mut job = manifest::parse(quickstart, "m.toml", base).unwrap();
        let point = job.points.at(0);
        let mut gathered = |load_points: &str| {
            job.text =
                format!("[runup]\npoints = \"speeds.csv\"\nload_points = \"{load_points}\"\n");
            Resources::gather(&job, &point, base, &base.join("tables"))
        };
        let resources = gathered("loads.csv").unwrap();
        for (path, bytes) in [
            ("files/runup.points.csv", "speeds.csv"),
            ("files/runup.load_points.csv", "loads.csv"),
        ] {
            assert_eq!(resources.files[path], bytes.as_bytes());
            let change = resources.choice.changes.iter();
            assert_eq!(change.filter(|change| change.contains(path)).count(), 1);
        }
        assert_eq!(gathered("missing.csv").unwrap().files.len(), 2);
        let error = gathered(".").unwrap_err();
        assert!(
            matches!(error, FmuError::Unreadable { .. }),
            "a folder: {error}"
        );
    }
}
