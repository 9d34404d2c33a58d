//! How do the points of a grid follow from the manifest? Combinations of model-key values are put into the tree and
//! resolved like text. Load and speed vary within a combination and need no resolution.
//!
//! Every combination is judged, that is, resolved and searched for faults, if that takes a fraction of a
//! second. Otherwise only some are judged: the corners of the grid and evenly spaced others. Rows of a list
//! with equal values of the model keys are one combination. Every value was already checked against the range
//! of its key when its axis was read. A combination that was not judged is resolved when one of its points is
//! requested; only then are its faults found.

use super::combinations::{Combinations, chosen};
use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use super::grid::GridAxis;
use super::grid_dimension::GridDimension;
use super::hash::JobHash;
use super::modal_keys;
use super::point_resolver::{HALF_GAP, INCONSISTENT, PointResolver};
use super::reader::Section;
use super::schema::{self, MANIFEST};
use super::sections::{Context, resolve};
use super::spec::Variant;
use super::tree::Node;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};

/// Number of combinations with faults after which the search ends.
const MAX_FAULTY: usize = 1000;

/// Index of a fault in the list of faults, and number of combinations that have it.
#[derive(Debug)]
struct Occurrence {
    index: usize,
    combinations: usize,
}

type Faults = HashMap<(DiagnosticKind, Span, String), Occurrence>;

/// Largest number of nodes of the tree, summed over all judged combinations. Resolving them takes about a
/// tenth of a second.
const MOST_NODES: usize = 500_000;

/// Smallest and largest number of combinations up to which all are judged. The number is smaller for a longer manifest.
/// In a larger grid, as many evenly spaced combinations are judged, and the corners.
const JUDGED: std::ops::RangeInclusive<usize> = 4..=10_000;

/// Largest number of resolved combinations that are kept in addition to the judged ones. They take some
/// megabytes.
const MOST_KEPT: usize = 4096;

/// The judged combinations of values of the model keys, the last key fastest.
#[derive(Debug)]
pub(super) struct JudgedCombinations {
    variants: Vec<Variant>,
    /// Numbers of the combinations in `variants`; `None` if it has every combination of the grid.
    numbers: Option<Vec<usize>>,
}

impl JudgedCombinations {
    /// The resolved combinations, all without faults.
    pub fn variants(&self) -> &[Variant] {
        &self.variants
    }
}

