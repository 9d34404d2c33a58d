//! The trajectory to about 30 digits: how large are the errors of everything else?
//!
//! Between breakpoints and events the system is linear, its stiffness and its half gap are
//! polynomials (mostly constants) and its inputs harmonic, so its Taylor series follows from itself. With `u = t/h` on a step of length h,
//!
//! ```text
//! x(u) = Σ X_j u^j,   X_{j+1} = h/(j+1) (A X_j − g F_j + s_j)
//! F_j  = Σ_m k_m (δ_{j−m} − s b_{j−m}) + c (δ'_j − s b'_j)
//! ```
//!
//! in numbers of two doubles each. Steps are a radian of the fastest rate, so that the terms
//! left out are below 1/31! ≈ 1e-34. The series of δ gives every change of contact state; its
//! first zero is proved by signs (`root`), and each step restarts from exact breakpoints. The
//! parameters of the [`Model`](crate::model::Model) are taken as exact.

mod double_double;
mod root;
mod series;

pub use double_double::DoubleDouble;

use super::ReferenceError;
use super::integrator::{CROSSING_LIMIT, fastest_rate};
use crate::model::{Contact, Model, Segment, Surface, TrajectoryState};
use series::{Instant, StepSeries, Structure};

/// Terms of the series on a step: X₀ … X₃₀.
const ORDER: usize = 30;

/// Extended-precision integrator of one model.
#[derive(Debug, Clone)]
pub struct Extended<'m> {
    model: &'m Model,
    structure: Structure,
    order: usize,
    /// Longest step \[s\].
    step: f64,
}

/// A change of contact state, its time to all digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtendedCrossing {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within the mesh cycle \[s\].
    pub time: DoubleDouble,
    /// Contact state before.
    pub from: Contact,
    /// Contact state after.
    pub to: Contact,
}

/// What an extended integration leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtendedPassage {
    /// State at the end: first components of all blocks, then second components, length 2N.
    pub state: Vec<DoubleDouble>,
    /// Contact state at the end.
    pub contact: Contact,
    /// Mesh cycles since the start of the simulation.
    pub cycle: u64,
    /// Every change of contact state, in order.
    pub crossings: Vec<ExtendedCrossing>,
}

impl ExtendedPassage {
    /// Differences `state − end` of a state in doubles, not rounded before they are taken.
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

    /// The integrator with another number of terms ≥ 2, by which its order can be seen.
    pub fn with_order(model: &'m Model, order: usize) -> Self {
        Self {
            model,
            structure: Structure::new(model),
            order: order.max(2),
            step: 1.0 / fastest_rate(model),
        }
    }

    /// The same integrator with steps `factor` ≥ 1 times shorter.
    pub fn refined(mut self, factor: u32) -> Self {
        self.step /= f64::from(factor.max(1));
        self
    }

    /// Advances `cycles` whole mesh cycles from `start`, whose doubles are taken as exact.
    ///
    /// # Errors
    /// [`ReferenceError`] where the state becomes non-finite, the contact chatters, or a
    /// surface is touched within the last digit, so that no sequence of events is certain.
    pub fn advance(
        &self,
        start: &TrajectoryState,
        cycles: u64,
    ) -> Result<ExtendedPassage, ReferenceError> {
        let mut integration = Integration {
            extended: self,
            cycle: start.cycle,
            contact: start.contact,
            crossed: None,
            state: start
                .state
                .iter()
                .map(|&x| DoubleDouble::exact(x))
                .collect(),
            crossings: Vec::new(),
        };
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

/// An integration under way.
struct Integration<'e> {
    extended: &'e Extended<'e>,
    cycle: u64,
    contact: Contact,
    /// Surface the trajectory stands on, right after an event.
    crossed: Option<Surface>,
    state: Vec<DoubleDouble>,
    crossings: Vec<ExtendedCrossing>,
}

impl Integration<'_> {
    fn one_cycle(&mut self) -> Result<(), ReferenceError> {
        let cycle = &self.extended.model.cycle;
        let boundary = |phase: f64| DoubleDouble::product(cycle.period, phase);
        let mut met = 0;
        for (index, segment) in cycle.segments.iter().enumerate() {
            let mut time = boundary(segment.start);
            let end = boundary(segment.end);
            if cycle.turns(index) {
                self.turn(segment, time);
            }
            while time < end {
                let rest = end - time;
                let steps = (rest.value() / self.extended.step).ceil().max(1.0);
                let length = rest / DoubleDouble::exact(steps);
                match self.step(index, time, length)? {
                    Some(crossing) => {
                        time = crossing;
                        met += 1;
                    }
                    None if steps == 1.0 => time = end,
                    None => time += length,
                }
                if met > CROSSING_LIMIT {
                    return Err(ReferenceError::Chatter {
                        cycle: self.cycle,
                        limit: CROSSING_LIMIT,
                    });
                }
            }
        }
        self.cycle += 1;
        Ok(())
    }

