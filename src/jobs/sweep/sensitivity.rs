//! How do the results of a point change with keys of its manifest?

use super::build::{BuildError, point_config};
use super::family::PointFamily;
use super::parts::Prepared;
use super::point_kernel::PointKernel;
use crate::analysis::continuation::drive::ParametricDrive;
use crate::analysis::orbits::shooting::shoot;
use crate::analysis::sensitivity::ensemble::{self, AVERAGES, Ensemble, averages, slope};
use crate::analysis::sensitivity::orbit::{QUANTITIES, derivatives};
use crate::analysis::{
    Class, EndedEarly, EnergyNorm, Interrupted, PointOutcome, Status, investigate_onward,
};
use crate::manifest::{Job, Parameter, PointSpec};
use crate::model::{Model, ModelDerivative, TrajectoryState};
use crate::numerics::random::PointSeed;
use crate::propagate::{Counters, Kernel, KernelUse, Stop};
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;

/// Harmonics of the mesh frequency whose amplitudes are differentiated.
const HARMONICS: usize = 3;

/// Step of the differences that check derivatives, relative to the parameter's size.
const CHECK_STEP: f64 = 1e-5;

/// Relative difference above which a derivative and a difference quotient disagree.
const DISAGREEMENT: f64 = 1e-2;

/// Relative derivative `p ∂a/∂p / a` below which a key has no effect, and only round-off would be compared.
const NEGLIGIBLE: f64 = 1e-5;

/// Note if a derivative and its difference quotient disagree.
const KINK: &str = "finite differences disagree, because the model has a kink here or the orbit changes within a step";

/// Note for a derivative without a check.
const UNCHECKED: &str =
    "no finite difference checks it, because no orbit was found at a value nearby";

/// Note for an amplitude of zero.
const AT_ZERO: &str = "the amplitude is zero up to round-off, and amplitudes have a kink at zero";

/// Cycles between the starts of an ensemble's members.
const CYCLES_BETWEEN_STARTS: u64 = 50;

/// The change of a quantity with a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// The key.
    pub key: String,
    /// SI unit of the key.
    pub key_unit: &'static str,
    /// Value of the key.
    pub at: f64,
    /// The quantity.
    pub quantity: String,
    /// SI unit of the quantity.
    pub unit: &'static str,
    /// Value of the quantity.
    pub value: f64,
    /// Derivative of the quantity by the key, in SI; `None` if it does not exist or is unreliable.
    pub by: Option<f64>,
    /// The same derivative from differences, or from a step twice as large.
    pub check: Option<f64>,
    /// Standard error of the derivative, if it is an estimate.
    pub error: Option<f64>,
    /// The method: `orbit` (exact), `difference` or `ensemble`.
    pub method: &'static str,
    /// Reason for a missing derivative, or doubts about it.
    pub note: String,
}

/// The sensitivities of a point.
#[derive(Debug)]
pub struct Sensitivities {
    /// Class of the motion.
    pub class: Class,
    /// Reason for the class, in words.
    pub reason: String,
    /// One row per key and quantity.
    pub rows: Vec<Sensitivity>,
}

/// A point whose results are differentiated.
#[derive(Debug, Clone, Copy)]
pub struct Differentiated<'a> {
    /// The point.
    pub point: &'a PointSpec,
    /// Keys whose values at the point differ from the manifest, with these values.
    pub held: &'a [(Parameter, f64)],
}

