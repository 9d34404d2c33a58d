//! The works that are done on the vibration in each window, and the energy that the vibration stores.

use super::cause::Cause;
use crate::analysis::coupled_modes::CoupledModes;
use crate::analysis::modal_series::{ModalMotion, Series, TERMS, cosine_series, integral, padded};
use crate::model::{Model, Release, STIFFNESS_TERMS, Segment, TrajectoryState};
use crate::numerics::legendre::{at_end, at_start, derivative, evaluate, transforms8};
use crate::numerics::quadrature::GaussLegendre;
use crate::propagate::{ClosedContact, Window};
use std::f64::consts::FRAC_PI_2;
use std::sync::OnceLock;

/// Length of a window, in mesh cycles, below which the rate of deflection is computed from the state. The
/// series of such a short window may have a larger round-off.
const SHORT: f64 = 1e-9;

/// Works and stored energy of a trajectory of a model.
#[derive(Debug, Clone)]
pub(in crate::analysis) struct Balance<'m> {
    motion: ModalMotion<'m>,
    /// Contacts at the end of the last window.
    last: Option<WindowEndContacts>,
    /// `None` if modes are not coupled.
    coupled: Option<CoupledModes>,
    /// Gauss rule that is exact for the square of a deflection times the slope of a stiffness.
    rule: &'static GaussLegendre,
    /// The impulses since the last window \[N s\], each with the index of its direction.
    pub(super) struck: Vec<(usize, f64)>,
    /// Work that moving stops have done through these impulses \[J\].
    pub(super) given_by_stops: f64,
}

/// The contacts at one end of a window.
#[derive(Debug, Clone)]
pub(in crate::analysis) struct WindowEndContacts {
    /// The segment of every contact.
    segments: Vec<Segment>,
    /// The closed contacts that act as springs, and their deflections \[m\].
    closed: Vec<(usize, f64)>,
    /// Mesh phase, in cycles.
    phase: f64,
}

impl WindowEndContacts {
    /// The contacts at the start of a window.
    pub fn start(model: &Model, window: &Window<'_>) -> Self {
        Self::of(model, window, at_start, window.start / model.period())
    }

    fn end(model: &Model, window: &Window<'_>) -> Self {
        let end = window.start + window.duration;
        Self::of(model, window, at_end, end / model.period())
    }

    fn of(model: &Model, window: &Window<'_>, value: fn(&[f64]) -> f64, phase: f64) -> Self {
        let springs = (window.closed.iter()).filter(|closed| model.is_spring(closed.contact));
        Self {
            segments: window.segments.to_vec(),
            closed: springs
                .map(|closed| (closed.contact, value(&padded(closed.deflection))))
                .collect(),
            phase,
        }
    }

    /// Stiffness \[N/m\] and compression \[m\] of a contact's spring; `None` if no closed contact acts as a spring.
    fn spring(&self, model: &Model, contact: usize) -> Option<[f64; 2]> {
        let (_, deflection) = self.closed.iter().find(|(closed, _)| *closed == contact)?;
        Some(spring(
            model,
            contact,
            &self.segments[contact],
            self.phase,
            *deflection,
        ))
    }
}

/// Stiffness \[N/m\] and compression \[m\] of a closed contact's spring at a phase, in cycles.
fn spring(
    model: &Model,
    contact: usize,
    segment: &Segment,
    phase: f64,
    deflection: f64,
) -> [f64; 2] {
    let contact = &model.contacts[contact];
    let [gap, _] = contact.gap(segment, phase * model.period());
    if contact.release == Release::Slip {
        return [segment.stiffness_at(phase), gap];
    }
    [segment.stiffness_at(phase), deflection - contact.side * gap]
}

fn energy([stiffness, stretch]: [f64; 2]) -> f64 {
    0.5 * stiffness * stretch * stretch
}

impl<'m> Balance<'m> {
    /// The balance of a model, from the motion of its blocks.
    pub fn new(motion: ModalMotion<'m>) -> Self {
        static RULE: OnceLock<GaussLegendre> = OnceLock::new();
        Self {
            last: None,
            struck: Vec::new(),
            given_by_stops: 0.0,
            coupled: CoupledModes::of(motion.model()),
            motion,
            rule: RULE.get_or_init(|| GaussLegendre::new(TERMS + STIFFNESS_TERMS)),
        }
    }

