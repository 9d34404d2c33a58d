//! Names of pictures in a request: kinds of pictures, and columns with elements of their lists.

use std::fmt;
use std::str::FromStr;

use crate::report::plot::picture_kind::PictureKind;
use crate::store::TableKind;
use strum::VariantArray;

/// Tables with drawable columns. Each of their rows belongs to a point.
pub(super) const TABLES: [TableKind; 3] =
    [TableKind::Points, TableKind::Attractors, TableKind::Orbits];

/// A request: a kind of picture, or a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PictureRequest {
    /// A kind of picture.
    Kind(PictureKind),
    /// A column.
    Column(ColumnName),
}

/// A selection of elements of a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Element {
    /// Counted from 1.
    Number(usize),
    /// The element with this name, or else all elements whose names contain all words of this text.
    Name(String),
}

impl Element {
    /// Indices of the selected elements of a list of this length, from 0. `names` are the names of its
    /// elements; empty if they have none.
    pub fn among(&self, names: &[String], length: usize) -> Vec<usize> {
        match self {
            Self::Number(number) => (*number <= length)
                .then(|| number - 1)
                .into_iter()
                .collect(),
            Self::Name(wanted) => {
                if let Some(exactly) = names.iter().position(|name| name == wanted) {
                    return vec![exactly];
                }
                let words = |name: &str| -> Vec<String> {
                    let words = name.split([' ', ',']).filter(|word| !word.is_empty());
                    words.map(str::to_owned).collect()
                };
                let meant = |place: &usize| {
                    let words_of_name = words(&names[*place]);
                    words(wanted)
                        .iter()
                        .all(|word| words_of_name.contains(word))
                };
                (0..names.len().min(length)).filter(meant).collect()
            }
        }
    }
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Name(name) => f.write_str(name),
        }
    }
}

/// A column of numbers: `deflection_rms`, `harmonics[3]`, `bearing_rms[pinion 1 x]`, `orbits.lambda`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnName {
    pub(super) table: TableKind,
    /// Name in the table.
    pub(super) name: String,
    /// Elements of a list; `None` for all.
    pub(super) element: Option<Element>,
}

/// The text in brackets after the name of a column is not an element.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{text}` has an element that is neither a number (counted from 1) nor a name; write for example \
     harmonics[3], bearing_rms[pinion 1 x]"
)]
pub struct NoColumn {
    text: String,
}

impl FromStr for PictureRequest {
    type Err = NoColumn;

    fn from_str(text: &str) -> Result<Self, NoColumn> {
        if let Some(what) = PictureKind::VARIANTS
            .iter()
            .find(|what| what.name() == text)
        {
            return Ok(Self::Kind(*what));
        }
        let of_table = TABLES.iter().find_map(|&table| {
            let rest = text.strip_prefix(table.name())?.strip_prefix('.')?;
            Some((table, rest))
        });
        let (table, rest) = of_table.unwrap_or((TableKind::Points, text));
        let refused = || NoColumn {
            text: text.to_owned(),
        };
        let (name, element) = match rest.split_once('[') {
            None => (rest, None),
            Some((name, element)) => {
                let element = element.strip_suffix(']').map(str::trim);
                let element = element.filter(|text| !text.is_empty());
                let element = element.ok_or_else(refused)?;
                let element = match element.parse() {
                    Ok(0) => return Err(refused()),
                    Ok(number) => Element::Number(number),
                    Err(_) => Element::Name(element.to_owned()),
                };
                (name, Some(element))
            }
        };
        Ok(Self::Column(ColumnName {
            table,
            name: name.to_owned(),
            element,
        }))
    }
}

impl ColumnName {
    /// The column, without an element.
    pub fn whole(&self) -> Self {
        Self {
            element: None,
            ..self.clone()
        }
    }
}

