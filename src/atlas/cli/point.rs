//! `--point ID` or `--point AXIS=VALUE,…`: one operating point of a manifest, on its grid or off it.
//!
//! Load or torque and speed may have any value. Every other axis is part of the resolved model, so that only values of
//! the grid are possible. An axis with a single value may be omitted. An axis that is tied to named axes may also be
//! omitted, if the named values determine its value. If the state is carried along an axis, `direction=up` or `down`
//! selects the sweep to the point.

use super::{BAD_INPUT, fail};
use crate::manifest::{Axis, AxisKey, Direction, GridDimension, Job, PointSpec};
use crate::report::{Unit, to_digits};
use crate::units::{self, Dimension};
use clap::Args;
use std::collections::BTreeMap;
use std::process::ExitCode;

/// The operating point of a command.
#[derive(Debug, Args)]
pub struct PointArg {
    /// Use this operating point: its point_id, or values of axes such as load=0.05,speed="9000 rpm". Load and speed
    /// may take any value, other axes a value of the grid. A bare number is in SI. Axes with a single value may be
    /// omitted. If the manifest carries the state along an axis, add direction=up or direction=down to start from the
    /// sweep up to this point.
    #[arg(
        long = "point",
        value_name = "ID|AXIS=VALUE,...",
        default_value = "",
        hide_default_value = true
    )]
    pub text: String,
}

/// A chosen operating point.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenPoint {
    /// The point to simulate.
    pub spec: PointSpec,
    /// Name of every axis and its value, SI.
    pub values: Vec<(String, f64)>,
    /// The sweep that leads to the point; `None` for a start from `run.initial`.
    pub direction: Option<Direction>,
    /// For file names: the named axes with their values as typed and the direction, `load-0.05-up`, or the `point_id`.
    pub label: String,
}

/// Why a text is not an operating point of a manifest.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PointError {
    /// A part without an equals sign, or with more than one value.
    #[error(
        "`{part}` is not of the form AXIS=VALUE; write for example --point load=0.05,speed=1200, with \
         decimal points and commas between axes"
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
        /// The error.
        reason: String,
        /// Accepted values.
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
    /// A value outside the grid, for an axis that allows only the grid's values.
    #[error(
        "{name} is {value}, which is not a value of the grid ({values}); choose one of these, or add this value to the manifest"
    )]
    NotOnGrid {
        /// The axis.
        name: String,
        /// Its value, with the unit of the manifest.
        value: String,
        /// The values of the grid, in the same unit.
        values: String,
    },
    /// A direction that the manifest does not sweep.
    #[error("direction is {value}, but {}", match known.as_str() {
        "" => "the points of this manifest are independent; remove direction".to_owned(),
        known => format!("this manifest sweeps {known}"),
    })]
    NotADirection {
        /// As typed.
        value: String,
        /// The directions of the manifest.
        known: String,
    },
    /// Axes with several values that were not given.
    #[error("the point needs a value for {axes}; add it to --point, for example --point {example}")]
    Missing {
        /// The axes with their values.
        axes: String,
        /// A valid argument.
        example: String,
    },
    /// A `point_id` that the manifest does not have.
    #[error("there is no point {id}: this manifest has {points} points, counted from 0")]
    NoSuchId {
        /// As typed.
        id: usize,
        /// Points of the manifest.
        points: usize,
    },
    /// Values at which the grid has no point.
    #[error("the grid has no point at these values; its axes are {axes}")]
    OffGrid {
        /// The axes with their values.
        axes: String,
    },
}

/// Largest number of values of an axis that a message lists.
const LISTED: usize = 24;

/// Largest relative distance of a typed value from a value of the grid: half a unit in the last digit that messages
/// show.
const TYPING_TOLERANCE: f64 = 5e-7;

/// The point of a job from an argument. On failure, prints all errors and returns the exit status.
pub fn read_point(job: &Job, text: &str) -> Result<ChosenPoint, ExitCode> {
    choose(job, text).map_err(|errors| fail(BAD_INPUT, &joined(&errors)))
}

/// The `point_id` of the grid point from an argument.
///
/// # Errors
/// All errors in the text, as lines of an error message.
pub fn id(job: &Job, text: &str) -> Result<u64, String> {
    let chosen = choose(job, text).map_err(|errors| joined(&errors))?;
    let same = |point: &PointSpec| {
        let mut values = point.axis_values.iter().zip(&chosen.spec.axis_values);
        (chosen.direction.is_none() || chosen.direction == point.direction)
            && values.all(|(value, typed)| is_near(*value, *typed))
    };
    let point = job.points.iter().find(same);
    point.map(|point| point.point_id).ok_or_else(|| {
        let axes = all_ranged(job);
        PointError::OffGrid { axes }.to_string()
    })
}

