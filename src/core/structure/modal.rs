//! What a structure looks like to the mesh: frequencies, damping, participations.

use crate::structure::{FrictionPart, MeshHarmonic, SliderPart, StaticShare, StopPart};

/// Most cycles of a contact and of the mesh in its base period: where it varies its tables are as many times larger.
pub const MOST_CYCLES: u32 = 10_000;

/// Most mesh cycles after which all contacts are as they were: where tables are made, some megabytes for every hundred.
pub const MOST_BASE_CYCLES: usize = 10_000;

/// Part of the largest entry of a matrix that is round-off where it does not act.
const COUPLING_NOISE: f64 = 1e-12;

/// Part of a contact's participations that is round-off of a rotation it does not feel.
const ROTATION_NOISE: f64 = 1e-10;

/// More (or fewer) modes were asked for than can be given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{requested} modes are requested, but between {least} and {available} are possible")]
pub struct ModeCount {
    /// Modes asked for.
    pub requested: usize,
    /// Fewest that can be given.
    pub least: usize,
    /// Most that can be given.
    pub available: usize,
}

/// A linear structure in mass-normalised modal coordinates, as seen by the gear mesh.
///
/// Every vector has one entry a mode, in ascending frequency. Mode `i` obeys
/// `q'' + 2 ζ ω q' + ω² q = torque·F₀ − mesh·F + …` with `F₀` the static and `F` the
/// actual mesh force \[N\]; `q` is in m √kg. Where there is a [`Coupling`], its terms
/// `(C + Ω G) q' + K_c q` of all modes stand on the left too, Ω the pinion's speed.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ModalStructure {
    /// Teeth of the pinion: mesh order per pinion revolution.
    pub teeth: u32,
    /// Teeth of the wheel, where known (needed for ripple on the wheel's shaft).
    pub wheel_teeth: Option<u32>,
    /// The frame in which the axes of the meshes stand still.
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
    /// Derivative of `mesh` by the load centroid z_c \[1/(m √kg)\].
    pub mesh_tilt: Vec<f64>,
    /// Modal force of a unit static mesh force \[1/√kg\]: torques `+r₁` on the pinion
    /// side and `−r₂` on the wheel side.
    pub torque: Vec<f64>,
    /// Modal force of a unit torque on the pinion's shaft \[1/(m √kg)\], where known.
    pub pinion_torque: Option<Vec<f64>>,
    /// Modal force of a unit torque on the wheel's shaft \[1/(m √kg)\], where known.
    pub wheel_torque: Option<Vec<f64>>,
    /// Participation of a unit friction force \[1/√kg\].
    pub friction: Vec<f64>,
    /// Its part linear in the position along the path of contact \[1/(m √kg)\].
    pub friction_lever: Vec<f64>,
    /// Static flexibility of the modes left out, `Σ mesh²/ω²` \[m/N\]; 0 when none is
    /// left out or when it is to be ignored (no modal-truncation augmentation).
    pub residual_flexibility: f64,
    /// What the coast flanks feel, with the sign of the drive flanks': their deflection grows
    /// as the drive flanks approach, and they touch where it falls to minus the half gap. None
    /// where their line of action is not known.
    pub coast: Option<FlankParticipation>,
    /// Contacts beside the two flanks of the mesh.
    pub contacts: Vec<StructureContact>,
    /// What the bearings feel of the modes, where known.
    pub bearings: Vec<BearingGain>,
    /// Torques in shafts and couplings, where known.
    pub torques: Vec<TorqueGain>,
    /// Places whose acceleration may be told.
    pub motions: Vec<PlaceMotion>,
    /// What couples the modes; none where damping is modal and nothing else acts.
    pub coupling: Option<Coupling>,
    /// Modal force that does not depend on the load \[N/√kg\], such as that of a constant
    /// drag; empty for none.
    pub constant_load: Vec<f64>,
    /// Modal force per pinion speed \[N s/(rad √kg)\], the mean of a viscous drag; empty for
    /// none.
    pub load_by_speed: Vec<f64>,
    /// Loads that vary with time.
    pub harmonic_loads: Vec<HarmonicLoad>,
    /// Names of its meshes, the first one's before those whose flanks are the first contacts, two each; empty of one mesh
    /// alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<String>,
    /// Names of shafts beside those of the first mesh, each with its turns, `[p, q]`: p in q mesh cycles.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shafts: Vec<(String, [u32; 2])>,
}

