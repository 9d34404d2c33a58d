//! Progress on standard error: a bar on a terminal, plain lines elsewhere.

use crate::store::PointRow;
use crate::sweep::{Progress, Watcher};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Least time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Shows how far a sweep is.
pub struct Display {
    bar: ProgressBar,
    plain: bool,
    points: u64,
    /// When this run began to compute.
    started: Instant,
    last_line: Instant,
}

impl Display {
    /// A display for so many points; silent when `quiet`.
    pub fn new(points: u64, quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let target = if quiet || !terminal {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(points), target);
        let template = "{bar:30} {pos}/{len} points  {per_sec}  ETA {eta}  {msg}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(250));
        Self {
            bar,
            plain: !quiet && !terminal,
            points,
            started: Instant::now(),
            last_line: Instant::now(),
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn line(&mut self, progress: &Progress) {
        let due = self.last_line.elapsed() >= LINE_INTERVAL;
        if !self.plain || !due {
            return;
        }
        self.last_line = Instant::now();
        let computed = progress.done - progress.resumed;
        let rate = computed as f64 / self.started.elapsed().as_secs_f64();
        let left = (self.points - progress.done) as f64 / rate;
        // Nothing can be done when standard error is closed.
        _ = writeln!(
            std::io::stderr(),
            "{}/{} points, {rate:.2} points/s, about {left:.0} s left{}",
            progress.done,
            self.points,
            remark(progress)
        );
    }
}

impl Watcher for Display {
    fn resumed(&mut self, progress: &Progress) {
        self.started = Instant::now();
        if progress.resumed == 0 {
            return;
        }
        // What is taken over must not count for the rate.
        self.bar.set_position(progress.done);
        self.bar.reset_eta();
        if self.plain {
            // Nothing can be done when standard error is closed.
            _ = writeln!(
                std::io::stderr(),
                "{}/{} points taken over from an interrupted run",
                progress.resumed,
                self.points
            );
        }
    }

    fn point(&mut self, _: &PointRow, progress: &Progress) {
        self.bar.set_position(progress.done);
        self.bar
            .set_message(remark(progress).trim_start_matches(", ").to_owned());
        self.line(progress);
    }
}

/// Points that ended badly, in words.
fn remark(progress: &Progress) -> String {
    let unsettled = progress.not_ok - progress.failed;
    let mut text = format!(", {} failed", progress.failed);
    if unsettled > 0 {
        text += &format!(", {unsettled} not settled");
    }
    text
}