fn joined(errors: &[PointError]) -> String {
    let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
    lines.join("\nerror: ")
}

/// The point with the `point_id` `id`, with its sweep direction.
fn numbered(job: &Job, id: usize) -> Result<ChosenPoint, PointError> {
    let points = job.points.len();
    if id >= points {
        return Err(PointError::NoSuchId { id, points });
    }
    let spec = job.points.at(id);
    let (values, direction) = (spec.axis_values.clone(), spec.direction);
    let typed = vec![None; job.axes.len()];
    Ok(ChosenPoint {
        label: id.to_string(),
        ..chosen(job, spec, &values, &typed, direction)
    })
}

/// The point of `job` from `text`.
///
/// # Errors
/// All errors in the text.
fn choose(job: &Job, text: &str) -> Result<ChosenPoint, Vec<PointError>> {
    if let Ok(id) = text.trim().parse() {
        return numbered(job, id).map_err(|error| vec![error]);
    }
    let units = job.written().axis_units();
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
                axes: all_ranged(job),
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
        match read(&job.axes[index], value.trim(), &units) {
            Ok(number) => typed[index] = Some((value.trim(), number)),
            Err(error) => errors.push(error),
        }
    }
    let mut values: Vec<Option<f64>> = typed.iter().map(|typed| Some(typed.as_ref()?.1)).collect();
    for dimension in &job.dimensions {
        fill(job, dimension, &mut values);
    }
    let missing: Vec<&Axis> = (job.axes.iter().zip(&named).zip(&values))
        .filter(|((axis, named), value)| !**named && value.is_none() && axis.values.len() > 1)
        .map(|((axis, _), _)| axis)
        .collect();
    // A misspelt name counts as one error, not also as a missing axis.
    let misspelt = |error: &PointError| matches!(error, PointError::UnknownAxis { .. });
    if !missing.is_empty() && !errors.iter().any(misspelt) {
        errors.push(PointError::Missing {
            axes: list(missing.into_iter().map(|axis| ranged(axis, &units))),
            example: example(job, &typed, &units),
        });
    }
    let values: Vec<f64> = (job.axes.iter().zip(&values))
        .map(|(axis, value)| value.unwrap_or_else(|| axis.values.get(0)))
        .collect();
    let spec = job.points.iter().find(|point| {
        let mut fixed = job.axes.iter().zip(&point.axis_values).zip(&values);
        (direction.is_none() || direction == point.direction)
            && fixed.all(|((axis, on_grid), value)| {
                allows_values_outside_grid(axis) || on_grid == value
            })
    });
    match spec {
        Some(spec) if errors.is_empty() => Ok(chosen(job, spec, &values, &typed, direction)),
        // Each value exists, but in different rows of a list.
        None if errors.is_empty() => Err(vec![PointError::OffGrid {
            axes: all_ranged(job),
        }]),
        _ => Err(errors),
    }
}

/// Fills in the axes of a group of tied axes that the argument does not name. They get the values at the
/// position of the named axes. If several positions fit, nothing is filled in unless all of them have equal
/// values.
fn fill(job: &Job, tied: &GridDimension, values: &mut [Option<f64>]) {
    let of = |axis: usize, place: usize| job.axes[axis].values.get(place);
    let fits = |place: &usize| {
        (tied.axes.iter())
            .all(|&axis| values[axis].is_none_or(|value| is_near(of(axis, *place), value)))
    };
    if tied.axes.iter().all(|&axis| values[axis].is_none()) {
        return;
    }
    let mut found = (0..tied.length).filter(fits);
    let equal =
        |one: usize, other: usize| (tied.axes.iter()).all(|&axis| of(axis, one) == of(axis, other));
    if let Some(place) = found.next()
        && found.all(|other| equal(place, other))
    {
        for &axis in &tied.axes {
            values[axis].get_or_insert(of(axis, place));
        }
    }
}