/// A load `force cos(2π turns_per_cycle t/T + phase)`, T the mesh period.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct HarmonicLoad {
    /// Its name.
    pub name: String,
    /// Amplitude of the modal force, one entry a mode \[N/√kg\].
    pub force: Vec<f64>,
    /// Turns of its phase per mesh cycle, > 0; need not be rational.
    pub turns_per_cycle: f64,
    /// Phase at time 0 \[rad\].
    pub phase: f64,
}

/// What couples the modes, or damps them beside their own ratio:
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
    /// The coupling of the `retained` first of `modes` modes.
    fn leading(&self, modes: usize, retained: usize) -> Self {
        let keep = |matrix: &[f64]| leading_part(matrix, modes, retained);
        Self {
            damping: keep(&self.damping),
            gyroscopic: keep(&self.gyroscopic),
            stiffness: keep(&self.stiffness),
        }
    }
}

/// Rows and columns of the `retained` first of `modes` modes in a matrix; nothing of an empty one.
fn leading_part(matrix: &[f64], modes: usize, retained: usize) -> Vec<f64> {
    let rows = matrix.chunks_exact(modes).take(retained);
    rows.flat_map(|row| &row[..retained]).copied().collect()
}

/// A frame that turns with the carrier of planets, and what it adds to the equations of motion of its structure:
/// `Ω² (K_f q − f)` on the left, Ω the speed of an operating point, which is the driver's. Coriolis terms are among the gyroscopic ones of [`Coupling`].
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TurningFrame {
    /// Speed of the first gear beside that of the carrier, in units of Ω; 1 where the frame stands still.
    pub rolling: f64,
    /// K_f, N × N row by row \[1\]; empty for none.
    pub stiffness: Vec<f64>,
    /// f, one entry a mode \[m √kg\]: centrifugal forces on planets; empty for none.
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

/// A one-sided contact of a structure beside the two flanks of its mesh: a further flank, a stop, a
/// stage of a spring. It closes where `δ = Σ participation q − e` rises to its gap b, and bears
/// `F = k (δ − b) + c δ'`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct StructureContact {
    /// Its name.
    pub name: String,
    /// Participation of its deflection, one entry a mode \[1/√kg\].
    pub participation: Vec<f64>,
    /// Modal force of a unit of its force without friction that turns, taken with a minus sign, one entry a mode
    /// \[1/√kg\]: mostly the participation itself.
    pub force: Vec<f64>,
    /// Derivative of participation and force by the load centroid z_c \[1/(m √kg)\]; empty where it stays at mid-face.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tilt: Vec<f64>,
    /// What friction adds to it by Λ₀ \[1/√kg\] and by Λ₁ \[1/(m √kg)\] of [`ContactLaw::friction`]; empty without.
    #[serde(skip_serializing_if = "no_friction")]
    pub rubbing: [Vec<f64>; 2],
    /// Speed at which its two gears turn against each other, by that of the gears of the first mesh \[1\]; 0 of what is no
    /// mesh.
    #[serde(skip_serializing_if = "is_zero")]
    pub sliding: f64,
    /// How many of its cycles, `[p, q]`: p in q cycles of the mesh.
    pub cycles: [u32; 2],
    /// What it bears.
    pub law: ContactLaw,
    /// The flank of the first mesh that it is another copy of, 0 the drive flank and 1 the coast flank. Of `law`
    /// counts the phase alone then; `rubbing` is for a unit of friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub copies: Option<usize>,
}

impl StructureContact {
    /// A contact along one line that acts where it is seen, in the cycles of the mesh, without friction.
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
    /// A stop without friction, of a gap \[m\] and a constant stiffness \[N/m\], for tests.
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

/// What a one-sided contact bears of its deflection.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct ContactLaw {
    /// Gap b \[m\]; a negative one is a preload.
    pub gap: f64,
    /// Stiffness k over its cycle: the phase where each piece ends, and its Legendre coefficients
    /// there \[N/m\].
    pub stiffness: Vec<(f64, [f64; 8])>,
    /// Direction Λ₀ \[1\] and lever Λ₁ \[m\] of friction over each of these pieces; empty without friction.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub friction: Vec<[f64; 2]>,
    /// Load centroid z_c over each of these pieces \[m\]; empty for mid-face.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub centres: Vec<f64>,
    /// Error of the loaded flanks over each of these pieces, which adds to the gap: Legendre coefficients \[m\];
    /// empty for none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lacking: Vec<[f64; 8]>,
    /// Damping c \[N s/m\].
    pub damping: f64,
    /// Phase in its cycle at the start of mesh cycle 0, in cycles.
    pub phase: f64,
    /// Harmonics of its error e; phases count from phase 0 of its cycle.
    pub error: Vec<MeshHarmonic>,
    /// The part of a dry slider that it is; none of an ordinary contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slider: Option<SliderPart>,
    /// The part of a rigid stop that it is; none of an ordinary contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop: Option<StopPart>,
    /// The part of dry friction that it is; none of an ordinary contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dry_friction: Option<FrictionPart>,
}

