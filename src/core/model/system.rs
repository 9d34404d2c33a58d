//! The model of one operating point, built from a structure and a mesh.

use super::assembly::{Assembled, Assembly};
use super::basis::Basis;
use super::contact::base_cycles;
use super::direction::Directions;
use super::error::{ModelError, check_in_range};
use super::{
    ActiveSet, BearingOutput, Block, Contact, Direction, Drive, DryFriction, Line, MeshCycle,
    MeshGain, NamedMesh, OperatingPoint, Output, Ripple, Rolling, Segment, Slider, Stop,
    TorqueRipple, TransmissionErrorHarmonic,
};
use super::{clearance, drive as laws};
use crate::structure::ModalStructure;
use std::f64::consts::TAU;

/// Names and revolutions of the shafts of a structure, as in [`Model::shafts`].
fn shafts(structure: &ModalStructure) -> Vec<(String, [u32; 2])> {
    let of_gear = |name: &str, teeth: u32| (name.to_owned(), [1, teeth]);
    let pinion = std::iter::once(of_gear("pinion", structure.teeth));
    let wheel = structure.wheel_teeth.map(|teeth| of_gear("wheel", teeth));
    (pinion.chain(wheel))
        .chain(structure.shafts.iter().cloned())
        .collect()
}

/// The piecewise-linear system at one operating point.
///
/// Rigid rotations are rotated among themselves so that at most one of them, the relative rotation, deflects the
/// mesh. Of the others, those that deflect no further contact and do not decay are [`Model::neutral`].
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// One block per mode of the structure, then one per dry slider.
    pub blocks: Vec<Block>,
    /// The distinct directions of all segments, with the gains between contacts and blocks.
    pub directions: Vec<Direction>,
    /// The distinct lines of all directions, along which deflections are measured. The mesh deflection is
    /// measured along the line of the first contact.
    pub lines: Vec<Line>,
    /// The one-sided contacts. The first two are the drive flank and the coast flank. If pairs of teeth are
    /// separate springs, the further springs of drive and coast flank follow alternately. The layers of a
    /// film of oil follow in the same way, the outermost first. The contacts of the structure are last.
    pub contacts: Vec<Contact>,
    /// Number of contacts of the two flanks: springs and layers of the film.
    pub flank_springs: usize,
    /// Number of layers of the film of oil on each flank.
    pub film_layers: usize,
    /// Indices of the rigid blocks that deflect no contact and do not decay, such as the rotation of the
    /// whole drive.
    pub neutral: Vec<usize>,
    /// Load, as a fraction of the rated load. The constant inputs of the blocks contain this fraction of
    /// `rated_input`.
    pub load: f64,
    /// Constant inputs of the blocks under rated load.
    pub rated_input: Vec<[f64; 2]>,
    /// Scale of lengths \[m\]: the half gap b of the first contact, or a given length if flanks are out of reach.
    pub half_gap: f64,
    /// Harmonics of the torques, then those of imposed motions, then those of other loads.
    pub ripple: Vec<Ripple>,
    /// Forces on the bearings.
    pub bearings: Vec<BearingOutput>,
    /// Transformation between the structure's modes and the blocks.
    pub basis: Basis,
    /// Rolling and sliding of the gears; `None` without a drawing.
    pub rolling: Option<Rolling>,
    /// Torques, accelerations and rotations at points of the structure.
    pub outputs: Vec<Output>,
    /// Effective mass m_e of an impact of the flanks along the line of action \[kg\], from
    /// [`ModalStructure::mesh_mass`].
    pub effective_mass: f64,
    /// Meshes of the structure, the first mesh first.
    pub meshes: Vec<NamedMesh>,
    /// Names of the shafts, each with `[p, q]`: p revolutions in q mesh cycles. The pinion is first, then the
    /// wheel if its teeth are known.
    pub shafts: Vec<(String, [u32; 2])>,
    /// Dry sliders in series with springs.
    pub sliders: Vec<Slider>,
    /// Rigid stops.
    pub stops: Vec<Stop>,
    /// Elements of dry friction.
    pub frictions: Vec<DryFriction>,
}

