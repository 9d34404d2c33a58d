//! Waits for quiet moments.
//!
//! Whoever shares a core, be it the second thread of it in another virtual machine, is in no
//! account that the system keeps, but takes a part of its units: some mesh cycles then take
//! longer than they did before. (Multiply-adds in registers do not show it: they leave room.)
//! Such disturbances last for seconds, so that it pays to wait, as long as there is patience,
//! and what had to be measured all the same is counted.

use super::drive;
use super::error::MeasurementError;
use super::team::{self, HardwareThread, Pace};
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Counters, Kernel, Volterra};
use crate::topology::Topology;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Mesh cycles of a look: a tenth of a millisecond.
const CYCLES: u64 = 32;

/// A look is the best of so many times: an interrupt in one of them does not count.
const TIMES: usize = 3;

/// A look is slowed when it takes this much of its best time: more than a clock that follows the
/// load makes of it (8 % where this was tried), less than a busy second thread of the core
/// (40 to 50 %).
const SLOWED: f64 = 1.15;

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(5);

/// Longest wait before one measurement.
const LONGEST: Duration = Duration::from_secs(1);

/// What is looked at: a drive that has settled, and its kernel.
#[derive(Debug)]
pub struct Probe<'m> {
    kernel: Volterra<'m>,
    start: TrajectoryState,
}

impl<'m> Probe<'m> {
    /// The probe of a drive.
    pub fn new(model: &'m Model) -> Result<Self, MeasurementError> {
        Ok(Self {
            kernel: drive::volterra(model),
            start: drive::settled(model)?,
        })
    }

    /// Advances some cycles, the same ones each time.
    fn advance(&self, workspace: &mut <Volterra<'m> as Kernel>::Workspace) {
        let mut trajectory = self.start.clone();
        let counters = &mut Counters::default();
        // It went this way before.
        _ = self
            .kernel
            .advance(CYCLES, &mut trajectory, workspace, &mut (), counters);
    }

    /// Time of some cycles, on all threads at once \[s\].
    fn look(
        &self,
        topology: &Topology,
        threads: &[HardwareThread],
    ) -> Result<f64, MeasurementError> {
        let pace = Pace {
            slice: Duration::ZERO,
            least: TIMES,
            most: TIMES,
        };
        let integrate = |workspace: &mut _, _| self.advance(workspace);
        let prepare = |_| Ok(self.kernel.workspace());
        let worked = team::work(
            topology,
            threads,
            1,
            pace,
            prepare,
            integrate,
            integrate,
            |_| (),
        )?;
        Ok(worked
            .times
            .into_iter()
            .flatten()
            .fold(f64::INFINITY, f64::min))
    }
}

/// Waits, and counts.
#[derive(Debug)]
pub struct QuietMachine<'a> {
    /// Ends all patience.
    called_off: &'a AtomicBool,
    /// Best look of so many threads together \[s\].
    best: HashMap<usize, f64>,
    patience: Duration,
    waited: Duration,
    measurements: usize,
    slowed: usize,
}

impl<'a> QuietMachine<'a> {
    /// Has no patience yet, and none any more once `called_off` is raised.
    pub fn new(called_off: &'a AtomicBool) -> Self {
        Self {
            called_off,
            best: HashMap::new(),
            patience: Duration::ZERO,
            waited: Duration::ZERO,
            measurements: 0,
            slowed: 0,
        }
    }

    /// Waits for so much longer in all.
    pub fn allow(&mut self, patience: Duration) {
        self.patience += patience;
    }

    /// Waits until integrating on these threads is as fast as it ever was, measures, and measures
    /// once more if it is slowed after that, as long as there is patience. Gives what was
    /// measured, once or twice.
    ///
    /// # Errors
    /// Of measuring.
    pub fn measure<M>(
        &mut self,
        probe: &Probe<'_>,
        topology: &Topology,
        threads: &[HardwareThread],
        measure: impl FnMut() -> Result<M, MeasurementError>,
    ) -> Result<Vec<M>, MeasurementError> {
        self.between(threads.len(), || probe.look(topology, threads), measure)
    }