/// The parts of the text between commas. A text without an equals sign is kept in the part before it, so that
/// a message about a decimal comma (`load=0,05`) can show the whole value. Commas in brackets separate
/// nothing.
fn parts(text: &str) -> Vec<&str> {
    let mut ends: Vec<usize> = (text.match_indices(',').map(|(at, _)| at))
        .filter(|&at| {
            let rest = &text[at + 1..];
            let inside = |text: &str| text.rfind('[') > text.rfind(']');
            if inside(&text[..at]) {
                return false;
            }
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
                'a'..='z' | 'A'..='Z' | '0'..='9' | '.' | '-' | '+' | '%' => c,
                _ => '_',
            })
            .collect(),
    }
}

fn read_direction(job: &Job, text: &str) -> Result<Direction, PointError> {
    let known = job.carried.as_ref().map_or(&[][..], |c| &c.directions);
    let direction = known.iter().find(|known| known.name() == text);
    direction.copied().ok_or_else(|| PointError::NotADirection {
        value: text.into(),
        known: match known {
            [] => String::new(),
            known => list(known.iter().map(|known| known.name().to_owned())),
        },
    })
}

/// Whether an axis may have values outside the grid.
fn allows_values_outside_grid(axis: &Axis) -> bool {
    !axis.key.is_model_key()
}

/// Converts the typed value of an axis to SI. An axis with a model key takes only values of the grid.
fn read(axis: &Axis, text: &str, units: &Units) -> Result<f64, PointError> {
    let value = quantity(axis, text)?;
    if allows_values_outside_grid(axis) {
        return if value > 0.0 || axis.key != AxisKey::Speed {
            Ok(value)
        } else {
            Err(PointError::NotPositive {
                name: axis.name().to_owned(),
                value,
            })
        };
    }
    let found = axis.values.iter().find(|on_grid| is_near(*on_grid, value));
    found.ok_or_else(|| PointError::NotOnGrid {
        name: axis.name().to_owned(),
        value: shown(axis, units).amount(number, value),
        values: listed(axis, units),
    })
}

/// Whether a typed value equals a value of the grid, to the digits that messages show.
fn is_near(on_grid: f64, value: f64) -> bool {
    (on_grid - value).abs() <= TYPING_TOLERANCE * value.abs()
}

fn quantity(axis: &Axis, text: &str) -> Result<f64, PointError> {
    let dimension = match axis.unit.as_str() {
        "1" => Some(Dimension::Ratio),
        // `None` if the unit has no known dimension: then the axis takes only bare numbers.
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

/// A valid argument: the typed values, and the first value of each missing axis.
fn example(job: &Job, typed: &[Option<(&str, f64)>], units: &Units) -> String {
    let parts: Vec<String> = (job.axes.iter().zip(typed))
        .filter(|(axis, typed)| typed.is_some() || axis.values.len() > 1)
        .map(|(axis, typed)| match typed {
            Some((text, _)) => format!("{}={text}", axis.name()),
            None => {
                let first = shown(axis, units).amount(number, axis.values.get(0));
                format!("{}={first}", axis.name())
            }
        })
        .collect();
    let text = parts.join(",");
    if text.contains(char::is_whitespace) { format!("\"{text}\"") } else { text }
}

/// `load (any value; the grid has 0.1 ... 0.3)` for an axis that allows other values, else all values of the
/// grid.
fn ranged(axis: &Axis, units: &Units) -> String {
    let values = if allows_values_outside_grid(axis) && axis.values.len() > 1 {
        let (low, high) = axis.values.ends();
        let unit = shown(axis, units);
        let low = number(low * unit.factor);
        format!(
            "any value; the grid has {low} ... {}",
            unit.amount(number, high)
        )
    } else {
        listed(axis, units)
    };
    format!("{} ({values})", axis.name())
}

fn all_ranged(job: &Job) -> String {
    let units = job.written().axis_units();
    list(job.axes.iter().map(|axis| ranged(axis, &units)))
}

/// Units of the axes in the manifest, by name.
type Units = BTreeMap<String, String>;

/// The unit in which values of an axis are shown.
fn shown(axis: &Axis, units: &Units) -> Unit {
    Unit::of_axis(units, axis.name(), &axis.unit)
}

/// All values of an axis, or the first [`LISTED`] and the number of the others.
fn listed(axis: &Axis, units: &Units) -> String {
    let unit = shown(axis, units);
    let values = axis.values.iter().take(LISTED);
    let mut values: Vec<String> = values.map(|value| number(value * unit.factor)).collect();
    if axis.values.len() > LISTED {
        values.push(format!("and {} more", axis.values.len() - LISTED));
    }
    unit.after(&values.join(", "))
}

/// A number with seven significant digits; they distinguish the values of a grid.
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
