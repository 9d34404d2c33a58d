//! The model of one operating point, built from a structure and a mesh.

use super::direction::Participations;
use super::{
    Block, Contact, Division, Drive, DriveShaft, MeshCycle, MeshGain, OperatingPoint, Ripple,
    Segment, TorqueRipple, TransmissionErrorHarmonic,
};
use crate::shaft::{BearingGain, ModalStructure};
use std::f64::consts::TAU;

/// Why a model cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// A block has two real eigenvalues.
    #[error(
        "mode {mode} is overdamped (damping ratio {ratio}); give a ratio below 1 or leave the mode out"
    )]
    Overdamped {
        /// Mode, counted from 1.
        mode: usize,
        /// Its damping ratio.
        ratio: f64,
    },
    /// A torque ripple on a shaft whose participation is unknown.
    #[error(
        "torque ripple on the {shaft} shaft, but the structure has no torque participation for it; add `torque_{shaft}` to the modal file"
    )]
    UnknownShaft {
        /// `pinion` or `wheel`.
        shaft: &'static str,
    },
    /// Modes that are coupled, or loaded by a drag.
    #[error("coupled modes and drag are not taken yet; leave them out of the structure")]
    Coupled,
    /// A quantity outside its physical range.
    #[error("{name} is {value}, but must be {accepted}")]
    OutOfRange {
        /// Which quantity.
        name: &'static str,
        /// Its value, SI.
        value: f64,
        /// What would be accepted.
        accepted: &'static str,
    },
}

/// Tilt of a rotation about the shafts this small, relative to the largest of any mode, is
/// round-off.
const TILT_NOISE: f64 = 1e-9;

/// The piecewise-linear system at one operating point.
///
/// Rigid rotations are rotated among themselves so that at most one of them, the relative
/// rotation, is felt by the mesh; the others are [`Model::neutral`].
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// The structure, one block a mode.
    pub blocks: Vec<Block>,
    /// How the mesh meets the blocks, one entry a block: the distinct directions of the
    /// segments; most drives have one.
    pub directions: Vec<Vec<MeshGain>>,
    /// Blocks that the mesh does not feel and that do not decay (rigid rotation of the
    /// whole drive).
    pub neutral: Vec<usize>,
    /// The mesh cycle.
    pub cycle: MeshCycle,
    /// Load, as a fraction of the rated one: the constant inputs of the blocks are so much of
    /// `rated_input`.
    pub load: f64,
    /// Constant inputs of the blocks under rated load.
    pub rated_input: Vec<[f64; 2]>,
    /// Backlash half gap b \[m\]; what loaded flanks lack comes on top ([`Self::gap_on`]).
    pub half_gap: f64,
    /// Harmonics of the static transmission error.
    pub transmission_error: Vec<TransmissionErrorHarmonic>,
    /// Harmonics of the torques.
    pub ripple: Vec<Ripple>,
    /// What the bearings feel: forces per unit first component of each block.
    pub bearings: Vec<BearingGain>,
    /// Rows: this model's rigid blocks in the structure's rigid modes (orthogonal).
    rigid_basis: Vec<Vec<f64>>,
    /// Indices of the structure's rigid modes.
    rigid: Vec<usize>,
}

