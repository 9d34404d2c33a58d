//! Progress on standard error: a bar on a terminal, plain lines elsewhere.

use super::activity::Activity;
use super::line::{self, Part};
use crate::input::printable;
use crate::store::PointRow;
use crate::sweep::{Progress, ProgressObserver, SweepPlan};
use indicatif::{HumanDuration, ProgressBar};
use std::io::{IsTerminal, Write};
use std::time::Duration;

/// Smallest time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Shows the progress of a sweep.
pub struct Display {
    bar: ProgressBar,
    quiet: bool,
    terminal: bool,
    activity: Activity,
    /// Time of the run when the last line was written.
    last_line: Duration,
}

impl Display {
    /// A display on standard error; it writes nothing if `quiet`.
    pub fn new(quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bar = line::bar(None, quiet, "{wide_msg}");
        Self {
            bar,
            quiet,
            terminal,
            activity: Activity::default(),
            last_line: Duration::ZERO,
        }
    }

    /// Writes a line, above the bar if there is one.
    fn write_line(&self, line: &str) {
        if self.quiet {
            return;
        }
        let line = printable(line);
        if self.terminal {
            self.bar.println(line);
        } else {
            // Ignore a closed standard error.
            _ = writeln!(std::io::stderr(), "{line}");
        }
    }

    fn show(&mut self, progress: &Progress) {
        let mut parts = parts(progress);
        let nodes = self.activity.words(progress.elapsed.as_secs_f64());
        if !nodes.is_empty() {
            parts.push(Part {
                words: nodes,
                rank: 5,
            });
        }
        let plain = !self.quiet && !self.terminal;
        if plain && progress.elapsed >= self.last_line + LINE_INTERVAL {
            self.last_line = progress.elapsed;
            let words: Vec<&str> = parts.iter().map(|part| part.words.as_str()).collect();
            self.write_line(&words.join(", "));
        }
        if self.terminal && !self.quiet {
            let share = progress.done as f64 / progress.points as f64;
            self.bar
                .set_message(line::fitted(share, &parts, line::width()));
        }
    }
}

impl Drop for Display {
    /// Removes the bar.
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl ProgressObserver for Display {
    fn begun(&mut self, begun: &SweepPlan<'_>) {
        let Progress {
            points, resumed, ..
        } = begun.progress;
        if resumed > 0 && !self.terminal {
            self.write_line(&format!(
                "{resumed}/{points} points kept from an interrupted run"
            ));
        }
    }

    fn warning(&mut self, sentence: &str) {
        self.write_line(&format!("warning: {sentence}"));
    }

    fn prepared(&mut self, tables: u64) {
        if self.terminal && !self.quiet {
            self.bar.set_message(format!("{tables} mesh tables ready"));
        }
    }

    fn point(&mut self, row: &PointRow, progress: &Progress) {
        self.activity.count(row);
        self.show(progress);
    }

    fn tick(&mut self, progress: &Progress) {
        self.show(progress);
    }
}

/// The number of finished points, the rate, the remaining time and the points that failed, in words.
fn parts(progress: &Progress) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut say = |rank: u8, words: String| parts.push(Part { words, rank });
    say(0, format!("{}/{} points", progress.done, progress.points));
    if progress.open {
        say(4, "more where they differ".to_owned());
    }
    say(3, format!("{:.2} points/s", progress.rate()));
    if let Some(left) = progress.left() {
        // At the start of a run, the estimate can exceed the range of a duration.
        let left = Duration::try_from_secs_f64(left).unwrap_or(Duration::MAX);
        say(1, format!("about {} left", HumanDuration(left)));
    }
    say(2, format!("{} failed", progress.failed));
    let unsettled = progress.not_ok - progress.failed;
    if unsettled > 0 {
        say(2, format!("{unsettled} not converged"));
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn remark(progress: &Progress) -> String {
        let words: Vec<String> = parts(progress).into_iter().map(|part| part.words).collect();
        words.join(", ")
    }

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
            "30/80 points, 5.00 points/s, about 10 seconds left, 1 failed, 2 not converged"
        );
        progress.elapsed = Duration::ZERO;
        assert_eq!(
            remark(&progress),
            "30/80 points, 0.00 points/s, 1 failed, 2 not converged"
        );
        progress.elapsed = Duration::from_secs(4);
        progress.open = true;
        assert_eq!(
            remark(&progress),
            "30/80 points, more where they differ, 5.00 points/s, 1 failed, 2 not converged"
        );
    }
}
