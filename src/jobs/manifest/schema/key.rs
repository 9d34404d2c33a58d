//! One key of a file: its values, range, default, meaning, and an example.

use super::{MANIFEST, children, number, quoted};
use crate::units::Dimension;

/// A key of a manifest, a modal file or a housing file.
#[derive(Debug)]
pub(in crate::manifest) struct Key {
    /// Dotted path; `*` means an index, `shafts.<shaft>` either shaft.
    pub path: &'static str,
    pub kind: Kind,
    pub bounds: Bounds,
    pub default: DefaultValue,
    /// Description: what the key is, what it does, and when it matters. Empty for the elements of a plain list, which
    /// the list describes.
    pub about: &'static str,
    /// Example of a value, as text for a file.
    pub example: &'static str,
    /// Reason for the limits of the range, unless it is obvious.
    pub why: &'static str,
    /// Names of the two values if the key accepts one value for both or a pair `[a, b]`.
    pub pair: Option<&'static str>,
    /// Number of entries of a list, if it is fixed.
    pub length: Option<usize>,
    /// Other tables that may have the key.
    pub elsewhere: OtherTables,
}

/// Other tables that may have a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::manifest) enum OtherTables {
    Nowhere,
    /// A key of `[shafts]` in the table of either shaft.
    EitherShaft,
    /// A key of `[gear]` in the table of one gear of a train, with one value.
    OneGear,
    /// A key of `[mesh]` in the table of a further mesh of a train.
    FurtherMesh,
}

/// Each entry is a table, a second table, and the group of keys of the second table that the first table may also have.
pub(in crate::manifest) const SHARED: [(&str, &str, OtherTables); 4] = [
    ("shafts.<shaft>", "shafts", OtherTables::EitherShaft),
    ("train.shaft.*.gears.*", "gear", OtherTables::OneGear),
    ("train.planetary.*", "gear", OtherTables::OneGear),
    ("train.mesh.*", "mesh", OtherTables::FurtherMesh),
];

/// Whether the table at this path draws one gear of a train. `[gear]` draws the two gears of a pair.
pub(in crate::manifest) fn draws_one_gear(path: &str) -> bool {
    path.starts_with("train.")
}

/// The value of an absent key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::manifest) enum DefaultValue {
    /// None: the key is required.
    Required,
    /// A value as text for a file.
    Value(&'static str),
    /// Depends on other keys, in words.
    Words(&'static str),
}

/// The type of a key's values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::manifest) enum Kind {
    /// A number in SI or a text with a unit.
    Quantity(Dimension),
    /// A whole number.
    Integer,
    /// `true` or `false`.
    Boolean,
    /// A free text.
    Text,
    /// One of a few words.
    Choice(&'static [&'static str]),
    /// A list. The text describes its elements, which are the keys `path.*`.
    List(&'static str),
    /// A damping ratio (bare number, `%`) or a coefficient (`N*s/m`).
    ContactDamping,
    /// `"static"`, `"rest"` or a modal state.
    InitialState,
    /// A table; its keys have separate entries.
    Table,
    /// An axis of the grid.
    Axis(Dimension),
    /// The name of a file, or a list of tables, one per point.
    Points,
}

/// A range of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::manifest) struct Bounds {
    pub min: f64,
    pub min_open: bool,
    pub max: f64,
    pub max_open: bool,
}

const INF: f64 = f64::INFINITY;
pub(in crate::manifest) const ANY: Bounds = bounds(-INF, true, INF, true);
pub(in crate::manifest) const POSITIVE: Bounds = bounds(0.0, true, INF, true);
pub(super) const NON_NEGATIVE: Bounds = bounds(0.0, false, INF, true);
/// From 0 to below 1: damping ratios, coefficients of friction, and relative drops.
pub(super) const BELOW_ONE: Bounds = bounds(0.0, false, 1.0, true);

/// Upper bound of counts that only memory and time limit. It catches typing errors.
pub(super) const LARGEST_COUNT: f64 = 1e9;

