//! The structured kernel: a scalar Volterra equation for the mesh force, no dense operators.
//!
//! On a window `[0, Δ]` with constant (k, c) write `H(t) = Σ w e^{At} g` for the response of
//! the deflection to a unit impulse of mesh force. Then
//!
//! ```text
//! δ(t) = δ_free(t) − ∫₀ᵗ H(t−τ) F(τ) dτ,      F = k (δ − s b) + c δ'
//! ```
//!
//! is a scalar Volterra equation of the second kind. All functions on a window are Legendre series with P = 24 terms
//! (Galerkin projection), so that the same numbers serve the solution and the event certificates. With 𝒟 the
//! derivative of a series and e₀ the series of the constant 1,
//!
//! ```text
//! d = R x                         free deflection; x holds the blocks and the inputs
//! f = S̃ d − s b k S e₀,           S = (I + k B + c B')⁻¹,  S̃ = S (k I + c 𝒟)
//! δ = Q̃ d + s b k B S e₀,         Q̃ = I − B S̃
//! x⁺ = D x + E f + …              + terms of torques and ripple
//! ```
//!
//! R, E, B follow in closed form from the Legendre series of the block exponentials
//! ([`crate::numerics::exponential`]) and a universal convolution table ([`crate::numerics::convolution`]). They
//! depend only on (Ω, Δ) and on the direction of the contact, so loads and contact states share them. S̃ and Q̃ are
//! stored once per distinct (k, c). In free flight F = 0, and the mesh is not evaluated. Mean torques, ripple and
//! transmission error are further rows of R, weighted by 1 and the (cos, sin) of their phases.
//!
//! A mesh segment is divided into equal windows. Segments of different lengths may have windows of different lengths
//! Δ, each with separate tables, so that a segment may end anywhere ([`grid`]). A window may start anywhere. It is
//! cut at an event or at a breakpoint: weights that depend on the cut and the force, but not on the blocks, recombine
//! the exponential series of the full window ([`partial`]).
//!
//! Why 24 terms and not 16: the work is proportional to the number of terms, but the length that P terms resolve to
//! round-off grows from κ = 1.26 to 4.0 (κ: fastest rate times half a window). A cycle then takes a third of the
//! windows.
//!
//! A trajectory and its tangents are columns of the same products. A window is solved and advanced for all of them at
//! once, four columns per pass over the tables if the registers can hold their sums. The bits of the trajectory do
//! not depend on the number of tangents.
//!
//! Layout. The series index is the SIMD lane in R, S̃ and Q̃ (24 doubles: three vectors of AVX-512, six of AVX2),
//! with one row per entry of the state. The block index is the lane in D, E and the exponentials (chunks of 8), chunk
//! after chunk in the order in which a window reads them. The exponential series of a slow block falls below
//! round-off long before term 24, so a chunk has the terms that its fastest block needs. Rows and lane groups start
//! on cache lines. At N = 40 these are 16 KB for R, 13 KB for D and E, 9 KB per distinct stiffness, and 11 KB that
//! only cuts read. Directions of one line share R, windows of one length the exponentials. The instruction set is
//! chosen once per solution of a window and once per advance; each is one call ([`lanes`]).

mod block_exponential;
mod contact_tables;
mod cycle;
mod feedback;
mod grid;
mod impact;
mod joint;
mod joint_stretch;
pub(super) mod lanes;
mod length;
mod partial;
mod position;
mod range;
mod release;
mod search;
mod shapes;
mod slide;
mod stick;
mod table_requests;
mod tables;
mod varying;
mod window_stiffness;
mod window_table;
mod workspace;

use super::vectors::InstructionSet;
use crate::model::{ActiveSet, Model, Release};
use std::borrow::Cow;
use std::f64::consts::TAU;
use tables::VolterraTables;
use window_table::WindowTable;

/// Rounding of a time within the cycle, in mesh periods.
const ON_BREAKPOINT: f64 = 4e-15;

