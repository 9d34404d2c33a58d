//! Columns of a table for a page: while they are read, and as packed arrays.

use std::collections::HashMap;

use serde_json::{Value, json};

use super::block;
use crate::store::{ColumnHead, ColumnKind, ResultTable, StoreError};

/// The stored length of a missing list.
const NO_LIST: u32 = u32::MAX;

/// Number of values that are packed to estimate the packed size of a column.
const PART: usize = 1 << 15;

/// The values of a column.
#[derive(Debug)]
enum Values {
    /// One number per row; NaN if the row has none.
    Numbers(Vec<f64>),
    /// `codes`: for each row, the position of its text in `texts`, from 1; 0 if the row has none.
    Texts {
        codes: Vec<u32>,
        texts: Vec<String>,
        places: HashMap<String, u32>,
    },
    /// The elements of all lists, one list after the other.
    Lists {
        lengths: Vec<u32>,
        elements: Vec<f64>,
    },
}

/// A column while it is being read.
#[derive(Debug)]
pub(super) struct PartialColumn {
    pub head: ColumnHead,
    values: Values,
}

/// A column as packed arrays for [`super::block::Blocks`], with its description for the page.
pub(super) struct Packed {
    head: ColumnHead,
    arrays: Vec<(&'static str, String)>,
    /// Number of elements of the longest list.
    longest: usize,
}

impl Packed {
    /// Number of characters of its arrays.
    pub fn bytes(&self) -> u64 {
        self.arrays.iter().map(|(_, text)| text.len() as u64).sum()
    }

    /// Adds its arrays to those of the page; returns the description of the column.
    pub fn embed(self, blocks: &mut block::Blocks) -> Value {
        let kind = match self.head.kind {
            ColumnKind::Whole => "whole",
            ColumnKind::Number => "number",
            ColumnKind::Truth | ColumnKind::Text => "text",
            ColumnKind::List => "list",
        };
        let mut description = json!({
            "name": self.head.name,
            "unit": self.head.unit,
            "description": self.head.description,
            "kind": kind,
        });
        if !self.head.elements.is_empty() {
            description["elements"] = json!(self.head.elements);
        }
        if self.head.kind == ColumnKind::List {
            description["longest"] = json!(self.longest);
        }
        for (name, text) in self.arrays {
            description[name] = json!(blocks.push(text));
        }
        description
    }
}

impl PartialColumn {
    /// A column without rows.
    pub fn new(head: ColumnHead) -> Self {
        let values = match head.kind {
            ColumnKind::Whole | ColumnKind::Number => Values::Numbers(Vec::new()),
            ColumnKind::Truth | ColumnKind::Text => Values::Texts {
                codes: Vec::new(),
                texts: Vec::new(),
                places: HashMap::new(),
            },
            ColumnKind::List => Values::Lists {
                lengths: Vec::new(),
                elements: Vec::new(),
            },
        };
        Self { head, values }
    }

    /// Appends the rows of a part of the table for which `wanted` is true.
    ///
    /// # Errors
    /// The part has no such column.
    pub fn take(&mut self, part: &ResultTable, wanted: &[bool]) -> Result<(), StoreError> {
        let name = self.head.name.as_str();
        let chosen = |row: &usize| wanted[*row];
        let rows = (0..wanted.len()).filter(chosen);
        match &mut self.values {
            Values::Numbers(values) if self.head.kind == ColumnKind::Whole => {
                let column = part.u64(name)?;
                values.extend(rows.map(|row| column[row].map_or(f64::NAN, |whole| whole as f64)));
            }
            Values::Numbers(values) => {
                let column = part.f64(name)?;
                values.extend(rows.map(|row| column[row].unwrap_or(f64::NAN)));
            }
            Values::Texts {
                codes,
                texts,
                places,
            } => {
                let mut own = match self.head.kind {
                    ColumnKind::Truth => (part.bool(name)?.into_iter())
                        .map(|truth| Some(if truth? { "yes" } else { "no" }.to_owned()))
                        .collect(),
                    _ => part.text(name)?,
                };
                for row in rows {
                    codes.push(own[row].take().map_or(0, |text| {
                        *places.entry(text).or_insert_with_key(|text| {
                            texts.push(text.clone());
                            texts.len() as u32
                        })
                    }));
                }
            }
            Values::Lists { lengths, elements } => {
                let own = part.lists(name)?;
                for row in rows {
                    let list = own[row].as_deref();
                    lengths.push(list.map_or(NO_LIST, |list| list.len() as u32));
                    let list = list.unwrap_or_default().iter();
                    elements.extend(list.map(|value| value.unwrap_or(f64::NAN)));
                }
            }
        }
        Ok(())
    }

