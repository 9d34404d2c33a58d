//! Which displacements of the freedoms of a structure belong to its modes?

/// Shapes of the modes in the freedoms from which a structure was assembled. They relate the modes of two structures.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeShapes {
    /// Inertia of each freedom \[kg or kg m²\].
    pub inertia: Vec<f64>,
    /// Displacement per modal displacement: one row per freedom, with one entry per mode.
    pub shapes: Vec<Vec<f64>>,
}

impl ModeShapes {
    /// The shapes of the first `retained` modes.
    pub(super) fn truncated(&self, retained: usize) -> Self {
        Self {
            inertia: self.inertia.clone(),
            shapes: (self.shapes.iter())
                .map(|row| row[..retained].to_vec())
                .collect(),
        }
    }
}
