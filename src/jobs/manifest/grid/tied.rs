//! `grid.tied`: axes that advance in step. The grid then has one point per value of them instead of one per
//! combination.

use super::grid_axis::GridAxis;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use crate::manifest::reader::{Given, Section};
use crate::manifest::schema;
use crate::manifest::tree::{Node, Value};

/// A group of axes as the text names them.
#[derive(Debug)]
pub(super) struct TiedGroup {
    pub names: Vec<String>,
    span: Span,
}

/// The groups of `grid.tied`; faulty ones are omitted and reported. Empty if an axis is named twice.
pub(super) fn read(section: &Section) -> Vec<TiedGroup> {
    let Some(entry) = section.entry("tied") else {
        return Vec::new();
    };
    let Value::Array(groups) = &entry.node.value else {
        return given(section, "grid.tied", &entry.node)
            .wrong_type()
            .unwrap_or_default();
    };
    let read: Vec<TiedGroup> = (groups.iter())
        .filter_map(|group| names(section, group))
        .collect();
    let mut seen: Vec<&str> = Vec::new();
    for tie in &read {
        for name in &tie.names {
            if seen.contains(&name.as_str()) {
                let message = format!("`grid.tied` names `{name}` twice");
                Diagnostic::new(DiagnosticKind::Inconsistent, tie.span, "grid.tied", message)
                    .label("named before")
                    .remedy("name every axis once; put all axes that advance together in one list")
                    .report(section.issues);
                return Vec::new();
            }
            seen.push(name);
        }
    }
    read
}

/// A value of `grid.tied`, with the schema's entry of `key`.
fn given<'a>(section: &'a Section, key: &str, node: &'a Node) -> Given<'a> {
    Given {
        issues: section.issues,
        node,
        path: "grid.tied",
        spec: section.spec(key),
    }
}

fn names(section: &Section, group: &Node) -> Option<TiedGroup> {
    let Value::Array(items) = &group.value else {
        return given(section, "grid.tied", group).wrong_type();
    };
    let texts = items
        .iter()
        .map(|item| given(section, "grid.tied.*", item).text());
    let names: Vec<String> = texts
        .map(|text| text.map(str::to_owned))
        .collect::<Option<_>>()?;
    if names.len() < 2 {
        let message = format!(
            "`grid.tied` ties {}",
            match names.first() {
                None => "no axis".to_owned(),
                Some(name) => format!("`{name}` to nothing"),
            }
        );
        return Diagnostic::new(
            DiagnosticKind::Inconsistent,
            group.span,
            "grid.tied",
            message,
        )
        .label("at least two axes")
        .accepted(section.spec("grid.tied.*").accepted())
        .remedy("name the axes that advance together, [[\"load\", \"speed\"]], or remove tied")
        .fail(section.issues);
    }
    Some(TiedGroup {
        names,
        span: group.span,
    })
}

/// The indices of the axes of every group. A group with an unknown axis or with axes of different lengths is omitted
/// and reported. `columns` of a list of points and axes given by `expressions` already advance in step. Faults of axes
/// in `faulty` have been reported.
pub(super) fn places(
    ties: &[TiedGroup],
    axes: &[GridAxis],
    (columns, expressions): (&[String], &[&str]),
    faulty: &[String],
    issues: &Issues,
) -> Vec<Vec<usize>> {
    let mut all = Vec::new();
    for tie in ties {
        if tie.names.iter().any(|name| faulty.contains(name)) {
            continue;
        }
        if let Some(column) = tie.names.iter().find(|name| columns.contains(name)) {
            let message =
                format!("`{column}` is a column of `grid.points`, which cannot be tied to an axis");
            let remedy = "give all axes that advance together as columns of grid.points, or remove the column from tied";
            Diagnostic::new(DiagnosticKind::Inconsistent, tie.span, "grid.tied", message)
                .label("advances with the other columns")
                .remedy(remedy)
                .report(issues);
            continue;
        }
        if let Some(name) = (tie.names.iter()).find(|name| expressions.contains(&name.as_str())) {
            let message =
                format!("`{name}` is an expression, which ties it to the axes in the expression");
            Diagnostic::new(DiagnosticKind::Inconsistent, tie.span, "grid.tied", message)
                .label("tied already")
                .remedy(format!("remove `{name}` from tied"))
                .report(issues);
            continue;
        }
        let place = |name: &String| axes.iter().position(|axis| axis.axis.name() == name);
        if let Some(unknown) = tie.names.iter().find(|name| place(name).is_none()) {
            let known: Vec<&str> = axes.iter().map(|axis| axis.axis.name()).collect();
            let message = format!("the grid has no axis `{unknown}`, so it cannot be tied");
            Diagnostic::new(DiagnosticKind::UnknownAxis, tie.span, "grid.tied", message)
                .label("not an axis of the grid")
                .accepted(known.join(", "))
                .suggestion(schema::nearest(unknown, &known).map(|near| format!("\"{near}\"")))
                .report(issues);
            continue;
        }
        let places: Vec<usize> = tie.names.iter().filter_map(place).collect();
        let length = |place: &usize| axes[*place].axis.values.len();
        if places
            .iter()
            .any(|place| length(place) != length(&places[0]))
        {
            let lengths: Vec<String> = (places.iter())
                .map(|place| format!("{} {}", length(place), axes[*place].axis.name()))
                .collect();
            let message = format!(
                "tied axes have different numbers of values: {}",
                lengths.join(", ")
            );
            Diagnostic::new(DiagnosticKind::Inconsistent, tie.span, "grid.tied", message)
                .label("cannot advance together")
                .remedy("give all of them the same number of values")
                .report(issues);
            continue;
        }
        all.push(places);
    }
    all
}
