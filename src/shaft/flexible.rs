//! From a flexible drive to the modes its gear mesh feels.
//!
//! Two parallel shafts along z, x along the line of centres from pinion to wheel, y across
//! it. Rotations are right-handed but for the wheel's about z, which is counted in the
//! wheel's own sense of running, so that both gears roll forward together. The mesh
//! deflection is
//!
//! ```text
//! δ = r_b1 θz1 − r_b2 θz2 + n·(u1 − u2) + z_c n·((θ1 − θ2) × e_z),   n = (sin α, cos α, 0)
//! ```
//!
//! `mesh` is δ at z_c = 0 per unit modal coordinate, `mesh_tilt` its derivative by z_c.
//! Gear bodies are rigid annuli between shaft surface and pitch radius, centred on their
//! node. The two rigid rotations are given as the neutral one (no deflection, no torque)
//! followed by the relative one.
//!
//! Friction acts along `t = (cos α, −sin α, 0)`, `+t` on the pinion and `−t` on the wheel, at
//! the distance s from the pitch point along n. Its moments about the two axes follow from
//! that point of attack: `−(r₁ sin α + s)` on θz1 and `r₂ sin α − s` on θz2. `friction` is the
//! part at the pitch point, where the flanks roll and the neutral rotation feels nothing;
//! `friction_lever` the part linear in s.

use super::assembly::{AssembledMatrices, Assembly, Disc, Freedom};
use super::beam::{Material, Section};
use super::drive::{Bearing, FlexibleDrive, Shaft};
use super::error::{ShaftError, non_negative, positive};
use super::modal::{BearingGain, ModalStructure};
use super::modes::Modes;

/// The neutral and the relative rotation.
const RIGID_MODES: usize = 2;

/// Nodes of one shaft that loads act on.
#[derive(Debug, Clone, Copy)]
struct ShaftNodes {
    /// Free end of the overhang.
    end: usize,
    /// The gear body.
    gear: usize,
    /// Both bearings.
    bearings: [usize; 2],
}

impl FlexibleDrive {
    /// The `retained` lowest of the `modes` lowest modes of the drive.
    ///
    /// With `mta` (modal-truncation augmentation) the modes computed but not retained
    /// return as residual flexibility `Σ mesh²/ω²`; without it that is 0. Modes beyond
    /// `modes` are dropped either way.
    ///
    /// `pinion_torque` and `wheel_torque` act at the end inertias, each positive in its
    /// shaft's sense of running. The sign of a mode is such that its mesh participation is
    /// positive, or, where the mesh does not feel it, that its largest freedom moves in the
    /// positive direction.
    ///
    /// # Errors
    /// Any [`ShaftError`] but those of ties: unphysical dimensions, shafts that are not
    /// held, more modes than freedoms, fewer retained than the two rigid ones.
    pub fn modes(
        &self,
        modes: usize,
        retained: usize,
        mta: bool,
    ) -> Result<ModalStructure, ShaftError> {
        self.check()?;
        let mut assembly = Assembly::new();
        let nodes = [
            self.add_shaft(&mut assembly, 0)?,
            self.add_shaft(&mut assembly, 1)?,
        ];
        let matrices = assembly.matrices()?;
        if modes < RIGID_MODES {
            return Err(ShaftError::ModeCount {
                requested: modes,
                least: RIGID_MODES,
                available: matrices.mass.nrows(),
            });
        }
        let solution = Modes::lowest(&matrices.mass, &matrices.stiffness, modes, RIGID_MODES)?;
        let damping = self.modal_damping(modes)?;
        self.structure(&matrices, nodes, &solution, damping)?
            .truncated(retained, mta)
    }

    fn check(&self) -> Result<(), ShaftError> {
        let gears = &self.gears;
        positive("module [m]", gears.module)?;
        positive("rated torque [N m]", gears.rated_torque)?;
        positive("pressure angle [rad]", gears.pressure_angle)?;
        gears.operating_pressure_angle()?;
        positive("density [kg/m^3]", self.density)?;
        for ratio in std::iter::once(self.damping)
            .chain(self.damping_overrides.iter().map(|(_, ratio)| *ratio))
        {
            if !(0.0..1.0).contains(&ratio) {
                return Err(ShaftError::DampingRatio { ratio });
            }
        }
        for (index, shaft) in self.shafts.iter().enumerate() {
            shaft.check(index + 1)?;
        }
        Ok(())
    }

