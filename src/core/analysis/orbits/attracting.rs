//! The orbit that a trajectory comes to, and how it is seen to.
//!
//! Newton's method finds an orbit next to a trajectory whether or not that ends there. The trajectory is
//! watched while the slowest multiplier halves its distance: where it comes as near as the map of a period
//! predicts, the orbit attracts it. Where neither the orbit nor the way to it has an event, the map alone may
//! prove it, without watching.

use super::shooting::{PeriodicOrbit, SAME_POINT, shoot, shortest};
use crate::analysis::lasting_contact::LastingContact;
use crate::analysis::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::linalg::{eigenpair, product};
use crate::propagate::{Counters, Kernel, Stop};
use faer::Mat;

/// Longest integration, in mesh cycles, spent on watching a trajectory approach an orbit at once.
const LONGEST_WATCH: f64 = 3000.0;

/// Distance, in half gaps, at which a trajectory is on the orbit, if the orbit is known as well.
const ARRIVED: f64 = 1e-9;

/// Largest distance, in half gaps, up to which an orbit that is known no better counts as reached.
const FARTHEST_ARRIVED: f64 = 1e-5;

/// Part of the decrease of the distance by which the approach may miss its prediction.
const PREDICTION_SLACK: f64 = 0.2;

/// An approach over some periods of an orbit.
struct Watched {
    /// Offsets from the orbit in energy coordinates.
    before: Mat<f64>,
    after: Mat<f64>,
    /// What the monodromy matrix makes of the first.
    predicted: Mat<f64>,
    /// Whether the events were those of the orbit.
    same_events: bool,
    /// Whether contact is certain to last until the orbit is reached.
    certain: bool,
}

/// How the approach to an orbit is watched.
struct Watch<'a, K: Kernel> {
    kernel: &'a K,
    norm: &'a EnergyNorm,
    orbit: &'a PeriodicOrbit,
    /// Periods watched: as many as the slowest multiplier takes to halve the distance, or what
    /// [`LONGEST_WATCH`] allows.
    periods: u64,
    /// Whether they are fewer than that.
    cut: bool,
    /// Part of a distance by which it decreases meanwhile, one half at most.
    decrease: f64,
    /// Distance at which a trajectory is on the orbit. A residual r leaves the orbit's place open by
    /// r / (1 - μ) along the direction of the slowest multiplier μ.
    arrived: f64,
}

impl<'a, K: Kernel> Watch<'a, K> {
    /// None where the orbit does not attract.
    fn new(kernel: &'a K, norm: &'a EnergyNorm, orbit: &'a PeriodicOrbit) -> Option<Self> {
        let radius = orbit.spectral_radius();
        if radius.is_nan() || radius >= 1.0 {
            return None;
        }
        let halving = (0.5f64.ln() / radius.ln()).ceil().max(1.0);
        let most = (LONGEST_WATCH / f64::from(orbit.period)).floor().max(1.0);
        let periods = halving.min(most);
        Some(Self {
            kernel,
            norm,
            orbit,
            periods: periods as u64,
            cut: most < halving,
            // Of a radius next to 1, without cancellation.
            decrease: (-(periods * radius.ln()).exp_m1()).min(0.5),
            arrived: norm.unit()
                * (2.0 * orbit.residual / (1.0 - radius)).clamp(ARRIVED, FARTHEST_ARRIVED),
        })
    }

    fn offset(&self, state: &[f64]) -> Mat<f64> {
        let apart = self.norm.difference(state, &self.orbit.start.state);
        Mat::from_fn(apart.len(), 1, |row, _| apart[row])
    }

    /// Advances `trajectory`, which starts a period. An integration ends early where its events are
    /// not those of the orbit (an event too many or too few may have slipped past the start of a cycle), or where
    /// contact is certain to last.
    fn follow(
        &self,
        trajectory: &mut TrajectoryState,
        mut lasting: Option<&mut LastingContact<'_>>,
        workspace: &mut K::Workspace,
        counters: &mut Counters,
    ) -> Result<Watched, Stop> {
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
        Ok(Watched {
            before,
            after: self.offset(&trajectory.state),
            predicted,
            same_events,
            certain,
        })
    }

