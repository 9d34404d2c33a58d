//! `grid.tied`: axes that advance in step. The grid then has one point per value of them instead of one per
//! combination.

use super::grid_axis::GridAxis;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use crate::manifest::reader::{Section, wrong_type};
use crate::manifest::schema;
use crate::manifest::tree::{Node, Value};

/// A group of axes as the text names them.
#[derive(Debug)]
pub(super) struct Tie {
    pub names: Vec<String>,
    span: Span,
}

/// The groups of `grid.tied`; faulty ones are omitted and reported.
pub(super) fn read(section: &Section, issues: &mut Issues) -> Vec<Tie> {
    let Some(entry) = section.entry("tied") else {
        return Vec::new();
    };
    let Value::Array(groups) = &entry.node.value else {
        wrong_type(issues, &entry.node, "grid.tied", section.spec("grid.tied"));
        return Vec::new();
    };
    let read: Vec<Tie> = (groups.iter())
        .filter_map(|group| names(section, issues, group))
        .collect();
    let mut seen: Vec<&str> = Vec::new();
    for tie in &read {
        for name in &tie.names {
            if seen.contains(&name.as_str()) {
                issues.push(
                    Diagnostic::new(
                        DiagnosticKind::Inconsistent,
                        tie.span,
                        "grid.tied",
                        format!("`grid.tied` names `{name}` twice"),
                    )
                    .label("named before")
                    .remedy("name every axis once; put all axes that advance together in one list"),
                );
                return Vec::new();
            }
            seen.push(name);
        }
    }
    read
}

fn names(section: &Section, issues: &mut Issues, group: &Node) -> Option<Tie> {
    let spec = section.spec("grid.tied.*");
    let Value::Array(items) = &group.value else {
        wrong_type(issues, group, "grid.tied", section.spec("grid.tied"));
        return None;
    };
    let mut names = Vec::new();
    for item in items {
        match &item.value {
            Value::Text(name) => names.push(name.clone()),
            _ => {
                wrong_type(issues, item, "grid.tied", spec);
                return None;
            }
        }
    }
    if names.len() < 2 {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                group.span,
                "grid.tied",
                format!(
                    "`grid.tied` ties {}",
                    match names.first() {
                        None => "no axis".to_owned(),
                        Some(name) => format!("`{name}` to nothing"),
                    }
                ),
            )
            .label("at least two axes")
            .accepted(spec.accepted())
            .remedy("name the axes that advance together, [[\"load\", \"speed\"]], or remove tied"),
        );
        return None;
    }
    Some(Tie {
        names,
        span: group.span,
    })
}

/// The indices of the axes of every group. A group with an unknown axis or with axes of different lengths is omitted
/// and reported. `columns` are those of a list of points, which already advance in step. Faults of axes in `faulty`
/// have been reported.
pub(super) fn places(
    ties: &[Tie],
    axes: &[GridAxis],
    columns: &[String],
    faulty: &[String],
    issues: &mut Issues,
) -> Vec<Vec<usize>> {
    let mut all = Vec::new();
    for tie in ties {
        if tie.names.iter().any(|name| faulty.contains(name)) {
            continue;
        }
        if let Some(column) = tie.names.iter().find(|name| columns.contains(name)) {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Inconsistent,
                    tie.span,
                    "grid.tied",
                    format!("`{column}` is a column of `grid.points`, which cannot be tied to an axis"),
                )
                .label("advances with the other columns")
                .remedy("give all axes that advance together as columns of grid.points, or remove the column from tied"),
            );
            continue;
        }
        let place = |name: &String| axes.iter().position(|axis| axis.axis.name() == name);
        if let Some(unknown) = tie.names.iter().find(|name| place(name).is_none()) {
            let known: Vec<&str> = axes.iter().map(|axis| axis.axis.name()).collect();
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::UnknownAxis,
                    tie.span,
                    "grid.tied",
                    format!("the grid has no axis `{unknown}`, so it cannot be tied"),
                )
                .label("not an axis of the grid")
                .accepted(known.join(", "))
                .suggestion(schema::nearest(unknown, &known).map(|near| format!("\"{near}\""))),
            );
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
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Inconsistent,
                    tie.span,
                    "grid.tied",
                    format!(
                        "tied axes have different numbers of values: {}",
                        lengths.join(", ")
                    ),
                )
                .label("cannot advance together")
                .remedy("give all of them the same number of values"),
            );
            continue;
        }
        all.push(places);
    }
    all
}
