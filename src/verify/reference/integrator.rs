//! Advances a model from breakpoint to breakpoint and records its crossings.

use super::compressed::Compressed;
use super::crossing::{Margin, Sample, first_crossing};
use super::end_conditions::{EndCondition, SlidingDirection};
use super::error::ReferenceError;
use super::gauss::{Compensated, GaussRule, StageWork};
use super::push::{push, round_off, sliding};
use super::rate::fastest_rate;
use crate::model::{ActiveSet, Model, Release, Segment, TrajectoryState};

/// Stages of the rule: order 16.
const STAGES: usize = 8;

/// Largest number of changes of contact state allowed in a mesh cycle.
pub(super) const CROSSING_LIMIT: u32 = 10_000;

/// An opening or closing of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within the mesh cycle \[s\].
    pub time: f64,
    /// The closed contacts before.
    pub from: ActiveSet,
    /// The closed contacts after.
    pub to: ActiveSet,
    /// The contact that opens or closes.
    pub contact: usize,
    /// Rate of the deflection relative to the surface at the crossing, δ' − s b' \[m/s\]. Exceptions: δ' at a
    /// breakpoint, 0 for dry friction and for rests on stops.
    pub rate: f64,
}

/// Results of an integration.
#[derive(Debug, Clone, PartialEq)]
pub struct Passage {
    /// The trajectory at its end.
    pub end: TrajectoryState,
    /// Every opening and closing of a contact, in order.
    pub crossings: Vec<Crossing>,
}

/// A moment of an integration, for an observer.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within the mesh cycle \[s\].
    pub time: f64,
    /// Weight of the moment \[s\] in Gauss's rule, 0 at the start and the end of a smooth piece. The rule integrates
    /// smooth functions of the state over time to order 16.
    pub weight: f64,
    /// The segment of every contact.
    pub segments: &'a [Segment],
    /// The closed contacts.
    pub contact: ActiveSet,
    /// The state.
    pub state: &'a [f64],
}

/// The independent integrator of one model.
#[derive(Debug, Clone)]
pub struct Reference<'m> {
    pub(super) model: &'m Model,
    rule: GaussRule,
    /// Largest length of a step \[s\].
    pub(super) step: f64,
}

impl<'m> Reference<'m> {
    /// The integrator of a model, with steps of at most one radian of its fastest rate.
    pub fn new(model: &'m Model) -> Self {
        Self {
            model,
            rule: GaussRule::new(STAGES),
            step: 1.0 / fastest_rate(model),
        }
    }

    /// The same integrator with steps `factor` ≥ 1 times shorter.
    pub fn refined(mut self, factor: u32) -> Self {
        self.step /= f64::from(factor.max(1));
        self
    }

    /// Advances `cycles` whole mesh cycles from `start`.
    ///
    /// # Errors
    /// [`ReferenceError`] if the state becomes non-finite or the contact state changes too often.
    pub fn advance(&self, start: &TrajectoryState, cycles: u64) -> Result<Passage, ReferenceError> {
        self.advance_watched(start, cycles, &mut |_| {})
    }

    /// As [`Reference::advance`]. Passes to `watch`, in order, all moments that integrals over time need.
    ///
    /// # Errors
    /// As [`Reference::advance`].
    pub fn advance_watched(
        &self,
        start: &TrajectoryState,
        cycles: u64,
        watch: &mut dyn FnMut(Moment<'_>),
    ) -> Result<Passage, ReferenceError> {
        let n = start.state.len();
        let mut integration = Integration {
            reference: self,
            cycle: start.cycle,
            contact: start.contact,
            compressed: Compressed::default(),
            leaving: ActiveSet::FREE,
            segments: self.model.segments_at(start.cycle, 0.0),
            state: Compensated::new(start.state.clone()),
            trial_state: Compensated::new(vec![0.0; n]),
            work: StageWork::new(self.rule.stages(), n),
            samples: Vec::with_capacity(self.rule.stages() + 2),
            crossings: Vec::new(),
            watch,
        };
        for _ in 0..cycles {
            integration.one_cycle()?;
        }
        Ok(Passage {
            end: TrajectoryState {
                state: integration.state.value,
                contact: integration.contact,
                cycle: integration.cycle,
            },
            crossings: integration.crossings,
        })
    }
}

/// A running integration.
pub(super) struct Integration<'r> {
    pub(super) reference: &'r Reference<'r>,
    pub(super) cycle: u64,
    pub(super) contact: ActiveSet,
    compressed: Compressed,
    /// Impact contacts of the rigid stops at which a step starts with zero distance and no approach.
    pub(super) leaving: ActiveSet,
    /// The segment of every contact.
    pub(super) segments: Vec<Segment>,
    pub(super) state: Compensated,
    /// The state at the end of a trial step.
    trial_state: Compensated,
    work: StageWork,
    samples: Vec<Sample>,
    crossings: Vec<Crossing>,
    watch: &'r mut dyn FnMut(Moment<'_>),
}

