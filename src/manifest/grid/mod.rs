//! `[grid]`: its axes and their values. An axis is `load`, `speed` or a quoted model key.

mod grid_axis;
mod order;
mod refine;
mod values;

use super::axis::AxisKey;
use super::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use super::reader::Section;
use super::schema::{self, Key, Kind, MANIFEST, VARIABLE_TABLES};
use super::spec::{Axis, Carried, Refine};
use super::tree::{Entry, Value};
use crate::units::Dimension;
pub(super) use grid_axis::GridAxis;
pub(super) use order::is_carried;
use values::{AxisReader, MAX_POINTS};

/// Axes named where there are too many points.
const MOST_FACTORS: usize = 8;

/// The axes of a grid, slowest first.
#[derive(Debug, Default)]
pub(super) struct Axes {
    pub valid: Vec<GridAxis>,
    /// Names of the axes that have faults or are missing.
    pub faulty: Vec<String>,
    /// Along which of the valid axes the state is carried, and how; none where points are
    /// independent.
    pub carried: Option<Carried>,
    /// How the grid is refined, where it is; values are then those of the finest grid.
    pub refine: Option<Refine>,
    /// Whether there are more points than accepted.
    pub too_large: bool,
}

/// Reads the grid. Model keys come first, by name, then load, then speed: points that
/// share a structure lie together, and the order of the text is of no effect.
pub(super) fn read(root: &Section, issues: &mut Issues) -> Axes {
    let mut axes = Axes::default();
    let Some(section) = root.required_child(issues, "grid") else {
        axes.faulty.extend(["load".to_owned(), "speed".to_owned()]);
        return axes;
    };
    for name in ["load", "speed"] {
        if !section.has(name) {
            section.missing(issues, name);
            axes.faulty.push(name.to_owned());
        }
    }
    for entry in section
        .entries()
        .iter()
        .filter(|entry| !matches!(entry.key.as_str(), "order" | "along" | "refine"))
    {
        match read_axis(issues, entry) {
            Some(axis) => axes.valid.push(axis),
            None => axes.faulty.push(entry.key.clone()),
        }
    }
    axes.valid.sort_by(|a, b| a.axis.key.cmp(&b.axis.key));
    axes.carried = order::read(&section, issues, &axes.valid, &axes.faulty);
    let whole = axes.faulty.is_empty();
    axes.refine = refine::read(root, &section, issues, &mut axes.valid, whole);
    let directions = axes.carried.as_ref().map_or(1, |c| c.directions.len());
    axes.too_large = !size_is_accepted(issues, &section, &axes.valid, directions);
    axes
}

fn size_is_accepted(
    issues: &mut Issues,
    section: &Section,
    axes: &[GridAxis],
    directions: usize,
) -> bool {
    let lengths = || {
        let axes = axes.iter().map(|axis| axis.axis.values.len() as u64);
        axes.chain([directions as u64])
    };
    let points = lengths().try_fold(1u64, |total, n| total.checked_mul(n));
    if points.is_some_and(|points| points <= MAX_POINTS) {
        return true;
    }
    let shown = axes.iter().take(MOST_FACTORS);
    let mut factors: Vec<_> = shown
        .map(|a| format!("{} {}", a.axis.values.len(), a.axis.name()))
        .collect();
    if axes.len() > MOST_FACTORS {
        factors.push(format!("{} more axes", axes.len() - MOST_FACTORS));
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
    issues.push(
        Diagnostic::new(
            DiagnosticKind::GridTooLarge,
            section.span,
            "grid",
            format!("the grid has {count} points"),
        )
        .label(factors.join(" x "))
        .accepted(format!("at most {MAX_POINTS} points"))
        .remedy("use coarser axes, or split the grid over several manifests"),
    );
    false
}

fn read_axis(issues: &mut Issues, entry: &Entry) -> Option<GridAxis> {
    let name = entry.key.as_str();
    let path = match name.contains('.') {
        true => format!("grid.\"{name}\""),
        false => format!("grid.{name}"),
    };
    let spec = axis_key(issues, entry, &path)?;
    let mut reader = AxisReader {
        spec,
        path: &path,
        dimension: match spec.kind {
            Kind::Quantity(dimension) | Kind::Axis(dimension) => Some(dimension),
            Kind::ContactDamping => None,
            _ => Some(Dimension::Ratio),
        },
    };
    let (values, spans) = reader.read(issues, &entry.node)?;
    let dimension = reader.dimension.unwrap_or(Dimension::Ratio);
    Some(GridAxis {
        axis: Axis {
            key: AxisKey::of(name),
            unit: dimension.unit().to_owned(),
            values,
        },
        key_span: entry.key_span,
        dimension,
        spans,
    })
}

/// The schema's entry for what an axis varies.
fn axis_key(issues: &mut Issues, entry: &Entry, path: &str) -> Option<&'static Key> {
    let name = entry.key.as_str();
    if !AxisKey::of(name).is_model_key() {
        return schema::find(MANIFEST, path);
    }
    let table = name.split('.').next().unwrap_or_default();
    let known = schema::find(MANIFEST, name).filter(|_| VARIABLE_TABLES.contains(&table));
    let spec = known.filter(|spec| spec.can_be_axis());
    if spec.is_none() {
        issues.push_with(|| no_axis(entry, path, known.map(|known| known.kind)));
    }
    spec
}

/// Why an entry of `[grid]` is no axis.
fn no_axis(entry: &Entry, path: &str, kind: Option<Kind>) -> Diagnostic {
    let name = entry.key.as_str();
    let fault = |message: String| {
        Diagnostic::new(DiagnosticKind::UnknownAxis, entry.key_span, path, message).accepted(
            "load, speed, or a quoted model key that takes a number, such as \"mesh.half_gap\"",
        )
    };
    match kind {
        Some(Kind::List(_)) => fault(format!("`{name}` is a list; an axis varies one number"))
            .label("a list")
            .remedy(format!("name an element, \"{name}.0\", or a key below it")),
        Some(Kind::Table) if !name.contains('.') => {
            let inner = match &entry.node.value {
                Value::Table(entries) => entries.first().map(|inner| inner.key.as_str()),
                _ => None,
            };
            let full = format!("\"{name}.{}\"", inner.unwrap_or("key"));
            fault(format!("`{name}` is a table, not an axis"))
                .label("a table")
                .remedy(format!("put the whole key in quotes: {full} = ..."))
        }
        Some(_) => fault(format!("`{name}` takes no number, so it cannot be an axis"))
            .label("takes no number")
            .remedy("write one manifest for each of its values"),
        None if schema::find(MANIFEST, name).is_some() => {
            fault(format!("`{name}` cannot be an axis"))
                .label("not a model key")
                .remedy(format!("axes are keys of {}", VARIABLE_TABLES.join(", ")))
        }
        None => fault(format!("the axis `{name}` names no model key"))
            .label("unknown")
            .suggestion(nearest_axis(name)),
    }
}

/// The nearest thing that can be an axis: by its whole name, or by its last part.
fn nearest_axis(name: &str) -> Option<String> {
    let paths: Vec<&str> = ["load", "speed"]
        .into_iter()
        .chain(
            schema::all(MANIFEST)
                .filter(|key| {
                    matches!(
                        key.kind,
                        Kind::Quantity(_) | Kind::Integer | Kind::ContactDamping
                    )
                })
                .map(|key| key.path)
                .filter(|path| !path.contains(['*', '<'])),
        )
        .collect();
    schema::nearest_path(name, &paths).map(|near| match near.contains('.') {
        true => format!("\"{near}\""),
        false => near.to_owned(),
    })
}
