//! The measurements along a trajectory.

use super::recorders::Recorders;
use crate::analysis::averages::CycleAverages;
use crate::analysis::config::PointConfig;
use crate::analysis::lyapunov::TangentGrowth;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::recurrence::Recurrence;
use crate::analysis::twin::Twin;
use crate::model::{Model, TrajectoryState};

/// Maximum number of cycles per trajectory with stored growth and strobe deflection.
const MOST_CYCLES: usize = 1 << 16;

/// Measurements of one trajectory, or of several, one after another.
#[derive(Clone)]
pub(super) struct Record {
    pub(super) growth: Option<TangentGrowth>,
    pub(super) twin: Option<Twin>,
    pub(super) watch: Recorders,
    /// Averages of the squared strobe deflection \[m²\], a statistic that is available at every point.
    pub(super) strobe: CycleAverages,
    /// Measured cycles.
    pub(super) measured: u64,
    /// Events in the measured cycles.
    pub(super) events: u64,
}

impl Record {
    /// Averages of the growth of the largest exponent; `None` if no exponent is requested.
    pub(super) fn averages(&self) -> Option<&CycleAverages> {
        self.growth.as_ref().map(TangentGrowth::averages)
    }

    /// Keeps only the first `cycles`, which contain `events` events. Spectra keep the later cycles too, because
    /// their segments are not stored.
    pub(super) fn cut(&mut self, cycles: u64, events: u64) {
        if let Some(growth) = &mut self.growth {
            growth.cut(cycles);
        }
        if let Some(nvh) = &mut self.watch.nvh {
            nvh.cut(cycles);
        }
        if let Some(power) = &mut self.watch.power {
            power.cut(cycles);
        }
        if let Some(outputs) = &mut self.watch.outputs {
            outputs.cut(cycles);
        }
        if let Some(orders) = &mut self.watch.orders {
            orders.cut(cycles);
        }
        self.strobe.cut(cycles);
        self.measured = cycles;
        self.events = events;
    }

    /// Appends the record of another trajectory; the twin remains that of the first.
    pub(super) fn append(&mut self, other: &Self) {
        if let (Some(growth), Some(behind)) = (&mut self.growth, &other.growth) {
            growth.append(behind);
        }
        self.watch.append(&other.watch);
        self.strobe.append(&other.strobe);
        self.measured += other.measured;
        self.events += other.events;
    }
}

/// Growth and strobe deflection of every cycle, for at most [`MOST_CYCLES`] cycles.
#[derive(Debug, Clone, Default)]
pub(super) struct Series {
    pub(super) growth: Vec<f64>,
    pub(super) strobe: Vec<f64>,
}

impl Series {
    /// Adds a cycle.
    pub(super) fn push(&mut self, growth: f64, strobe: f64) {
        if self.growth.len() < MOST_CYCLES {
            self.growth.push(growth);
            self.strobe.push(strobe);
        }
    }

    /// Whether the series contains every measured cycle.
    pub(super) fn is_whole(&self, measured: u64) -> bool {
        self.growth.len() as u64 == measured
    }
}

/// All measurements of one trajectory, and the states by which a period is detected.
pub(super) struct Instruments {
    pub(super) record: Record,
    pub(super) recurrence: Recurrence,
    pub(super) series: Series,
}

impl Instruments {
    /// Instruments for the requested analyses, at the trajectory's present state.
    pub(super) fn new(
        model: &Model,
        norm: &EnergyNorm,
        config: &PointConfig,
        trajectory: &TrajectoryState,
    ) -> Self {
        let growth = config.lyapunov.map(|l| {
            let count = l.exponents.min(norm.dimension());
            let mut stream = config.point.stream(0);
            TangentGrowth::new(norm, model.modes(), count, &mut stream)
        });
        let wanted = config.lyapunov.filter(|l| l.twin);
        let twin = (growth.as_ref().zip(wanted)).map(|(growth, config)| {
            Twin::new(model, norm, trajectory, growth.leading(), config.separation)
        });
        Self::of(model, growth, twin, Recorders::requested(model, config))
    }

    /// Instruments of a trajectory that branched off another, with the tangents from there.
    pub(super) fn of(
        model: &Model,
        growth: Option<TangentGrowth>,
        twin: Option<Twin>,
        watch: Recorders,
    ) -> Self {
        Self {
            record: Record {
                growth,
                twin,
                watch,
                strobe: CycleAverages::default(),
                measured: 0,
                events: 0,
            },
            recurrence: Recurrence::new(model),
            series: Series::default(),
        }
    }

    /// Forgets all measurements and keeps the directions.
    pub(super) fn restart(&mut self) {
        if let Some(growth) = &mut self.record.growth {
            growth.restart();
        }
        if let Some(twin) = &mut self.record.twin {
            twin.restart();
        }
        self.record.watch.restart();
        self.record.strobe = CycleAverages::default();
        self.record.measured = 0;
        self.record.events = 0;
        self.series = Series::default();
    }
}
