//! Tables of a results folder in a page of limited size.
//!
//! The table of points keeps all rows and omits the columns that do not fit. Other tables keep all rows of
//! some points: of one in two, one in four, and so on, so that the data of a point stay complete. Tables
//! without `point_id` keep a part of their rows in the same way.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Value, json};

use super::block::Blocks;
use super::columns::{Packed, PartialColumn};
use crate::report::numbers::plural;
use crate::store::{ColumnHead, ColumnKind, ResultTable, StoreError, TableKind};

/// Columns of the table of points that a page always contains.
const NEEDED: [&str; 5] = ["point_id", "status", "reason", "class", "period"];

/// Columns besides the axes that the first picture of the points needs.
const SHOWN_FIRST: [&str; 3] = ["lambda_max", "errors_verified", "direction"];

/// Number of values of the table of points that are read at a time: 32 MB.
const NUMBERS_AT_A_TIME: usize = 1 << 22;

/// Assumed ratio of the size of data in memory to their packed size.
const SHRINKS: u64 = 4;

/// A table in the form for a page.
pub(super) struct Embedded {
    /// Description for the head of the page: name, numbers of rows, columns.
    pub description: Value,
    /// Description of the parts that did not fit.
    pub left_out: Option<String>,
}

/// The rows of a table that a page has room for.
struct Rows {
    columns: Vec<PartialColumn>,
    /// For each kept row, the key that decides whether it is kept: `point_id`, or else the number of the row.
    keys: Vec<u64>,
    /// All points with rows in the table, kept or not; empty if rows do not belong to points.
    points: BTreeSet<u64>,
    /// Number of rows of the whole table.
    all: u64,
    /// One key in `2^thinned` is kept.
    thinned: u32,
}

/// Whether a point or a row is kept if about one key in `2^thinned` is kept. The key is hashed, so that the
/// kept points form no pattern along an axis of the grid.
fn is_kept(key: u64, thinned: u32) -> bool {
    // The golden ratio times 2^64 (Knuth 1998, section 6.4).
    let scattered = key.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    thinned == 0 || scattered >> (64 - thinned.min(63)) == 0
}

impl Rows {
    /// Reads a table; thins its rows if they take more than `max_bytes` bytes.
    fn read(folder: &Path, kind: TableKind, max_bytes: u64) -> Result<Self, StoreError> {
        let heads = ResultTable::head(folder, kind)?.columns()?;
        let names: Vec<String> = heads.iter().map(|head| head.name.clone()).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let of_points = names.contains(&"point_id");
        let mut rows = Self {
            columns: heads.into_iter().map(PartialColumn::new).collect(),
            keys: Vec::new(),
            points: BTreeSet::new(),
            all: 0,
            thinned: 0,
        };
        ResultTable::scan(folder, kind, &names, |part| {
            let first = rows.all;
            rows.all += part.rows() as u64;
            let keys: Vec<u64> = if of_points {
                (part.u64("point_id")?.into_iter())
                    .map(Option::unwrap_or_default)
                    .collect()
            } else {
                (first..rows.all).collect()
            };
            if of_points {
                rows.points.extend(&keys);
            }
            let wanted: Vec<bool> = keys.iter().map(|key| is_kept(*key, rows.thinned)).collect();
            let kept_keys = keys.iter().zip(&wanted).filter(|(_, wanted)| **wanted);
            rows.keys.extend(kept_keys.map(|(key, _)| *key));
            for column in &mut rows.columns {
                column.take(part, &wanted)?;
            }
            while rows.bytes() > max_bytes {
                rows.thin();
            }
            Ok::<_, StoreError>(())
        })?;
        if of_points {
            let mut order: Vec<usize> = (0..rows.keys.len()).collect();
            order.sort_by_key(|&row| rows.keys[row]);
            rows.rearrange(&order);
        }
        Ok(rows)
    }

    fn bytes(&self) -> u64 {
        self.columns.iter().map(PartialColumn::bytes).sum()
    }

    /// Keeps about half of the kept points or rows; after 64 halvings, none.
    fn thin(&mut self) {
        self.thinned += 1;
        let kept_rows: Vec<usize> = (0..self.keys.len())
            .filter(|&row| self.thinned < 64 && is_kept(self.keys[row], self.thinned))
            .collect();
        self.rearrange(&kept_rows);
    }

    fn rearrange(&mut self, order: &[usize]) {
        for column in &mut self.columns {
            column.rearrange(order);
        }
        self.keys = order.iter().map(|&row| self.keys[row]).collect();
    }

    /// Description of the rows that were left out; `None` if all rows are kept.
    fn left_out(&self, name: &str) -> Option<String> {
        let distinct_keys: BTreeSet<u64> = self.keys.iter().copied().collect();
        let all = if self.points.is_empty() {
            plural(self.all as usize, "row")
        } else {
            plural(self.points.len(), "point")
        };
        (self.thinned > 0).then(|| {
            format!(
                "{name}: the page has rows of {} of {all}",
                distinct_keys.len()
            )
        })
    }
}

