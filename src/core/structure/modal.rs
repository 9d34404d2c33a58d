//! Which quantities describe a linear structure? Frequencies, damping, participations.

use crate::structure::{
    FrictionPart, MeshHarmonic, ModeShapes, OmittedModeForces, SliderPart, StopPart,
};
use std::sync::Arc;

/// Largest p and largest q of a contact that has p cycles in q cycles of the first mesh. Its tables grow with
/// p and q.
pub const MOST_RATIO_CYCLES: u32 = 10_000;

/// Largest number of mesh cycles after which all contacts repeat: tables take some megabytes per hundred cycles.
pub const MOST_BASE_CYCLES: usize = 10_000;

/// A row of a coupling matrix adds a direction only if its new part exceeds this fraction of the largest entry
/// of the matrix. A smaller part is round-off.
const COUPLING_NOISE: f64 = 1e-12;

/// The participations of a further contact in the rigid rotations add a direction only if their new part exceeds
/// this fraction of the contact's largest participation. A smaller part is round-off.
const ROTATION_NOISE: f64 = 1e-10;

/// The requested number of modes is too large or too small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{requested} modes are requested, but between {least} and {available} are possible")]
pub struct ModeCount {
    /// Requested number of modes.
    pub requested: usize,
    /// Smallest possible number.
    pub least: usize,
    /// Largest possible number.
    pub available: usize,
}

/// A linear structure in mass-normalised modal coordinates, as seen by the gear mesh.
///
/// Vectors of numbers have one entry per mode, in ascending order of frequency. Mode `i` obeys
/// `q'' + 2 ζ ω q' + ω² q = torque·F₀ − mesh·F + …` with `F₀` the static and `F` the
/// actual mesh force \[N\]; `q` is in m √kg. A [`Coupling`] adds its terms
/// `(C + Ω G) q' + K_c q` of all modes on the left, with the pinion's speed Ω.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ModalStructure {
    /// Teeth of the pinion: mesh order per pinion revolution.
    pub teeth: u32,
    /// Teeth of the wheel, if known (needed for ripple on the wheel's shaft).
    pub wheel_teeth: Option<u32>,
    /// The frame in which the axes of the meshes are fixed.
    pub frame: TurningFrame,
    /// Mesh force at load = 1 \[N\].
    pub rated_force: f64,
    /// Undamped natural frequency ω \[rad/s\]; 0 for a rigid rotation.
    pub frequency: Vec<f64>,
    /// Modal damping ratio ζ \[1\], `0 ≤ ζ < 1`.
    pub damping: Vec<f64>,
    /// Participation of the mesh deflection, along the line of action of the drive flanks
    /// \[1/√kg\].
    pub mesh: Vec<f64>,
    /// Derivative of `mesh` with respect to the load centroid z_c \[1/(m √kg)\].
    pub mesh_tilt: Vec<f64>,
    /// Modal force of a unit static mesh force \[1/√kg\]: torques `+r₁` on the pinion
    /// side and `−r₂` on the wheel side.
    pub torque: Vec<f64>,
    /// Modal force of a unit torque on the pinion's shaft \[1/(m √kg)\], if known.
    pub pinion_torque: Option<Vec<f64>>,
    /// Modal force of a unit torque on the wheel's shaft \[1/(m √kg)\], if known.
    pub wheel_torque: Option<Vec<f64>>,
    /// Participation of a unit friction force \[1/√kg\].
    pub friction: Vec<f64>,
    /// Derivative of this participation with respect to the position along the path of contact \[1/(m √kg)\].
    pub friction_lever: Vec<f64>,
    /// Static flexibility of the omitted modes, `Σ mesh²/ω²` \[m/N\]; 0 if no mode is omitted, or without
    /// modal-truncation augmentation.
    pub residual_flexibility: f64,
    /// Static tilt of the flanks by the omitted modes, `[Σ w w₁/ω², Σ w₁²/ω²]` \[rad/N, rad/(N m)\], with the
    /// participations w and w₁ of deflection and tilt. One entry for the drive flanks, one for the coast flanks, then
    /// one for each of `contacts`. Empty if no mode is omitted.
    #[serde(skip)]
    pub tilt_residuals: Vec<[f64; 2]>,
    /// Mass of the mesh along the line of action \[kg\]. `None` stands for `1/Σ mesh²` over the rigid modes, or over
    /// all modes if no rigid one deflects the mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_mass: Option<f64>,
    /// Participations of the coast flanks, with the sign of the drive flanks': their deflection grows
    /// as the drive flanks approach, and they touch where it falls to minus the half gap. `None`
    /// if their line of action is unknown.
    pub coast: Option<FlankParticipation>,
    /// Contacts besides the two flanks of the mesh.
    pub contacts: Vec<StructureContact>,
    /// Forces on the bearings by the modes, if known.
    pub bearings: Vec<BearingGain>,
    /// Torques in shafts and couplings, if known.
    pub torques: Vec<TorqueGain>,
    /// Motions that the results may contain: accelerations of points and bodies, rotations of gears.
    pub motions: Vec<PlaceMotion>,
    /// Coupling of the modes; `None` if damping is modal and there are no other terms.
    pub coupling: Option<Coupling>,
    /// Modal force that does not depend on the load \[N/√kg\], such as that of a constant
    /// drag; empty for none.
    pub constant_load: Vec<f64>,
    /// Modal force per pinion speed \[N s/(rad √kg)\], such as that of a viscous drag at the mean speed;
    /// empty for none.
    pub load_by_speed: Vec<f64>,
    /// Loads that vary with time.
    pub harmonic_loads: Vec<HarmonicLoad>,
    /// Names of the meshes, the first mesh first; empty with a single mesh. The flanks of the other meshes
    /// are the first entries of `contacts`, two per mesh.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<String>,
    /// Names of the shafts besides those of the first mesh, each with `[p, q]`: p revolutions in q mesh
    /// cycles.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shafts: Vec<(String, [u32; 2])>,
    /// Shapes of the modes in the freedoms from which the structure was assembled. `None` if these freedoms are
    /// unknown, as for a modal file.
    #[serde(skip)]
    pub shapes: Option<Arc<ModeShapes>>,
}

