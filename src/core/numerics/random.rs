//! Random streams that depend only on given numbers, not on the scheduling of threads.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// A stream of random deviates. The numbers (seed, point, probe) determine it.
pub struct Stream(Pcg64);

/// The numbers of a point that determine its random streams.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PointSeed {
    /// Seed of all random streams of a job.
    pub seed: u64,
    /// Number of the point.
    pub point_id: u64,
}

impl PointSeed {
    /// The stream of the point with a number.
    pub fn stream(self, number: u64) -> Stream {
        Stream::new(self.seed, self.point_id, number)
    }
}

impl Stream {
    /// The stream of a point and a probe for a seed of the job.
    pub fn new(seed: u64, point: u64, probe: u64) -> Self {
        let mut bytes = [0; 32];
        // The second half of the bytes is the generator's increment, whose lowest bit is always set. An even
        // probe number in this half would give the same stream as the next odd one. The number is therefore
        // rotated by one bit, and its lowest bit is moved to the last word.
        let probe = probe.rotate_left(1);
        let [low, high] = [probe & !1, 0x617c << 1 | probe & 1];
        for (chunk, value) in bytes.chunks_exact_mut(8).zip([seed, point, low, high]) {
            chunk.copy_from_slice(&value.to_le_bytes());
        }
        let mut generator = Pcg64::from_seed(bytes);
        // Seeds that differ in a few bits give correlated first outputs: discard them.
        for _ in 0..16 {
            generator.next_u64();
        }
        Self(generator)
    }

    /// A uniform deviate on (0, 1).
    pub fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) * (-53f64).exp2()
    }

    /// A standard normal deviate (Box & Muller 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_repeatable_and_apart() {
        let draw = |s, p, q| Stream::new(s, p, q).uniform();
        assert_eq!(draw(1, 2, 3).to_bits(), draw(1, 2, 3).to_bits());
        for probe in [2, 4, 3 + (1 << 63)] {
            assert_ne!(draw(1, 2, 3).to_bits(), draw(1, 2, probe).to_bits());
        }
        assert_ne!(draw(1, 2, 3).to_bits(), draw(1, 3, 3).to_bits());
        assert_ne!(draw(1, 2, 3).to_bits(), draw(2, 2, 3).to_bits());
    }

    #[test]
    fn deviates_have_the_moments_of_a_normal() {
        let mut stream = Stream::new(7, 0, 0);
        let values: Vec<f64> = (0..100_000).map(|_| stream.normal()).collect();
        let mean = values.iter().sum::<f64>() / 1e5;
        let square = values.iter().map(|v| v * v).sum::<f64>() / 1e5;
        // Five standard errors: 1/√n and √2/√n.
        assert!(mean.abs() < 5.0 / 1e5f64.sqrt());
        assert!((square - 1.0).abs() < 5.0 * (2.0 / 1e5f64).sqrt());
    }
}
