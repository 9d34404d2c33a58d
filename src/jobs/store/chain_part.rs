//! What is a point of a chain, along which the state is carried, to its neighbours?

use crate::analysis::Class;
use serde::{Deserialize, Serialize};

/// A point's part in its chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChainPart {
    /// Whether the sweep runs towards larger values.
    pub upwards: bool,
    /// Where the integration ended, for the next point; none where it diverged or failed.
    pub end: Option<ChainEnd>,
    /// The change of motion since the last point that has a verdict, where there is one and
    /// it was to be refined.
    pub transition: Option<Transition>,
    /// What the next point is held against, where changes are to be refined.
    pub level: Option<Level>,
}

/// Mean and RMS of the deflection: what tells two motions of one class and period apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// Mean deflection and its standard error, 0 where the motion repeats \[m\].
    pub mean: [f64; 2],
    /// RMS about the mean, and its standard error \[m\].
    pub rms: [f64; 2],
}

/// The state that a point leaves to the next of its chain. The journal keeps every bit, so
/// that an interrupted chain goes on as if it had not been.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChainEnd {
    /// First components of all blocks, then second components, at mesh phase 0.
    pub state: Vec<f64>,
    /// Mesh cycles since the start of the chain.
    pub cycle: u64,
}

/// A change of class or period, or a jump at constant class and period, between two points of a
/// chain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Transition {
    /// Motion before it, in sweep order.
    pub from: Class,
    /// Motion behind it.
    pub to: Class,
    /// The swept parameter on either side of it, in sweep order.
    pub bracket: [f64; 2],
    /// Points computed to narrow it.
    pub trials: u32,
    /// Where class and period stay: the deflection before and behind it.
    pub jump: Option<[Level; 2]>,
}

impl Transition {
    /// The word for what changes.
    pub(super) fn what(&self) -> &'static str {
        if self.jump.is_some() {
            "deflection"
        } else if self.from.name() == self.to.name() {
            "period"
        } else {
            "class"
        }
    }
}
