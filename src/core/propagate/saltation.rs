//! How does an event change tangent vectors?
//!
//! At the entry into contact, contact damping makes the vector field jump by `−g c δ'`. The saltation matrix
//! `I + (f⁺ − f⁻) wᵀ / δ'` (Leine & Nijmeijer 2004) is therefore `I − c g wᵀ` on entry and `I + c g wᵀ` on
//! release. It does not depend on the state. Its determinant is 1, because `w·g = 0`.

use crate::model::MeshGain;

/// Applies the saltation matrix to a tangent vector, given by its first and second components. Both have at
/// least one entry per gain. `damping` is c \[N s/m\] of the closed contact.
pub fn apply(
    gains: &[MeshGain],
    damping: f64,
    entering: bool,
    first: &mut [f64],
    second: &mut [f64],
) {
    let mut deflection = 0.0;
    for (gain, (x, y)) in gains.iter().zip(first.iter().zip(second.iter())) {
        deflection += gain.deflection[0] * x + gain.deflection[1] * y;
    }
    let kick = if entering { -damping } else { damping } * deflection;
    for (gain, (x, y)) in gains.iter().zip(first.iter_mut().zip(second)) {
        *x += kick * gain.mesh_input[0];
        *y += kick * gain.mesh_input[1];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Block;

    #[test]
    fn release_undoes_entry_and_positions_stay() {
        let gains = [
            MeshGain::mode(&Block::mode(0.0, 0.0, 0.0), 0.7, 0.7),
            MeshGain::mode(&Block::mode(100.0, 0.01, 0.0), -0.4, -0.5),
        ];
        let (mut q, mut v) = ([1.0, 2.0], [3.0, 4.0]);
        apply(&gains, 10.0, true, &mut q, &mut v);
        // δ = 0.7 − 0.8 = −0.1; v −= c g δ.
        assert_eq!(q, [1.0, 2.0]);
        assert!((v[0] - 3.7).abs() < 1e-14 && (v[1] - 3.5).abs() < 1e-14);
        apply(&gains, 10.0, false, &mut q, &mut v);
        assert!((v[0] - 3.0).abs() < 1e-14 && (v[1] - 4.0).abs() < 1e-14);
    }
}
