//! The values of a column, point by point.

use super::request::{ColumnName, TABLES, nearest};
use crate::report::plot::error::PlotError;
use crate::report::plot::picture_kind::PictureKind;
use crate::report::plot::results::Results;
use crate::store::{ColumnHead, ColumnKind, ResultTable, StoreError, TableKind};

/// Names and mesh orders of the elements of the list `suborders`.
pub(in crate::report::plot) const SUBORDERS: [(&str, f64); 5] = [
    ("1/4", 0.25),
    ("1/3", 1.0 / 3.0),
    ("1/2", 0.5),
    ("2/3", 2.0 / 3.0),
    ("3/4", 0.75),
];

/// A value with its standard error; the error is 0 if it is unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::report::plot) struct Sample {
    pub value: f64,
    pub error: f64,
}

/// Values over the points of a results folder.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report::plot) struct Series {
    /// Label of the axis: the column with its table, without an element.
    pub name: String,
    /// Text for the element of the list, which distinguishes series with the same name; empty for a column
    /// without lists.
    pub part: String,
    /// SI unit.
    pub unit: String,
    /// Whether a point may have several values, which form no curve.
    pub scattered: bool,
    pub samples: Samples,
}

/// Values of all points, in the order of the summary.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report::plot) struct Samples {
    /// End index of each point's values.
    ends: Vec<usize>,
    all: Vec<Sample>,
}

impl Samples {
    /// Samples of `points` points. `placed` has the values with the index of their point; the values of a
    /// point keep their order.
    pub fn new(mut placed: Vec<(usize, Sample)>, points: usize) -> Self {
        placed.sort_by_key(|(place, _)| *place);
        let ends = (0..points).map(|point| placed.partition_point(|(place, _)| *place <= point));
        Self {
            ends: ends.collect(),
            all: placed.into_iter().map(|(_, sample)| sample).collect(),
        }
    }

    /// Values of a point.
    pub fn of(&self, point: usize) -> &[Sample] {
        let start = point.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.all[start..self.ends[point]]
    }
}

impl Series {
    /// The value of a point; `None` if it has none, or several.
    pub fn one(&self, point: usize) -> Option<Sample> {
        match self.samples.of(point) {
            [one] => Some(*one),
            _ => None,
        }
    }
}

/// The series of a column: one, or one per element of a list.
///
/// # Errors
/// The column of numbers or the element does not exist.
pub(super) fn read(results: &Results, column: &ColumnName) -> Result<Vec<Series>, PlotError> {
    let Some(table) = results.head(column.table)? else {
        return Err(PlotError::NoTable {
            column: column.to_string(),
            folder: results.folder.clone(),
            table: column.table.file_name(),
        });
    };
    let units = table.units()?;
    let modulus = column.table == TableKind::Orbits && column.name == "multipliers";
    let known = units.get(&column.name).filter(|unit| !unit.is_empty());
    let unit = match (modulus, known) {
        (true, _) => "1",
        (false, Some(unit)) => unit,
        (false, None) => return Err(unknown(results, column, units.contains_key(&column.name))?),
    };
    let partner = match column.name.as_str() {
        "lambda_max" => "lambda_stderr".to_owned(),
        name => format!("{name}_stderr"),
    };
    let partner = units.contains_key(&partner).then_some(partner);
    let head = table.columns()?.into_iter();
    let names = head
        .filter(|head| head.name == column.name)
        .flat_map(|head| head.elements);
    let names: Vec<String> = names.collect();
    let mut wanted = vec!["point_id"];
    if modulus {
        wanted.extend(MULTIPLIERS)
    } else {
        wanted.extend(
            [Some(column.name.as_str()), partner.as_deref()]
                .into_iter()
                .flatten(),
        )
    }
    let (mut placed, mut alike): (Vec<Vec<(usize, Sample)>>, _) = (Vec::new(), true);
    // Read only these columns, some thousand rows at a time: all columns of a million points take a gigabyte.
    ResultTable::scan(&results.folder, column.table, &wanted, |part| {
        let values = if modulus { moduli(part)? } else { part.numbers(&column.name)? };
        let errors = partner
            .as_ref()
            .map(|partner| part.numbers(partner))
            .transpose()?;
        for (row, (id, values)) in part.u64("point_id")?.into_iter().zip(values).enumerate() {
            // If the structures of a grid have different elements, an index does not always mean the same element.
            alike &= values.is_empty() || values.len() == names.len();
            placed.resize_with(placed.len().max(values.len()), Vec::new);
            let Some(place) = id.and_then(|id| results.place(id)) else {
                continue;
            };
            for (element, value) in values.into_iter().enumerate() {
                let error = || errors.as_ref()?[row].get(element).copied().flatten();
                let error = error().unwrap_or(0.0).abs();
                placed[element].extend(value.map(|value| (place, Sample { value, error })));
            }
        }
        Ok::<_, StoreError>(())
    })?;
    let longest = placed.len();
    let names = if alike { names } else { Vec::new() };
    let is_list = modulus || table.is_list(&column.name);
    let elements: Vec<usize> = match (is_list, &column.element) {
        (false, None) => vec![0],
        (true, None) => (0..longest).collect(),
        (true, Some(element)) if !element.among(&names, longest).is_empty() => {
            element.among(&names, longest)
        }
        (_, Some(element)) => {
            return Err(PlotError::NoElement {
                column: column.name.clone(),
                element: element.to_string(),
                length: is_list.then_some(longest),
                names,
            });
        }
    };
    let whole = column.whole();
    let mut of_element = |element: usize| {
        let placed = placed.get_mut(element).map(std::mem::take);
        let samples = Samples::new(placed.unwrap_or_default(), results.summary.all.len());
        Series {
            name: whole.to_string(),
            part: if is_list {
                match names.get(element) {
                    Some(name) => name.clone(),
                    None => element_words(&column.name, element),
                }
            } else {
                String::new()
            },
            unit: unit.to_owned(),
            scattered: column.table != TableKind::Points,
            samples,
        }
    };
    Ok(elements.into_iter().map(&mut of_element).collect())
}

