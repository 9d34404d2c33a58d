//! Where does the motion pierce the strobe plane?

use super::outcome::PoincareSample;
use crate::model::{Model, TrajectoryState};

/// The last strobe samples at mesh phase 0.
#[derive(Debug, Clone)]
pub struct Poincare {
    keep: usize,
    samples: Vec<PoincareSample>,
    next: usize,
}

impl Poincare {
    /// Keeps the last `keep` samples.
    pub fn new(keep: usize) -> Self {
        Self {
            keep,
            samples: Vec::with_capacity(keep),
            next: 0,
        }
    }

    /// Notes a trajectory at the start of a mesh cycle.
    pub fn push(&mut self, model: &Model, trajectory: &TrajectoryState) {
        let (deflection, velocity) = model.deflection(&trajectory.state, 0.0);
        let sample = PoincareSample {
            cycle: trajectory.cycle,
            deflection,
            velocity,
        };
        if self.samples.len() < self.keep {
            self.samples.push(sample);
        } else if self.keep > 0 {
            self.samples[self.next] = sample;
            self.next = (self.next + 1) % self.keep;
        }
    }

    /// Forgets all samples.
    pub fn restart(&mut self) {
        self.samples.clear();
        self.next = 0;
    }

    /// The samples kept, oldest first.
    pub fn into_samples(mut self) -> Vec<PoincareSample> {
        self.samples.rotate_left(self.next);
        self.samples
    }
}
