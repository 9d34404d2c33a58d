//! What does an observer see of a trajectory while a kernel advances it?

use crate::model::{ActiveSet, Segment};

/// A part of a trajectory between breakpoints, as polynomials.
///
/// Series are Legendre coefficients on the window: with `x = 2 t / duration − 1`,
/// `δ(t) = Σ deflection[n] P_n(x)`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Window<'a> {
    /// Mesh cycle.
    pub cycle: u64,
    /// Start within the mesh cycle \[s\].
    pub start: f64,
    /// Length \[s\], > 0.
    pub duration: f64,
    /// The segment of every contact.
    pub segments: &'a [Segment],
    /// The closed contacts, which are the same throughout.
    pub contact: ActiveSet,
    /// Deflection δ of the mesh \[m\]: along the line of the first contact.
    pub deflection: &'a [f64],
    /// Force F of the mesh \[N\], the sum over its closed flanks: a push of the drive flank is positive, a push of
    /// the coast flank negative. All terms are zero in free flight.
    pub force: &'a [f64],
    /// Every closed contact, in order.
    pub closed: &'a [ClosedContact<'a>],
    /// Deflection along the line of every contact \[m\], open ones too. Empty unless the observer asks for it
    /// ([`Observer::LINES`]) and the kernel has solved the whole window along all lines.
    pub along: &'a [&'a [f64]],
    /// First components of the blocks at the window's start, length N. A kernel may leave them empty if the
    /// observer does not read states.
    pub first: &'a [f64],
    /// Second components, which may be empty too.
    pub second: &'a [f64],
}

/// A closed contact over a window.
#[derive(Debug, Clone, Copy)]
pub struct ClosedContact<'a> {
    /// Its index among the model's contacts.
    pub contact: usize,
    /// Deflection along its line \[m\].
    pub deflection: &'a [f64],
    /// Force along its direction \[N\].
    pub force: &'a [f64],
}

impl<'a> ClosedContact<'a> {
    /// One entry per contact; `series` has its deflection and its force.
    pub(super) fn each<const P: usize, const M: usize>(
        contacts: &[usize; M],
        series: &'a [[[f64; P]; 2]; M],
    ) -> [Self; M] {
        std::array::from_fn(|i| Self {
            contact: contacts[i],
            deflection: &series[i][0],
            force: &series[i][1],
        })
    }
}

impl Window<'_> {
    /// Passes a window with series of P terms to an observer, with the force of its mesh: the sum over the closed
    /// contacts whose index is below `springs`.
    pub(super) fn show<const P: usize, O: Observer>(&self, springs: usize, observer: &mut O) {
        let mut sum = [0.0; P];
        let of_mesh = self
            .closed
            .iter()
            .filter(|contact| contact.contact < springs);
        let force = match (of_mesh.clone().next(), of_mesh.clone().nth(1)) {
            (Some(only), None) => only.force,
            _ => {
                for contact in of_mesh {
                    for (sum, f) in sum.iter_mut().zip(contact.force) {
                        *sum += f;
                    }
                }
                &sum
            }
        };
        observer.window(&Window { force, ..*self });
    }
}

/// A contact opens or closes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within the mesh cycle \[s\].
    pub time: f64,
    /// The closed contacts before the event.
    pub from: ActiveSet,
    /// The closed contacts after the event.
    pub to: ActiveSet,
    /// The contact that opens or closes.
    pub contact: usize,
    /// Rate of its deflection relative to its surface, δ' − s b' \[m/s\].
    pub rate: f64,
}

impl Event {
    /// The contacts that open or close: more than one if a film layer is replaced by the next.
    pub fn changed(&self) -> impl Iterator<Item = usize> {
        let opened = self.from.without(self.to);
        opened.union(self.to.without(self.from)).iter()
    }

    /// Whether the contact closes.
    pub fn closes(&self) -> bool {
        self.to.holds(self.contact)
    }
}

/// Observes a trajectory.
pub trait Observer {
    /// Whether the observer needs windows; if not, their series are not computed.
    const WINDOWS: bool;

    /// Whether the observer reads the deflections of open contacts.
    const LINES: bool = false;

    /// Whether the observer reads the blocks' states at the start of the next window. A kernel may ignore this.
    fn states(&self) -> bool {
        true
    }

    /// Called after a window.
    fn window(&mut self, _window: &Window<'_>) {}

    /// Called at an event.
    fn event(&mut self, _event: &Event) {}

    /// Whether the integration ends here; called at least once per mesh cycle, by most kernels before every window.
    fn is_interrupted(&self) -> bool {
        false
    }
}

/// No observer.
impl Observer for () {
    const WINDOWS: bool = false;
}

/// Two observers.
impl<A: Observer, B: Observer> Observer for (A, B) {
    const WINDOWS: bool = A::WINDOWS || B::WINDOWS;
    const LINES: bool = A::LINES || B::LINES;

    fn states(&self) -> bool {
        (A::WINDOWS && self.0.states()) || (B::WINDOWS && self.1.states())
    }

    fn window(&mut self, window: &Window<'_>) {
        self.0.window(window);
        self.1.window(window);
    }

    fn event(&mut self, event: &Event) {
        self.0.event(event);
        self.1.event(event);
    }

    fn is_interrupted(&self) -> bool {
        self.0.is_interrupted() || self.1.is_interrupted()
    }
}

impl<O: Observer> Observer for &mut O {
    const WINDOWS: bool = O::WINDOWS;
    const LINES: bool = O::LINES;

    fn states(&self) -> bool {
        (**self).states()
    }

    fn window(&mut self, window: &Window<'_>) {
        (**self).window(window);
    }

    fn event(&mut self, event: &Event) {
        (**self).event(event);
    }

    fn is_interrupted(&self) -> bool {
        (**self).is_interrupted()
    }
}
