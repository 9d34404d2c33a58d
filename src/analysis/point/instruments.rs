//! What is measured beside a trajectory.

use crate::analysis::known::{Loosest, Size, loosest};
use crate::analysis::lyapunov::{GrowthAverages, TangentGrowth};
use crate::analysis::norm::EnergyNorm;
use crate::analysis::nvh::Nvh;
use crate::analysis::orders::Orders;
use crate::analysis::outcome::NvhOutcome;
use crate::analysis::outputs::Outputs;
use crate::analysis::poincare::{Poincare, Section};
use crate::analysis::questions::Questions;
use crate::analysis::recurrence::Recurrence;
use crate::analysis::spectrum::{Spectra, Welch};
use crate::analysis::twin::Twin;
use crate::model::{Model, Quantity, TrajectoryState};
use crate::numerics::statistics::FEWEST_BLOCKS;
use crate::propagate::{Counters, Event, Observer, Window};

/// Fewest mesh cycles of NVH statistics whose errors are believed by a stop rule: as many stretches of ten as of
/// averages of an exponent.
const FEWEST_CYCLES: u64 = 10 * 4 * FEWEST_BLOCKS as u64;

/// Looks follow each other after this part of what was measured, so that all of them cost little.
const SPARSE: u64 = 4;

/// When NVH statistics are known well enough.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    /// Relative standard error asked for.
    target: f64,
    /// Measured cycles at the next look.
    next: u64,
}

impl Goal {
    fn new(target: f64) -> Self {
        Self {
            target,
            next: FEWEST_CYCLES,
        }
    }
}

/// What is measured beside the trajectory.
pub(super) struct Instruments {
    pub(super) growth: Option<TangentGrowth>,
    pub(super) twin: Option<Twin>,
    pub(super) watch: Watch,
    pub(super) recurrence: Recurrence,
    pub(super) measured: u64,
    pub(super) events_before: u64,
    /// None where NVH statistics have no stop rule.
    pub(super) goal: Option<Goal>,
}

/// The observers of measured cycles.
pub(super) struct Watch {
    pub(super) nvh: Option<Nvh>,
    pub(super) spectra: Option<Spectra>,
    pub(super) poincare: Poincare,
    pub(super) outputs: Option<Outputs>,
    pub(super) orders: Option<Orders>,
    /// Whether NVH statistics are known well enough, and nothing is added to them any more.
    enough: bool,
}

impl Watch {
    /// Nothing is watched.
    pub(super) fn of_nothing(model: &Model) -> Self {
        Self {
            nvh: None,
            spectra: None,
            poincare: Poincare::new(model, Section::default(), 0),
            outputs: None,
            orders: None,
            enough: false,
        }
    }

    /// Whether windows and events are of use.
    pub(super) fn watches(&self) -> bool {
        (self.nvh.is_some() && !self.enough) || self.poincare.watches()
    }

    /// The statistics of what was watched.
    pub(super) fn statistics(&self) -> Option<NvhOutcome> {
        let mut found = self.nvh.as_ref()?.outcome()?;
        if let Some(outputs) = &self.outputs {
            let [bearings, bearing_errors] = outputs.statistics(Quantity::BearingForce);
            let [torques, torque_errors] = outputs.statistics(Quantity::Torque);
            let [places, place_errors] = outputs.statistics(Quantity::Acceleration);
            let [bodies, body_errors] = outputs.statistics(Quantity::AngularAcceleration);
            found.bearing_mean = bearings.mean;
            found.bearing_rms = bearings.rms;
            found.torque_mean = torques.mean;
            found.torque_rms = torques.rms;
            found.acceleration_rms = places.rms;
            found.angular_acceleration_rms = bodies.rms;
            if let Some(stderr) = &mut found.stderr {
                stderr.bearing_mean = bearing_errors.mean;
                stderr.bearing_rms = bearing_errors.rms;
                stderr.torque_mean = torque_errors.mean;
                stderr.torque_rms = torque_errors.rms;
                stderr.acceleration_rms = place_errors.rms;
                stderr.angular_acceleration_rms = body_errors.rms;
            }
        }
        Some(found)
    }

    /// The statistic that is known least well; none before any.
    fn loosest(&self) -> Option<Loosest> {
        let found = self.statistics()?;
        if self.spectra.as_ref().is_some_and(|all| !all.begun()) {
            return Some(Loosest {
                name: "a spectrum".to_owned(),
                error: f64::INFINITY,
            });
        }
        let spectra = self.spectra.as_ref().map(Spectra::spectra);
        let orders = self.orders.as_ref().map(Orders::outcome);
        let sizes: Vec<(&str, Size)> = self.outputs.as_ref().map_or(Vec::new(), Outputs::sizes);
        Some(loosest(
            &found,
            &spectra.unwrap_or_default(),
            &orders.unwrap_or_default(),
            &sizes,
        ))
    }
}

