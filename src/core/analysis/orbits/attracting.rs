//! Which orbit does a trajectory approach, and how is that verified?
//!
//! Newton's method may find an orbit near a trajectory that does not approach it. The trajectory is therefore
//! observed while the slowest multiplier halves its distance. If it comes as near as the monodromy matrix predicts,
//! the orbit attracts it. If neither the orbit nor the approach has an event, the matrix alone may prove this without
//! an integration.

use super::shooting::{PeriodicOrbit, SAME_POINT, shoot, shortest};
use crate::analysis::lasting_contact::LastingContact;
use crate::analysis::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::linalg::{eigenpair, product};
use crate::propagate::{Counters, Kernel, Stop};
use faer::Mat;

/// Longest integration of one observation of an approach \[mesh cycles\].
const LONGEST_WATCH: f64 = 3000.0;

/// Distance, in half gaps, below which a trajectory counts as on the orbit, if the orbit is known to this accuracy.
const ARRIVED: f64 = 1e-9;

/// Upper limit of that distance, in half gaps, for orbits that are known less accurately.
const FARTHEST_ARRIVED: f64 = 1e-5;

/// Largest error of the predicted approach, relative to the decrease of the distance.
const PREDICTION_SLACK: f64 = 0.2;

/// An observed approach over some periods of an orbit.
struct ObservedApproach {
    /// Offsets from the orbit in energy coordinates, before and after the observation.
    before: Mat<f64>,
    after: Mat<f64>,
    /// Prediction of `after` by the monodromy matrix.
    predicted: Mat<f64>,
    /// Whether the events are those of the orbit.
    same_events: bool,
    /// Whether contact is certain to last until the orbit is reached.
    certain: bool,
}

/// Settings for the observation of an approach to an orbit.
struct ApproachSettings<'a, K: Kernel> {
    kernel: &'a K,
    norm: &'a EnergyNorm,
    orbit: &'a PeriodicOrbit,
    /// Observed periods: the number in which the slowest multiplier halves the distance, limited by
    /// [`LONGEST_WATCH`].
    periods: u64,
    /// Whether [`LONGEST_WATCH`] limits the number of observed periods.
    cut: bool,
    /// Predicted relative decrease of the distance over the observed periods, at most one half.
    decrease: f64,
    /// Distance below which a trajectory is on the orbit. A residual r leaves an uncertainty r / (1 − μ) of the orbit
    /// along the direction of the slowest multiplier μ.
    arrival_distance: f64,
}

impl<'a, K: Kernel> ApproachSettings<'a, K> {
    /// `None` if the orbit does not attract.
    fn new(kernel: &'a K, norm: &'a EnergyNorm, orbit: &'a PeriodicOrbit) -> Option<Self> {
        if !orbit.attracts() {
            return None;
        }
        let radius = orbit.spectral_radius();
        let halving = (0.5f64.ln() / radius.ln()).ceil().max(1.0);
        let most = (LONGEST_WATCH / f64::from(orbit.period)).floor().max(1.0);
        let periods = halving.min(most);
        Some(Self {
            kernel,
            norm,
            orbit,
            periods: periods as u64,
            cut: most < halving,
            // `1 − radiusⁿ` over n periods, without cancellation for a radius near 1.
            decrease: (-(periods * radius.ln()).exp_m1()).min(0.5),
            arrival_distance: norm.unit()
                * (2.0 * orbit.residual / (1.0 - radius)).clamp(ARRIVED, FARTHEST_ARRIVED),
        })
    }

    fn offset(&self, state: &[f64]) -> Mat<f64> {
        let apart = self.norm.difference(state, &self.orbit.start.state);
        Mat::from_fn(apart.len(), 1, |row, _| apart[row])
    }

