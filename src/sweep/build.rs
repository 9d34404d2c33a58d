//! From a point's specification to the system that kernels march.

use super::mesh_tables::{MeshError, MeshTables};
pub use super::parts::{Parts, tables_wanted};
use crate::analysis::{
    GrowthNorm, HorizonQuestion, LyapunovQuestion, MultistabilityQuestion, NvhQuestion,
    OrbitQuestion, Plane, Questions, Section, SliceError, SliceOf, SliceQuestion,
};
use crate::manifest::{
    DampingSpec, InitialSpec, KernelSpec, ModelSpec, PointSpec, SectionSpec, ShaftName, SliceSpec,
    StiffnessSpec, StructureSource,
};
use crate::model::{
    Division, Drive, InitialState, Model, ModelError, OperatingPoint, RippleInput, RippleShaft,
};
use crate::propagate::Volterra;
use crate::shaft::{ModalStructure, ShaftError};
use crate::store::OperatorFetchError;

/// Why a point's system cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// The values of the point's axes do not go together.
    #[error("no drive has these values: {0}")]
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
    /// The kernel's tables cannot be come by.
    #[error("{error}{}", advice.as_ref().map_or(String::new(), |advice| format!("; {advice}")))]
    Tables {
        /// Why.
        error: OperatorFetchError,
        /// Which other kernel there is, where it is the model that tables do not fit.
        advice: Option<String>,
    },
    /// There is no such slice of initial states.
    #[error("analyses.multistability.slice: {0}")]
    Slice(#[from] SliceError),
    /// The motion is too fast for the mesh cycle.
    #[error(
        "one mesh cycle would take {windows:.0} windows (at most {MOST_WINDOWS}): the fastest motion, {rate:.1e} rad/s, is too fast for the mesh period of {period:.1e} s; check the units of mesh stiffness and damping, leave out high modes, or raise the speed"
    )]
    TooFast {
        /// Windows a mesh cycle.
        windows: f64,
        /// Fastest rate of the closed system \[rad/s\].
        rate: f64,
        /// Mesh period \[s\].
        period: f64,
    },
}

/// Most windows in a mesh cycle: some milliseconds a cycle, so that a job can still be
/// called off and a mistaken unit does not cost a night.
const MOST_WINDOWS: f64 = 20_000.0;

/// Whether a kernel gets through a mesh cycle of a model in reasonable time.
///
/// # Errors
/// [`BuildError::TooFast`] where the structured kernel would need too many windows.
pub fn affordable(model: &Model, kernel: &KernelSpec) -> Result<(), BuildError> {
    let KernelSpec::Volterra { tolerance } = kernel else {
        return Ok(());
    };
    let windows = Volterra::windows_needed(model, *tolerance);
    // Written so that a rate that is not finite is refused too.
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
    /// Of tables that a model does not have, with what is known to fit it.
    pub fn tables(error: impl Into<OperatorFetchError>, model: &Model) -> Self {
        let error = error.into();
        let another = match &error {
            OperatorFetchError::Dense(dense) => dense.concerns_the_model(),
            OperatorFetchError::Arrays(_) => false,
        };
        Self::Tables {
            advice: another.then(|| structured_instead(model)),
            error,
        }
    }
}

/// Whether the structured kernel gets through a mesh cycle that tables do not fit.
fn structured_instead(model: &Model) -> String {
    let windows = Volterra::windows_needed(model, f64::EPSILON);
    match windows <= MOST_WINDOWS {
        true => format!(
            "or set run.kernel = \"volterra\", which takes this mesh cycle in {windows:.0} windows"
        ),
        false => format!(
            "run.kernel = \"volterra\" does not fit either: it would take {windows:.0} windows \
             (at most {MOST_WINDOWS})"
        ),
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
        StructureSource::Modal(structure) => structure.truncated(spec.retained, spec.mta),
    }
}

