//! The values of one axis: one value, a list, or an even range.

use super::axis_key::{axis_key, dimension_of};
use crate::manifest::axis::AxisValues;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use crate::manifest::reader::{EXACT, Given, all_or_none};
use crate::manifest::schema::{self, Key, Kind};
use crate::manifest::tree::{Entry, Node, Value};
use crate::units::{self, Dimension};

/// Keys of an axis written as a table.
const AXIS_KEYS: [&str; 5] = ["from", "to", "count", "spacing", "values"];

/// Largest number of points of a grid, and of values of an axis.
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
    /// The list in which faults are recorded.
    pub issues: &'a Issues,
    pub spec: &'static Key,
    pub path: &'a str,
    /// Dimension of the values; the first value determines it if the key does not.
    pub dimension: Option<Dimension>,
}

impl<'a> AxisReader<'a> {
    /// The reader for the key of an axis; a name that is no key is reported.
    pub fn of(issues: &'a Issues, entry: &Entry, path: &'a str) -> Option<Self> {
        let spec = axis_key(issues, entry, path)?;
        Some(Self {
            issues,
            spec,
            path,
            dimension: dimension_of(spec),
        })
    }

    /// The values in SI and their places; `None` if there is a fault, which is reported. A value may repeat only if
    /// `repeats`.
    pub fn read(&mut self, node: &Node, repeats: bool) -> Option<(AxisValues, Spans)> {
        match &node.value {
            Value::Table(entries) => self.table(node, entries, repeats),
            Value::Array(_) => {
                wrong_axis(self.issues, node, self.path, self.spec);
                None
            }
            _ => {
                let value = self.value(node, self.path)?;
                Some((AxisValues::each(vec![value]), Spans::Whole(node.span)))
            }
        }
    }

