//! The observers of a trajectory's windows and events.

use crate::analysis::config::PointConfig;
use crate::analysis::nvh::Nvh;
use crate::analysis::orders::Orders;
use crate::analysis::outcome::{NvhOutcome, NvhStatistics};
use crate::analysis::outputs::{OutputStatistics, Outputs};
use crate::analysis::poincare::{Poincare, Section};
use crate::analysis::power::Power;
use crate::analysis::precision::{LeastPrecise, SignalSize, loosest};
use crate::analysis::spectrum::{Spectra, Welch};
use crate::model::{Model, Quantity, TrajectoryState};
use crate::propagate::{Event, Observer, Window};

/// The observers of measured cycles.
#[derive(Clone)]
pub(super) struct Recorders {
    pub(super) nvh: Option<Nvh>,
    pub(super) spectra: Option<Spectra>,
    pub(super) poincare: Poincare,
    pub(super) outputs: Option<Outputs>,
    pub(super) power: Option<Power>,
    pub(super) orders: Option<Orders>,
    /// Whether NVH statistics are precise enough. Nothing more is then added to them.
    pub(super) enough: bool,
}

impl Recorders {
    /// The observers for the requested analyses.
    pub(super) fn requested(model: &Model, config: &PointConfig) -> Self {
        let wanted = config.nvh;
        Self {
            nvh: wanted.map(|n| Nvh::new(model, n.harmonics)),
            spectra: wanted.and_then(|all| {
                let welch = Welch::new(model, &all.spectrum?, all.computed());
                Some(Spectra::Welch(welch))
            }),
            outputs: wanted.and_then(|all| Outputs::new(model, all.computed())),
            power: wanted.filter(|all| all.power).map(|_| Power::new(model)),
            orders: wanted.and_then(|all| Some(Orders::new(model, &all.orders?, &all))),
            poincare: Poincare::new(model, config.section.clone(), config.poincare_samples),
            enough: false,
        }
    }

    /// The observers of a trajectory that branched off another one, whose statistics, if any, are `nvh`. It has no
    /// Poincaré samples.
    pub(super) fn for_branch(model: &Model, config: &PointConfig, nvh: Option<&Nvh>) -> Self {
        Self {
            nvh: nvh.map(Nvh::for_same_model),
            poincare: Poincare::new(model, Section::default(), 0),
            ..Self::requested(model, config)
        }
    }

    /// Forgets all observations.
    pub(super) fn restart(&mut self) {
        self.nvh.iter_mut().for_each(Nvh::restart);
        self.spectra.iter_mut().for_each(Spectra::restart);
        self.poincare.restart();
        self.outputs.iter_mut().for_each(Outputs::restart);
        self.power.iter_mut().for_each(Power::restart);
        self.orders.iter_mut().for_each(Orders::restart);
        self.enough = false;
    }

    /// Appends the observations of another trajectory; Poincaré samples remain those of the first.
    pub(super) fn append(&mut self, other: &Self) {
        fn both<R>(record: &mut Option<R>, behind: &Option<R>, append: fn(&mut R, &R)) {
            if let (Some(record), Some(behind)) = (record, behind) {
                append(record, behind);
            }
        }
        both(&mut self.nvh, &other.nvh, Nvh::append);
        both(&mut self.spectra, &other.spectra, Spectra::append);
        both(&mut self.outputs, &other.outputs, Outputs::append);
        both(&mut self.power, &other.power, Power::append);
        both(&mut self.orders, &other.orders, Orders::append);
    }

    /// Whether windows and events are needed.
    pub(super) fn needs_windows(&self) -> bool {
        (self.nvh.is_some() && !self.enough) || self.poincare.needs_windows()
    }

    /// The statistics of the observations.
    pub(super) fn statistics(&self) -> Option<NvhOutcome> {
        let mut nvh = self.nvh.as_ref()?.outcome()?;
        if let Some(outputs) = &self.outputs {
            let mut take = |quantity, into: fn(&mut NvhStatistics, OutputStatistics)| {
                let [values, errors] = outputs.statistics(quantity);
                into(&mut nvh.values, values);
                if let Some(stderr) = &mut nvh.stderr {
                    into(stderr, errors);
                }
            };
            take(Quantity::BearingForce, |all, of| {
                (all.bearing_mean, all.bearing_rms) = (of.mean, of.rms);
            });
            take(Quantity::Torque, |all, of| {
                (all.torque_mean, all.torque_rms) = (of.mean, of.rms);
            });
            take(Quantity::Acceleration, |all, of| {
                all.acceleration_rms = of.rms
            });
            take(Quantity::AngularAcceleration, |all, of| {
                all.angular_acceleration_rms = of.rms
            });
            take(Quantity::MeshDeflection, |all, of| {
                all.mesh_deflection_rms = of.rms
            });
            take(Quantity::MeshForce, |all, of| all.mesh_force_rms = of.rms);
        }
        if let Some([power, errors]) = self.power.as_ref().and_then(Power::outcome) {
            nvh.values.power = Some(power);
            if let Some(stderr) = &mut nvh.stderr {
                stderr.power = Some(errors);
            }
        }
        Some(nvh)
    }

    /// Ends a measured cycle, with the trajectory at its end.
    pub(super) fn cycle(&mut self, model: &Model, end: &TrajectoryState) {
        self.poincare.push(model, end);
        if let Some(nvh) = &mut self.nvh {
            nvh.finish();
        }
        if let Some(power) = self.power.as_mut().filter(|_| !self.enough) {
            power.cycle(end);
        }
    }

    /// The least precise statistic; `None` before there is one.
    pub(super) fn loosest(&self) -> Option<LeastPrecise> {
        let nvh = self.statistics()?;
        if self.spectra.as_ref().is_some_and(|all| !all.has_segments()) {
            return Some(LeastPrecise {
                name: "a spectrum".to_owned(),
                error: f64::INFINITY,
            });
        }
        let spectra = self.spectra.as_ref().map(Spectra::spectra);
        let orders = self.orders.as_ref().map(Orders::outcome);
        let sizes: Vec<(&str, SignalSize)> =
            self.outputs.as_ref().map_or(Vec::new(), Outputs::sizes);
        Some(loosest(
            &nvh,
            &spectra.unwrap_or_default(),
            &orders.unwrap_or_default(),
            &sizes,
        ))
    }
}

impl Observer for Recorders {
    const WINDOWS: bool = true;

    fn states(&self) -> bool {
        let rebuilt = self.outputs.is_some() || self.power.is_some();
        (rebuilt && !self.enough) || self.poincare.needs_windows()
    }

    fn window(&mut self, window: &Window<'_>) {
        self.poincare.window(window);
        if self.enough {
            return;
        }
        (self.nvh.iter_mut()).for_each(|recorder| recorder.window(window));
        (self.outputs.iter_mut()).for_each(|recorder| recorder.window(window));
        (self.power.iter_mut()).for_each(|recorder| recorder.window(window));
        let outputs = self.outputs.as_ref().map_or(&[][..], Outputs::series);
        (self.spectra.iter_mut()).for_each(|recorder| recorder.window(window, outputs));
        (self.orders.iter_mut()).for_each(|recorder| recorder.window(window, outputs));
    }

    fn event(&mut self, event: &Event) {
        self.poincare.event(event);
        if self.enough {
            return;
        }
        (self.nvh.iter_mut()).for_each(|recorder| recorder.event(event));
        (self.power.iter_mut()).for_each(|recorder| recorder.event(event));
    }
}
