//! Follows all branches and curves of a job. Orbits are followed over one axis. A line is one combination of
//! values of the other axes; each line has a separate family of drives.

use super::family::PointFamily;
use super::motion_scale;
use super::parts::Prepared;
use crate::analysis::Interrupted;
use crate::analysis::continuation::bifurcation::Bifurcation;
use crate::analysis::continuation::branch::StepSettings;
use crate::analysis::continuation::curve::{Curve, CurveSettings, follow, is_known};
use crate::analysis::continuation::drive::DriveMap;
use crate::analysis::continuation::explore::{
    Branches, ExplorationSettings, ExploreError, explore,
};
use crate::analysis::continuation::map::MapError;
use crate::analysis::continuation::map::MapParameters;
use crate::analysis::continuation::onset::{Onset, onset};
use crate::analysis::continuation::path::Span;
use crate::analysis::continuation::search::OrbitSearchSettings;
use crate::manifest::{ContinuationSpec, Job, Parameter, ParameterError, PointSpec, StiffnessSpec};
use crate::model::InitialState;
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;

/// Number of values of the second parameter for the onset of rattle.
const ONSETS: usize = 201;

/// Kinds of bifurcation that curves follow.
const CURVES: [&str; 4] = ["fold", "period_doubling", "torus", "graze"];

/// Reason why orbits cannot be followed.
#[derive(Debug, thiserror::Error)]
pub enum FollowError {
    /// The manifest has no `[continuation]`, or its axis has one value.
    #[error(
        "there is nothing to follow: [continuation] is missing, or its axis has one value; give [continuation] over = \"speed\", and grid.speed as an interval"
    )]
    NotAsked,
    /// An axis is not a parameter.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A state does not have one number per mode.
    #[error(
        "continuation.states.{number} has {given} displacements for {modes} retained modes; give one per mode"
    )]
    StateLength {
        /// Number of the state.
        number: usize,
        /// Number of its displacements.
        given: usize,
        /// Number of modes.
        modes: usize,
    },
    /// The drive of a line cannot be built, or its motion cannot be computed.
    #[error("{place}: {source}")]
    Line {
        /// The line.
        place: String,
        /// Reason.
        source: Box<ExploreError>,
    },
    /// The work was interrupted.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Branches at one combination of values of the other axes.
#[derive(Debug)]
pub struct Line {
    /// Value of every axis of the job; NaN for the axis that orbits are followed over.
    pub axis_values: Vec<f64>,
    /// The branches.
    pub branches: Branches,
    /// Number of models that were built.
    pub models: u64,
}

/// Curves in the plane of two axes, with the other axes fixed.
#[derive(Debug)]
pub struct Curves {
    /// Value of every axis; NaN for the two axes of the plane.
    pub axis_values: Vec<f64>,
    /// The curves, by kind.
    pub all: Vec<Curve>,
    /// The onset of rattle; empty unless one of the two axes is the load or torque and the mesh has no table.
    pub onset: Vec<Onset>,
}

/// Followed branches and curves.
#[derive(Debug)]
pub struct Followed {
    /// One entry per line.
    pub lines: Vec<Line>,
    /// One entry per plane; empty without a second axis.
    pub planes: Vec<Curves>,
}

/// Follows all branches and curves of a job, on the threads of the current rayon pool. Calls `passed` with a sentence
/// for every finished line, and for every kind of bifurcation whose curves in a plane are finished.
///
/// # Errors
/// [`FollowError`].
pub fn follow_job(
    job: &Job,
    parts: &Prepared,
    interrupt: &AtomicBool,
    passed: &(dyn Fn(&str) + Sync),
) -> Result<Followed, FollowError> {
    let spec = job.continuation.as_ref().ok_or(FollowError::NotAsked)?;
    let first_value = job.axes[spec.over].values.get(0);
    let bases: Vec<PointSpec> = (job.points.iter())
        .filter(|point| point.axis_values[spec.over] == first_value)
        .filter(|point| {
            point.direction.is_none_or(|way| {
                Some(&way) == job.carried.as_ref().and_then(|c| c.directions.first())
            })
        })
        .collect();
    let lines: Vec<Line> = (bases.par_iter())
        .map(|base| {
            let line = line(job, spec, base, parts, interrupt)?;
            passed(&format!(
                "{}: {} branches",
                place_of(job, &line.axis_values),
                line.branches.all.len()
            ));
            Ok(line)
        })
        .collect::<Result<_, FollowError>>()?;
    let mut planes = Vec::new();
    if let Some(second) = spec.second {
        let first = job.axes[second].values.get(0);
        for base in bases
            .iter()
            .filter(|base| base.axis_values[second] == first)
        {
            let of_plane: Vec<&Line> = (lines.iter())
                .filter(|line| {
                    let given = |i: &usize| !job.between.is_derived(job.axes[*i].name());
                    let others = (0..job.axes.len())
                        .filter(|i| ![spec.over, second].contains(i) && given(i));
                    others
                        .into_iter()
                        .all(|i| line.axis_values[i] == base.axis_values[i])
                })
                .collect();
            planes.push(plane(
                job,
                spec,
                (second, base),
                &of_plane,
                parts,
                interrupt,
                passed,
            )?);
        }
    }
    Ok(Followed { lines, planes })
}

