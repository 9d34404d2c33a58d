//! Does the energy balance close?
//!
//! Over any stretch, with u the modal velocities,
//!
//! ```text
//! Δ(½Σ(v² + ω²q²) + Σ ½k(δ − s b)²) = ∫ T·u dt                 torques
//!     − ∫ F e' dt − ∫ F s b' dt                               transmission error, half gap
//!     − ∫ Σ 2ζω u² dt − ∫ c (δ' − s b')² dt                   damping, structure and contacts
//!     − ∫ F (g − w)·u dt                                      friction
//!     + ∫ ½ k' (δ − s b)² dt                                  stiffness that varies
//!     + Σ Δ(½ k (δ − s b)²)                                   steps of stiffness, line, gap;
//!                                                             contacts that let go compressed
//! ```
//!
//! each summed over the closed contacts.
//! Every integrand is a product of Legendre series. The modal velocities are rebuilt
//! ([`super::modal_series`]) from the state at each window's start and the force series,
//! independently of how the kernel moved the state on. The residual is relative to the sum
//! of all absolute works and the largest energy stored: of a drive at rest under its load no work
//! is done, and what is left of the balance is the round-off of what is stored.

use super::coupled_modes::CoupledModes;
use super::modal_series::{ModalMotion, Series, TERMS, cosine_series, integral, padded};
use crate::model::{Model, Release, STIFFNESS_TERMS, Segment, TrajectoryState};
use crate::numerics::legendre::{at_end, at_start, derivative, evaluate, transforms8};
use crate::numerics::quadrature::GaussLegendre;
use crate::propagate::{ClosedContact, Event, Observer, Window};
use std::f64::consts::FRAC_PI_2;
use std::sync::OnceLock;

/// Residual above which a kernel without errors of its own has failed. Of a thousand random
/// drives no valid row is above 1e-11.
pub const LARGEST_RESIDUAL: f64 = 1e-9;

/// What is to be said of a motion whose energy balance does not close; none where it does.
pub fn objection(residual: f64) -> Option<String> {
    // Written so that a residual that is not a number is objected to.
    let closes = residual <= LARGEST_RESIDUAL;
    (!closes).then(|| {
        format!(
            "the energy balance misses by {residual:.1e} of the energy at work (at most {LARGEST_RESIDUAL:.0e} is round-off): the kernel does not follow this drive, another run.kernel may"
        )
    })
}

/// Audits the energy balance of a trajectory.
#[derive(Debug, Clone)]
pub struct EnergyAudit<'m> {
    model: &'m Model,
    motion: ModalMotion<'m>,
    start: Option<f64>,
    balance: f64,
    turnover: f64,
    /// Largest energy stored, all of its parts by their size \[J\].
    stored: f64,
    last: Option<Last>,
    /// Where modes are coupled.
    coupled: Option<CoupledModes<'m>>,
    /// Exact for the square of a deflection times the slope of a stiffness.
    rule: &'static GaussLegendre,
}

/// How the last window ended.
#[derive(Debug, Clone)]
struct Last {
    /// The segment of every contact.
    segments: Vec<Segment>,
    /// The closed contacts and their deflections \[m\].
    closed: Vec<(usize, f64)>,
    /// Mesh phase, in cycles.
    phase: f64,
}

impl<'m> EnergyAudit<'m> {
    /// An audit that starts with the first window shown.
    pub fn new(model: &'m Model) -> Self {
        static RULE: OnceLock<GaussLegendre> = OnceLock::new();
        Self {
            model,
            motion: ModalMotion::new(model),
            start: None,
            balance: 0.0,
            turnover: 0.0,
            stored: 0.0,
            last: None,
            coupled: CoupledModes::of(model),
            rule: RULE.get_or_init(|| GaussLegendre::new(TERMS + STIFFNESS_TERMS)),
        }
    }

    /// Relative residual of the balance up to `end`, which is where the last window shown
    /// ended; none when nothing was shown or nothing moved.
    pub fn residual(&self, end: &TrajectoryState) -> Option<f64> {
        let (start, last) = (self.start?, self.last.as_ref()?);
        let n = self.model.modes();
        let (first, second) = end.state.split_at(n);
        let mut stored = self.structure(first, second);
        for &(contact, _) in &last.closed {
            let segment = &last.segments[contact];
            let deflection = (self.model)
                .deflection_on(segment, end.cycle, &end.state, 0.0)
                .0;
            stored += self.spring(contact, segment, 1.0, deflection);
        }
        let imbalance = stored - start - self.balance;
        let at_work = self.turnover + self.stored;
        (at_work > 0.0).then(|| imbalance.abs() / at_work)
    }