    fn between<M>(
        &mut self,
        members: usize,
        mut look: impl FnMut() -> Result<f64, MeasurementError>,
        mut measure: impl FnMut() -> Result<M, MeasurementError>,
    ) -> Result<Vec<M>, MeasurementError> {
        let mut fast = self.settle(members, &mut look)?;
        let mut measured = vec![measure()?];
        fast &= self.judge(members, look()?);
        if !fast && self.is_patient() {
            fast = self.settle(members, &mut look)?;
            let begun = Instant::now();
            measured.push(measure()?);
            self.waited += begun.elapsed();
            fast &= self.judge(members, look()?);
        }
        self.measurements += 1;
        self.slowed += usize::from(!fast);
        Ok(measured)
    }

    /// Looks until integrating is fast, or patience ends; whether it is fast.
    fn settle(
        &mut self,
        members: usize,
        mut look: impl FnMut() -> Result<f64, MeasurementError>,
    ) -> Result<bool, MeasurementError> {
        let (begun, before) = (Instant::now(), self.waited);
        loop {
            let fast = self.judge(members, look()?);
            let over = begun.elapsed() > LONGEST || !self.is_patient();
            if fast || over {
                return Ok(fast);
            }
            std::thread::sleep(PAUSE);
            self.waited = before + begun.elapsed();
        }
    }

    fn is_patient(&self) -> bool {
        self.waited < self.patience && !self.called_off.load(Ordering::Relaxed)
    }

    /// Whether a look of so many threads was as fast as any.
    fn judge(&mut self, members: usize, time: f64) -> bool {
        let best = self.best.entry(members).or_insert(time);
        *best = best.min(time);
        time <= SLOWED * *best
    }

    /// How long it waited.
    pub fn waited(&self) -> Duration {
        self.waited
    }

    /// Part of the measurements that mesh cycles were slowed before or after; none before the first.
    pub fn slowed(&self) -> Option<f64> {
        let part = self.slowed as f64 / self.measurements as f64;
        (self.measurements > 0).then_some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disturbance_is_waited_for_and_then_counted() {
        let called_off = AtomicBool::new(false);
        let mut quiet = QuietMachine::new(&called_off);
        assert_eq!(quiet.slowed(), None);
        let measured = |quiet: &mut QuietMachine<'_>, members, times: &[f64]| {
            let mut looks = times.iter().copied();
            let found = quiet
                .between(members, || Ok(looks.next().unwrap()), || Ok(()))
                .unwrap();
            assert_eq!(looks.len(), 0, "{times:?}");
            found.len()
        };
        // The first look knows no better one; a clock may vary.
        assert_eq!(measured(&mut quiet, 1, &[2.0, 1.0]), 1);
        assert_eq!(measured(&mut quiet, 1, &[1.1, 1.14]), 1);
        // Without patience, what is slowed is measured all the same.
        assert_eq!(measured(&mut quiet, 1, &[1.5, 1.0]), 1);
        assert_eq!(
            (quiet.slowed(), quiet.waited()),
            (Some(1.0 / 3.0), Duration::ZERO)
        );

        quiet.allow(Duration::from_secs(3600));
        assert_eq!(measured(&mut quiet, 1, &[1.5, 1.2, 1.1, 1.0]), 1);
        assert!(quiet.waited() >= 2 * PAUSE);
        // Slowed meanwhile: once more, when it is over.
        assert_eq!(measured(&mut quiet, 1, &[1.0, 1.5, 1.5, 1.0, 1.0]), 2);
        assert_eq!(measured(&mut quiet, 1, &[1.0, 1.5, 1.0, 1.5]), 2);
        // Nobody waits for what is called off.
        called_off.store(true, Ordering::Relaxed);
        assert_eq!(measured(&mut quiet, 1, &[1.5, 1.5]), 1);
        called_off.store(false, Ordering::Relaxed);
        // Another number of threads has a best time of its own.
        assert_eq!(measured(&mut quiet, 2, &[9.0, 9.0]), 1);
        assert_eq!(quiet.slowed(), Some(3.0 / 8.0));
        let wrong = || Err(MeasurementError::Wrong { what: "x" });
        assert!(
            quiet
                .between(1, || Ok(1.0), wrong as fn() -> Result<(), _>)
                .is_err()
        );
    }

    #[test]
    fn every_thread_marches() {
        let topology = Topology::current().unwrap();
        let index = topology.cores[0].threads[0];
        let default = drive::DefaultDrive::new().unwrap();
        let model = default.probed().unwrap();
        let probe = Probe::new(&model).unwrap();
        let time = probe
            .look(&topology, &[HardwareThread { index, node: 0 }; 2])
            .unwrap();
        assert!(time > 0.0 && time < 1.0, "{time}");
    }
}
