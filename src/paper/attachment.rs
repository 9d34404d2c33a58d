//! Residual attachment modes: dynamic replacements for the modes that a reduction leaves out (Appendix C; Ding et al.
//! 2020).
//!
//! Residual flexibility treats the omitted modes as massless. An attachment mode is their static shape under the mesh
//! force, `v₁ = Λ⁻¹ w` in modal coordinates, with `Λ = diag(ω²)` and their participation `w` at the mesh. Higher orders
//! correct for inertia, `vₖ = Λ⁻¹ vₖ₋₁`. The Ritz modes of the structure in the span of all vₖ replace the omitted
//! modes. With p attachment modes the receptance at the mesh keeps 2p terms of its series in the frequency f of
//! excitation, `Σ w² / ω²ʲ` for j = 1 … 2p, so that its error is of order f⁴ᵖ. Residual flexibility keeps one term.

use faer::Mat;
use gearatlas_core::numerics::linalg::symmetric_eigen;
use gearatlas_core::structure::{ModalStructure, ModeCount};

/// The `retained` lowest modes of a structure and `count` attachment modes for the rest.
///
/// The result keeps loads on the shafts and one line of action. It drops further contacts, couplings, bearing forces,
/// torques and motions of places.
///
/// # Errors
/// [`ModeCount`] unless `max(1, rigid modes) ≤ retained` and `retained + count ≤ modes`.
pub fn with_attachment_modes(
    structure: &ModalStructure,
    retained: usize,
    count: usize,
) -> Result<ModalStructure, ModeCount> {
    let mut reduced = structure.truncated(retained, false)?;
    let rest = structure.modes() - retained;
    if count > rest {
        return Err(ModeCount {
            requested: retained + count,
            least: structure.rigid_modes().max(1),
            available: structure.modes(),
        });
    }
    let stiffness: Vec<f64> = (structure.frequency[retained..].iter())
        .map(|omega| omega * omega)
        .collect();
    let (squares, shapes) = ritz(&stiffness, &structure.mesh[retained..], count);
    let append = |column: &mut Vec<f64>, full: &[f64]| {
        let project = |shape: &Vec<f64>| -> f64 {
            shape
                .iter()
                .zip(&full[retained..])
                .map(|(v, x)| v * x)
                .sum()
        };
        if !full.is_empty() {
            column.extend(shapes.iter().map(project));
        }
    };
    append(&mut reduced.mesh, &structure.mesh);
    append(&mut reduced.mesh_tilt, &structure.mesh_tilt);
    append(&mut reduced.torque, &structure.torque);
    append(&mut reduced.friction, &structure.friction);
    append(&mut reduced.friction_lever, &structure.friction_lever);
    append(&mut reduced.constant_load, &structure.constant_load);
    append(&mut reduced.load_by_speed, &structure.load_by_speed);
    for (column, full) in [
        (&mut reduced.pinion_torque, &structure.pinion_torque),
        (&mut reduced.wheel_torque, &structure.wheel_torque),
    ] {
        if let (Some(column), Some(full)) = (column, full) {
            append(column, full);
        }
    }
    for (load, full) in reduced
        .harmonic_loads
        .iter_mut()
        .zip(&structure.harmonic_loads)
    {
        append(&mut load.force, &full.force);
    }
    for (square, shape) in squares.iter().zip(&shapes) {
        let omega = square.sqrt();
        // Half of vᵀ diag(2 ζ ω) v.
        let decay: f64 = (shape.iter().zip(&structure.damping[retained..]))
            .zip(&structure.frequency[retained..])
            .map(|((v, zeta), omega)| v * v * zeta * omega)
            .sum();
        reduced.frequency.push(omega);
        reduced.damping.push(decay / omega);
    }
    reduced.coast = None;
    reduced.coupling = None;
    reduced.contacts.clear();
    reduced.bearings.clear();
    reduced.torques.clear();
    reduced.motions.clear();
    Ok(reduced)
}

