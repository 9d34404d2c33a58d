//! The survey of a table before it is written: its number of rows and the lengths of its lists.

use super::cells::Cells;
use super::error::ExportError;
use super::format::Lists;
use crate::store::{ColumnHead, ColumnKind, ResultTable, StoreError, TableKind};
use std::collections::HashSet;
use std::path::Path;

/// A table of a folder, with the counts of a survey.
#[derive(Debug)]
pub struct Surveyed {
    /// Kind of the table.
    pub kind: TableKind,
    /// Number of rows.
    pub rows: u64,
    /// The chosen columns, in file order.
    pub columns: Vec<SurveyedColumn>,
}

/// A column of a table.
#[derive(Debug)]
pub struct SurveyedColumn {
    /// Name, unit, description and type.
    pub head: ColumnHead,
    /// Number of rows without a value.
    pub absent: u64,
    /// Number of elements of the longest list; 0 if the column contains no lists.
    pub width: usize,
    /// Whether every list has as many elements as there are element names.
    named: bool,
}

impl SurveyedColumn {
    fn new(head: ColumnHead) -> Self {
        Self {
            named: !head.elements.is_empty(),
            head,
            absent: 0,
            width: 0,
        }
    }

    fn add(&mut self, rows: &ResultTable) -> Result<(), StoreError> {
        let name = &self.head.name;
        self.absent += rows.absent(name) as u64;
        if !self.is_list() {
            return Ok(());
        }
        for list in rows.lists(name)?.iter().flatten() {
            self.width = self.width.max(list.len());
            self.named &= list.len() == self.head.elements.len();
        }
        Ok(())
    }

    /// Whether its values are lists.
    pub fn is_list(&self) -> bool {
        self.head.kind == ColumnKind::List
    }

    /// Number of columns after lists are widened.
    pub fn places(&self) -> usize {
        if self.is_list() { self.width } else { 1 }
    }

    /// Names of the list elements; empty if the elements have no names, or if a list has another length.
    pub fn elements(&self) -> &[String] {
        if self.named { &self.head.elements } else { &[] }
    }

    /// `deflection_rms`, `harmonics_2` for the second element of a list, `bearing_rms_pinion_1_x` for one with a name.
    fn name(&self, place: usize) -> String {
        let name = self.head.name.clone();
        match (self.is_list(), self.elements().get(place)) {
            (false, _) => name,
            (true, Some(element)) => format!("{name}_{}", element.replace(' ', "_")),
            (true, None) => format!("{name}_{}", place + 1),
        }
    }

    /// A name with its unit, if it has one: `deflection_rms [m]`.
    pub fn titled(&self, name: String) -> String {
        match self.head.unit.as_str() {
            "" | "1" => name,
            unit => format!("{name} [{unit}]"),
        }
    }
}

impl Surveyed {
    /// Name of the table.
    pub fn name(&self) -> &'static str {
        self.kind.name()
    }

    /// The columns of the table, with lists widened to one column per element, or left out. Equal names (elements `b x`
    /// and `b_x`) are numbered from the second on.
    pub(super) fn flat(&self, lists: Lists) -> Vec<FlatColumn> {
        let mut taken = HashSet::new();
        let mut flat = Vec::new();
        for (index, column) in self.columns.iter().enumerate() {
            if lists != Lists::Wide && column.is_list() {
                continue;
            }
            for place in 0..column.places() {
                let plain = column.name(place);
                let mut name = plain.clone();
                let mut count = 1;
                while !taken.insert(name.clone()) {
                    count += 1;
                    name = format!("{plain}_{count}");
                }
                flat.push(FlatColumn {
                    column: index,
                    place,
                    title: column.titled(name),
                });
            }
        }
        flat
    }

    /// Whether lists go into a separate table.
    pub(super) fn has_long_lists(&self, lists: Lists) -> bool {
        lists == Lists::Long && self.columns.iter().any(SurveyedColumn::is_list)
    }

    /// Calls `each` with some thousand rows at a time, as one [`Cells`] per column.
    pub(super) fn scan(
        &self,
        folder: &Path,
        mut each: impl FnMut(Vec<Cells>) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        let names: Vec<&str> = (self.columns.iter())
            .map(|column| column.head.name.as_str())
            .collect();
        ResultTable::scan(folder, self.kind, &names, |rows| {
            let columns = self.columns.iter();
            let cells =
                columns.map(|column| Cells::read(rows, &column.head.name, column.head.kind));
            each(cells.collect::<Result<_, _>>()?)
        })
    }
}

/// A column of the table after lists are widened or left out.
#[derive(Debug)]
pub(super) struct FlatColumn {
    /// Index in [`Surveyed::columns`] of the column with its values.
    pub column: usize,
    /// Index of the element of its lists, from 0.
    pub place: usize,
    /// Title of the column.
    pub title: String,
}

/// Reads the table once. Counts its rows and, for each chosen column (all if `chosen` is empty), the absent
/// values and the longest list.
///
/// # Errors
/// The table cannot be read, or was changed.
pub fn survey(folder: &Path, kind: TableKind, chosen: &[String]) -> Result<Surveyed, StoreError> {
    let heads = ResultTable::head(folder, kind)?.columns()?;
    let wanted = |head: &ColumnHead| chosen.is_empty() || chosen.contains(&head.name);
    let columns: Vec<SurveyedColumn> = (heads.into_iter())
        .filter(wanted)
        .map(SurveyedColumn::new)
        .collect();
    let mut found = Surveyed {
        kind,
        rows: 0,
        columns,
    };
    let names: Vec<String> = (found.columns.iter())
        .map(|column| column.head.name.clone())
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    ResultTable::scan(folder, kind, &names, |rows| {
        found.rows += rows.rows() as u64;
        for column in &mut found.columns {
            column.add(rows)?;
        }
        Ok::<_, StoreError>(())
    })?;
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column whose lists have two named elements.
    fn column(name: &str, elements: [&str; 2]) -> SurveyedColumn {
        let mut column = SurveyedColumn::new(ColumnHead {
            name: name.to_owned(),
            unit: "N".to_owned(),
            description: String::new(),
            kind: ColumnKind::List,
            elements: elements.map(str::to_owned).to_vec(),
        });
        column.width = 2;
        column
    }

    /// Columns whose names differ only in a space and an underscore get different titles.
    #[test]
    fn equal_heads_are_numbered() {
        let surveyed = Surveyed {
            kind: TableKind::Points,
            rows: 1,
            columns: vec![column("mean", ["b x", "b_x"]), column("rms", ["b x", "a"])],
        };
        let flat = surveyed.flat(Lists::Wide);
        let titles: Vec<&str> = flat.iter().map(|flat| flat.title.as_str()).collect();
        let expected = ["mean_b_x [N]", "mean_b_x_2 [N]", "rms_b_x [N]", "rms_a [N]"];
        assert_eq!(titles, expected);
    }
}
