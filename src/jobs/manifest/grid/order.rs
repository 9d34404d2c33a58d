//! `grid.order`, `grid.along` and `grid.displacement`: are points independent, or does each start near the end of the
//! previous one along an axis?

use super::grid_axis::GridAxis;
use crate::manifest::axis::AxisKey;
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::grid_dimension::GridDimension;
use crate::manifest::modal_keys;
use crate::manifest::reader::Section;
use crate::manifest::schema;
use crate::manifest::spec::{Carried, Direction};
use crate::manifest::tree::Value;

/// Tables whose keys change the system but not its modes.
const TABLES_LEAVING_MODES: [&str; 2] = ["mesh.", "excitation."];

/// Whether `grid.order` carries the state from point to point. A faulty value counts as carrying it.
pub(in crate::manifest) fn is_carried(root: &Section) -> bool {
    let order = root.entry("grid").and_then(|grid| grid.node.entry("order"));
    let independent = |value: &Value| matches!(value, Value::Text(word) if word == "independent");
    order.is_some_and(|order| !independent(&order.node.value))
}

/// The order of the points over the valid `axes`; `None` if they are independent, or if there is a fault, which is
/// reported.
pub(super) fn read(
    section: &Section,
    axes: &[GridAxis],
    dimensions: &[GridDimension],
    faulty: &[String],
) -> Option<Carried> {
    let displacement = section.quantity("displacement");
    let order = section.choice("order")?;
    let directions = match order {
        "sweep-up" => vec![Direction::Up],
        "sweep-down" => vec![Direction::Down],
        "both" => vec![Direction::Up, Direction::Down],
        _ => {
            for key in ["along", "displacement"] {
                section.without_effect(
                    &[key],
                    "because points are independent",
                    &format!(
                        "set order = \"sweep-up\", \"sweep-down\" or \"both\", or remove {key}"
                    ),
                );
            }
            return None;
        }
    };
    let (key, name) = if section.has("along") {
        ("along", section.text("along")?)
    } else {
        if !faulty.is_empty() {
            return None;
        }
        let last = axes.iter().rfind(|axis| axis.axis.values.vary());
        ("order", last.map_or("", |axis| axis.axis.name()))
    };
    if faulty.iter().any(|fault| fault == name) {
        return None;
    }
    let position = axes.iter().position(|axis| axis.axis.name() == name);
    match fault(axes, dimensions, position, name) {
        None => position
            .zip(displacement)
            .map(|(axis, displacement)| Carried {
                axis,
                length: axes[axis].axis.values.len(),
                directions,
                displacement,
            }),
        Some((kind, message, label)) => {
            let sweepable_axes = sweepable_axes(axes, dimensions);
            let near = schema::nearest(name, &sweepable_axes).map(|near| format!("\"{near}\""));
            let remedy = if sweepable_axes.is_empty() {
                "give such an axis several values, or set order = \"independent\"".to_owned()
            } else {
                let sweepable_axes = sweepable_axes.join(", ");
                format!("axes of this grid that can be swept: {sweepable_axes}")
            };
            section
                .fault(kind, key, message)
                .label(label)
                .accepted("name load, torque, speed, or a key of mesh, excitation or a modal file that the grid varies: these keep the coordinates of the state")
                .suggestion(near)
                .remedy(remedy)
                .fail(section.issues)
        }
    }
}

/// Kind of fault, message and label for an axis that cannot be swept.
fn fault(
    axes: &[GridAxis],
    dimensions: &[GridDimension],
    position: Option<usize>,
    name: &str,
) -> Option<(DiagnosticKind, String, &'static str)> {
    let Some(place) = position else {
        return Some(match name {
            "" => (
                DiagnosticKind::Inconsistent,
                "no axis of the grid has more than one value, so none can be swept".to_owned(),
                "nothing to carry",
            ),
            name => (
                DiagnosticKind::UnknownAxis,
                format!("the grid has no axis `{name}` to sweep along"),
                "not an axis",
            ),
        });
    };
    let tied = &dimensions[GridDimension::of(dimensions, place)];
    if tied.sampled {
        return Some((
            DiagnosticKind::Inconsistent,
            format!(
                "a state cannot be carried along `{name}`: its values are samples of a distribution"
            ),
            "samples have no order",
        ));
    }
    let changing =
        (tied.axes.iter().map(|&axis| axes[axis].axis.name())).find(|name| !leaves_modes(name));
    if let Some(changing) = changing {
        let of_the_work = ["run.", "analyses.", "job."];
        let (why, label) = if of_the_work.iter().any(|table| changing.starts_with(table)) {
            (
                "changes the computation, not the drive",
                "not a key of the drive",
            )
        } else {
            ("changes the modes of the structure", "changes the modes")
        };
        return Some((
            DiagnosticKind::Inconsistent,
            if changing == name {
                format!("a state cannot be carried along `{name}`: this axis {why}")
            } else {
                format!("a state cannot be carried along `{name}`: `{changing}`, tied to it, {why}")
            },
            label,
        ));
    }
    if !axes[place].axis.values.vary() {
        return Some((
            DiagnosticKind::Inconsistent,
            format!("`{name}` has one value, so it cannot be swept"),
            "nothing to carry",
        ));
    }
    let duplicate = tied
        .is_tied()
        .then(|| repeated_value(&axes[place]))
        .flatten();
    duplicate.map(|value| {
        (
            DiagnosticKind::Inconsistent,
            format!(
                "`{name}` is {} at several of the tied points, so the order of the sweep is ambiguous",
                schema::number(value)
            ),
            "the value repeats",
        )
    })
}

fn leaves_modes(name: &str) -> bool {
    !AxisKey::of(name).is_model_key()
        || modal_keys::is_modal_number_name(name)
        || TABLES_LEAVING_MODES
            .iter()
            .any(|table| name.starts_with(table))
}

/// A value that a tied axis has at several places.
fn repeated_value(axis: &GridAxis) -> Option<f64> {
    let ascending = axis.axis.values.ascending();
    let value = |rank: usize| axis.axis.values.get(ascending.place(rank));
    (1..ascending.len())
        .find(|&rank| value(rank) == value(rank - 1))
        .map(value)
}

/// Axes that can be swept.
fn sweepable_axes<'a>(axes: &'a [GridAxis], dimensions: &[GridDimension]) -> Vec<&'a str> {
    (axes.iter().enumerate())
        .map(|(place, axis)| (place, axis.axis.name()))
        .filter(|&(place, name)| {
            axes[place].axis.values.vary() && fault(axes, dimensions, Some(place), name).is_none()
        })
        .map(|(_, name)| name)
        .collect()
}
