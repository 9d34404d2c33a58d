//! Tangent vectors that advance with a trajectory.

/// `count` tangent vectors of length 2N (first components of all blocks, then second
/// components), one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Tangents {
    dimension: usize,
    data: Vec<f64>,
}

impl Tangents {
    /// No tangents: a kernel then does no work for them.
    pub fn none() -> Self {
        Self {
            dimension: 0,
            data: Vec::new(),
        }
    }

    /// `count` zero vectors for `modes` blocks.
    pub fn zeros(modes: usize, count: usize) -> Self {
        Self {
            dimension: 2 * modes,
            data: vec![0.0; 2 * modes * count],
        }
    }

    /// Number of vectors.
    pub fn count(&self) -> usize {
        self.data.len().checked_div(self.dimension).unwrap_or(0)
    }

    /// Vector `index`.
    pub fn vector(&self, index: usize) -> &[f64] {
        &self.data[index * self.dimension..(index + 1) * self.dimension]
    }

    /// Vector `before`, and a later vector `index`, mutable.
    pub fn pair_mut(&mut self, before: usize, index: usize) -> (&[f64], &mut [f64]) {
        let (first, second) = self.data.split_at_mut(index * self.dimension);
        (
            &first[before * self.dimension..][..self.dimension],
            &mut second[..self.dimension],
        )
    }

    /// Vector `index`, mutable.
    pub fn vector_mut(&mut self, index: usize) -> &mut [f64] {
        &mut self.data[index * self.dimension..(index + 1) * self.dimension]
    }
}

/// Copies the state and the tangents of a trajectory into one column each, with `length` entries per column.
/// Each half of a vector fills the start of a half of its column. The padding behind it does not change.
pub(super) fn write_padded(columns: &mut [f64], length: usize, state: &[f64], tangents: &Tangents) {
    let vectors = (0..tangents.count()).map(|i| tangents.vector(i));
    for (to, from) in (columns.chunks_exact_mut(length)).zip([state].into_iter().chain(vectors)) {
        let n = from.len() / 2;
        to[..n].copy_from_slice(&from[..n]);
        to[length / 2..][..n].copy_from_slice(&from[n..]);
    }
}

/// Copies a trajectory's state and its tangents from columns that [`write_padded`] wrote.
pub(super) fn read_padded(
    columns: &[f64],
    length: usize,
    state: &mut [f64],
    tangents: &mut Tangents,
) {
    let mut columns = columns.chunks_exact(length);
    let read = |to: &mut [f64], from: &[f64]| {
        let n = to.len() / 2;
        to[..n].copy_from_slice(&from[..n]);
        to[n..].copy_from_slice(&from[length / 2..][..n]);
    };
    if let Some(first) = columns.next() {
        read(state, first);
    }
    for (i, column) in columns.take(tangents.count()).enumerate() {
        read(tangents.vector_mut(i), column);
    }
}