/// Judges the combinations of the grid, the last model key fastest. Returns those without faults.
///
/// Every fault is recorded once. It names the first combination that has it, unless all judged ones have it. Without
/// `exhaustive` (the grid is too large), only the first combination is judged.
pub(super) fn expand(
    tree: &mut Node,
    axes: &[GridAxis],
    dimensions: &[GridDimension],
    exhaustive: bool,
    issues: &Issues,
    context: &mut Context,
    hash: &mut JobHash,
) -> JudgedCombinations {
    let keys: Vec<&GridAxis> = axes.iter().filter(|axis| axis.is_model_key()).collect();
    context.half_gap_varies = keys.iter().any(|axis| axis.axis.name() == HALF_GAP);
    let combinations = Combinations::new(axes, dimensions);
    // The number of combinations does not overflow for a grid of an accepted size.
    let all = if exhaustive { combinations.lengths.iter().product() } else { 1 };
    let budget = (MOST_NODES / tree.size()).clamp(*JUDGED.start(), *JUDGED.end());
    let in_part = all > budget;
    let looked_at: Vec<usize> = if in_part {
        chosen(all, budget, &combinations.lengths)
    } else {
        (0..all).collect()
    };
    let distinct = combinations.distinct();
    let others = (in_part && distinct.iter().product::<usize>() <= budget)
        .then(|| combinations.each(distinct));
    // Only the combinations in `looked_at` enter the hash; `others` are resolved, too, but do not enter it.
    let numbers = (looked_at.into_iter().map(|number| (number, true)))
        .chain(others.into_iter().flatten().map(|number| (number, false)));
    let mut variants = BTreeMap::<usize, Variant>::new();
    let mut checked_numbers = HashSet::new();
    let mut faults = Faults::new();
    let (mut checked, mut faulty) = (0, 0);
    for (number, hashed) in numbers {
        let number = combinations.first_like(number);
        if !checked_numbers.insert(number) {
            if let Some(known) = variants.get(&number).filter(|_| hashed) {
                hash.add(known);
            }
            continue;
        }
        let index = combinations.places(number);
        // The number of faults is limited in each combination, and then over all combinations.
        let counted = issues.count();
        let earlier = (issues.found.take(), issues.more.take());
        let resolved = substitute(tree, &keys, &index, issues)
            .then(|| resolve(&Section::root(tree, issues, MANIFEST), context))
            .flatten();
        checked += 1;
        if resolved.is_none() && counted + issues.count() == 0 {
            // A combination that cannot be resolved is an error, even if no section gives a reason.
            Diagnostic::new(DiagnosticKind::Inconsistent, tree.span, "", INCONSISTENT)
                .label("these values")
                .report(issues);
        }
        faulty += usize::from(issues.count() > 0);
        let found = issues.found.replace(earlier.0);
        issues.more.set(earlier.1 + issues.more.get());
        keep_new_faults(issues, found, &mut faults, &keys, &index);
        if let Some(mut resolved) = resolved.filter(|_| issues.count() == 0) {
            if hashed {
                hash.add(&resolved);
            }
            if let Some((_, last)) = variants.last_key_value() {
                resolved.share(last);
            }
            variants.insert(number, resolved);
        }
        // Stop when faults are no longer kept: further combinations could not add any.
        if faulty >= MAX_FAULTY || issues.more.get() > 0 {
            break;
        }
    }
    if in_part {
        hash.in_part(tree);
    }
    let mut sometimes = HashSet::new();
    let mut diagnostics = issues.found.borrow_mut();
    for occurrence in faults.values() {
        if occurrence.combinations == checked {
            diagnostics[occurrence.index].at_point = None
        } else {
            _ = sometimes.insert(occurrence.index)
        }
    }
    // A key that has an effect at some points gets no warning.
    let mut index = 0..;
    diagnostics.retain(|diagnostic| {
        let sometimes = index.next().is_some_and(|index| sometimes.contains(&index));
        diagnostic.kind != DiagnosticKind::NoEffect || !sometimes
    });
    let every = variants.len() == all;
    let (numbers, variants) = variants.into_iter().unzip();
    JudgedCombinations {
        variants,
        numbers: (!every).then_some(numbers),
    }
}

/// Puts the values of the model keys at `index` into the tree. False if a key names an element that does not
/// exist, which is reported.
fn substitute(tree: &mut Node, keys: &[&GridAxis], index: &[usize], issues: &Issues) -> bool {
    let mut fits = true;
    for (key, &i) in keys.iter().zip(index) {
        let name = key.axis.name();
        if let Err(end) = modal_keys::put(tree, name, key.node(i)) {
            let message = format!(
                "the axis `{name}` names an element that does not exist: `{}` {}",
                end.holder, end.why
            );
            let remedy = if modal_keys::is_modal_number_name(name) {
                "indices in brackets count from 1; write the list or the table in the modal file first"
            } else {
                "elements count from 0; write the list in its own table first"
            };
            Diagnostic::new(DiagnosticKind::UnknownAxis, key.key_span, name, message)
                .label("no such element")
                .suggestion(end.near.map(|near| format!("\"{near}\"")))
                .remedy(remedy)
                .report(issues);
            fits = false;
        }
    }
    fits
}