    /// Adds one shaft with bearings, gear body and end inertia.
    fn add_shaft(&self, assembly: &mut Assembly, index: usize) -> Result<ShaftNodes, ShaftError> {
        let shaft = &self.shafts[index];
        let gear_station = shaft.gear_position * shaft.span;
        let mut stations = vec![-shaft.overhang];
        if shaft.overhang > 0.0 {
            divide(&mut stations, 0.0, self.elements[0], "the overhang")?;
        }
        let first_bearing = stations.len() - 1;
        divide(
            &mut stations,
            gear_station,
            self.elements[1],
            "the stretch from the first bearing to the gear",
        )?;
        let gear = stations.len() - 1;
        divide(
            &mut stations,
            shaft.span,
            self.elements[2],
            "the stretch from the gear to the second bearing",
        )?;
        let second_bearing = stations.len() - 1;

        let material = Material {
            young_modulus: self.young_modulus,
            shear_modulus: self.shear_modulus,
            density: self.density,
        };
        let first = assembly.add_shaft(
            &stations,
            Section::solid(shaft.diameter)?,
            material,
            self.shear_coefficient,
        )?;
        for (node, bearing) in [first_bearing, second_bearing].iter().zip(&shaft.bearings) {
            assembly.add_spring(first + node, bearing.stiffness())?;
        }
        let body = Disc::annulus(
            2.0 * self.gears.pitch_radii()[index],
            shaft.diameter,
            self.gears.body_length[index],
            self.density,
        )?;
        assembly.add_disc(first + gear, body)?;
        assembly.add_polar_inertia(first, shaft.end_inertia)?;
        Ok(ShaftNodes {
            end: first,
            gear: first + gear,
            bearings: [first + first_bearing, first + second_bearing],
        })
    }

    fn modal_damping(&self, modes: usize) -> Result<Vec<f64>, ShaftError> {
        let mut damping = vec![self.damping; modes];
        damping[..RIGID_MODES].fill(0.0);
        for &(mode, ratio) in &self.damping_overrides {
            if mode <= RIGID_MODES || mode > modes {
                return Err(ShaftError::DampingOverride {
                    mode,
                    first: RIGID_MODES + 1,
                    last: modes,
                });
            }
            damping[mode - 1] = ratio;
        }
        Ok(damping)
    }

    /// Participations of all computed modes, rigid pair and signs settled.
    fn structure(
        &self,
        matrices: &AssembledMatrices,
        nodes: [ShaftNodes; 2],
        solution: &Modes,
        damping: Vec<f64>,
    ) -> Result<ModalStructure, ShaftError> {
        use Freedom::{RotationX, RotationY, RotationZ, X, Y};
        let [base_1, base_2] = self.gears.base_radii();
        let [pitch_1, pitch_2] = self.gears.operating_pitch_radii()?;
        let (sin, cos) = self.gears.operating_pressure_angle()?.sin_cos();
        let [pinion, wheel] = nodes.map(|shaft| shaft.gear);
        let participation =
            |terms: &[(usize, Freedom, f64)]| solution.participation(&matrices.functional(terms));

        let mut mesh = participation(&[
            (pinion, RotationZ, base_1),
            (pinion, X, sin),
            (pinion, Y, cos),
            (wheel, X, -sin),
            (wheel, Y, -cos),
            (wheel, RotationZ, -base_2),
        ]);
        // n·(θ × e_z) = sin α θy − cos α θx
        let mut mesh_tilt = participation(&[
            (pinion, RotationY, sin),
            (pinion, RotationX, -cos),
            (wheel, RotationY, -sin),
            (wheel, RotationX, cos),
        ]);
        let mut friction = participation(&[
            (pinion, X, cos),
            (pinion, Y, -sin),
            (wheel, X, -cos),
            (wheel, Y, sin),
            (pinion, RotationZ, -pitch_1 * sin),
            (wheel, RotationZ, pitch_2 * sin),
        ]);
        let mut friction_lever =
            participation(&[(pinion, RotationZ, -1.0), (wheel, RotationZ, -1.0)]);
        let mut pinion_torque = participation(&[(nodes[0].end, RotationZ, 1.0)]);
        let mut wheel_torque = participation(&[(nodes[1].end, RotationZ, 1.0)]);

        let mut bearings = self.bearing_gains(matrices, nodes, solution);

        let signs = orientation(&mesh[RIGID_MODES..], solution);
        let [w_1, w_2] = [mesh[0], mesh[1]];
        let norm = w_1.hypot(w_2);
        // The pinion turns forward in the neutral mode.
        let forward = (w_2 * pinion_torque[0] - w_1 * pinion_torque[1]).signum();
        for column in [
            &mut mesh,
            &mut mesh_tilt,
            &mut friction,
            &mut friction_lever,
            &mut pinion_torque,
            &mut wheel_torque,
        ]
        .into_iter()
        .chain(bearings.iter_mut().map(|bearing| &mut bearing.gain))
        {
            let [a, b] = [column[0], column[1]];
            column[0] = forward * (w_2 * a - w_1 * b) / norm;
            column[1] = (w_1 * a + w_2 * b) / norm;
            for (value, sign) in column[RIGID_MODES..].iter_mut().zip(&signs) {
                *value *= sign;
            }
        }
        let mut torque: Vec<f64> = (pinion_torque.iter().zip(&wheel_torque))
            .map(|(one, two)| base_1 * one - base_2 * two)
            .collect();
        // Zero by construction; only round-off of the rotation is removed.
        mesh[0] = 0.0;
        torque[0] = 0.0;
        // Shafts turn in their bearings; the neutral rotation grows without bound.
        for bearing in &mut bearings {
            bearing.gain[..RIGID_MODES].fill(0.0);
        }

        Ok(ModalStructure {
            teeth: self.gears.teeth[0],
            wheel_teeth: Some(self.gears.teeth[1]),
            rated_force: self.gears.rated_force(),
            frequency: solution.frequencies(),
            damping,
            mesh,
            mesh_tilt,
            torque,
            pinion_torque: Some(pinion_torque),
            wheel_torque: Some(wheel_torque),
            friction,
            friction_lever,
            residual_flexibility: 0.0,
            bearings,
        })
    }

