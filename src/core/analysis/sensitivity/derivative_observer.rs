//! Observers of the derivatives of windows with respect to a parameter.

use crate::analysis::modal_series::Series;
use crate::propagate::Window;

/// The derivative of a window with respect to the parameter.
#[derive(Debug, Clone, Copy)]
pub struct WindowDerivative<'a> {
    /// The window.
    pub window: &'a Window<'a>,
    /// δ_p of the mesh deflection.
    pub deflection: &'a Series,
    /// F_p of the mesh force, the sum over its closed flanks.
    pub force: &'a Series,
}

/// Observes the derivative of every window.
pub trait DerivativeObserver {
    /// Takes a window.
    fn window(&mut self, derivative: &WindowDerivative<'_>);

    /// Takes a jump of the mesh force by `force_jump` \[N\] at a time \[s\] of a cycle. This time changes by
    /// `moved` \[s\] per unit of the parameter.
    fn jump(&mut self, cycle: u64, time: f64, moved: f64, force_jump: f64);
}

/// No observer.
impl DerivativeObserver for () {
    fn window(&mut self, _: &WindowDerivative<'_>) {}
    fn jump(&mut self, _: u64, _: f64, _: f64, _: f64) {}
}
