//! An integrator of about 30 digits, which shows the errors of all other integrations.
//!
//! Between breakpoints and events the system is linear, its stiffness and its half gap are polynomials (mostly
//! constants), and its inputs are harmonic. Its Taylor series therefore follows by recurrence. With `u = t/h` on a step
//! of length h,
//!
//! ```text
//! x(u) = Σ X_j u^j,   X_{j+1} = h/(j+1) (A X_j − g F_j + s_j)
//! F_j  = Σ_m k_m (δ_{j−m} − s b_{j−m}) + c (δ'_j − s b'_j)
//! ```
//!
//! in numbers of two doubles each. A step is at most one radian of the fastest rate, so that the omitted
//! terms are below 1/31! ≈ 1e-34. Every event is a zero of a series for δ, for its rate or for the push of a
//! contact. Signs of coefficients prove that it is the first zero (`root`). Breakpoints are exact. The parameters of
//! the [`Model`](crate::model::Model) count as exact.

mod double_double;
mod root;
mod series;

pub use double_double::DoubleDouble;

use super::ReferenceError;
use super::integrator::CROSSING_LIMIT;
use super::rate::fastest_rate;
use crate::model::{ActiveSet, Model, Release, Segment, TrajectoryState};
use series::{Instant, StepSeries, Structure};

/// Bound, relative to the stretch at the limit, below which two quantities count as zero after an event: the
/// stretch of a slider's spring beyond the limit, and its change over a step.
const LEFT_BY_AN_EVENT: f64 = 1e-22;

/// Round-off of the stretch of a slider's spring in doubles, in units of the largest of its limit and the components of
/// the state.
const AT_LIMIT: f64 = 1e-14;

/// Order of the series on a step, whose terms are X₀ … X₃₀.
const ORDER: usize = 30;

/// Extended-precision integrator of one model.
#[derive(Debug, Clone)]
pub struct Extended<'m> {
    model: &'m Model,
    structure: Structure,
    order: usize,
    /// Largest length of a step \[s\].
    step: f64,
    /// Growth rate of the speed, relative to the speed of the model \[1/s\].
    acceleration: f64,
}

/// A change of a contact, with its time to all digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtendedCrossing {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within the mesh cycle \[s\].
    pub time: DoubleDouble,
    /// The closed contacts before.
    pub from: ActiveSet,
    /// The closed contacts after.
    pub to: ActiveSet,
}

/// Results of an extended integration.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtendedPassage {
    /// State at the end: first components of all blocks, then second components, length 2N.
    pub state: Vec<DoubleDouble>,
    /// The closed contacts at the end.
    pub contact: ActiveSet,
    /// Mesh cycles since the start of the simulation.
    pub cycle: u64,
    /// Every opening and closing of a contact, in order.
    pub crossings: Vec<ExtendedCrossing>,
}

impl ExtendedPassage {
    /// Differences `state − end` for a state in doubles, computed before rounding.
    pub fn difference(&self, state: &[f64]) -> Vec<f64> {
        state
            .iter()
            .zip(&self.state)
            .map(|(&x, &end)| (DoubleDouble::exact(x) - end).value())
            .collect()
    }

    /// The end, rounded to doubles.
    pub fn end(&self) -> TrajectoryState {
        TrajectoryState {
            state: self.state.iter().map(|x| x.value()).collect(),
            contact: self.contact,
            cycle: self.cycle,
        }
    }
}

impl<'m> Extended<'m> {
    /// The integrator of a model.
    pub fn new(model: &'m Model) -> Self {
        Self::with_order(model, ORDER)
    }

    /// The integrator with another order ≥ 2, for tests of the observed order.
    pub fn with_order(model: &'m Model, order: usize) -> Self {
        Self {
            model,
            structure: Structure::new(model),
            order: order.max(2),
            step: 1.0 / fastest_rate(model),
            acceleration: 0.0,
        }
    }

    /// The same integrator for a drive whose speed grows uniformly, at a rate relative to the model's speed \[1/s\].
    /// Times within a mesh cycle then refer to the model's speed, `T · phase`.
    pub fn accelerated(mut self, acceleration: f64) -> Self {
        self.acceleration = acceleration;
        self
    }

    /// The same integrator with steps `factor` ≥ 1 times shorter.
    pub fn refined(mut self, factor: u32) -> Self {
        self.step /= f64::from(factor.max(1));
        self
    }

