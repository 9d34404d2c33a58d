//! Which constant forces besides the load act on the modes of a train? Drag, forces of displaced pins, and
//! centrifugal forces.

use super::TrainDrive;
use super::nodes::Assembled;
use super::solved::Solved;
use super::speeds::Layout;
use crate::numerics::linalg::add_scaled;
use crate::shaft::assembly::Freedom;
use crate::structure::ModalStructure;
use nalgebra::{DMatrix, DVector};

/// Mean force on the flanks of every mesh, the first one first \[N\], negative on coast flanks. These forces
/// balance load and drag on every rotation that no spring holds. If torque splits, its paths share it with the
/// smallest sum of squared forces.
///
/// * `structure`: that of a train, or of a drive of two shafts.
/// * `load`: fraction of the rated torque.
/// * `speed`: of the driver \[rad/s\].
pub fn mean_forces(structure: &ModalStructure, load: f64, speed: f64) -> Vec<f64> {
    let meshes = structure.meshes.len().saturating_sub(1);
    let flanks = structure.contacts[..2 * meshes].iter().step_by(2);
    let others = structure.contacts[2 * meshes..].iter();
    // Dry sliders start without a force.
    let others = flanks.chain(others.filter(|contact| contact.law.slider.is_none()));
    let participations: Vec<&[f64]> = std::iter::once(structure.mesh.as_slice())
        .chain(others.map(|contact| contact.participation.as_slice()))
        .collect();
    let rigid: Vec<usize> = (0..structure.modes())
        .filter(|&mode| structure.frequency[mode] == 0.0)
        .collect();
    let balance = DMatrix::from_fn(rigid.len(), participations.len(), |row, contact| {
        participations[contact][rigid[row]]
    });
    let at = |column: &[f64], mode: usize| column.get(mode).copied().unwrap_or(0.0);
    let loads = DVector::from_fn(rigid.len(), |row, _| {
        let mode = rigid[row];
        load * structure.rated_force * structure.torque[mode]
            + at(&structure.constant_load, mode)
            + speed * at(&structure.load_by_speed, mode)
    });
    let least = 1e-9 * balance.amax();
    let forces = balance.svd(true, true).solve(&loads, least);
    // The decomposition has both factors, so a solution exists.
    let forces = forces.unwrap_or_else(|_| DVector::zeros(participations.len()));
    forces.iter().take(1 + meshes).copied().collect()
}

impl TrainDrive {
    /// Modal centrifugal forces on the planets, per square of the driver's speed; empty for none.
    pub(super) fn centrifugal_load(
        &self,
        solved: &Solved,
        layout: &Layout,
        assembled: &Assembled,
    ) -> Vec<f64> {
        let forces = self.centrifugal_forces(layout, assembled);
        if forces.is_empty() {
            return Vec::new();
        }
        let mut load = solved.participation(&forces);
        load[0] = 0.0;
        load
    }

    /// Modal forces of the mean drag, constant and per speed of the driver, and of displaced pins. The
    /// motor keeps the speed: its torque supplies the power of all brakes.
    pub(super) fn mean_drag(
        &self,
        solved: &Solved,
        layout: &Layout,
        assembled: &Assembled,
        driving: &[f64],
    ) -> [Vec<f64>; 2] {
        let participations = |terms: &[(usize, Freedom, f64)]| solved.participation(terms);
        let mut loads = self.brakes(layout, assembled, driving, participations);
        for (node, freedom, force) in self.pin_forces(layout, assembled) {
            add_scaled(
                &mut loads[0],
                force,
                &solved.participation(&[(node, freedom, 1.0)]),
            );
        }
        for load in &mut loads {
            load[0] = 0.0;
            if load.iter().all(|&force| force == 0.0) {
                load.clear();
            }
        }
        loads
    }

    /// Forces of all brakes and of the motor against them: a constant part and a part per speed of the
    /// driver. `participations` converts a sum of freedoms to the coordinates of `driving`, a unit torque of
    /// the motor.
    pub(super) fn brakes(
        &self,
        layout: &Layout,
        assembled: &Assembled,
        driving: &[f64],
        participations: impl Fn(&[(usize, Freedom, f64)]) -> Vec<f64>,
    ) -> [Vec<f64>; 2] {
        let size = driving.len();
        let mut loads = [vec![0.0; size], vec![0.0; size]];
        let turning = |node: usize| participations(&[(node, Freedom::RotationZ, 1.0)]);
        let shafts = self.shafts.iter().enumerate().map(|(index, shaft)| {
            let node = assembled.at(index, shaft.torque_at);
            (turning(node), layout.speeds[index], shaft.drag)
        });
        let loose = self.loose_gears().zip(&assembled.loose).enumerate();
        let loose = loose.filter_map(|(number, (place, &node))| {
            let drag = self.gear(place).loose?.drag;
            let on = assembled.at(place.shaft, self.gear(place).at);
            let [above, below] = [node, on].map(turning);
            let relative = above.iter().zip(below).map(|(a, b)| a - b);
            let speeds = [
                layout.speeds[self.shafts.len() + number],
                layout.speeds[place.shaft],
            ];
            Some((relative.collect(), speeds[0] - speeds[1], drag))
        });
        for (participations, speed, drag) in shafts.chain(loose) {
            let torques = [drag.constant * sign(speed), drag.viscous * speed];
            for (load, torque) in loads.iter_mut().zip(torques) {
                add_scaled(load, -torque, &participations);
                add_scaled(load, torque * speed, driving);
            }
        }
        loads
    }

    /// Forces of the driven machines and of the motor that drives them, per newton of rated force;
    /// `participations` as in [`Self::brakes`].
    pub(super) fn power(
        &self,
        layout: &Layout,
        assembled: &Assembled,
        driving: &[f64],
        participations: impl Fn(&[(usize, Freedom, f64)]) -> Vec<f64>,
    ) -> Vec<f64> {
        let base = self.pair.base_radii()[0];
        let mut load = vec![0.0; driving.len()];
        for (index, shaft) in self.shafts.iter().enumerate() {
            if shaft.output != 0.0 {
                let leaving = shaft.output * base / layout.speeds[index];
                let node = assembled.at(index, shaft.torque_at);
                add_scaled(
                    &mut load,
                    -leaving,
                    &participations(&[(node, Freedom::RotationZ, 1.0)]),
                );
                add_scaled(&mut load, shaft.output * base, driving);
            }
        }
        load
    }
}

/// −1, 0 or 1.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}
