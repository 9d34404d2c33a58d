//! What is measured beside a trajectory.

use super::watch::Recorders;
use crate::analysis::averages::CycleAverages;
use crate::analysis::config::PointConfig;
use crate::analysis::lyapunov::TangentGrowth;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::recurrence::Recurrence;
use crate::analysis::twin::Twin;
use crate::model::{Model, TrajectoryState};

/// Most cycles of a trajectory whose growth and strobe deflection are kept one by one.
const MOST_CYCLES: usize = 1 << 16;

/// What was measured of one trajectory, or of several, one behind the other.
#[derive(Clone)]
pub(super) struct Record {
    pub(super) growth: Option<TangentGrowth>,
    pub(super) twin: Option<Twin>,
    pub(super) watch: Recorders,
    /// Averages of the squared strobe deflection \[m²\]: a statistic of motion that every point has.
    pub(super) strobe: CycleAverages,
    /// Measured cycles.
    pub(super) measured: u64,
    /// Events in them.
    pub(super) events: u64,
}

impl Record {
    /// Averages of the growth of the largest exponent; `None` if no exponent is asked for.
    pub(super) fn averages(&self) -> Option<&CycleAverages> {
        self.growth.as_ref().map(TangentGrowth::averages)
    }

    /// Keeps the first `cycles` alone, in which there were so many events.
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
        self.strobe.cut(cycles);
        self.measured = cycles;
        self.events = events;
    }

    /// Adds the record of another trajectory behind this one; the twin stays that of the first.
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

/// Growth and strobe deflection of every cycle, as long as they are few.
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

    /// Whether it still holds every measured cycle.
    pub(super) fn is_whole(&self, measured: u64) -> bool {
        self.growth.len() as u64 == measured
    }
}

/// The instruments of one trajectory.
pub(super) struct Instruments {
    pub(super) record: Record,
    pub(super) recurrence: Recurrence,
    pub(super) series: Series,
}

impl Instruments {
    /// Instruments for the questions asked, at the trajectory's present place.
    pub(super) fn new(
        model: &Model,
        norm: &EnergyNorm,
        questions: &PointConfig,
        trajectory: &TrajectoryState,
    ) -> Self {
        let growth = questions.lyapunov.map(|l| {
            let count = l.exponents.min(norm.dimension());
            let mut stream = questions.point.stream(0);
            TangentGrowth::new(norm, model.modes(), count, &mut stream)
        });
        let wanted = questions.lyapunov.filter(|l| l.twin);
        let twin = (growth.as_ref().zip(wanted)).map(|(growth, asked)| {
            Twin::new(model, norm, trajectory, growth.leading(), asked.separation)
        });
        Self::of(model, growth, twin, Recorders::asked(model, questions))
    }

    /// Instruments of a trajectory that branched off another, with the tangents that it had there.
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

    /// Forgets what was measured, keeps directions.
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
