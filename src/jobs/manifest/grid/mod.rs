//! `[grid]`: its axes and their values. An axis is `load` or `torque`, `speed` or a quoted model key. Four
//! kinds of axes advance in step: columns of a list of points, tied axes, distributions, and axes given by
//! expressions together with the axes in these.

mod axis_key;
mod expressions;
mod grid_axis;
mod list;
mod order;
mod refine;
mod samples;
mod tied;
mod values;

use super::axis::AxisKey;
use super::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use super::expression::Expression;
use super::grid_dimension::GridDimension;
use super::reader::Section;
use super::spec::{Axis, Carried, Refine, Samples};
use super::tree::{Entry, Value};
use crate::units::Dimension;
use axis_key::path_of;
pub(super) use grid_axis::GridAxis;
pub(super) use order::is_carried;
use samples::{Drawn, DrawnAxes};
use std::path::Path;
use values::{AxisReader, MAX_POINTS};

/// Number of axes that the message about too many points names.
const MOST_FACTORS: usize = 8;

/// Keys of `[grid]` that are not axes.
const NOT_AXES: [&str; 8] = [
    "order",
    "along",
    "displacement",
    "refine",
    "tied",
    "points",
    "samples",
    "design",
];

/// The axes of a grid, slowest first.
#[derive(Debug, Default)]
pub(super) struct Axes {
    pub valid: Vec<GridAxis>,
    /// The dimensions of the grid.
    pub dimensions: Vec<GridDimension>,
    /// Names of axes that are faulty or missing.
    pub faulty: Vec<String>,
    /// The valid axis along which the state is carried, and how; `None` if points are independent.
    pub carried: Option<Carried>,
    /// How the grid is refined, if it is; values are then those of the finest grid.
    pub refine: Option<Refine>,
    /// How values are drawn; `None` without distributions.
    pub samples: Option<Samples>,
    /// Expressions of axes by name, in the order of their evaluation.
    pub expressions: Vec<(String, Expression)>,
    /// Whether a list of points, which may have any key as a column, cannot be read.
    pub unknown: bool,
    /// Whether there are more points than accepted.
    pub too_large: bool,
}

/// Reads the grid. Relative paths in it start at `base_dir`, and samples depend on `seed`. Model keys come first, by
/// name, then load or torque, then speed. So points that share a structure are adjacent, and the order of the text has
/// no effect.
pub(super) fn read(root: &Section, base_dir: &Path, seed: u64) -> Axes {
    let mut axes = Axes::default();
    let Some(section) = root.required_child("grid") else {
        axes.faulty.extend(["load".to_owned(), "speed".to_owned()]);
        return axes;
    };
    let listed = list::read(&section, base_dir);
    let columns = listed.iter().flat_map(|list| &list.axes);
    let mut names: Vec<String> = columns.map(|axis| axis.axis.name().to_owned()).collect();
    names.extend(listed.iter().flat_map(|list| list.faulty.iter().cloned()));
    axes.unknown = listed.as_ref().is_some_and(|list| list.unknown);
    let oscillator = is_without_mesh(root);
    find_missing(&section, &names, oscillator, &mut axes);
    let ties = tied::read(&section);
    let is_tied = |name: &str| {
        ties.iter()
            .any(|tie| tie.names.iter().any(|tied_name| tied_name == name))
    };
    let (mut drawn, mut derived) = (Vec::new(), Vec::new());
    for entry in (section.entries().iter()).filter(|entry| !NOT_AXES.contains(&entry.key.as_str()))
    {
        if names.contains(&entry.key) {
            root.issues.push(twice(entry));
            continue;
        }
        let tied = is_tied(&entry.key);
        let read = if expressions::is_expression(entry) {
            expressions::read(root.issues, entry).map(|new_axis| derived.push(new_axis))
        } else if samples::is_distribution(&entry.node) {
            samples::read(root.issues, entry, tied, base_dir).map(|new_axis| drawn.push(new_axis))
        } else {
            read_axis(root.issues, entry, tied).map(|axis| axes.valid.push(axis))
        };
        if read.is_none() {
            axes.faulty.push(entry.key.clone());
        }
    }
    let first = axes.valid.len();
    let expressions: Vec<&str> = derived.iter().map(expressions::Pending::name).collect();
    let in_step = (&names[..], &expressions[..]);
    let mut groups = tied::places(&ties, &axes.valid, in_step, &axes.faulty, root.issues);
    if let Some(list) = listed {
        axes.faulty.extend(list.faulty);
        groups.push((first..first + list.axes.len()).collect());
        axes.valid.extend(list.axes);
    }
    let first_drawn = axes.valid.len();
    if let Some(drawn) = sample_axes(&section, drawn, &mut axes, seed) {
        groups.push((first_drawn..first_drawn + drawn.axes.len()).collect());
        axes.valid.extend(drawn.axes);
        axes.samples = Some(drawn.samples);
    }
    let (valid, faulty) = (&mut axes.valid, &mut axes.faulty);
    axes.expressions = expressions::add(root.issues, derived, valid, &mut groups, faulty);
    load_and_torque(&axes.valid, root.issues);
    // Sort the axes; the groups then get the new indices of their axes.
    let mut order: Vec<usize> = (0..axes.valid.len()).collect();
    order.sort_by(|&a, &b| {
        axes.valid[a]
            .axis
            .key
            .rank()
            .cmp(&axes.valid[b].axis.key.rank())
    });
    let place = |before: &usize| order.iter().position(|known| known == before);
    let groups: Vec<Vec<usize>> = (groups.iter())
        .map(|group| group.iter().filter_map(&place).collect())
        .filter(|group: &Vec<usize>| !group.is_empty())
        .collect();
    axes.valid
        .sort_by(|a, b| a.axis.key.rank().cmp(&b.axis.key.rank()));
    let whole = axes.faulty.is_empty();
    axes.refine = refine::read(root, &section, &mut axes.valid, &groups, whole);
    let plain: Vec<&Axis> = axes.valid.iter().map(|axis| &axis.axis).collect();
    axes.dimensions = GridDimension::all(&plain, &groups);
    if let Some(samples) = &mut axes.samples {
        // Drawn axes keep their order when the axes are sorted.
        for (axis, _) in &mut samples.axes {
            *axis = place(&(first_drawn + *axis)).unwrap_or_default();
        }
        let own = GridDimension::of(&axes.dimensions, samples.axes[0].0);
        axes.dimensions[own].sampled = true;
    }
    axes.carried = order::read(&section, &axes.valid, &axes.dimensions, &axes.faulty);
    let directions = axes.carried.as_ref().map_or(1, |c| c.directions.len());
    axes.too_large = !size_is_accepted(&section, &axes, directions);
    axes
}

