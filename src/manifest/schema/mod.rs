//! Every key a manifest may have: what it takes, its range, an example. The one table
//! behind unknown-key errors, grid axes and the wording of what is accepted.

mod keys;
#[cfg(test)]
mod tests;

use crate::units::Dimension;
use keys::MANY;
pub(in crate::manifest) use keys::{FEWEST_CYCLES, MANIFEST, MODAL_FILE};

/// A key of the manifest or of a modal file.
#[derive(Debug)]
pub(in crate::manifest) struct Key {
    /// Dotted path; `*` stands for an index, `shafts.<shaft>` for either shaft.
    pub path: &'static str,
    pub kind: Kind,
    pub bounds: Bounds,
    /// A value as it would stand in the file.
    pub example: &'static str,
    /// Why the range ends where it does, where that is not plain.
    pub why: &'static str,
}

/// What a key takes.
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
    /// A list; its elements are the keys `path.*`.
    List(&'static str),
    /// A damping ratio (bare number, `%`) or a coefficient (`N*s/m`).
    ContactDamping,
    /// `"roundoff"` or a number.
    Tolerance,
    /// `"static"`, `"rest"` or a modal state.
    Initial,
    /// A table; its keys are listed on their own.
    Table,
    /// An axis of the grid.
    Axis(Dimension),
}

/// A range of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::manifest) struct Bounds {
    pub min: f64,
    pub min_open: bool,
    pub max: f64,
    pub max_open: bool,
}

impl Bounds {
    pub fn contain(self, value: f64) -> bool {
        let above = value > self.min || (!self.min_open && value == self.min);
        let below = value < self.max || (!self.max_open && value == self.max);
        value.is_finite() && above && below
    }

    /// The range in words, empty when any finite value will do.
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

/// A number as people write it: `0.05`, `4.4e8`.
pub(in crate::manifest) fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || (1e-3..1e6).contains(&magnitude) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// The schema's form of a path: indices become `*`, either shaft `<shaft>`.
fn pattern(path: &str) -> String {
    let mut out = String::with_capacity(path.len() + 4);
    for (i, segment) in path.split('.').enumerate() {
        if i > 0 {
            out.push('.');
        }
        let index = segment.bytes().all(|b| b.is_ascii_digit()) && !segment.is_empty();
        let shaft = i == 1 && out == "shafts." && matches!(segment, "pinion" | "wheel");
        out.push_str(match (index, shaft) {
            (true, _) => "*",
            (_, true) => "<shaft>",
            _ => segment,
        });
    }
    out
}

/// The entry of a dotted path such as `excitation.torque_ripple.0.order`.
pub(in crate::manifest) fn find(schema: &'static [Key], path: &str) -> Option<&'static Key> {
    let pattern = pattern(path);
    schema.iter().find(|key| key.path == pattern)
}

/// The names of the keys directly below a path (`""` for the top).
pub(in crate::manifest) fn children(schema: &'static [Key], path: &str) -> Vec<&'static str> {
    let prefix = match path {
        "" => String::new(),
        path => pattern(path) + ".",
    };
    let mut names = Vec::new();
    for key in schema {
        match key.path.strip_prefix(&prefix) {
            Some("<shaft>") => names.extend(["pinion", "wheel"]),
            Some(rest) if !rest.contains('.') && rest != "*" => names.push(rest),
            _ => {}
        }
    }
    names
}

/// Longest name \[bytes\] that may be a misspelt one.
const LONGEST_MISSPELT: usize = 120;

/// The nearest of some names, if any is near enough to be meant.
pub(in crate::manifest) fn nearest<'n>(name: &str, known: &[&'n str]) -> Option<&'n str> {
    // The work grows with the length, and no known name is half as long.
    if name.len() > LONGEST_MISSPELT {
        return None;
    }
    let folded = name.to_lowercase().replace('-', "_");
    known
        .iter()
        .map(|&candidate| (strsim::damerau_levenshtein(&folded, candidate), candidate))
        .filter(|&(distance, candidate)| {
            let longer = candidate.chars().count().max(folded.chars().count());
            distance * 3 <= longer || (folded.len() >= 4 && candidate.contains(&folded))
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// The other places where a key of exactly this name belongs.
pub(in crate::manifest) fn homes(schema: &'static [Key], name: &str) -> Vec<&'static str> {
    schema
        .iter()
        .filter_map(|key| key.path.rsplit_once('.'))
        .filter(|&(home, last)| last == name && !home.contains(['*', '<']))
        .map(|(home, _)| home)
        .collect()
}

impl Key {
    /// What the key takes, in words, with its range and an example.
    pub fn accepted(&self) -> String {
        let words = self.bounds.words();
        let range = if words.is_empty() {
            String::new()
        } else {
            format!(", {words}")
        };
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
            Kind::Integer if self.bounds.max >= MANY => {
                format!("a whole number, at least {}; for example {example}", self.bounds.min)
            }
            Kind::Integer => {
                let why = match self.why {
                    "" => String::new(),
                    why => format!(" ({why})"),
                };
                format!(
                    "a whole number from {} to {}{why}; for example {example}",
                    self.bounds.min, self.bounds.max
                )
            }
            Kind::Boolean => "true or false".to_owned(),
            Kind::Text => format!("a text in quotes; for example {example}"),
            Kind::Choice(choices) => choices
                .iter()
                .map(|choice| format!("\"{choice}\""))
                .collect::<Vec<_>>()
                .join(", "),
            Kind::List(of) => format!("a list of {of}; for example {example}"),
            Kind::ContactDamping => format!(
                "a damping ratio (bare number or %){range}, or a coefficient with its unit ({}); for example 0.05 or \"1483 N*s/m\"",
                Dimension::Damping.units()
            ),
            Kind::Tolerance => format!("\"roundoff\", or a number{range}"),
            Kind::Initial => "\"static\", \"rest\", or { displacement = [...], velocity = [...] } in modal coordinates".to_owned(),
            Kind::Table => {
                let names = children(MANIFEST, self.path);
                format!("a table with the keys {}", names.join(", "))
            }
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
