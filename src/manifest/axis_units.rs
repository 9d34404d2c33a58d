//! In which units does a manifest give the values of its grid?

use std::collections::BTreeMap;

use toml::Value;

use crate::units;

/// The unit of the first value with one of each axis of a manifest's grid, by the axis's name, as it is
/// written; nothing of a text that is no manifest.
pub fn axis_units(text: &str) -> BTreeMap<String, String> {
    let manifest = text.parse::<toml::Table>().unwrap_or_default();
    let grid = manifest.get("grid").and_then(Value::as_table);
    let axes = grid.into_iter().flatten();
    axes.filter_map(|(name, values)| Some((name.clone(), unit(values)?)))
        .collect()
}

fn unit(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => {
            let (_, unit) = units::split(text)?;
            (!unit.is_empty()).then(|| unit.to_owned())
        }
        Value::Array(values) => values.iter().find_map(unit),
        Value::Table(axis) => {
            (["values", "from", "to"].iter()).find_map(|key| unit(axis.get(*key)?))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_of_the_text() {
        let found = axis_units(
            "[grid]\nspeed = { from = \"6000 rpm\", to = \"9000 rpm\", count = 3 }\nload = 0.1\n\
             \"mesh.half_gap\" = { values = [1e-5, \"15 um\"] }\n\"mesh.misalignment\" = \"2 mrad\"\n",
        );
        let found: Vec<(&str, &str)> = found.iter().map(|(a, b)| (&**a, &**b)).collect();
        let wanted = [
            ("mesh.half_gap", "um"),
            ("mesh.misalignment", "mrad"),
            ("speed", "rpm"),
        ];
        assert_eq!(found, wanted);
        assert!(axis_units("no manifest").is_empty());
    }
}