impl ContactLaw {
    /// Of a contact whose law is given later but for its phase \[cycles\]: by the flank of the first mesh that it
    /// copies, or by the load.
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

/// What the flanks of one side feel of the modes, one entry a mode, and what they do to them.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FlankParticipation {
    /// Participation of the deflection along the line of action \[1/√kg\].
    pub mesh: Vec<f64>,
    /// Derivative of `mesh` by the load centroid z_c \[1/(m √kg)\].
    pub tilt: Vec<f64>,
    /// Participation of a unit friction force \[1/√kg\].
    pub friction: Vec<f64>,
    /// Its part linear in the position along the path of contact \[1/(m √kg)\].
    pub lever: Vec<f64>,
    /// Static flexibility of the modes left out, `Σ mesh²/ω²` \[m/N\].
    pub residual_flexibility: f64,
}

impl FlankParticipation {
    /// Its first `retained` modes, the others returning as their flexibility where `mta` asks.
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

/// The force that a shaft exerts on one bearing in one direction, `Σ gain·q + Σ rate_gain·q'` \[N\]:
/// that of its springs and of its dampers. Modal damping has no place of its own and is not in it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct BearingGain {
    /// Shaft, bearing and direction, such as `pinion 1 x`.
    pub name: String,
    /// Force per unit modal displacement \[N/(m √kg)\], one entry a mode.
    pub gain: Vec<f64>,
    /// Force per unit modal velocity \[N s/(m √kg)\], one entry a mode; empty for none.
    pub rate_gain: Vec<f64>,
    /// What modes that are left out add at rest.
    pub left_out: StaticShare,
}

/// The torque that a shaft or a coupling transmits, `Σ gain·q + Σ rate_gain·q'` \[N m\], of its spring and
/// its damper, in the sense of running: of a drive of two shafts from the motor to the pinion and from the
/// wheel to the load, of a train from the lower place to the higher.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TorqueGain {
    /// Shaft or coupling.
    pub name: String,
    /// Torque per unit modal displacement \[N/√kg\], one entry a mode.
    pub gain: Vec<f64>,
    /// Torque per unit modal velocity \[N s/√kg\], one entry a mode; empty for none.
    pub rate_gain: Vec<f64>,
}

/// What moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum MotionKind {
    /// A place of a bearing, in one direction.
    Place,
    /// What rotates as one: the rotation of its node that torque acts on.
    Body,
    /// A gear: its rotation.
    Gear,
}

/// A motion, `Σ gain·q`: a displacement in one direction, or a rotation in the sense of running, beside the mean rotation.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PlaceMotion {
    /// Shaft, bearing and direction, such as `pinion 1 x`; of a rotation the shaft or the gear.
    pub name: String,
    /// What moves.
    pub kind: MotionKind,
    /// Displacement \[1/√kg\] or angle \[1/(m √kg)\] per unit modal displacement, one entry a mode.
    pub gain: Vec<f64>,
}

impl BearingGain {
    /// What modes that are left out add, those of its structure behind the `retained` first among them.
    fn left_out_behind(&self, structure: &ModalStructure, retained: usize) -> StaticShare {
        let known = &self.left_out;
        let share = |before: f64, column: &[f64]| -> f64 {
            let felt = self.gain.iter().zip(&structure.frequency).zip(column);
            let added: f64 = (felt.skip(retained))
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
        StaticShare {
            drive: flank(known.drive, &structure.drive_flank()),
            coast: (structure.coast.as_ref()).map_or(known.coast, |own| flank(known.coast, own)),
            contacts: (structure.contacts.iter().enumerate())
                .map(|(number, own)| {
                    let before = known.contacts.get(number).copied().unwrap_or_default();
                    let [along, lever] = &own.rubbing;
                    let columns = [&own.force, &own.tilt, along, lever];
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
                    .map(|own| own.force.as_slice())
                    .collect(),
            ),
        }
    }
}

impl ModalStructure {
    /// Modes with one damping ratio, rigid ones undamped, that mesh and torque participations alone tell
    /// about: a pinion of one tooth, 1 N of mesh force at load = 1, no friction, no bearings.
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
        }
    }

