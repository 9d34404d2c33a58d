//! From a train to its modes and the participations of contacts, torques and bearings in them.

use super::contacts::{FlankTerms, Terms, tilt_residuals};
use super::nodes::Assembled;
use super::outputs::{BearingTerms, place_motions};
use super::solved::Solved;
use super::speeds::{Layout, sense};
use super::{GearPlace, MeshLaw, TrainDrive, TrainError};
use crate::gear::positive;
use crate::shaft::assembly::{AssembledMatrices, Freedom};
use crate::shaft::error::ShaftError;
use crate::shaft::modes::{Modes, orientation};
use crate::shaft::projection;
use crate::structure::{
    BearingGain, ContactLaw, ModalStructure, ModeCount, MotionKind, StructureContact, TorqueGain,
    TurningFrame,
};

/// The motions that bearings must hold, with the stiffnesses that do so.
const REQUIRED_SUPPORTS: [(Freedom, &str, &str); 5] = [
    (Freedom::X, "along its x axis", "x"),
    (Freedom::Y, "along its y axis", "y"),
    (Freedom::Z, "axially", "axial"),
    (
        Freedom::RotationX,
        "against tilting about its x axis",
        "tilt",
    ),
    (
        Freedom::RotationY,
        "against tilting about its y axis",
        "tilt",
    ),
];

impl TrainDrive {
    /// The `retained` lowest of the `modes` lowest modes, as
    /// [`FlexibleDrive::modes`](crate::shaft::FlexibleDrive::modes). The torque on the pinion acts on the driving
    /// shaft. The torque on the wheel acts on the shaft of the second gear; it is `None` if this gear runs loose, and
    /// in trains with planets.
    ///
    /// # Errors
    /// [`TrainError`], and as [`FlexibleDrive::modes`](crate::shaft::FlexibleDrive::modes).
    pub fn modes(
        &self,
        modes: usize,
        retained: usize,
        mta: bool,
    ) -> Result<ModalStructure, ShaftError> {
        positive("rated torque [N m]", self.pair.rated_torque)?;
        let layout = self.layout()?;
        let mut assembled = self.assembled(&layout)?;
        self.load_bearings(&layout, &mut assembled)?;
        let matrices = assembled.assembly.matrices()?;
        let rigid = self.rotations();
        if modes < rigid {
            return Err(ModeCount {
                requested: modes,
                least: rigid,
                available: matrices.mass.nrows(),
            }
            .into());
        }
        let solution = Modes::lowest(&matrices.mass, &matrices.stiffness, modes, rigid)
            .map_err(|error| self.name_unsupported(error, &matrices, &assembled))?;
        let mut damping = self.modal_damping(modes, rigid)?;
        let neutral = self.neutral(&layout, &assembled, (&matrices, &solution), rigid);
        let supports = assembled.supports.iter().enumerate();
        let supports = supports
            .map(|(number, support)| (support, self.base_place(number, &layout, &assembled)));
        let bearings = BearingTerms::of_supports(&matrices, supports);
        let angle = self.pair.operating_pressure_angle()?;
        let mut first = layout.meshes[0];
        first.point += first.pitch_line * self.pair.form.face_middle;
        let flanks = self.flanks(self.gears, (&first, angle), &layout, &assembled);
        let tilts = self.tilt_loads(&flanks, &layout, &assembled, &matrices);
        let with_shapes = BearingTerms::with_shapes(&bearings, tilts, &matrices, &solution)?;
        damping.resize(with_shapes.squared_frequency.len(), 0.0);
        let mut solved = Solved {
            matrices: &matrices,
            modes: &with_shapes,
            signs: vec![1.0; modes - 1],
            neutral,
        };
        let drive = solved.participation(&flanks[0].mesh);
        let turning = drive[1..rigid]
            .iter()
            .map(|gain| if *gain < 0.0 { -1.0 } else { 1.0 });
        let elastic = orientation(&drive[..modes], rigid, &solution);
        solved.signs = turning.chain(elastic).collect();
        let to_structure_modes = |column: &mut [f64]| solved.to_structure_modes(column);
        let gains = BearingTerms::gains(
            &bearings,
            &with_shapes,
            [modes, solved.neutral.len()],
            to_structure_modes,
        );
        let with_shapes = self.structure(&solved, &layout, &assembled, (flanks, damping, gains))?;
        let mut structure = with_shapes.truncated(modes, false)?;
        structure.tilt_residuals = tilt_residuals(&with_shapes, modes + bearings.len());
        structure.shapes = Some(solution.in_freedoms(&matrices, to_structure_modes).into());
        (structure.coupling, structure.frame.stiffness) =
            projection::coupling(&matrices, &solution, to_structure_modes);
        release_neutral(&mut structure);
        Ok(structure.truncated(retained, mta)?)
    }