impl Model {
    /// Builds the system of a structure and a drive at an operating point.
    ///
    /// The mesh stiffness is in series with the structure's residual flexibility, `k/(1 + c_res k)`. Parallel
    /// springs share this flexibility.
    ///
    /// # Errors
    /// The variants of [`ModelError`] state the causes.
    pub fn new(
        structure: &ModalStructure,
        drive: &Drive,
        point: OperatingPoint,
    ) -> Result<Self, ModelError> {
        check_ranges(drive, point)?;
        let (basis, mut generators) = Basis::new(structure, point.speed)?;
        let film_layers = drive.film.map_or(0, |film| film.layers);
        let first_structure_contact = 2 * (1 + drive.further.len() + film_layers);
        let sliders = Slider::of_structure(structure, first_structure_contact);
        let basis = basis.with_sliders(sliders.len());
        // A slider does not move unless it slips.
        generators.resize(generators.len() + sliders.len(), [[0.0; 2]; 2]);
        let rated: Vec<f64> = (basis.turn(&structure.torque).iter())
            .map(|t| t * structure.rated_force)
            .collect();
        let load = mean_load(structure, &basis, &rated, point);
        let rated_input = basis.input(&rated);
        let blocks: Vec<Block> = (generators.into_iter().zip(basis.input(&load)))
            .map(|(generator, static_input)| Block {
                generator,
                static_input,
            })
            .collect();
        let period = TAU / (structure.cycles_per_turn() * point.speed);
        let assembly = Assembly {
            structure,
            drive,
            basis: &basis,
            blocks: &blocks,
            sliders: &sliders,
            period,
        };
        let Assembled {
            contacts,
            flank_springs,
            directions: Directions { directions, lines },
        } = assembly.contacts()?;
        clearance::has_room(&contacts, &directions)?;
        let stops = Stop::of_structure(structure, flank_springs, &contacts, &directions)?;
        let frictions =
            DryFriction::of_structure(structure, flank_springs, &contacts, &directions)?;
        let has_no_deflection =
            |i: usize| (directions.iter()).all(|d| d.gains[i].deflection[0] == 0.0);
        let neutral = (basis.rigid().iter().copied())
            .filter(|&i| {
                has_no_deflection(i) && blocks[i].generator == Block::mode(0.0, 0.0, 0.0).generator
            })
            .collect();

        let imposed = drive.imposed_motion.iter();
        let imposed = imposed.map(|motion| motion.torque(structure, period));
        let torques: Vec<TorqueRipple> = (drive.torque_ripple.iter().copied().map(Ok))
            .chain(imposed)
            .collect::<Result<_, _>>()?;
        let ripples = torques.iter().enumerate().map(|(place, torque)| {
            let ripple = Ripple::of_torque(structure, torque, period, &basis)?;
            let of_motion = place >= drive.torque_ripple.len();
            Ok(Ripple {
                of_motion,
                ..ripple
            })
        });
        let loads =
            (structure.harmonic_loads.iter()).map(|load| Ripple::of_load(load, period, &basis));
        let ripple = ripples.chain(loads).collect::<Result<_, _>>()?;
        let bearings = (structure.bearings.iter())
            .map(|bearing| BearingOutput::new(bearing, structure, &torques, point, &basis))
            .collect();
        let outputs = Output::of_structure(structure, &basis);
        let model = Self {
            blocks,
            directions,
            lines,
            contacts,
            flank_springs,
            film_layers,
            neutral,
            load: point.load,
            rated_input,
            half_gap: drive.half_gap,
            ripple,
            bearings,
            basis,
            rolling: None,
            outputs,
            effective_mass: 1.0 / inverse_mass(structure),
            meshes: NamedMesh::of_structure(structure, flank_springs),
            shafts: shafts(structure),
            sliders,
            stops,
            frictions,
        };
        model.static_equilibrium()?;
        Ok(model)
    }

    /// Contact damping `c = 2 ζ √(k_mean m_e)` \[N s/m\], with the mass m_e of
    /// [`Self::effective_mass`].
    pub fn damping_from_ratio(structure: &ModalStructure, ratio: f64, mean_stiffness: f64) -> f64 {
        2.0 * ratio * (mean_stiffness / inverse_mass(structure)).sqrt()
    }

    /// Converts a sum over the modal displacements of the structure, and the same sum over the velocities, to
    /// sums over the components of the blocks, without neutral blocks.
    pub fn block_gains_of(&self, participation: &[f64]) -> [Vec<[f64; 2]>; 2] {
        let mut gains = self.basis.output(&self.basis.turn(participation));
        for &block in &self.neutral {
            gains.iter_mut().for_each(|gain| gain[block] = [0.0; 2]);
        }
        gains
    }

    /// Number of blocks N: the modes, then the positions of dry sliders.
    pub fn modes(&self) -> usize {
        self.blocks.len()
    }

    /// Mesh period T \[s\].
    pub fn period(&self) -> f64 {
        self.contacts[0].cycles[0].period
    }

    /// The first mesh cycle of the first contact.
    pub fn first_cycle(&self) -> &MeshCycle {
        &self.contacts[0].cycles[0]
    }

