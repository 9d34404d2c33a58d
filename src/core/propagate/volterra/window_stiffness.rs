//! What is the solution operator of a window in a given segment?

use super::feedback::Feedback;
use super::lanes;
use super::shapes::{Row, TERMS};
use super::varying::{Factors, Nodal};
use crate::model::{Model, Segment, Stiffness};
use crate::numerics::legendre::transforms24;
use crate::propagate::vectors::InstructionSet;

/// Stiffness and damping of a contact on a window, and the position of the window in the segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowStiffness {
    /// Stiffness of the segment.
    pub stiffness: Stiffness,
    /// Contact damping c \[N s/m\].
    pub damping: f64,
    /// Positions of the window's start and end in the segment, which is \[−1, 1\]. The same for all windows if the
    /// stiffness is constant.
    span: [f64; 2],
}

impl WindowStiffness {
    /// Stiffness and damping for a window of length `delta` \[s\] that starts at `time` \[s\] in a segment.
    pub fn new(model: &Model, segment: &Segment, time: f64, delta: f64) -> Self {
        let stiffness = segment.stiffness;
        let place = |time: f64| segment.place(time / model.period());
        let span = if stiffness.is_constant() {
            [-1.0, 1.0]
        } else {
            [place(time), place(time + delta)]
        };
        Self {
            stiffness,
            damping: segment.damping,
            span,
        }
    }

    /// Whether the stiffness varies.
    pub fn varies(&self) -> bool {
        !self.stiffness.is_constant()
    }

    /// Factorises the window's system.
    pub fn factorise(&self, set: InstructionSet, nodal: &Nodal, out: &mut Factors) {
        let [start, end] = self.span;
        let nodes = (transforms24().nodes()).map(|x| 0.5 * ((end - start) * x + (start + end)));
        let stiffness = self.stiffness.coefficients();
        lanes::factorise(set, nodal, stiffness, &nodes, self.damping, out);
    }

    /// The solution operator of the window with a varying stiffness. Overwrites `factors` with those of its system.
    pub fn feedback(&self, set: InstructionSet, nodal: &Nodal, factors: &mut Factors) -> Feedback {
        self.factorise(set, nodal, factors);
        let (mut to_force, mut to_deflection) = ([Row::ZERO; TERMS], [Row::ZERO; TERMS]);
        for (j, (force, deflection)) in to_force.iter_mut().zip(&mut to_deflection).enumerate() {
            let mut free = Row::ZERO;
            free.0[j] = 1.0;
            *force = lanes::force(set, nodal, factors, &free, 0.0);
            *deflection = lanes::deflection(set, nodal, &free, force);
        }
        let gap = lanes::force(set, nodal, factors, &Row::ZERO, 1.0);
        Feedback {
            force: to_force,
            deflection: to_deflection,
            gap: [gap, lanes::deflection(set, nodal, &Row::ZERO, &gap)],
        }
    }
}
