//! Random numbers for drives and inputs.

// Every test binary uses a part of it.
#![allow(dead_code)]

use gearatlas::numerics::random::Stream;

/// Random numbers from a seed.
pub struct Dice(pub Stream);

impl Dice {
    pub fn chance(&mut self, share: f64) -> bool {
        self.0.uniform() < share
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    /// Uniform over decades.
    pub fn decades(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(self.between(low, high))
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.0.uniform() * count as f64) as usize
    }

    pub fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }
}
