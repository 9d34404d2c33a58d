//! `atlas follow m.toml`: periodic orbits over an axis of the grid, through their bifurcations.

use super::manifest_args::ManifestArgs;
use super::process::{NOTHING_WRITTEN, Process, begin_writing};
use super::status::failure;
use super::table::TablesFolder;
use super::threads::Threads;
use super::{BAD_INPUT, INTERRUPTED, Status, answer, fail, labelled, reply, with_causes};
use crate::analysis::continuation::end::End;
use crate::input::printable;
use crate::manifest::Job;
use crate::report::counted;
use crate::store::{TableKind, table_path};
use crate::sweep::{FollowError, Followed, Prepared, WORKER, follow_job, write_branches};
use clap::Args;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Arguments of `atlas follow`.
#[derive(Debug, Args)]
pub struct FollowArgs {
    #[command(flatten)]
    manifest: ManifestArgs,
    /// Write the results to this folder [default: results/JOB].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    tables: TablesFolder,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Follows orbits: status 0 if done, 1 if threads cannot start or files cannot be written, 2 for bad input, 130 if
/// interrupted.
pub fn run(args: &FollowArgs) -> Status {
    let job = args.manifest.read_job()?;
    let process = Process::prepare(NOTHING_WRITTEN)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.count().unwrap_or(0))
        .thread_name(|i| format!("{WORKER}{i}"));
    let pool = match pool.build() {
        Ok(pool) => pool,
        Err(error) => {
            return Err(fail(
                1,
                &format!("cannot start worker threads: {error}; ask for fewer with --threads"),
            ));
        }
    };
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| Path::new("results").join(&job.name));
    let parts = Prepared::new(args.tables.store());
    let clock = Instant::now();
    let talks = !args.quiet && !args.json && std::io::stderr().is_terminal();
    let report_progress = |text: &str| {
        if talks {
            // A closed terminal is no reason to stop.
            _ = writeln!(std::io::stderr().lock(), "{}", printable(text));
        }
    };
    let followed =
        match pool.install(|| follow_job(&job, &parts, &process.interrupt, &report_progress)) {
            Ok(followed) => followed,
            Err(FollowError::Interrupted(_)) => {
                return Err(fail(INTERRUPTED, NOTHING_WRITTEN));
            }
            Err(error) => return Err(fail(BAD_INPUT, &with_causes(&error))),
        };
    let seconds = clock.elapsed().as_secs_f64();
    let census = Census {
        job: job.name.clone(),
        folder,
        seconds,
        ..Census::default()
    };
    let census = census.counting(&followed);
    begin_writing();
    if let Err(error) = write_branches(&job, &census.folder, &followed) {
        return Err(fail(failure(&error), &with_causes(&error)));
    }
    let text = || census.text(&job, &followed);
    let text = reply(args.json, args.quiet, || &census, text);
    Ok(answer(&text, ExitCode::SUCCESS))
}

/// Counts of the results and the folder with the results; also the JSON output.
#[derive(Default, Serialize)]
struct Census {
    job: String,
    folder: PathBuf,
    seconds: f64,
    branches: usize,
    orbits: usize,
    newton_steps: u64,
    models: u64,
    steps_refused: u64,
    orbits_on_known_branches: usize,
    bifurcations: BTreeMap<&'static str, usize>,
    changes_of_sequence: usize,
    ends: BTreeMap<String, usize>,
    curves: BTreeMap<&'static str, usize>,
    failures: Vec<String>,
}

impl Census {
    /// The census with the counts of `followed` added.
    fn counting(mut self, followed: &Followed) -> Self {
        let out = &mut self;
        for line in &followed.lines {
            out.models += line.models;
            out.orbits_on_known_branches += line.branches.repeated_orbits;
            out.failures.extend(line.branches.failures.iter().cloned());
            for (_, branch) in &line.branches.all {
                out.branches += 1;
                out.orbits += branch.orbits.len();
                out.steps_refused += branch.rejected;
                out.newton_steps += branch
                    .orbits
                    .iter()
                    .map(|orbit| u64::from(orbit.steps))
                    .sum::<u64>();
                for bifurcation in &branch.bifurcations {
                    *out.bifurcations.entry(bifurcation.kind.name()).or_default() += 1;
                }
                let pairs = branch.orbits.windows(2);
                out.changes_of_sequence += pairs
                    .filter(|p| {
                        !p[0]
                            .details
                            .touches
                            .is_cyclic_shift_of(&p[1].details.touches)
                    })
                    .count();
                for end in branch.ends.iter().filter(|end| **end != End::Start) {
                    let word = match end {
                        End::Lost { .. } => "no orbit beyond".to_owned(),
                        other => other.to_string(),
                    };
                    *out.ends.entry(word).or_default() += 1;
                }
            }
        }
        for plane in &followed.planes {
            for curve in &plane.all {
                *out.curves.entry(curve.kind.name()).or_default() += 1;
            }
            if !plane.onset.is_empty() {
                *out.curves.entry("onset").or_default() += 1;
            }
        }
        self
    }

    fn text(&self, job: &Job, followed: &Followed) -> String {
        let ends: Vec<String> = self
            .ends
            .iter()
            .map(|(end, count)| format!("{count} x {end}"))
            .collect();
        let over = job
            .continuation
            .as_ref()
            .map_or("", |spec| job.axes[spec.over].name());
        let mut lines = vec![
            (
                "job",
                format!(
                    "{}: orbits over {over}, {} lines",
                    job.name,
                    followed.lines.len()
                ),
            ),
            (
                "branches",
                format!(
                    "{} with {} orbits in {:.1} s, {:.2} Newton steps per orbit; {} steps refused",
                    self.branches,
                    self.orbits,
                    self.seconds,
                    self.newton_steps as f64 / self.orbits.max(1) as f64,
                    self.steps_refused
                ),
            ),
            ("bifurcations", counted(&self.bifurcations)),
            (
                "sequences",
                format!("changed {} times along branches", self.changes_of_sequence),
            ),
            ("ends", ends.join("; ")),
        ];
        if job
            .continuation
            .as_ref()
            .is_some_and(|spec| spec.second.is_some())
        {
            lines.push(("curves", counted(&self.curves)));
        }
        lines.extend(
            self.failures
                .iter()
                .map(|failure| ("not followed", failure.clone())),
        );
        let mut kinds = vec![TableKind::Branches, TableKind::Bifurcations];
        if !followed.planes.is_empty() {
            kinds.push(TableKind::Curves);
        }
        lines.extend(kinds.iter().enumerate().map(|(i, kind)| {
            (
                if i == 0 { "files" } else { "" },
                table_path(&self.folder, *kind, None).display().to_string(),
            )
        }));
        labelled(14, &lines)
    }
}
