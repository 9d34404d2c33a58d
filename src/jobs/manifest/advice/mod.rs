//! Advice about a valid manifest: keys without effect, and values that no gear drive has. Advice never refuses a
//! manifest.

mod idle;
mod sizes;
mod suspect;

use super::tree::Node;
use super::{AxisKey, Job, reader, schema};

/// The reason for advice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdviceKind {
    /// The key may be omitted without a change of any result.
    NoEffect,
    /// No gear drive has such a value; usually the unit is wrong.
    Suspect,
}

/// The place of a key's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// A line of the manifest, from 1.
    Line(usize),
    /// A value that the command sets.
    Set,
}

/// Advice about a key of a manifest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Advice {
    /// Reason.
    pub kind: AdviceKind,
    /// Path of the key, such as `mesh.half_gap`.
    pub key: String,
    /// Place of its value; `None` for a default, or a value from a drawing or a modal file.
    pub place: Option<Place>,
    /// Message, one sentence.
    pub message: String,
}

/// All advice on a job in addition to its warnings, at most once per key: suspect values, then keys without effect,
/// each in the order of the manifest.
pub fn advice(job: &Job) -> Vec<Advice> {
    let text = Text {
        root: job.written().tree(),
        text: &job.text,
    };
    let mut found: Vec<Advice> = Vec::new();
    let mut add = |kind, (key, mut message): (String, String)| {
        let place = text.place_of(&key);
        // Harmonics that are computed from gear errors or a torque curve have no separate key.
        let derived = place.is_none() && key.starts_with("excitation.");
        let warned = job
            .warnings
            .diagnostics
            .iter()
            .any(|warning| warning.key == key);
        if kind == AdviceKind::Suspect
            && let Some(node) = text.root.at(&key)
            && let Some(spec) = schema::find(schema::MANIFEST, &key)
            && let Some(meant) = reader::meant(&node.value, spec)
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
    let operating = suspect::LargestOperation {
        load: largest(ends(&AxisKey::Load)),
        speed: largest(ends(&AxisKey::Speed)),
    };
    let torque = largest(ends(&AxisKey::Torque));
    for variant in job.points.variants().iter() {
        let operating = suspect::LargestOperation {
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

/// A manifest and the places of its keys.
struct Text<'t> {
    root: Node,
    text: &'t str,
}

impl Text<'_> {
    /// Place of a key, or of the axis of the grid that varies it.
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
