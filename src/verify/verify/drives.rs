//! The drives on which kernels are tested, from one degree of freedom to forty modes. All of them rattle. The
//! largest drive is the default drive, from the manifest `flex80` at the time of the build.

use super::CheckError;
use super::candidate::Propagator;
use crate::analysis::EnergyNorm;
use crate::gear::{Flanks, GearPair, MeshTable, MeshTableInputs, MeshTablePiece};
use crate::manifest::{
    self, DampingSpec, FrictionSpec, Job, ManifestText, StiffnessSpec, StructureSource,
};
use crate::model::{
    Division, Drive, DriveShaft, InitialState, MeshHarmonic, Model, OperatingPoint, TorqueRipple,
    TrajectoryState,
};
use crate::propagate::Stepping;
use crate::shaft::FlexibleDrive;
use crate::structure::ModalStructure;
use std::f64::consts::PI;
use std::path::Path;

const DEFAULT_DRIVE: &str = include_str!("../../../manifests/flex80.toml");

/// Number of steps per mesh cycle in the transient of [`rattling`].
const STEPS_PER_CYCLE: u32 = 2000;

/// Number of mesh cycles after which a drive rattles.
const TRANSIENT: u64 = 40;

/// A drive at an operating point.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its name in the report.
    pub name: String,
    /// The structure.
    pub structure: ModalStructure,
    /// Mesh and excitation.
    pub drive: Drive,
    /// Load and speed.
    pub point: OperatingPoint,
}

impl Case {
    /// The piecewise-linear system of the case.
    ///
    /// # Errors
    /// A value is out of its range.
    pub fn model(&self) -> Result<Model, CheckError> {
        Ok(Model::new(&self.structure, &self.drive, self.point)?)
    }

    /// The case at full load, with nearly constant mesh stiffness and small excitation: contact never opens.
    pub fn in_constant_contact(&self) -> Self {
        let mut case = self.clone();
        for harmonic in &mut case.drive.transmission_error {
            harmonic.amplitude *= 0.002;
        }
        for ripple in &mut case.drive.torque_ripple {
            ripple.amplitude *= 0.1;
        }
        case.drive.mesh = Division::levels(&[3.4e8, 3.333e8], &[0.6]);
        case.point.load = 1.0;
        case
    }
}

/// The state of a model after some mesh cycles from the static equilibrium. It is computed with small steps,
/// so that no kernel under test determines the start of its check.
///
/// # Errors
/// The trajectory diverges.
pub fn rattling(model: &Model) -> Result<TrajectoryState, CheckError> {
    let kernel = Stepping::new(model, STEPS_PER_CYCLE, 10_000);
    let start = model.start(&InitialState::Static);
    Ok(kernel.passage(&start, TRANSIENT)?.end)
}

/// A structure with the given frequencies \[rad/s\], damping ratio of the elastic modes, mesh and torque
/// participations.
pub fn structure(frequency: &[f64], ratio: f64, mesh: &[f64], torque: &[f64]) -> ModalStructure {
    ModalStructure {
        teeth: 20,
        wheel_teeth: Some(30),
        rated_force: 1330.0,
        ..ModalStructure::of_modes(frequency, ratio, mesh, torque)
    }
}

/// The drives on which every kernel is tested, in order of the number of modes.
///
/// # Errors
/// The default drive cannot be assembled.
pub fn cases() -> Result<Vec<Case>, CheckError> {
    let forty = default_drive()?;
    let mut twenty = forty.clone();
    twenty.name = "20 modes + MTA, 30 % load".to_owned();
    twenty.structure = forty.structure.truncated(20, true)?;
    twenty.point.load = 0.3;
    let mut sparse = six_modes();
    sparse.name = "6 modes, 1400 rad/s".to_owned();
    sparse.point.speed = 1400.0;
    let mut computed = forty.clone();
    computed.name = "40 modes, computed mesh".to_owned();
    computed.drive.mesh = computed_mesh(forty.point.load)?;
    Ok(vec![
        one_degree(),
        two_bodies(),
        six_modes(),
        sparse,
        twenty,
        computed,
        forty,
    ])
}

