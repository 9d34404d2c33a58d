//! `--point axis=value,…`: one operating point of a manifest, on its grid or off it.
//!
//! Load or torque and speed may take any value. Every other axis goes into the resolved model, so
//! that only values of the grid exist. An axis with a single value need not be named, nor one that is tied to others
//! that are, where these are at one point of the grid. Where
//! the state is carried along an axis, `direction=up` or `down` asks for the point as the sweep
//! meets it.

use super::{BAD_INPUT, fail};
use crate::manifest::{Axis, AxisKey, Direction, GridDimension, Job, PointSpec};
use crate::report::to_digits;
use crate::units::{self, Dimension};
use std::process::ExitCode;

/// An operating point that was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenPoint {
    /// What to simulate.
    pub spec: PointSpec,
    /// Name of every axis and its value, SI.
    pub values: Vec<(String, f64)>,
    /// The sweep asked for; none for a start from `run.initial`.
    pub direction: Option<Direction>,
    /// The axes named, with their values as typed, fit for a file name.
    pub label: String,
}

/// Why a text is not an operating point of a manifest.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PointError {
    /// A part without an equals sign, or with more than one value.
    #[error(
        "`{part}` is not of the form axis=value; write for example --point load=0.05,speed=1200, with decimal points and a comma between axes"
    )]
    NoAssignment {
        /// The part.
        part: String,
    },
    /// A name that is not an axis.
    #[error("the grid has no axis `{name}`; its axes are {axes}")]
    UnknownAxis {
        /// The name.
        name: String,
        /// All axes with their values.
        axes: String,
    },
    /// An axis given more than once.
    #[error("`{name}` is given twice; keep one of the two")]
    Twice {
        /// The axis.
        name: String,
    },
    /// Not a quantity of the axis's kind.
    #[error("{name}: {reason}; give {accepted}")]
    NotAValue {
        /// The axis.
        name: String,
        /// What is wrong.
        reason: String,
        /// What would be accepted.
        accepted: String,
    },
    /// A speed that is not positive.
    #[error("{name} is {value}, but must be greater than 0")]
    NotPositive {
        /// The axis.
        name: String,
        /// Its value, SI.
        value: f64,
    },
    /// A value that the grid does not have, of an axis that may only take the grid's.
    #[error(
        "{name} is {value}, which is not on the grid ({values}); choose a value of the grid, or add this one to the manifest"
    )]
    NotOnGrid {
        /// The axis.
        name: String,
        /// Its value, SI.
        value: String,
        /// The grid's values.
        values: String,
    },
    /// A direction in which nothing is swept.
    #[error("direction is {value}, but {}", match known.as_str() {
        "" => "the points of this manifest are independent; leave direction out".to_owned(),
        known => format!("this manifest sweeps {known}"),
    })]
    NotADirection {
        /// As typed.
        value: String,
        /// The directions of the manifest.
        known: String,
    },
    /// Axes with several values that were not given.
    #[error("the point needs a value for {axes}; add it to --point, as in --point {example}")]
    Missing {
        /// The axes with their values.
        axes: String,
        /// A valid argument.
        example: String,
    },
}

/// Values of an axis that a message lists.
const LISTED: usize = 24;

/// How near to a value of the grid a typed one must be, relative: half a unit in the last
/// digit that messages show.
const NEAR: f64 = 5e-7;

/// The point of a job that an argument names; the exit status where it names none, everything wrong
/// being told.
pub fn admit(job: &Job, text: &str) -> Result<ChosenPoint, ExitCode> {
    choose(job, text).map_err(|errors| {
        let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
        fail(BAD_INPUT, &lines.join("\nerror: "))
    })
}