impl Model {
    /// Builds the system of a structure and a drive at an operating point.
    ///
    /// Stiffness is put in series with the structure's residual flexibility,
    /// `k/(1 + c_res k)`.
    ///
    /// # Errors
    /// An overdamped mode, ripple on a shaft the structure does not know, or a value out
    /// of its range.
    pub fn new(
        structure: &ModalStructure,
        drive: &Drive,
        point: OperatingPoint,
    ) -> Result<Self, ModelError> {
        if !structure.is_uncoupled() {
            return Err(ModelError::Coupled);
        }
        let positive = |name, value: f64, ok: bool, accepted| {
            if ok && value.is_finite() {
                Ok(())
            } else {
                Err(ModelError::OutOfRange {
                    name,
                    value,
                    accepted,
                })
            }
        };
        positive("speed", point.speed, point.speed > 0.0, "above 0 rad/s")?;
        positive("load", point.load, true, "finite")?;
        positive(
            "half gap",
            drive.half_gap,
            drive.half_gap > 0.0,
            "above 0 m",
        )?;
        positive(
            "damping",
            drive.damping,
            drive.damping >= 0.0,
            "at least 0 N s/m",
        )?;
        let smallest = (drive.mesh.iter())
            .map(|division| division.stiffness.smallest())
            .fold(f64::INFINITY, f64::min);
        positive("mesh stiffness", smallest, smallest > 0.0, "above 0 N/m")?;
        let mut before = 0.0;
        for division in &drive.mesh {
            let inside = before < division.end && division.end <= 1.0;
            positive(
                "mesh transition",
                division.end,
                inside,
                "between its neighbours",
            )?;
            before = division.end;
        }
        positive("end of the mesh cycle", before, before == 1.0, "1")?;

        let rigid: Vec<usize> = (0..structure.modes())
            .filter(|&i| structure.frequency[i] == 0.0)
            .collect();
        let rigid_basis = rigid_basis(&rigid, &structure.mesh);
        let rotate = |values: &[f64]| rotate_rigid(&rigid, &rigid_basis, values);

        let mut mesh = rotate(&structure.mesh);
        let mut tilt = rotate(&structure.mesh_tilt);
        if let Some((_, felt)) = rigid.split_last() {
            let noise = TILT_NOISE * tilt.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
            for &i in felt {
                // Round-off of the rotation; the basis makes these zero by construction.
                mesh[i] = 0.0;
                // A rotation about the shafts does not tilt them.
                if tilt[i].abs() <= noise {
                    tilt[i] = 0.0;
                }
            }
        }
        let rated_input: Vec<[f64; 2]> = rotate(&structure.torque)
            .iter()
            .map(|t| [0.0, t * structure.rated_force])
            .collect();

        let mut blocks = Vec::with_capacity(structure.modes());
        for i in 0..structure.modes() {
            let (frequency, ratio) = (structure.frequency[i], structure.damping[i]);
            let block = Block::mode(frequency, ratio, rated_input[i][1] * point.load);
            if block.damped_frequency().is_none() {
                return Err(ModelError::Overdamped { mode: i + 1, ratio });
            }
            blocks.push(block);
        }
        let participations = Participations {
            mesh,
            tilt,
            friction: rotate(&structure.friction),
            lever: rotate(&structure.friction_lever),
        };
        let (directions, which) = participations.directions(drive, &blocks);
        let unfelt = |i: usize| directions.iter().all(|gains| gains[i].deflection[0] == 0.0);
        let neutral = rigid.iter().copied().filter(|&i| unfelt(i)).collect();

        let mesh: Vec<_> = (drive.mesh.iter())
            .map(|division| Division {
                stiffness: (division.stiffness).in_series_with(structure.residual_flexibility),
                ..*division
            })
            .collect();
        let period = TAU / (f64::from(structure.teeth) * point.speed);
        let transmission_error = drive
            .transmission_error
            .iter()
            .map(|h| TransmissionErrorHarmonic {
                angular_frequency: TAU * f64::from(h.harmonic) / period,
                amplitude: h.amplitude,
                phase: h.phase,
            })
            .collect();
        let ripple = drive
            .torque_ripple
            .iter()
            .map(|r| ripple(structure, r, period, rotate))
            .collect::<Result<_, _>>()?;
        let bearings = (structure.bearings.iter())
            .map(|bearing| BearingGain {
                name: bearing.name.clone(),
                gain: rotate(&bearing.gain),
            })
            .collect();
        Ok(Self {
            blocks,
            directions,
            neutral,
            cycle: MeshCycle::new(period, &mesh, &which, drive.damping),
            load: point.load,
            rated_input,
            half_gap: drive.half_gap,
            transmission_error,
            ripple,
            bearings,
            rigid_basis,
            rigid,
        })
    }

