//! Axes that are distributions: their text, and the values that are drawn.

use super::axis_key::path_of;
use super::grid_axis::GridAxis;
use super::values::{AxisReader, Spans};
use crate::manifest::axis::{AxisKey, AxisValues};
use crate::manifest::columns;
use crate::manifest::csv::ListOf;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use crate::manifest::distribution::{Distribution, Law};
use crate::manifest::reader::{Section, all_or_none};
use crate::manifest::schema::{self, Key, Kind, quoted};
use crate::manifest::spec::{Design, Samples};
use crate::manifest::tree::{Entry, Node, Value};
use crate::units::Dimension;
use std::path::Path;

/// Names of laws; a distribution has exactly one.
const LAWS: [&str; 4] = ["normal", "lognormal", "uniform", "empirical"];

const TRUNCATE: &str = "truncate";

/// The accepted forms of a distribution.
const ACCEPTED: &str = "{ normal = [mean, standard deviation] }, { lognormal = [median, standard deviation of the \
                        logarithm] }, { uniform = [low, high] } or { empirical = [values] }, with truncate = [low, high]";

/// Smallest share of a law that a truncation may keep: below it, quantiles lose digits.
const LEAST_KEPT: f64 = 1e-6;

const VALUES: ListOf = ListOf {
    path: "empirical",
    row: "7.8e-5",
    header: "mesh.half_gap [um]",
};

/// An axis that is a distribution.
pub(super) struct Drawn {
    key: AxisKey,
    key_span: Span,
    /// Place of the distribution.
    span: Span,
    spec: &'static Key,
    dimension: Dimension,
    distribution: Distribution,
}

/// The drawn axes of a grid, with their samples.
pub(super) struct DrawnAxes {
    pub axes: Vec<GridAxis>,
    /// The samples. Their indices refer to `axes`.
    pub samples: Samples,
}

/// Whether an axis is written as a distribution.
pub(super) fn is_distribution(node: &Node) -> bool {
    matches!(&node.value, Value::Table(entries) if entries.iter().any(is_distribution_key))
}

fn is_distribution_key(entry: &Entry) -> bool {
    entry.key == TRUNCATE || LAWS.contains(&entry.key.as_str())
}

/// The distribution of an axis; `None` if there is a fault, which is reported. Relative paths start at `base_dir`.
pub(super) fn read(issues: &Issues, entry: &Entry, tied: bool, base_dir: &Path) -> Option<Drawn> {
    let name = entry.key.as_str();
    let path = path_of(name);
    let axis = AxisReader::of(issues, entry, &path)?;
    let spec = axis.spec;
    if spec.kind == Kind::Integer {
        let message = format!("`{name}` takes whole numbers, so it cannot be a distribution");
        return fault(entry.key_span, &path, message)
            .label("whole numbers")
            .remedy("give it as { values = [...] }")
            .fail(issues);
    }
    if tied {
        let message = format!(
            "`{name}` is a distribution, so it cannot be tied: all distributions advance together"
        );
        let remedy = "remove it from grid.tied, or give it as { values = [...] }";
        return fault(entry.key_span, &path, message)
            .label("in grid.tied")
            .remedy(remedy)
            .fail(issues);
    }
    let mut reader = DistributionReader {
        axis,
        name,
        base_dir,
    };
    let distribution = reader.read(&entry.node)?;
    Some(Drawn {
        key: AxisKey::of(name),
        key_span: entry.key_span,
        span: entry.node.span,
        spec,
        dimension: reader.axis.dimension.unwrap_or(Dimension::Ratio),
        distribution,
    })
}

