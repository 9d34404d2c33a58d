//! The values of one axis: one value, a list, or an even range.

use crate::manifest::axis::AxisValues;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use crate::manifest::reader::{self, wrong_type};
use crate::manifest::schema::{self, Key, Kind};
use crate::manifest::tree::{Entry, Node, Value};
use crate::units::{self, Dimension};

/// Keys of an axis written as a table.
const AXIS_KEYS: [&str; 5] = ["from", "to", "count", "spacing", "values"];

/// Most points of a grid, and so most values of an axis.
pub(super) const MAX_POINTS: u64 = 10_000_000;

static COUNT: Key = schema::integer("count", 1.0, MAX_POINTS as f64, "8");

/// The places of an axis's values.
#[derive(Debug)]
pub(super) enum Spans {
    Each(Vec<Span>),
    Whole(Span),
}

/// Reads the values of one axis.
pub(super) struct AxisReader<'a> {
    pub spec: &'static Key,
    pub path: &'a str,
    /// Dimension of the values; the first value determines it if the key does not.
    pub dimension: Option<Dimension>,
}

impl AxisReader<'_> {
    /// The values in SI and their places; `None` if there is a fault, which is reported. A value may repeat only if
    /// `repeats`.
    pub fn read(
        &mut self,
        issues: &mut Issues,
        node: &Node,
        repeats: bool,
    ) -> Option<(AxisValues, Spans)> {
        match &node.value {
            Value::Table(entries) => self.table(issues, node, entries, repeats),
            Value::Array(_) => {
                wrong_axis(issues, node, self.path, self.spec);
                None
            }
            _ => {
                let value = self.value(issues, node, self.path)?;
                Some((AxisValues::each(vec![value]), Spans::Whole(node.span)))
            }
        }
    }

    /// One value of a column in SI.
    pub fn one(&mut self, issues: &mut Issues, node: &Node) -> Option<f64> {
        let path = self.path;
        self.value(issues, node, path)
    }

    /// One value in SI, in the range of its key. Consistency with other keys is checked when a point is resolved.
    fn value(&mut self, issues: &mut Issues, node: &Node, path: &str) -> Option<f64> {
        if self.spec.kind == Kind::Integer {
            return self.whole(issues, node, path);
        }
        let value = self.unbounded(issues, node, path)?;
        let dimension = self.dimension.unwrap_or(Dimension::Ratio);
        // A damping ratio has a range, but a damping coefficient has none.
        if value.is_finite() && dimension == Dimension::Damping {
            return Some(value);
        }
        reader::in_range(issues, node, path, value, dimension, self.spec)
    }

    /// One value of any size in SI.
    pub fn unbounded(&mut self, issues: &mut Issues, node: &Node, path: &str) -> Option<f64> {
        let own = match &node.value {
            Value::Text(text) if self.spec.kind == Kind::ContactDamping => {
                match units::parse_any(text) {
                    Ok((_, Dimension::Ratio)) => Dimension::Ratio,
                    _ => Dimension::Damping,
                }
            }
            _ => self.dimension.unwrap_or(Dimension::Ratio),
        };
        let dimension = *self.dimension.get_or_insert(own);
        if self.spec.kind == Kind::ContactDamping
            && (own != dimension
                || (dimension == Dimension::Damping && !matches!(node.value, Value::Text(_))))
        {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Inconsistent,
                    node.span,
                    path,
                    format!("`{}` mixes damping ratios and coefficients", self.path),
                )
                .label("differs from the first value")
                .remedy("give all values as bare ratios, or all with the unit N*s/m"),
            );
            return None;
        }
        reader::quantity_unbounded(issues, node, path, dimension, self.spec)
    }

    /// A whole number. An axis stores it as a double, which cannot represent the largest seeds.
    fn whole(&self, issues: &mut Issues, node: &Node, path: &str) -> Option<f64> {
        const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;
        let value = reader::integer(issues, node, path, self.spec)?;
        if value > EXACT {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::OutOfRange,
                    node.span,
                    path,
                    format!("`{path}` = {value} is too large for an axis"),
                )
                .label("not stored exactly")
                .accepted(format!("a whole number of at most {EXACT}")),
            );
            return None;
        }
        Some(value as f64)
    }

    fn table(
        &mut self,
        issues: &mut Issues,
        node: &Node,
        entries: &[Entry],
        repeats: bool,
    ) -> Option<(AxisValues, Spans)> {
        let mut valid = true;
        for entry in entries
            .iter()
            .filter(|e| !AXIS_KEYS.contains(&e.key.as_str()))
        {
            let path = format!("{}.{}", self.path, entry.key);
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::UnknownKey,
                    entry.key_span,
                    &path,
                    format!("an axis has no key `{}`", entry.key),
                )
                .label("unknown")
                .accepted("{ values = [...] }, or { from, to, count, spacing }")
                .suggestion(
                    schema::nearest(&entry.key, &AXIS_KEYS).map(|near| format!("`{near}`")),
                ),
            );
            valid = false;
        }
        if let Some(values) = node.entry("values") {
            if entries.len() > 1 && valid {
                issues.push(
                    Diagnostic::new(
                        DiagnosticKind::Inconsistent,
                        node.span,
                        self.path,
                        format!("`{}` has `values` and a range", self.path),
                    )
                    .label("give only one of the two")
                    .remedy("keep either `values`, or `from`, `to`, `count` and `spacing`"),
                );
                valid = false;
            }
            let list = self.list(issues, &values.node, repeats);
            return list.filter(|_| valid);
        }
        let range = self.range(issues, node);
        range
            .filter(|_| valid)
            .map(|values| (values, Spans::Whole(node.span)))
    }

    fn list(
        &mut self,
        issues: &mut Issues,
        node: &Node,
        repeats: bool,
    ) -> Option<(AxisValues, Spans)> {
        let path = format!("{}.values", self.path);
        let Value::Array(items) = &node.value else {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::WrongType,
                    node.span,
                    &path,
                    format!(
                        "`{path}` must be a list in [ ], not {}",
                        node.value.type_name()
                    ),
                )
                .label(format!("this is {}", node.value.type_name())),
            );
            return None;
        };
        if items.is_empty() {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Empty,
                    node.span,
                    &path,
                    format!("`{path}` is empty, so the grid has no points"),
                )
                .label("empty")
                .remedy("give at least one value"),
            );
            return None;
        }
        let read: Vec<_> = items
            .iter()
            .enumerate()
            .map(|(i, item)| self.value(issues, item, &format!("{path}.{i}")))
            .collect();
        let values = read.into_iter().collect::<Option<Vec<f64>>>()?;
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]).then(a.cmp(&b)));
        let twice = order
            .windows(2)
            .find(|pair| values[pair[0]] == values[pair[1]]);
        if let Some(pair) = twice.filter(|_| !repeats) {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Inconsistent,
                    items[pair[1]].span,
                    &path,
                    format!("`{path}` has the same value twice"),
                )
                .label(format!("as entry {}", pair[0] + 1))
                .remedy("every value makes separate points: keep one of the two"),
            );
            return None;
        }
        let spans = items.iter().map(|item| item.span).collect();
        Some((AxisValues::each(values), Spans::Each(spans)))
    }

    fn range(&mut self, issues: &mut Issues, node: &Node) -> Option<AxisValues> {
        let path_of = |key: &str| format!("{}.{key}", self.path);
        for key in ["from", "to", "count"] {
            if node.entry(key).is_none() {
                issues.push(
                    Diagnostic::new(
                        DiagnosticKind::MissingKey,
                        node.span,
                        &path_of(key),
                        format!("`{}` needs `{key}`", self.path),
                    )
                    .label("incomplete")
                    .accepted("{ values = [...] }, or { from, to, count, spacing }"),
                );
            }
        }
        let (from_path, to_path, count_path) = (path_of("from"), path_of("to"), path_of("count"));
        let from = node
            .entry("from")
            .map(|e| self.value(issues, &e.node, &from_path));
        let to = node
            .entry("to")
            .map(|e| self.value(issues, &e.node, &to_path));
        let count = node
            .entry("count")
            .map(|e| reader::integer(issues, &e.node, &count_path, &COUNT));
        let logarithmic = self.logarithmic(issues, node);
        let (from, to, count, logarithmic) = (from??, to??, count??, logarithmic?);
        let mut fault = |message: String, remedy: &str| {
            issues.push(
                Diagnostic::new(DiagnosticKind::Inconsistent, node.span, self.path, message)
                    .label("does not fit together")
                    .remedy(remedy),
            );
            None
        };
        if count > 1 && from == to {
            return fault(
                format!(
                    "`{}` takes {count} values, but from and to are equal",
                    self.path
                ),
                "set count = 1, or change one end",
            );
        }
        if count == 1 && from != to {
            return fault(
                format!("`{}` takes 1 value, but from and to differ", self.path),
                "give the value itself, or set count = 2 or more",
            );
        }
        if logarithmic && (from <= 0.0 || to <= 0.0) {
            return fault(
                format!(
                    "`{}` has logarithmic spacing, but an end is not greater than 0",
                    self.path
                ),
                "use spacing = \"linear\", or ends greater than 0",
            );
        }
        let count = usize::try_from(count).ok()?;
        let values = AxisValues::even(from, to, count, logarithmic);
        let broken = (self.spec.kind == Kind::Integer)
            .then(|| values.iter().find(|value| value.fract() != 0.0));
        if let Some(value) = broken.flatten() {
            let value = Value::Sample(value, Dimension::Ratio);
            let span = node.span;
            _ = self.whole(issues, &Node { span, value }, self.path);
            return None;
        }
        Some(values)
    }

    fn logarithmic(&self, issues: &mut Issues, node: &Node) -> Option<bool> {
        let Some(entry) = node.entry("spacing") else {
            return Some(false);
        };
        match &entry.node.value {
            Value::Text(text) if text == "linear" => return Some(false),
            Value::Text(text) if text == "log" => return Some(true),
            _ => {}
        }
        let path = format!("{}.spacing", self.path);
        static SPACING: Key = schema::choice("spacing", &["linear", "log"], "\"log\"");
        match &entry.node.value {
            Value::Text(text) => issues.push(
                Diagnostic::new(
                    DiagnosticKind::OutOfRange,
                    entry.node.span,
                    &path,
                    format!("`{path}` cannot be \"{text}\""),
                )
                .label("not one of the choices")
                .accepted(SPACING.accepted())
                .suggestion(
                    schema::nearest(text, &["linear", "log"]).map(|near| format!("\"{near}\"")),
                ),
            ),
            _ => wrong_type(issues, &entry.node, &path, &SPACING),
        }
        None
    }
}

fn wrong_axis(issues: &mut Issues, node: &Node, path: &str, spec: &'static Key) {
    let example = match spec.kind {
        Kind::Axis(_) => spec.example.to_owned(),
        _ => format!("{{ values = [{}, ...] }}", spec.example),
    };
    issues.push(
        Diagnostic::new(
            DiagnosticKind::WrongType,
            node.span,
            path,
            format!("`{path}` must be a value or a table, not {}", node.value.type_name()),
        )
        .label(format!("this is {}", node.value.type_name()))
        .accepted(format!(
            "one value, {{ values = [...] }}, or {{ from, to, count, spacing }}; for example {example}"
        )),
    );
}
