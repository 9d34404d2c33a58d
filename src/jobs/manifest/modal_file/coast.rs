//! Which keys of a modal file describe the coast flanks?

use super::{column, optional};
use crate::manifest::reader::Section;
use crate::structure::FlankParticipation;

/// Keys without an effect if there is no `mesh_coast`.
const COAST_KEYS: [&str; 3] = ["mesh_tilt_coast", "friction_coast", "friction_lever_coast"];

/// Largest difference of both flanks' deflections in a rigid rotation, as a fraction of the largest
/// participation: the error of a file with six digits.
const SAME_ROTATION: f64 = 1e-5;

/// The columns of the coast flanks. The outer `None` is a fault, the inner one a file without `mesh_coast`.
pub(super) fn read(
    root: &Section,
    drive: Option<&[f64]>,
    frequency: Option<&[f64]>,
) -> Option<Option<FlankParticipation>> {
    if !root.has("mesh_coast") {
        root.without_effect(
            &COAST_KEYS,
            "without `mesh_coast`",
            "remove it, or add mesh_coast",
        );
        return Some(None);
    }
    let modes = frequency.map(<[f64]>::len);
    let mesh = column(root, "mesh_coast", modes);
    let [tilt, friction, lever] = COAST_KEYS.map(|name| optional(root, name, modes));
    let (mesh, frequency) = (mesh?, frequency?);
    same_rotation(root, &mesh, drive?, frequency)?;
    let or_zeros = |column: Option<Vec<f64>>| column.unwrap_or_else(|| vec![0.0; frequency.len()]);
    Some(Some(FlankParticipation {
        mesh,
        tilt: or_zeros(tilt?),
        friction: or_zeros(friction?),
        lever: or_zeros(lever?),
        residual_flexibility: 0.0,
    }))
}

/// Checks that both flanks have the same deflection in rigid rotations: a rotation opens one side of a tooth as much as
/// it closes the other side.
fn same_rotation(root: &Section, coast: &[f64], drive: &[f64], frequency: &[f64]) -> Option<()> {
    let largest = drive.iter().fold(0.0_f64, |most, w| most.max(w.abs()));
    let differs = |mode: &usize| {
        frequency[*mode] == 0.0 && (coast[*mode] - drive[*mode]).abs() > SAME_ROTATION * largest
    };
    let Some(mode) = (0..frequency.len()).find(differs) else {
        return Some(());
    };
    let message = format!(
        "mode {} is a rigid rotation, so both flanks must have the same deflection, but `mesh_coast` is {} and `mesh` is {}",
        mode + 1,
        coast[mode],
        drive[mode]
    );
    root.inconsistent("mesh_coast", message)
        .label("differs from `mesh` in sign or size")
        .remedy("give `mesh_coast` the sign of `mesh`: it grows as the drive flanks approach")
        .fail(root.issues)
}