    /// Damping ratios of modes; the first `rigid` ones have none.
    fn modal_damping(&self, modes: usize, rigid: usize) -> Result<Vec<f64>, ShaftError> {
        let overrides = &self.damping_overrides;
        let ratios = overrides.iter().map(|&(_, ratio)| ratio);
        for ratio in std::iter::once(self.damping).chain(ratios) {
            if !(0.0..1.0).contains(&ratio) {
                return Err(ShaftError::DampingRatio { ratio });
            }
        }
        let mut damping = vec![self.damping; modes];
        damping[..rigid].fill(0.0);
        for &(mode, ratio) in overrides {
            if mode <= rigid || mode > modes {
                return Err(ShaftError::DampingOverride {
                    mode,
                    first: rigid + 1,
                    last: modes,
                });
            }
            damping[mode - 1] = ratio;
        }
        Ok(damping)
    }

    /// Replaces an error about the number of rigid modes by one that names the shaft, or the loose gear on
    /// its shaft, that moves in them.
    pub(super) fn name_unsupported(
        &self,
        error: ShaftError,
        matrices: &AssembledMatrices,
        assembled: &Assembled,
    ) -> ShaftError {
        let ShaftError::RigidModes { found, expected } = error else {
            return error;
        };
        if found < expected {
            return error;
        }
        if self
            .housing
            .as_ref()
            .is_some_and(|joined| joined.housing.floats())
        {
            return TrainError::FloatingHousing.into();
        }
        let Ok(rigid) = Modes::lowest(&matrices.mass, &matrices.stiffness, found, found) else {
            return error;
        };
        let shafts = self.shafts.iter().enumerate();
        let shafts = shafts.flat_map(|(index, shaft)| {
            let nodes = assembled.independent_nodes(index);
            nodes.map(move |node| (&shaft.name, node, None))
        });
        let loose = self
            .loose_gears()
            .zip(&assembled.loose)
            .map(|(place, &node)| {
                let gear = self.gear(place);
                (&gear.name, node, Some(assembled.at(place.shaft, gear.at)))
            });
        let mut worst = (0.0, None);
        for (name, node, on) in shafts.chain(loose) {
            for (freedom, direction, key) in REQUIRED_SUPPORTS {
                let terms = [(node, freedom, 1.0)];
                let against: Terms = on.map(|node| (node, freedom, -1.0)).into_iter().collect();
                let place = matrices.functional(&[&terms[..], &against].concat());
                let rigid_participation = rigid.participation(&place);
                let inertia: f64 = (place.iter().enumerate())
                    .map(|(row, part)| part * part * matrices.mass[(row, row)])
                    .sum();
                let size = rigid_participation.iter().map(|m| m * m).sum::<f64>() * inertia;
                if size > worst.0 {
                    let name = name.clone();
                    let reason = match on {
                        None => self.free_shaft(name, direction),
                        Some(_) => TrainError::LooseNotHeld {
                            gear: name,
                            direction,
                            key,
                        },
                    };
                    worst = (size, Some(reason));
                }
            }
        }
        worst.1.map_or(error, ShaftError::from)
    }