/// The mesh of the default drive, computed from its drawing with a misalignment of 0.2 mrad. Its stiffness
/// varies, its load centroid moves, and its friction changes its direction.
fn computed_mesh(load: f64) -> Result<Vec<Division>, CheckError> {
    let gears = default_gears()?;
    let mut inputs = MeshTableInputs::of_gears(&gears);
    inputs.misalignment = vec![2e-4];
    inputs.torque = vec![load * gears.rated_torque];
    let table = MeshTable::build(&Flanks::new(&gears)?, &inputs, &|_, _| ())?;
    let cycle = table.cycle(0, 0);
    Ok((cycle.pieces().iter().map(MeshTablePiece::division)).collect())
}

/// The operating points of the grid in the manifest of the default drive.
///
/// # Errors
/// The default drive cannot be assembled.
pub fn grid() -> Result<Vec<Case>, CheckError> {
    let drive = default_drive()?;
    let case = |point: manifest::PointSpec| {
        let mut case = drive.clone();
        case.name = format!("40 modes, {:.3} load, {:.0} rad/s", point.load, point.speed);
        case.point = OperatingPoint {
            load: point.load,
            speed: point.speed,
        };
        case.drive.half_gap = point.mesh.half_gap;
        case
    };
    Ok(job(&[])?.points.iter().map(case).collect())
}

/// A state a few half gaps from the static one, from which contacts open and close.
pub fn disturbed(model: &Model) -> TrajectoryState {
    let mut state = model.start(&InitialState::Static).state;
    let norm = EnergyNorm::new(model);
    let felt = norm.weighted_components();
    let part = 4.0 * norm.unit() / (felt.len() as f64).sqrt();
    for (index, &component) in felt.iter().enumerate() {
        state[component] += part * (1.7 * index as f64).cos() / norm.weights()[component];
    }
    TrajectoryState::new(model, state, 0)
}

/// A mesh without excitation. Its levels of stiffness \[N/m\] end at the given phases, the last one at 1. Without
/// phases, all levels have the same length.
pub fn quiet(half_gap: f64, levels: &[f64], ends: &[f64], damping: f64) -> Drive {
    Drive {
        mesh: Division::levels(levels, ends),
        damping,
        ..Drive::constant(half_gap, 0.0)
    }
}

/// A mesh with two levels of stiffness, as for a contact ratio of 1.6, and one harmonic of transmission
/// error.
fn two_level_mesh(half_gap: f64) -> Drive {
    Drive {
        transmission_error: vec![MeshHarmonic::new(1, 5e-6, 0.0)],
        ..quiet(half_gap, &[4.444e8, 3.333e8], &[0.6], 1483.0)
    }
}

const STRONG_RATTLE: OperatingPoint = OperatingPoint {
    load: 0.05,
    speed: 1200.0,
};

/// A drive with one degree of freedom: the relative rotation of rigid bodies.
fn one_degree() -> Case {
    Case {
        name: "1 degree of freedom".to_owned(),
        structure: structure(&[0.0], 0.0, &[1.3], &[1.3]),
        drive: two_level_mesh(10e-6),
        point: STRONG_RATTLE,
    }
}

/// Two rigid bodies. Each mode is the rotation of one body, not the neutral or the relative rotation of both.
fn two_bodies() -> Case {
    let mesh = [0.98, -0.86];
    Case {
        name: "2 rigid bodies".to_owned(),
        structure: structure(&[0.0, 0.0], 0.0, &mesh, &mesh),
        drive: two_level_mesh(9e-6),
        point: STRONG_RATTLE,
    }
}