/// Tables whose keys can be axes of the grid.
pub(in crate::manifest) const VARIABLE_TABLES: [&str; 8] = [
    "model",
    "gear",
    "shafts",
    "train",
    "mesh",
    "excitation",
    "run",
    "analyses",
];

/// The only key outside of [`VARIABLE_TABLES`] that can be an axis.
pub(in crate::manifest) const SEED: &str = "job.seed";

/// Keys of [`VARIABLE_TABLES`] that cannot be axes, because all points share their values.
const OF_THE_WHOLE_RUN: [(&str, &str); 2] = [
    (
        "analyses.multistability.slice.modes.*",
        "it names the columns of basins.parquet, which all points share",
    ),
    (
        "analyses.multistability.slice.mode",
        "it names the columns of basins.parquet, which all points share",
    ),
];

pub(super) const fn bounds(min: f64, min_open: bool, max: f64, max_open: bool) -> Bounds {
    Bounds {
        min,
        min_open,
        max,
        max_open,
    }
}

pub(super) const fn key(
    path: &'static str,
    kind: Kind,
    bounds: Bounds,
    example: &'static str,
) -> Key {
    Key {
        path,
        kind,
        bounds,
        default: DefaultValue::Required,
        about: "",
        example,
        why: "",
        pair: None,
        length: None,
        elsewhere: OtherTables::Nowhere,
    }
}

pub(super) const fn table(path: &'static str) -> Key {
    key(path, Kind::Table, ANY, "")
}

pub(in crate::manifest) const fn quantity(
    path: &'static str,
    dimension: Dimension,
    bounds: Bounds,
    example: &'static str,
) -> Key {
    key(path, Kind::Quantity(dimension), bounds, example)
}

pub(in crate::manifest) const fn integer(
    path: &'static str,
    min: f64,
    max: f64,
    example: &'static str,
) -> Key {
    key(path, Kind::Integer, bounds(min, false, max, false), example)
}

pub(in crate::manifest) const fn choice(
    path: &'static str,
    words: &'static [&'static str],
    example: &'static str,
) -> Key {
    key(path, Kind::Choice(words), ANY, example)
}

impl Key {
    /// The key with a description.
    pub const fn about(self, about: &'static str) -> Self {
        Self { about, ..self }
    }

    /// The key with a default as text for a file.
    pub const fn or(self, value: &'static str) -> Self {
        Self {
            default: DefaultValue::Value(value),
            ..self
        }
    }

    /// The key with a default that depends on other keys, in words.
    pub const fn otherwise(self, words: &'static str) -> Self {
        Self {
            default: DefaultValue::Words(words),
            ..self
        }
    }

    /// The key with the reason for its range.
    pub const fn because(self, why: &'static str) -> Self {
        Self { why, ..self }
    }

    /// The key with one value for both of `names`, or a pair.
    pub const fn or_pair(self, names: &'static str) -> Self {
        Self {
            pair: Some(names),
            ..self
        }
    }

    /// The list with a fixed number of entries.
    pub const fn of_length(self, length: usize) -> Self {
        Self {
            length: Some(length),
            ..self
        }
    }

    /// The key of `[shafts]`, also in the table of either shaft.
    pub const fn on_either_shaft(self) -> Self {
        self.also(OtherTables::EitherShaft)
    }

    /// The key of `[gear]`, also in the table of one gear.
    pub const fn on_one_gear(self) -> Self {
        self.also(OtherTables::OneGear)
    }

    /// The key of `[mesh]`, also in the table of a further mesh.
    pub const fn on_further_meshes(self) -> Self {
        self.also(OtherTables::FurtherMesh)
    }

    const fn also(self, elsewhere: OtherTables) -> Self {
        Self { elsewhere, ..self }
    }
}

impl Bounds {
    pub fn contain(self, value: f64) -> bool {
        let above = value > self.min || (!self.min_open && value == self.min);
        let below = value < self.max || (!self.max_open && value == self.max);
        value.is_finite() && above && below
    }