    /// Mesh cycles after which all contacts repeat: their base period.
    pub fn base_cycles(&self) -> usize {
        base_cycles(&self.contacts)
    }

    /// Whether a contact is a spring or a film layer of the two flanks of the gear pair.
    pub fn of_mesh(&self, contact: usize) -> bool {
        contact < self.flank_springs
    }

    /// Whether a contact has a negative stiffness.
    pub fn has_negative_stiffness(&self) -> bool {
        let cycles = self.contacts.iter().flat_map(|contact| &contact.cycles);
        let mut segments = cycles.flat_map(|cycle| &cycle.segments);
        segments.any(|segment| segment.stiffness.mean() < 0.0)
    }

    /// All harmonics of the transmission errors.
    pub fn transmission_errors(&self) -> impl Iterator<Item = &TransmissionErrorHarmonic> {
        self.lines.iter().flat_map(|line| &line.transmission_error)
    }

    /// Gains between a contact and each block on a segment.
    pub fn gains(&self, segment: &Segment) -> &[MeshGain] {
        &self.directions[segment.direction].gains
    }

    /// The line of a segment's direction, as an index into [`Self::lines`].
    pub fn line(&self, segment: &Segment) -> usize {
        self.directions[segment.direction].line
    }

    /// Gains between the mesh and each block at the start of the mesh cycle.
    pub fn first_gains(&self) -> &[MeshGain] {
        self.gains(&self.first_cycle().segments[0])
    }

    /// Mesh deflection and its rate `(δ [m], δ' [m/s])` along the line of the first contact, in a state
    /// (length 2N) at a time \[s\] within the first mesh cycle of a base period.
    pub fn deflection(&self, state: &[f64], time: f64) -> (f64, f64) {
        self.deflection_on(self.first_cycle().segment_at(time), 0, state, time)
    }

    /// Deflection \[m\] and its rate \[m/s\] along the line of a contact's segment, at a time \[s\] within
    /// mesh cycle `cycle`, the end of the segment included.
    pub fn deflection_on(
        &self,
        segment: &Segment,
        cycle: u64,
        state: &[f64],
        time: f64,
    ) -> (f64, f64) {
        let n = self.blocks.len();
        let direction = &self.directions[segment.direction];
        let (error, error_rate) = self.lines[direction.line].transmission_error_at(cycle, time);
        let mut deflection = -error;
        let mut rate = -error_rate;
        for (i, gain) in direction.gains.iter().enumerate() {
            let (x, y) = (state[i], state[n + i]);
            let (w, r) = (gain.deflection, gain.rate);
            deflection += w[0] * x + w[1] * y;
            rate += r[0] * x + r[1] * y;
        }
        deflection += self.direct_loads(direction.line, cycle, time);
        (deflection, rate)
    }

    /// The contacts that are closed in a state at a time \[s\] within mesh cycle `cycle`, without those of
    /// rigid stops. `segments` has the segment of every contact.
    pub fn active_set(
        &self,
        segments: &[Segment],
        cycle: u64,
        state: &[f64],
        time: f64,
    ) -> ActiveSet {
        let mut active = ActiveSet::FREE;
        for (j, (contact, segment)) in self.contacts.iter().zip(segments).enumerate() {
            let release = contact.release;
            if release.of_slider() || release.of_stop() || release.of_friction() {
                continue;
            }
            let (deflection, rate) = self.deflection_on(segment, cycle, state, time);
            if contact.closes(segment, time, deflection, rate) {
                active = active.toggled(j);
            }
        }
        for &slider in &self.sliders {
            active = active.toggled(self.state_of_slider(slider, segments, (cycle, time), state));
        }
        if self.frictions.is_empty() {
            return active;
        }
        self.with_frictions(segments, active, (cycle, time), state)
    }

    /// The vector field: writes `x'` (length 2N) at a time \[s\] within mesh cycle `cycle`, with the `active`
    /// contacts closed. `segments` has the segment of every contact.
    pub fn derivative(
        &self,
        segments: &[Segment],
        active: ActiveSet,
        cycle: u64,
        time: f64,
        state: &[f64],
        out: &mut [f64],
    ) {
        let n = self.blocks.len();
        for (i, block) in self.blocks.iter().enumerate() {
            let (x, y) = (state[i], state[n + i]);
            let [a, b] = block.generator;
            let s = block.static_input;
            out[i] = a[0] * x + a[1] * y + s[0];
            out[n + i] = b[0] * x + b[1] * y + s[1];
        }
        for contact in active
            .iter()
            .filter(|contact| !self.is_constraint(*contact))
        {
            let segment = &segments[contact];
            let (deflection, rate) = self.deflection_on(segment, cycle, state, time);
            let force = self.contacts[contact].force(segment, time, deflection, rate);
            for (i, gain) in self.gains(segment).iter().enumerate() {
                out[i] -= gain.mesh_input[0] * force;
                out[n + i] -= gain.mesh_input[1] * force;
            }
        }
        for ripple in &self.ripple {
            let cos = ripple.phase_at(cycle, time).cos();
            for (i, input) in ripple.input.iter().enumerate() {
                out[i] += input[0] * cos;
                out[n + i] += input[1] * cos;
            }
        }
        self.apply_constraints(active, (cycle, time), out);
    }