    /// Size of its values in bytes.
    pub fn bytes(&self) -> u64 {
        let bytes = match &self.values {
            Values::Numbers(values) => 8 * values.len(),
            Values::Texts { codes, .. } => 4 * codes.len(),
            Values::Lists { lengths, elements } => 4 * lengths.len() + 8 * elements.len(),
        };
        bytes as u64
    }

    /// Whether no row has a value.
    pub fn is_empty(&self) -> bool {
        match &self.values {
            Values::Numbers(values) => values.iter().all(|value| value.is_nan()),
            Values::Texts { codes, .. } => codes.iter().all(|code| *code == 0),
            Values::Lists { lengths, .. } => lengths.iter().all(|length| *length == NO_LIST),
        }
    }

    /// Keeps only the given rows, in this order; `rows` are their present indices.
    pub fn rearrange(&mut self, rows: &[usize]) {
        match &mut self.values {
            Values::Numbers(values) => *values = rows.iter().map(|&row| values[row]).collect(),
            Values::Texts { codes, .. } => *codes = rows.iter().map(|&row| codes[row]).collect(),
            Values::Lists { lengths, elements } => {
                let mut end = 0;
                let ends: Vec<usize> = (lengths.iter())
                    .map(|&length| {
                        end += length_of(length);
                        end
                    })
                    .collect();
                *elements = (rows.iter())
                    .flat_map(|&row| {
                        elements[ends[row] - length_of(lengths[row])..ends[row]].to_vec()
                    })
                    .collect();
                *lengths = rows.iter().map(|&row| lengths[row]).collect();
            }
        }
    }

    /// Estimated number of characters of its arrays, extrapolated from a part of its numbers; 0 for texts.
    pub fn likely_bytes(&self) -> u64 {
        let (Values::Numbers(values)
        | Values::Lists {
            elements: values, ..
        }) = &self.values
        else {
            return 0;
        };
        let start = (values.len() / 2).saturating_sub(PART / 2);
        let part = &values[start..values.len().min(start + PART)];
        let whole = values.len() as u64;
        block::numbers(part).len() as u64 * whole / (part.len() as u64).max(1)
    }

    /// The column in the form for a page.
    pub fn packed(self) -> Packed {
        let arrays = match &self.values {
            Values::Numbers(values) => vec![("block", block::numbers(values))],
            Values::Texts { codes, texts, .. } => {
                vec![
                    ("block", block::codes(codes)),
                    ("texts", block::texts(texts)),
                ]
            }
            Values::Lists { lengths, elements } => vec![
                ("block", block::numbers(elements)),
                ("lengths", block::codes(lengths)),
            ],
        };
        let longest = match &self.values {
            Values::Lists { lengths, .. } => lengths.iter().map(|&length| length_of(length)).max(),
            _ => None,
        };
        Packed {
            head: self.head,
            arrays,
            longest: longest.unwrap_or(0),
        }
    }
}

/// Number of elements of a list with a stored length.
fn length_of(length: u32) -> usize {
    if length == NO_LIST { 0 } else { length as usize }
}