    /// Advances `trajectory` from the start of a period, and records the approach. The integration ends early
    /// if the events are not those of the orbit, or if contact is certain to last. One event may be missing
    /// or additional, because it may have moved across the start of a cycle.
    fn follow(
        &self,
        trajectory: &mut TrajectoryState,
        mut lasting: Option<&mut LastingContact<'_>>,
        workspace: &mut K::Workspace,
        counters: &mut Counters,
    ) -> Result<ObservedApproach, Stop> {
        let before = self.offset(&trajectory.state);
        let mut predicted = before.clone();
        let period = u64::from(self.orbit.period);
        let events = counters.events;
        let (mut same_events, mut certain) = (true, false);
        for passed in 1..=self.periods {
            if let Some(lasting) = &mut lasting {
                let away = self
                    .norm
                    .difference(&trajectory.state, &self.orbit.start.state);
                certain = lasting.is_certain(self.kernel, &away, workspace);
                if certain {
                    break;
                }
            }
            predicted = product(self.orbit.monodromy.as_ref(), predicted.as_ref());
            self.kernel
                .advance(period, trajectory, workspace, &mut (), counters)?;
            same_events = (counters.events - events).abs_diff(passed * self.orbit.events) <= 1;
            if !same_events {
                break;
            }
        }
        Ok(ObservedApproach {
            before,
            after: self.offset(&trajectory.state),
            predicted,
            same_events,
            certain,
        })
    }

    /// A proof that contact lasts until a trajectory reaches an orbit without events. `None` if the orbit has
    /// events, or if the proof takes more time than the observation.
    fn lasting_contact(
        &self,
        model: &'a Model,
        trajectory: &TrajectoryState,
    ) -> Option<LastingContact<'a>> {
        let orbit = self.orbit;
        let bounds = BOUND * (self.norm.dimension() as u64 + 1);
        let observed_returns = orbit.events == 0
            && trajectory.contact == orbit.start.contact
            && self.periods >= bounds;
        let at = (orbit.start.clone(), orbit.period);
        observed_returns
            .then(|| LastingContact::new(model, self.norm, &orbit.monodromy, at))
            .flatten()
    }

    /// Whether the observed approach agrees with the prediction of the linear map.
    fn is_linear(&self, observed: &ObservedApproach) -> bool {
        let [before, after, predicted] =
            [&observed.before, &observed.after, &observed.predicted].map(|offset| offset.norm_l2());
        if !observed.same_events {
            return false;
        }
        if before <= self.arrival_distance {
            return after <= self.arrival_distance;
        }
        // If `LONGEST_WATCH` has cut the observation short, the distance decreases only a little. On an elongated
        // curve around the orbit it also varies as the state circulates, by more than this decrease.
        let distance = if self.cut { before.min(predicted) } else { before };
        let missed = (&observed.after - &observed.predicted).norm_l2();
        missed <= PREDICTION_SLACK * self.decrease * distance && after < before
    }
}

/// Advances `trajectory` until the slowest multiplier of `orbit` has halved its distance, for at most 3000 cycles.
/// Returns whether it came as near as the monodromy matrix predicts, with the orbit's events. If so, the linear map
/// governs the approach, because the nonlinear terms shrink with the distance.
///
/// # Errors
/// [`Stop`] as in any integration.
pub fn approaches<K: Kernel>(
    kernel: &K,
    norm: &EnergyNorm,
    orbit: &PeriodicOrbit,
    trajectory: &mut TrajectoryState,
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) -> Result<bool, Stop> {
    let Some(watch) = ApproachSettings::new(kernel, norm, orbit) else {
        return Ok(false);
    };
    let observed = watch.follow(trajectory, None, workspace, counters)?;
    Ok(watch.is_linear(&observed))
}

/// Largest factor by which an observation leaves the components of an offset across the slowest direction, if the
/// approach counts as one along this direction.
const OTHERS_LEFT: f64 = 0.1;

/// Cosine of the angle between offset and prediction above which both count as parallel.
const ALIGNED: f64 = 0.9;

/// Smallest decrease of an approach along the slowest direction, relative to the prediction.
const LEAST_DECREASE: f64 = 0.1;

/// Largest number of states that are tried between a trajectory and an orbit. Each is at [`NEARER`] times the
/// distance of the previous one.
const MOST_BETWEEN: usize = 8;

/// Ratio of the distances of consecutive tried states.
const NEARER: f64 = 0.25;

