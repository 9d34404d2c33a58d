//! The inputs of the FMU, and their values before the importer sets any.

use super::FmuError;
use crate::manifest::{PointSpec, StructureSource};
use crate::structure::ModalStructure;

/// An input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// Torque on the pinion's shaft.
    Pinion,
    /// Torque on the wheel's shaft.
    Wheel,
    /// Load: a fraction of the rated torques on all shafts.
    Load,
}

/// Number of inputs.
pub const INPUTS: usize = 3;

/// Largest remainder of the load, relative to the load, with which the two torques still make up the whole
/// load.
const NOISE: f64 = 1e-9;

impl Input {
    /// All inputs, in order.
    pub const ALL: [Self; INPUTS] = [Self::Pinion, Self::Wheel, Self::Load];

    /// Index in [`Self::ALL`].
    pub fn place(self) -> usize {
        self as usize
    }
}

/// Values of the inputs before the importer sets any. They give the operating point of the job: torques on
/// the two shafts if these make up the whole load, otherwise the load.
///
/// # Errors
/// The structure has no participation of a torque on one of the shafts.
pub fn at_start(structure: &ModalStructure, point: &PointSpec) -> Result<[f64; INPUTS], FmuError> {
    let modal = matches!(point.model.source, StructureSource::Modal(_));
    let missing = |shaft| FmuError::NoTorque { shaft, modal };
    let pinion = structure
        .pinion_torque
        .as_deref()
        .ok_or(missing("pinion"))?;
    let wheel = (structure.wheel_torque.as_deref())
        .filter(|_| structure.wheel_teeth.is_some())
        .ok_or(missing("wheel"))?;
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let load = &structure.torque;
    let [pp, pw, ww] = [dot(pinion, pinion), dot(pinion, wheel), dot(wheel, wheel)];
    let [p, w] = [dot(pinion, load), dot(wheel, load)];
    let determinant = pp * ww - pw * pw;
    let [first, second] = [
        (p * ww - w * pw) / determinant,
        (w * pp - p * pw) / determinant,
    ];
    let rest = load.iter().zip(pinion.iter().zip(wheel));
    let rest: f64 = (rest.map(|(t, (p, w))| (t - first * p - second * w).powi(2))).sum();
    let scale = structure.rated_force * point.load;
    // If the two participations are parallel, the remainder is NaN or infinite: the load is the input.
    if rest.sqrt() <= NOISE * dot(load, load).sqrt() {
        Ok([first * scale, second * scale, 0.0])
    } else {
        Ok([0.0, 0.0, point.load])
    }
}
