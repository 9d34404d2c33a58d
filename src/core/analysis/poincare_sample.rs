//! A sample on a section of phase space, as in the result files.

use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

/// The reason why a Poincaré sample was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum SampleKind {
    /// The requested mesh phase.
    Strobe,
    /// Entry into drive contact.
    Entry,
    /// δ' = 0 with δ'' < 0.
    Maximum,
    /// δ' = 0 with δ'' > 0.
    Minimum,
    /// The end of drive contact.
    Release,
    /// Entry into coast contact.
    CoastEntry,
    /// The end of coast contact.
    CoastRelease,
    /// F > 0 and F' = 0 with F'' < 0.
    ForceMaximum,
    /// The requested surface, crossed towards larger values.
    SurfaceUp,
    /// The requested surface, crossed towards smaller values.
    SurfaceDown,
}

impl SampleKind {
    /// The word stored in result files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A sample on a section of phase space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoincareSample {
    /// Mesh cycle, counted from the start of the simulation.
    pub cycle: u64,
    /// Mesh phase in \[0, 1).
    pub phase: f64,
    /// Mesh deflection δ \[m\].
    pub deflection: f64,
    /// Rate δ' of the mesh deflection \[m/s\].
    pub velocity: f64,
    /// Reason for the sample.
    pub kind: SampleKind,
}
