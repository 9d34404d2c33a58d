//! What does a point of a chain pass to the next point?

use crate::analysis::Class;
use serde::{Deserialize, Serialize};

/// The data of a point that belong to its chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChainPart {
    /// Whether the sweep runs towards larger values.
    pub upwards: bool,
    /// State at the end of the integration, for the next point; `None` if it diverged or failed.
    pub end: Option<ChainEnd>,
    /// The change of motion since the last point whose class of motion is known. `None` without a change, or if
    /// changes are not refined.
    pub transition: Option<Transition>,
    /// Deflection that the next point is compared with; `None` if changes are not refined.
    pub level: Option<Level>,
}

/// Mean and RMS of the deflection, which distinguish two motions of one class and period.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// Mean deflection and its standard error \[m\]. The error is 0 if the motion repeats.
    pub mean: [f64; 2],
    /// RMS about the mean, and its standard error \[m\].
    pub rms: [f64; 2],
}

/// The state that a point passes to the next of its chain. The journal keeps every bit, so that an interruption does
/// not change a chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChainEnd {
    /// Modal displacements, then velocities, at mesh phase 0, with rigid modes rotated as in the basis of the model.
    /// The states of the blocks would depend on the point if modes are coupled.
    pub state: Vec<f64>,
    /// Mesh cycles since the start of the chain, or since the last point that started from `run.initial`.
    pub cycle: u64,
}

/// A change of class or period, or a jump at constant class and period, between two points of a
/// chain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Transition {
    /// Motion before the change, in sweep order.
    pub from: Class,
    /// Motion after the change.
    pub to: Class,
    /// The swept parameter on either side of the change, in sweep order.
    pub bracket: [f64; 2],
    /// Number of points computed to narrow the bracket.
    pub trials: u32,
    /// The deflection before and after the change if class and period stay the same.
    pub jump: Option<[Level; 2]>,
}

impl Transition {
    /// The kind of change: `deflection`, `period` or `class`.
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
