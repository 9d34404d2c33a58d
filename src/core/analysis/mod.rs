//! Analyses of a trajectory, one file per question. An analysis neither reads nor writes files. It starts no
//! threads; only probes and cells of slices are integrated in parallel, by the threads of a pool.

mod analyses;
mod averages;
mod classify;
mod config;
mod contact_jumps;
pub mod continuation;
mod convergence;
mod coupled_modes;
mod covariant;
mod dimension;
mod divergence;
mod energy;
mod evidence;
mod frequencies;
mod horizon;
mod interrupt;
mod lasting_contact;
mod lyapunov;
mod modal_series;
mod multistability;
mod norm;
mod nvh;
pub mod orbits;
mod orders;
mod outcome;
mod outputs;
mod poincare;
mod poincare_sample;
mod point;
mod power;
mod power_outcome;
mod precision;
mod recurrence;
pub mod run_up;
pub mod sensitivity;
mod signal;
mod spectrum;
mod surface;
mod torus;
mod trace;
mod twin;
mod window_cache;

pub use analyses::Analyses;
pub use config::{
    Effort, GrowthNorm, LyapunovConfig, NvhConfig, OrderConfig, PointConfig, Signals,
    SpectrumConfig,
};
pub use contact_jumps::ContactJumps;
pub use covariant::{
    ANGLE_SHARES, AngleOutcome, CovariantConfig, CovariantError, CovariantOutcome, MOST_MEMORY,
    covariant_vectors,
};
pub use dimension::kaplan_yorke;
pub use energy::EnergyAudit;
pub use evidence::{ChaosAverages, ChaosOutcome, EvidenceOutcome, GrowthRecord};
pub use frequencies::{ClosedMode, Frequencies, NaturalMode};
pub use horizon::{HorizonConfig, HorizonMeasure, HorizonOutcome, HorizonQuantity, predictability};
pub use interrupt::{EndedEarly, Interrupted};
pub use lyapunov::{TangentGrowth, displaced};
pub use multistability::{
    AttractorOutcome, BasinShare, CellOutcome, MultistabilityConfig, MultistabilityOutcome, Plane,
    ProbeOutcome, Probes, SliceConfig, SliceError, SliceOf, probe_basins,
};
pub use norm::EnergyNorm;
pub use nvh::Nvh;
pub use orbits::character::{Bifurcation, Character};
pub use orbits::kick::Kick;
pub use orbits::survey::{
    MissedState, OrbitConfig, OrbitOutcome, OrbitSurvey, survey as survey_orbits,
};
pub use outcome::*;
pub use outputs::{OutputStatistics, Outputs, named as named_outputs};
pub use poincare::{PoincareConfig, Section};
pub use poincare_sample::{PoincareSample, SampleKind};
pub use point::{ExpectedCycles, investigate, investigate_onward};
pub use power::Power;
pub use power_outcome::PowerOutcome;
pub use recurrence::excitation_period;
pub use spectrum::{Lines, Welch};
pub use surface::Surface;
pub use trace::{ModalState, TraceConfig, TraceOutcome, TraceSample, TraceSink, trace};
pub use twin::SEPARATION;
