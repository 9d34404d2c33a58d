//! Named arrays of numbers, as a builder hands them over.

use super::CacheError;

/// The arrays of a table in memory, in the order in which they were pushed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Arrays(Vec<Array>);

/// One array.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    pub name: String,
    pub unit: String,
    /// Extent of each axis, slowest first.
    pub shape: Vec<usize>,
    /// Row by row: the last axis is contiguous.
    pub values: Vec<f64>,
}

impl Arrays {
    /// No array.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an array: `name` in lower case as in `docs/notation.md`, `unit` in SI (`1` for a
    /// pure number), `shape` with the slowest axis first (empty for a single number),
    /// `values` row by row.
    ///
    /// # Errors
    /// The name is taken, or the shape does not have as many places as there are values.
    pub fn push(
        &mut self,
        name: &str,
        unit: &str,
        shape: &[usize],
        values: Vec<f64>,
    ) -> Result<(), CacheError> {
        if self.0.iter().any(|array| array.name == name) {
            return Err(CacheError::NameTaken { name: name.into() });
        }
        if places(shape) != Some(values.len()) {
            return Err(CacheError::Shape {
                name: name.into(),
                shape: shape.to_vec(),
                values: values.len(),
            });
        }
        self.0.push(Array {
            name: name.into(),
            unit: unit.into(),
            shape: shape.to_vec(),
            values,
        });
        Ok(())
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Array> {
        self.0.iter()
    }
}

/// Number of places of a shape; none where it is beyond what can be counted.
pub(super) fn places(shape: &[usize]) -> Option<usize> {
    shape
        .iter()
        .try_fold(1_usize, |places, extent| places.checked_mul(*extent))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_have_to_fit_and_names_to_differ() {
        let mut arrays = Arrays::new();
        arrays
            .push("stiffness", "N/m", &[2, 3], vec![0.0; 6])
            .unwrap();
        arrays.push("mean", "N/m", &[], vec![1.0]).unwrap();
        arrays.push("nothing", "1", &[0, 3], Vec::new()).unwrap();
        let twice = arrays.push("mean", "1", &[1], vec![0.0]);
        assert!(matches!(twice, Err(CacheError::NameTaken { .. })));
        for shape in [&[2, 2][..], &[], &[usize::MAX, 2]] {
            let error = arrays.push("x", "1", shape, vec![0.0; 3]).unwrap_err();
            assert!(error.to_string().contains("has 3 values"), "{error}");
        }
        assert_eq!(arrays.iter().count(), 3);
    }
}