    /// The same model under another load. Stiffness and friction stay those of the old load.
    ///
    /// # Errors
    /// [`ModelError::NoEquilibrium`].
    pub fn under_load(&self, load: f64) -> Result<Self, ModelError> {
        let mut model = self.clone();
        for (block, rated) in model.blocks.iter_mut().zip(&self.rated_input) {
            for (input, rated) in block.static_input.iter_mut().zip(rated) {
                *input += (load - self.load) * rated;
            }
        }
        for bearing in &mut model.bearings {
            bearing.constant += (load - self.load) * bearing.by_load;
        }
        model.load = load;
        model.static_equilibrium()?;
        Ok(model)
    }

    /// The rigid relative rotation: the last rotated rigid mode, which deflects the mesh if any does. `None` if there
    /// is no rigid mode or it is neutral.
    pub fn relative_rotation(&self) -> Option<usize> {
        (self.basis.rigid().last().copied()).filter(|i| !self.neutral.contains(i))
    }
}

/// The reciprocal of the effective mass of the mesh \[1/kg\], see [`ModalStructure::mesh_mass`].
fn inverse_mass(structure: &ModalStructure) -> f64 {
    if let Some(mass) = structure.mesh_mass {
        return 1.0 / mass;
    }
    let sum = |rigid_only: bool| -> f64 {
        (structure.mesh.iter().zip(&structure.frequency))
            .filter(|(_, frequency)| !rigid_only || **frequency == 0.0)
            .map(|(w, _)| w * w)
            .sum()
    };
    let of_rigid = sum(true);
    if of_rigid > 0.0 { of_rigid } else { sum(false) }
}

/// Rejects an operating point or a drive with a value out of its range.
fn check_ranges(drive: &Drive, point: OperatingPoint) -> Result<(), ModelError> {
    check_in_range("speed", point.speed, point.speed > 0.0, "above 0 rad/s")?;
    check_in_range("load", point.load, true, "finite")?;
    check_in_range(
        "half gap",
        drive.half_gap,
        drive.half_gap > 0.0,
        "above 0 m",
    )?;
    check_in_range(
        "damping",
        drive.damping,
        drive.damping >= 0.0,
        "at least 0 N s/m",
    )?;
    if let Some(film) = &drive.film {
        film.check()?;
    }
    let cycles = || {
        let coast = drive.coast.iter();
        let coast = coast.flat_map(|coast| std::iter::once(&coast.mesh).chain(&coast.further));
        std::iter::once(&drive.mesh)
            .chain(&drive.further)
            .chain(coast)
            .chain(drive.tooth_cycles.iter().flatten().flatten())
    };
    // A minimum that keeps a NaN.
    let smallest = (cycles().flatten())
        .map(|division| division.stiffness.smallest())
        .fold(f64::INFINITY, |least, k| {
            if k < least || k.is_nan() { k } else { least }
        });
    check_in_range("mesh stiffness", smallest, smallest > 0.0, "above 0 N/m")?;
    for cycle in cycles() {
        laws::ends_are_in_order(cycle)?;
    }
    Ok(())
}

/// Mean modal forces on the rotated modes: the load times the rated forces, constant loads, and loads due to
/// the speed.
fn mean_load(
    structure: &ModalStructure,
    basis: &Basis,
    rated: &[f64],
    point: OperatingPoint,
) -> Vec<f64> {
    let mut load: Vec<f64> = rated.iter().map(|t| t * point.load).collect();
    // Add constant loads, mean drag and the load of a rotating frame.
    let speed = point.speed;
    for (factor, column) in [
        (1.0, &structure.constant_load),
        (speed, &structure.load_by_speed),
        (speed * speed, &structure.frame.load),
    ] {
        for (load, value) in load.iter_mut().zip(rotate_any(basis, column)) {
            *load += factor * value;
        }
    }
    load
}

/// Converts values per mode to the rotated modes. An empty list stays empty.
fn rotate_any(basis: &Basis, values: &[f64]) -> Vec<f64> {
    if values.is_empty() { Vec::new() } else { basis.turn(values) }
}

#[cfg(test)]
mod tests;
