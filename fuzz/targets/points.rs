//! A file of operating points in the formats of spreadsheets.

use super::manifest::judged;
use super::right;
use super::scratch::{folder, put};
use gearatlas::manifest::ManifestText;

/// The bytes of the file that a manifest names.
pub fn points(data: &[u8]) {
    let folder = folder();
    put(&folder.join("fuzzed.csv"), data);
    let text = include_str!("../../manifests/points.toml").replace("points.csv", "fuzzed.csv");
    let changes = &[];
    let Some(job) = judged(
        ManifestText {
            text: &text,
            changes,
        },
        &folder,
    ) else {
        return;
    };
    // A point takes at least a number and a line end.
    right(job.points.len() <= data.len(), || {
        format!("{} points of {} bytes", job.points.len(), data.len())
    });
}
