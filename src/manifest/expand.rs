//! What the points of a grid are made of: every combination of model-key values is put into the
//! tree and resolved like text; load and speed vary inside, where nothing needs resolving again.

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use super::grid::GridAxis;
use super::hash::JobHash;
use super::points::Variant;
use super::reader::Section;
use super::schema::{self, MANIFEST};
use super::sections::{Context, resolve};
use super::spec::PointSpec;
use super::tree::Node;
use crate::shaft::ModalStructure;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Combinations with faults after which no more are looked at.
const MAX_FAULTY: usize = 1000;

/// How often a fault was seen.
#[derive(Debug)]
struct Sighting {
    index: usize,
    combinations: usize,
}

type Faults = HashMap<(DiagnosticKind, Span, String), Sighting>;

/// Resolves the whole grid, the last model key fastest.
///
/// Every fault is recorded once, with the first combination at which it shows when it
/// does not show at all of them. Unless `exhaustive` (the grid is too large) only the first
/// combination is looked at.
pub(super) fn expand(
    tree: &mut Node,
    axes: &[GridAxis],
    exhaustive: bool,
    issues: &mut Issues,
    context: &mut Context,
    hash: &mut JobHash,
) -> Vec<Variant> {
    let keys: Vec<&GridAxis> = axes.iter().filter(|axis| axis.is_model_key()).collect();
    let mut variants: Vec<Variant> = Vec::new();
    let mut faults = Faults::new();
    let (mut tried, mut faulty) = (0, 0);
    let mut index = vec![0; keys.len()];
    loop {
        let before = issues.found.len();
        let resolved = substitute(tree, &keys, &index, issues)
            .then(|| resolve(&Section::root(tree, MANIFEST), issues, context))
            .flatten();
        tried += 1;
        if issues.found.len() > before {
            faulty += 1;
            sift(issues, before, &mut faults, &keys, &index);
        }
        if let Some(mut resolved) = resolved.filter(|_| issues.found.is_empty()) {
            hash.resolved(&resolved);
            if let Some(last) = variants.last() {
                resolved.share(last);
            }
            variants.push(resolved);
        }
        if !exhaustive || faulty >= MAX_FAULTY || !advance(&mut index, &keys) {
            break;
        }
    }
    for sighting in faults
        .values()
        .filter(|sighting| sighting.combinations == tried)
    {
        issues.found[sighting.index].at_point = None;
    }
    variants
}

/// Puts one value of every key axis into the tree; false when one has no place there.
fn substitute(tree: &mut Node, keys: &[&GridAxis], index: &[usize], issues: &mut Issues) -> bool {
    let mut fits = true;
    for (key, &i) in keys.iter().zip(index) {
        let name = &key.axis.name;
        let path: Vec<&str> = name.split('.').collect();
        if let Err(short) = tree.put(&path, key.node(i)) {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::UnknownAxis,
                    key.key_span,
                    name,
                    format!(
                        "the axis `{name}` names an element that is not there: the list has {}",
                        super::reader::entries(short.length)
                    ),
                )
                .label("no such element")
                .remedy("elements count from 0; write the list in its own table first"),
            );
            fits = false;
        }
    }
    fits
}

/// The next combination, the last key fastest.
fn advance(index: &mut [usize], keys: &[&GridAxis]) -> bool {
    for (i, key) in index.iter_mut().zip(keys).rev() {
        *i += 1;
        if *i < key.axis.values.len() {
            return true;
        }
        *i = 0;
    }
    false
}

/// Drops faults seen at an earlier combination and says of new ones where they were seen.
fn sift(
    issues: &mut Issues,
    before: usize,
    faults: &mut Faults,
    keys: &[&GridAxis],
    index: &[usize],
) {
    let place = keys
        .iter()
        .zip(index)
        .map(|(key, &i)| format!("{} = {}", key.axis.name, schema::number(key.axis.values[i])))
        .collect::<Vec<_>>()
        .join(", ");
    let mut seen_here: Vec<(DiagnosticKind, Span, String)> = Vec::new();
    for mut diagnostic in issues.found.split_off(before) {
        let identity = (diagnostic.kind, diagnostic.span, diagnostic.key.clone());
        if seen_here.contains(&identity) {
            continue;
        }
        seen_here.push(identity.clone());
        if let Some(sighting) = faults.get_mut(&identity) {
            sighting.combinations += 1;
            continue;
        }
        let own_file = diagnostic.span.source == 0 && diagnostic.kind != DiagnosticKind::Unreadable;
        if own_file && !keys.is_empty() {
            diagnostic.at_point = Some(place.clone());
        }
        faults.insert(
            identity,
            Sighting {
                index: issues.found.len(),
                combinations: 1,
            },
        );
        issues.push(diagnostic);
    }
}

/// The text of a job, kept to resolve points that the grid does not have.
#[derive(Debug, Clone)]
pub struct Between(Arc<Kept>);

#[derive(Debug)]
struct Kept {
    tree: Node,
    keys: Vec<GridAxis>,
    base_dir: PathBuf,
    modal_files: HashMap<PathBuf, Option<Arc<ModalStructure>>>,
}

impl Between {
    /// `axes` has the model keys first, as [`expand`] wants them.
    pub(super) fn new(tree: Node, axes: Vec<GridAxis>, context: Context) -> Self {
        Self(Arc::new(Kept {
            tree,
            keys: axes.into_iter().filter(GridAxis::is_model_key).collect(),
            base_dir: context.base_dir.to_path_buf(),
            modal_files: context.modal_files,
        }))
    }

    /// Gives a point the mesh and the excitation that its axis values stand for. None where
    /// the manifest would be faulty with these values.
    pub(super) fn resolve(&self, point: &mut PointSpec) -> Option<()> {
        let kept = &*self.0;
        let mut tree = kept.tree.clone();
        for (key, value) in kept.keys.iter().zip(&point.axis_values) {
            let path: Vec<&str> = key.axis.name.split('.').collect();
            tree.put(&path, key.sample(*value)).ok()?;
        }
        let mut issues = Issues::default();
        let mut context = Context::new(&kept.base_dir);
        context.modal_files.clone_from(&kept.modal_files);
        let resolved = resolve(&Section::root(&tree, MANIFEST), &mut issues, &mut context)?;
        if !issues.found.is_empty() {
            return None;
        }
        point.mesh = resolved.mesh;
        point.excitation = resolved.excitation;
        Some(())
    }
}
