//! What a kernel shows of a trajectory while it advances.

use crate::model::{Contact, Segment, Surface};

/// A stretch of trajectory between breakpoints, as polynomials.
///
/// `deflection` and `force` are Legendre coefficients on the window: with
/// `x = 2 t / duration − 1`, `δ(t) = Σ deflection[n] P_n(x)`.
#[derive(Debug, Clone, Copy)]
pub struct Window<'a> {
    /// Mesh cycle.
    pub cycle: u64,
    /// Start within the mesh cycle \[s\].
    pub start: f64,
    /// Length \[s\], > 0.
    pub duration: f64,
    /// Mesh segment (stiffness and damping) in force.
    pub segment: &'a Segment,
    /// Contact state throughout.
    pub contact: Contact,
    /// Legendre coefficients of δ \[m\].
    pub deflection: &'a [f64],
    /// Legendre coefficients of F \[N\]; all zero in free flight.
    pub force: &'a [f64],
    /// First components of the blocks at the window's start, length N.
    pub first: &'a [f64],
    /// Second components of the blocks at the window's start, length N.
    pub second: &'a [f64],
}

/// A change of contact state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within the mesh cycle \[s\].
    pub time: f64,
    /// State before.
    pub from: Contact,
    /// State after.
    pub to: Contact,
    /// Surface crossed.
    pub surface: Surface,
    /// Rate of the deflection against the surface at the crossing, δ' − s b' \[m/s\].
    pub rate: f64,
}

/// Watches a trajectory.
pub trait Observer {
    /// Whether windows are to be shown; where false their series are not even formed.
    const WINDOWS: bool;

    /// A window was passed.
    fn window(&mut self, window: &Window<'_>);

    /// The contact state changed.
    fn event(&mut self, event: &Event);

    /// Whether the integration is to end here; asked before every window.
    fn called_off(&self) -> bool {
        false
    }
}

/// Nobody watches.
impl Observer for () {
    const WINDOWS: bool = false;

    fn window(&mut self, _: &Window<'_>) {}

    fn event(&mut self, _: &Event) {}
}

/// Both watch.
impl<A: Observer, B: Observer> Observer for (A, B) {
    const WINDOWS: bool = A::WINDOWS || B::WINDOWS;

    fn window(&mut self, window: &Window<'_>) {
        self.0.window(window);
        self.1.window(window);
    }

    fn event(&mut self, event: &Event) {
        self.0.event(event);
        self.1.event(event);
    }

    fn called_off(&self) -> bool {
        self.0.called_off() || self.1.called_off()
    }
}

impl<O: Observer> Observer for &mut O {
    const WINDOWS: bool = O::WINDOWS;

    fn window(&mut self, window: &Window<'_>) {
        (**self).window(window);
    }

    fn event(&mut self, event: &Event) {
        (**self).event(event);
    }

    fn called_off(&self) -> bool {
        (**self).called_off()
    }
}
