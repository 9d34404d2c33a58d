//! Manifests, their modal files, and key changes from a command.

use super::right;
use super::scratch::{folder, put};
use gearatlas::input::printable;
use gearatlas::manifest::{Job, ManifestErrors, ManifestText, advice};
use gearatlas::propagate::{Counters, Kernel, Volterra};
use gearatlas::store::TableStore;
use gearatlas::sweep::Prepared;
use std::path::Path;

/// Most bytes printed about a manifest of the size that fuzzers generate.
const WORDS: usize = 200_000;

/// Limit of windows per mesh cycle, for the time of a run.
const WINDOWS: f64 = 2000.0;

/// The text of a manifest.
pub fn manifest(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let changes = &[];
    judged(
        ManifestText {
            text: &text,
            changes,
        },
        &folder(),
    );
}

/// The text of a modal file.
pub fn modal(data: &[u8]) {
    let folder = folder();
    put(&folder.join("fuzzed.modal.toml"), data);
    let text = super::scratch::OSCILLATOR.replace("oscillator.modal.toml", "fuzzed.modal.toml");
    let changes = &[];
    let text = ManifestText {
        text: &text,
        changes,
    };
    if let Some(job) = judged(text, &folder) {
        a_cycle(&job, &folder);
    }
}

/// One change of a key of the quick start per line.
pub fn changes(data: &[u8]) {
    let changes: Vec<String> = (String::from_utf8_lossy(data).lines())
        .map(str::to_owned)
        .collect();
    let text = include_str!("../../manifests/quickstart.toml");
    judged(
        ManifestText {
            text,
            changes: &changes,
        },
        &folder(),
    );
}

/// The job of a text, if it has one; checks the verdict in either case.
pub fn judged(text: ManifestText<'_>, folder: &Path) -> Option<Job> {
    match text.job("m.toml", folder) {
        Ok(job) => {
            accepted(&job, folder);
            Some(job)
        }
        Err(errors) => {
            refused(&errors);
            None
        }
    }
}

/// A job has points, each with a finite speed and load and a value for every axis, and reading it again gives the same.
fn accepted(job: &Job, folder: &Path) {
    right(!job.points.is_empty(), || "a job without points".into());
    let last = job.points.len() - 1;
    for id in [0, last / 2, last] {
        let point = job.points.at(id);
        let sound = point.speed.is_finite() && point.speed > 0.0 && point.load.is_finite();
        right(sound, || {
            format!("point {id}: {} {}", point.load, point.speed)
        });
        right(point.axis_values.len() == job.axes.len(), || {
            format!("point {id}: {:?}", point.axis_values)
        });
        right(
            point.axis_values.iter().all(|value| value.is_finite()),
            || format!("point {id}: {:?}", point.axis_values),
        );
    }
    let again = job.written().job("m.toml", folder);
    let same = again.is_ok_and(|again| again.hash == job.hash);
    right(same, || "read again, it is another job".into());
    for advice in advice(job) {
        shows(&format!("{advice:?}"));
    }
}

/// A refusal has faults, all in the text, and few words that a terminal only displays.
fn refused(errors: &ManifestErrors) {
    right(errors.count() > 0, || "refused without a fault".into());
    for fault in &errors.diagnostics {
        let span = fault.span;
        let text = errors.sources[span.source].text.get(span.start..span.end);
        right(text.is_some(), || format!("no text at {span:?}"));
        right(!fault.message.is_empty(), || "a fault without words".into());
    }
    shows(&errors.render(false));
}

fn shows(words: &str) {
    right(words.len() < WORDS, || {
        format!("{} bytes of words", words.len())
    });
    right(printable(words) == words, || format!("{words:?}"));
}

/// The model of the first point starts with finite numbers, and a cycle of it ends with finite numbers or stops.
fn a_cycle(job: &Job, folder: &Path) {
    let point = job.points.at(0);
    let parts = Prepared::new(TableStore::open(folder.join("tables")));
    let Ok(model) = parts.model(&point) else {
        return;
    };
    let mut trajectory = model.start(&point.run.initial);
    if Volterra::windows_needed(&model, f64::EPSILON) > WINDOWS {
        return;
    }
    let kernel = Volterra::new(&model, f64::EPSILON, 1000);
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    let ended = kernel.advance(1, &mut trajectory, &mut workspace, &mut (), &mut counters);
    let finite = trajectory.state.iter().all(|x| x.is_finite());
    right(ended.is_err() || finite, || {
        format!("{:?}", trajectory.state)
    });
}