    /// Why a shaft is free to move.
    fn free_shaft(&self, shaft: String, direction: &'static str) -> TrainError {
        let shafts_of_name = self.shafts.iter().filter(|part| part.name == shaft);
        let bearings = shafts_of_name.flat_map(|part| &part.bearings);
        let clearances = bearings.filter_map(|(_, bearing)| Some(bearing.rolling?.clearance));
        match (clearances.reduce(f64::max), self.bearing_load) {
            (Some(clearance), Some(load)) => TrainError::HeldByNoElement {
                shaft,
                direction,
                load,
                clearance,
            },
            _ => TrainError::NotHeld { shaft, direction },
        }
    }

    /// The neutral rotation, with every body at its speed, as a unit vector in the rigid modes.
    fn neutral(
        &self,
        layout: &Layout,
        assembled: &Assembled,
        (matrices, solution): (&AssembledMatrices, &Modes),
        rigid: usize,
    ) -> Vec<f64> {
        let shafts = (0..self.shafts.len()).flat_map(|shaft| {
            let speed = layout.speeds[shaft];
            assembled
                .independent_nodes(shaft)
                .map(move |node| (node, speed))
        });
        let loose = assembled.loose.iter().copied();
        let turning = shafts
            .chain(loose.zip(layout.speeds[self.shafts.len()..].iter().copied()))
            .map(|(node, speed)| (node, Freedom::RotationZ, speed));
        let turning: Terms = turning
            .chain(self.planet_velocities(layout, assembled))
            .collect();
        let motion = matrices.functional(&turning);
        let parts = solution.participation(&matrices.momentum(&motion))[..rigid].to_vec();
        let norm = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
        parts.into_iter().map(|part| part / norm).collect()
    }

    fn structure(
        &self,
        solved: &Solved,
        layout: &Layout,
        assembled: &Assembled,
        (first, damping, bearings): ([FlankTerms; 2], Vec<f64>, Vec<BearingGain>),
    ) -> Result<ModalStructure, ShaftError> {
        let mesh_mass = self.mesh_mass(solved.matrices, assembled, &first[0].mesh);
        let [drive, coast] = first.map(|flank| solved.flank(&flank));
        let torque_on = |shaft: usize, sense: f64| {
            let node = assembled.at(shaft, self.shafts[shaft].torque_at);
            solved.participation(&[(node, Freedom::RotationZ, sense)])
        };
        let driving = torque_on(self.driver, sense(layout.speeds[self.driver]));
        // A torque on the shaft of a loose gear has neither the speed nor the direction of the gear.
        let is_fixed = |place: &GearPlace| self.gear(*place).loose.is_none();
        let wheel =
            Some(self.gears[1]).filter(|place| is_fixed(place) && self.planetary.is_empty());
        let wheel = wheel.map(|place| torque_on(place.shaft, layout.speeds[place.shaft].signum()));

        // Torques per newton of rated force; their neutral parts cancel up to round-off.
        let participations = |terms: &[(usize, Freedom, f64)]| solved.participation(terms);
        let mut torque = self.power(layout, assembled, &driving, participations);
        torque[0] = 0.0;
        let [constant_load, load_by_speed] = self.mean_drag(solved, layout, assembled, &driving);

        let turning = self.turning(layout, assembled);
        let supports = assembled.supports.iter().cloned();
        let mut motions =
            place_motions(solved.matrices, solved.modes, supports, turning.into_iter());
        for motion in &mut motions {
            solved.to_structure_modes(&mut motion.gain);
        }
        motions.extend(self.housing_motions(solved, assembled));
        Ok(ModalStructure {
            teeth: self.pair.teeth[0],
            wheel_teeth: Some(self.pair.teeth[1]),
            frame: TurningFrame {
                rolling: layout.first_gear_speed,
                stiffness: Vec::new(),
                load: self.centrifugal_load(solved, layout, assembled),
            },
            rated_force: self.pair.rated_force(),
            frequency: solved.modes.frequencies(),
            damping,
            mesh: drive.mesh,
            mesh_tilt: drive.tilt,
            torque,
            pinion_torque: Some(driving),
            wheel_torque: wheel,
            friction: drive.friction,
            friction_lever: drive.lever,
            residual_flexibility: 0.0,
            tilt_residuals: Vec::new(),
            mesh_mass,
            coast: Some(coast),
            contacts: self.contacts(solved, layout, assembled),
            bearings,
            torques: self.torques(solved, layout, assembled),
            motions,
            coupling: None,
            constant_load,
            load_by_speed,
            harmonic_loads: Vec::new(),
            meshes: self.mesh_names(),
            shafts: self.further_shafts(layout),
            shapes: None,
        })
    }