impl fmt::Display for ColumnName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.table != TableKind::Points {
            write!(f, "{}.", self.table.name())?;
        }
        f.write_str(&self.name)?;
        match &self.element {
            Some(element) => write!(f, "[{element}]"),
            None => Ok(()),
        }
    }
}

/// Up to four known names similar to `name`, the most similar first. They contain it, are part of it, or
/// differ from it in few letters.
pub(in crate::report::plot) fn nearest(name: &str, known: &[String]) -> Vec<String> {
    const MOST_NAMES: usize = 4;
    let folded = name.to_lowercase();
    let mut near: Vec<(usize, &String)> = (known.iter())
        .filter_map(|candidate| {
            let distance = strsim::damerau_levenshtein(&folded, candidate);
            let held =
                folded.len() > 2 && (candidate.contains(&folded) || folded.contains(&**candidate));
            (held || distance <= 1 + name.len() / 3).then_some((distance, candidate))
        })
        .collect();
    near.sort();
    near.into_iter()
        .take(MOST_NAMES)
        .map(|(_, name)| name.clone())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(text: &str) -> ColumnName {
        match text.parse() {
            Ok(PictureRequest::Column(column)) => column,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn names_are_kinds_columns_and_elements_of_lists() {
        assert_eq!(
            "lambda".parse(),
            Ok(PictureRequest::Kind(PictureKind::Lambda))
        );
        let of = |text: &str| {
            let found = column(text);
            assert_eq!(found.to_string(), text.replace("points.", ""));
            (found.table.name(), found.name, found.element)
        };
        assert_eq!(of("lambda_max"), ("points", "lambda_max".into(), None));
        assert_eq!(of("points.horizon"), ("points", "horizon".into(), None));
        assert_eq!(
            of("mesh.half_gap"),
            ("points", "mesh.half_gap".into(), None)
        );
        let third = Some(Element::Number(3));
        assert_eq!(of("harmonics[3]"), ("points", "harmonics".into(), third));
        let named = Some(Element::Name("pinion 1 x".into()));
        assert_eq!(
            of("bearing_rms[pinion 1 x]"),
            ("points", "bearing_rms".into(), named)
        );
        assert_eq!(of("orbits.lambda"), ("orbits", "lambda".into(), None));
        for element in ["[0]", "[00]", "[+0]", "[]", "[ ]", "[1"] {
            let wrong = format!("harmonics{element}");
            assert!(wrong.parse::<PictureRequest>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn elements_are_meant_by_their_names_or_words_of_these() {
        let names = ["pinion 1 x", "pinion 1 y", "wheel 1 x", "wheel 1 x base"];
        let names = names.map(str::to_owned);
        let among = |text: &str| Element::Name(text.to_owned()).among(&names, 4);
        assert_eq!(among("wheel 1 x"), [2]);
        assert_eq!(among("x"), [0, 2, 3]);
        assert_eq!(among("x pinion"), [0]);
        assert_eq!(among("in"), [] as [usize; 0]);
        let stages = [
            "stage 1 of engine and input, forward",
            "stage 1 of engine and input, backward",
        ];
        let stages = stages.map(str::to_owned);
        let of_stages = |text: &str| Element::Name(text.to_owned()).among(&stages, 2);
        assert_eq!(of_stages("stage 1 of engine and input, forward"), [0]);
        assert_eq!(of_stages("input"), [0, 1]);
        assert_eq!(of_stages("input, backward"), [1]);
        assert_eq!(Element::Number(4).among(&[], 4), [3]);
        assert_eq!(Element::Number(5).among(&names, 4), [] as [usize; 0]);
    }

    #[test]
    fn the_nearest_names_are_given() {
        let known = ["deflection_rms", "deflection_mean", "force_peak", "speed"];
        let known = known.map(str::to_owned);
        assert_eq!(nearest("deflection_rsm", &known)[0], "deflection_rms");
        assert_eq!(nearest("rms", &known), ["deflection_rms"]);
        assert!(nearest("colour", &known).is_empty());
    }
}