/// Why a point has no sensitivities.
#[derive(Debug, thiserror::Error)]
pub enum SensitivityError {
    /// The drive cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The class of the motion is unknown.
    #[error("the point does not settle, so its results cannot be differentiated: {reason}")]
    Unsettled {
        /// Reason.
        reason: String,
    },
    /// The orbit cannot be integrated.
    #[error(transparent)]
    Stop(#[from] Stop),
    /// The computation was interrupted.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl From<EndedEarly> for SensitivityError {
    fn from(error: EndedEarly) -> Self {
        match error {
            EndedEarly::Stop(stop) => Self::Stop(stop),
            EndedEarly::Interrupted(interrupt) => Self::Interrupted(interrupt),
        }
    }
}

/// The sensitivities of a point to some keys. They are exact for motion that repeats. For chaotic motion they are
/// estimates over an ensemble, whose step is `step` times the size of each key.
///
/// # Errors
/// [`SensitivityError`].
pub fn sensitivities(
    job: &Job,
    Differentiated { point, held }: Differentiated<'_>,
    keys: &[Parameter],
    settings: &Ensemble,
    step: f64,
    parts: &Prepared,
    interrupt: &AtomicBool,
) -> Result<Sensitivities, SensitivityError> {
    let model = parts.model(point)?;
    let seed = point.random();
    let settle = Settle {
        model: &model,
        start: model.start(&point.run.initial),
        point,
        seed,
        interrupt,
    };
    let (outcome, state) = with_kernel(point, &model, parts, settle)??;
    let unsettled = || SensitivityError::Unsettled {
        reason: outcome.reason.clone(),
    };
    let class = outcome
        .class
        .filter(|_| matches!(outcome.status, Status::Ok | Status::NotConverged))
        .ok_or_else(unsettled)?;
    let of_key = |key: &Parameter| -> Result<Vec<Sensitivity>, SensitivityError> {
        Interrupted::check(interrupt)?;
        let family = PointFamily::new(point.clone(), vec![key.clone()], &job.between, parts);
        let family = family.holding(held);
        match class {
            Class::Periodic(period) | Class::SteadyContact(Some(period)) => {
                of_orbit(&family, &model, &state, period, parts)
            }
            Class::Chaotic | Class::TransientChaos => {
                of_ensemble(&family, &model, &state, settings, step, parts, interrupt)
            }
            _ => Err(unsettled()),
        }
    };
    let rows: Vec<Vec<Sensitivity>> = keys.par_iter().map(of_key).collect::<Result<_, _>>()?;
    let rows = rows.into_iter().flatten().collect();
    Ok(Sensitivities {
        class,
        reason: outcome.reason,
        rows,
    })
}

fn with_kernel<U: KernelUse + Clone>(
    point: &PointSpec,
    model: &Model,
    parts: &Prepared,
    user: U,
) -> Result<U::Output, BuildError> {
    PointKernel::of(point, model, parts)?.apply(model, parts, |_| user.clone())
}

#[derive(Clone)]
struct Settle<'a> {
    model: &'a Model,
    start: TrajectoryState,
    point: &'a PointSpec,
    seed: PointSeed,
    interrupt: &'a AtomicBool,
}

impl KernelUse for Settle<'_> {
    type Output = Result<(PointOutcome, TrajectoryState), Interrupted>;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output {
        let mut trajectory = self.start;
        let config = point_config(self.point, self.seed);
        let outcome =
            investigate_onward(self.model, kernel, &mut trajectory, &config, self.interrupt)?;
        Ok((outcome, trajectory))
    }
}

/// A request for the quantities of an orbit, then the modulus of its largest multiplier, and for the derivatives of the
/// quantities. The output is `None` if no orbit is found.
#[derive(Clone)]
struct Orbit<'a> {
    model: &'a Model,
    by: &'a ModelDerivative,
    start: &'a TrajectoryState,
    period: u32,
}

impl KernelUse for Orbit<'_> {
    type Output = Result<Option<(Vec<f64>, Vec<f64>)>, Stop>;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output {
        let norm = EnergyNorm::new(self.model);
        let start = TrajectoryState::new(self.model, self.start.state.clone(), self.start.cycle);
        let found = shoot(
            self.model,
            kernel,
            &norm,
            &start,
            self.period,
            &mut kernel.workspace(),
        )?;
        let Some(orbit) = found else { return Ok(None) };
        let all = derivatives(
            self.model,
            self.by,
            kernel,
            &orbit.start,
            self.period,
            HARMONICS,
        )?;
        let mut values: Vec<f64> = all.iter().map(|d| d.value).collect();
        values.push(orbit.spectral_radius());
        Ok(Some((values, all.iter().map(|d| d.by_parameter).collect())))
    }
}

/// A state of the model `other` as a state of `model`; unchanged if no transformation between their bases exists.
fn state_in(model: &Model, other: &Model, state: &TrajectoryState) -> TrajectoryState {
    let change = model.basis.change_to(&other.basis);
    let blocks = change.map_or_else(|_| state.state.clone(), |change| change.undo(&state.state));
    TrajectoryState::new(model, blocks, state.cycle)
}