/// Ritz values, ascending, and orthonormal Ritz vectors of `Λ = diag(stiffness)` in the span of `Λ⁻¹ w, Λ⁻² w, …`.
fn ritz(stiffness: &[f64], w: &[f64], count: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut next = w.to_vec();
    for _ in 0..count {
        for (x, k) in next.iter_mut().zip(stiffness) {
            *x /= k;
        }
        // Two passes of orthogonalisation are enough.
        for _ in 0..2 {
            for known in &basis {
                let along = dot(known, &next);
                next.iter_mut()
                    .zip(known)
                    .for_each(|(x, v)| *x -= along * v);
            }
            let size = dot(&next, &next).sqrt();
            next.iter_mut().for_each(|x| *x /= size);
        }
        basis.push(next.clone());
    }
    let projected = Mat::from_fn(count, count, |i, j| {
        let terms = basis[i].iter().zip(&basis[j]).zip(stiffness);
        terms.map(|((a, b), k)| a * k * b).sum()
    });
    let Some((squares, turns)) = symmetric_eigen(&projected) else {
        return (Vec::new(), Vec::new());
    };
    let shape = |mode: usize| -> Vec<f64> {
        let entry = |i: usize| (0..count).map(|j| basis[j][i] * turns[(j, mode)]).sum();
        (0..stiffness.len()).map(entry).collect()
    };
    (squares, (0..count).map(shape).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn structure() -> ModalStructure {
        let frequency: Vec<f64> = (0..12).map(|i| 900.0 * f64::from(i * i)).collect();
        let mesh: Vec<f64> = (0..12).map(|i| 0.3 + 0.1 * f64::from(i % 5)).collect();
        ModalStructure::of_modes(&frequency, 0.02, &mesh, &mesh)
    }

    /// Σ w²/(ω² − Ω²) of the modes from index `from` on.
    fn receptance(structure: &ModalStructure, from: usize, omega: f64) -> f64 {
        let modes = structure.frequency[from..]
            .iter()
            .zip(&structure.mesh[from..]);
        modes.map(|(f, w)| w * w / (f * f - omega * omega)).sum()
    }

    /// One attachment mode has the flexibility of the modes left out, and the inertia of their static shape.
    #[test]
    fn one_mode_is_the_static_shape() {
        let full = structure();
        let reduced = with_attachment_modes(&full, 4, 1).unwrap();
        let sum = |power: i32| -> f64 {
            let left = full.frequency[4..].iter().zip(&full.mesh[4..]);
            left.map(|(omega, w)| w * w / omega.powi(power)).sum()
        };
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-13, "{a} {b}");
        assert_eq!(reduced.modes(), 5);
        near(reduced.frequency[4].powi(2), sum(2) / sum(4));
        near(reduced.mesh[4], sum(2) / sum(4).sqrt());
        near(reduced.torque[4], reduced.mesh[4]);
        near(receptance(&reduced, 4, 0.0), sum(2));
        // 2 ζ ω of equal ratios, weighted with the squares of the shape w/ω².
        let weighted: f64 = (full.frequency[4..].iter().zip(&full.mesh[4..]))
            .map(|(omega, w)| 0.02 * w * w / omega.powi(3))
            .sum();
        near(reduced.damping[4] * reduced.frequency[4], weighted / sum(4));
    }

    /// The error of the receptance falls with the fourth power of the frequency per attachment mode, and with the
    /// second for residual flexibility.
    #[test]
    fn the_order_grows_by_four_per_mode() {
        let full = structure();
        let error = |count: usize, omega: f64| {
            let exact = receptance(&full, 4, omega);
            let found = match count {
                0 => full.truncated(4, true).unwrap().residual_flexibility,
                _ => receptance(&with_attachment_modes(&full, 4, count).unwrap(), 4, omega),
            };
            (found / exact - 1.0).abs()
        };
        for (count, order) in [(0, 2.0), (1, 4.0), (2, 8.0)] {
            let cut = full.frequency[4];
            let [coarse, fine] = [0.24, 0.12].map(|share| error(count, share * cut));
            let observed = (coarse / fine).log2();
            assert!(
                (observed / order - 1.0).abs() < 0.05,
                "{count}: {observed}, {coarse:e}"
            );
        }
    }

    /// If there are as many attachment modes as omitted modes, they equal the omitted modes.
    #[test]
    fn all_attachment_modes_are_the_modes() {
        let full = structure();
        let again = with_attachment_modes(&full, 9, 3).unwrap();
        for mode in 9..12 {
            let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{mode}: {a} {b}");
            near(again.frequency[mode], full.frequency[mode]);
            near(again.mesh[mode].abs(), full.mesh[mode]);
            near(again.damping[mode], 0.02);
        }
    }

    #[test]
    fn no_more_than_are_left_out() {
        let refused = with_attachment_modes(&structure(), 9, 4).unwrap_err();
        assert_eq!((refused.requested, refused.available), (13, 12));
        assert!(with_attachment_modes(&structure(), 0, 1).is_err());
    }
}