/// The values of the fixed axes, in words.
fn place_of(job: &Job, values: &[f64]) -> String {
    let fixed_values = job
        .axes
        .iter()
        .zip(values)
        .filter(|(axis, value)| !value.is_nan() && axis.values.len() > 1);
    let words: Vec<String> = fixed_values
        .map(|(axis, value)| format!("{} = {value:.6}", axis.name()))
        .collect();
    if words.is_empty() { job.name.clone() } else { words.join(", ") }
}

fn family<'a>(
    job: &'a Job,
    base: &PointSpec,
    axes: &[usize],
    parts: &'a Prepared,
) -> Result<PointFamily<'a>, ParameterError> {
    let parameters: Vec<Parameter> = (axes.iter())
        .map(|&axis| job.between.parameter(base, job.axes[axis].name()))
        .collect::<Result<_, _>>()?;
    Ok(PointFamily::new(
        base.clone(),
        parameters,
        &job.between,
        parts,
    ))
}

fn line(
    job: &Job,
    spec: &ContinuationSpec,
    base: &PointSpec,
    parts: &Prepared,
    interrupt: &AtomicBool,
) -> Result<Line, FollowError> {
    states_fit(spec, base.model.retained)?;
    let axes: Vec<usize> = std::iter::once(spec.over).chain(spec.second).collect();
    let family = family(job, base, &axes, parts)?;
    let mut axis_values = base.axis_values.clone();
    axis_values[spec.over] = f64::NAN;
    let (from, to) = job.axes[spec.over].values.ends();
    let second = family.values()[1];
    let starts: Vec<f64> = (0..spec.starts)
        .map(|i| from + (to - from) * (i as f64 + 0.5) / spec.starts as f64)
        .collect();
    let exploration = ExplorationSettings {
        span: Span { axis: 0, from, to },
        search: OrbitSearchSettings {
            transient: spec.transient,
            cycles: spec.cycles,
            longest: spec.longest_period,
            guesses: spec.guesses,
            initial: base.run.initial.clone(),
        },
        states: spec.states.clone(),
        steps: StepSettings {
            longest: spec.step,
            most: spec.orbits,
            ..StepSettings::default()
        },
        most: spec.branches,
        starts,
    };
    let at = [exploration.starts.first().copied().unwrap_or(from), second];
    let refused = |source: ExploreError| FollowError::Line {
        place: place_of(job, &axis_values),
        source: Box::new(source),
    };
    let family =
        motion_scale::measured(family, at, &base.run.initial).map_err(|e| refused(e.into()))?;
    let explored = DriveMap::new(&family, at)
        .map_err(ExploreError::from)
        .and_then(|map| {
            let mut map = map.with_interrupt(interrupt);
            explore(&mut map, second, &exploration, interrupt)
                .map(|branches| (branches, map.models))
        });
    Interrupted::check(interrupt)?;
    match explored {
        Ok((branches, models)) => Ok(Line {
            axis_values,
            branches,
            models,
        }),
        Err(ExploreError::Interrupted(interrupt)) => Err(interrupt.into()),
        Err(source) => Err(refused(source)),
    }
}