    pub fn given<'v>(&'v self, node: &'v Node, path: &'v str) -> Given<'v> {
        Given {
            issues: self.issues,
            node,
            path,
            spec: self.spec,
        }
    }

    /// One value in SI, in the range of its key. Consistency with other keys is checked when a point is resolved.
    pub fn value(&mut self, node: &Node, path: &str) -> Option<f64> {
        if self.spec.kind == Kind::Integer {
            return self.whole(node, path);
        }
        let value = self.unbounded(node, path)?;
        let dimension = self.dimension.unwrap_or(Dimension::Ratio);
        // A damping ratio has a range, but a damping coefficient has none.
        if value.is_finite() && dimension == Dimension::Damping {
            return Some(value);
        }
        self.given(node, path).in_range(value, dimension)
    }

    /// One value of any size in SI.
    pub fn unbounded(&mut self, node: &Node, path: &str) -> Option<f64> {
        let node_dimension = match &node.value {
            Value::Text(text) if self.spec.kind == Kind::ContactDamping => {
                match units::parse_any(text) {
                    Ok((_, Dimension::Ratio)) => Dimension::Ratio,
                    _ => Dimension::Damping,
                }
            }
            _ => self.dimension.unwrap_or(Dimension::Ratio),
        };
        let dimension = *self.dimension.get_or_insert(node_dimension);
        if self.spec.kind == Kind::ContactDamping
            && (node_dimension != dimension
                || (dimension == Dimension::Damping && !matches!(node.value, Value::Text(_))))
        {
            let message = format!("`{}` mixes damping ratios and coefficients", self.path);
            return Diagnostic::new(DiagnosticKind::Inconsistent, node.span, path, message)
                .label("differs from the first value")
                .remedy("give all values as bare ratios, or all with the unit N*s/m")
                .fail(self.issues);
        }
        self.given(node, path).quantity_unbounded(dimension)
    }

    /// A whole number. An axis stores it as a double, which cannot represent the largest seeds.
    fn whole(&self, node: &Node, path: &str) -> Option<f64> {
        let value = self.given(node, path).integer()?;
        if value > EXACT {
            let message = format!("`{path}` = {value} is too large for an axis");
            return Diagnostic::new(DiagnosticKind::OutOfRange, node.span, path, message)
                .label("not stored exactly")
                .accepted(format!("a whole number of at most {EXACT}"))
                .fail(self.issues);
        }
        Some(value as f64)
    }

    fn table(
        &mut self,
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
            let message = format!("an axis has no key `{}`", entry.key);
            Diagnostic::new(DiagnosticKind::UnknownKey, entry.key_span, &path, message)
                .label("unknown")
                .accepted("{ values = [...] }, or { from, to, count, spacing }")
                .suggestion(schema::nearest(&entry.key, &AXIS_KEYS).map(|near| format!("`{near}`")))
                .report(self.issues);
            valid = false;
        }
        if let Some(values) = node.entry("values") {
            if entries.len() > 1 && valid {
                let message = format!("`{}` has `values` and a range", self.path);
                Diagnostic::new(DiagnosticKind::Inconsistent, node.span, self.path, message)
                    .label("give only one of the two")
                    .remedy("keep either `values`, or `from`, `to`, `count` and `spacing`")
                    .report(self.issues);
                valid = false;
            }
            let list = self.list(&values.node, repeats);
            return list.filter(|_| valid);
        }
        let range = self.range(node);
        range
            .filter(|_| valid)
            .map(|values| (values, Spans::Whole(node.span)))
    }

    fn list(&mut self, node: &Node, repeats: bool) -> Option<(AxisValues, Spans)> {
        let path = format!("{}.values", self.path);
        let Value::Array(items) = &node.value else {
            let message = format!(
                "`{path}` must be a list in [ ], not {}",
                node.value.type_name()
            );
            return Diagnostic::new(DiagnosticKind::WrongType, node.span, &path, message)
                .label(format!("this is {}", node.value.type_name()))
                .fail(self.issues);
        };
        if items.is_empty() {
            let message = format!("`{path}` is empty, so the grid has no points");
            return Diagnostic::new(DiagnosticKind::Empty, node.span, &path, message)
                .label("empty")
                .remedy("give at least one value")
                .fail(self.issues);
        }
        let values = items.iter().enumerate();
        let values = all_or_none(values.map(|(i, item)| self.value(item, &format!("{path}.{i}"))))?;
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]).then(a.cmp(&b)));
        let twice = order
            .windows(2)
            .find(|pair| values[pair[0]] == values[pair[1]]);
        if let Some(pair) = twice.filter(|_| !repeats) {
            let message = format!("`{path}` has the same value twice");
            return Diagnostic::new(
                DiagnosticKind::Inconsistent,
                items[pair[1]].span,
                &path,
                message,
            )
            .label(format!("as entry {}", pair[0] + 1))
            .remedy("every value makes separate points: keep one of the two")
            .fail(self.issues);
        }
        let spans = items.iter().map(|item| item.span).collect();
        Some((AxisValues::each(values), Spans::Each(spans)))
    }

    fn range(&mut self, node: &Node) -> Option<AxisValues> {
        let path_of = |key: &str| format!("{}.{key}", self.path);
        for key in ["from", "to", "count"] {
            if node.entry(key).is_none() {
                let message = format!("`{}` needs `{key}`", self.path);
                Diagnostic::new(
                    DiagnosticKind::MissingKey,
                    node.span,
                    &path_of(key),
                    message,
                )
                .label("incomplete")
                .accepted("{ values = [...] }, or { from, to, count, spacing }")
                .report(self.issues);
            }
        }
        let (from_path, to_path, count_path) = (path_of("from"), path_of("to"), path_of("count"));
        let from = node.entry("from").map(|e| self.value(&e.node, &from_path));
        let to = node.entry("to").map(|e| self.value(&e.node, &to_path));
        let count = node.entry("count").map(|e| {
            let given = Given {
                spec: &COUNT,
                ..self.given(&e.node, &count_path)
            };
            given.integer()
        });
        let logarithmic = self.logarithmic(node);
        let (from, to, count, logarithmic) = (from??, to??, count??, logarithmic?);
        let fault = |message: String, remedy: &str| {
            Diagnostic::new(DiagnosticKind::Inconsistent, node.span, self.path, message)
                .label("does not fit together")
                .remedy(remedy)
                .fail(self.issues)
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
        let fractional_value = (self.spec.kind == Kind::Integer)
            .then(|| values.iter().find(|value| value.fract() != 0.0));
        if let Some(value) = fractional_value.flatten() {
            let value = Value::Sample(value, Dimension::Ratio);
            let span = node.span;
            _ = self.whole(&Node { span, value }, self.path);
            return None;
        }
        Some(values)
    }

    fn logarithmic(&self, node: &Node) -> Option<bool> {
        let Some(entry) = node.entry("spacing") else {
            return Some(false);
        };
        static SPACING: Key = schema::choice("spacing", &["linear", "log"], "\"log\"");
        let path = format!("{}.spacing", self.path);
        let given = Given {
            spec: &SPACING,
            ..self.given(&entry.node, &path)
        };
        Some(given.choice()? == "log")
    }
}

fn wrong_axis(issues: &Issues, node: &Node, path: &str, spec: &'static Key) {
    let example = match spec.kind {
        Kind::Axis(_) => spec.example.to_owned(),
        _ => format!("{{ values = [{}, ...] }}", spec.example),
    };
    let message = format!(
        "`{path}` must be a value or a table, not {}",
        node.value.type_name()
    );
    let accepted = format!(
        "one value, {{ values = [...] }}, or {{ from, to, count, spacing }}; for example {example}"
    );
    Diagnostic::new(DiagnosticKind::WrongType, node.span, path, message)
        .label(format!("this is {}", node.value.type_name()))
        .accepted(accepted)
        .report(issues);
}
