//! One mode as a real 2 × 2 block, and how the mesh meets it.

/// A real 2 × 2 block `x' = A x − g F + s`, contributing `w·x` to the mesh deflection; w and g
/// are its [`MeshGain`].
///
/// A mode with modal damping is the companion block `A = [0 1; −ω² −2ζω]`, `x = (q, q')`,
/// `g = (0, gᵢ)`, `w = (wᵢ, 0)`. Kernels rely on nothing but the block form, so that blocks
/// from a non-proportional damping or gyroscopic decomposition serve as well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Generator A \[1/s\], row by row.
    pub generator: [[f64; 2]; 2],
    /// Constant input s of the mean torques.
    pub static_input: [f64; 2],
}

impl Block {
    /// The companion block of a mode with natural frequency ω \[rad/s\] and damping ratio ζ.
    pub fn mode(frequency: f64, damping: f64, load: f64) -> Self {
        Self {
            generator: [
                [0.0, 1.0],
                [-frequency * frequency, -2.0 * damping * frequency],
            ],
            static_input: [0.0, load],
        }
    }

    /// Half the trace of A: minus the decay rate \[1/s\].
    pub fn growth(&self) -> f64 {
        0.5 * (self.generator[0][0] + self.generator[1][1])
    }

    /// Damped frequency ν ≥ 0 \[rad/s\] with `(A − growth I)² = −ν² I`; none where the
    /// block is overdamped (real, distinct eigenvalues).
    pub fn damped_frequency(&self) -> Option<f64> {
        let [a, b] = self.generator;
        let half = 0.5 * (a[0] - b[1]);
        let square = -(half * half + a[1] * b[0]);
        (square >= 0.0).then(|| square.sqrt())
    }

    /// The traceless part `M = A − growth I`, so that
    /// `exp(A t) = e^{growth t} (cos νt I + sin νt / ν M)`.
    pub fn traceless(&self) -> [[f64; 2]; 2] {
        let mu = self.growth();
        let [a, b] = self.generator;
        [[a[0] - mu, a[1]], [b[0], b[1] - mu]]
    }

    /// Undamped frequency `√det A` \[rad/s\].
    pub fn natural_frequency(&self) -> f64 {
        let [a, b] = self.generator;
        (a[0] * b[1] - a[1] * b[0]).max(0.0).sqrt()
    }
}

/// How the mesh meets a block while the line of action and the direction of friction stay as
/// they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshGain {
    /// Gain w of the mesh deflection.
    pub deflection: [f64; 2],
    /// Gain of the deflection rate, `w A`.
    pub rate: [f64; 2],
    /// Gain g of the mesh force; it enters with a minus sign.
    pub mesh_input: [f64; 2],
}

impl MeshGain {
    /// The gain of a block with deflection gain w and force gain g.
    pub fn new(block: &Block, deflection: [f64; 2], mesh_input: [f64; 2]) -> Self {
        let [a, b] = block.generator;
        let [w1, w2] = deflection;
        Self {
            deflection,
            rate: [w1 * a[0] + w2 * b[0], w1 * a[1] + w2 * b[1]],
            mesh_input,
        }
    }

    /// The gain of a companion block: participations in deflection and force.
    pub fn mode(block: &Block, deflection: f64, force: f64) -> Self {
        Self::new(block, [deflection, 0.0], [0.0, force])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mode_has_the_damped_frequency_of_the_textbook() {
        let block = Block::mode(10.0, 0.3, 0.0);
        assert!((block.growth() + 3.0).abs() < 1e-15);
        let nu = block.damped_frequency().unwrap();
        assert!((nu - 10.0 * (1.0f64 - 0.09).sqrt()).abs() < 1e-14);
        let m = block.traceless();
        let square = m[0][0] * m[0][0] + m[0][1] * m[1][0];
        assert!((square + nu * nu).abs() < 1e-12);
        assert_eq!(MeshGain::mode(&block, 1.0, 1.0).rate, [0.0, 1.0]);
    }

    #[test]
    fn rigid_rotation_has_frequency_zero_and_overdamped_has_none() {
        assert_eq!(Block::mode(0.0, 0.0, 0.0).damped_frequency(), Some(0.0));
        assert_eq!(Block::mode(1.0, 1.5, 0.0).damped_frequency(), None);
    }
}