    /// What may prove that contact lasts on the way of a trajectory to an orbit without events, where that takes less time
    /// than watching.
    fn lasting_contact(
        &self,
        model: &'a Model,
        trajectory: &TrajectoryState,
    ) -> Option<LastingContact<'a>> {
        let orbit = self.orbit;
        let bounds = BOUND * (self.norm.dimension() as u64 + 1);
        let asked = orbit.events == 0
            && trajectory.contact == orbit.start.contact
            && self.periods >= bounds;
        let at = (orbit.start.clone(), orbit.period);
        asked
            .then(|| LastingContact::new(model, self.norm, &orbit.monodromy, at))
            .flatten()
    }

    /// Whether the linear map governs an approach.
    fn is_linear(&self, seen: &Watched) -> bool {
        let [before, after, predicted] =
            [&seen.before, &seen.after, &seen.predicted].map(|offset| offset.norm_l2());
        if !seen.same_events {
            return false;
        }
        if before <= self.arrived {
            return after <= self.arrived;
        }
        // Over a watch that was cut short, distances across and along a flat torus may differ by more
        // than they decrease.
        let distance = if self.cut { before.min(predicted) } else { before };
        let missed = (&seen.after - &seen.predicted).norm_l2();
        missed <= PREDICTION_SLACK * self.decrease * distance && after < before
    }
}

/// Advances `trajectory` until the slowest multiplier of `orbit` has halved its distance, but for
/// 3000 cycles at most, and tells whether it came as near as the monodromy matrix predicts, with
/// the orbit's events. If so, the linear map governs the approach; remainders shrink with distance.
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn approaches<K: Kernel>(
    kernel: &K,
    norm: &EnergyNorm,
    orbit: &PeriodicOrbit,
    trajectory: &mut TrajectoryState,
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) -> Result<bool, Stop> {
    let Some(watch) = Watch::new(kernel, norm, orbit) else {
        return Ok(false);
    };
    let seen = watch.follow(trajectory, None, workspace, counters)?;
    Ok(watch.is_linear(&seen))
}

/// Part of an offset that may be left, after a watch, of all but its slowest direction.
const OTHERS_LEFT: f64 = 0.1;

/// Cosine of the angle between offset and prediction from which both point along one direction.
const ALIGNED: f64 = 0.9;

/// Part of the predicted decrease that an approach along the slowest direction makes at least.
const FALLS: f64 = 0.1;

/// Most states tried between a trajectory and an orbit, each at a [`NEARER`]th of the distance of the
/// one before it.
const MOST_BETWEEN: usize = 8;

/// Ratio of the distances of states that are tried one after the other.
const NEARER: f64 = 0.25;

/// How a trajectory comes to an orbit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Approach {
    /// As the monodromy matrix predicts.
    AsPredicted,
    /// Along the slowest direction, on which states nearer to the orbit move as predicted.
    AlongALine,
    /// In contact that is certain to last, so that the map of a period holds all the way.
    InContact,
}

/// Periods whose integration takes as long as bounding what is felt of one multiplier over a period.
const BOUND: u64 = 2;

/// Tells how `trajectory` comes to `orbit`, and advances it while it is watched; none where it is not
/// seen to.
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn comes<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    orbit: &PeriodicOrbit,
    trajectory: &mut TrajectoryState,
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) -> Result<Option<Approach>, Stop> {
    let Some(watch) = Watch::new(kernel, norm, orbit) else {
        return Ok(None);
    };
    let mut lasting = watch.lasting_contact(model, trajectory);
    let seen = watch.follow(trajectory, lasting.as_mut(), workspace, counters)?;
    if seen.certain {
        return Ok(Some(Approach::InContact));
    }
    if watch.is_linear(&seen) {
        return Ok(Some(Approach::AsPredicted));
    }
    if seen.same_events {
        comes_along_a_line(model, &watch, trajectory, workspace, counters)
    } else {
        Ok(None)
    }
}

/// Whether `trajectory` comes to `orbit` along its slowest direction, though it is so far away that the
/// linear map does not say how fast: next to a bifurcation the multiplier of that direction is almost
/// 1 in modulus, and terms of the distance's square and cube outweigh what is missing.
///
/// All other directions have decayed, so that states move on a line through the orbit. The
/// trajectory moves towards the orbit, so do states ever nearer to it, and the last as the linear map
/// predicts. Where two multipliers are slow, a torus may lie around the orbit: nothing is said then.
fn comes_along_a_line<K: Kernel>(
    model: &Model,
    watch: &Watch<'_, K>,
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
    let (weights, felt) = (watch.norm.weights(), watch.norm.felt());
    let mut between = trajectory.clone();
    for tried in 0..=MOST_BETWEEN {
        let seen = match tried {
            0 => watch.follow(trajectory, None, workspace, counters)?,
            _ => watch.follow(&mut between, None, workspace, counters)?,
        };
        if watch.is_linear(&seen) {
            return Ok(Some(match tried {
                0 => Approach::AsPredicted,
                _ => Approach::AlongALine,
            }));
        }
        let [before, after, predicted] =
            [&seen.before, &seen.after, &seen.predicted].map(|offset| offset.norm_l2());
        let along = product(seen.predicted.transpose(), seen.after.as_ref())[(0, 0)];
        let falls = after <= before * (1.0 - FALLS * watch.decrease);
        if !(seen.same_events && falls && along >= ALIGNED * after * predicted) {
            return Ok(None);
        }
        let mut state = orbit.start.state.clone();
        for (row, &i) in felt.iter().enumerate() {
            state[i] += NEARER * seen.after[(row, 0)] / weights[i];
        }
        between = TrajectoryState::new(model, state, orbit.start.cycle);
    }
    Ok(None)
}