/// The point of `job` that `text` names.
///
/// # Errors
/// Everything that is wrong with the text.
fn choose(job: &Job, text: &str) -> Result<ChosenPoint, Vec<PointError>> {
    let mut errors = Vec::new();
    let mut typed: Vec<Option<(&str, f64)>> = vec![None; job.axes.len()];
    let mut named = vec![false; job.axes.len()];
    let mut direction = None;
    for part in parts(text) {
        let Some((name, value)) = part.split_once('=') else {
            errors.push(PointError::NoAssignment { part: part.into() });
            continue;
        };
        let name = name.trim().trim_matches('"');
        if name == "direction" {
            if direction.is_some() {
                errors.push(PointError::Twice { name: name.into() });
            }
            match read_direction(job, value.trim()) {
                Ok(found) => direction = Some(found),
                Err(error) => errors.push(error),
            }
            continue;
        }
        let Some(index) = job.axes.iter().position(|axis| axis.name() == name) else {
            errors.push(PointError::UnknownAxis {
                name: name.into(),
                axes: list(job.axes.iter().map(ranged)),
            });
            continue;
        };
        if std::mem::replace(&mut named[index], true) {
            errors.push(PointError::Twice { name: name.into() });
            continue;
        }
        if value.contains([',', '=']) {
            errors.push(PointError::NoAssignment { part: part.into() });
            continue;
        }
        match read(&job.axes[index], value.trim()) {
            Ok(number) => typed[index] = Some((value.trim(), number)),
            Err(error) => errors.push(error),
        }
    }
    let mut values: Vec<Option<f64>> = typed.iter().map(|typed| Some(typed.as_ref()?.1)).collect();
    for own in &job.dimensions {
        fill(job, own, &mut values);
    }
    let missing: Vec<&Axis> = (job.axes.iter().zip(&named).zip(&values))
        .filter(|((axis, named), value)| !**named && value.is_none() && axis.values.len() > 1)
        .map(|((axis, _), _)| axis)
        .collect();
    // A misspelt name is one fault, not an unknown and a missing one.
    let misspelt = |error: &PointError| matches!(error, PointError::UnknownAxis { .. });
    if !missing.is_empty() && !errors.iter().any(misspelt) {
        errors.push(PointError::Missing {
            axes: list(missing.into_iter().map(ranged)),
            example: example(job, &typed),
        });
    }
    let values: Vec<f64> = (job.axes.iter().zip(&values))
        .map(|(axis, value)| value.unwrap_or_else(|| axis.values.get(0)))
        .collect();
    let spec = job.points.iter().find(|point| {
        let fixed = job.axes.iter().zip(&point.axis_values).zip(&values);
        let same_way = direction.is_none() || direction == point.direction;
        same_way
            && fixed
                .filter(|((axis, _), _)| !is_free(axis))
                .all(|((_, on_grid), value)| on_grid == value)
    });
    match spec {
        Some(spec) if errors.is_empty() => Ok(chosen(job, spec, &values, &typed, direction)),
        _ => Err(errors),
    }
}

/// Gives tied axes that are not named the values that they have where those named have theirs, if that is at one
/// place, or at equal ones.
fn fill(job: &Job, own: &GridDimension, values: &mut [Option<f64>]) {
    let of = |axis: usize, place: usize| job.axes[axis].values.get(place);
    let fits = |place: &usize| {
        let mut given = own
            .axes
            .iter()
            .filter_map(|&axis| Some((axis, values[axis]?)));
        given.all(|(axis, value)| is_near(of(axis, *place), value))
    };
    if own.axes.iter().all(|&axis| values[axis].is_none()) {
        return;
    }
    let mut found = (0..own.length).filter(fits);
    let equal =
        |one: usize, other: usize| (own.axes.iter()).all(|&axis| of(axis, one) == of(axis, other));
    if let Some(place) = found.next()
        && found.all(|other| equal(place, other))
    {
        for &axis in &own.axes {
            values[axis].get_or_insert(of(axis, place));
        }
    }
}

/// The parts of the text between commas; what has no equals sign belongs to what comes
/// before it, so that a decimal comma shows as one.
fn parts(text: &str) -> Vec<&str> {
    let mut ends: Vec<usize> = (text.match_indices(',').map(|(at, _)| at))
        .filter(|&at| {
            let rest = &text[at + 1..];
            let part = rest.split(',').next().unwrap_or(rest);
            part.contains('=') || part.trim().is_empty()
        })
        .collect();
    ends.push(text.len());
    let mut start = 0;
    let mut parts = Vec::with_capacity(ends.len());
    for end in ends {
        parts.push(text[start..end].trim());
        start = (end + 1).min(text.len());
    }
    parts.retain(|part| !part.is_empty());
    parts
}

fn chosen(
    job: &Job,
    mut spec: PointSpec,
    values: &[f64],
    typed: &[Option<(&str, f64)>],
    direction: Option<Direction>,
) -> ChosenPoint {
    for (axis, &value) in job.axes.iter().zip(values) {
        match axis.key {
            AxisKey::Load => spec.load = value,
            AxisKey::Torque => spec.load = spec.model.load_of_torque(value),
            AxisKey::Speed => spec.speed = value,
            AxisKey::Key(_) => {}
        }
    }
    spec.axis_values = values.to_vec();
    let names = job.axes.iter().map(|axis| axis.name().to_owned());
    let label: Vec<String> = (job.axes.iter().zip(typed))
        .filter_map(|(axis, typed)| typed.map(|(text, _)| format!("{}-{text}", axis.name())))
        .chain(direction.map(|direction| direction.name().to_owned()))
        .collect();
    ChosenPoint {
        spec,
        values: names.zip(values.iter().copied()).collect(),
        direction,
        label: label
            .join("-")
            .chars()
            .filter(|c| !c.is_whitespace())
            .map(|c| match c {
                _ if c.is_ascii_alphanumeric() => c,
                '.' | '-' | '+' | '%' => c,
                _ => '_',
            })
            .collect(),
    }
}