    /// Contact damping `c = 2 ζ √(k_mean m_e)` \[N s/m\], `1/m_e = Σ mesh²` over the rigid
    /// modes, over all modes where no rigid mode is felt by the mesh.
    pub fn damping_from_ratio(structure: &ModalStructure, ratio: f64, mean_stiffness: f64) -> f64 {
        let sum = |rigid_only: bool| -> f64 {
            structure
                .mesh
                .iter()
                .zip(&structure.frequency)
                .filter(|(_, f)| !rigid_only || **f == 0.0)
                .map(|(w, _)| w * w)
                .sum()
        };
        let inverse_mass = if sum(true) > 0.0 {
            sum(true)
        } else {
            sum(false)
        };
        2.0 * ratio * (mean_stiffness / inverse_mass).sqrt()
    }

    /// Number of modes N.
    pub fn modes(&self) -> usize {
        self.blocks.len()
    }

    /// Mesh period T \[s\].
    pub fn period(&self) -> f64 {
        self.cycle.period
    }

    /// Static transmission error and its rate, `(e [m], e' [m/s])`, at a time \[s\] within the
    /// mesh cycle.
    pub fn transmission_error_at(&self, time: f64) -> (f64, f64) {
        let mut error = 0.0;
        let mut rate = 0.0;
        for h in &self.transmission_error {
            let (sin, cos) = (h.angular_frequency * time + h.phase).sin_cos();
            error += h.amplitude * cos;
            rate -= h.amplitude * h.angular_frequency * sin;
        }
        (error, rate)
    }

    /// How the mesh meets each block on a segment.
    pub fn gains(&self, segment: &Segment) -> &[MeshGain] {
        &self.directions[segment.direction]
    }

    /// How the mesh meets each block at the start of the mesh cycle.
    pub fn first_gains(&self) -> &[MeshGain] {
        self.gains(&self.cycle.segments[0])
    }

    /// Mesh deflection and rate `(δ [m], δ' [m/s])` of a state (length 2N) at a time \[s\]
    /// within the mesh cycle.
    pub fn deflection(&self, state: &[f64], time: f64) -> (f64, f64) {
        self.deflection_on(self.cycle.segment_at(time), state, time)
    }

    /// As [`Self::deflection`], on a given segment: at its end too.
    pub fn deflection_on(&self, segment: &Segment, state: &[f64], time: f64) -> (f64, f64) {
        let n = self.blocks.len();
        let (error, error_rate) = self.transmission_error_at(time);
        let mut deflection = -error;
        let mut rate = -error_rate;
        for (i, gain) in self.gains(segment).iter().enumerate() {
            let (x, y) = (state[i], state[n + i]);
            let (w, r) = (gain.deflection, gain.rate);
            deflection += w[0] * x + w[1] * y;
            rate += r[0] * x + r[1] * y;
        }
        (deflection, rate)
    }

    /// Half gap \[m\] and its rate \[m/s\] at a time \[s\] within a segment, its ends included.
    pub fn gap_on(&self, segment: &Segment, time: f64) -> [f64; 2] {
        let [error, slope] = segment.error_at(time / self.cycle.period);
        [self.half_gap + error, slope / self.cycle.period]
    }

    /// Mesh force \[N\] for a deflection and its rate in a contact state on a segment, at a
    /// time \[s\] within the mesh cycle.
    pub fn force(
        &self,
        segment: &Segment,
        contact: Contact,
        time: f64,
        deflection: f64,
        rate: f64,
    ) -> f64 {
        if contact.touching() {
            let [gap, opening] = self.gap_on(segment, time);
            segment.stiffness_at(time / self.cycle.period) * (deflection - contact.sign() * gap)
                + segment.damping * (rate - contact.sign() * opening)
        } else {
            0.0
        }
    }