/// Leading multiplier of an orbit whose period has doubled just now: what is near a farther one has left
/// it after some hundred cycles.
const JUST_DOUBLED: f64 = -1.1;

/// Displacements, in half gaps, from which an orbit of twice the period is sought beside its parent.
const DISPLACEMENTS: [f64; 2] = [1e-5, 0.3];

/// Largest ratio of the distance of that orbit to the displacement from which it was found: one farther away
/// is another orbit.
const BESIDE: f64 = 4.0;

/// The attracting orbit of twice the period that a period doubling has left beside `parent`, where
/// that is unstable by it alone. A trajectory nearer to the parent than to halfway between both is put
/// halfway: it leaves the parent along the direction in which that is unstable, either way, but the more
/// slowly the nearer the doubling is.
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
    // The side of the parent on which the trajectory lies.
    let apart = norm.difference(&trajectory.state, &parent.start.state);
    let along: f64 = apart.iter().zip(&direction).map(|(a, d)| a * d).sum();
    let side = 1f64.copysign(along);
    let (weights, felt) = (norm.weights(), norm.felt());
    let displaced = |by: f64| {
        let mut state = parent.start.state.clone();
        for (&i, d) in felt.iter().zip(&direction) {
            state[i] += side * by * norm.unit() * d / weights[i];
        }
        TrajectoryState::new(model, state, parent.start.cycle)
    };
    let [smallest, largest] = DISPLACEMENTS;
    let mut by = smallest;
    while by <= largest {
        let guess = displaced(by);
        let found = shoot(model, kernel, norm, &guess, 2 * parent.period, workspace);
        // An iterate that diverges or storms is no orbit.
        if let Ok(Some(orbit)) = found
            && orbit.spectral_radius() < 1.0
        {
            let apart = norm.distance(&orbit.start.state, &parent.start.state) / norm.unit();
            if apart > SAME_POINT && apart <= BESIDE * by {
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

/// An attracting orbit, and how a trajectory was seen to come to it.
#[derive(Debug)]
pub struct Attracting {
    /// The orbit with its shortest period.
    pub orbit: PeriodicOrbit,
    /// Whether it is the orbit of twice the period beside an unstable one.
    pub doubled: bool,
    /// How the trajectory comes to it.
    pub approach: Approach,
}

/// Seeks an orbit of `period` mesh cycles next to `trajectory` which attracts it, or, where that orbit has
/// become unstable by a period doubling, the orbit of twice the period beside it. Advances `trajectory`
/// while it is watched; its own period is a multiple of `unit` cycles.
///
/// # Errors
/// [`Stop`] where the trajectory itself diverges or storms.
pub fn attracting<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    trajectory: &mut TrajectoryState,
    [period, unit]: [u32; 2],
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) -> Result<Option<Attracting>, Stop> {
    // An iterate that diverges or storms is no orbit, and no fault of the trajectory.
    let found = shoot(model, kernel, norm, trajectory, period, workspace);
    let Ok(Some(orbit)) = found else {
        return Ok(None);
    };
    let doubles = orbit.spectral_radius() >= 1.0;
    let orbit = if doubles {
        match doubled(model, kernel, norm, &orbit, trajectory, workspace) {
            Some(orbit) => orbit,
            None => return Ok(None),
        }
    } else {
        shortest(model, kernel, norm, orbit, unit, workspace)?
    };
    let seen = comes(model, kernel, norm, &orbit, trajectory, workspace, counters)?;
    Ok(seen.map(|approach| Attracting {
        orbit,
        doubled: doubles,
        approach,
    }))
}

#[cfg(test)]
mod tests;