    /// Advances `cycles` whole mesh cycles from `start`, whose doubles count as exact.
    ///
    /// # Errors
    /// [`ReferenceError`] if the state becomes non-finite, the contact state changes too often, or the
    /// trajectory touches a surface within the last digit, so that the sequence of events is uncertain. Also
    /// for a film of oil, rigid stops or dry friction.
    pub fn advance(
        &self,
        start: &TrajectoryState,
        cycles: u64,
    ) -> Result<ExtendedPassage, ReferenceError> {
        if self.model.film_layers > 0 {
            return Err(ReferenceError::Film);
        }
        if !self.model.stops.is_empty() {
            return Err(ReferenceError::RigidStop);
        }
        if !self.model.frictions.is_empty() {
            return Err(ReferenceError::DryFriction);
        }
        let mut integration = Integration {
            extended: self,
            cycle: start.cycle,
            contact: start.contact,
            segments: self.model.segments_at(start.cycle, 0.0),
            crossed: ActiveSet::FREE,
            forceless: ActiveSet::FREE,
            speed: DoubleDouble::ONE,
            state: start
                .state
                .iter()
                .map(|&x| DoubleDouble::exact(x))
                .collect(),
            crossings: Vec::new(),
        };
        integration.clamp_sliders();
        for _ in 0..cycles {
            integration.one_cycle()?;
        }
        Ok(ExtendedPassage {
            state: integration.state,
            contact: integration.contact,
            cycle: integration.cycle,
            crossings: integration.crossings,
        })
    }
}

/// A running integration.
struct Integration<'e> {
    extended: &'e Extended<'e>,
    cycle: u64,
    contact: ActiveSet,
    /// The segment of every contact.
    segments: Vec<Segment>,
    /// Contacts on whose surfaces the trajectory is exactly, right after an event.
    crossed: ActiveSet,
    /// Contacts with zero push, right after they opened or closed again.
    forceless: ActiveSet,
    /// Speed, relative to that of the model.
    speed: DoubleDouble,
    state: Vec<DoubleDouble>,
    crossings: Vec<ExtendedCrossing>,
}