/// A rigid pair and four elastic modes, with friction, two harmonics of transmission error, and torque ripple
/// on both shafts.
fn six_modes() -> Case {
    let mut structure = structure(
        &[0.0, 0.0, 4288.0, 4864.0, 8171.0, 19757.0],
        0.01,
        &[0.61, -0.49, 0.72, 0.64, -0.48, 0.21],
        &[0.61, -0.49, 0.33, -0.21, 0.05, 0.0],
    );
    structure.friction = vec![0.1, 0.2, -0.17, 0.56, 0.3, -0.1];
    structure.pinion_torque = Some(vec![16.0, 0.0, 8.0, -5.0, 1.0, 0.0]);
    structure.wheel_torque = Some(vec![0.0, 8.0, 3.0, 2.0, -1.0, 0.5]);
    let ripple = |shaft, order, amplitude, phase| TorqueRipple {
        shaft,
        order,
        amplitude,
        phase,
    };
    let drive = Drive {
        friction: 0.1,
        transmission_error: vec![
            MeshHarmonic::new(1, 5e-6, 0.0),
            MeshHarmonic::new(2, 1e-6, 0.7),
        ],
        torque_ripple: vec![
            ripple(DriveShaft::Pinion, 2.0, 1.5, 0.3),
            ripple(DriveShaft::Wheel, 1.5, 0.8, -1.1),
        ],
        ..two_level_mesh(10e-6)
    };
    Case {
        name: "6 modes, friction, ripple".to_owned(),
        structure,
        drive,
        point: OperatingPoint {
            load: 0.1,
            ..STRONG_RATTLE
        },
    }
}

/// The manifest of the default drive with some changed keys.
///
/// # Errors
/// The built-in manifest is not as expected.
pub(super) fn job(changes: &[&str]) -> Result<Job, CheckError> {
    read(DEFAULT_DRIVE, "manifests/flex80.toml", changes)
}

/// A built-in manifest with some changed keys.
pub(super) fn read(text: &str, name: &str, changes: &[&str]) -> Result<Job, CheckError> {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let manifest = ManifestText {
        text,
        changes: &changes,
    };
    Ok(manifest.job(name, Path::new(""))?)
}

/// Moments of inertia of both shafts about their axes \[kg m²\]. Each is the sum of the shaft (a solid cylinder), the
/// gear body (a hollow cylinder from the shaft to the pitch diameter) and the inertia at the end.
pub(super) fn inertias(drive: &FlexibleDrive) -> [f64; 2] {
    let rod = |outer: f64, inner: f64, length: f64| {
        PI * drive.density * length * (outer.powi(4) - inner.powi(4)) / 32.0
    };
    [0, 1].map(|index| {
        let shaft = &drive.shafts[index];
        let pitch = 2.0 * drive.gears.pitch_radii()[index];
        shaft.end_inertia
            + rod(shaft.diameter, 0.0, shaft.span + shaft.overhang)
            + rod(pitch, shaft.diameter, drive.gears.body_length[index])
    })
}

/// Shafts, bearings and gears of the default drive.
///
/// # Errors
/// The built-in manifest is not as expected.
pub fn shafts() -> Result<FlexibleDrive, CheckError> {
    let job = job(&[])?;
    match job.points.first().map(|point| point.model.source) {
        Some(StructureSource::Flexible(drive)) => Ok((*drive).clone()),
        _ => Err(CheckError::Missing {
            what: "a flexible drive",
        }),
    }
}

/// The default drive with its forty modes in strong rattle, a half gap of 9 µm.
fn default_drive() -> Result<Case, CheckError> {
    let job = job(&[])?;
    let point = job.points.first().ok_or(CheckError::Missing {
        what: "an operating point of the default drive",
    })?;
    let (
        StiffnessSpec::Piecewise(levels),
        DampingSpec::Coefficient(damping),
        FrictionSpec::Constant(friction),
    ) = (
        &point.mesh.stiffness,
        &point.mesh.damping,
        &point.mesh.friction,
    )
    else {
        return Err(CheckError::Missing {
            what: "a piecewise mesh of the default drive",
        });
    };
    Ok(Case {
        name: "40 modes".to_owned(),
        structure: shafts()?.modes(point.model.modes, point.model.retained, false)?,
        drive: Drive {
            friction: *friction,
            release: point.mesh.release,
            transmission_error: point.excitation.transmission_error.clone(),
            ..quiet(9e-6, levels, &[], *damping)
        },
        point: STRONG_RATTLE,
    })
}

/// The gears of the default drive, on its shafts.
pub(super) fn default_gears() -> Result<GearPair, CheckError> {
    let drive = shafts()?;
    let diameters = drive.shafts.each_ref().map(|shaft| shaft.diameter);
    let mut gears = drive.gears.on_shafts(diameters);
    // Gear and shaft are one piece. The gear body is rigid within these diameters.
    gears.form.bore = [Some(48e-3), Some(76e-3)];
    Ok(gears)
}
