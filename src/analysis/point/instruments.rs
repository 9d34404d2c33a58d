//! What is measured beside a trajectory.

use crate::analysis::lyapunov::TangentGrowth;
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
use crate::propagate::{Counters, Event, Observer, Window};

/// What is measured beside the trajectory.
pub(super) struct Instruments {
    pub(super) growth: Option<TangentGrowth>,
    pub(super) twin: Option<Twin>,
    pub(super) watch: Watch,
    pub(super) recurrence: Recurrence,
    pub(super) measured: u64,
    pub(super) events_before: u64,
}

/// The observers of measured cycles.
pub(super) struct Watch {
    pub(super) nvh: Option<Nvh>,
    pub(super) spectra: Option<Spectra>,
    pub(super) poincare: Poincare,
    pub(super) outputs: Option<Outputs>,
    pub(super) orders: Option<Orders>,
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
        }
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
}

impl Observer for Watch {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
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
        self.poincare.window(window);
    }

    fn event(&mut self, event: &Event) {
        if let Some(nvh) = &mut self.nvh {
            nvh.event(event);
        }
        self.poincare.event(event);
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
            },
            recurrence: Recurrence::new(model),
            measured: 0,
            events_before: 0,
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
        self.measured = 0;
        self.events_before = counters.events;
    }

    /// Averages of the largest exponent, empty where none was asked for.
    pub(super) fn averages(&self) -> &[f64] {
        self.growth.as_ref().map_or(&[], |g| g.averages())
    }
}