/// A load `force cos(2π turns_per_cycle t/T + phase)` with the mesh period T.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct HarmonicLoad {
    /// Its name.
    pub name: String,
    /// Amplitude of the modal force, one entry per mode \[N/√kg\].
    pub force: Vec<f64>,
    /// Turns of its phase per mesh cycle, > 0; need not be rational.
    pub turns_per_cycle: f64,
    /// Phase at time 0 \[rad\].
    pub phase: f64,
}

/// Coupling of the modes, and damping beyond their ratios:
/// `q'' + (2 ζ ω + C + Ω G) q' + (ω² + K_c) q = …`. Matrices N × N, row by row.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Coupling {
    /// C \[1/s\], adds to `2 ζ ω` on the diagonal.
    pub damping: Vec<f64>,
    /// G \[1\], times the pinion's speed Ω \[rad/s\]; skew, `G_ji = −G_ij`.
    pub gyroscopic: Vec<f64>,
    /// K_c \[1/s²\], adds to `ω²` on the diagonal: cross-coupled springs, in general not
    /// symmetric.
    pub stiffness: Vec<f64>,
}

impl Coupling {
    /// The coupling of the first `retained` of `modes` modes.
    fn leading(&self, modes: usize, retained: usize) -> Self {
        let keep = |matrix: &[f64]| leading_part(matrix, modes, retained);
        Self {
            damping: keep(&self.damping),
            gyroscopic: keep(&self.gyroscopic),
            stiffness: keep(&self.stiffness),
        }
    }
}

/// Rows and columns of the first `retained` of `modes` modes in a matrix. An empty matrix gives an empty
/// result.
fn leading_part(matrix: &[f64], modes: usize, retained: usize) -> Vec<f64> {
    let rows = matrix.chunks_exact(modes).take(retained);
    rows.flat_map(|row| &row[..retained]).copied().collect()
}

/// A frame that rotates with the carrier of planets, and its contribution to the equations of motion: `Ω² (K_f q − f)`
/// on the left, with the speed Ω of an operating point, which is the driver's. Coriolis terms are among the gyroscopic
/// ones of [`Coupling`].
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TurningFrame {
    /// Speed of the first gear relative to the carrier, in units of Ω; 1 if the frame is fixed.
    pub rolling: f64,
    /// K_f, N × N row by row \[1\]; empty for none.
    pub stiffness: Vec<f64>,
    /// f, one entry per mode \[m √kg\]: centrifugal forces on planets; empty for none.
    pub load: Vec<f64>,
}

