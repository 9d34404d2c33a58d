//! The refinement of a plane of points, and the criteria by which points are compared.

use crate::numerics::nested_grid::NestedGrid;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

/// A plane whose cells are halved if points on their edges differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refine {
    /// Numbering of its places by `point_id`. The first axis with several values varies between rows, the second
    /// between columns.
    pub nested: NestedGrid,
    /// Criteria of comparison, without repetition, in the order of [`Criterion`].
    pub by: Vec<Criterion>,
    /// Largest ignored difference of columns, as a fraction of their range over level 0.
    pub tolerance: f64,
    /// Largest period that is distinguished from others \[mesh cycles\].
    pub longest_period: u32,
}

impl Refine {
    /// The names of the criteria, such as `class, period`.
    pub fn by_words(&self) -> String {
        let names: Vec<&str> = self.by.iter().map(|criterion| criterion.name()).collect();
        names.join(", ")
    }
}

/// A criterion for comparing two points: a column of `points.parquet`, by name.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, IntoStaticStr, VariantArray,
)]
#[strum(serialize_all = "snake_case")]
#[allow(missing_docs, reason = "described as columns of points.parquet")]
pub enum Criterion {
    Class,
    Period,
    LambdaMax,
    EventsPerCycle,
    DeflectionMean,
    DeflectionRms,
    ForceStd,
    ImpactRate,
    ImpactVelocity,
}

impl Criterion {
    /// Name in manifests and result files.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Whether it is a number, so that differences have a size.
    pub fn is_number(self) -> bool {
        !matches!(self, Self::Class | Self::Period)
    }

    /// The analysis that computes it, if it needs one.
    pub(in crate::manifest) fn analysis(self) -> Option<&'static str> {
        match self {
            Self::Class | Self::Period | Self::EventsPerCycle => None,
            Self::LambdaMax => Some("lyapunov"),
            Self::DeflectionMean
            | Self::DeflectionRms
            | Self::ForceStd
            | Self::ImpactRate
            | Self::ImpactVelocity => Some("nvh"),
        }
    }
}