    /// Takes up a new direction and half gap, where the contact state may step.
    fn turn(&mut self, segment: &Segment, time: DoubleDouble) {
        let Extended {
            model, structure, ..
        } = self.extended;
        let deflection = structure.deflection(model, segment, time, &self.state);
        let gap = model.gap_on(segment, time.value());
        let target = Contact::classify(deflection.value(), 0.0, gap);
        while let Some(surface) = self.contact.towards(target) {
            let from = self.contact;
            self.contact = from.across(surface);
            // Nothing stands on a surface after a step over it.
            self.crossed = None;
            self.crossings.push(ExtendedCrossing {
                cycle: self.cycle,
                time,
                from,
                to: self.contact,
            });
        }
    }

    /// One step, or to the first event, whose time is given.
    fn step(
        &mut self,
        segment: usize,
        time: DoubleDouble,
        length: DoubleDouble,
    ) -> Result<Option<DoubleDouble>, ReferenceError> {
        let extended = self.extended;
        let instant = Instant {
            cycle: self.cycle,
            time,
            segment: &extended.model.cycle.segments[segment],
            contact: self.contact,
        };
        let series = extended.structure.expand(
            extended.model,
            &instant,
            &self.state,
            length,
            extended.order,
        );
        if !series.deflection.iter().all(|d| d.value().is_finite()) {
            return Err(ReferenceError::NonFinite { cycle: self.cycle });
        }
        let Some((place, surface)) = self.first_event(&series)? else {
            self.state = series.state_at(DoubleDouble::ONE);
            self.crossed = None;
            return Ok(None);
        };
        self.state = series.state_at(place);
        let (from, to) = (self.contact, self.contact.across(surface));
        let reached = time + length * place;
        self.crossings.push(ExtendedCrossing {
            cycle: self.cycle,
            time: reached,
            from,
            to,
        });
        self.contact = to;
        self.crossed = Some(surface);
        Ok(Some(reached))
    }

    /// The first place of a step where its contact state ends, and through which surface.
    fn first_event(
        &self,
        series: &StepSeries,
    ) -> Result<Option<(DoubleDouble, Surface)>, ReferenceError> {
        // Margin: side·δ + outside·b, positive inside the contact state.
        let half_gap = self.extended.model.half_gap;
        let margins: &[(Surface, f64, f64)] = match self.contact {
            Contact::Drive => &[(Surface::Drive, 1.0, -1.0)],
            Contact::Coast => &[(Surface::Coast, -1.0, -1.0)],
            Contact::Free => &[(Surface::Drive, -1.0, 1.0), (Surface::Coast, 1.0, 1.0)],
        };
        let mut first: Option<(DoubleDouble, Surface)> = None;
        for &(surface, side, outside) in margins {
            let mut margin: Vec<_> = series.deflection.iter().map(|&d| d * side).collect();
            margin[0] += DoubleDouble::exact(outside * half_gap);
            for (margin, &lack) in margin.iter_mut().zip(&series.lack) {
                *margin += lack * outside;
            }
            if self.crossed == Some(surface) {
                // The event's own zero is divided out.
                margin.remove(0);
            }
            let zero = root::first_zero(&margin)
                .map_err(|root::Undecided| ReferenceError::Touch { cycle: self.cycle })?;
            if let Some(place) = zero
                && first.is_none_or(|(earlier, _)| place < earlier)
            {
                first = Some((place, surface));
            }
        }
        Ok(first)
    }
}

#[cfg(test)]
mod tests;
