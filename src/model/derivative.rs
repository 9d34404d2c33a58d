//! How does a model change with a parameter?
//!
//! Everything a model says in numbers is differentiated, segment by segment, at fixed mesh phase:
//! differences of whole models, whichever way they were built. What the numbers then do to a
//! trajectory is no longer a matter of differences ([`crate::analysis::sensitivity`]).

use super::{Model, Segment};

/// Why models of neighbouring values of a parameter cannot be told from one another number by
/// number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the {what} of the model change with it")]
pub struct ShapeChange {
    /// What is not the same.
    pub what: &'static str,
}

impl Model {
    /// A weighted sum of the numbers of models, `Σ weight · model`, with the shape of the first: a
    /// derivative where the weights are those of a difference quotient. Frequencies of harmonics
    /// are left alone: at fixed mesh phase they do not count.
    ///
    /// # Errors
    /// [`ShapeChange`] where they have not the same segments, directions, contacts and harmonics.
    pub fn combined(models: &[(f64, &Self)]) -> Result<Self, ShapeChange> {
        let mut sum = models[0].1.unchanged();
        for &(weight, model) in models {
            same_shape(&sum, model)?;
            let mut numbers = Vec::new();
            model
                .clone()
                .each_number(&mut |number| numbers.push(*number));
            let mut numbers = numbers.into_iter();
            sum.each_number(&mut |number| *number += weight * numbers.next().unwrap_or(0.0));
        }
        Ok(sum)
    }

    /// The derivative by what nothing depends on: all numbers are zero.
    pub fn unchanged(&self) -> Self {
        let mut still = self.clone();
        still.each_number(&mut |number| *number = 0.0);
        still
    }

    /// Visits every number that may depend on a parameter, always in the same order.
    fn each_number(&mut self, visit: &mut impl FnMut(&mut f64)) {
        for block in &mut self.blocks {
            block
                .generator
                .as_flattened_mut()
                .iter_mut()
                .for_each(&mut *visit);
            block.static_input.iter_mut().for_each(&mut *visit);
        }
        for share in self.directions.iter_mut().flat_map(|d| &mut d.on_bearings) {
            visit(share);
        }
        for gain in self.directions.iter_mut().flat_map(|d| &mut d.gains) {
            let all = [&mut gain.deflection, &mut gain.rate, &mut gain.mesh_input];
            all.into_iter().flatten().for_each(&mut *visit);
        }
        for harmonic in self
            .lines
            .iter_mut()
            .flat_map(|line| &mut line.transmission_error)
        {
            visit(&mut harmonic.amplitude);
            visit(&mut harmonic.phase);
        }
        for contact in &mut self.contacts {
            visit(&mut contact.half_gap);
            for cycle in &mut contact.cycles {
                visit(&mut cycle.period);
                for segment in &mut cycle.segments {
                    visit(&mut segment.start);
                    visit(&mut segment.end);
                    segment
                        .stiffness
                        .coefficients_mut()
                        .iter_mut()
                        .for_each(&mut *visit);
                    segment
                        .error
                        .coefficients_mut()
                        .iter_mut()
                        .for_each(&mut *visit);
                    visit(&mut segment.damping);
                }
            }
        }
        for ripple in &mut self.ripple {
            visit(&mut ripple.phase);
            ripple
                .input
                .as_flattened_mut()
                .iter_mut()
                .for_each(&mut *visit);
        }
        for bearing in &mut self.bearings {
            bearing
                .gain
                .as_flattened_mut()
                .iter_mut()
                .for_each(&mut *visit);
            visit(&mut bearing.constant);
            bearing.by_ripple.iter_mut().for_each(&mut *visit);
        }
        for output in &mut self.outputs {
            output
                .gain
                .as_flattened_mut()
                .iter_mut()
                .for_each(&mut *visit);
        }
        visit(&mut self.half_gap);
        visit(&mut self.effective_mass);
    }
}

fn same_shape(a: &Model, b: &Model) -> Result<(), ShapeChange> {
    let differ = |what| Err(ShapeChange { what });
    if a.blocks.len() != b.blocks.len() || a.neutral != b.neutral {
        return differ("modes");
    }
    let lines = |model: &Model| model.directions.iter().map(|d| d.line).collect::<Vec<_>>();
    if lines(a) != lines(b) {
        return differ("lines of action");
    }
    let turns = |model: &Model| -> Vec<f64> {
        let errors = model.transmission_errors().map(|h| h.turns_per_cycle);
        errors
            .chain(model.ripple.iter().map(|r| r.turns_per_cycle))
            .collect()
    };
    if turns(a) != turns(b) {
        return differ("orders of the excitation");
    }
    let directions = |segments: &[Segment]| -> Vec<usize> {
        segments.iter().map(|segment| segment.direction).collect()
    };
    let cycles = |model: &Model| -> Vec<Vec<usize>> {
        let all = model.contacts.iter().flat_map(|contact| &contact.cycles);
        all.map(|cycle| directions(&cycle.segments)).collect()
    };
    let laws = |model: &Model| -> Vec<_> {
        let contacts = model.contacts.iter();
        contacts
            .map(|c| (c.side.to_bits(), c.release, c.cycles.len()))
            .collect()
    };
    if laws(a) != laws(b) {
        return differ("contacts");
    }
    if cycles(a) != cycles(b) {
        return differ("segments of the mesh cycle");
    }
    Ok(())
}

impl Segment {
    /// Derivatives, at fixed mesh phase, of the stiffness \[N/m\] and of what loaded flanks lack
    /// \[m\] at a phase within the segment, per unit of the parameter that `by` is the derivative by.
    pub fn change_at(&self, by: &Self, phase: f64) -> [f64; 2] {
        let x = self.place(phase);
        let length = self.end - self.start;
        // The segment's ends move, and with them the place of the phase.
        let moved = -(by.start + by.end + x * (by.end - by.start)) / length;
        let slope = |series: &[f64; super::STIFFNESS_TERMS]| {
            crate::numerics::legendre::evaluate(&crate::numerics::legendre::derivative(series), x)
        };
        [
            by.stiffness.at(x) + slope(self.stiffness.coefficients()) * moved,
            by.error.at(x) + slope(self.error.coefficients()) * moved,
        ]
    }
}