/// How a trajectory approaches an orbit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Approach {
    /// As the monodromy matrix predicts.
    AsPredicted,
    /// Along the slowest direction. States in this direction that are nearer to the orbit move as predicted.
    AlongALine,
    /// In contact that is certain to last, so that the linear map is exact.
    InContact,
}

/// Time to bound the effect of one multiplier over a period, in integrations of a period.
const BOUND: u64 = 2;

/// Determines how `trajectory` approaches `orbit`, and advances it during the observation. `None` if no approach is
/// observed.
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn observe_approach<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    orbit: &PeriodicOrbit,
    trajectory: &mut TrajectoryState,
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) -> Result<Option<Approach>, Stop> {
    let Some(watch) = ApproachSettings::new(kernel, norm, orbit) else {
        return Ok(None);
    };
    let mut lasting = watch.lasting_contact(model, trajectory);
    let observed = watch.follow(trajectory, lasting.as_mut(), workspace, counters)?;
    if observed.certain {
        return Ok(Some(Approach::InContact));
    }
    if watch.is_linear(&observed) {
        return Ok(Some(Approach::AsPredicted));
    }
    if observed.same_events {
        comes_along_a_line(model, &watch, trajectory, workspace, counters)
    } else {
        Ok(None)
    }
}

/// How `trajectory` approaches `orbit` along its slowest direction from a distance at which the linear map does not
/// predict the rate; `None` if it does not approach. Near a bifurcation, the multiplier of that direction has a
/// modulus near 1, and quadratic and cubic terms outweigh its distance from 1.
///
/// All other directions have decayed, so states move on a line through the orbit. The trajectory and states ever
/// nearer to the orbit move towards it, and the last one moves as the linear map predicts. With two slow multipliers,
/// there may be a torus around the orbit, and the result is `None`.
fn comes_along_a_line<K: Kernel>(
    model: &Model,
    watch: &ApproachSettings<'_, K>,
    trajectory: &mut TrajectoryState,
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) -> Result<Option<Approach>, Stop> {
    let orbit = watch.orbit;
    let [slowest, others @ ..] = &orbit.multipliers[..] else {
        return Ok(None);
    };
    let periods = watch.periods as f64;
    let left = others.first().map_or(0.0, |next| next.norm().powf(periods));
    if !watch.cut || slowest.im != 0.0 || left > OTHERS_LEFT {
        return Ok(None);
    }
    let mut between = trajectory.clone();
    for attempt in 0..=MOST_BETWEEN {
        let observed = match attempt {
            0 => watch.follow(trajectory, None, workspace, counters)?,
            _ => watch.follow(&mut between, None, workspace, counters)?,
        };
        if watch.is_linear(&observed) {
            return Ok(Some(match attempt {
                0 => Approach::AsPredicted,
                _ => Approach::AlongALine,
            }));
        }
        let [before, after, predicted] =
            [&observed.before, &observed.after, &observed.predicted].map(|offset| offset.norm_l2());
        let along = product(observed.predicted.transpose(), observed.after.as_ref())[(0, 0)];
        let falls = after <= before * (1.0 - LEAST_DECREASE * watch.decrease);
        if !(observed.same_events && falls && along >= ALIGNED * after * predicted) {
            return Ok(None);
        }
        let mut state = orbit.start.state.clone();
        (watch.norm).displace(&mut state, NEARER, observed.after.col_as_slice(0));
        between = TrajectoryState::new(model, state, orbit.start.cycle);
    }
    Ok(None)
}

/// Smallest leading multiplier of an orbit whose period has just doubled. Below it, trajectories near the orbit leave
/// it within some hundred cycles.
const JUST_DOUBLED: f64 = -1.1;

/// Smallest and largest displacement, in half gaps, at which an orbit of twice the period is sought near its parent.
const DISPLACEMENTS: [f64; 2] = [1e-5, 0.3];

/// Largest distance of an orbit of twice the period from its parent, in displacements from which it was found. A more
/// distant orbit does not belong to the period doubling.
const FARTHEST_DOUBLED: f64 = 4.0;

