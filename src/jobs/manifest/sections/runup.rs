//! `[runup]`: a run-up or run-down.

use super::analyses::signals;
use crate::analysis::run_up::LoadLaw;
use crate::manifest::columns::{self, Quantities};
use crate::manifest::csv::ListOf;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind};
use crate::manifest::reader::Section;
use crate::manifest::schema::{self, ANY, Key, POSITIVE};
use crate::manifest::spec::{RunUpLoad, RunUpSpec};
use crate::numerics::point_course::{BetweenPoints, PointCourse};
use crate::units::Dimension::{AngularSpeed, Ratio, Time, Torque};
use std::path::Path;

static TIME: Key = schema::quantity("time", Time, ANY, "0.5");
static SPEED: Key = schema::quantity("speed", AngularSpeed, POSITIVE, r#""600 rpm""#);
static LOAD: Key = schema::quantity("load", Ratio, ANY, "0.2");
static TORQUE: Key = schema::quantity("torque", Torque, ANY, r#""10 N m""#);

/// Speed over time, with or without the load.
const POINTS: ListOf = ListOf {
    path: "runup.points",
    row: "{ time = 0, speed = \"600 rpm\", load = 0.2 }",
    header: "time [s],speed [rpm],torque [N m]",
};

/// Load over speed or time.
const LOAD_POINTS: ListOf = ListOf {
    path: "runup.load_points",
    row: "{ speed = \"600 rpm\", load = 0.2 }",
    header: "speed [rpm],torque [N m]",
};

/// The section; `Some(None)` if there is none, `None` if it is faulty. Relative paths start at `base_dir`.
pub(in crate::manifest) fn read(root: &Section, base_dir: &Path) -> Option<Option<RunUpSpec>> {
    let Some(section) = root.child("runup")? else {
        return Some(None);
    };
    let course = course(&section, base_dir);
    let settle = section.quantity("settle");
    let sample_rate = section.integer("sample_rate");
    let revolutions = section.integer("revolutions");
    let orders = section.if_given("orders", |section, name| section.quantities(name, None));
    let frequency_step = section.integer("frequency_step");
    let signals = signals(&section);
    if let (Some(rate), Some(course)) = (sample_rate, &course) {
        fits_in_memory(&section, rate, &course.speed);
    }
    let course = course?;
    Some(Some(RunUpSpec {
        speed: course.speed,
        load: course.load,
        settle: settle?,
        sample_rate: sample_rate?,
        revolutions: revolutions?,
        orders: orders?,
        frequency_step: frequency_step?,
        signals: signals?,
    }))
}

/// How speed and load vary over the run-up.
struct Course {
    speed: PointCourse,
    load: Option<RunUpLoad>,
}

/// Speed and load, each as a line or through points.
fn course(section: &Section, base_dir: &Path) -> Option<Course> {
    let exclusive = [["points", "speed"], ["load_points", "load"]];
    for [list, line] in exclusive {
        if section.has(list) && section.has(line) {
            let message = format!("`{line}` and `{list}` both give the same course");
            return section
                .inconsistent(list, message)
                .label("second course")
                .remedy("keep one of the two")
                .fail(section.issues);
        }
    }
    let Some(entry) = section.entry("points") else {
        let speed = line(section)?;
        let load = load(section, base_dir, &speed, 0.0)?;
        return Some(Course { speed, load });
    };
    let file_columns = columns::read(section.issues, entry, &POINTS, base_dir)?;
    let column_kinds = [&TIME, &SPEED, &LOAD, &TORQUE];
    let mut columns = columns::quantities(section.issues, file_columns, &POINTS, &column_kinds)?;
    let place = (&POINTS, entry.node.span);
    let time = columns::one_of(section.issues, &mut columns, &["time"], place)?;
    let speed = columns::one_of(section.issues, &mut columns, &["speed"], place)?;
    columns::increases(section.issues, &time, &POINTS).then_some(())?;
    let first = time.values[0];
    let speed = through(&time, &speed, first);
    let Some(column) = columns.first() else {
        let load = load(section, base_dir, &speed, first)?;
        return Some(Course { speed, load });
    };
    if let Some(entry) = section.entry("load").or(section.entry("load_points")) {
        let message = format!(
            "`{}` and a column of `points` both give the load",
            entry.key
        );
        return Diagnostic::new(
            DiagnosticKind::Inconsistent,
            column.spans.0,
            POINTS.path,
            message,
        )
        .label("second load")
        .remedy("keep one of the two")
        .fail(section.issues);
    }
    let load = columns::one_of(section.issues, &mut columns, &["load", "torque"], place)?;
    let load = RunUpLoad {
        law: LoadLaw::OverTime(through(&time, &load, first)),
        is_torque: load.name == "torque",
    };
    Some(Course {
        speed,
        load: Some(load),
    })
}

/// A line from one speed to another.
fn line(section: &Section) -> Option<PointCourse> {
    let speed = section.required_child("speed")?;
    let [from, to, duration] = ["from", "to", "in"].map(|name| speed.quantity(name));
    let (from, to) = (from?, to?);
    if from == to {
        return section
            .inconsistent("speed", "both speeds of the run-up are the same")
            .label("no run-up")
            .remedy("give two different speeds; `atlas trace` records a motion at one speed")
            .fail(section.issues);
    }
    Some(PointCourse::line([0.0, from], [duration?, to]))
}

/// The load from the keys for it; `Some(None)` for the load of the operating point. The time `first_time` of a list of
/// points becomes 0.
fn load(
    section: &Section,
    base_dir: &Path,
    speed: &PointCourse,
    first_time: f64,
) -> Option<Option<RunUpLoad>> {
    if let Some(entry) = section.entry("load_points") {
        let file_columns = columns::read(section.issues, entry, &LOAD_POINTS, base_dir)?;
        let column_kinds = [&TIME, &SPEED, &LOAD, &TORQUE];
        let mut columns =
            columns::quantities(section.issues, file_columns, &LOAD_POINTS, &column_kinds)?;
        let place = (&LOAD_POINTS, entry.node.span);
        let over = columns::one_of(section.issues, &mut columns, &["time", "speed"], place)?;
        let load = columns::one_of(section.issues, &mut columns, &["load", "torque"], place)?;
        columns::increases(section.issues, &over, &LOAD_POINTS).then_some(())?;
        let law = match over.name {
            "time" => LoadLaw::OverTime(through(&over, &load, first_time)),
            _ => LoadLaw::OverSpeed(through(&over, &load, 0.0)),
        };
        let is_torque = load.name == "torque";
        return Some(Some(RunUpLoad { law, is_torque }));
    }
    if !section.has("load") {
        return Some(None);
    }
    let [from, to] = section.one_or_pair("load")?;
    let duration = speed.points.last().map_or(0.0, |point| point[0]);
    let law = LoadLaw::OverTime(PointCourse::line([0.0, from], [duration, to]));
    Some(Some(RunUpLoad {
        law,
        is_torque: false,
    }))
}

/// The course of one column over another; the position `zero` becomes 0.
fn through(over: &Quantities, values: &Quantities, zero: f64) -> PointCourse {
    let pairs = over.values.iter().zip(&values.values);
    PointCourse {
        points: pairs.map(|(place, value)| [place - zero, *value]).collect(),
        between: BetweenPoints::Monotone,
    }
}

/// Reports a record that is too long.
fn fits_in_memory(section: &Section, rate: u32, speed: &PointCourse) {
    /// Largest number of samples of one signal: a quarter of a gigabyte.
    const MOST_SAMPLES: f64 = 32e6;
    let longest = MOST_SAMPLES / f64::from(rate);
    let duration = speed.points.last().map_or(0.0, |point| point[0]);
    if duration > longest {
        let name = if section.has("points") { "points" } else { "speed" };
        let message = format!(
            "a run-up of {duration} s at {rate} samples per second is too long: at most {longest:.4} s fit in memory"
        );
        section
            .fault(DiagnosticKind::OutOfRange, name, message)
            .label("too long")
            .remedy("shorten it, or lower runup.sample_rate")
            .report(section.issues);
    }
}