impl Default for TurningFrame {
    fn default() -> Self {
        Self {
            rolling: 1.0,
            stiffness: Vec::new(),
            load: Vec::new(),
        }
    }
}

impl TurningFrame {
    fn leading(&self, modes: usize, retained: usize) -> Self {
        Self {
            rolling: self.rolling,
            stiffness: leading_part(&self.stiffness, modes, retained),
            load: self.load.iter().take(retained).copied().collect(),
        }
    }
}

/// A one-sided contact of a structure besides the two flanks of its mesh: a further flank, a stop, a
/// stage of a spring. It closes where `δ = Σ participation q − e` rises to its gap b, with the force
/// `F = k (δ − b) + c δ'`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct StructureContact {
    /// Its name.
    pub name: String,
    /// Participation of its deflection, one entry per mode \[1/√kg\].
    pub participation: Vec<f64>,
    /// Modal force of a unit contact force with the sign reversed, one entry per mode \[1/√kg\]. It excludes
    /// `rubbing`, and usually equals the participation.
    pub force: Vec<f64>,
    /// Derivative of participation and force with respect to the load centroid z_c \[1/(m √kg)\]; empty for
    /// mid-face.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tilt: Vec<f64>,
    /// Contribution of friction to `force`, per Λ₀ \[1/√kg\] and per Λ₁ \[1/(m √kg)\] of
    /// [`ContactLaw::friction`]; empty without friction.
    #[serde(skip_serializing_if = "no_friction")]
    pub rubbing: [Vec<f64>; 2],
    /// Relative rotational speed of its two gears, divided by that of the gears of the first mesh \[1\]; 0 if
    /// the contact is not a mesh.
    #[serde(skip_serializing_if = "is_zero")]
    pub sliding: f64,
    /// Number of its cycles, `[p, q]`: p cycles in q cycles of the mesh.
    pub cycles: [u32; 2],
    /// Its force law.
    pub law: ContactLaw,
    /// The flank of the first mesh whose law it copies, 0 for the drive flank and 1 for the coast flank. Of
    /// `law` only the phase then has an effect. `rubbing` is for a friction coefficient of 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub copies: Option<usize>,
}

impl StructureContact {
    /// A contact whose force acts along its deflection, without friction, with one cycle per mesh cycle.
    pub fn plain(name: String, participation: Vec<f64>, law: ContactLaw) -> Self {
        Self {
            name,
            force: participation.clone(),
            participation,
            tilt: Vec::new(),
            rubbing: Default::default(),
            sliding: 0.0,
            cycles: [1, 1],
            law,
            copies: None,
        }
    }
}

#[cfg(test)]
impl StructureContact {
    /// A stop without friction, with a gap \[m\] and a constant stiffness \[N/m\], for tests.
    pub fn stop(participation: &[f64], gap: f64, stiffness: f64) -> Self {
        let mut series = [0.0; 8];
        series[0] = stiffness;
        let law = ContactLaw {
            gap,
            stiffness: vec![(1.0, series)],
            damping: 50.0,
            ..ContactLaw::default()
        };
        Self::plain("stop".to_owned(), participation.to_vec(), law)
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde asks for a reference"
)]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

fn no_friction(rubbing: &[Vec<f64>; 2]) -> bool {
    rubbing.iter().all(Vec::is_empty)
}

/// Force of a one-sided contact as a function of its deflection.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct ContactLaw {
    /// Gap b \[m\]; a negative one is a preload.
    pub gap: f64,
    /// Stiffness k over its cycle: for each piece the phase at its end, and the Legendre coefficients of k on
    /// it \[N/m\].
    pub stiffness: Vec<(f64, [f64; 8])>,
    /// Direction Λ₀ \[1\] and lever Λ₁ \[m\] of friction over each piece of `stiffness`; empty without friction.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub friction: Vec<[f64; 2]>,
    /// Load centroid z_c over each piece of `stiffness` \[m\]; empty for mid-face.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub centres: Vec<f64>,
    /// Error of the loaded flanks over each piece of `stiffness`, added to the gap: Legendre coefficients \[m\];
    /// empty for none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lacking: Vec<[f64; 8]>,
    /// Damping c \[N s/m\].
    pub damping: f64,
    /// Phase in its cycle at the start of mesh cycle 0, in cycles.
    pub phase: f64,
    /// Harmonics of its error e; phases count from phase 0 of its cycle.
    pub error: Vec<MeshHarmonic>,
    /// The state of a dry slider that the contact represents; `None` for other contacts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slider: Option<SliderPart>,
    /// The part of a rigid stop that the contact represents; `None` for other contacts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop: Option<StopPart>,
    /// The state of an element of dry friction that the contact represents; `None` for other contacts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dry_friction: Option<FrictionPart>,
}