    /// The model.
    pub fn model(&self) -> &Model {
        self.motion.model()
    }

    /// Forgets the last window.
    pub fn restart(&mut self) {
        self.last = None;
        self.struck.clear();
        self.given_by_stops = 0.0;
    }

    /// Energy stored in structure and contacts at the start of a window \[J\].
    pub fn stored_before(&self, window: &Window<'_>) -> f64 {
        let edge = WindowEndContacts::start(self.model(), window);
        let springs = edge.closed.iter().map(|&(contact, deflection)| {
            let segment = &edge.segments[contact];
            energy(spring(
                self.model(),
                contact,
                segment,
                edge.phase,
                deflection,
            ))
        });
        springs.fold(self.structure(window.first, window.second), |sum, e| {
            sum + e
        })
    }

    /// Energy stored at `end`, the end of a mesh cycle and of the last window \[J\]; `None` before the first
    /// window.
    pub fn stored_at(&self, end: &TrajectoryState) -> Option<f64> {
        let last = self.last.as_ref()?;
        let model = self.model();
        let (first, second) = end.state.split_at(model.modes());
        let springs = last.closed.iter().map(|&(contact, _)| {
            let segment = &last.segments[contact];
            let deflection = model.deflection_on(segment, end.cycle, &end.state, 0.0).0;
            energy(spring(model, contact, segment, 1.0, deflection))
        });
        Some(springs.fold(self.structure(first, second), |sum, e| sum + e))
    }

    pub(super) fn structure(&self, first: &[f64], second: &[f64]) -> f64 {
        let model = self.model();
        if let Some(coupled) = &self.coupled {
            return coupled.stored(model, first, second);
        }
        let mut energy = 0.0;
        for (i, block) in model.blocks.iter().enumerate() {
            if model.neutral.contains(&i) {
                continue;
            }
            let omega = block.natural_frequency();
            energy += second[i] * second[i] + (omega * first[i]).powi(2);
        }
        0.5 * energy
    }

    /// Sum of the energies whose round-off enters the balance, at the start of a window \[J\]. These are the
    /// energies of structure and contacts, and the works of the torques over their rotations. The compression
    /// of a contact is a small difference of large terms, so it contains their round-off.
    pub fn magnitude(&self, window: &Window<'_>) -> f64 {
        let model = self.model();
        let phase = window.start / model.period();
        if let Some(coupled) = &self.coupled {
            return coupled.magnitude(model, window, phase);
        }
        let turning = (model.blocks.iter().enumerate()).filter(|(i, _)| !model.neutral.contains(i));
        let torque_work: f64 = (turning.clone())
            .map(|(i, block)| (block.static_input[1] * window.first[i]).abs())
            .sum();
        let mut contacts = 0.0;
        let springs = (window.closed.iter()).filter(|closed| model.is_spring(closed.contact));
        for closed in springs {
            let segment = &window.segments[closed.contact];
            let contact = &model.contacts[closed.contact];
            let deflection = at_start(&padded(closed.deflection));
            let gains = model.gains(segment);
            let along = turning
                .clone()
                .map(|(i, _)| (gains[i].deflection[0] * window.first[i]).abs());
            let room = along.fold(model.half_gap + deflection.abs(), |sum, a| sum + a);
            let stretch = (deflection - contact.side * contact.half_gap).abs();
            let padded_stretch = stretch + f64::EPSILON * room;
            contacts += segment.stiffness_at(phase) * padded_stretch * room;
        }
        self.structure(window.first, window.second) + torque_work + contacts
    }

    /// Passes each work \[J\] of a window, and of the steps since the last window, to `work`.
    pub fn window(&mut self, window: &Window<'_>, work: &mut impl FnMut(Cause, f64)) {
        if let Some(last) = &self.last {
            steps(
                self.model(),
                last,
                &WindowEndContacts::start(self.model(), window),
                work,
            );
        }
        if !self.struck.is_empty() {
            let gained = self.gained_by_impacts(window.first, window.second);
            let given = std::mem::take(&mut self.given_by_stops);
            work(Cause::Error, given);
            work(Cause::Contact, gained - given);
            self.struck.clear();
        }
        self.last = Some(WindowEndContacts::end(self.model(), window));
        for closed in window.closed {
            self.contact_work(window, closed, work);
        }
        self.structural_work(window, work);
    }

