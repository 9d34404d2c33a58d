//! Advances a model from breakpoint to breakpoint and records its crossings.

use super::crossing::{Margin, first_crossing};
use super::gauss::{Compensated, GaussRule, StageWork};
use crate::model::{Contact, MeshGain, Model, Segment, Surface, TrajectoryState};

/// Stages of the rule: order 16.
const STAGES: usize = 8;

/// Most changes of contact state in one mesh cycle before the integration is given up.
pub(super) const CROSSING_LIMIT: u32 = 10_000;

/// A change of contact state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within the mesh cycle \[s\].
    pub time: f64,
    /// Contact state before.
    pub from: Contact,
    /// Contact state after.
    pub to: Contact,
    /// Rate of the deflection against the surface at the crossing, δ' − s b' \[m/s\].
    pub rate: f64,
}

/// What an integration leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Passage {
    /// The trajectory at its end.
    pub end: TrajectoryState,
    /// Every change of contact state, in order.
    pub crossings: Vec<Crossing>,
}

/// Why an integration was given up.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ReferenceError {
    /// The state became non-finite.
    #[error("the state became non-finite in mesh cycle {cycle}; check the model's parameters")]
    NonFinite {
        /// The mesh cycle.
        cycle: u64,
    },
    /// Contact chatters.
    #[error("more than {limit} changes of contact state in mesh cycle {cycle}")]
    Chatter {
        /// The mesh cycle.
        cycle: u64,
        /// The limit that was passed.
        limit: u32,
    },
    /// A surface is touched so closely that no arithmetic at hand tells a touch from a crossing.
    #[error("a surface is touched within the last digit in mesh cycle {cycle}")]
    Touch {
        /// The mesh cycle.
        cycle: u64,
    },
}