/// Embeds the table of points, in ascending `point_id`: all its rows, and the columns that fit. Columns are
/// read in small groups, because all columns of a million points take a gigabyte of memory.
///
/// # Errors
/// The table cannot be read.
pub(super) fn embed_points(
    folder: &Path,
    axes: &[String],
    max_bytes: u64,
    blocks: &mut Blocks,
) -> Result<Embedded, StoreError> {
    let order = point_order(folder)?;
    let (mut descriptions, mut empty, mut left) = (Vec::new(), Vec::new(), Vec::new());
    let mut bytes_left = max_bytes;
    let heads = ResultTable::head(folder, TableKind::Points)?.columns()?;
    let columns_at_a_time = (NUMBERS_AT_A_TIME / order.len().max(1)).max(1);
    let is_list = |head: &ColumnHead| head.kind == ColumnKind::List;
    // Lists are as large as many columns, so that each is read alone.
    let groups = heads.chunk_by(|a, b| !is_list(a) && !is_list(b));
    for heads in groups.flat_map(|heads| heads.chunks(columns_at_a_time)) {
        let names: Vec<&str> = heads.iter().map(|head| head.name.as_str()).collect();
        let mut columns: Vec<PartialColumn> =
            heads.iter().cloned().map(PartialColumn::new).collect();
        ResultTable::scan(folder, TableKind::Points, &names, |part| {
            let all = vec![true; part.rows()];
            (columns.iter_mut()).try_for_each(|column| column.take(part, &all))
        })?;
        for mut column in columns {
            if !order.is_sorted() {
                column.rearrange(&order);
            }
            let name = column.head.name.clone();
            let needed = NEEDED.contains(&name.as_str()) || axes.contains(&name);
            if column.is_empty() && !needed {
                empty.push(name);
                continue;
            }
            // Packing takes most of the time. Skip a column that is unlikely to fit.
            let likely = needed || column.likely_bytes() <= 2 * bytes_left;
            let packed = likely.then(|| column.packed());
            match packed.filter(|packed| needed || packed.bytes() <= bytes_left) {
                Some(packed) => {
                    bytes_left = bytes_left.saturating_sub(packed.bytes());
                    let from = blocks.count();
                    descriptions.push(packed.embed(blocks));
                    if SHOWN_FIRST.contains(&name.as_str()) || axes.contains(&name) {
                        blocks.mark_for_first_picture(from);
                    }
                }
                None => left.push(name),
            }
        }
    }
    let count = order.len();
    let left_out = (!left.is_empty()).then(|| format!("points: columns {}", left.join(", ")));
    Ok(Embedded {
        description: json!({
            "name": TableKind::Points.name(),
            "rows": count,
            "kept": count,
            "columns": descriptions,
            "empty": empty,
        }),
        left_out,
    })
}

/// Indices of the rows of the table of points, in ascending `point_id`.
fn point_order(folder: &Path) -> Result<Vec<usize>, StoreError> {
    let mut ids = Vec::new();
    ResultTable::scan(folder, TableKind::Points, &["point_id"], |part| {
        ids.extend(part.u64("point_id")?);
        Ok::<_, StoreError>(())
    })?;
    let mut order: Vec<usize> = (0..ids.len()).collect();
    order.sort_by_key(|&row| ids[row]);
    Ok(order)
}

/// Embeds a table other than that of the points: all its columns, and the rows that fit.
///
/// # Errors
/// The table cannot be read.
pub(super) fn embed(
    folder: &Path,
    kind: TableKind,
    max_bytes: u64,
    blocks: &mut Blocks,
) -> Result<Embedded, StoreError> {
    let mut bytes_left = max_bytes.saturating_mul(SHRINKS);
    loop {
        let rows = Rows::read(folder, kind, bytes_left)?;
        let (all, count) = (rows.all, rows.keys.len());
        let left_out = rows.left_out(kind.name());
        let row_bytes = rows.bytes();
        let (empty, columns): (Vec<_>, Vec<_>) =
            rows.columns.into_iter().partition(PartialColumn::is_empty);
        let packed: Vec<Packed> = columns.into_iter().map(PartialColumn::packed).collect();
        if count > 0 && packed.iter().map(Packed::bytes).sum::<u64>() > max_bytes {
            // The data compressed less than assumed: read half of them next.
            bytes_left = row_bytes / 2;
            continue;
        }
        let columns: Vec<Value> = (packed.into_iter())
            .map(|column| column.embed(blocks))
            .collect();
        return Ok(Embedded {
            description: json!({
                "name": kind.name(),
                "rows": all,
                "kept": count,
                "columns": columns,
                "empty": empty.iter().map(|column| &column.head.name).collect::<Vec<_>>(),
            }),
            left_out,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_points_are_among_those_kept_before() {
        for thinned in 0..10 {
            let kept = |more: u32| (0..100_000).filter(move |&key| is_kept(key, thinned + more));
            let (all, fewer): (Vec<u64>, Vec<u64>) = (kept(0).collect(), kept(1).collect());
            assert!(fewer.iter().all(|key| all.contains(key)));
            let wanted = 100_000.0 / f64::from(1 << thinned);
            let found = all.len() as f64;
            assert!((found / wanted - 1.0).abs() < 0.1, "{thinned}: {found}");
        }
    }

    /// In a plane of 100 x 100 points, every row and every column keeps some points.
    #[test]
    fn kept_points_follow_no_axis() {
        let kept: Vec<u64> = (0..10_000).filter(|&key| is_kept(key, 3)).collect();
        for side in 0..100 {
            assert!(kept.iter().any(|key| key % 100 == side), "column {side}");
            assert!(kept.iter().any(|key| key / 100 == side), "row {side}");
        }
    }
}