    /// The range in words, empty if any finite value is accepted.
    pub fn words(self) -> String {
        let low = match (self.min, self.min_open) {
            (min, _) if min == f64::NEG_INFINITY => String::new(),
            (min, true) => format!("greater than {}", number(min)),
            (min, false) => format!("at least {}", number(min)),
        };
        let high = match (self.max, self.max_open) {
            (max, _) if max == f64::INFINITY => String::new(),
            (max, true) => format!("less than {}", number(max)),
            (max, false) => format!("at most {}", number(max)),
        };
        match (low.is_empty(), high.is_empty()) {
            (false, false) => format!("{low} and {high}"),
            _ => low + &high,
        }
    }
}

impl Key {
    /// Whether the grid may vary it.
    pub fn can_be_axis(&self) -> bool {
        let number = matches!(
            self.kind,
            Kind::Quantity(_) | Kind::Integer | Kind::ContactDamping
        );
        number && self.is_variable() && self.shared().is_none()
    }

    /// Whether points of a grid may differ in it, or in a key below it.
    pub fn is_variable(&self) -> bool {
        let table = self.path.split('.').next().unwrap_or_default();
        VARIABLE_TABLES.contains(&table) || self.path == SEED
    }

    /// Why all points of a run share its value, if they do.
    pub fn shared(&self) -> Option<&'static str> {
        let mut keys = OF_THE_WHOLE_RUN.iter();
        keys.find(|(path, _)| *path == self.path)
            .map(|(_, why)| *why)
    }

    /// The accepted values, in words, with their range and an example.
    pub fn accepted(&self) -> String {
        let words = self.bounds.words();
        let range = if words.is_empty() { String::new() } else { format!(", {words}") };
        let example = self.example;
        match self.kind {
            Kind::Quantity(Dimension::Ratio) => format!("a number{range}; for example {example}"),
            Kind::Quantity(dimension) if dimension.units().is_empty() => {
                format!("a bare number in {}{range}; for example {example}", dimension.unit())
            }
            Kind::Quantity(dimension) => format!(
                "a number in {}, or a text with a unit ({}){range}; for example {example}",
                dimension.unit(),
                dimension.units()
            ),
            Kind::Integer => {
                let why = match self.why {
                    "" => String::new(),
                    why => format!(" ({why})"),
                };
                format!(
                    "a whole number from {} to {}{why}; for example {example}",
                    number(self.bounds.min),
                    number(self.bounds.max)
                )
            }
            Kind::Boolean => "true or false".to_owned(),
            Kind::Text => format!("a text in quotes; for example {example}"),
            Kind::Choice(choices) => quoted(choices),
            Kind::List(of) => format!("a list of {of}; for example {example}"),
            Kind::ContactDamping => format!(
                "a damping ratio (bare number or %){range}, or a coefficient with its unit ({}); for example 0.05 or \"1483 N*s/m\"",
                Dimension::Damping.units()
            ),
            Kind::InitialState => "\"static\", \"rest\", or { displacement = [...], velocity = [...] } in modal coordinates".to_owned(),
            Kind::Table => {
                let names = children(MANIFEST, self.path);
                format!("a table with the keys {}", names.join(", "))
            }
            Kind::Points => format!("a list of tables, [{{ load = 0.1, speed = \"1000 rpm\" }}], or the path of a file; for example {example}"),
            Kind::Axis(dimension) => {
                let value = match dimension {
                    Dimension::Ratio => "a number or a text in %".to_owned(),
                    _ => format!(
                        "a number in {} or a text with a unit ({})",
                        dimension.unit(),
                        dimension.units()
                    ),
                };
                format!(
                    "one value, {{ values = [...] }} or {{ from, to, count, spacing }}, each value {value}{range}; for example {example}"
                )
            }
        }
    }
}

impl Key {
    /// Whether it has only one value in the table at this path, although `[gear]` may have one per gear.
    pub fn is_of_one_gear(&self, path: &str) -> bool {
        self.elsewhere == OtherTables::OneGear && draws_one_gear(path)
    }

    /// The range of its numbers for the manual, empty if any finite value is accepted.
    pub fn range(&self) -> String {
        match self.kind {
            Kind::Integer => {
                format!("{} to {}", number(self.bounds.min), number(self.bounds.max))
            }
            _ => self.bounds.words(),
        }
    }
}
