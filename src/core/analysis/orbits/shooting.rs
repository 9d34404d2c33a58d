//! The periodic orbit near a state, by Newton's method on the map of k mesh cycles.
//!
//! ```text
//! (M − I) Δ = x − P(x),      M = dP/dx, exact (windows and saltations)
//! ```
//!
//! in energy coordinates, without the neutral pair. The map of a drive with contact damping is continuous, but its
//! derivative jumps where the event sequence changes. Steps converge quadratically once the sequence is that of the
//! orbit. An orbit that never leaves contact, or never touches, is found in one step because its map is affine.

use super::floquet::monodromy;
use crate::analysis::norm::EnergyNorm;
use crate::model::{ActiveSet, Model, TrajectoryState};
use crate::numerics::linalg::{eigenvalues, solve};
use crate::numerics::product_moduli::round_off;
use crate::propagate::{Counters, Kernel, Stop};
use faer::Mat;
use num_complex::Complex64;

/// Largest number of Newton steps; a good guess needs three to five.
const MOST_STEPS: usize = 8;

/// Residual, in half gaps, at which an orbit counts as found. The round-off of a cycle is some 1e-14, and one more
/// step follows.
const CONVERGED: f64 = 1e-11;

/// Residual, in half gaps, at which an orbit counts as found if the next step does not halve the residual. The
/// round-off of nearly critically damped modes in tables can prevent smaller residuals.
const STAGNANT: f64 = 1e-9;

/// Longest step, in half gaps, before the search counts as divergent.
const LONGEST_STEP: f64 = 30.0;

/// Decay per mesh cycle that the round-off of a kernel can cause. It is some 1e-14.
const SPURIOUS_DECAY: f64 = 1e-12;

/// A periodic orbit.
#[derive(Debug, Clone)]
pub struct PeriodicOrbit {
    /// State at the start of a mesh cycle.
    pub start: TrajectoryState,
    /// Period in mesh cycles.
    pub period: u32,
    /// Distance between start and end of a period, in half gaps.
    pub residual: f64,
    /// Events in a period.
    pub events: u64,
    /// Monodromy matrix in energy coordinates.
    pub monodromy: Mat<f64>,
    /// Floquet multipliers, largest modulus first.
    pub multipliers: Vec<Complex64>,
}

impl PeriodicOrbit {
    /// Largest modulus of the multipliers.
    pub fn spectral_radius(&self) -> f64 {
        self.multipliers
            .first()
            .map_or(0.0, |leading| leading.norm())
    }

    /// Whether all neighbours approach the orbit. The multipliers of undamped modes have the modulus 1 within round-off.
    pub fn attracts(&self) -> bool {
        let decay = -self.spectral_radius().ln();
        decay > SPURIOUS_DECAY * f64::from(self.period) + round_off(&self.monodromy, 1.0)
    }
}

/// Seeks an orbit of `period` mesh cycles near `guess`. `None` if Newton's method does not converge within a few
/// steps.
///
/// # Errors
/// [`Stop`] if an iterate diverges or has too many events.
pub fn shoot<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    guess: &TrajectoryState,
    period: u32,
    workspace: &mut K::Workspace,
) -> Result<Option<PeriodicOrbit>, Stop> {
    Shooting::new(model, kernel, norm, period).orbit(guess, workspace)
}

/// As [`shoot`], for an orbit without events, which solves a linear system. `None` if there is an event in the period
/// from `guess` or in the one from the solution.
///
/// # Errors
/// As [`shoot`].
pub fn shoot_without_event<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    guess: &TrajectoryState,
    period: u32,
    workspace: &mut K::Workspace,
) -> Result<Option<PeriodicOrbit>, Stop> {
    let mut shooting = Shooting::new(model, kernel, norm, period);
    shooting.without_event = true;
    shooting.orbit(guess, workspace)
}

/// Newton's method on the map of a period.
struct Shooting<'a, K: Kernel> {
    model: &'a Model,
    kernel: &'a K,
    norm: &'a EnergyNorm,
    period: u32,
    counters: Counters,
    /// Whether an iterate with an event ends the search.
    without_event: bool,
    /// Closed contacts and derivative of a period without an event. All such periods with the same contacts closed
    /// have the same derivative.
    lasting: Option<(ActiveSet, Mat<f64>)>,
}

/// An integrated period.
struct IntegratedPeriod {
    end: TrajectoryState,
    matrix: Mat<f64>,
    events: u64,
}