/// Exact derivatives along an orbit, each with a difference quotient of the fourth order.
fn of_orbit(
    family: &PointFamily<'_>,
    model: &Model,
    start: &TrajectoryState,
    period: u32,
    parts: &Prepared,
) -> Result<Vec<Sensitivity>, SensitivityError> {
    let key = &family.parameters[0];
    let at = family.values();
    let by = family.derivative(at, 0, &model.basis);
    let names = QUANTITIES
        .iter()
        .map(|(name, unit)| ((*name).to_owned(), *unit));
    let harmonics = (1..=HARMONICS).map(|m| (format!("deflection_harmonic_{m}"), "m"));
    let multiplier = std::iter::once(("multiplier".to_owned(), "1"));
    let unchanged = model.unchanged();
    let task = Orbit {
        model,
        by: by.as_ref().unwrap_or(&unchanged),
        start,
        period,
    };
    let found = with_kernel(&family.point, model, parts, task)??;
    let Some((values, exact)) = found else {
        return Err(SensitivityError::Unsettled {
            reason: "Newton's method does not find the orbit at a nearby value".to_owned(),
        });
    };
    let h = CHECK_STEP * family.size(at, 0);
    let base = model;
    let near = |steps: f64| -> Option<Vec<f64>> {
        let there = [at[0] + steps * h, at[1]];
        let point = family.at(there).ok()?;
        let model = parts.model(&point).ok()?;
        let orbit = Orbit {
            model: &model,
            by: &model.unchanged(),
            start: &state_in(&model, base, start),
            period,
        };
        Some(with_kernel(&point, &model, parts, orbit).ok()?.ok()??.0)
    };
    let around = [-2.0, -1.0, 1.0, 2.0].map(near);
    let difference = |i: usize| -> Option<f64> {
        let [a, b, c, d] = around
            .each_ref()
            .map(|values| values.as_ref().map(|v| v[i]));
        Some((a? - 8.0 * b? + 8.0 * c? - d?) / (12.0 * h))
    };
    let fault = by.err().unwrap_or_default();
    Ok((names.chain(harmonics).chain(multiplier).enumerate())
        .map(|(i, (quantity, unit))| {
            let exact = exact.get(i).copied().filter(|_| fault.is_empty());
            let at_zero = exact.is_some_and(f64::is_nan);
            let check = difference(i).filter(|_| !at_zero);
            let by = exact.filter(|_| !at_zero).or(check);
            Sensitivity {
                key: key.name().to_owned(),
                key_unit: key.unit(),
                at: at[0],
                method: if exact.is_some() { "orbit" } else { "difference" },
                value: values[i],
                by,
                check: exact.and(check),
                error: None,
                note: match exact.zip(check) {
                    _ if at_zero => AT_ZERO.to_owned(),
                    None if exact.is_some() => UNCHECKED.to_owned(),
                    Some((exact, check))
                        if (exact - check).abs()
                            > DISAGREEMENT
                                * exact
                                    .abs()
                                    .max(check.abs())
                                    .max(NEGLIGIBLE * (values[i] / family.size(at, 0)).abs()) =>
                    {
                        KINK.to_owned()
                    }
                    _ if i < QUANTITIES.len() + HARMONICS => fault.clone(),
                    _ => String::new(),
                },
                quantity,
                unit,
            }
        })
        .collect())
}

#[derive(Clone)]
struct Members<'a> {
    model: &'a Model,
    starts: &'a [TrajectoryState],
    settings: &'a Ensemble,
    interrupt: &'a AtomicBool,
}

impl KernelUse for Members<'_> {
    type Output = Result<Vec<[f64; 4]>, EndedEarly>;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output {
        averages(
            self.model,
            kernel,
            self.starts,
            self.settings,
            self.interrupt,
        )
    }
}

#[derive(Clone)]
struct Starts<'a> {
    start: &'a TrajectoryState,
    members: usize,
}

impl KernelUse for Starts<'_> {
    type Output = Result<Vec<TrajectoryState>, Stop>;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output {
        let mut workspace = kernel.workspace();
        let mut state = self.start.clone();
        (0..self.members)
            .map(|_| {
                kernel.advance(
                    CYCLES_BETWEEN_STARTS,
                    &mut state,
                    &mut workspace,
                    &mut (),
                    &mut Counters::default(),
                )?;
                Ok(state.clone())
            })
            .collect()
    }
}

/// Slopes of averages over an ensemble.
fn of_ensemble(
    family: &PointFamily<'_>,
    model: &Model,
    state: &TrajectoryState,
    settings: &Ensemble,
    step: f64,
    parts: &Prepared,
    interrupt: &AtomicBool,
) -> Result<Vec<Sensitivity>, SensitivityError> {
    let key = &family.parameters[0];
    let at = family.values();
    let starts = with_kernel(
        &family.point,
        model,
        parts,
        Starts {
            start: state,
            members: settings.members,
        },
    )??;
    let h = step * family.size(at, 0);
    let base = model;
    let mut members = Vec::new();
    for steps in [-2.0, -1.0, 1.0, 2.0] {
        let there = [at[0] + steps * h, at[1]];
        let point = family.at(there).map_err(BuildError::Values)?;
        let model = parts.model(&point)?;
        let starts: Vec<TrajectoryState> = (starts.iter())
            .map(|start| state_in(&model, base, start))
            .collect();
        members.push(with_kernel(
            &point,
            &model,
            parts,
            Members {
                model: &model,
                starts: &starts,
                settings,
                interrupt,
            },
        )??);
    }
    Ok((AVERAGES.iter().enumerate())
        .map(|(i, (quantity, unit))| {
            let of: Vec<Vec<f64>> = members
                .iter()
                .map(|all| all.iter().map(|values| values[i]).collect())
                .collect();
            let found: ensemble::Slope = slope([&of[0], &of[1], &of[2], &of[3]], h);
            let reason = found.unreliable_reason();
            Sensitivity {
                key: key.name().to_owned(),
                key_unit: key.unit(),
                at: at[0],
                quantity: (*quantity).to_owned(),
                unit,
                value: found.value,
                by: reason.is_none().then_some(found.by_parameter),
                check: Some(found.doubled[0]),
                error: Some(found.error),
                method: "ensemble",
                note: reason.unwrap_or_default().to_owned(),
            }
        })
        .collect())
}
