//! What the points of a grid are made of: combinations of model-key values are put into the tree
//! and resolved like text; load and speed vary inside, where nothing needs resolving again.
//!
//! Every combination is judged, as long as that takes a fraction of a second. Of more, some are:
//! the corners of the grid and others evenly between. Rows of a list with the same values of the model
//! keys are one combination. The range of each key by itself was checked
//! for all values where they stand; what does not fit together shows when its point is asked for.

use super::axis::AxisKey;
use super::combinations::{Combinations, chosen};
use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use super::expression::Expression;
use super::grid::GridAxis;
use super::grid_dimension::GridDimension;
use super::hash::JobHash;
use super::modal_keys;
use super::modal_tree::ModalFile;
use super::reader::Section;
use super::schema::{self, MANIFEST};
use super::sections::{Context, resolve};
use super::spec::{PointSpec, Variant};
use super::tree::Node;
use crate::shaft::Housing;
use crate::units::Dimension;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Combinations with faults after which no more are looked at.
const MAX_FAULTY: usize = 1000;

/// What is said of values that make no drive where no section says why.
const NO_DRIVE: &str = "the values do not fit together";

/// How often a fault was seen.
#[derive(Debug)]
struct Occurrence {
    index: usize,
    combinations: usize,
}

type Faults = HashMap<(DiagnosticKind, Span, String), Occurrence>;

/// Nodes of the tree that may be resolved, over all combinations that are judged: a tenth of a
/// second.
const MOST_NODES: usize = 500_000;

/// Combinations judged of a grid with more, by the size of its text.
const JUDGED: std::ops::RangeInclusive<usize> = 4..=10_000;

/// Resolved combinations that are kept beside those that were judged: some megabytes.
const MOST_KEPT: usize = 4096;

/// Combinations of values of the model keys, the last key fastest, that were judged.
#[derive(Debug)]
pub(super) struct Judged {
    variants: Vec<Variant>,
    /// Their numbers, where these do not count them all.
    numbers: Option<Vec<usize>>,
}

impl Judged {
    /// Those that have no fault.
    pub fn variants(&self) -> &[Variant] {
        &self.variants
    }
}

/// Resolves the grid, the last model key fastest.
///
/// Every fault is recorded once, with the first combination at which it shows when it
/// does not show at all of them. Unless `exhaustive` (the grid is too large) only the first
/// combination is looked at.
pub(super) fn expand(
    tree: &mut Node,
    axes: &[GridAxis],
    dimensions: &[GridDimension],
    exhaustive: bool,
    issues: &mut Issues,
    context: &mut Context,
    hash: &mut JobHash,
) -> Judged {
    let keys: Vec<&GridAxis> = axes.iter().filter(|axis| axis.is_model_key()).collect();
    let combinations = Combinations::new(axes, dimensions);
    // A grid of an accepted size has countable combinations.
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
    // What is hashed does not depend on which rows are alike.
    let numbers = (looked_at.into_iter().map(|number| (number, true)))
        .chain(others.into_iter().flatten().map(|number| (number, false)));
    let mut variants = BTreeMap::<usize, Variant>::new();
    let mut looked = HashSet::new();
    let mut faults = Faults::new();
    let (mut tried, mut faulty) = (0, 0);
    for (number, hashed) in numbers {
        let number = combinations.first_like(number);
        if !looked.insert(number) {
            if let Some(known) = variants.get(&number).filter(|_| hashed) {
                hash.resolved(known);
            }
            continue;
        }
        let index = combinations.places(number);
        let before = issues.found.len();
        let counted = issues.count();
        let resolved = substitute(tree, &keys, &index, issues)
            .then(|| resolve(&Section::root(tree, MANIFEST), issues, context))
            .flatten();
        tried += 1;
        if resolved.is_none() && issues.count() == 0 {
            // What resolves to nothing is no job, even where no section says why.
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Inconsistent,
                    tree.span,
                    "",
                    NO_DRIVE.to_owned(),
                )
                .label("these values"),
            );
        }
        faulty += usize::from(issues.count() > counted);
        sift(issues, before, &mut faults, &keys, &index);
        if let Some(mut resolved) = resolved.filter(|_| issues.count() == 0) {
            if hashed {
                hash.resolved(&resolved);
            }
            if let Some((_, last)) = variants.last_key_value() {
                resolved.share(last);
            }
            variants.insert(number, resolved);
        }
        // With more faults than are kept, those of further combinations tell nobody anything.
        if faulty >= MAX_FAULTY || issues.more > 0 {
            break;
        }
    }
    if in_part {
        hash.in_part(tree);
    }
    let mut sometimes = HashSet::new();
    for occurrence in faults.values() {
        if occurrence.combinations == tried {
            issues.found[occurrence.index].at_point = None
        } else {
            _ = sometimes.insert(occurrence.index)
        }
    }
    // A key that has an effect at some points has an effect.
    let mut index = 0..;
    (issues.found).retain(|found| {
        let sometimes = index.next().is_some_and(|index| sometimes.contains(&index));
        found.kind != DiagnosticKind::NoEffect || !sometimes
    });
    let every = variants.len() == all;
    let (numbers, variants) = variants.into_iter().unzip();
    Judged {
        variants,
        numbers: (!every).then_some(numbers),
    }
}

