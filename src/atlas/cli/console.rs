//! The messages of `atlas run` during the run and at its end: text for users, or JSON events for programs.

use super::answer;
use super::events::Events;
use super::progress::Display;
use super::run_args::RunArgs;
use crate::manifest::Job;
use crate::store::{PointRow, RunRecord};
use crate::sweep::{Progress, ProgressObserver, SweepPlan};
use std::path::Path;
use std::process::ExitCode;

/// Prints messages in the requested form.
pub struct Console<'a> {
    quiet: bool,
    display: Display,
    events: Option<Events<'a>>,
}

impl<'a> Console<'a> {
    /// The console of a run with results in `folder`.
    pub fn new(args: &RunArgs, job: &'a Job, folder: &'a Path) -> Self {
        Self {
            quiet: args.quiet,
            display: Display::new(args.quiet),
            events: args.json.then(|| Events::new(job, folder, args.shard)),
        }
    }

    /// Reports the end of the run, for users as `text`, and returns the exit status.
    pub fn close(self, record: &RunRecord, exit_status: u8, text: &str) -> ExitCode {
        drop(self.display);
        match self.events {
            Some(events) => events.finished(record, exit_status),
            None if self.quiet => ExitCode::from(exit_status),
            None => answer(text, ExitCode::from(exit_status)),
        }
    }

    fn each(&mut self, visit: impl Fn(&mut dyn ProgressObserver)) {
        visit(&mut self.display);
        if let Some(events) = &mut self.events {
            visit(events);
        }
    }
}

impl ProgressObserver for Console<'_> {
    fn begun(&mut self, begun: &SweepPlan<'_>) {
        self.each(|watcher| watcher.begun(begun));
    }

    fn warning(&mut self, sentence: &str) {
        self.each(|watcher| watcher.warning(sentence));
    }

    fn prepared(&mut self, tables: u64) {
        self.each(|watcher| watcher.prepared(tables));
    }

    fn writing(&mut self) {
        super::process::begin_writing();
    }

    fn point(&mut self, row: &PointRow, progress: &Progress) {
        self.each(|watcher| watcher.point(row, progress));
    }

    fn tick(&mut self, progress: &Progress) {
        self.each(|watcher| watcher.tick(progress));
    }
}