/// Text for an element without a name: `mesh order 3` for harmonics and suborders, else `element 3`, counted
/// from 1.
fn element_words(column: &str, element: usize) -> String {
    match column.trim_end_matches("_stderr") {
        "harmonics" => format!("mesh order {}", element + 1),
        "suborders" => match SUBORDERS.get(element) {
            Some((order, _)) => format!("mesh order {order}"),
            None => format!("element {}", element + 1),
        },
        _ => format!("element {}", element + 1),
    }
}

/// Columns of the multipliers of orbits.
const MULTIPLIERS: [&str; 2] = ["multipliers_re", "multipliers_im"];

/// Moduli of the multipliers of orbits.
fn moduli(table: &ResultTable) -> Result<Vec<Vec<Option<f64>>>, StoreError> {
    let [re, im] = [table.lists(MULTIPLIERS[0])?, table.lists(MULTIPLIERS[1])?];
    let orbits = re.into_iter().zip(im).map(|(re, im)| {
        let pairs = re
            .unwrap_or_default()
            .into_iter()
            .zip(im.unwrap_or_default());
        pairs.map(|(re, im)| Some(re?.hypot(im?))).collect()
    });
    Ok(orbits.collect())
}

/// All drawable columns, by their names in requests.
///
/// # Errors
/// A table cannot be read.
pub(in crate::report::plot) fn listed(results: &Results) -> Result<Vec<ColumnHead>, PlotError> {
    let mut all = Vec::new();
    for kind in TABLES {
        if let Some(table) = results.head(kind)? {
            for head in table.columns()? {
                let numbers = [ColumnKind::Whole, ColumnKind::Number, ColumnKind::List];
                if !numbers.contains(&head.kind) {
                    continue;
                }
                let column = ColumnName {
                    table: kind,
                    name: head.name.clone(),
                    element: None,
                };
                all.push(ColumnHead {
                    name: column.to_string(),
                    ..head
                });
            }
        }
    }
    Ok(all)
}

/// The error for a column that cannot be drawn.
fn unknown(results: &Results, column: &ColumnName, is_text: bool) -> Result<PlotError, PlotError> {
    let columns = listed(results)?.into_iter().map(|head| head.name);
    let known: Vec<String> = PictureKind::names().chain(columns).collect();
    let name = column.to_string();
    Ok(PlotError::UnknownColumn {
        nearest: nearest(&name, &known),
        name,
        is_text,
        folder: results.folder.clone(),
    })
}