impl<'a, K: Kernel> Shooting<'a, K> {
    fn new(model: &'a Model, kernel: &'a K, norm: &'a EnergyNorm, period: u32) -> Self {
        Self {
            model,
            kernel,
            norm,
            period,
            counters: Counters::default(),
            without_event: false,
            lasting: None,
        }
    }

    /// Integrates a period, with tangents only if its derivative is unknown.
    fn pass(
        &mut self,
        start: &TrajectoryState,
        workspace: &mut K::Workspace,
    ) -> Result<IntegratedPeriod, Stop> {
        let counters = &mut self.counters;
        let before = counters.events;
        if let Some((contact, matrix)) = &self.lasting
            && *contact == start.contact
        {
            let (mut end, period) = (start.clone(), u64::from(self.period));
            self.kernel
                .advance(period, &mut end, workspace, &mut (), counters)?;
            if counters.events == before || self.without_event {
                return Ok(IntegratedPeriod {
                    end,
                    matrix: matrix.clone(),
                    events: counters.events - before,
                });
            }
        }
        let (mut end, before) = (start.clone(), counters.events);
        let matrix = monodromy(
            self.model,
            self.kernel,
            self.norm,
            &mut end,
            self.period,
            workspace,
            counters,
        )?;
        let events = counters.events - before;
        if events == 0 {
            self.lasting = Some((start.contact, matrix.clone()));
        }
        Ok(IntegratedPeriod {
            end,
            matrix,
            events,
        })
    }

    fn orbit(
        &mut self,
        guess: &TrajectoryState,
        workspace: &mut K::Workspace,
    ) -> Result<Option<PeriodicOrbit>, Stop> {
        let norm = self.norm;
        let mut start = guess.clone();
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let IntegratedPeriod {
                end,
                matrix,
                events,
            } = self.pass(&start, workspace)?;
            if self.without_event && events > 0 {
                return Ok(None);
            }
            let residual = norm.distance(&end.state, &start.state) / norm.unit();
            if residual.is_nan() || residual > 2.0 * last.max(1.0) {
                return Ok(None);
            }
            let stagnant = last <= STAGNANT && residual > 0.5 * last;
            if last <= CONVERGED || stagnant {
                // The last step towards a nearly neutral orbit may be magnified round-off.
                if residual > 2.0 * STAGNANT {
                    return Ok(None);
                }
                return Ok(
                    eigenvalues(matrix.as_ref()).map(|multipliers| PeriodicOrbit {
                        start,
                        period: self.period,
                        residual,
                        events,
                        monodromy: matrix,
                        multipliers,
                    }),
                );
            }
            last = residual;
            let defect = norm.difference(&start.state, &end.state);
            let n = defect.len();
            let system = Mat::from_fn(n, n, |i, j| matrix[(i, j)] - f64::from(u8::from(i == j)));
            let step = solve(system.as_ref(), &defect);
            let length = step.iter().map(|s| s * s).sum::<f64>().sqrt();
            if length.is_nan() || length > LONGEST_STEP * norm.unit() {
                return Ok(None);
            }
            norm.displace(&mut start.state, 1.0, &step);
            start = TrajectoryState::new(self.model, start.state, start.cycle);
        }
        Ok(None)
    }
}

/// Distance, in half gaps, below which two points of an orbit are the same.
pub(super) const SAME_POINT: f64 = 1e-7;

/// The orbit with its shortest period: a multiple of `unit` cycles that divides the given period. The map of an orbit
/// without events is affine and has no other orbit.
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn shortest<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    orbit: PeriodicOrbit,
    unit: u32,
    workspace: &mut K::Workspace,
) -> Result<PeriodicOrbit, Stop> {
    if orbit.period == unit {
        return Ok(orbit);
    }
    if orbit.events == 0 {
        let shorter = shoot(model, kernel, norm, &orbit.start, unit, workspace)?;
        return Ok(shorter.unwrap_or(orbit));
    }
    let mut counters = Counters::default();
    let mut state = orbit.start.clone();
    for cycle in 1..orbit.period {
        kernel.advance(1, &mut state, workspace, &mut (), &mut counters)?;
        let divides = cycle.is_multiple_of(unit) && orbit.period.is_multiple_of(cycle);
        let distance = norm.distance(&state.state, &orbit.start.state) / norm.unit();
        if divides && distance <= SAME_POINT {
            let shorter = shoot(model, kernel, norm, &orbit.start, cycle, workspace)?;
            return Ok(shorter.unwrap_or(orbit));
        }
    }
    Ok(orbit)
}