/// The piecewise-linear system of a point.
pub(super) fn model(
    structure: &ModalStructure,
    point: &PointSpec,
    meshes: &MeshTables,
) -> Result<Model, BuildError> {
    let average = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let mut error: Vec<_> = (point.excitation.transmission_error.iter())
        .map(|h| (h.harmonic, h.amplitude, h.phase))
        .collect();
    let (mesh, mean) = match &point.mesh.stiffness {
        StiffnessSpec::Constant(k) => (Division::levels(&[*k], &[]), *k),
        StiffnessSpec::Piecewise(values) => (Division::levels(values, &[]), average(values)),
        StiffnessSpec::Continuous(levels) => {
            let (stiffness, transitions) = levels.divisions();
            (Division::levels(&stiffness, &transitions), levels.mean())
        }
        StiffnessSpec::Table(spec) => {
            let mesh = meshes.mesh(point, spec, structure)?;
            error.extend(mesh.transmission_error);
            (mesh.divisions, mesh.mean_stiffness)
        }
    };
    let drive = Drive {
        half_gap: point.mesh.half_gap,
        damping: match point.mesh.damping {
            DampingSpec::Coefficient(c) => c,
            DampingSpec::Ratio(ratio) => Model::damping_from_ratio(structure, ratio, mean),
        },
        mesh,
        friction: point.mesh.friction,
        transmission_error: error,
        torque_ripple: point
            .excitation
            .torque_ripple
            .iter()
            .map(|r| RippleInput {
                shaft: match r.shaft {
                    ShaftName::Pinion => RippleShaft::Pinion,
                    ShaftName::Wheel => RippleShaft::Wheel,
                },
                order: r.order,
                amplitude: r.amplitude,
                phase: r.phase,
            })
            .collect(),
    };
    let operating = OperatingPoint {
        load: point.load,
        speed: point.speed,
    };
    Ok(Model::new(structure, &drive, operating)?)
}

/// Where a point's trajectory starts.
pub fn initial(spec: &InitialSpec) -> InitialState {
    match spec {
        InitialSpec::Static => InitialState::Static,
        InitialSpec::Rest => InitialState::Rest,
        InitialSpec::Modal {
            displacement,
            velocity,
        } => InitialState::Modal {
            displacement: displacement.clone(),
            velocity: velocity.clone(),
        },
    }
}

/// What is asked of a point.
pub fn questions(point: &PointSpec, seed: u64) -> Questions {
    let analyses = &point.analyses;
    Questions {
        seed,
        point_id: point.point_id,
        transient: point.run.transient,
        cycles: point.run.cycles,
        settle: point.run.settle,
        audit_cycles: point.run.audit_cycles,
        lyapunov: analyses.lyapunov.map(|l| LyapunovQuestion {
            exponents: l.exponents,
            stop_at_stderr: l.stop_at_stderr,
            align: l.align,
            twin: l.twin,
            norm: match l.raw_norm {
                true => GrowthNorm::Raw,
                false => GrowthNorm::Energy,
            },
        }),
        poincare_samples: analyses.poincare.map_or(0, |p| p.samples),
        section: match analyses.poincare.map(|p| p.section) {
            None => Section::default(),
            Some(SectionSpec::Strobe { phase }) => Section::Strobe { phase },
            Some(SectionSpec::Entry) => Section::Entry,
            Some(SectionSpec::Turning) => Section::Turning,
        },
        nvh: analyses.nvh.map(|n| NvhQuestion {
            harmonics: n.harmonics,
            spectrum: n.spectrum,
            bearings: n.bearings,
        }),
    }
}

/// The probes asked of a point.
///
/// # Errors
/// The model has no such slice as is asked for.
pub fn probes(
    model: &Model,
    point: &PointSpec,
    seed: u64,
) -> Result<Option<MultistabilityQuestion>, SliceError> {
    let Some(asked) = point.analyses.multistability else {
        return Ok(None);
    };
    let slice = |asked: SliceSpec| {
        let question = SliceQuestion {
            modes: asked.modes,
            of: if asked.velocity {
                SliceOf::Velocity
            } else {
                SliceOf::Displacement
            },
            extent: asked.extent,
            count: asked.count,
        };
        Plane::new(model, &question)
    };
    Ok(Some(MultistabilityQuestion {
        seed,
        point_id: point.point_id,
        initial_conditions: asked.initial_conditions,
        decades: asked.decades,
        transient: asked.transient,
        cycles: asked.cycles,
        settle: point.run.settle,
        slice: asked.slice.map(slice).transpose()?,
    }))
}

/// The periodic orbits asked of a point.
pub fn orbits(point: &PointSpec) -> Option<OrbitQuestion> {
    let asked = point.analyses.orbits.as_ref()?;
    Some(OrbitQuestion {
        periods: asked.periods.clone(),
        guesses: asked.guesses,
        cycles: asked.cycles,
        floquet: asked.floquet,
    })
}

/// The predictability asked of a point.
pub fn horizon(point: &PointSpec, seed: u64) -> Option<HorizonQuestion> {
    let asked = point.analyses.horizon?;
    Some(HorizonQuestion {
        seed,
        point_id: point.point_id,
        twins: asked.twins,
        separation: asked.separation,
        cycles: asked.cycles,
        averages: asked.averages,
    })
}