    /// Rotations of all bodies and of all gears: kind, name, node and direction of rotation.
    fn turning(
        &self,
        layout: &Layout,
        assembled: &Assembled,
    ) -> Vec<(MotionKind, String, (usize, f64))> {
        let shafts = self.shafts.iter().enumerate().map(|(index, shaft)| {
            let node = assembled.at(index, shaft.torque_at);
            (
                MotionKind::Body,
                shaft.name.clone(),
                (node, sense(layout.speeds[index])),
            )
        });
        let gear = |kind: MotionKind, place: GearPlace| {
            let turns = sense(layout.speeds[self.body_of(place)]);
            let node = assembled.gear(self, place);
            (kind, self.gear(place).name.clone(), (node, turns))
        };
        let loose = self
            .loose_gears()
            .map(|place| gear(MotionKind::Body, place));
        let gears = self.gears().map(|place| gear(MotionKind::Gear, place));
        shafts.chain(loose).chain(gears).collect()
    }

    /// Torques in every stretch of a flexible shaft between positions where torque enters or leaves,
    /// and in the springs and dampers of couplings, without stages behind gaps.
    fn torques(&self, solved: &Solved, layout: &Layout, assembled: &Assembled) -> Vec<TorqueGain> {
        let elastic = |terms: &[(usize, Freedom, f64)]| {
            let mut gain = solved.participation(terms);
            gain[..solved.neutral.len()].fill(0.0);
            gain
        };
        let mut torques = Vec::new();
        for (index, shaft) in self.shafts.iter().enumerate() {
            let sense = sense(layout.speeds[index]);
            let stretches = self.stretches(index, assembled);
            for (number, torsion) in (1..).zip(&stretches) {
                torques.push(TorqueGain {
                    name: match stretches.len() {
                        1 => shaft.name.clone(),
                        _ => format!("{} {number}", shaft.name),
                    },
                    gain: elastic(&torsion.terms(sense)),
                    rate_gain: Vec::new(),
                });
            }
        }
        for (number, coupling) in self.couplings.iter().enumerate() {
            let stiffness = coupling.stiffness[3];
            let twist = self.twist(number, layout, assembled);
            let times = |factor: f64| -> Vec<_> {
                let terms = twist.iter();
                terms
                    .map(|&(node, freedom, c)| (node, freedom, factor * c))
                    .collect()
            };
            if stiffness > 0.0 {
                let [one, two] = coupling.shafts.map(|shaft| &self.shafts[shaft].name);
                torques.push(TorqueGain {
                    name: format!("{one} to {two}"),
                    gain: elastic(&times(stiffness)),
                    rate_gain: if coupling.damping == 0.0 {
                        Vec::new()
                    } else {
                        elastic(&times(coupling.damping))
                    },
                });
            }
        }
        torques
    }

    /// Relative rotational speed of the gears of a mesh, in units of the first gear's speed.
    fn relative_speed(&self, gears: [GearPlace; 2], layout: &Layout) -> f64 {
        let [one, two] = gears.map(|place| self.gear(place));
        let ratio = f64::from(one.teeth) / f64::from(two.teeth);
        let in_ring = one.internal || two.internal;
        let against = if in_ring { (1.0 - ratio).abs() } else { 1.0 + ratio };
        layout.mesh_speeds[self.body_of(gears[0])].abs() * against
    }