impl Observer for Watch {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        self.poincare.window(window);
        if self.enough {
            return;
        }
        if let Some(nvh) = &mut self.nvh {
            nvh.window(window);
        }
        if let Some(outputs) = &mut self.outputs {
            outputs.window(window);
        }
        let outputs = self.outputs.as_ref().map_or(&[][..], Outputs::series);
        if let Some(spectra) = &mut self.spectra {
            spectra.window(window, outputs);
        }
        if let Some(orders) = &mut self.orders {
            orders.window(window, outputs);
        }
    }

    fn event(&mut self, event: &Event) {
        self.poincare.event(event);
        if let Some(nvh) = self.nvh.as_mut().filter(|_| !self.enough) {
            nvh.event(event);
        }
    }
}

impl Instruments {
    /// Instruments for the questions asked, at the trajectory's present place.
    pub(super) fn new(
        model: &Model,
        norm: &EnergyNorm,
        questions: &Questions,
        trajectory: &TrajectoryState,
    ) -> Self {
        let q = questions;
        let growth = q.lyapunov.map(|l| {
            let count = l.exponents.min(norm.dimension());
            let mut stream = q.point.stream(0);
            TangentGrowth::new(norm, model.modes(), count, &mut stream)
        });
        let wanted = q.lyapunov.filter(|l| l.twin);
        let twin = (growth.as_ref().zip(wanted)).map(|(growth, asked)| {
            Twin::new(model, norm, trajectory, growth.leading(), asked.separation)
        });
        Self {
            growth,
            twin,
            watch: Watch {
                nvh: q.nvh.map(|n| Nvh::new(model, n.harmonics)),
                spectra: q.nvh.and_then(|all| {
                    let welch = Welch::new(model, &all.spectrum?, all.computed());
                    Some(Spectra::Welch(welch))
                }),
                outputs: q.nvh.and_then(|all| Outputs::new(model, all.computed())),
                orders: (q.nvh).and_then(|all| Some(Orders::new(model, &all.orders?, &all))),
                poincare: Poincare::new(model, q.section.clone(), q.poincare_samples),
                enough: false,
            },
            recurrence: Recurrence::new(model),
            measured: 0,
            events_before: 0,
            goal: q.nvh.and_then(|all| all.stop_at_stderr).map(Goal::new),
        }
    }

    /// Forgets what was measured, keeps directions.
    pub(super) fn restart(&mut self, counters: &Counters) {
        if let Some(growth) = &mut self.growth {
            growth.restart();
        }
        if let Some(twin) = &mut self.twin {
            twin.restart();
        }
        if let Some(nvh) = &mut self.watch.nvh {
            nvh.restart();
        }
        if let Some(spectra) = &mut self.watch.spectra {
            spectra.restart();
        }
        self.watch.poincare.restart();
        if let Some(outputs) = &mut self.watch.outputs {
            outputs.restart();
        }
        if let Some(orders) = &mut self.watch.orders {
            orders.restart();
        }
        self.watch.enough = false;
        if let Some(goal) = &mut self.goal {
            *goal = Goal::new(goal.target);
        }
        self.measured = 0;
        self.events_before = counters.events;
    }

    /// Looks, where a look is due, whether NVH statistics are known well enough; gathers no more of them from
    /// then on.
    pub(super) fn look(&mut self) {
        let Some(goal) = &mut self.goal else { return };
        if self.watch.enough || self.measured < goal.next {
            return;
        }
        goal.next = self.measured + self.measured / SPARSE;
        self.watch.enough =
            (self.watch.loosest()).is_some_and(|loosest| loosest.error <= goal.target);
    }

    /// What NVH statistics lack of the error asked for, at the end of a record.
    pub(super) fn missed(&self) -> Option<(f64, Loosest)> {
        let goal = self.goal.filter(|_| !self.watch.enough)?;
        let loosest = self.watch.loosest()?;
        (loosest.error > goal.target).then_some((goal.target, loosest))
    }

    /// Whether NVH statistics are known well enough; none where they have no stop rule.
    pub(super) fn enough(&self) -> Option<bool> {
        self.goal.map(|_| self.watch.enough)
    }

    /// Averages of the largest exponent; none where none was asked for.
    pub(super) fn averages(&self) -> Option<&GrowthAverages> {
        self.growth.as_ref().map(TangentGrowth::averages)
    }
}
