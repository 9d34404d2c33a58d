//! On which quantities do the constant inputs of a model depend? Load, speed, torques on its shafts.

use super::Model;
use crate::structure::ModalStructure;

/// A quantity to which a constant input of the blocks is proportional.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadTerm {
    /// The load, as a fraction of the rated one.
    Rated,
    /// No quantity: the input is constant.
    Constant,
    /// The speed Ω of the operating point \[rad/s\].
    Speed,
    /// The square of the speed \[rad²/s²\].
    SpeedSquared,
    /// A torque on the pinion's shaft \[N m\], besides the rated load.
    PinionTorque,
    /// A torque on the wheel's shaft \[N m\], besides the rated load.
    WheelTorque,
}

/// Number of load terms.
pub const LOAD_TERMS: usize = 6;

/// The inputs of a model by load term. Neutral blocks have none. Torques on shafts exclude their effect on
/// the rotation of the whole drive, which is part of the mean rotation.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadTerms {
    /// Inputs of the blocks per unit of each [`LoadTerm`], in the order of its variants.
    pub inputs: [Vec<[f64; 2]>; LOAD_TERMS],
    /// Static force of the omitted modes on every bearing \[N\], per unit of each load term.
    pub on_bearings: Vec<[f64; LOAD_TERMS]>,
    /// Angular acceleration of the pinion's shaft per unit torque on the pinion's and on the wheel's shaft, with the
    /// drive as a rigid body without dampers \[1/(kg m²)\]. An entry is `None` if the place of its torque is unknown.
    /// Both are `None` if no torque on the pinion's shaft turns the whole drive.
    pub mobility: [Option<f64>; 2],
}

impl Model {
    /// The inputs of this model by load term; `structure` is the structure of the model.
    pub fn load_terms(&self, structure: &ModalStructure) -> LoadTerms {
        let basis = &self.basis;
        let block_inputs = |values: &[f64], scale: f64| -> Vec<[f64; 2]> {
            if values.is_empty() {
                return vec![[0.0; 2]; self.blocks.len()];
            }
            let scaled: Vec<f64> = basis.turn(values).iter().map(|v| scale * v).collect();
            basis.input(&scaled)
        };
        // The part of a torque that accelerates the whole drive changes the mean rotation. It is no input.
        let torques = [&structure.pinion_torque, &structure.wheel_torque].map(|values| {
            let mut turned = basis.turn(values.as_deref()?);
            let whole = self
                .free_rotations()
                .map(|i| std::mem::take(&mut turned[i]));
            let whole: Vec<f64> = whole.collect();
            Some((whole, basis.input(&turned)))
        });
        let along = |torque: &Option<(Vec<f64>, _)>| {
            let (pinion, own) = (&torques[0].as_ref()?.0, &torque.as_ref()?.0);
            Some(pinion.iter().zip(own).map(|(p, t)| p * t).sum::<f64>())
        };
        let acts = along(&torques[0]).is_some_and(|own| own > 0.0);
        let mobility = [0, 1].map(|shaft| along(&torques[shaft]).filter(|_| acts));
        let no_input = || vec![[0.0; 2]; self.blocks.len()];
        let [pinion, wheel] =
            torques.map(|torque| torque.map_or_else(no_input, |(_, input)| input));
        let mut inputs = [
            block_inputs(&structure.torque, structure.rated_force),
            block_inputs(&structure.constant_load, 1.0),
            block_inputs(&structure.load_by_speed, 1.0),
            block_inputs(&structure.frame.load, 1.0),
            pinion,
            wheel,
        ];
        for &block in &self.neutral {
            inputs
                .iter_mut()
                .for_each(|inputs| inputs[block] = [0.0; 2]);
        }
        let share = |bearing: &crate::structure::BearingGain| {
            let left_out = &bearing.left_out;
            let [pinion, wheel] = left_out.shaft_torques;
            [
                left_out.torque * structure.rated_force,
                left_out.constant_load,
                left_out.load_by_speed,
                left_out.frame_load,
                pinion,
                wheel,
            ]
        };
        LoadTerms {
            inputs,
            on_bearings: structure.bearings.iter().map(share).collect(),
            mobility,
        }
    }

    /// Indices of the rotated rigid modes that neither contacts nor springs restrain: rotations of the whole
    /// drive, which dampers may slow down.
    pub fn free_rotations(&self) -> impl Iterator<Item = usize> {
        let n = self.blocks.len();
        let is_held = move |&i: &usize| {
            let coupled = self.basis.coupled();
            coupled.is_some_and(|coupled| coupled.stiffness[n * i..][..n].iter().any(|k| *k != 0.0))
        };
        let rigid = self.basis.without_contact().iter().copied();
        rigid.filter(move |i| !is_held(i))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{OperatingPoint, fixtures};

    /// Two rigid rotations that only the mesh couples. The inputs by load and speed sum to the model's input,
    /// and a torque on the pinion's shaft accelerates the whole inertia.
    #[test]
    fn inputs_add_up_to_those_of_the_point() {
        let (a, b) = (0.8, 0.6);
        let mut structure =
            fixtures::structure(&[0.0, 0.0, 900.0], 0.01, &[a, b, 0.4], &[a, b, 0.4]);
        structure.constant_load = vec![3.0, -2.0, 1.0];
        structure.load_by_speed = vec![0.1, 0.0, 0.2];
        // Radii of 1: unit torques pull along the line of action in opposite directions.
        structure.pinion_torque = Some(vec![a, 0.0, 0.4]);
        structure.wheel_torque = Some(vec![0.0, -b, 0.1]);
        let point = OperatingPoint {
            load: 0.3,
            speed: 70.0,
        };
        let model = Model::new(&structure, &fixtures::two_level_mesh(1e-5), point).unwrap();
        let terms = model.load_terms(&structure);
        assert_eq!(model.neutral.len(), 1);
        for i in (0..3).filter(|i| !model.neutral.contains(i)) {
            for part in 0..2 {
                let factors = [point.load, 1.0, point.speed, point.speed.powi(2), 0.0, 0.0];
                let sum: f64 = (terms.inputs.iter().zip(factors))
                    .map(|(inputs, factor)| factor * inputs[i][part])
                    .sum();
                let own = model.blocks[i].static_input[part];
                assert!(
                    (sum - own).abs() <= 1e-12 * own.abs(),
                    "{i} {part}: {sum} {own}"
                );
            }
        }
        // Both shafts rotate by the same angle: J = 1/a² + 1/b².
        let inertia = 1.0 / (a * a) + 1.0 / (b * b);
        let [pinion, wheel] = terms.mobility.map(Option::unwrap);
        assert!((pinion * inertia - 1.0).abs() < 1e-14, "{pinion}");
        assert!((wheel.abs() * inertia - 1.0).abs() < 1e-14, "{wheel}");
    }
}