/// The independent integrator of one model.
#[derive(Debug, Clone)]
pub struct Reference<'m> {
    model: &'m Model,
    rule: GaussRule,
    /// Longest step \[s\].
    step: f64,
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
    /// [`ReferenceError`] where the state becomes non-finite or the contact chatters.
    pub fn advance(&self, start: &TrajectoryState, cycles: u64) -> Result<Passage, ReferenceError> {
        let n = start.state.len();
        let mut integration = Integration {
            reference: self,
            cycle: start.cycle,
            contact: start.contact,
            state: Compensated::new(start.state.clone()),
            moved: Compensated::new(vec![0.0; n]),
            work: StageWork::new(self.rule.stages(), n),
            samples: Vec::with_capacity(self.rule.stages() + 2),
            crossings: Vec::new(),
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

/// A rate \[1/s\] that bounds how fast anything in the model moves: natural frequencies with
/// the mesh spring and damper on top, decay, excitation.
pub(super) fn fastest_rate(model: &Model) -> f64 {
    let mut natural = 0.0f64;
    let mut decay = 0.0f64;
    // Σ |w·g| and Σ |w A·g|: what force does to the deflection's rate and acceleration.
    let (mut direct, mut inertial) = (0.0f64, 0.0f64);
    for block in &model.blocks {
        natural = natural.max(block.natural_frequency());
        decay = decay.max(block.growth().abs());
    }
    for gains in &model.directions {
        let dot = |a: [f64; 2], b: [f64; 2]| (a[0] * b[0] + a[1] * b[1]).abs();
        let sum = |row: fn(&MeshGain) -> [f64; 2]| -> f64 {
            gains
                .iter()
                .map(|gain| dot(row(gain), gain.mesh_input))
                .sum()
        };
        direct = direct.max(sum(|gain| gain.deflection));
        inertial = inertial.max(sum(|gain| gain.rate));
    }
    let stiffness = model.cycle.largest_stiffness();
    let damping = model
        .cycle
        .segments
        .iter()
        .map(|s| s.damping)
        .fold(0.0, f64::max);
    let structure =
        (natural * natural + stiffness * inertial).sqrt() + damping * inertial + stiffness * direct;
    let error = model.transmission_error.iter().map(|h| h.angular_frequency);
    let ripple = model.ripple.iter().map(|r| r.angular_frequency);
    error
        .chain(ripple)
        .fold(structure + 2.0 * decay, f64::max)
        // A free body has no rate of its own; the mesh cycle then sets the step.
        .max(1.0 / model.period())
}

/// An integration under way.
struct Integration<'r> {
    reference: &'r Reference<'r>,
    cycle: u64,
    contact: Contact,
    state: Compensated,
    /// The state at the end of a trial step.
    moved: Compensated,
    work: StageWork,
    samples: Vec<(f64, Margin)>,
    crossings: Vec<Crossing>,
}

impl Integration<'_> {
    fn one_cycle(&mut self) -> Result<(), ReferenceError> {
        let cycle = &self.reference.model.cycle;
        let mut changes = 0;
        for (index, segment) in cycle.segments.iter().enumerate() {
            let mut time = cycle.start(index);
            let end = cycle.end(index);
            if cycle.turns(index) {
                self.turn(segment, time);
            }
            while time < end {
                time = self.smooth_piece(segment, time, end, &mut changes)?;
            }
        }
        self.cycle += 1;
        Ok(())
    }

    /// Takes up a new direction and half gap, where the contact state may step.
    fn turn(&mut self, segment: &Segment, time: f64) {
        let model = self.reference.model;
        let (deflection, rate) = model.deflection_on(segment, &self.state.value, time);
        let target = Contact::classify(deflection, rate, model.gap_on(segment, time));
        while let Some(surface) = self.contact.towards(target) {
            let from = self.contact;
            self.contact = from.across(surface);
            self.crossings.push(Crossing {
                cycle: self.cycle,
                time,
                from,
                to: self.contact,
                rate,
            });
        }
    }

    /// Advances to the end of the segment or to the next crossing; gives the time reached.
    fn smooth_piece(
        &mut self,
        segment: &Segment,
        start: f64,
        end: f64,
        changes: &mut u32,
    ) -> Result<f64, ReferenceError> {
        let steps = ((end - start) / self.reference.step).ceil().max(1.0);
        let at = |j: f64| {
            if j == steps {
                end
            } else {
                start + (end - start) * (j / steps)
            }
        };
        let mut j = 0.0;
        while j < steps {
            let (left, right) = (at(j), at(j + 1.0));
            if let Some(crossing) = self.step(segment, left, right)? {
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

    /// One step from `left` to `right`, or to the first crossing, whose time is given.
    fn step(
        &mut self,
        segment: &Segment,
        left: f64,
        right: f64,
    ) -> Result<Option<f64>, ReferenceError> {
        let h = right - left;
        let model = self.reference.model;
        let (deflection, rate) = self.advance(segment, left, h);
        if !(deflection + rate).is_finite() {
            return Err(ReferenceError::NonFinite { cycle: self.cycle });
        }
        self.sample(segment, left, h, (deflection, rate));

        // Half a unit in the last place of a mesh period.
        let resolution = model.period() * 2f64.powi(-54);
        let contact = self.contact;
        let samples = std::mem::take(&mut self.samples);
        let mut probed = false;
        let found = first_crossing(&samples, resolution, |tau| {
            probed = true;
            let (deflection, rate) = self.advance(segment, left, tau);
            Margin::new(contact, deflection, rate, model.gap_on(segment, left + tau))
        });
        self.samples = samples;

        let reached = match found {
            // The crossing's time as it can be told: the state goes with the rounded one.
            Some(tau) => left + tau,
            None => right,
        };
        let (deflection, rate) = if probed {
            self.advance(segment, left, reached - left)
        } else {
            (deflection, rate)
        };
        self.state.copy_from(&self.moved);
        if found.is_none() {
            return Ok(None);
        }
        let surface = if deflection > 0.0 {
            Surface::Drive
        } else {
            Surface::Coast
        };
        let to = contact.across(surface);
        let [_, opening] = model.gap_on(segment, reached);
        self.crossings.push(Crossing {
            cycle: self.cycle,
            time: reached,
            from: contact,
            to,
            rate: rate - surface.sign() * opening,
        });
        self.contact = to;
        Ok(Some(reached))
    }

    /// Sets `moved` to the state after `tau` from `left` and gives its deflection and rate.
    fn advance(&mut self, segment: &Segment, left: f64, tau: f64) -> (f64, f64) {
        let model = self.reference.model;
        let rule = &self.reference.rule;
        let (contact, cycle) = (self.contact, self.cycle);
        rule.solve(
            &self.state.value,
            tau,
            &mut self.work,
            |fraction, state, out| {
                model.derivative(segment, contact, cycle, left + fraction * tau, state, out);
            },
        );
        self.moved.copy_from(&self.state);
        for i in 0..self.state.value.len() {
            self.moved.add(i, rule.increment(&self.work, tau, i));
        }
        model.deflection_on(segment, &self.moved.value, left + tau)
    }

    /// Collects the margin at the start, the stages and the end of the step just solved.
    fn sample(&mut self, segment: &Segment, left: f64, h: f64, end: (f64, f64)) {
        let model = self.reference.model;
        let n = self.state.value.len();
        let margin = |tau: f64, (deflection, rate)| {
            let gap = model.gap_on(segment, left + tau);
            Margin::new(self.contact, deflection, rate, gap)
        };
        self.samples.clear();
        self.samples.push((
            0.0,
            margin(0.0, model.deflection_on(segment, &self.state.value, left)),
        ));
        for (i, c) in self.reference.rule.nodes.iter().enumerate() {
            let stage = &self.work.states[i * n..(i + 1) * n];
            self.samples.push((
                c * h,
                margin(c * h, model.deflection_on(segment, stage, left + c * h)),
            ));
        }
        self.samples.push((h, margin(h, end)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::OperatingPoint;
    use crate::model::fixtures::{constant_mesh, one_mode};
    use crate::shaft::ModalStructure;

    fn model(frequency: f64, stiffness: f64) -> Model {
        let structure = ModalStructure {
            mesh: vec![2.0],
            ..one_mode(frequency)
        };
        let point = OperatingPoint {
            load: 1.0,
            speed: 1.0,
        };
        Model::new(&structure, &constant_mesh(1.0, stiffness), point).unwrap()
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
