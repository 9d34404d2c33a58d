//! Which files does a manifest name? Files of modes, of a housing, of lists of points, of measured values of axes.

use super::ManifestText;
use super::tree::{Node, Value};

/// Keys whose texts are paths, relative to the folder of the manifest.
const KEYS: [&str; 6] = [
    "excitation.torque_curve.points",
    "model.file",
    "train.housing.file",
    "grid.points",
    "runup.points",
    "runup.load_points",
];

/// A file that a manifest names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedFile {
    /// The dotted key that names the file, with quotes around the name of an axis.
    pub key: String,
    /// Path of the file, as written.
    pub path: String,
}

impl ManifestText<'_> {
    /// The files that the manifest names, even if they are not used.
    pub fn files(self) -> Vec<NamedFile> {
        let root = self.tree();
        let named = |key: &str, node: &Node| match &node.value {
            Value::Text(path) => Some(NamedFile {
                key: key.to_owned(),
                path: path.clone(),
            }),
            _ => None,
        };
        let axes = match root.at("grid").map(|grid| &grid.value) {
            Some(Value::Table(axes)) => axes.as_slice(),
            _ => &[],
        };
        let values = axes.iter().filter_map(|axis| {
            let key = format!("grid.\"{}\".empirical", axis.key);
            named(&key, &axis.node.entry("empirical")?.node)
        });
        (KEYS.into_iter().filter_map(|key| named(key, root.at(key)?)))
            .chain(values)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest::schema::{self, Kind, MANIFEST};

    #[test]
    fn files_are_those_of_the_text_and_its_changes() {
        let text = "[model]\nfile = \"a.toml\"\n[grid]\npoints = [{ load = 1 }]\n";
        let changes = ["grid.points=b.csv".to_owned()];
        let named = |changes: &[String]| -> Vec<String> {
            let files = ManifestText { text, changes }.files();
            files
                .into_iter()
                .map(|file| format!("{}={}", file.key, file.path))
                .collect()
        };
        assert_eq!(named(&[]), ["model.file=a.toml"]);
        assert_eq!(named(&changes), ["model.file=a.toml", "grid.points=b.csv"]);
    }

    /// [`KEYS`] has every key with the name `file` and every key with a list of points.
    #[test]
    fn every_key_that_names_a_file_is_known() {
        let names = |key: &&schema::Key| key.path.ends_with(".file") || key.kind == Kind::Points;
        let mut keys: Vec<&str> = schema::all(MANIFEST)
            .filter(names)
            .map(|key| key.path)
            .collect();
        keys.sort_unstable();
        let mut known = KEYS;
        known.sort_unstable();
        assert_eq!(keys, known);
    }
}
