//! `[continuation]`: the parameters over which orbits are followed.

use super::modal_state;
use crate::analysis::continuation::explore::GivenState;
use crate::manifest::expression::Expression;
use crate::manifest::grid_dimension::GridDimension;
use crate::manifest::parameter::Parameter;
use crate::manifest::reader::{Section, all_of};
use crate::manifest::schema;
use crate::manifest::spec::{Axis, ContinuationSpec};
use crate::manifest::tree::Value;

/// The section; `Some(None)` if there is none or if an axis that it names has one value, `None` if it is faulty.
pub(in crate::manifest) fn read(
    root: &Section,
    axes: &[&Axis],
    dimensions: &[GridDimension],
    (faulty, expressions): (&[String], &[(String, Expression)]),
    retained: Option<usize>,
) -> Option<Option<ContinuationSpec>> {
    let Some(section) = root.child("continuation")? else {
        return Some(None);
    };
    // A manifest with one value of this axis remains valid for other commands.
    if let Some(name) = single_valued(&section, axes) {
        root.without_effect(
            &["continuation"],
            &format!("here: its axis `{name}` has one value"),
            "give this axis an interval to follow orbits along it",
        );
        return Some(None);
    }
    let named = |section: &Section, key: &str| {
        axis(section, key, (axes, dimensions), (faulty, expressions))
    };
    let (followed, other) = (named(&section, "over"), section.if_given("second", named));
    if let (Some(first), Some(Some(second))) = (followed, other)
        && first == second
    {
        let message = "`continuation.second` is already the axis along which orbits are followed";
        section
            .inconsistent("second", message)
            .label("the same axis")
            .remedy("name another axis, or remove it")
            .report(section.issues);
    }
    let two = section.has("second");
    if !two {
        section.without_effect(
            &["curves"],
            "without `second`: bifurcations are only followed with a second axis",
            "remove it, or name the axis as `second`",
        );
    }
    let curves = section.if_effective(two).choice("curves");
    let spec = all_of!(ContinuationSpec {
        over: followed,
        second: other,
        all_curves: curves.map(|curves| curves == "all"),
        starts: section.integer("starts"),
        transient: section.integer("transient"),
        cycles: section.integer("cycles"),
        longest_period: section.integer("longest_period"),
        guesses: section.integer("guesses"),
        orbits: section.integer("orbits"),
        branches: section.integer("branches"),
        step: section.quantity("step"),
        states: section.each("states", |table| state(table, retained)),
    });
    spec.map(Some)
}

/// The name of an axis that `over` or `second` names, if this axis has only one value.
fn single_valued<'a>(section: &Section, axes: &[&'a Axis]) -> Option<&'a str> {
    ["over", "second"].into_iter().find_map(|key| {
        let Value::Text(name) = &section.entry(key)?.node.value else {
            return None;
        };
        let found = axes.iter().find(|axis| axis.name() == name)?;
        (!found.values.vary()).then(|| found.name())
    })
}

fn state(table: &Section, retained: Option<usize>) -> Option<GivenState> {
    all_of!(GivenState {
        value: table.quantity("at"),
        period: table.integer("period"),
        state: modal_state::read(table, retained),
    })
}

/// The index of the axis that a key names, or by default of the last untied axis with two different values. The drive
/// must depend on the axis continuously. The axis may only be tied to axes given by expressions.
fn axis(
    section: &Section,
    key: &str,
    (axes, dimensions): (&[&Axis], &[GridDimension]),
    (faulty, expressions): (&[String], &[(String, Expression)]),
) -> Option<usize> {
    let derived = |place: usize| (expressions.iter()).any(|(name, _)| axes[place].name() == name);
    // Expressions are evaluated again along a branch.
    let is_tied = |place: usize| {
        let dimension = &dimensions[GridDimension::of(dimensions, place)];
        let given = dimension
            .axes
            .iter()
            .filter(|axis| !derived(**axis))
            .count();
        dimension.sampled || derived(place) || given > 1
    };
    let name = match section.has(key) {
        true => section.text(key)?,
        false if !faulty.is_empty() => return None,
        false => (axes.iter().enumerate())
            .rfind(|(place, axis)| axis.values.vary() && !is_tied(*place))
            .map_or("", |(_, axis)| axis.name()),
    };
    if faulty.iter().any(|fault| fault == name) {
        return None;
    }
    let position = axes.iter().position(|axis| axis.name() == name);
    let fault = match position {
        None if name.is_empty() => Some((
            "no untied axis of the grid has two different values, so orbits cannot be followed along an axis"
                .to_owned(),
            "nothing to follow",
        )),
        None => Some((
            format!("the grid has no axis `{name}` to follow orbits along"),
            "not an axis",
        )),
        Some(place) => match Parameter::named(name) {
            Err(error) => Some((error.to_string(), "not continuous")),
            Ok(_) if is_tied(place) => Some((
                format!("orbits are followed along one key, but `{name}` is tied to other axes or a distribution"),
                "a tied axis",
            )),
            Ok(_) => None,
        },
    };
    let Some((message, label)) = fault else {
        return position;
    };
    let fitting: Vec<&str> = (axes.iter().enumerate())
        .filter(|(place, axis)| {
            axis.values.vary() && !is_tied(*place) && Parameter::named(axis.name()).is_ok()
        })
        .map(|(_, axis)| axis.name())
        .collect();
    let near = schema::nearest(name, &fitting).map(|near| format!("\"{near}\""));
    let remedy = if fitting.is_empty() {
        "give such an axis of [grid] two values: the ends of the interval".to_owned()
    } else {
        let fitting = fitting.join(", ");
        format!("axes of this grid along which orbits can be followed: {fitting}")
    };
    section
        .inconsistent(key, message)
        .label(label)
        .accepted("name load, torque, speed, or a continuous key that the grid varies between two different values")
        .suggestion(near)
        .remedy(remedy)
        .fail(section.issues)
}
