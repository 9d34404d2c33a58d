//! The dimensions of a grid: tied axes advance in step along one dimension.

use super::spec::Axis;
use serde::Serialize;

/// A dimension of a grid.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct GridDimension {
    /// The axes along it, as indices into [`Job::axes`](super::Job::axes), ascending.
    pub axes: Vec<usize>,
    /// Number of values of each axis along it.
    pub length: usize,
    /// Whether it varies a key of the model.
    pub model_keys: bool,
    /// Whether its axes are distributions. The positions along it are then rows of a design of samples.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub sampled: bool,
}

impl GridDimension {
    /// The dimensions of some axes, slowest first: those that vary model keys, then the others. `ties` has the indices
    /// of axes that advance in step, all equally long; every other axis has a separate dimension.
    pub(super) fn all(axes: &[&Axis], ties: &[Vec<usize>]) -> Vec<Self> {
        let tied = |axis: usize| ties.iter().find(|tie| tie.contains(&axis));
        let mut all: Vec<Self> = (0..axes.len())
            .filter_map(|axis| {
                let mut along = tied(axis).map_or_else(|| vec![axis], Vec::clone);
                along.sort_unstable();
                (along[0] == axis).then(|| Self {
                    length: axes[axis].values.len(),
                    model_keys: along.iter().any(|&axis| axes[axis].key.is_model_key()),
                    sampled: false,
                    axes: along,
                })
            })
            .collect();
        all.sort_by_key(|dimension| (!dimension.model_keys, dimension.axes[0]));
        all
    }

    /// Whether its values may repeat: it has several axes, or samples.
    pub fn is_tied(&self) -> bool {
        self.axes.len() > 1 || self.sampled
    }

    /// The index of the dimension of an axis.
    pub(crate) fn of(all: &[Self], axis: usize) -> usize {
        (all.iter()
            .position(|dimension| dimension.axes.contains(&axis)))
        .unwrap_or_else(|| unreachable!("every axis goes along a dimension"))
    }

    /// Number of points of a grid over these dimensions.
    pub(super) fn product(all: &[Self]) -> usize {
        all.iter().map(|dimension| dimension.length).product()
    }

    /// The position of a point along each dimension, in row-major order with the last dimension fastest.
    pub(super) fn places(lengths: &[usize], number: usize) -> Vec<usize> {
        let mut rest = number;
        let mut places = vec![0; lengths.len()];
        for (place, length) in places.iter_mut().zip(lengths).rev() {
            *place = rest % length;
            rest /= length;
        }
        places
    }
}
