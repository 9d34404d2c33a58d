//! Speed and loads over a stretch of time.

use super::VaryingSpeed;
use super::powers::{Course, on_window, rate, square, value};
use crate::model::{LOAD_TERMS, LoadTerm};

/// Rotation and loads over a stretch of time, by powers of time \[s\] since its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedInterval {
    /// Its length \[s\].
    pub duration: f64,
    /// Mean rotation of the pinion \[rad\], 0 at the start.
    pub rotation: Course,
    /// Load, as a fraction of the rated one.
    pub load: Course,
    /// Additional torques on the pinion's and the wheel's shaft \[N m\], each positive in its sense of rotation.
    pub torques: [Course; 2],
}

impl SpeedInterval {
    /// An interval of constant speed \[rad/s\] and load.
    pub fn steady(duration: f64, speed: f64, load: f64) -> Self {
        let mut interval = Self {
            duration,
            rotation: Course::default(),
            load: Course::default(),
            torques: [Course::default(); 2],
        };
        (interval.rotation[1], interval.load[0]) = (speed, load);
        interval
    }

    /// Adds the torque on the pinion's shaft that accelerates the whole drive as `rotation` requires. Unchanged if no
    /// known torque on this shaft turns the whole drive.
    #[must_use]
    pub fn accelerated(mut self, kernel: &VaryingSpeed) -> Self {
        if let Some(mobility) = kernel.mobility[0] {
            let acceleration = rate(&rate(&self.rotation));
            for (torque, a) in self.torques[0].iter_mut().zip(acceleration) {
                *torque += a / mobility;
            }
        }
        self
    }

    /// Whether the speed is positive at all points of a fine grid.
    pub(super) fn runs_forwards(&self) -> bool {
        const PLACES: u32 = 64;
        let speed = rate(&self.rotation);
        (0..=PLACES).all(|k| value(&speed, f64::from(k) / f64::from(PLACES) * self.duration) > 0.0)
    }

    /// Upper bound of the speed \[rad/s\].
    pub(super) fn fastest(&self) -> f64 {
        let sizes = rate(&self.rotation).map(f64::abs);
        value(&sizes, self.duration)
    }

    /// Mesh cycles that pass on a window, and the load terms there, by powers of u. The window starts at
    /// `start` \[s\] of the interval and is `length` \[s\] long.
    pub(super) fn on_window(
        &self,
        kernel: &VaryingSpeed,
        start: f64,
        length: f64,
    ) -> (Course, [Course; LOAD_TERMS]) {
        let rotation = on_window(&self.rotation, start, length);
        let speed = rate(&rotation).map(|a| a / length);
        let mut cycles = rotation.map(|a| kernel.cycles_per_radian * a);
        cycles[0] = 0.0;
        let mut loads = [Course::default(); LOAD_TERMS];
        loads[LoadTerm::Rated as usize] = on_window(&self.load, start, length);
        loads[LoadTerm::Constant as usize][0] = 1.0;
        loads[LoadTerm::Speed as usize] = speed;
        loads[LoadTerm::SpeedSquared as usize] = square(&speed);
        loads[LoadTerm::PinionTorque as usize] = on_window(&self.torques[0], start, length);
        loads[LoadTerm::WheelTorque as usize] = on_window(&self.torques[1], start, length);
        (cycles, loads)
    }
}