    /// Passes each work \[J\] of the steps from the last window to `next` to `work`.
    pub fn step_to(&self, next: &WindowEndContacts, work: &mut impl FnMut(Cause, f64)) {
        if let Some(last) = &self.last {
            steps(self.model(), last, next, work);
        }
    }

    /// Series over a window of the flank error of a closed contact, times its side: s e \[m\].
    fn contact_gap_error(&self, window: &Window<'_>, contact: usize) -> Series {
        let model = self.model();
        let segment = &window.segments[contact];
        let place = |time: f64| segment.place(time / model.period());
        let ends = [window.start, window.start + window.duration].map(place);
        let series = transforms8().restrict(segment.error.coefficients(), ends[0], ends[1]);
        padded(&series.map(|a| model.contacts[contact].side * a))
    }

    /// Work of a varying stiffness over a window; `deflection` excludes the flank error.
    fn stiffening(&self, window: &Window<'_>, contact: usize, deflection: &Series) -> f64 {
        let model = self.model();
        let segment = &window.segments[contact];
        let slope = segment.stiffness.slope();
        let contact = &model.contacts[contact];
        let level = contact.side * contact.half_gap;
        let mut work = 0.0;
        for (x, weight) in self.rule.nodes.iter().zip(&self.rule.weights) {
            let time = window.start + 0.5 * window.duration * (1.0 + x);
            let place = segment.place(time / model.period());
            let stretch = evaluate(deflection, *x) - level;
            work += weight * evaluate(&slope, place) * stretch * stretch;
        }
        // Half the duration converts the node's position to time. `phase_rate` converts time to the position
        // in the segment.
        let phase_rate = 2.0 / (segment.end - segment.start) / model.period();
        0.25 * window.duration * phase_rate * work
    }

    /// Works of loads, friction and structural damping over a window.
    fn structural_work(&mut self, window: &Window<'_>, work: &mut impl FnMut(Cause, f64)) {
        let tau = window.duration;
        let series = self.motion.on(window);
        let model = series.model();
        if let Some(coupled) = &self.coupled {
            return coupled.works(window, &series, work);
        }
        let (mut loads, mut damping) = (0.0, 0.0);
        let mut friction = vec![0.0; window.closed.len()];
        for (i, block) in model.blocks.iter().enumerate() {
            if model.neutral.contains(&i) {
                continue;
            }
            let velocity = series.component(i, 1);
            loads += block.static_input[1] * tau * velocity[0];
            for (ripple, course) in model.ripple.iter().zip(series.ripples()) {
                loads += ripple.input[i][1] * integral(course, &velocity, tau);
            }
            for (friction, closed) in friction.iter_mut().zip(window.closed) {
                let segment = &window.segments[closed.contact];
                let direction = model.motion_direction_index(closed.contact, segment);
                let gain = &model.directions[direction].gains[i];
                let rubbing = gain.mesh_input[1] - gain.deflection[0];
                if rubbing != 0.0 {
                    *friction -= rubbing * integral(&padded(closed.force), &velocity, tau);
                }
            }
            damping += 2.0 * block.growth() * integral(&velocity, &velocity, tau);
        }
        work(Cause::Loads, loads);
        for friction in friction {
            work(Cause::Friction, friction);
        }
        work(Cause::Structure, damping);
    }

    /// Rate of a contact's deflection at the start of a window \[m/s\], without that of the flank error.
    fn rate(&self, window: &Window<'_>, contact: usize) -> f64 {
        let (model, segment) = (self.model(), &window.segments[contact]);
        let state = [window.first, window.second].concat();
        let (_, rate) = model.deflection_on(segment, window.cycle, &state, window.start);
        let [_, opening] = segment.error_at(window.start / model.period());
        rate - model.contacts[contact].side * opening / model.period()
    }

