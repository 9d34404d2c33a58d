//! Progress on standard error: a bar on a terminal, plain lines elsewhere.

use super::activity::Activity;
use crate::store::PointRow;
use crate::sweep::{Begun, Progress, Watcher};
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::time::Duration;

/// Least time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Shows how far a sweep is.
pub struct Display {
    bar: ProgressBar,
    quiet: bool,
    terminal: bool,
    activity: Activity,
    /// Time of the run when the last line was written.
    last_line: Duration,
}

impl Display {
    /// A display; silent when `quiet`.
    pub fn new(quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let target = if quiet || !terminal {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(None, target);
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} points  {msg}") {
            bar.set_style(style);
        }
        Self {
            bar,
            quiet,
            terminal,
            activity: Activity::default(),
            last_line: Duration::ZERO,
        }
    }

    /// Writes a line, above the bar where there is one.
    fn say(&self, line: &str) {
        if self.quiet {
            return;
        }
        if self.terminal {
            self.bar.println(line);
        } else {
            // Nothing can be done when standard error is closed.
            _ = writeln!(std::io::stderr(), "{line}");
        }
    }

    fn show(&mut self, progress: &Progress) {
        let mut text = remark(progress);
        let nodes = self.activity.words(progress.elapsed.as_secs_f64());
        if !nodes.is_empty() {
            text += &format!("; {nodes}");
        }
        self.bar.set_length(progress.points);
        self.bar.set_position(progress.done);
        let plain = !self.quiet && !self.terminal;
        if plain && progress.elapsed >= self.last_line + LINE_INTERVAL {
            self.last_line = progress.elapsed;
            self.say(&format!(
                "{}/{} points, {text}",
                progress.done, progress.points
            ));
        }
        self.bar.set_message(text);
    }
}

impl Drop for Display {
    /// Removes the bar.
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Watcher for Display {
    fn begun(&mut self, begun: &Begun<'_>) {
        let Progress {
            points, resumed, ..
        } = begun.progress;
        self.bar.set_length(points);
        self.bar.set_position(begun.progress.done);
        if resumed > 0 && !self.terminal {
            self.say(&format!(
                "{resumed}/{points} points taken over from an interrupted run"
            ));
        }
    }

    fn warning(&mut self, sentence: &str) {
        self.say(&format!("warning: {sentence}"));
    }

    fn point(&mut self, row: &PointRow, progress: &Progress) {
        self.activity.count(row);
        self.show(progress);
    }

    fn tick(&mut self, progress: &Progress) {
        self.show(progress);
    }
}

/// Rate, time left and points that ended badly, in words.
fn remark(progress: &Progress) -> String {
    let mut text = format!("{:.2} points/s", progress.rate());
    if progress.open {
        text = format!("more where they differ, {text}");
    }
    if let Some(left) = progress.left() {
        // Rates of a first moment may stand for times that a duration does not hold.
        let left = Duration::try_from_secs_f64(left).unwrap_or(Duration::MAX);
        text += &format!(", about {} left", HumanDuration(left));
    }
    text += &format!(", {} failed", progress.failed);
    let unsettled = progress.not_ok - progress.failed;
    if unsettled > 0 {
        text += &format!(", {unsettled} not settled");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remarks_leave_out_what_is_taken_over() {
        let mut progress = Progress {
            done: 30,
            not_ok: 3,
            failed: 1,
            resumed: 10,
            points: 80,
            open: false,
            cycles: 0,
            elapsed: Duration::from_secs(4),
        };
        assert_eq!(
            remark(&progress),
            "5.00 points/s, about 10 seconds left, 1 failed, 2 not settled"
        );
        progress.elapsed = Duration::ZERO;
        assert_eq!(remark(&progress), "0.00 points/s, 1 failed, 2 not settled");
        progress.elapsed = Duration::from_secs(4);
        progress.open = true;
        assert_eq!(
            remark(&progress),
            "more where they differ, 5.00 points/s, 1 failed, 2 not settled"
        );
    }
}
