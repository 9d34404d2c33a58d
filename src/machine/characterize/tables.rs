//! Tables of dense kernels: built once, and copied into memory of their own wherever they are
//! read.
//!
//! Load and half gap are coordinates of the state that these tables act on, so that operating
//! points of one speed have equal tables. Their time is one of memory, whoever wrote it.

use super::buffer::{Buffer, LANES, Line};
use super::error::MeasurementError;
use super::memory;
use super::plan::Solver;
use crate::propagate::{KeptTables, TableArray};
use gearatlas_paper::kernels::DenseError;

/// Tables as they were built, for every kernel and number of modes.
#[derive(Debug, Default)]
pub struct BuiltTables(Vec<((Solver, usize), Vec<TableArray>)>);

impl BuiltTables {
    /// The tables of a kernel, built where they were not before.
    pub fn of(
        &mut self,
        solver: Solver,
        modes: usize,
        build: impl FnOnce() -> Result<Vec<TableArray>, DenseError>,
    ) -> Result<&[TableArray], DenseError> {
        let key = (solver, modes);
        let place = match self.0.iter().position(|(known, _)| *known == key) {
            Some(place) => place,
            None => {
                self.0.push((key, build()?));
                self.0.len() - 1
            }
        };
        Ok(&self.0[place].1)
    }
}

/// Tables in pages that the thread which made them touched first.
#[derive(Debug)]
pub struct LocalTables(Vec<(&'static str, usize, Buffer)>);

impl LocalTables {
    /// Copies tables.
    pub fn new(built: &[TableArray]) -> Result<Self, MeasurementError> {
        let arrays = built.iter().map(|array| {
            let lines = array.values.len().div_ceil(LANES);
            let mut buffer = memory::untouched(lines)?;
            for (line, values) in buffer
                .lines_mut()
                .iter_mut()
                .zip(array.values.chunks(LANES))
            {
                let mut copied = [0.0; LANES];
                copied[..values.len()].copy_from_slice(values);
                *line = Line(copied);
            }
            Ok((array.name, array.values.len(), buffer))
        });
        Ok(Self(arrays.collect::<Result<_, MeasurementError>>()?))
    }
}

impl KeptTables for LocalTables {
    fn numbers(&self, name: &str) -> Option<&[f64]> {
        let array = self.0.iter().find(|(known, ..)| *known == name);
        array.map(|(_, count, buffer)| &buffer.doubles()[..*count])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_holds_what_was_built() {
        let array = |name, count: usize| TableArray {
            name,
            unit: "1",
            values: (0..count).map(|i| i as f64 + 0.5).collect::<Vec<_>>()[..].into(),
        };
        let mut built_tables = BuiltTables::default();
        let built = vec![array("a", 19), array("b", 0), array("c", 8)];
        built_tables
            .of(Solver::Fused, 4, || Ok(built.clone()))
            .unwrap();
        let again = |built_tables: &mut BuiltTables, modes| {
            let fails = || Err(DenseError::Overdamped);
            built_tables
                .of(Solver::Fused, modes, fails)
                .map(<[_]>::to_vec)
        };
        assert_eq!(again(&mut built_tables, 4), Ok(built.clone()));
        assert!(again(&mut built_tables, 5).is_err());
        let copy = LocalTables::new(&built).unwrap();
        for array in &built {
            let numbers = copy.numbers(array.name).unwrap();
            assert_eq!(numbers, &array.values[..]);
            assert_eq!(numbers.as_ptr() as usize % super::super::buffer::LINE, 0);
        }
        assert_eq!(copy.numbers("d"), None);
    }
}