impl ContactLaw {
    /// A law of which only the phase \[cycles\] is known. The copied flank of the first mesh, or the load,
    /// determines the rest later.
    pub fn later(phase: f64) -> Self {
        Self {
            phase,
            ..Self::default()
        }
    }

    /// Whether its stiffness is the same over its whole cycle.
    pub fn is_constant(&self) -> bool {
        let level = |series: &[f64; 8]| series[1..].iter().all(|term| *term == 0.0);
        let mut pieces = self.stiffness.iter().map(|(_, series)| series);
        pieces.all(|series| level(series) && *series == self.stiffness[0].1)
    }
}

/// Participations of the flanks of one side, one entry per mode.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FlankParticipation {
    /// Participation of the deflection along the line of action \[1/√kg\].
    pub mesh: Vec<f64>,
    /// Derivative of `mesh` with respect to the load centroid z_c \[1/(m √kg)\].
    pub tilt: Vec<f64>,
    /// Participation of a unit friction force \[1/√kg\].
    pub friction: Vec<f64>,
    /// Derivative of this participation with respect to the position along the path of contact \[1/(m √kg)\].
    pub lever: Vec<f64>,
    /// Static flexibility of the omitted modes, `Σ mesh²/ω²` \[m/N\].
    pub residual_flexibility: f64,
}

impl FlankParticipation {
    /// Its first `retained` modes. With `mta`, the static flexibility of the other modes is added to the
    /// residual one; without it the residual flexibility is 0.
    fn truncated(&self, frequency: &[f64], retained: usize, mta: bool) -> Self {
        let keep = |column: &[f64]| column[..retained].to_vec();
        let left_out = self.mesh[retained..].iter().zip(&frequency[retained..]);
        let added: f64 = left_out.map(|(w, omega)| (w / omega).powi(2)).sum();
        Self {
            mesh: keep(&self.mesh),
            tilt: keep(&self.tilt),
            friction: keep(&self.friction),
            lever: keep(&self.lever),
            residual_flexibility: if mta { self.residual_flexibility + added } else { 0.0 },
        }
    }
}

/// The force of a shaft on one bearing in one direction, `Σ gain·q + Σ rate_gain·q'` \[N\], from the springs
/// and dampers of the bearing. Modal damping has no place in the structure and is not included.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BearingGain {
    /// Shaft, bearing and direction, such as `pinion 1 x`.
    pub name: String,
    /// Force per unit modal displacement \[N/(m √kg)\], one entry per mode.
    pub gain: Vec<f64>,
    /// Force per unit modal velocity \[N s/(m √kg)\], one entry per mode; empty for none.
    pub rate_gain: Vec<f64>,
    /// Static contribution of the omitted modes.
    pub left_out: OmittedModeForces,
}

/// The torque in a shaft or a coupling, `Σ gain·q + Σ rate_gain·q'` \[N m\], of its spring and its damper, in the
/// direction of rotation. In a drive of two shafts a positive torque acts from the motor on the pinion and from the
/// wheel on the load; in a train, in a shaft from the lower position on the higher one, in a coupling from its first
/// shaft on the second.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TorqueGain {
    /// Shaft or coupling.
    pub name: String,
    /// Torque per unit modal displacement \[N/√kg\], one entry per mode.
    pub gain: Vec<f64>,
    /// Torque per unit modal velocity \[N s/√kg\], one entry per mode; empty for none.
    pub rate_gain: Vec<f64>,
}

/// Kind of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum MotionKind {
    /// Displacement of a bearing's position, in one direction.
    Place,
    /// Rotation of a body, at the node on which its torque acts.
    Body,
    /// Rotation of a gear.
    Gear,
}

