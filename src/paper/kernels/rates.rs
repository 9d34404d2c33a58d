//! Which motions of a structure and its mesh are slow?

use crate::model::{Block, Model};
use crate::propagate::Volterra;

/// Eigenvalues below this, per mesh period, are slow: splitting the constant input off a wave of rate λ loses a factor
/// (λT)⁻² of accuracy.
pub const SLOW: f64 = 0.5;

/// Usual limit of slow eigenvalues, relative to the fastest rate. It equals [`SLOW`] per mesh period if the period is
/// 2048 divided by the fastest rate. Practical drives have shorter periods.
const SLOWEST: f64 = SLOW / 2048.0;

/// Factor by which the limit is reduced, once or more, if the period is longer.
const LIMIT_REDUCTION: f64 = 64.0;

/// Waves may be slower than [`SLOW`] per mesh period by this factor. The table of that speed advances such waves with
/// the slow group and splits no constant input off them.
const WAVE_MARGIN: f64 = 8.0;

/// The two rates from which a [`Basis`](super::basis::Basis) of a structure and its mesh is made: one that scales, and
/// the limit between waves (damped sinusoids, which are diagonalised) and the slow group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// Upper bound of all rates \[rad/s\].
    pub fastest: f64,
    /// Eigenvalues below this are slow: they do not become waves \[rad/s\].
    pub slow: f64,
}

impl Rates {
    /// The rates of a model. They depend on its speed only if a mesh cycle exceeds 2048 / `fastest`, or if a mode is
    /// so slow that it would lose accuracy as a wave.
    pub fn new(model: &Model) -> Self {
        let fastest = Volterra::fastest_structure_rate(model);
        let limit = SLOW / model.period();
        let mut slow = SLOWEST * fastest;
        while slow > limit {
            slow /= LIMIT_REDUCTION;
        }
        let mut modes = model.blocks.iter().flat_map(eigenvalues);
        if modes.any(|rate| (slow..limit / WAVE_MARGIN).contains(&rate)) {
            slow = limit;
        }
        Self { fastest, slow }
    }
}

/// Absolute values of the eigenvalues of a block \[rad/s\].
fn eigenvalues(block: &Block) -> [f64; 2] {
    match block.spread() {
        Some(spread) => [-1.0, 1.0].map(|sign| (block.growth() + sign * spread).abs()),
        None => [block.natural_frequency(); 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::fixtures;
    use crate::model::OperatingPoint;

    /// Rates and mesh frequency \[1/s\] of a rigid pair with an elastic mode \[rad/s\] at a speed \[rad/s\].
    fn rates(frequency: f64, speed: f64) -> (Rates, f64) {
        let structure = fixtures::structure(&[0.0, frequency], 0.01, &[1.0, 0.3], &[1.0, 0.3]);
        let point = OperatingPoint { load: 0.1, speed };
        let model = Model::new(&structure, &fixtures::two_level_mesh(1e-5), point).unwrap();
        (Rates::new(&model), model.period().recip())
    }

    #[test]
    fn what_is_slow_does_not_depend_on_usual_speeds() {
        let (usual, _) = rates(3000.0, 1200.0);
        // The spring of the mesh with the mass of the pair alone has 2.1e4 rad/s.
        assert!(
            usual.fastest > 4.444e8f64.sqrt() && usual.fastest < 1e5,
            "{usual:?}"
        );
        assert_eq!(usual.slow, SLOW / 2048.0 * usual.fastest);
        assert_eq!(rates(3000.0, 300.0).0, usual);
    }

    #[test]
    fn nothing_is_slow_that_turns_half_a_radian_a_period() {
        let usual = rates(3000.0, 1200.0).0;
        for speed in [1.0, 0.1, 1e-3] {
            let (found, mesh) = rates(3000.0, speed);
            assert!(
                found.slow <= 0.5 * mesh && 64.0 * found.slow > 0.5 * mesh,
                "{found:?}"
            );
            let powers = (usual.slow / found.slow).log2() / 6.0;
            assert!(powers >= 1.0 && powers.fract() == 0.0, "{powers}");
        }
    }

    /// A mode more than eight times slower than half a radian per mesh period is slow. A mode 7.9 times slower is a
    /// wave.
    #[test]
    fn modes_slow_against_the_period_are_slow() {
        let (found, mesh) = rates(100.0, 1200.0);
        assert_eq!(found.slow, 0.5 / mesh.recip());
        let (found, mesh) = rates(0.5 * mesh / 7.9, 1200.0);
        assert!(found.slow < 0.4 * mesh, "{found:?}");
    }

    #[test]
    fn sizes_of_eigenvalues_are_those_of_a_mode() {
        let [slow, fast] = eigenvalues(&Block::mode(100.0, 1.25, 0.0));
        assert!((slow.min(fast) - 50.0).abs() < 1e-11 && (slow.max(fast) - 200.0).abs() < 1e-11);
        for size in eigenvalues(&Block::mode(100.0, 0.2, 0.0)) {
            assert!((size - 100.0).abs() < 1e-11);
        }
    }
}
