//! Does the energy balance close?
//!
//! Over any time, with u the modal velocities and T the modal loads,
//!
//! ```text
//! Δ(½Σ(v² + ω²q²) + Σ ½k(δ − s b)²) = ∫ T·u dt                 torques
//!     − ∫ F e' dt − ∫ F s b' dt                               transmission error, half gap
//!     − ∫ Σ 2ζω u² dt − ∫ c (δ' − s b')² dt                   damping, structure and contacts
//!     − ∫ F (g − w)·u dt                                      friction
//!     + ∫ ½ k' (δ − s b)² dt                                  stiffness that varies
//!     + Σ Δ(½ k (δ − s b)²)                                   steps of stiffness, line, gap;
//!                                                             contacts that open compressed
//!     + Σ Δ(½Σ v²)                                            impacts on rigid stops
//! ```
//!
//! Terms with a force or a spring of a contact are summed over the closed contacts.
//! Every integrand is a product of Legendre series. The modal velocities are rebuilt
//! ([`super::modal_series`]) from the state at each window's start and the force series,
//! independently of the kernel's propagation. The residual is relative to the sum of all absolute
//! works and the largest energy stored, because a drive at rest under its load does no work, and its
//! imbalance is the round-off of the stored energy.

mod balance;
mod cause;
mod impacts;

use super::modal_series::ModalMotion;
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Event, Observer, Window};
pub(super) use balance::{Balance, WindowEndContacts};
pub(super) use cause::Cause;

/// Residual above which a kernel without truncation error has failed. In a thousand random drives, every
/// valid result is below 1e-11.
pub const LARGEST_RESIDUAL: f64 = 1e-9;

/// The message if the energy balance does not close; `None` if it does.
pub fn imbalance_message(residual: f64) -> Option<String> {
    // This form of the comparison also rejects NaN.
    let closes = residual <= LARGEST_RESIDUAL;
    (!closes).then(|| {
        format!(
            "the energy balance is off by {residual:.1e} of the converted energy (round-off is at most \
             {LARGEST_RESIDUAL:.0e}): the kernel does not integrate this drive accurately; try another \
             run.kernel"
        )
    })
}

/// Audits the energy balance of a trajectory.
#[derive(Debug, Clone)]
pub struct EnergyAudit<'m> {
    balance: Balance<'m>,
    start: Option<f64>,
    /// Sum of all works \[J\].
    gained: f64,
    /// Sum of the absolute values of all works \[J\].
    turnover: f64,
    /// Largest energy stored, as the sum of the absolute values of its parts \[J\].
    stored: f64,
}

impl<'m> EnergyAudit<'m> {
    /// An audit that starts with the first observed window.
    pub fn new(model: &'m Model) -> Self {
        Self {
            balance: Balance::new(ModalMotion::new(model)),
            start: None,
            gained: 0.0,
            turnover: 0.0,
            stored: 0.0,
        }
    }

    /// Relative residual of the balance up to `end`, the end of the last observed window; `None` if no window
    /// was observed or nothing moved.
    pub fn residual(&self, end: &TrajectoryState) -> Option<f64> {
        let (first, second) = end.state.split_at(end.state.len() / 2);
        let gained = self.gained + self.balance.gained_by_impacts(first, second);
        let imbalance = self.balance.stored_at(end)? - self.start? - gained;
        let at_work = self.turnover + self.stored;
        (at_work > 0.0).then(|| imbalance.abs() / at_work)
    }
}

impl Observer for EnergyAudit<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        self.stored = self.stored.max(self.balance.magnitude(window));
        if self.start.is_none() {
            self.start = Some(self.balance.stored_before(window));
        }
        let (gained, turnover) = (&mut self.gained, &mut self.turnover);
        self.balance.window(window, &mut |_, work| {
            *gained += work;
            *turnover += work.abs();
        });
    }

    fn event(&mut self, event: &Event) {
        self.balance.event(event);
    }
}

#[cfg(test)]
mod tests;
