//! How are a kernel's tables stored as plain arrays and read back?
//!
//! Arrays with one name are concatenated, table by table. The numbers of an operator have the order in which
//! a kernel reads them, so that it can multiply by them in place.

use super::TableError;
use super::vectors::Aligned;
use std::any::Any;
use std::sync::{Arc, OnceLock};

/// Largest count that a kept table may contain.
const LARGEST_COUNT: f64 = 1e6;

/// One array of a kernel's tables.
#[derive(Debug, Clone, PartialEq)]
pub struct TableArray {
    /// Its name.
    pub name: &'static str,
    /// Its unit; `mixed` if entries have different units.
    pub unit: &'static str,
    /// Its numbers.
    pub values: Aligned,
}

/// Storage beside kept tables for data that kernels create on demand and share.
pub type SharedStorage = OnceLock<Arc<dyn Any + Send + Sync>>;

/// Stored tables, by the names under which they were written.
pub trait KeptTables {
    /// The numbers of an array; `None` if there is no such array. Products are faster if the numbers are
    /// aligned to 64 bytes.
    fn numbers(&self, name: &str) -> Option<&[f64]>;

    /// Storage for data that kernels of the same structure create on demand and share; `None` if these tables have
    /// none.
    fn shared_storage(&self) -> Option<&SharedStorage> {
        None
    }
}

impl KeptTables for Vec<TableArray> {
    fn numbers(&self, name: &str) -> Option<&[f64]> {
        let array = self.iter().find(|array| array.name == name);
        array.map(|array| &array.values[..])
    }
}

/// Collects named arrays to be kept on disk.
#[derive(Debug, Default)]
pub struct KeptWriter(Vec<(&'static str, &'static str, Vec<f64>)>);

impl KeptWriter {
    /// Appends `values` to the array `name`.
    pub fn push(&mut self, name: &'static str, unit: &'static str, values: &[f64]) {
        match self.0.iter_mut().find(|(known, ..)| *known == name) {
            Some((.., all)) => all.extend_from_slice(values),
            None => self.0.push((name, unit, values.to_vec())),
        }
    }

    /// The arrays, in the order in which their names first occurred.
    pub fn finish(self) -> Vec<TableArray> {
        let arrays = self.0.into_iter();
        arrays
            .map(|(name, unit, values)| TableArray {
                name,
                unit,
                values: values[..].into(),
            })
            .collect()
    }
}

/// Reads arrays in the order in which they were written.
pub struct KeptReader<'t> {
    kept: &'t dyn KeptTables,
    /// Unread rests of the arrays read so far.
    rests: Vec<(&'static str, &'t [f64])>,
}

impl<'t> KeptReader<'t> {
    /// A reader before the first number.
    pub fn new(kept: &'t dyn KeptTables) -> Self {
        Self {
            kept,
            rests: Vec::new(),
        }
    }

    /// The next `count` numbers of an array; an error if fewer are left.
    pub fn take(&mut self, name: &'static str, count: usize) -> Result<&'t [f64], TableError> {
        let place = match self.rests.iter().position(|(known, _)| *known == name) {
            Some(place) => place,
            None => {
                let all = self.kept.numbers(name).ok_or(TableError::Kept { name })?;
                self.rests.push((name, all));
                self.rests.len() - 1
            }
        };
        let rest = &mut self.rests[place].1;
        let (taken, left) = rest
            .split_at_checked(count)
            .ok_or(TableError::Kept { name })?;
        *rest = left;
        Ok(taken)
    }

    /// The next number.
    pub fn number(&mut self, name: &'static str) -> Result<f64, TableError> {
        Ok(self.take(name, 1)?[0])
    }

    /// The next number, which must be a count.
    pub fn count(&mut self, name: &'static str) -> Result<usize, TableError> {
        let number = self.number(name)?;
        if (0.0..=LARGEST_COUNT).contains(&number) && number.fract() == 0.0 {
            Ok(number as usize)
        } else {
            Err(TableError::Kept { name })
        }
    }

    /// Checks that every array of which numbers were read was read to its end.
    pub fn finish(self) -> Result<(), TableError> {
        let left = self.rests.iter().find(|(_, rest)| !rest.is_empty());
        left.map_or(Ok(()), |&(name, _)| Err(TableError::Kept { name }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_in_turn() {
        let mut writer = KeptWriter::default();
        writer.push("a", "1", &[1.0, 2.0]);
        writer.push("b", "m", &[0.5]);
        writer.push("a", "1", &[8.0]);
        let arrays = writer.finish();
        assert_eq!(arrays.len(), 2);
        let mut reader = KeptReader::new(&arrays);
        assert_eq!(reader.take("a", 2), Ok(&[1.0, 2.0][..]));
        assert_eq!(reader.count("a"), Ok(8));
        assert_eq!(reader.count("b"), Err(TableError::Kept { name: "b" }));
        for name in ["a", "c"] {
            assert_eq!(reader.number(name), Err(TableError::Kept { name }));
        }
        assert_eq!(reader.finish(), Ok(()));
        let mut short = KeptReader::new(&arrays);
        short.number("a").unwrap();
        assert_eq!(short.finish(), Err(TableError::Kept { name: "a" }));
    }
}