    fn structure(&self, first: &[f64], second: &[f64]) -> f64 {
        if let Some(coupled) = &self.coupled {
            return coupled.stored(first, second);
        }
        let mut energy = 0.0;
        for (i, block) in self.model.blocks.iter().enumerate() {
            if self.model.neutral.contains(&i) {
                continue;
            }
            let omega = block.natural_frequency();
            energy += second[i] * second[i] + (omega * first[i]).powi(2);
        }
        0.5 * energy
    }

    /// Energy of a closed contact at a phase, in cycles.
    fn spring(&self, contact: usize, segment: &Segment, phase: f64, deflection: f64) -> f64 {
        let contact = &self.model.contacts[contact];
        let [gap, _] = contact.gap(segment, phase * self.model.period());
        let stretch = deflection - contact.side * gap;
        0.5 * segment.stiffness_at(phase) * stretch * stretch
    }

    /// Energies whose round-off the balance is made of: those of structure and contacts, and of the
    /// torques over what they have turned. The stretch of a contact is a small difference, known to
    /// the round-off of what it is the difference of.
    fn magnitude(&self, window: &Window<'_>, phase: f64) -> f64 {
        let model = self.model;
        if let Some(coupled) = &self.coupled {
            return coupled.magnitude(window, phase);
        }
        let turning = (model.blocks.iter().enumerate()).filter(|(i, _)| !model.neutral.contains(i));
        let turned: f64 = (turning.clone())
            .map(|(i, block)| (block.static_input[1] * window.first[i]).abs())
            .sum();
        let mut contacts = 0.0;
        for closed in window.closed {
            let segment = &window.segments[closed.contact];
            let contact = &model.contacts[closed.contact];
            let deflection = at_start(&padded(closed.deflection));
            let gains = model.gains(segment);
            let along = turning
                .clone()
                .map(|(i, _)| (gains[i].deflection[0] * window.first[i]).abs());
            let room = along.fold(model.half_gap + deflection.abs(), |sum, a| sum + a);
            let stretch = (deflection - contact.side * contact.half_gap).abs();
            let known = stretch + f64::EPSILON * room;
            contacts += segment.stiffness_at(phase) * known * room;
        }
        self.structure(window.first, window.second) + turned + contacts
    }

    fn work(&mut self, value: f64) {
        self.balance += value;
        self.turnover += value.abs();
    }

    /// Series over a window of what the flanks of a closed contact lack on its side, s e.
    fn lack(&self, window: &Window<'_>, contact: usize) -> Series {
        let segment = &window.segments[contact];
        let place = |time: f64| segment.place(time / self.model.period());
        let ends = [window.start, window.start + window.duration].map(place);
        let series = transforms8().restrict(segment.error.coefficients(), ends[0], ends[1]);
        padded(&series.map(|a| self.model.contacts[contact].side * a))
    }

    /// Work of a stiffness that varies over a window, `deflection` being without what the flanks
    /// lack.
    fn stiffening(&mut self, window: &Window<'_>, contact: usize, deflection: &Series) {
        let segment = &window.segments[contact];
        if segment.stiffness.is_constant() {
            return;
        }
        let slope = segment.stiffness.slope();
        let contact = &self.model.contacts[contact];
        let level = contact.side * contact.half_gap;
        let mut work = 0.0;
        for (x, weight) in self.rule.nodes.iter().zip(&self.rule.weights) {
            let time = window.start + 0.5 * window.duration * (1.0 + x);
            let place = segment.place(time / self.model.period());
            let stretch = evaluate(deflection, *x) - level;
            work += weight * evaluate(&slope, place) * stretch * stretch;
        }
        // dk/dt dt: from the window's place to time, from the segment's place to phase.
        let phase_rate = 2.0 / (segment.end - segment.start) / self.model.period();
        self.work(0.25 * window.duration * phase_rate * work);
    }

