//! How a plane of points is refined: what its corners are compared by.

use crate::numerics::nested_grid::NestedGrid;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

/// A plane whose cells are divided where their corners differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refine {
    /// Its places. Rows go along the first axis that has several values, columns along the second;
    /// `point_id` is the number of a place.
    pub nested: NestedGrid,
    /// What is compared, each once, in the order of [`Criterion`].
    pub by: Vec<Criterion>,
    /// How far columns may differ, as a part of what they span over level 0.
    pub tolerance: f64,
    /// Longest period \[mesh cycles\] that is told from others.
    pub longest_period: u32,
}

impl Refine {
    /// `class, period`.
    pub fn by_words(&self) -> String {
        let names: Vec<&str> = self.by.iter().map(|criterion| criterion.name()).collect();
        names.join(", ")
    }
}

/// What of two points is compared: a column of `points.parquet`, by its name.
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
    /// Its name in manifests and result files.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Whether it is a number, which differs by more or less.
    pub fn is_number(self) -> bool {
        !matches!(self, Self::Class | Self::Period)
    }

    /// The analysis that it comes from, where it takes one.
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