/// The structured kernel for one model.
#[derive(Debug)]
pub struct Volterra<'m> {
    model: Cow<'m, Model>,
    tables: VolterraTables,
    event_limit: u32,
    instructions: InstructionSet,
    /// Contacts that open when their force vanishes.
    never_pull: ActiveSet,
    /// Contacts with a separate search: parts of dry sliders, of rigid stops and of dry friction.
    of_parts: ActiveSet,
    /// The fastest rate of the open structure, its excitation and the mesh cycle \[1/s\].
    fastest: f64,
    /// Times closer than this to a following breakpoint are on it \[s\].
    on_breakpoint: f64,
    /// Deflections of every line beyond which a motion has diverged, in the units of its contacts.
    farthest: Vec<f64>,
}

impl<'m> Volterra<'m> {
    /// Builds the kernel's tables for a model.
    ///
    /// * `tolerance`: relative size of the first omitted Legendre coefficient of a window, for the fastest motion of
    ///   the model; 2⁻⁵² for round-off. It sets the window length up to the limit of the exponential series, which is
    ///   reached at some 5·10⁻¹⁴.
    /// * `event_limit`: largest number of events in a mesh cycle before integration stops.
    pub fn new(model: &'m Model, tolerance: f64, event_limit: u32) -> Self {
        Self::with_instructions(model, tolerance, event_limit, InstructionSet::best())
    }

    /// As [`Self::new`], with a model that the kernel owns.
    pub fn of(model: Model, tolerance: f64, event_limit: u32) -> Volterra<'static> {
        let set = InstructionSet::best();
        Volterra::build(Cow::Owned(model), tolerance, event_limit, set)
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// As [`Self::new`], with a given instruction set.
    pub fn with_instructions(
        model: &'m Model,
        tolerance: f64,
        event_limit: u32,
        instructions: InstructionSet,
    ) -> Self {
        Self::build(Cow::Borrowed(model), tolerance, event_limit, instructions)
    }

    fn build(
        model: Cow<'m, Model>,
        tolerance: f64,
        event_limit: u32,
        instructions: InstructionSet,
    ) -> Self {
        let released_by = |law: fn(Release) -> bool| {
            (0..model.contacts.len())
                .filter(|&contact| law(model.contacts[contact].release))
                .fold(ActiveSet::FREE, ActiveSet::toggled)
        };
        let never_pull = released_by(Release::is_by_force);
        Self {
            farthest: super::farthest(&model),
            tables: VolterraTables::new(&model, tolerance),
            event_limit,
            instructions,
            never_pull,
            of_parts: [Release::of_slider, Release::of_stop, Release::of_friction]
                .map(released_by)
                .into_iter()
                .fold(ActiveSet::FREE, ActiveSet::union),
            fastest: length::fastest_of_open(&model).max(TAU / model.period()),
            on_breakpoint: if never_pull.touching() {
                // A contact that never pulls may take load again at a step of the stiffness, inside a window
                // of free flight.
                ON_BREAKPOINT * model.period()
            } else {
                0.0
            },
            model,
        }
    }

    /// Upper bound of the rates \[rad/s\] of a model with any one contact closed, including the excitation. It sets
    /// the window length.
    pub fn fastest_rate(model: &Model) -> f64 {
        length::fastest_rate(model)
    }

    /// Upper bound of the rates \[rad/s\] of the structure with any one contact closed, without the
    /// excitation.
    pub fn fastest_structure_rate(model: &Model) -> f64 {
        length::fastest_structure_rate(model)
    }

    /// Windows per mesh cycle that the kernel would need for the first contact of a model. A stiff mesh, a strong
    /// damper or a slow speed can make this number impractical.
    pub fn windows_needed(model: &Model, tolerance: f64) -> f64 {
        grid::cells_needed(model, tolerance)
    }

    /// Count of the table numbers that a full window in contact reads, for the first window length. Each of
    /// them costs one multiply-add of the trajectory.
    pub fn numbers_per_window(&self) -> usize {
        self.tables.windows[0].numbers_read()
    }

    /// Bytes of the tables, including those that only cut windows read.
    pub fn bytes(&self) -> usize {
        let numbers = self.tables.windows.iter().map(WindowTable::numbers);
        numbers.sum::<usize>() * size_of::<f64>()
    }

    /// Windows in the first mesh cycle of the first contact, without events.
    pub fn windows_per_cycle(&self) -> usize {
        self.tables.first_schedule().grid.cells()
    }
}