/// Checks that every given state has one number per mode.
fn states_fit(spec: &ContinuationSpec, modes: usize) -> Result<(), FollowError> {
    for (number, given) in spec.states.iter().enumerate() {
        if let InitialState::Modal { displacement, .. } = &given.state
            && displacement.len() != modes
        {
            return Err(FollowError::StateLength {
                number,
                given: displacement.len(),
                modes,
            });
        }
    }
    Ok(())
}

/// The curves of a plane, for each kind of bifurcation separately. A curve starts at each requested
/// bifurcation of the lines that is not on a curve yet.
fn plane(
    job: &Job,
    spec: &ContinuationSpec,
    (second, base): (usize, &PointSpec),
    lines: &[&Line],
    parts: &Prepared,
    interrupt: &AtomicBool,
    passed: &(dyn Fn(&str) + Sync),
) -> Result<Curves, FollowError> {
    let family = family(job, base, &[spec.over, second], parts)?;
    let ends = [spec.over, second].map(|axis| job.axes[axis].values.ends());
    let plane = CurveSettings {
        from: ends.map(|e| e.0),
        to: ends.map(|e| e.1),
        longest: spec.step,
        most: spec.orbits,
    };
    let mut axis_values = base.axis_values.clone();
    axis_values[spec.over] = f64::NAN;
    axis_values[second] = f64::NAN;
    let refused = |source: ExploreError| FollowError::Line {
        place: place_of(job, &axis_values),
        source: Box::new(source),
    };
    let middle: MapParameters = std::array::from_fn(|i| 0.5 * (plane.from[i] + plane.to[i]));
    let family = motion_scale::measured(family, middle, &base.run.initial)
        .map_err(|error| refused(error.into()))?;
    let of_kind: Vec<Vec<Curve>> = (CURVES.par_iter())
        .map(|kind| {
            let map = DriveMap::new(&family, middle).map_err(|e| refused(e.into()))?;
            let mut map = map.with_interrupt(interrupt);
            let mut curves: Vec<Curve> = Vec::new();
            let branches = lines.iter().flat_map(|line| &line.branches.all);
            let found = branches.flat_map(|(_, branch)| {
                let wanted = |b: &&Bifurcation| spec.all_curves || branch.has_stable_neighbour(b);
                branch.bifurcations.iter().filter(wanted)
            });
            for bifurcation in found.filter(|b| b.kind.name() == *kind) {
                Interrupted::check(interrupt)?;
                let Ok(orbit) = map.in_own_coordinates(&bifurcation.orbit) else {
                    continue;
                };
                let bifurcation = Bifurcation {
                    orbit,
                    ..bifurcation.clone()
                };
                if is_known(&plane, &curves, &bifurcation) {
                    continue;
                }
                curves.extend(follow(&mut map, &plane, &bifurcation));
            }
            Interrupted::check(interrupt)?;
            passed(&format!(
                "{}: {} curves ({kind})",
                place_of(job, &axis_values),
                curves.len()
            ));
            Ok(curves)
        })
        .collect::<Result<_, FollowError>>()?;
    let onset = onsets(job, spec, second, base, &family, &plane).map_err(refused)?;
    Ok(Curves {
        axis_values: axis_values.clone(),
        all: of_kind.into_iter().flatten().collect(),
        onset,
    })
}

/// The onset of rattle as a function of the other axis. It is computed only if one of the two axes is the
/// load or torque, and the mesh stiffness does not depend on the load.
fn onsets(
    job: &Job,
    spec: &ContinuationSpec,
    second: usize,
    base: &PointSpec,
    family: &PointFamily<'_>,
    plane: &CurveSettings,
) -> Result<Vec<Onset>, ExploreError> {
    let names = [spec.over, second].map(|axis| job.axes[axis].name());
    let Some(load) = (names.iter()).position(|name| matches!(*name, "load" | "torque")) else {
        return Ok(Vec::new());
    };
    if matches!(base.mesh.stiffness, StiffnessSpec::Table(_)) {
        return Ok(Vec::new());
    }
    let other = 1 - load;
    let mut at = plane.from;
    let mut map = DriveMap::new(family, at)?;
    let mut found = Vec::new();
    for i in 0..ONSETS {
        at[other] = plane.from[other]
            + (plane.to[other] - plane.from[other]) * i as f64 / (ONSETS - 1) as f64;
        match onset(&mut map, at, load) {
            Ok(onset) => found.extend(onset),
            Err(MapError::NoModel(_)) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(found)
}