fn read_direction(job: &Job, text: &str) -> Result<Direction, PointError> {
    let known = job.carried.as_ref().map_or(&[][..], |c| &c.directions);
    let found = known.iter().find(|known| known.name() == text);
    found.copied().ok_or_else(|| PointError::NotADirection {
        value: text.into(),
        known: match known {
            [] => String::new(),
            known => list(known.iter().map(|known| known.name().to_owned())),
        },
    })
}

/// Whether an axis may take values that the grid does not have.
fn is_free(axis: &Axis) -> bool {
    !axis.key.is_model_key()
}

/// A value of an axis as typed, in SI.
fn read(axis: &Axis, text: &str) -> Result<f64, PointError> {
    let value = quantity(axis, text)?;
    if is_free(axis) {
        return match value > 0.0 || axis.key != AxisKey::Speed {
            true => Ok(value),
            false => Err(PointError::NotPositive {
                name: axis.name().to_owned(),
                value,
            }),
        };
    }
    let found = axis.values.iter().find(|on_grid| is_near(*on_grid, value));
    found.ok_or_else(|| PointError::NotOnGrid {
        name: axis.name().to_owned(),
        value: with_unit(number(value), axis),
        values: listed(axis),
    })
}

/// Whether a value is one of the grid to the digits that messages show.
fn is_near(on_grid: f64, value: f64) -> bool {
    (on_grid - value).abs() <= NEAR * value.abs()
}

fn quantity(axis: &Axis, text: &str) -> Result<f64, PointError> {
    let dimension = match axis.unit.as_str() {
        "1" => Some(Dimension::Ratio),
        // None where the axis takes bare numbers only.
        unit => units::parse_any(&format!("1 {unit}")).ok().map(|(_, d)| d),
    };
    let parsed = match (text.parse::<f64>(), dimension) {
        (Ok(value), _) if value.is_finite() => Ok(value),
        (Ok(_), _) => Err(format!("`{text}` is not finite")),
        (Err(_), Some(dimension)) => units::parse(text, dimension).map_err(|e| e.to_string()),
        (Err(_), None) => Err(format!("`{text}` is not a number")),
    };
    parsed.map_err(|reason| {
        let unit = match axis.unit.as_str() {
            "1" => String::new(),
            unit => format!(" in {unit}"),
        };
        let units = match dimension.map_or("", Dimension::units) {
            "" => String::new(),
            units => format!(", or one with a unit ({units})"),
        };
        PointError::NotAValue {
            name: axis.name().to_owned(),
            reason,
            accepted: format!("a bare number{unit}{units}"),
        }
    })
}

/// A valid argument: what was typed, and the first value of each axis that was not.
fn example(job: &Job, typed: &[Option<(&str, f64)>]) -> String {
    let parts: Vec<String> = (job.axes.iter().zip(typed))
        .filter(|(axis, typed)| typed.is_some() || axis.values.len() > 1)
        .map(|(axis, typed)| match typed {
            Some((text, _)) => format!("{}={text}", axis.name()),
            None => format!("{}={}", axis.name(), number(axis.values.get(0))),
        })
        .collect();
    let text = parts.join(",");
    match text.contains(char::is_whitespace) {
        true => format!("\"{text}\""),
        false => text,
    }
}

/// `load (0.1 ... 0.3)` where any value will do, else all values.
fn ranged(axis: &Axis) -> String {
    let values = match is_free(axis) && axis.values.len() > 1 {
        true => {
            let (low, high) = axis.values.ends();
            let span = format!("{} ... {}", number(low), number(high));
            format!("any value; the grid has {}", with_unit(span, axis))
        }
        false => listed(axis),
    };
    format!("{} ({values})", axis.name())
}

/// All values of an axis, or as many as one reads.
fn listed(axis: &Axis) -> String {
    let mut shown: Vec<String> = axis.values.iter().take(LISTED).map(number).collect();
    if axis.values.len() > LISTED {
        shown.push(format!("and {} more", axis.values.len() - LISTED));
    }
    with_unit(shown.join(", "), axis)
}

fn with_unit(text: String, axis: &Axis) -> String {
    match axis.unit.as_str() {
        "1" => text,
        unit => format!("{text} {unit}"),
    }
}

/// A number with seven digits, which tell the values of a grid apart.
pub fn number(value: f64) -> String {
    to_digits(value, 7)
}

/// `a`, `a and b`, `a, b and c`.
fn list(items: impl Iterator<Item = String>) -> String {
    let mut items: Vec<String> = items.collect();
    match items.pop() {
        Some(last) if items.is_empty() => last,
        Some(last) => format!("{} and {last}", items.join(", ")),
        None => "none".to_owned(),
    }
}