/// The attracting orbit of twice the period near `parent`, if a period doubling alone has made `parent` unstable. If
/// the trajectory is nearer to the parent than halfway between both orbits, it is moved to halfway. It would reach
/// this distance anyway along the unstable direction, but slowly near the period doubling.
fn doubled<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    parent: &PeriodicOrbit,
    trajectory: &mut TrajectoryState,
    workspace: &mut K::Workspace,
) -> Option<PeriodicOrbit> {
    let [leading, others @ ..] = &parent.multipliers[..] else {
        return None;
    };
    let flips = leading.im == 0.0 && (JUST_DOUBLED..-1.0).contains(&leading.re);
    if !flips || others.iter().any(|other| other.norm() >= 1.0) {
        return None;
    }
    let [direction, _] = eigenpair(parent.monodromy.as_ref(), *leading)?.vector;
    // The side of the parent on which the trajectory is.
    let apart = norm.difference(&trajectory.state, &parent.start.state);
    let along: f64 = apart.iter().zip(&direction).map(|(a, d)| a * d).sum();
    let side = 1f64.copysign(along);
    let displaced = |by: f64| {
        let mut state = parent.start.state.clone();
        norm.displace(&mut state, side * by * norm.unit(), &direction);
        TrajectoryState::new(model, state, parent.start.cycle)
    };
    let [smallest, largest] = DISPLACEMENTS;
    let mut by = smallest;
    while by <= largest {
        let guess = displaced(by);
        let found = shoot(model, kernel, norm, &guess, 2 * parent.period, workspace);
        // An iterate that diverges or has too many events is no orbit.
        if let Ok(Some(orbit)) = found
            && orbit.attracts()
        {
            let apart = norm.distance(&orbit.start.state, &parent.start.state) / norm.unit();
            if apart > SAME_POINT && apart <= FARTHEST_DOUBLED * by {
                let away = norm.distance(&trajectory.state, &parent.start.state) / norm.unit();
                if away < 0.5 * apart {
                    let ends = parent.start.state.iter().zip(&orbit.start.state);
                    let halfway = ends.map(|(a, b)| 0.5 * (a + b)).collect();
                    *trajectory = TrajectoryState::new(model, halfway, trajectory.cycle);
                }
                return Some(orbit);
            }
        }
        by *= 2.0;
    }
    None
}

/// An attracting orbit, and how a trajectory approaches it.
#[derive(Debug)]
pub struct Attracting {
    /// The orbit with its shortest period.
    pub orbit: PeriodicOrbit,
    /// Whether the orbit has twice the period of an unstable orbit near it.
    pub doubled: bool,
    /// How the trajectory approaches it.
    pub approach: Approach,
}

/// Seeks an orbit of `period` mesh cycles near `trajectory` that attracts it. If that orbit has become unstable by a
/// period doubling, seeks the orbit of twice the period near it. Advances `trajectory` during the observation. The
/// shortest period is a multiple of `unit` cycles.
///
/// # Errors
/// [`Stop`] if the trajectory itself diverges or has too many events.
pub fn attracting<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    trajectory: &mut TrajectoryState,
    [period, unit]: [u32; 2],
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) -> Result<Option<Attracting>, Stop> {
    // An iterate that diverges or has too many events is no orbit; the trajectory may still be fine.
    let found = shoot(model, kernel, norm, trajectory, period, workspace);
    let Ok(Some(orbit)) = found else {
        return Ok(None);
    };
    let doubles = !orbit.attracts();
    let orbit = if doubles {
        match doubled(model, kernel, norm, &orbit, trajectory, workspace) {
            Some(orbit) => orbit,
            None => return Ok(None),
        }
    } else {
        shortest(model, kernel, norm, orbit, unit, workspace)?
    };
    let observed = observe_approach(model, kernel, norm, &orbit, trajectory, workspace, counters)?;
    Ok(observed.map(|approach| Attracting {
        orbit,
        doubled: doubles,
        approach,
    }))
}

#[cfg(test)]
mod tests;
