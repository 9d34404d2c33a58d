//! Which tables exist, what are their names, and which record lists each?

use crate::analysis::Analyses;
use strum::{IntoStaticStr, VariantArray};

/// File name of the record of the tables of `atlas follow`.
pub(super) const FOLLOW_RECORD: &str = "follow.json";
/// File name of the record of the tables of `atlas trace`.
pub(super) const TRACE_RECORD: &str = "trace.json";

/// File name of the record of the tables of `atlas runup`.
pub(super) const RUNUP_RECORD: &str = "runup.json";

/// A result table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case", suffix = ".parquet")]
pub enum TableKind {
    /// One row per operating point.
    Points,
    /// One row per sample on a section of phase space.
    Poincare,
    /// One row per line of a spectrum.
    Spectra,
    /// One row per order of a signal.
    Orders,
    /// One row per initial condition.
    Probes,
    /// One row per periodic orbit.
    Orbits,
    /// One row per change of motion between neighbours of a chain.
    Transitions,
    /// One row per attractor of a point.
    Attractors,
    /// One row per cell of a slice of initial states.
    Basins,
    /// One row per quantity over a number of mesh cycles.
    Horizon,
    /// One row per orbit of a branch.
    Branches,
    /// One row per bifurcation of a branch.
    Bifurcations,
    /// One row per point of a bifurcation curve.
    Curves,
    /// One row per instant of a traced trajectory.
    Trace,
    /// One row per change of contact state of a traced trajectory.
    Events,
    /// One row per instant of a run-up.
    Signals,
    /// One row per order of a signal at a speed of a run-up.
    OrderTracks,
    /// One row per signal at a speed of a run-up.
    Levels,
    /// One row per spectrum of a signal at a time of a run-up.
    Spectrogram,
    /// One row per opening or closing of a contact in a run-up.
    ContactChanges,
}

impl TableKind {
    /// The tables of a job, `points.parquet` last: its presence means that the results are complete.
    pub const OF_A_JOB: [Self; 10] = [
        Self::Transitions,
        Self::Orbits,
        Self::Basins,
        Self::Attractors,
        Self::Horizon,
        Self::Probes,
        Self::Spectra,
        Self::Orders,
        Self::Poincare,
        Self::Points,
    ];

    /// One table for each kind of record.
    pub(super) const OF_RECORDS: [Self; 4] =
        [Self::Points, Self::Branches, Self::Trace, Self::Signals];

    /// File name of the record that lists the table; `None` for tables of a run.
    pub(super) fn command_record(self) -> Option<&'static str> {
        match self {
            Self::Branches | Self::Bifurcations | Self::Curves => Some(FOLLOW_RECORD),
            Self::Trace | Self::Events => Some(TRACE_RECORD),
            Self::Signals
            | Self::OrderTracks
            | Self::Levels
            | Self::Spectrogram
            | Self::ContactChanges => Some(RUNUP_RECORD),
            _ => None,
        }
    }

    /// Name of the table: its file name without the suffix.
    pub fn name(self) -> &'static str {
        self.file_name().trim_end_matches(".parquet")
    }

    /// Whether analyses request the table. False for `Points`, for `Transitions` and `Basins`, which depend on other
    /// settings, and for tables of other commands.
    pub fn is_requested(self, analyses: &Analyses) -> bool {
        match self {
            Self::Poincare => analyses.poincare.is_some(),
            Self::Spectra => analyses.nvh.is_some_and(|nvh| nvh.spectrum.is_some()),
            Self::Orders => analyses.nvh.is_some_and(|nvh| nvh.orders.is_some()),
            Self::Probes | Self::Attractors => analyses.multistability.is_some(),
            Self::Orbits => analyses.orbits.is_some(),
            Self::Horizon => analyses.horizon.is_some(),
            _ => false,
        }
    }

    /// Sentence about how to obtain the table.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::Points => "`atlas run` writes it",
            Self::Poincare => "add `poincare = {}` to [analyses] of the manifest",
            Self::Spectra => "add `nvh = { spectrum = {} }` to [analyses] of the manifest",
            Self::Orders => "add `nvh = { orders = {} }` to [analyses] of the manifest",
            Self::Probes | Self::Attractors => {
                "add `multistability = {}` to [analyses] of the manifest"
            }
            Self::Basins => "add `multistability.slice` to [analyses] of the manifest",
            Self::Orbits => "add `orbits = {}` to [analyses] of the manifest",
            Self::Transitions => {
                "carry the state along an axis: `order = \"both\"` in [grid] of the manifest"
            }
            Self::Horizon => "add `lyapunov = {}` and `horizon = {}` to [analyses] of the manifest",
            Self::Branches | Self::Bifurcations | Self::Curves => "`atlas follow` writes it",
            Self::Trace | Self::Events => "`atlas trace` writes it",
            Self::Signals
            | Self::OrderTracks
            | Self::Levels
            | Self::Spectrogram
            | Self::ContactChanges => "`atlas runup` writes it",
        }
    }

    /// The names of all tables.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Self::VARIANTS.iter().map(|kind| kind.name())
    }

    /// The table with a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::VARIANTS
            .iter()
            .copied()
            .find(|kind| kind.name() == name)
    }

    /// Name of the file, or of the folder of shards.
    pub fn file_name(self) -> &'static str {
        self.into()
    }
}
