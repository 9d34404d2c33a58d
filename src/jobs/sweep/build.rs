//! Builds the system that kernels integrate from the specification of a point.

use super::first_force;
use super::further_meshes::{self, FurtherMeshError};
use super::loaded_mesh::first_cycle;
use super::mesh_error::MeshError;
use super::mesh_tables::MeshTables;
use crate::analysis::{PointConfig, SliceError};
use crate::gear::GearError;
use crate::manifest::{
    CoastSpec, DampingSpec, MeshSpec, ModelSpec, PointSpec, StiffnessSpec, StructureSource,
};
use crate::model::{
    CoastFlank, Division, Drive, MeshHarmonic, Model, ModelError, OperatingPoint, Rolling,
    ToothCycles,
};
use crate::numerics::random::PointSeed;
use crate::propagate::{KernelChoice, TableError, Volterra};
use crate::shaft::ShaftError;
use crate::store::MeshUnderLoad;
use crate::structure::ModalStructure;
use crate::units::short;
use std::f64::consts::{PI, TAU};

/// Why a point's system cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// The values of the point's axes are inconsistent.
    #[error("these values do not describe a drive: {0}")]
    Values(String),
    /// The structure cannot be assembled or solved.
    #[error("the structure cannot be computed: {0}")]
    Structure(#[from] ShaftError),
    /// The model cannot be formed.
    #[error("the model cannot be formed: {0}")]
    Model(#[from] ModelError),
    /// The mesh cannot be computed from the drawing of the gears.
    #[error("the mesh cannot be computed: {0}")]
    Mesh(#[from] MeshError),
    /// The mesh of further gears of a train cannot be computed from their drawing.
    #[error(transparent)]
    FurtherMesh(#[from] FurtherMeshError),
    /// The law of friction cannot be applied.
    #[error("the friction of the mesh cannot be computed: {0}")]
    Friction(#[from] GearError),
    /// The kernel's tables could not be loaded or computed.
    #[error("{error}{}", advice.as_ref().map_or(String::new(), |advice| format!("; {advice}")))]
    Tables {
        /// Reason.
        error: TableError,
        /// Another kernel, if the model does not fit the tables.
        advice: Option<String>,
    },
    /// The slice of initial states is impossible for the model.
    #[error("analyses.multistability.slice: {0}")]
    Slice(#[from] SliceError),
    /// The motion is too fast for the mesh cycle.
    #[error(
        "one mesh cycle would take {} windows (at most {MOST_WINDOWS}): the fastest motion, \
         {rate:.1e} rad/s, is too fast for the mesh period of {period:.1e} s; check the units of mesh \
         stiffness and damping, omit high modes, or raise the speed",
        short(*windows, 0)
    )]
    TooFast {
        /// Windows per mesh cycle.
        windows: f64,
        /// Fastest rate of the closed system \[rad/s\].
        rate: f64,
        /// Mesh period \[s\].
        period: f64,
    },
}

/// Largest number of windows in a mesh cycle. A cycle then takes at most some milliseconds, so that a job can
/// be interrupted quickly. A wrong unit in the manifest gives an error instead of a run of many hours.
const MOST_WINDOWS: f64 = 20_000.0;

/// Checks that a kernel needs reasonable time for a mesh cycle of a model.
///
/// # Errors
/// [`BuildError::TooFast`] if the kernel `volterra` would need too many windows.
pub fn check_window_count(model: &Model, kernel: &KernelChoice) -> Result<(), BuildError> {
    // The kernel `closed_modes` needs about as many blocks as `volterra` needs windows.
    if !matches!(kernel, KernelChoice::Volterra | KernelChoice::ClosedModes) {
        return Ok(());
    }
    let windows = Volterra::windows_needed(model, f64::EPSILON);
    // The comparison also rejects NaN.
    if windows <= MOST_WINDOWS {
        return Ok(());
    }
    Err(BuildError::TooFast {
        windows,
        rate: Volterra::fastest_rate(model),
        period: model.period(),
    })
}

impl BuildError {
    /// The error if tables cannot be made or loaded, with advice on another kernel if the model is the
    /// reason.
    pub fn tables(error: TableError, model: &Model) -> Self {
        let another = error.concerns_the_model();
        Self::Tables {
            advice: another.then(|| structured_instead(model)),
            error,
        }
    }
}

/// Whether the kernel `volterra` helps for a model that the tables do not fit, in words.
fn structured_instead(model: &Model) -> String {
    let windows = Volterra::windows_needed(model, f64::EPSILON);
    if windows <= MOST_WINDOWS {
        format!(
            "or set run.kernel = \"volterra\", which computes this mesh cycle in {windows:.0} windows"
        )
    } else {
        format!(
            "run.kernel = \"volterra\" does not help: it would take {} windows (at most {MOST_WINDOWS})",
            short(windows, 0)
        )
    }
}

/// The structure of a model specification, reduced to the modes it retains.
///
/// # Errors
/// The shaft model cannot be assembled or solved.
pub fn structure(spec: &ModelSpec) -> Result<ModalStructure, ShaftError> {
    match &spec.source {
        StructureSource::Rigid(drive) => drive.modes(spec.modes, spec.retained, spec.mta),
        StructureSource::Flexible(drive) => drive.modes(spec.modes, spec.retained, spec.mta),
        StructureSource::Train(train) => train.modes(spec.modes, spec.retained, spec.mta),
        StructureSource::Modal(structure) => Ok(structure.truncated(spec.retained, spec.mta)?),
    }
}

/// The piecewise-linear system of a point, and its mesh under the mean load if it is computed from the gears.
pub(super) fn model(
    structure: &ModalStructure,
    point: &PointSpec,
    meshes: &MeshTables,
) -> Result<(Model, Option<MeshUnderLoad>), BuildError> {
    // Harmonics that represent the error of loaded flanks.
    let mut flank_error_harmonics = Vec::new();
    let mut further = (Vec::new(), Default::default());
    let mut under_load = None;
    let (mesh, mean) = match &point.mesh.stiffness {
        StiffnessSpec::Constant(k) => (Division::levels(&[*k], &[]), *k),
        StiffnessSpec::Piecewise(values) => (
            Division::levels(values, &[]),
            values.iter().sum::<f64>() / values.len() as f64,
        ),
        StiffnessSpec::Continuous(levels) => {
            let (stiffness, transitions) = levels.divisions();
            (Division::levels(&stiffness, &transitions), levels.mean())
        }
        StiffnessSpec::Fourier(mean, harmonics) => (Division::fourier(*mean, harmonics), *mean),
        StiffnessSpec::Table(spec) => {
            let mesh = meshes.mesh(point, spec, structure)?;
            flank_error_harmonics = mesh.transmission_error;
            further = (mesh.further, mesh.tooth_cycles);
            under_load = mesh.under_load;
            (mesh.divisions, mesh.mean_stiffness)
        }
    };
    let mesh = match &point.mesh.sliding {
        Some(pairs) => pairs.cut(&mesh),
        None => mesh,
    };
    let structure = &further_meshes::with_laws(structure, point, meshes)?;
    let model = with_mesh(
        structure,
        point,
        (mesh, mean),
        further,
        flank_error_harmonics,
    )?;
    Ok((model, under_load))
}

/// The system of a point with constant mean mesh stiffness, which determines its natural frequencies in
/// contact. The shafts do not tilt.
///
/// # Errors
/// A structure, a mesh or a value is refused.
pub fn mean_model(
    structure: &ModalStructure,
    point: &PointSpec,
    meshes: &MeshTables,
) -> Result<Model, BuildError> {
    let structure = further_meshes::with_means(structure, point, meshes)?;
    let mean = mean_of(&structure, point, meshes)?;
    with_mean(&structure, point, mean)
}

/// As [`mean_model`], at several speeds \[rad/s\]. The mean stiffness is computed once, at the speed of
/// `point`.
pub fn mean_models(
    structure: &ModalStructure,
    point: &PointSpec,
    speeds: &[f64],
    meshes: &MeshTables,
) -> Result<Vec<Model>, BuildError> {
    let mean = mean_of(structure, point, meshes)?;
    let structure = further_meshes::with_means(structure, point, meshes)?;
    let at = speeds.iter().map(|&speed| PointSpec {
        speed,
        ..point.clone()
    });
    at.map(|point| with_mean(&structure, &point, mean))
        .collect()
}

/// Mean stiffness of a point's mesh \[N/m\].
fn mean_of(
    structure: &ModalStructure,
    point: &PointSpec,
    meshes: &MeshTables,
) -> Result<f64, BuildError> {
    Ok(match &point.mesh.stiffness {
        StiffnessSpec::Table(spec) => {
            first_cycle(point, spec, Some(structure), meshes)?.mean_stiffness()
        }
        known => known.mean().unwrap_or_default(),
    })
}

fn with_mean(
    structure: &ModalStructure,
    point: &PointSpec,
    mean: f64,
) -> Result<Model, BuildError> {
    // Friction changes its sign within a mesh cycle, so the mean mesh has none.
    let level = Division {
        friction: [0.0; 2],
        ..Division::level(1.0, mean)
    };
    let mesh = (vec![level], mean);
    let equal = PointSpec {
        mesh: MeshSpec {
            teeth: None,
            ..point.mesh.clone()
        },
        ..point.clone()
    };
    let mut model = with_mesh(structure, &equal, mesh, Default::default(), Vec::new())?;
    // The mean mesh has no contact positions.
    model.rolling = None;
    Ok(model)
}

/// The system of a point on a given mesh: the divisions of its cycle with their mean stiffness \[N/m\].
/// `further` has the divisions of further springs, and `tooth_cycles` those of all springs in every cycle of
/// a revolution if single teeth differ. `flank_error_harmonics` represent the error of loaded flanks.
fn with_mesh(
    structure: &ModalStructure,
    point: &PointSpec,
    (mesh, mean): (Vec<Division>, f64),
    (further, tooth_cycles): (Vec<Vec<Division>>, ToothCycles),
    flank_error_harmonics: Vec<MeshHarmonic>,
) -> Result<Model, BuildError> {
    let coast = match point.mesh.coast {
        CoastSpec::SameLine => None,
        CoastSpec::Mirrored { symmetry } => Some(coast_flank(
            point,
            (&mesh, &further),
            &flank_error_harmonics,
            symmetry,
        )),
    };
    let mut error = point.excitation.transmission_error.clone();
    error.extend(flank_error_harmonics);
    let friction = first_force::friction(structure, point)?;
    let tooth_cycles = match &point.mesh.teeth {
        Some(teeth) if tooth_cycles[0].is_empty() => {
            let of_coast = coast.as_ref().map(|coast| teeth.on_coast(&coast.mesh));
            // The mesh has one spring, so each cycle has one list of divisions.
            [teeth.on_drive(&mesh), of_coast.unwrap_or_default()]
                .map(|cycles| cycles.into_iter().map(|own| vec![own]).collect())
        }
        _ => tooth_cycles,
    };
    let drive = Drive {
        half_gap: point.mesh.half_gap,
        damping: match point.mesh.damping {
            DampingSpec::Coefficient(c) => c,
            DampingSpec::Ratio(ratio) => Model::damping_from_ratio(structure, ratio, mean),
        },
        mesh,
        friction,
        release: point.mesh.release,
        film: point.mesh.film,
        coast,
        transmission_error: error,
        torque_ripple: point.excitation.torque_ripple.clone(),
        further,
        imposed_motion: point.excitation.imposed_motion.clone(),
        tooth_cycles,
    };
    let operating = OperatingPoint {
        load: point.load,
        speed: point.speed,
    };
    let mut model = Model::new(structure, &drive, operating)?;
    model.half_gap = point.mesh.scale();
    model.rolling = rolling(point, friction, structure.frame.rolling);
    Ok(model)
}

/// How the gears of a drawing roll on each other; `None` without a drawing. `relative` is the speed of the
/// first gear relative to the carrier, divided by the driver's speed.
fn rolling(point: &PointSpec, friction: f64, relative: f64) -> Option<Rolling> {
    let gears = point.model.source.gears()?;
    let [pinion, wheel] = gears.teeth.map(f64::from);
    let speed = point.speed * relative;
    Some(Rolling {
        base_speed: gears.base_radii()[0] * speed,
        friction,
        sliding: speed * (1.0 + pinion / wheel),
    })
}

/// The coast flank. Its stiffness and its error under load mirror those of the drive flank about the mesh phase
/// `symmetry`; its imposed transmission error does not.
fn coast_flank(
    point: &PointSpec,
    (mesh, further): (&[Division], &[Vec<Division>]),
    flank_error_harmonics: &[MeshHarmonic],
    symmetry: f64,
) -> CoastFlank {
    let excitation = &point.excitation;
    let imposed =
        (excitation.coast_transmission_error.as_ref()).unwrap_or(&excitation.transmission_error);
    let flank_error_harmonics = flank_error_harmonics
        .iter()
        .map(|&harmonic| flank_error_on_coast(harmonic, symmetry));
    CoastFlank {
        mesh: Division::mirrored(mesh, symmetry),
        transmission_error: imposed
            .iter()
            .copied()
            .chain(flank_error_harmonics)
            .collect(),
        further: (further.iter())
            .map(|spring| Division::mirrored(spring, symmetry))
            .collect(),
    }
}

/// A harmonic of the drive flanks' error, on the coast flanks: `e(symmetry + φ)` is minus the value at
/// `symmetry − φ`. A positive error lets δ rise further on the drive flanks, and its mirror image lets δ fall
/// further on the coast flanks.
fn flank_error_on_coast(drive: MeshHarmonic, symmetry: f64) -> MeshHarmonic {
    let turn = 2.0 * TAU * drive.turns_per_cycle() * symmetry;
    MeshHarmonic {
        phase: PI - drive.phase - turn,
        ..drive
    }
}

/// The configuration of a point's main trajectory.
pub fn point_config(point: &PointSpec, seed: PointSeed) -> PointConfig {
    let (run, analyses) = (&point.run, &point.analyses);
    PointConfig {
        point: seed,
        transient: run.transient,
        cycles: run.cycles,
        settle: run.settle,
        audit_cycles: run.audit_cycles,
        lyapunov: analyses.lyapunov,
        poincare_samples: (analyses.poincare.as_ref()).map_or(0, |config| config.samples),
        section: (analyses.poincare.as_ref())
            .map(|config| config.section.clone())
            .unwrap_or_default(),
        nvh: analyses.nvh,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_beyond_all_reason_is_short() {
        let error = |windows| BuildError::TooFast {
            windows,
            rate: 1e150,
            period: 1e-3,
        };
        for (windows, expected) in [
            (1e148, "take 1.00e148 windows"),
            (25_000.4, "take 25000 windows"),
        ] {
            let message = error(windows).to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