    /// The vector field: writes `x'` (length 2N) at a time \[s\] within mesh cycle `cycle`, on
    /// a given segment and in a given contact state.
    pub fn derivative(
        &self,
        segment: &Segment,
        contact: Contact,
        cycle: u64,
        time: f64,
        state: &[f64],
        out: &mut [f64],
    ) {
        let n = self.blocks.len();
        let (deflection, rate) = self.deflection_on(segment, state, time);
        let force = self.force(segment, contact, time, deflection, rate);
        for (i, (block, gain)) in self.blocks.iter().zip(self.gains(segment)).enumerate() {
            let (x, y) = (state[i], state[n + i]);
            let [a, b] = block.generator;
            let g = gain.mesh_input;
            let s = block.static_input;
            out[i] = a[0] * x + a[1] * y - g[0] * force + s[0];
            out[n + i] = b[0] * x + b[1] * y - g[1] * force + s[1];
        }
        for ripple in &self.ripple {
            let cos = ripple.phase_at(cycle, time).cos();
            for (i, input) in ripple.input.iter().enumerate() {
                out[i] += input[0] * cos;
                out[n + i] += input[1] * cos;
            }
        }
    }

    /// The rigid relative rotation: the rigid block that the mesh feels.
    pub fn relative_rotation(&self) -> Option<usize> {
        self.rigid
            .last()
            .copied()
            .filter(|i| !self.neutral.contains(i))
    }

    /// Modal values of the structure in this model's basis.
    pub fn from_structure(&self, values: &[f64]) -> Vec<f64> {
        rotate_rigid(&self.rigid, &self.rigid_basis, values)
    }

    /// Modal values of this model in the structure's basis: undoes [`Self::from_structure`].
    pub fn to_structure(&self, values: &[f64]) -> Vec<f64> {
        let mut out = values.to_vec();
        for (j, &target) in self.rigid.iter().enumerate() {
            out[target] = self
                .rigid_basis
                .iter()
                .zip(&self.rigid)
                .map(|(row, &i)| row[j] * values[i])
                .sum();
        }
        out
    }
}

/// Orthonormal rows spanning the rigid modes, the last one along their mesh participation:
/// all others have none.
fn rigid_basis(rigid: &[usize], mesh: &[f64]) -> Vec<Vec<f64>> {
    let n = rigid.len();
    let identity = |i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect();
    let w: Vec<f64> = rigid.iter().map(|&i| mesh[i]).collect();
    let norm = w.iter().map(|v| v * v).sum::<f64>().sqrt();
    if norm == 0.0 {
        return (0..n).map(identity).collect();
    }
    // Householder reflection that sends w/|w| to the last axis.
    let side = if w[n - 1] > 0.0 { 1.0 } else { -1.0 };
    let mut v: Vec<f64> = w.iter().map(|x| x / norm).collect();
    v[n - 1] += side;
    let square: f64 = v.iter().map(|x| x * x).sum();
    (0..n)
        .map(|i| {
            let flip = if i == n - 1 { -side } else { 1.0 };
            (0..n)
                .map(|j| flip * (f64::from(u8::from(i == j)) - 2.0 * v[i] * v[j] / square))
                .collect()
        })
        .collect()
}

/// `values` with its rigid entries expressed in the rows of `basis`.
fn rotate_rigid(rigid: &[usize], basis: &[Vec<f64>], values: &[f64]) -> Vec<f64> {
    let mut out = values.to_vec();
    for (row, &target) in basis.iter().zip(rigid) {
        out[target] = row.iter().zip(rigid).map(|(b, &i)| b * values[i]).sum();
    }
    out
}

/// The block inputs of one torque ripple.
fn ripple(
    structure: &ModalStructure,
    input: &TorqueRipple,
    period: f64,
    rotate: impl Fn(&[f64]) -> Vec<f64>,
) -> Result<Ripple, ModelError> {
    let (name, participation, teeth) = match input.shaft {
        DriveShaft::Pinion => ("pinion", &structure.pinion_torque, Some(structure.teeth)),
        DriveShaft::Wheel => ("wheel", &structure.wheel_torque, structure.wheel_teeth),
    };
    let (Some(participation), Some(teeth)) = (participation, teeth) else {
        return Err(ModelError::UnknownShaft { shaft: name });
    };
    let turns_per_cycle = input.order / f64::from(teeth);
    Ok(Ripple {
        angular_frequency: TAU * turns_per_cycle / period,
        turns_per_cycle,
        phase: input.phase,
        input: rotate(participation)
            .iter()
            .map(|p| [0.0, p * input.amplitude])
            .collect(),
    })
}

#[cfg(test)]
mod tests;