impl Integration<'_> {
    fn one_cycle(&mut self) -> Result<(), ReferenceError> {
        let model = self.extended.model;
        let boundary = |phase: f64| DoubleDouble::product(model.period(), phase);
        let mut met = 0;
        let mut start = 0.0;
        for phase in model.segment_ends(self.cycle) {
            let mut time = boundary(start);
            let end = boundary(phase);
            let inside = 0.5 * (start + phase);
            self.segments = model.segments_at(self.cycle, model.period() * inside);
            self.turn(start, time);
            while time < end {
                let rest = self.time_to_pass(end - time);
                let steps = (rest.value() / self.extended.step).ceil().max(1.0);
                let length = rest / DoubleDouble::exact(steps);
                let (passed, place) = self.step(time, length)?;
                met += u32::from(place.is_some());
                let last = steps == 1.0 && place.is_none();
                time = if last { end } else { passed };
                let part = place.unwrap_or(DoubleDouble::ONE);
                self.speed += length * part * self.extended.acceleration;
                if met > CROSSING_LIMIT {
                    return Err(ReferenceError::Chatter {
                        cycle: self.cycle,
                        limit: CROSSING_LIMIT,
                    });
                }
            }
            start = phase;
        }
        self.let_slide(self.contact, boundary(1.0));
        self.cycle += 1;
        Ok(())
    }

    /// Time \[s\] that corresponds to a time at the model's speed.
    fn time_to_pass(&self, passed: DoubleDouble) -> DoubleDouble {
        let half = 0.5 * self.extended.acceleration;
        let mut time = passed / self.speed;
        if half != 0.0 {
            for _ in 0..8 {
                let off = time * (self.speed + time * half) - passed;
                time = time - off / (self.speed + time * (2.0 * half));
            }
        }
        time
    }

    /// Opens and closes contacts whose line or gap changes at this mesh phase.
    fn turn(&mut self, phase: f64, time: DoubleDouble) {
        let Extended {
            model, structure, ..
        } = self.extended;
        for index in model.turning(self.cycle, phase) {
            let contact = &model.contacts[index];
            if contact.release == Release::Force {
                // The next step finds a change of its state.
                continue;
            }
            let segment = &self.segments[index];
            let at = (self.cycle, time);
            let deflection = structure.deflection(model, segment, at, &self.state);
            let gap = contact.gap(segment, time.value());
            if contact.is_reached(deflection.value(), 0.0, gap) != self.contact.holds(index) {
                self.cross(index, time);
                // After a jump of line or gap, no contact is on a surface.
                self.crossed = ActiveSet::FREE;
            }
        }
    }

    /// Opens or closes a contact.
    fn cross(&mut self, contact: usize, time: DoubleDouble) {
        let from = self.contact;
        let model = self.extended.model;
        self.contact = model.toggled(from, contact);
        if model.is_slip(contact) {
            self.let_slide(from, time);
        }
        self.crossings.push(ExtendedCrossing {
            cycle: self.cycle,
            time,
            from,
            to: self.contact,
        });
    }

    /// Moves each slider whose stretch is within the round-off of doubles of its limit exactly to this limit.
    fn clamp_sliders(&mut self) {
        let model = self.extended.model;
        let at_limit = |slip: &usize| {
            let (segment, contact_data) = (&self.segments[*slip], &model.contacts[*slip]);
            let start = (self.cycle, DoubleDouble::ZERO);
            let stretch = self
                .extended
                .structure
                .deflection(model, segment, start, &self.state);
            let size = (self.state.iter())
                .fold(contact_data.half_gap, |most, x| x.value().abs().max(most));
            (contact_data.side * stretch.value() - contact_data.half_gap).abs() <= AT_LIMIT * size
        };
        let slips = model.sliders.iter().flat_map(|slider| slider.slips());
        let slips = slips
            .filter(at_limit)
            .fold(ActiveSet::FREE, ActiveSet::toggled);
        self.let_slide(slips, DoubleDouble::ZERO);
    }

    /// Moves each slider whose slip is among these contacts to the place where its spring has the limit force.
    fn let_slide(&mut self, slips: ActiveSet, time: DoubleDouble) {
        let Extended {
            model, structure, ..
        } = self.extended;
        for slider in &model.sliders {
            for slip in slider.slips().into_iter().filter(|slip| slips.holds(*slip)) {
                self.state[slider.block] = DoubleDouble::ZERO;
                let (segment, contact_data) = (&self.segments[slip], &model.contacts[slip]);
                let at = (self.cycle, time);
                let deflection = structure.deflection(model, segment, at, &self.state);
                let stretch = DoubleDouble::exact(contact_data.half_gap) * contact_data.side;
                self.state[slider.block] = deflection - stretch;
            }
        }
    }

    /// Takes one step, or the part up to the first event. Returns the time reached, at the model's speed, and the
    /// fraction of the step at the event; `None` without an event.
    fn step(
        &mut self,
        time: DoubleDouble,
        length: DoubleDouble,
    ) -> Result<(DoubleDouble, Option<DoubleDouble>), ReferenceError> {
        let extended = self.extended;
        let passed = [
            self.speed * length,
            length * length * (0.5 * extended.acceleration),
        ];
        let instant = Instant {
            cycle: self.cycle,
            time,
            passed,
            segments: &self.segments,
            contact: self.contact,
        };
        let series = extended.structure.expand(
            extended.model,
            &instant,
            &self.state,
            length,
            extended.order,
        );
        let mut terms = series.deflections.iter().flatten();
        if !terms.all(|d| d.value().is_finite()) {
            return Err(ReferenceError::NonFinite { cycle: self.cycle });
        }
        let first = self.first_event(&series, length)?;
        self.crossed = ActiveSet::FREE;
        self.forceless = ActiveSet::FREE;
        let Some((place, contact, met)) = first else {
            self.state = series.state_at(DoubleDouble::ONE);
            return Ok((time + passed[0] + passed[1], None));
        };
        self.state = series.state_at(place);
        let reached = time + place * (passed[0] + passed[1] * place);
        if met != StateEnd::Freedom {
            self.cross(contact, reached);
        }
        let changed = ActiveSet::FREE.toggled(contact);
        // If the event is at the start of the step, the push or the surface has jumped, and neither quantity
        // is zero.
        let stepped =
            self.extended.model.contacts[contact].release == Release::Force && place.value() == 0.0;
        match met {
            _ if stepped => {}
            StateEnd::Slide => {}
            StateEnd::Surface | StateEnd::Freedom => self.crossed = changed,
            StateEnd::NoForce => self.forceless = changed,
        }
        Ok((reached, Some(place)))
    }

    /// The first event on a step of some length \[s\]: its fraction of the step, its contact and its cause; `None`
    /// without an event.
    fn first_event(
        &self,
        series: &StepSeries,
        length: DoubleDouble,
    ) -> Result<Option<(DoubleDouble, usize, StateEnd)>, ReferenceError> {
        let model = self.extended.model;
        let mut first: Option<(DoubleDouble, usize, StateEnd)> = None;
        for (index, contact) in model.contacts.iter().enumerate() {
            let closed = self.contact.holds(index);
            if model.is_out_of_reach(index, &self.segments, self.contact) {
                continue;
            }
            if contact.release == Release::Stick {
                continue;
            }
            let indentation = self.indentation(index, series);
            if contact.release == Release::Slip {
                let margin = margin_of_slip(&indentation, contact.half_gap, closed);
                let zero = root::first_zero(&margin)
                    .map_err(|root::UndecidedTouch| ReferenceError::Touch { cycle: self.cycle })?;
                if let Some(place) = zero
                    && first.is_none_or(|(earlier, ..)| place < earlier)
                {
                    first = Some((place, index, StateEnd::Slide));
                }
                continue;
            }
            let by_force = contact.release == Release::Force;
            // A contact that opened by force is compressed until it is free.
            let compressed = by_force && !self.crossed.holds(index) && indentation[0].value() > 0.0;
            let mut margins: Vec<(Vec<DoubleDouble>, bool, StateEnd)> = Vec::new();
            let crossed = self.crossed.holds(index);
            let outside = || indentation.iter().map(|&d| -d).collect();
            if by_force && (closed || compressed) {
                let push = series.push(index, &indentation, length);
                let inside = if closed { 1.0 } else { -1.0 };
                let push = push.iter().map(|&f| f * inside).collect();
                margins.push((push, self.forceless.holds(index), StateEnd::NoForce));
                if !closed {
                    margins.push((indentation, false, StateEnd::Freedom));
                } else if !crossed && indentation[0].value() < 0.0 {
                    // After a jump of line or gap the closed contact is not compressed any more.
                    margins.push((indentation, false, StateEnd::Surface));
                }
            } else if closed {
                margins.push((indentation, crossed, StateEnd::Surface));
            } else {
                margins.push((outside(), crossed, StateEnd::Surface));
            }
            for (mut margin, known, met) in margins {
                if known {
                    // The last event left a zero at the start of the step: divide it out.
                    margin.remove(0);
                }
                let zero = root::first_zero(&margin)
                    .map_err(|root::UndecidedTouch| ReferenceError::Touch { cycle: self.cycle })?;
                if let Some(place) = zero
                    && first.is_none_or(|(earlier, ..)| place < earlier)
                {
                    first = Some((place, index, met));
                }
            }
        }
        Ok(first)
    }

    /// Coefficients of `s δ − b` of a contact on a step \[m\].
    fn indentation(&self, contact: usize, series: &StepSeries) -> Vec<DoubleDouble> {
        let model = self.extended.model;
        let contact_data = &model.contacts[contact];
        let line = model.line(&self.segments[contact]);
        let mut out: Vec<_> = (series.deflections[line].iter())
            .map(|&d| d * contact_data.side)
            .collect();
        out[0] += DoubleDouble::exact(-contact_data.half_gap);
        for (value, &gap_error) in out.iter_mut().zip(&series.gap_errors[contact]) {
            *value += gap_error * -1.0;
        }
        out
    }
}