impl Integration<'_> {
    fn one_cycle(&mut self) -> Result<(), ReferenceError> {
        let model = self.reference.model;
        let mut changes = 0;
        let mut start = 0.0;
        for end in model.segment_ends(self.cycle) {
            let inside = 0.5 * (start + end);
            self.segments = model.segments_at(self.cycle, model.period() * inside);
            let mut time = model.period() * start;
            self.turn(start, time);
            while time < model.period() * end {
                self.show(time);
                time = self.advance_to_breakpoint_or_crossing(
                    time,
                    model.period() * end,
                    &mut changes,
                )?;
            }
            start = end;
        }
        let at = (self.cycle, model.period());
        model.let_slide((self.contact, &self.segments), at, &mut self.state.value);
        self.cycle += 1;
        Ok(())
    }

    /// Opens and closes contacts at a breakpoint, except rigid stops and dry friction.
    fn turn(&mut self, phase: f64, time: f64) {
        let model = self.reference.model;
        let turning: Vec<usize> = model.turning(self.cycle, phase).collect();
        for (index, contact) in model.contacts.iter().enumerate() {
            if contact.release.of_stop() || contact.release.of_friction() {
                continue;
            }
            // Contacts with `Release::Force` are checked at all breakpoints: their force jumps with the stiffness.
            if contact.release != Release::Force && !turning.contains(&index) {
                continue;
            }
            let segment = &self.segments[index];
            let state = &self.state.value;
            let (deflection, rate) = model.deflection_on(segment, self.cycle, state, time);
            let closes = contact.closes(segment, time, deflection, rate);
            if closes != self.contact.holds(index) {
                self.cross(index, time, rate);
            }
        }
        let closed = (self.contact, &self.segments[..]);
        let at = (self.cycle, time);
        self.compressed = Compressed::of(model, closed, at, &self.state.value);
    }

    /// Conditions that may end the present state of a contact. The earliest one ends it.
    fn end_conditions(&self, contact: usize) -> &'static [EndCondition] {
        let release = self.reference.model.contacts[contact].release;
        match (release, self.contact.holds(contact)) {
            (Release::Stick, _) | (Release::Rest | Release::Rub | Release::Grip, false) => &[],
            (Release::Grip, true) => &[
                EndCondition::Limit(SlidingDirection::Forwards),
                EndCondition::Limit(SlidingDirection::Backwards),
            ],
            (Release::Rest, true) => &[EndCondition::Hold],
            (Release::Impact, _) if self.contact.holds(contact + 1) => &[],
            (Release::Slip | Release::Rub, true) => &[EndCondition::Slide],
            (Release::Force | Release::Film, true) => &[EndCondition::Push],
            (Release::Film, false) if self.compressed.passed.holds(contact) => {
                &[EndCondition::Depth]
            }
            _ if self.compressed.unladen.holds(contact) => {
                &[EndCondition::Push, EndCondition::Deflection]
            }
            _ => &[EndCondition::Deflection],
        }
    }

    /// Opens or closes a contact.
    pub(super) fn cross(&mut self, contact: usize, time: f64, rate: f64) {
        let from = self.contact;
        let model = self.reference.model;
        self.contact = model.toggled(from, contact);
        (self.compressed).take_note(model, self.contact, &self.segments);
        if model.is_slip(contact) {
            let at = (self.cycle, time);
            model.let_slide((from, &self.segments), at, &mut self.state.value);
        }
        self.crossings.push(Crossing {
            cycle: self.cycle,
            time,
            from,
            to: self.contact,
            contact,
            rate,
        });
    }

    /// Advances to the next breakpoint or to the next crossing; returns the time reached.
    fn advance_to_breakpoint_or_crossing(
        &mut self,
        start: f64,
        end: f64,
        changes: &mut u32,
    ) -> Result<f64, ReferenceError> {
        let steps = ((end - start) / self.reference.step).ceil().max(1.0);
        let at = |j: f64| {
            if j == steps { end } else { start + (end - start) * (j / steps) }
        };
        let mut j = 0.0;
        while j < steps {
            let (left, right) = (at(j), at(j + 1.0));
            if let Some(crossing) = self.step(left, right, j + 1.0 == steps)? {
                *changes += 1;
                if *changes > CROSSING_LIMIT {
                    return Err(ReferenceError::Chatter {
                        cycle: self.cycle,
                        limit: CROSSING_LIMIT,
                    });
                }
                return Ok(crossing);
            }
            j += 1.0;
        }
        Ok(end)
    }

    /// One step from `left` to `right`, or to the first end of a contact's state. Returns the time of this end; `None`
    /// if no state ends. `last` is true for the last step of a smooth piece.
    fn step(&mut self, left: f64, right: f64, last: bool) -> Result<Option<f64>, ReferenceError> {
        if let Some(stop) = self.reached_stop(left) {
            self.meet_stop(stop, stop.impact, left);
            return Ok(Some(left));
        }
        let h = right - left;
        let model = self.reference.model;
        self.advance(left, h);
        if !self.trial_state.value.iter().all(|x| x.is_finite()) {
            return Err(ReferenceError::NonFinite { cycle: self.cycle });
        }
        // Half a unit in the last place of a mesh period.
        let resolution = model.period() * 2f64.powi(-54);
        let mut first: Option<(f64, usize, EndCondition)> = None;
        let mut probed = false;
        for contact in 0..model.contacts.len() {
            if model.is_out_of_reach(contact, &self.segments, self.contact) {
                continue;
            }
            for &watched in self.end_conditions(contact) {
                self.sample(contact, watched, left, h);
                let samples = std::mem::take(&mut self.samples);
                let mut advanced = false;
                let crossing = first_crossing(&samples, resolution, |tau| {
                    advanced = true;
                    self.advance(left, tau);
                    self.margin(contact, watched, &self.trial_state.value, left + tau)
                });
                self.samples = samples;
                if advanced {
                    probed = true;
                    // Restore the stages of the whole step.
                    self.advance(left, h);
                }
                if let Some(tau) = crossing
                    && first.is_none_or(|(earlier, ..)| tau < earlier)
                {
                    first = Some((tau, contact, watched));
                }
            }
        }
        let reached = match first {
            // The sum rounds the time. The state is therefore advanced to the rounded time.
            Some((tau, ..)) => left + tau,
            None => right,
        };
        if probed {
            self.advance(left, reached - left);
        }
        self.show_stages(left, reached - left);
        self.state.copy_from(&self.trial_state);
        if first.is_some() || last {
            self.show(reached);
        }
        let Some((_, contact, watched)) = first else {
            self.leaving = ActiveSet::FREE;
            return Ok(None);
        };
        if let Some(stop) = model.stop_of(contact) {
            self.meet_stop(stop, contact, reached);
            return Ok(Some(reached));
        }
        if let Some(friction) = model.friction_of(contact) {
            self.meet_friction(friction, watched, reached);
            return Ok(Some(reached));
        }
        let Compressed { unladen, passed } = &mut self.compressed;
        let was_unladen = unladen.holds(contact);
        if watched == EndCondition::Depth {
            (*passed, *unladen) = (passed.toggled(contact), unladen.toggled(contact));
            return Ok(Some(reached));
        }
        if was_unladen || watched == EndCondition::Push {
            *unladen = unladen.toggled(contact);
        }
        if was_unladen && watched == EndCondition::Deflection {
            // The contact is free now; no force changes.
            return Ok(Some(reached));
        }
        let segment = self.segments[contact];
        let state = &self.state.value;
        let (_, rate) = model.deflection_on(&segment, self.cycle, state, reached);
        let contact_data = &model.contacts[contact];
        let [_, opening] = contact_data.gap(&segment, reached);
        self.cross(contact, reached, rate - contact_data.side * opening);
        Ok(Some(reached))
    }

    /// Passes the present state to the observer.
    fn show(&mut self, time: f64) {
        (self.watch)(Moment {
            cycle: self.cycle,
            time,
            weight: 0.0,
            segments: &self.segments,
            contact: self.contact,
            state: &self.state.value,
        });
    }

    /// Passes the stages of the step just solved to the observer.
    fn show_stages(&mut self, left: f64, h: f64) {
        let rule = &self.reference.rule;
        let stages = self.work.states.chunks_exact(self.state.value.len());
        for (state, (node, weight)) in stages.zip(rule.nodes.iter().zip(&rule.weights)) {
            (self.watch)(Moment {
                cycle: self.cycle,
                time: left + node * h,
                weight: weight * h,
                segments: &self.segments,
                contact: self.contact,
                state,
            });
        }
    }

    /// Sets `trial_state` to the state after `tau` from `left`.
    fn advance(&mut self, left: f64, tau: f64) {
        let model = self.reference.model;
        let rule = &self.reference.rule;
        let (contact, cycle, segments) = (self.contact, self.cycle, &self.segments);
        rule.solve(
            &self.state.value,
            tau,
            &mut self.work,
            |fraction, state, out| {
                model.derivative(segments, contact, cycle, left + fraction * tau, state, out);
            },
        );
        self.trial_state.copy_from(&self.state);
        for i in 0..self.state.value.len() {
            self.trial_state.add(i, rule.increment(&self.work, tau, i));
        }
    }

    /// Time derivative of a state.
    pub(super) fn slope(&self, state: &[f64], time: f64) -> Vec<f64> {
        let mut slope = vec![0.0; state.len()];
        let (model, active) = (self.reference.model, self.contact);
        model.derivative(&self.segments, active, self.cycle, time, state, &mut slope);
        slope
    }

    /// The margin of a contact in a state at a time.
    fn margin(&self, contact: usize, watched: EndCondition, state: &[f64], time: f64) -> Margin {
        let model = self.reference.model;
        let (contact_data, segment) = (&model.contacts[contact], &self.segments[contact]);
        let closed = self.contact.holds(contact);
        match watched {
            EndCondition::Deflection => {
                let motion = model.deflection_on(segment, self.cycle, state, time);
                let compressed = closed || self.compressed.unladen.holds(contact);
                let mut margin = Margin::new(
                    contact_data.side,
                    compressed,
                    motion,
                    contact_data.gap(segment, time),
                );
                if contact_data.release == Release::Slip || self.leaving.holds(contact) {
                    // Right after a slip or a rest the margin has a double root, which round-off must not
                    // split.
                    margin.value += round_off(model, contact, state);
                }
                margin
            }
            EndCondition::Hold => self.holding_force(contact, state, time),
            EndCondition::Limit(way) => self.room(contact, way, state, time),
            EndCondition::Depth => {
                let motion = model.deflection_on(segment, self.cycle, state, time);
                let [gap, opening] = contact_data.gap(segment, time);
                Margin::new(
                    contact_data.side,
                    true,
                    motion,
                    [gap + contact_data.band, opening],
                )
            }
            EndCondition::Slide => {
                let slope = self.slope(state, time);
                let at = (self.cycle, time);
                let mut margin = sliding(model, contact, segment, at, (state, &slope));
                if let Some(friction) = model.friction_of(contact) {
                    margin.value += self.round_off_of_sliding(friction, state)
                        - contact_data.side * friction.belt_speed;
                }
                margin
            }
            EndCondition::Push => {
                let slope = self.slope(state, time);
                let push = push(model, contact, segment, (self.cycle, time), state, &slope);
                let inside = if closed { 1.0 } else { -1.0 };
                Margin {
                    value: inside * push.value,
                    rate: inside * push.rate,
                }
            }
        }
    }

    /// Collects a contact's margin at the start, the stages and the end of the step just solved.
    fn sample(&mut self, contact: usize, watched: EndCondition, left: f64, h: f64) {
        let n = self.state.value.len();
        let mut samples = std::mem::take(&mut self.samples);
        samples.clear();
        samples.push((0.0, self.margin(contact, watched, &self.state.value, left)));
        for (i, c) in self.reference.rule.nodes.iter().enumerate() {
            let stage = &self.work.states[i * n..(i + 1) * n];
            samples.push((c * h, self.margin(contact, watched, stage, left + c * h)));
        }
        samples.push((
            h,
            self.margin(contact, watched, &self.trial_state.value, left + h),
        ));
        self.samples = samples;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Drive, OperatingPoint};
    use crate::structure::ModalStructure;

    fn model(frequency: f64, stiffness: f64) -> Model {
        let structure = ModalStructure {
            mesh: vec![2.0],
            ..ModalStructure::of_modes(&[frequency], 0.0, &[1.0], &[1.0])
        };
        let point = OperatingPoint {
            load: 1.0,
            speed: 1.0,
        };
        Model::new(&structure, &Drive::constant(1.0, stiffness), point).unwrap()
    }

    #[test]
    fn fastest_rate_is_the_closed_loop_frequency_of_one_degree() {
        // ω² + k w².
        assert!((fastest_rate(&model(3.0, 4.0)) - 5.0).abs() < 1e-14);
        assert!((fastest_rate(&model(0.0, 4.0)) - 4.0).abs() < 1e-14);
    }

    #[test]
    fn non_finite_states_are_reported() {
        let model = model(3.0, 4.0);
        let start = TrajectoryState::new(&model, vec![f64::NAN, 0.0], 7);
        assert_eq!(
            Reference::new(&model).advance(&start, 1),
            Err(ReferenceError::NonFinite { cycle: 7 })
        );
    }
}