/// A motion, `Σ gain·q`: a displacement in one direction, or a rotation in the direction of running, relative to the
/// mean rotation.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PlaceMotion {
    /// Shaft, bearing and direction, such as `pinion 1 x`; for a rotation the shaft or the gear.
    pub name: String,
    /// Its kind.
    pub kind: MotionKind,
    /// Displacement \[1/√kg\] or angle \[1/(m √kg)\] per unit modal displacement, one entry per mode.
    pub gain: Vec<f64>,
}

impl BearingGain {
    /// Static contribution of the omitted modes, if the modes of `structure` after the first `retained` are
    /// omitted too.
    fn forces_of_omitted_modes(
        &self,
        structure: &ModalStructure,
        retained: usize,
    ) -> OmittedModeForces {
        let known = &self.left_out;
        let share = |before: f64, column: &[f64]| -> f64 {
            let terms = self.gain.iter().zip(&structure.frequency).zip(column);
            let added: f64 = (terms.skip(retained))
                .map(|((gain, frequency), force)| gain * force / (frequency * frequency))
                .sum();
            before + added
        };
        let flank = |before: [f64; 4], flank: &FlankParticipation| -> [f64; 4] {
            let columns = [&flank.mesh, &flank.tilt, &flank.friction, &flank.lever];
            std::array::from_fn(|i| share(before[i], columns[i]))
        };
        let optional = |before: f64, column: &Option<Vec<f64>>| {
            column
                .as_deref()
                .map_or(before, |column| share(before, column))
        };
        let each = |before: &[f64], columns: Vec<&[f64]>| -> Vec<f64> {
            (columns.into_iter().enumerate())
                .map(|(i, column)| share(before.get(i).copied().unwrap_or(0.0), column))
                .collect()
        };
        let [pinion, wheel] = known.shaft_torques;
        OmittedModeForces {
            drive: flank(known.drive, &structure.drive_flank()),
            coast: (structure.coast.as_ref())
                .map_or(known.coast, |coast| flank(known.coast, coast)),
            contacts: (structure.contacts.iter().enumerate())
                .map(|(number, contact)| {
                    let before = known.contacts.get(number).copied().unwrap_or_default();
                    let [along, lever] = &contact.rubbing;
                    let columns = [&contact.force, &contact.tilt, along, lever];
                    std::array::from_fn(|i| share(before[i], columns[i]))
                })
                .collect(),
            torque: share(known.torque, &structure.torque),
            shaft_torques: [
                optional(pinion, &structure.pinion_torque),
                optional(wheel, &structure.wheel_torque),
            ],
            constant_load: share(known.constant_load, &structure.constant_load),
            load_by_speed: share(known.load_by_speed, &structure.load_by_speed),
            frame_load: share(known.frame_load, &structure.frame.load),
            harmonic_loads: each(
                &known.harmonic_loads,
                (structure.harmonic_loads.iter())
                    .map(|contact| contact.force.as_slice())
                    .collect(),
            ),
        }
    }
}

impl ModalStructure {
    /// A structure with one damping ratio for all elastic modes and given mesh and torque participations. The
    /// pinion has one tooth, the mesh force at load = 1 is 1 N, and there are no friction and no bearings.
    pub fn of_modes(frequency: &[f64], ratio: f64, mesh: &[f64], torque: &[f64]) -> Self {
        let n = frequency.len();
        let damping = |f: &f64| if *f > 0.0 { ratio } else { 0.0 };
        Self {
            teeth: 1,
            wheel_teeth: None,
            frame: TurningFrame::default(),
            rated_force: 1.0,
            frequency: frequency.to_vec(),
            damping: frequency.iter().map(damping).collect(),
            mesh: mesh.to_vec(),
            mesh_tilt: vec![0.0; n],
            torque: torque.to_vec(),
            pinion_torque: None,
            wheel_torque: None,
            friction: vec![0.0; n],
            friction_lever: vec![0.0; n],
            residual_flexibility: 0.0,
            tilt_residuals: Vec::new(),
            mesh_mass: None,
            coast: None,
            contacts: Vec::new(),
            bearings: Vec::new(),
            torques: Vec::new(),
            motions: Vec::new(),
            coupling: None,
            constant_load: Vec::new(),
            load_by_speed: Vec::new(),
            harmonic_loads: Vec::new(),
            meshes: Vec::new(),
            shafts: Vec::new(),
            shapes: None,
        }
    }