    /// Works of a closed contact over a window.
    fn contact_work(
        &self,
        window: &Window<'_>,
        closed: &ClosedContact<'_>,
        work: &mut impl FnMut(Cause, f64),
    ) {
        let tau = window.duration;
        let segment = &window.segments[closed.contact];
        let (mut deflection, force) = (padded(closed.deflection), padded(closed.force));
        let model = self.model();
        let direction = model.motion_direction_index(closed.contact, segment);
        for h in &model.lines[model.directions[direction].line].transmission_error {
            // e' = −a ω sin(ωt + φ) = a ω cos(ωt + φ + π/2).
            let phase = h.turned(window.cycle, window.start) + h.phase + FRAC_PI_2;
            let rate = cosine_series(h.angular_frequency, phase, tau);
            let removed_work = integral(&force, &rate, tau) * h.amplitude * h.angular_frequency;
            work(Cause::Error, -removed_work);
        }
        if !segment.error.is_none() {
            let contact_gap_error = self.contact_gap_error(window, closed.contact);
            let opening = derivative(&contact_gap_error).map(|d| 2.0 / tau * d);
            work(Cause::Error, -integral(&force, &opening, tau));
            for (d, contact_gap_error) in deflection.iter_mut().zip(&contact_gap_error) {
                *d -= contact_gap_error;
            }
        }
        if let Some(friction) = model.friction_of(closed.contact) {
            // If dry friction sticks, the deflection of its line describes its force, not its motion.
            let work_against_friction = if model.is_slip(closed.contact) {
                force[0] * (at_end(&deflection) - at_start(&deflection))
            } else {
                force[0] * friction.belt_speed * tau
            };
            work(Cause::Friction, -work_against_friction);
            return;
        }
        if model.is_rest(closed.contact) {
            return;
        }
        if model.is_slip(closed.contact) {
            let slid = at_end(&deflection) - at_start(&deflection);
            work(Cause::Contact, -force[0] * slid);
            return;
        }
        let square = if tau < SHORT * self.model().period() {
            tau * self.rate(window, closed.contact).powi(2)
        } else {
            let rate = derivative(&deflection).map(|d| 2.0 / tau * d);
            integral(&rate, &rate, tau)
        };
        work(Cause::Contact, -segment.damping * square);
        if !segment.stiffness.is_constant() {
            work(
                Cause::Stiffness,
                self.stiffening(window, closed.contact, &deflection),
            );
        }
    }
}

/// Passes the energy that springs of contacts gain by steps of stiffness, line or gap between two windows. If
/// stiffness and length step at the same time, each work is the mean of its values before and after the other
/// step.
fn steps(
    model: &Model,
    before: &WindowEndContacts,
    after: &WindowEndContacts,
    work: &mut impl FnMut(Cause, f64),
) {
    for (contact, law) in model.contacts.iter().enumerate() {
        let (old, new) = (&before.segments[contact], &after.segments[contact]);
        let springs = [before, after].map(|edge| edge.spring(model, contact));
        let toggles = springs[0].is_some() != springs[1].is_some();
        // A contact released while compressed loses the energy of its spring.
        let released = law.release == Release::Force && toggles;
        if old == new && !released {
            continue;
        }
        let may_change_length =
            model.line(old) != model.line(new) || !(old.error.is_none() && new.error.is_none());
        match springs {
            [Some([k, length]), Some([stepped, stretched])] => {
                // If line and error stay the same, the spring has the same length in both windows.
                let length = if may_change_length { length } else { stretched };
                let squares = [length * length, stretched * stretched];
                work(
                    Cause::Stiffness,
                    0.25 * (stepped - k) * (squares[0] + squares[1]),
                );
                if may_change_length {
                    work(
                        Cause::Error,
                        0.25 * (stepped + k) * (squares[1] - squares[0]),
                    );
                }
            }
            // If contact ends or begins at the gap, the spring stores no energy there.
            [resting, holds] if may_change_length || released => {
                let gained = holds.map_or(0.0, energy) - resting.map_or(0.0, energy);
                let cause = if released { Cause::Contact } else { Cause::Error };
                work(cause, gained);
            }
            _ => {}
        }
    }
}