/// Puts one value of every key axis into the tree; false when one has no place there.
fn substitute(tree: &mut Node, keys: &[&GridAxis], index: &[usize], issues: &mut Issues) -> bool {
    let mut fits = true;
    for (key, &i) in keys.iter().zip(index) {
        let name = key.axis.name();
        if let Err(end) = modal_keys::put(tree, name, key.node(i)) {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::UnknownAxis,
                    key.key_span,
                    name,
                    format!(
                        "the axis `{name}` names an element that does not exist: `{}` {}",
                        end.holder, end.why
                    ),
                )
                .label("no such element")
                .suggestion(end.near.map(|near| format!("\"{near}\"")))
                .remedy(if modal_keys::is_name(name) {
                    "indices in brackets count from 1; write the list or the table in the modal file first"
                } else {
                    "elements count from 0; write the list in its own table first"
                }),
            );
            fits = false;
        }
    }
    fits
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
        .map(|(key, &i)| {
            let value = schema::number(key.axis.values.get(i));
            format!("{} = {value}", key.axis.name())
        })
        .collect::<Vec<_>>()
        .join(", ");
    let of_file = (keys.iter()).any(|key| modal_keys::is_name(key.axis.name()));
    let mut seen_here = HashSet::new();
    for diagnostic in issues.found.split_off(before) {
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
        faults.insert(
            identity,
            Occurrence {
                index: issues.found.len(),
                combinations: 1,
            },
        );
        issues.push(diagnostic);
    }
}

/// The text of a job, kept to resolve combinations that were not judged, and points that the
/// grid does not have.
#[derive(Debug, Clone)]
pub struct PointResolver(Arc<Kept>);

#[derive(Debug)]
struct Kept {
    tree: Node,
    keys: Vec<GridAxis>,
    combinations: Combinations,
    /// Whether the points have a torque: then that is what is kept where the rated torque changes.
    torque: bool,
    base_dir: PathBuf,
    modal_files: HashMap<PathBuf, Option<Arc<ModalFile>>>,
    /// The tree of the modal file with the values that commands give it.
    modal_tree: Option<Node>,
    /// Whether axes or commands change that tree.
    modal_changed: bool,
    /// Axes that others give, those that others need first.
    derived: Vec<(AxisKey, Dimension, Expression)>,
    housings: HashMap<PathBuf, Option<Arc<Housing>>>,
}