/// Draws the values of the axes; `whole` means that no axis of the grid has a fault. `None` if there are no
/// distributions, or if there is a fault, which is reported.
pub(super) fn draw(
    section: &Section,
    mut drawn: Vec<Drawn>,
    whole: bool,
    seed: u64,
) -> Option<DrawnAxes> {
    if drawn.is_empty() {
        if whole {
            section.without_effect(
                &["samples", "design"],
                "because no axis is a distribution",
                "give an axis as { normal = [mean, standard deviation] } or another distribution, or remove the key",
            );
        }
        return None;
    }
    let design: Design = section.variant("design")?;
    let count = section.integer("samples")?;
    if drawn.len() > design.most_axes() {
        let message = format!("the grid has {} distributions", drawn.len());
        let most = format!(
            "at most {} with design = \"{}\"",
            design.most_axes(),
            design.name()
        );
        return fault(section.span, "grid", message)
            .label("too many")
            .accepted(most)
            .fail(section.issues);
    }
    drawn.sort_by(|a, b| a.key.rank().cmp(&b.key.rank()));
    let shares = design.shares(drawn.len(), count, seed);
    let values: Vec<Vec<f64>> = (drawn.iter().zip(shares))
        .map(|(axis, shares)| {
            shares
                .iter()
                .map(|share| axis.distribution.quantile(*share))
                .collect()
        })
        .collect();
    let fit =
        (drawn.iter().zip(&values)).map(|(axis, values)| axis.in_range(section.issues, values));
    if fit.filter(|fit| !fit).count() > 0 {
        return None;
    }
    let samples = Samples {
        axes: (drawn
            .iter()
            .map(|axis| axis.distribution.clone())
            .enumerate())
        .collect(),
        design,
        count,
    };
    let axes = drawn
        .into_iter()
        .zip(values)
        .map(|(axis, values)| axis.axis(values));
    Some(DrawnAxes {
        axes: axes.collect(),
        samples,
    })
}

impl Drawn {
    /// The name of the axis.
    pub fn name(&self) -> &str {
        self.key.name()
    }

    fn axis(self, values: Vec<f64>) -> GridAxis {
        let values = (AxisValues::each(values), Spans::Whole(self.span));
        GridAxis::new(self.key, self.key_span, self.dimension, values)
    }

    /// Whether all values are in the range of the key; reports if not. A damping coefficient has no range.
    fn in_range(&self, issues: &Issues, values: &[f64]) -> bool {
        let bounds = self.spec.bounds;
        let bounded = self.dimension != Dimension::Damping;
        let outside = |value: &&f64| !value.is_finite() || bounded && !bounds.contain(**value);
        let Some(first) = values.iter().find(outside) else {
            return true;
        };
        let name = self.key.name();
        let unit = match self.dimension {
            Dimension::Ratio => String::new(),
            dimension => format!(" {}", dimension.unit()),
        };
        let message = format!(
            "{} of {} values of `{name}` are out of range, such as {first:.3e}{unit}",
            values.iter().filter(outside).count(),
            values.len(),
        );
        Diagnostic::new(
            DiagnosticKind::OutOfRange,
            self.span,
            &path_of(name),
            message,
        )
        .label(format!("must be {}{unit}", bounds.words()))
        .accepted(self.spec.accepted())
        .remedy("add truncate = [low, high] with limits inside the range")
        .report(issues);
        false
    }
}

fn fault(span: Span, path: &str, message: String) -> Diagnostic {
    Diagnostic::new(DiagnosticKind::Inconsistent, span, path, message)
}

/// Reads a distribution.
struct DistributionReader<'a> {
    axis: AxisReader<'a>,
    /// Name of the axis.
    name: &'a str,
    base_dir: &'a Path,
}