    /// Works of torques, friction and structural damping over a window.
    fn structural_work(&mut self, window: &Window<'_>) {
        let tau = window.duration;
        let model = self.model;
        let series = self.motion.on(window);
        if let Some(coupled) = &self.coupled {
            for work in coupled.works(window, &series) {
                self.work(work);
            }
            return;
        }
        let (mut torque, mut damping) = (0.0, 0.0);
        let mut friction = vec![0.0; window.closed.len()];
        for (i, block) in model.blocks.iter().enumerate() {
            if model.neutral.contains(&i) {
                continue;
            }
            let velocity = series.component(i, 1);
            torque += block.static_input[1] * tau * velocity[0];
            for (ripple, course) in model.ripple.iter().zip(series.ripples()) {
                torque += ripple.input[i][1] * integral(course, &velocity, tau);
            }
            for (friction, closed) in friction.iter_mut().zip(window.closed) {
                let gain = &model.gains(&window.segments[closed.contact])[i];
                let rubbing = gain.mesh_input[1] - gain.deflection[0];
                if rubbing != 0.0 {
                    *friction -= rubbing * integral(&padded(closed.force), &velocity, tau);
                }
            }
            damping += 2.0 * block.growth() * integral(&velocity, &velocity, tau);
        }
        self.work(torque);
        for friction in friction {
            self.work(friction);
        }
        self.work(damping);
    }

    /// Energy that the springs of closed contacts gain between the last window and this one, where
    /// stiffness, line or gap step.
    fn steps(&mut self, window: &Window<'_>, phase: f64) {
        let Some(last) = self.last.take() else { return };
        let model = self.model;
        for contact in 0..model.contacts.len() {
            let (old, new) = (&last.segments[contact], &window.segments[contact]);
            let before = last.closed.iter().find(|(closed, _)| *closed == contact);
            let after = window
                .closed
                .iter()
                .find(|closed| closed.contact == contact);
            // What lets go while it is compressed loses what its spring holds.
            let released = model.contacts[contact].release == Release::Force
                && before.is_some() != after.is_some();
            if old == new && !released {
                continue;
            }
            let turned =
                model.line(old) != model.line(new) || !(old.error.is_none() && new.error.is_none());
            let at = after.map(|closed| at_start(&padded(closed.deflection)));
            // Where nothing turns the spring is as long on both sides, and an event finds no energy.
            if turned || released || before.is_some() == after.is_some() {
                let spring = at.map_or(0.0, |at| self.spring(contact, new, phase, at));
                let spent = before.map_or(0.0, |&(_, end)| {
                    let length = if turned { end } else { at.unwrap_or(end) };
                    self.spring(contact, old, last.phase, length)
                });
                self.work(spring - spent);
            }
        }
    }

    /// Works of a closed contact over a window.
    fn contact_work(&mut self, window: &Window<'_>, closed: &ClosedContact<'_>) {
        let tau = window.duration;
        let segment = &window.segments[closed.contact];
        let (mut deflection, force) = (padded(closed.deflection), padded(closed.force));
        for h in &self.model.lines[self.model.line(segment)].transmission_error {
            // e' = −a ω sin(ωt + φ) = a ω cos(ωt + φ + π/2).
            let phase = h.turned(window.cycle, window.start) + h.phase + FRAC_PI_2;
            let rate = cosine_series(h.angular_frequency, phase, tau);
            let work = integral(&force, &rate, tau) * h.amplitude * h.angular_frequency;
            self.work(-work);
        }
        if !segment.error.is_none() {
            let lack = self.lack(window, closed.contact);
            let opening = derivative(&lack).map(|d| 2.0 / tau * d);
            self.work(-integral(&force, &opening, tau));
            for (d, lack) in deflection.iter_mut().zip(&lack) {
                *d -= lack;
            }
        }
        let rate = derivative(&deflection).map(|d| 2.0 / tau * d);
        self.work(-segment.damping * integral(&rate, &rate, tau));
        self.stiffening(window, closed.contact, &deflection);
    }
}

impl Observer for EnergyAudit<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let phase = window.start / self.model.period();
        self.stored = self.stored.max(self.magnitude(window, phase));
        if self.start.is_none() {
            let mut stored = self.structure(window.first, window.second);
            for closed in window.closed {
                let at = at_start(&padded(closed.deflection));
                let segment = &window.segments[closed.contact];
                stored += self.spring(closed.contact, segment, phase, at);
            }
            self.start = Some(stored);
        }
        self.steps(window, phase);
        self.last = Some(Last {
            segments: window.segments.to_vec(),
            closed: (window.closed.iter())
                .map(|closed| (closed.contact, at_end(&padded(closed.deflection))))
                .collect(),
            phase: (window.start + window.duration) / self.model.period(),
        });
        for closed in window.closed {
            self.contact_work(window, closed);
        }
        self.structural_work(window);
    }

    fn event(&mut self, _: &Event) {}
}

#[cfg(test)]
mod tests;