    /// Contacts besides the flanks of the first mesh.
    fn contacts(
        &self,
        solved: &Solved,
        layout: &Layout,
        assembled: &Assembled,
    ) -> Vec<StructureContact> {
        let mut contacts = Vec::new();
        let mut names = self.contact_names().into_iter().skip(2);
        let mut name = || names.next().unwrap_or_default();
        let pitch_points = layout.meshes[1..].iter().zip(&layout.cycles[1..]);
        for (mesh, (pitch_point, &cycles)) in self.meshes.iter().zip(pitch_points) {
            let terms = self.flanks(
                mesh.gears,
                (pitch_point, mesh.pressure_angle),
                layout,
                assembled,
            );
            let rubs = match &mesh.law {
                MeshLaw::OfFirst { .. } => true,
                MeshLaw::Own(flanks) => flanks.iter().any(|law| !law.friction.is_empty()),
                MeshLaw::Drawn(drawn) => drawn.friction != 0.0,
            };
            for (index, flank) in terms.iter().enumerate() {
                let feels = solved.flank(flank);
                // The coast flanks push if their deflection, with the sign of the drive flanks', falls.
                let side = [1.0, -1.0][index];
                let sided = |column: &[f64], wanted: bool| -> Vec<f64> {
                    let column = column.iter().filter(|_| wanted);
                    column.map(|w| side * w).collect()
                };
                let participation = sided(&feels.mesh, true);
                let off_middle = !matches!(mesh.law, MeshLaw::Own(_));
                contacts.push(StructureContact {
                    name: name(),
                    force: participation.clone(),
                    tilt: sided(&feels.tilt, off_middle),
                    rubbing: [&feels.friction, &feels.lever].map(|column| sided(column, rubs)),
                    sliding: self.relative_speed(mesh.gears, layout)
                        / self.relative_speed(self.gears, layout),
                    participation,
                    cycles,
                    law: match &mesh.law {
                        MeshLaw::OfFirst { phase } => ContactLaw::later(*phase),
                        MeshLaw::Own(flanks) => flanks[index].clone(),
                        MeshLaw::Drawn(drawn) => ContactLaw::later(drawn.undrawn_properties.phase),
                    },
                    copies: matches!(mesh.law, MeshLaw::OfFirst { .. }).then_some(index),
                });
            }
        }
        for (number, coupling) in self.couplings.iter().enumerate() {
            let twist = solved.contact_participation(&self.twist(number, layout, assembled));
            for stage in &coupling.stages {
                for (side, _) in stage.side.ways() {
                    let participations = twist.iter().map(|w| side * w).collect();
                    contacts.push(StructureContact::plain(
                        name(),
                        participations,
                        stage.law.clone(),
                    ));
                }
            }
        }
        for (number, coupling) in self.couplings.iter().enumerate() {
            let twist = solved.contact_participation(&self.twist(number, layout, assembled));
            for element in &coupling.hysteresis {
                let parts = StructureContact::slider("", &twist, element.stiffness, element.limit);
                contacts.extend(parts.map(|part| StructureContact {
                    name: name(),
                    ..part
                }));
            }
        }
        for (number, stop) in self.stops.iter().enumerate() {
            let mut participations =
                solved.contact_participation(&self.approach(number, assembled));
            participations[..solved.neutral.len()].fill(0.0);
            contacts.push(StructureContact::plain(
                name(),
                participations,
                stop.law.clone(),
            ));
        }
        contacts
    }
}

/// Removes the neutral rotation from the terms of a rotating frame. These terms would change centrifugal forces in
/// proportion to the small variation of the set's speed. But nothing would hold the mean speed, because no contact is
/// deflected. From any start the set would rotate at another speed than that of the mesh cycle.
fn release_neutral(structure: &mut ModalStructure) {
    if structure.frame.stiffness.is_empty() {
        return;
    }
    let modes = structure.modes();
    let gyroscopic = structure
        .coupling
        .iter_mut()
        .map(|coupling| &mut coupling.gyroscopic);
    for matrix in gyroscopic.chain([&mut structure.frame.stiffness]) {
        for (place, entry) in matrix.iter_mut().enumerate() {
            if place / modes == 0 || place % modes == 0 {
                *entry = 0.0;
            }
        }
    }
}
