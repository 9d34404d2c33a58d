//! What of a valid manifest is worth a word: what has no effect, and what no gear drive is built like.
//! Nothing here is refused.

mod idle;
mod sizes;
mod suspect;

use super::tree::Node;
use super::{AxisKey, Job, reader, schema};

/// Why something is worth a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdviceKind {
    /// It may be left out without a change of any result.
    NoEffect,
    /// No gear drive is built like that; mostly a unit is another one than was meant.
    Suspect,
}

/// Where a key is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// This line of the manifest, from 1.
    Line(usize),
    /// Another value than in the manifest, by the command.
    Set,
}

/// A word on a key of a manifest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Advice {
    /// Why.
    pub kind: AdviceKind,
    /// Its path, such as `mesh.half_gap`.
    pub key: String,
    /// Where it is given; none where its default is meant, or what a drawing or a modal file makes of it.
    pub place: Option<Place>,
    /// In a sentence.
    pub message: String,
}

/// All there is to say of a job beside its warnings, a key at most once, in the order of the manifest.
pub fn advice(job: &Job) -> Vec<Advice> {
    let text = Text {
        root: job.written().tree(),
        text: &job.text,
    };
    let mut found: Vec<Advice> = Vec::new();
    let mut add = |kind, (key, mut message): (String, String)| {
        let place = text.place_of(&key);
        // Harmonics of deviations that are given tooth by tooth are nobody's to change.
        let derived = place.is_none() && key.starts_with("excitation.");
        let warned = job.warnings.diagnostics.iter().any(|own| own.key == key);
        if kind == AdviceKind::Suspect
            && let Some(meant) = text.root.at(&key).and_then(|node| bare(node, &key))
        {
            message = format!("{message}; {meant}");
        }
        if !derived && !warned && !found.iter().any(|known: &Advice| known.key == key) {
            found.push(Advice {
                kind,
                key,
                place,
                message,
            });
        }
    };
    let ends = |wanted: &AxisKey| {
        let axis = job.axes.iter().find(|axis| axis.key == *wanted);
        axis.map_or((0.0, 0.0), |axis| axis.values.ends())
    };
    let largest = |(low, high): (f64, f64)| low.abs().max(high.abs());
    let operating = suspect::Operating {
        load: largest(ends(&AxisKey::Load)),
        speed: largest(ends(&AxisKey::Speed)),
    };
    let torque = largest(ends(&AxisKey::Torque));
    for variant in job.points.variants().iter() {
        let operating = suspect::Operating {
            load: operating.load.max(variant.model.load_of_torque(torque)),
            ..operating
        };
        let suspects = suspect::suspects(variant, operating);
        suspects
            .into_iter()
            .for_each(|word| add(AdviceKind::Suspect, word));
    }
    if let Some(first) = job.points.first() {
        let idle = idle::idle(job, &first, &text.root);
        idle.into_iter()
            .for_each(|word| add(AdviceKind::NoEffect, word));
    }
    found.sort_by_key(|advice| (advice.kind == AdviceKind::NoEffect, advice.place));
    found
}

/// What a number without a unit may have been meant as.
fn bare(node: &Node, key: &str) -> Option<String> {
    reader::meant(&node.value, schema::find(schema::MANIFEST, key)?)
}

/// A manifest and where its keys stand.
struct Text<'t> {
    root: Node,
    text: &'t str,
}

impl Text<'_> {
    /// Where a key is given, or the axis of the grid that varies it.
    fn place_of(&self, key: &str) -> Option<Place> {
        let axis = self.root.at("grid").and_then(|grid| grid.entry(key));
        let span = match axis {
            Some(axis) => axis.key_span,
            None => self.root.at(key)?.span,
        };
        if span.source != 0 {
            return Some(Place::Set);
        }
        let before = self.text.get(..span.start)?;
        Some(Place::Line(1 + before.matches('\n').count()))
    }
}