/// Records the faults found in a combination, except those that an earlier combination has. Faults in the manifest, or
/// in a modal file that an axis changes, get the values of this combination.
fn keep_new_faults(
    issues: &Issues,
    found: Vec<Diagnostic>,
    faults: &mut Faults,
    keys: &[&GridAxis],
    index: &[usize],
) {
    let place = keys
        .iter()
        .zip(index)
        .map(|(key, &i)| {
            let value = schema::number(key.axis.values.get(i));
            format!("{} = {value}", key.axis.name())
        })
        .collect::<Vec<_>>()
        .join(", ");
    let of_file = (keys.iter()).any(|key| modal_keys::is_modal_number_name(key.axis.name()));
    let mut seen_here = HashSet::new();
    for diagnostic in found {
        let identity = (diagnostic.kind, diagnostic.span, diagnostic.key.clone());
        if !seen_here.insert(identity.clone()) {
            continue;
        }
        if let Some(occurrence) = faults.get_mut(&identity) {
            occurrence.combinations += 1;
            continue;
        }
        let own_file = (diagnostic.span.source == 0 || of_file)
            && diagnostic.kind != DiagnosticKind::Unreadable;
        let diagnostic = if own_file && !keys.is_empty() {
            diagnostic.at_point(&place)
        } else {
            diagnostic
        };
        let occurrence = Occurrence {
            index: issues.found.borrow().len(),
            combinations: 1,
        };
        issues.push(diagnostic);
        // A full list drops a warning and counts an error.
        if issues.found.borrow().len() > occurrence.index {
            faults.insert(identity, occurrence);
        }
    }
}

/// All combinations of values of the model keys, the last key fastest: the judged ones, and the others computed on
/// demand.
#[derive(Debug, Clone)]
pub(super) struct Expansion {
    judged: Arc<JudgedCombinations>,
    between: PointResolver,
    /// Recently resolved combinations that were not judged, by number.
    recent_variants: Arc<Mutex<HashMap<usize, Variant>>>,
}

impl Expansion {
    /// Requires at least one judged combination, and none with a fault.
    pub fn new(judged: JudgedCombinations, between: PointResolver) -> Self {
        Self {
            judged: Arc::new(judged),
            between,
            recent_variants: Arc::default(),
        }
    }

    /// The variants of the judged combinations.
    pub fn judged(&self) -> &[Variant] {
        &self.judged.variants
    }

    /// The index of a combination among the judged ones. If it was not judged, the error is the index of the
    /// last judged combination before it.
    fn place(&self, number: usize) -> Result<usize, usize> {
        let judged = &*self.judged;
        let Some(numbers) = &judged.numbers else {
            return Ok(number);
        };
        let place = numbers.binary_search(&self.between.combinations().first_like(number));
        place.map_err(|place| place.saturating_sub(1))
    }

    /// The variant of a combination if it was judged, otherwise that of a judged combination near it.
    /// Resolves nothing.
    pub fn near(&self, number: usize) -> &Variant {
        match self.place(number) {
            Ok(place) | Err(place) => &self.judged.variants[place],
        }
    }

    /// The variant of a combination. If its values are inconsistent: a judged variant near it, with the
    /// reason.
    pub fn get(&self, number: usize) -> (Cow<'_, Variant>, Option<String>) {
        let near = match self.place(number) {
            Ok(place) => return (Cow::Borrowed(&self.judged.variants[place]), None),
            Err(place) => &self.judged.variants[place],
        };
        let number = self.between.combinations().first_like(number);
        let lock_variants = || {
            self.recent_variants
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        if let Some(known) = lock_variants().get(&number) {
            return (Cow::Owned(known.clone()), None);
        }
        let values = self.between.values(number);
        match self.between.combined(&values, Vec::new(), Some(near)) {
            Ok(variant) => {
                let mut variants = lock_variants();
                if variants.len() >= MOST_KEPT {
                    variants.clear();
                }
                variants.insert(number, variant.clone());
                (Cow::Owned(variant), None)
            }
            Err(fault) => (Cow::Borrowed(near), Some(fault)),
        }
    }
}