    /// Names of the meshes, the first mesh first.
    pub fn mesh_names(&self) -> Vec<String> {
        if self.meshes.is_empty() {
            vec!["pinion and wheel".to_owned()]
        } else {
            self.meshes.clone()
        }
    }

    /// Participations of the drive flanks.
    pub fn drive_flank(&self) -> FlankParticipation {
        FlankParticipation {
            mesh: self.mesh.clone(),
            tilt: self.mesh_tilt.clone(),
            friction: self.friction.clone(),
            lever: self.friction_lever.clone(),
            residual_flexibility: self.residual_flexibility,
        }
    }

    /// Participations of deflection and tilt at the drive flanks, the coast flanks and every other contact. Unknown
    /// columns are empty.
    pub fn tilt_columns(&self) -> impl Iterator<Item = [&[f64]; 2]> {
        let coast = self.coast.as_ref();
        let coast = coast.map_or([&[][..]; 2], |flank| [&flank.mesh[..], &flank.tilt]);
        let contacts = self.contacts.iter();
        [[&self.mesh[..], &self.mesh_tilt], coast]
            .into_iter()
            .chain(contacts.map(|contact| [&contact.participation[..], &contact.tilt]))
    }

    /// [`Self::tilt_residuals`] after the modes from `retained` on are omitted.
    fn tilt_residuals_without(&self, retained: usize) -> Vec<[f64; 2]> {
        if retained == self.modes() {
            return self.tilt_residuals.clone();
        }
        (self.tilt_columns().enumerate())
            .map(|(flank, [mesh, tilt])| {
                let known = self.tilt_residuals.get(flank).copied().unwrap_or_default();
                let modes = mesh.iter().zip(tilt).zip(&self.frequency);
                modes
                    .skip(retained)
                    .fold(known, |[a, b], ((w, turn), omega)| {
                        let square = omega * omega;
                        [a + w * turn / square, b + turn * turn / square]
                    })
            })
            .collect()
    }

    /// Mesh cycles per revolution of the driver, `z |Ω_1 − Ω_carrier|/Ω`.
    pub fn cycles_per_turn(&self) -> f64 {
        f64::from(self.teeth) * self.frame.rolling.abs()
    }

    /// Number of modes N.
    pub fn modes(&self) -> usize {
        self.frequency.len()
    }

    /// Number of rigid rotations: modes of frequency 0.
    pub fn rigid_modes(&self) -> usize {
        self.frequency.iter().filter(|&&omega| omega == 0.0).count()
    }

    /// Number of rigid rotations that deflect no contact.
    pub fn neutral_modes(&self) -> usize {
        self.rigid_modes() - self.contact_rotations().len()
    }

    /// Number of positions and speeds of neutral rotations that affect the motion: the speed of a rotation
    /// with dampers or gyroscopic terms, position and speed of a rotation with springs.
    pub fn restrained_neutral_count(&self) -> usize {
        let Some(coupling) = &self.coupling else {
            return 0;
        };
        let (modes, rigid) = (self.modes(), self.rigid_modes());
        let mut directions = Vec::new();
        for row in self.contact_rotations() {
            widen(&mut directions, &row, 0.0);
        }
        let by_contacts = directions.len();
        let mut by = |matrix: &[f64]| {
            let largest = matrix.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for row in matrix.chunks_exact(modes) {
                widen(&mut directions, &row[..rigid], COUPLING_NOISE * largest);
            }
            directions.len() - by_contacts
        };
        let held = by(&coupling.stiffness);
        by(&coupling.damping);
        held + by(&coupling.gyroscopic)
    }

    /// Linearly independent rigid rotations that deflect contacts, the one of the mesh first. Each is given
    /// by the participations of a contact in the rigid modes.
    pub fn contact_rotations(&self) -> Vec<Vec<f64>> {
        let rigid = self.rigid_modes();
        let further = self.contacts.iter().map(|contact| &contact.participation);
        let mut rotations: Vec<Vec<f64>> = Vec::new();
        let mut independent: Vec<Vec<f64>> = Vec::new();
        // The participation of the mesh in the rotations may be arbitrarily small.
        let columns = std::iter::once((&self.mesh, 0.0))
            .chain(further.map(|column| (column, ROTATION_NOISE)));
        for (column, noise) in columns {
            let largest = column.iter().fold(0.0_f64, |most, w| most.max(w.abs()));
            if widen(&mut independent, &column[..rigid], noise * largest) {
                rotations.push(column[..rigid].to_vec());
            }
        }
        rotations
    }