impl PointResolver {
    /// `axes` has the model keys first, as [`expand`] wants them.
    pub(super) fn new(
        mut tree: Node,
        axes: Vec<GridAxis>,
        dimensions: &[GridDimension],
        context: Context,
    ) -> Self {
        // The values of the axes stand there: of the grid a point needs the order only.
        tree.retain("grid", |key| matches!(key, "order" | "along"));
        let changed = modal_keys::detach(&mut tree);
        let file = || context.modal_files.values().flatten().next();
        Self(Arc::new(Kept {
            tree,
            modal_changed: changed.is_some(),
            modal_tree: changed.or_else(|| file().map(|file| file.tree.clone())),
            combinations: Combinations::new(&axes, dimensions),
            torque: axes.iter().any(|axis| axis.axis.key == AxisKey::Torque),
            keys: axes.into_iter().filter(GridAxis::is_model_key).collect(),
            base_dir: context.base_dir.to_path_buf(),
            modal_files: context.modal_files,
            housings: context.housings,
            derived: Vec::new(),
        }))
    }

    /// The same with axes that expressions give.
    pub(super) fn deriving(self, expressions: Vec<(String, Expression)>) -> Self {
        let own = |(name, expression): (String, Expression)| {
            let of_axis = |key: &&GridAxis| key.axis.name() == name;
            let dimension = self.0.keys.iter().find(of_axis).map(GridAxis::dimension);
            let dimension = dimension.unwrap_or(Dimension::Ratio);
            (AxisKey::of(&name), dimension, expression)
        };
        let derived = expressions.into_iter().map(own).collect();
        let mut kept = self.0;
        if let Some(kept) = Arc::get_mut(&mut kept) {
            kept.derived = derived;
        }
        Self(kept)
    }

    /// Axes that others give, and what they measure; those that others need first.
    pub(super) fn derived(&self) -> &[(AxisKey, Dimension, Expression)] {
        &self.0.derived
    }

    /// Whether an expression gives an axis.
    pub fn is_derived(&self, name: &str) -> bool {
        self.0.derived.iter().any(|(own, ..)| own.name() == name)
    }

    /// Gives a point the mesh and the excitation that its axis values stand for. None where
    /// the manifest would be faulty with these values.
    pub(super) fn resolve(&self, point: &mut PointSpec) -> Option<()> {
        let resolved = self.combine(&point.axis_values, None).ok()?;
        if self.0.modal_changed {
            point.model = resolved.model;
        }
        point.mesh = resolved.mesh;
        point.excitation = resolved.excitation;
        Some(())
    }

    /// What stands in the manifest at a dotted path,
    /// or in the modal file under a name of its own.
    pub(super) fn node(&self, path: &str) -> Option<&Node> {
        if !modal_keys::is_name(path) {
            return self.0.tree.at(path);
        }
        let file = self.0.modal_tree.as_ref()?;
        file.at(&modal_keys::path(file, path).ok()?.join("."))
    }

    /// Whether a key has a place in the manifest, or in the modal file where it names a number of that.
    pub(super) fn has_place(&self, name: &str) -> bool {
        let file = self.0.modal_tree.as_ref();
        !modal_keys::is_name(name) || file.is_some_and(|file| modal_keys::path(file, name).is_ok())
    }

    /// Whether the points of the grid have a torque instead of a load.
    pub(super) fn has_torque(&self) -> bool {
        self.0.torque
    }

    /// The place of a model key among the axes.
    pub(super) fn axis(&self, name: &str) -> Option<usize> {
        self.0.keys.iter().position(|key| key.axis.name() == name)
    }

    /// What a point's values of the model keys stand for with some more nodes in the tree; a
    /// sentence where they make no drive.
    pub(super) fn resolved_with(
        &self,
        point: &PointSpec,
        nodes: Vec<(&str, Node)>,
    ) -> Result<Variant, String> {
        let like = Variant {
            model: point.model.clone(),
            mesh: point.mesh.clone(),
            excitation: point.excitation.clone(),
            run: point.run.clone(),
            analyses: point.analyses.clone(),
        };
        self.combined(&point.axis_values, nodes, Some(&like))
    }

    /// What some values of the model keys stand for, sharing with `like` what is equal; a
    /// sentence where they make no drive.
    fn combine(&self, values: &[f64], like: Option<&Variant>) -> Result<Variant, String> {
        self.combined(values, Vec::new(), like)
    }