impl DistributionReader<'_> {
    fn read(&mut self, node: &Node) -> Option<Distribution> {
        let Value::Table(entries) = &node.value else {
            return None;
        };
        if let Some(entry) = entries.iter().find(|entry| !is_distribution_key(entry)) {
            let near = schema::nearest(&entry.key, &LAWS).map(|near| format!("`{near}`"));
            let message = format!("a distribution has no key `{}`", entry.key);
            return Diagnostic::new(
                DiagnosticKind::UnknownKey,
                entry.key_span,
                &format!("{}.{}", self.axis.path, entry.key),
                message,
            )
            .label("unknown")
            .accepted(ACCEPTED)
            .suggestion(near)
            .fail(self.axis.issues);
        }
        let laws: Vec<&Entry> = entries
            .iter()
            .filter(|entry| entry.key != TRUNCATE)
            .collect();
        let [law] = laws[..] else {
            let message = format!("`{}` must have one of {}", self.axis.path, quoted(&LAWS));
            let label = if laws.is_empty() { "no law" } else { "several laws" };
            return fault(node.span, self.axis.path, message)
                .label(label)
                .accepted(ACCEPTED)
                .fail(self.axis.issues);
        };
        let law = self.law(law)?;
        let truncate = match node.entry(TRUNCATE) {
            Some(entry) => Some(self.pair(entry, false)?),
            None => None,
        };
        let distribution = Distribution { law, truncate };
        if let Some([low, high]) = truncate
            && !(low < high && distribution.kept() >= LEAST_KEPT)
        {
            let message = if low < high {
                format!(
                    "`{}.truncate` keeps less than a millionth of the distribution",
                    self.axis.path
                )
            } else {
                format!(
                    "`{}.truncate` ends where it begins, or before",
                    self.axis.path
                )
            };
            return fault(node.span, self.axis.path, message)
                .label("nothing left")
                .remedy("give truncate = [low, high], with low < high and most of the distribution between")
                .fail(self.axis.issues);
        }
        Some(distribution)
    }

    fn law(&mut self, entry: &Entry) -> Option<Law> {
        let (law, violation) = match entry.key.as_str() {
            "normal" => {
                let [mean, deviation] = self.pair(entry, false)?;
                (
                    Law::Normal { mean, deviation },
                    (deviation <= 0.0).then_some("the standard deviation must be greater than 0"),
                )
            }
            "lognormal" => {
                let [median, deviation] = self.pair(entry, true)?;
                let violation = (median <= 0.0 || deviation <= 0.0)
                    .then_some("median and standard deviation must be greater than 0");
                (Law::Lognormal { median, deviation }, violation)
            }
            "uniform" => {
                let [low, high] = self.pair(entry, false)?;
                (
                    Law::Uniform { low, high },
                    (low >= high).then_some("the first value must be less than the second"),
                )
            }
            _ => (self.empirical(entry)?, None),
        };
        if let Some(violation) = violation {
            let message = format!("`{}.{}`: {violation}", self.axis.path, entry.key);
            return Diagnostic::new(
                DiagnosticKind::OutOfRange,
                entry.node.span,
                &format!("{}.{}", self.axis.path, entry.key),
                message,
            )
            .label("out of range")
            .accepted(ACCEPTED)
            .fail(self.axis.issues);
        }
        Some(law)
    }

    /// Two finite values of the axis's dimension; with `ratio`, the second is a ratio.
    fn pair(&mut self, entry: &Entry, ratio: bool) -> Option<[f64; 2]> {
        let path = format!("{}.{}", self.axis.path, entry.key);
        let issues = self.axis.issues;
        let wrong_type = |message: String| {
            Diagnostic::new(DiagnosticKind::WrongType, entry.node.span, &path, message)
                .label("not two values")
                .accepted(ACCEPTED)
                .fail(issues)
        };
        let Value::Array(items) = &entry.node.value else {
            let type_name = entry.node.value.type_name();
            return wrong_type(format!(
                "`{path}` must be a list of two values, not {type_name}"
            ));
        };
        let [first, last] = &items[..] else {
            let count = items.len();
            return wrong_type(format!("`{path}` must have two values, not {count}"));
        };
        let first = self.axis.unbounded(first, &path)?;
        let last = if ratio {
            self.axis
                .given(last, &path)
                .quantity_unbounded(Dimension::Ratio)?
        } else {
            self.axis.unbounded(last, &path)?
        };
        if !(first.is_finite() && last.is_finite()) {
            return wrong_type(format!("`{path}` has a value that is not a finite number"));
        }
        Some([first, last])
    }

    /// Values from a list, or from a column of a file.
    fn empirical(&mut self, entry: &Entry) -> Option<Law> {
        let column;
        let items = match &entry.node.value {
            Value::Array(items) if !items.is_empty() => items,
            Value::Text(_) => {
                let columns = columns::read(self.axis.issues, entry, &VALUES, self.base_dir)?;
                let names: Vec<&str> = columns
                    .iter()
                    .map(|column| column.name.key.as_str())
                    .collect();
                let Some(place) = names.iter().position(|name| *name == self.name) else {
                    let message = format!("the file has no column `{}`", self.name);
                    let remedy = format!(
                        "name a column so in the header line, such as {}",
                        VALUES.header
                    );
                    return fault(entry.node.span, self.axis.path, message)
                        .label("no such column")
                        .accepted(names.join(", "))
                        .remedy(remedy)
                        .fail(self.axis.issues);
                };
                column = columns.into_iter().nth(place)?;
                column
                    .unit_fits(self.axis.issues, self.axis.path, self.axis.dimension)
                    .then_some(())?;
                &column.values
            }
            _ => {
                let path = format!("{}.empirical", self.axis.path);
                let message = format!("`{path}` must be a list of values, or the path of a file");
                return Diagnostic::new(DiagnosticKind::WrongType, entry.node.span, &path, message)
                    .label("here")
                    .accepted(ACCEPTED)
                    .fail(self.axis.issues);
            }
        };
        let mut values = all_or_none(
            items
                .iter()
                .map(|item| self.axis.value(item, self.axis.path)),
        )?;
        values.sort_by(f64::total_cmp);
        Some(Law::Empirical(values.into()))
    }
}