    /// Names of its meshes, the first one's first.
    pub fn mesh_names(&self) -> Vec<String> {
        if self.meshes.is_empty() {
            vec!["pinion and wheel".to_owned()]
        } else {
            self.meshes.clone()
        }
    }

    /// What the drive flanks feel.
    pub fn drive_flank(&self) -> FlankParticipation {
        FlankParticipation {
            mesh: self.mesh.clone(),
            tilt: self.mesh_tilt.clone(),
            friction: self.friction.clone(),
            lever: self.friction_lever.clone(),
            residual_flexibility: self.residual_flexibility,
        }
    }

    /// Mesh cycles in a turn of the driver, `z |Ω_1 − Ω_carrier|/Ω`.
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

    /// Number of rigid rotations that no contact feels.
    pub fn neutral_modes(&self) -> usize {
        self.rigid_modes() - self.felt_rotations().len()
    }

    /// How many of the places and speeds of these rotations are felt all the same: the speed of each
    /// that dampers or gyroscopic terms act on, both of each that springs hold.
    pub fn felt_of_neutral(&self) -> usize {
        let Some(coupling) = &self.coupling else {
            return 0;
        };
        let (modes, rigid) = (self.modes(), self.rigid_modes());
        let mut felt = Vec::new();
        for row in self.felt_rotations() {
            widen(&mut felt, &row, 0.0);
        }
        let by_contacts = felt.len();
        let mut by = |matrix: &[f64]| {
            let largest = matrix.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for row in matrix.chunks_exact(modes) {
                widen(&mut felt, &row[..rigid], COUPLING_NOISE * largest);
            }
            felt.len() - by_contacts
        };
        let held = by(&coupling.stiffness);
        by(&coupling.damping);
        held + by(&coupling.gyroscopic)
    }

    /// Directions in the space of the rigid rotations that contacts feel, linearly independent, that
    /// of the mesh first: participations in the rigid modes alone.
    pub fn felt_rotations(&self) -> Vec<Vec<f64>> {
        let rigid = self.rigid_modes();
        let further = self.contacts.iter().map(|contact| &contact.participation);
        let mut felt: Vec<Vec<f64>> = Vec::new();
        let mut independent: Vec<Vec<f64>> = Vec::new();
        // The mesh may feel the rotations as little as it likes.
        let columns = std::iter::once((&self.mesh, 0.0))
            .chain(further.map(|column| (column, ROTATION_NOISE)));
        for (column, noise) in columns {
            let largest = column.iter().fold(0.0_f64, |most, w| most.max(w.abs()));
            if widen(&mut independent, &column[..rigid], noise * largest) {
                felt.push(column[..rigid].to_vec());
            }
        }
        felt
    }

    /// The structure reduced to its `retained` lowest modes.
    ///
    /// With `mta` (modal-truncation augmentation) the modes left out return as their static
    /// flexibility at the mesh, `Σ mesh²/ω²` \[m/N\], added to what the structure already
    /// carried; without it the residual flexibility is 0. On bearings their static share stays in either case
    /// ([`StaticShare`]). What couples them to the modes that
    /// stay, or to each other, is left out with them.
    ///
    /// # Errors
    /// [`ModeCount`] unless `max(1, rigid modes) ≤ retained ≤ modes`: a rigid
    /// rotation has no static flexibility and cannot be left out.
    pub fn truncated(&self, retained: usize, mta: bool) -> Result<Self, ModeCount> {
        // Frequencies ascend, so that the rigid modes come first.
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
                        bearing.left_out_behind(self, retained)
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
            harmonic_loads: (self.harmonic_loads.iter())
                .map(|load| HarmonicLoad {
                    force: keep(&load.force),
                    ..load.clone()
                })
                .collect(),
        })
    }
}

/// Adds what of a row is orthogonal to some unit vectors to them, made one itself; whether there is more
/// of it than `noise`.
fn widen(units: &mut Vec<Vec<f64>>, row: &[f64], noise: f64) -> bool {
    let mut rest = row.to_vec();
    // Twice, against round-off.
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
