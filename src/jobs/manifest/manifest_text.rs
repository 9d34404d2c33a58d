//! A manifest as it was written, with the keys that a command changed. Results keep both, and every program that reads
//! the manifest again must use both.

use std::collections::BTreeMap;
use std::fmt;

use super::diagnostic::Issues;
use super::expression::Expression;
use super::set;
use super::tree::{self, Node, Value};
use crate::units;

/// A text and its changes.
#[derive(Debug, Clone, Copy)]
pub struct ManifestText<'t> {
    /// The manifest as the user wrote it.
    pub text: &'t str,
    /// Keys with changed values, as typed: `KEY=VALUE`.
    pub changes: &'t [String],
}

impl ManifestText<'_> {
    /// The units of the axes of its grid as written, by the axis's name. An axis has the unit of its first
    /// value with a unit. Empty if the text is not a manifest.
    pub fn axis_units(self) -> BTreeMap<String, String> {
        let root = self.tree();
        let entries = root.entries("grid").iter();
        entries
            .filter_map(|axis| Some((axis.key.clone(), unit(&axis.node)?)))
            .collect()
    }

    /// The tree of its values, without regard to faults. Values of the text have source 0.
    pub(super) fn tree(self) -> Node {
        let issues = Issues::default();
        let source = issues.add_source(String::new(), self.text.to_owned());
        let mut root = tree::parse(source, &issues);
        set::apply(&mut root, self.changes, &issues);
        root
    }
}

impl fmt::Display for ManifestText<'_> {
    /// The text, followed by the changed keys.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text)?;
        (self.changes.iter()).try_for_each(|change| write!(f, "\n--set {change}"))
    }
}

fn unit(node: &Node) -> Option<String> {
    match &node.value {
        Value::Text(text) if !Expression::is_expression(text) => {
            let (_, unit) = units::split(text)?;
            (!unit.is_empty()).then(|| unit.to_owned())
        }
        Value::Array(values) => values.iter().find_map(unit),
        Value::Table(_) => {
            let keys = ["values", "from", "to", "normal", "lognormal", "uniform"];
            keys.iter().find_map(|key| unit(&node.entry(key)?.node))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: &str = "[grid]\nspeed = { from = \"6000 rpm\", to = \"9000 rpm\", count = 3 }\nload = 0.1\n\
        \"mesh.half_gap\" = { values = [1e-5, \"15 um\"] }\n\"mesh.misalignment\" = \"2 mrad\"\n\
        \"mesh.mean_stiffness\" = { normal = [\"300 N/um\", \"9 N/um\"] }\n";

    fn found(text: &str, changes: &[&str]) -> Vec<(String, String)> {
        let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
        let changes = &changes;
        ManifestText { text, changes }
            .axis_units()
            .into_iter()
            .collect()
    }

    #[test]
    fn units_are_those_of_the_text_and_its_changes() {
        let pairs = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
            let owned = |&(a, b): &(&str, &str)| (a.to_owned(), b.to_owned());
            pairs.iter().map(owned).collect()
        };
        let written = pairs(&[
            ("mesh.half_gap", "um"),
            ("mesh.mean_stiffness", "N/um"),
            ("mesh.misalignment", "mrad"),
            ("speed", "rpm"),
        ]);
        assert_eq!(found(GRID, &[]), written);
        let changed = pairs(&[
            ("mesh.half_gap", "mm"),
            ("mesh.mean_stiffness", "N/um"),
            ("mesh.misalignment", "mrad"),
        ]);
        assert_eq!(
            found(GRID, &["grid.\"mesh.half_gap\"=0.01 mm", "grid.speed=600"]),
            changed
        );
        let tied = found(
            "[grid]\nspeed = \"600 rpm\"\nload = \"0.01 * speed^2\"\n",
            &[],
        );
        assert_eq!(tied, pairs(&[("speed", "rpm")]));
        assert!(found("no manifest", &[]).is_empty());
    }
}