    /// The structure reduced to its `retained` lowest modes.
    ///
    /// With `mta` (modal-truncation augmentation), the static flexibility of the omitted modes at the mesh,
    /// `Σ mesh²/ω²` \[m/N\], is added to the residual flexibility. Without `mta` the residual flexibility is
    /// zero. In both cases the bearing forces ([`OmittedModeForces`]) and the tilt of the flanks keep the static
    /// share of the omitted modes. The coupling of the omitted modes to the retained modes and to each other is
    /// omitted.
    ///
    /// # Errors
    /// [`ModeCount`] unless `max(1, rigid modes) ≤ retained ≤ modes`: a rigid
    /// rotation has no static flexibility and cannot be omitted.
    pub fn truncated(&self, retained: usize, mta: bool) -> Result<Self, ModeCount> {
        // Frequencies ascend, so the rigid modes come first.
        let least = self.rigid_modes().max(1);
        if retained < least || retained > self.modes() {
            return Err(ModeCount {
                requested: retained,
                least,
                available: self.modes(),
            });
        }
        let reduce = |flank: &FlankParticipation| flank.truncated(&self.frequency, retained, mta);
        let drive = reduce(&self.drive_flank());
        let keep = |column: &[f64]| column[..retained].to_vec();
        let keep_any = |column: &[f64]| column.iter().take(retained).copied().collect();
        Ok(Self {
            teeth: self.teeth,
            wheel_teeth: self.wheel_teeth,
            frame: self.frame.leading(self.modes(), retained),
            rated_force: self.rated_force,
            frequency: keep(&self.frequency),
            damping: keep(&self.damping),
            mesh: drive.mesh,
            mesh_tilt: drive.tilt,
            torque: keep(&self.torque),
            pinion_torque: self.pinion_torque.as_deref().map(keep),
            wheel_torque: self.wheel_torque.as_deref().map(keep),
            friction: drive.friction,
            friction_lever: drive.lever,
            residual_flexibility: drive.residual_flexibility,
            tilt_residuals: self.tilt_residuals_without(retained),
            mesh_mass: self.mesh_mass,
            coast: self.coast.as_ref().map(reduce),
            contacts: (self.contacts.iter())
                .map(|contact| StructureContact {
                    participation: keep(&contact.participation),
                    force: keep(&contact.force),
                    tilt: keep_any(&contact.tilt),
                    rubbing: contact.rubbing.each_ref().map(|column| keep_any(column)),
                    ..contact.clone()
                })
                .collect(),
            bearings: (self.bearings.iter())
                .map(|bearing| BearingGain {
                    name: bearing.name.clone(),
                    gain: keep(&bearing.gain),
                    rate_gain: keep_any(&bearing.rate_gain),
                    left_out: if retained == self.modes() {
                        bearing.left_out.clone()
                    } else {
                        bearing.forces_of_omitted_modes(self, retained)
                    },
                })
                .collect(),
            torques: (self.torques.iter())
                .map(|torque| TorqueGain {
                    name: torque.name.clone(),
                    gain: keep(&torque.gain),
                    rate_gain: keep_any(&torque.rate_gain),
                })
                .collect(),
            motions: (self.motions.iter())
                .map(|motion| PlaceMotion {
                    gain: keep(&motion.gain),
                    ..motion.clone()
                })
                .collect(),
            coupling: (self.coupling.as_ref())
                .map(|coupling| coupling.leading(self.modes(), retained)),
            constant_load: keep_any(&self.constant_load),
            load_by_speed: keep_any(&self.load_by_speed),
            meshes: self.meshes.clone(),
            shafts: self.shafts.clone(),
            shapes: (self.shapes.as_ref()).map(|shapes| Arc::new(shapes.truncated(retained))),
            harmonic_loads: (self.harmonic_loads.iter())
                .map(|load| HarmonicLoad {
                    force: keep(&load.force),
                    ..load.clone()
                })
                .collect(),
        })
    }
}