/// The cause of the end of a contact's state.
#[derive(Debug, Clone, Copy, PartialEq)]
enum StateEnd {
    /// It reaches its surface, and opens or closes.
    Surface,
    /// The push of its spring and damper vanishes: it opens or closes again.
    NoForce,
    /// It leaves its surface after it opened by force. Its state stays open, and no force changes.
    Freedom,
    /// A slider reaches its limit, or the velocity of a slip becomes zero.
    Slide,
}

/// The margin of a slip of a dry slider, from the coefficients of its `s δ − b`. For a slipping slider it is
/// the velocity, for a sticking one the distance to the limit. Zeros at the start of the step, which an event
/// left, are divided out.
fn margin_of_slip(indentation: &[DoubleDouble], limit: f64, slips: bool) -> Vec<DoubleDouble> {
    let at_zero = |term: DoubleDouble| term.value().abs() <= LEFT_BY_AN_EVENT * limit;
    if slips {
        let rates = indentation.iter().enumerate().skip(1);
        let mut margin: Vec<_> = rates.map(|(j, &d)| d * j as f64).collect();
        if at_zero(margin[0]) {
            margin.remove(0);
        }
        return margin;
    }
    let mut margin: Vec<_> = indentation.iter().map(|&d| -d).collect();
    if at_zero(margin[0]) {
        margin.remove(0);
        if at_zero(margin[0]) {
            margin.remove(0);
        }
    }
    margin
}

#[cfg(test)]
mod tests;
