//! Which lengths and diameters are impossible for a shaft?

use crate::manifest::StructureSource;
use crate::manifest::slip::{DIAMETERS, LENGTHS, of_length};

/// Keys of impossible lengths and diameters, with messages about them.
pub(super) fn of_shafts(source: &StructureSource) -> Vec<(String, String)> {
    let words = match source {
        StructureSource::Flexible(drive) => (drive.shafts.iter().zip(["pinion", "wheel"]))
            .flat_map(|(shaft, name)| {
                let key = |key: &str| format!("shafts.{name}.{key}");
                [
                    (key("diameter"), shaft.diameter, DIAMETERS),
                    (key("span"), shaft.span, LENGTHS),
                    (key("overhang"), shaft.overhang, LENGTHS),
                ]
            })
            .collect::<Vec<_>>(),
        StructureSource::Train(train) => (train.shafts.iter().enumerate())
            .flat_map(|(number, shaft)| {
                let sections = shaft.sections.iter().enumerate();
                sections.flat_map(move |(section, shaft_section)| {
                    let key = |key| format!("train.shaft.{number}.sections.{section}.{key}");
                    [
                        (key("outer"), shaft_section.outer, DIAMETERS),
                        (key("length"), shaft_section.length, LENGTHS),
                    ]
                })
            })
            .collect(),
        StructureSource::Rigid(_) | StructureSource::Modal(_) => Vec::new(),
    };
    (words.into_iter())
        .filter_map(|(key, value, range)| {
            let what = if range == DIAMETERS { "diameter" } else { "length" };
            Some((key, of_length(value, what, range)?))
        })
        .collect()
}