    /// Gains of every bearing with a stiffness: along the line of centres, across it, axially.
    fn bearing_gains(
        &self,
        matrices: &AssembledMatrices,
        nodes: [ShaftNodes; 2],
        solution: &Modes,
    ) -> Vec<BearingGain> {
        let mut gains = Vec::new();
        for ((name, shaft), nodes) in ["pinion", "wheel"].iter().zip(&self.shafts).zip(nodes) {
            for ((number, bearing), node) in (1..).zip(&shaft.bearings).zip(nodes.bearings) {
                let directions = [
                    ("line", Freedom::X, bearing.line_of_centres),
                    ("across", Freedom::Y, bearing.across),
                    ("axial", Freedom::Z, bearing.axial),
                ];
                for (direction, freedom, stiffness) in directions {
                    if stiffness > 0.0 {
                        let force = matrices.functional(&[(node, freedom, stiffness)]);
                        gains.push(BearingGain {
                            name: format!("{name} {number} {direction}"),
                            gain: solution.participation(&force),
                        });
                    }
                }
            }
        }
        gains
    }
}

impl Bearing {
    /// Stiffness of each freedom, in the order of [`Freedom`].
    fn stiffness(&self) -> [f64; 6] {
        [
            self.line_of_centres,
            self.across,
            self.axial,
            self.tilt,
            self.tilt,
            0.0,
        ]
    }
}

impl Shaft {
    /// Dimensions, and that nothing but the rotation is free. `number` is 1 or 2.
    fn check(&self, number: usize) -> Result<(), ShaftError> {
        positive("bearing span [m]", self.span)?;
        non_negative("overhang [m]", self.overhang)?;
        if !(self.gear_position > 0.0 && self.gear_position < 1.0) {
            return Err(ShaftError::GearPosition {
                shaft: number,
                position: self.gear_position,
            });
        }
        let supports =
            |pick: fn(&Bearing) -> f64| self.bearings.iter().filter(|b| pick(b) > 0.0).count();
        // A line is held in a plane by two springs, or by one and a tilt spring.
        let tilting = supports(|b| b.tilt) > 0;
        let held = |count: usize| count == 2 || (count == 1 && tilting);
        for (direction, held) in [
            (
                "along the line of centres",
                held(supports(|b| b.line_of_centres)),
            ),
            ("across the line of centres", held(supports(|b| b.across))),
            ("axially", supports(|b| b.axial) > 0),
        ] {
            if !held {
                return Err(ShaftError::NotHeld {
                    shaft: number,
                    direction,
                });
            }
        }
        Ok(())
    }
}

/// Sign of every elastic mode, from its mesh participation.
fn orientation(mesh: &[f64], solution: &Modes) -> Vec<f64> {
    let largest = mesh.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
    (mesh.iter().enumerate())
        .map(|(index, &w)| {
            // Below this a participation is round-off of a zero.
            if w.abs() > 1e-8 * largest {
                return w.signum();
            }
            let shape = solution.shape.col(RIGID_MODES + index);
            let peak = shape.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            // The first of those that tie within round-off.
            shape
                .iter()
                .find(|v| v.abs() > (1.0 - 1e-6) * peak)
                .map_or(1.0, |v| v.signum())
        })
        .collect()
}

/// Appends `count` equal steps from the last station to `to`.
fn divide(
    stations: &mut Vec<f64>,
    to: f64,
    count: usize,
    stretch: &'static str,
) -> Result<(), ShaftError> {
    if count == 0 {
        return Err(ShaftError::NoElement { stretch });
    }
    let from = stations[stations.len() - 1];
    for step in 1..=count {
        let fraction = step as f64 / count as f64;
        stations.push(from * (1.0 - fraction) + to * fraction);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