/// Records missing axes, and adds the load 0 of an oscillator; `names` are columns of a list of points.
fn find_missing(section: &Section, names: &[String], oscillator: bool, axes: &mut Axes) {
    let has = |name: &str| section.has(name) || names.iter().any(|known| known == name);
    // An unreadable list may have any column.
    if axes.unknown {
        let absent = ["load", "torque", "speed"]
            .into_iter()
            .filter(|name| !has(name));
        axes.faulty.extend(absent.map(str::to_owned));
        return;
    }
    let mut load = has("load") || has("torque");
    if oscillator && !load {
        // An oscillator has no load by default.
        axes.valid
            .push(GridAxis::single(AxisKey::Load, 0.0, section.span));
        load = true;
    }
    for (name, has) in [("load", load), ("speed", has("speed"))] {
        if !has {
            section.missing(name);
            axes.faulty.push(name.to_owned());
        }
    }
}

/// Whether a manifest has a modal file but no `[mesh]`.
fn is_without_mesh(root: &Section) -> bool {
    let model = root
        .entry("model")
        .and_then(|model| model.node.entry("kind"));
    let modal =
        matches!(model.map(|kind| &kind.node.value), Some(Value::Text(kind)) if kind == "modal");
    modal && !root.has("mesh")
}

/// The axes that are distributions, with their values; axes without values are faulty.
fn sample_axes(
    section: &Section,
    drawn: Vec<Drawn>,
    axes: &mut Axes,
    seed: u64,
) -> Option<DrawnAxes> {
    let names: Vec<String> = drawn.iter().map(|axis| axis.name().to_owned()).collect();
    let whole = axes.faulty.is_empty();
    let drawn = samples::draw(section, drawn, whole, seed);
    if drawn.is_none() {
        axes.faulty.extend(names);
    }
    drawn
}

/// The fault of an axis that is also a column of the list of points.
fn twice(entry: &Entry) -> Diagnostic {
    let name = &entry.key;
    Diagnostic::new(
        DiagnosticKind::DuplicateKey,
        entry.key_span,
        &path_of(name),
        format!("`{name}` is also a column of `grid.points`"),
    )
    .label("second time")
    .remedy("keep one of the two")
}

/// Records a grid with both load and torque.
fn load_and_torque(axes: &[GridAxis], issues: &Issues) {
    let of = |key: AxisKey| axes.iter().find(|axis| axis.axis.key == key);
    if let (Some(_), Some(torque)) = (of(AxisKey::Load), of(AxisKey::Torque)) {
        let message = "`load` and `torque` both give the mean load";
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            torque.key_span,
            "grid.torque",
            message,
        )
        .label("second time")
        .remedy("keep `load`, a fraction of the rated torque, or `torque`, in N m")
        .report(issues);
    }
}

fn size_is_accepted(section: &Section, axes: &Axes, directions: usize) -> bool {
    let lengths = || {
        let lengths = axes
            .dimensions
            .iter()
            .map(|dimension| dimension.length as u64);
        lengths.chain([directions as u64])
    };
    let points = lengths().try_fold(1u64, |total, n| total.checked_mul(n));
    if points.is_some_and(|points| points <= MAX_POINTS) {
        return true;
    }
    let all = &axes.dimensions;
    let shown = all.iter().take(MOST_FACTORS);
    let mut factors: Vec<_> = shown
        .map(|dimension| {
            format!(
                "{} {}",
                dimension.length,
                axes.valid[dimension.axes[0]].axis.name()
            )
        })
        .collect();
    if all.len() > MOST_FACTORS {
        factors.push(format!("{} more axes", all.len() - MOST_FACTORS));
    }
    if directions > 1 {
        factors.push(format!("{directions} directions"));
    }
    let count = match points {
        Some(points) => points.to_string(),
        None => {
            let tens: f64 = lengths().map(|n| (n as f64).log10()).sum();
            format!("about 10^{tens:.0}")
        }
    };
    let message = format!("the grid has {count} points");
    section
        .whole_fault(DiagnosticKind::GridTooLarge, message)
        .label(factors.join(" x "))
        .accepted(format!("at most {MAX_POINTS} points"))
        .remedy("use coarser axes, or split the grid over several manifests")
        .report(section.issues);
    false
}

/// Reads an axis; values of a tied one may repeat.
fn read_axis(issues: &Issues, entry: &Entry, tied: bool) -> Option<GridAxis> {
    let name = entry.key.as_str();
    let path = path_of(name);
    let mut reader = AxisReader::of(issues, entry, &path)?;
    let values = reader.read(&entry.node, tied)?;
    let dimension = reader.dimension.unwrap_or(Dimension::Ratio);
    let key = AxisKey::of(name);
    Some(GridAxis::new(key, entry.key_span, dimension, values))
}