    fn combined(
        &self,
        values: &[f64],
        nodes: Vec<(&str, Node)>,
        like: Option<&Variant>,
    ) -> Result<Variant, String> {
        let kept = &*self.0;
        let mut tree = kept.tree.clone();
        let samples = kept.keys.iter().zip(values);
        let samples = samples.map(|(key, value)| (key.axis.name(), key.sample(*value)));
        let of_file = nodes.iter().any(|(name, _)| modal_keys::is_name(name));
        if let Some(file) = (kept.modal_tree.as_ref()).filter(|_| kept.modal_changed || of_file) {
            modal_keys::attach(&mut tree, file.clone());
        }
        for (name, node) in samples.chain(nodes) {
            if modal_keys::put(&mut tree, name, node).is_err() {
                return Err(format!("`{name}` is neither a key nor an axis"));
            }
        }
        let mut issues = Issues::default();
        let mut context = Context::new(&kept.base_dir);
        context.modal_files.clone_from(&kept.modal_files);
        context.housings.clone_from(&kept.housings);
        context.last_drive = like.map(|like| like.model.source.clone());
        let resolved = resolve(&Section::root(&tree, MANIFEST), &mut issues, &mut context);
        let fault = issues.errors().next();
        match (resolved, fault) {
            (Some(mut resolved), None) => {
                if let Some(like) = like {
                    resolved.share(like);
                }
                Ok(resolved)
            }
            (_, Some(fault)) => Err(fault.message.clone()),
            (None, None) => Err(NO_DRIVE.to_owned()),
        }
    }
}

/// All combinations of values of the model keys, the last key fastest: those that were judged,
/// and the others made when they are asked for.
#[derive(Debug, Clone)]
pub(super) struct Expansion {
    judged: Arc<Judged>,
    between: PointResolver,
    /// Of the others, those made lately, by their number.
    made: Arc<Mutex<HashMap<usize, Variant>>>,
}

impl Expansion {
    /// At least one combination was judged, and none has a fault.
    pub fn new(judged: Judged, between: PointResolver) -> Self {
        Self {
            judged: Arc::new(judged),
            between,
            made: Arc::default(),
        }
    }

    /// Those that were judged.
    pub fn judged(&self) -> &[Variant] {
        &self.judged.variants
    }

    /// Where a combination stands among those that were judged, or else the last one before it.
    fn place(&self, number: usize) -> Result<usize, usize> {
        let judged = &*self.judged;
        let Some(numbers) = &judged.numbers else {
            return Ok(number);
        };
        let place = numbers.binary_search(&self.between.0.combinations.first_like(number));
        place.map_err(|place| place.saturating_sub(1))
    }

    /// A combination, or one beside it, without resolving anything.
    pub fn near(&self, number: usize) -> &Variant {
        match self.place(number) {
            Ok(place) | Err(place) => &self.judged.variants[place],
        }
    }

    /// A combination, and why its values make no drive, where they do not: then it is another.
    pub fn get(&self, number: usize) -> (Cow<'_, Variant>, Option<String>) {
        let near = match self.place(number) {
            Ok(place) => return (Cow::Borrowed(&self.judged.variants[place]), None),
            Err(place) => &self.judged.variants[place],
        };
        let Kept {
            keys, combinations, ..
        } = &*self.between.0;
        let number = combinations.first_like(number);
        let made = || self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = made().get(&number) {
            return (Cow::Owned(known.clone()), None);
        }
        let values = keys.iter().zip(combinations.places(number));
        let values: Vec<f64> = values.map(|(key, i)| key.axis.values.get(i)).collect();
        match self.between.combine(&values, Some(near)) {
            Ok(variant) => {
                let mut made = made();
                if made.len() >= MOST_KEPT {
                    made.clear();
                }
                made.insert(number, variant.clone());
                (Cow::Owned(variant), None)
            }
            Err(fault) => (Cow::Borrowed(near), Some(fault)),
        }
    }
}