/// Appends the part of a row that is orthogonal to all `units`, normalised, if its length exceeds `noise`.
/// Returns whether it appended a row.
fn widen(units: &mut Vec<Vec<f64>>, row: &[f64], noise: f64) -> bool {
    let mut rest = row.to_vec();
    // A second pass removes the round-off of the first.
    for unit in units.iter().chain(&*units) {
        let part: f64 = unit.iter().zip(&rest).map(|(u, r)| u * r).sum();
        for (r, u) in rest.iter_mut().zip(unit) {
            *r -= part * u;
        }
    }
    let norm = rest.iter().map(|r| r * r).sum::<f64>().sqrt();
    if norm > noise {
        units.push(rest.iter().map(|r| r / norm).collect());
    }
    norm > noise
}

#[cfg(test)]
mod tests {
    use super::*;

    fn structure() -> ModalStructure {
        let column = |scale: f64| (1..=4).map(|i| scale * f64::from(i)).collect::<Vec<_>>();
        ModalStructure {
            teeth: 20,
            wheel_teeth: None,
            frame: TurningFrame::default(),
            rated_force: 1.0,
            mesh_mass: None,
            frequency: vec![0.0, 2.0, 4.0, 8.0],
            damping: column(0.01),
            mesh: column(1.0),
            mesh_tilt: column(2.0),
            torque: column(3.0),
            pinion_torque: Some(column(4.0)),
            wheel_torque: None,
            friction: column(5.0),
            friction_lever: column(6.0),
            residual_flexibility: 0.25,
            tilt_residuals: Vec::new(),
            coast: None,
            contacts: Vec::new(),
            bearings: Vec::new(),
            torques: Vec::new(),
            motions: Vec::new(),
            coupling: Some(Coupling {
                damping: (0..16).map(f64::from).collect(),
                gyroscopic: vec![0.0; 16],
                stiffness: (16..32).map(f64::from).collect(),
            }),
            constant_load: column(7.0),
            load_by_speed: Vec::new(),
            meshes: Vec::new(),
            shafts: Vec::new(),
            shapes: None,
            harmonic_loads: vec![HarmonicLoad {
                name: "shaker".to_owned(),
                force: column(8.0),
                turns_per_cycle: 0.5,
                phase: 0.0,
            }],
        }
    }

    #[test]
    fn leading_parts_of_the_coupling_stay() {
        let reduced = structure().truncated(2, true).unwrap();
        let coupling = reduced.coupling.unwrap();
        assert_eq!(coupling.damping, [0.0, 1.0, 4.0, 5.0]);
        assert_eq!(coupling.gyroscopic, [0.0; 4]);
        assert_eq!(coupling.stiffness, [16.0, 17.0, 20.0, 21.0]);
        assert_eq!(reduced.constant_load, [7.0, 14.0]);
        assert!(reduced.load_by_speed.is_empty());
        assert_eq!(reduced.harmonic_loads[0].force, [8.0, 16.0]);
    }

    #[test]
    fn modes_left_out_return_as_static_flexibility() {
        let reduced = structure().truncated(2, true).unwrap();
        assert_eq!(
            reduced.residual_flexibility,
            0.25 + 9.0 / 16.0 + 16.0 / 64.0
        );
        assert_eq!(reduced.modes(), 2);
        assert_eq!(reduced.pinion_torque, Some(vec![4.0, 8.0]));
        assert_eq!(reduced.friction_lever, vec![6.0, 12.0]);
    }

    #[test]
    fn truncation_in_two_steps_is_truncation_in_one() {
        let direct = structure().truncated(1, true).unwrap();
        let stepwise = structure().truncated(3, true).unwrap();
        assert_eq!(stepwise.truncated(1, true).unwrap(), direct);
    }

    #[test]
    fn without_augmentation_nothing_returns() {
        assert_eq!(
            structure()
                .truncated(2, false)
                .unwrap()
                .residual_flexibility,
            0.0
        );
        assert_eq!(structure().truncated(4, true).unwrap(), structure());
    }

    #[test]
    fn rigid_modes_cannot_be_left_out() {
        let mut two_rigid = structure();
        two_rigid.frequency[1] = 0.0;
        let refused = |requested, least| {
            Err(ModeCount {
                requested,
                least,
                available: 4,
            })
        };
        assert_eq!(two_rigid.truncated(1, true), refused(1, 2));
        assert_eq!(structure().truncated(0, true), refused(0, 1));
        assert_eq!(structure().truncated(5, true), refused(5, 1));
    }
}
