//! `[excitation.torque_curve]`: torque of an engine over the angle of its shaft.

use super::Context;
use crate::manifest::columns;
use crate::manifest::csv::ListOf;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::schema::{self, ANY, Key};
use crate::manifest::spec::StructureSource;
use crate::manifest::tree::{Entry, Value};
use crate::model::{DriveShaft, TorqueCurve, TorqueRipple};
use crate::units::Dimension::{Angle, Torque};
use std::f64::consts::TAU;

static ANGLE: Key = schema::quantity("angle", Angle, ANY, r#""90 deg""#);
static TORQUE: Key = schema::quantity("torque", Torque, ANY, r#""10 N m""#);

const POINTS: ListOf = ListOf {
    path: "excitation.torque_curve.points",
    row: "{ angle = \"90 deg\", torque = \"10 N m\" }",
    header: "angle [deg],torque [N m]",
};

/// The harmonics of the curve; empty without a curve.
pub(super) fn read(
    excitation: &Section,
    source: Option<&StructureSource>,
    context: &mut Context,
) -> Option<Vec<TorqueRipple>> {
    let Some(section) = excitation.child("torque_curve")? else {
        return Some(Vec::new());
    };
    let shaft = section.variant("shaft");
    let revolutions = section.integer::<u32>("revolutions");
    let harmonics = section.integer("harmonics");
    let points = section.required("points");
    let points = points.and_then(|entry| points_of(entry, excitation.issues, context));
    let shaft = shaft?;
    check_torque_can_act(&section, source, shaft)?;
    let (mut points, period) = (points?, TAU * f64::from(revolutions?));
    if let ([[first, start], .., [last, end]], false) = (&points[..], points.is_empty()) {
        let beyond = last - first - period;
        let repeats = beyond.abs() < 1e-6;
        if repeats && start == end {
            points.pop();
        } else if beyond > -1e-6 {
            let message = if repeats {
                "the curve does not end with the torque with which it starts".to_owned()
            } else {
                format!(
                    "the curve covers {:.6} revolutions, but repeats after {}",
                    (last - first) / TAU,
                    period / TAU
                )
            };
            return Diagnostic::new(
                DiagnosticKind::Inconsistent,
                section.span_of("points"),
                POINTS.path,
                message,
            )
            .label("not one period")
            .remedy("give one period of the torque, and its `revolutions`")
            .fail(excitation.issues);
        }
    }
    let curve = TorqueCurve {
        shaft,
        points,
        period,
    };
    Some(curve.harmonics(harmonics?))
}

/// Angles and torques; a file is read once per job.
fn points_of(entry: &Entry, issues: &Issues, context: &mut Context) -> Option<Vec<[f64; 2]>> {
    let path = match &entry.node.value {
        Value::Text(name) => Some(context.base_dir.join(name)),
        _ => None,
    };
    if let Some(known) = path
        .as_ref()
        .and_then(|path| context.torque_curves.get(path))
    {
        return known.clone();
    }
    let points = pairs(entry, issues, context);
    if let Some(path) = path {
        context.torque_curves.insert(path, points.clone());
    }
    points
}

fn pairs(entry: &Entry, issues: &Issues, context: &Context) -> Option<Vec<[f64; 2]>> {
    let found = columns::read(issues, entry, &POINTS, context.base_dir)?;
    let mut columns = columns::quantities(issues, found, &POINTS, &[&ANGLE, &TORQUE])?;
    let place = (&POINTS, entry.node.span);
    let angle = columns::one_of(issues, &mut columns, &["angle"], place)?;
    let torque = columns::one_of(issues, &mut columns, &["torque"], place)?;
    columns::increases(issues, &angle, &POINTS).then_some(())?;
    let pairs = angle.values.iter().zip(&torque.values);
    Some(pairs.map(|(angle, torque)| [*angle, *torque]).collect())
}

/// Checks that a torque or an imposed motion can act on a shaft. `None` if it cannot, which is reported.
pub(super) fn check_torque_can_act(
    table: &Section,
    source: Option<&StructureSource>,
    shaft: DriveShaft,
) -> Option<()> {
    if let (Some(StructureSource::Train(train)), DriveShaft::Wheel) = (source, shaft) {
        let gear = train.gear(train.gears[1]);
        let refuse = |message: String, label: &str, remedy: &str| -> Option<()> {
            (table
                .inconsistent("shaft", message)
                .label(label)
                .remedy(remedy))
            .fail(table.issues)
        };
        if gear.loose.is_some() {
            return refuse(
                format!(
                    "gear `{}` is loose: its shaft does not turn with the wheel",
                    gear.name
                ),
                "this shaft does not turn at the speed of the wheel",
                "name a mesh in train.gears whose second gear is fixed to its shaft, or remove the torque",
            );
        }
        if !train.planetary.is_empty() {
            return refuse(
                "a drive with planets has no wheel shaft on which a torque or a motion can act"
                    .to_owned(),
                "its first mesh may be that of a planet",
                "let it act on the pinion's shaft, or remove it",
            );
        }
    }
    if let Some(StructureSource::Modal(structure)) = source {
        let (name, columns) = match shaft {
            DriveShaft::Pinion if structure.pinion_torque.is_none() => ("pinion", "torque_pinion"),
            DriveShaft::Wheel
                if structure.wheel_torque.is_none() || structure.wheel_teeth.is_none() =>
            {
                ("wheel", "torque_wheel and teeth_wheel")
            }
            _ => return Some(()),
        };
        let message =
            format!("the modal file does not give the effect of a torque on the {name} shaft");
        return table
            .inconsistent("shaft", message)
            .label("unknown participation")
            .remedy(format!(
                "add {columns} to the modal file, or remove the torque"
            ))
            .fail(table.issues);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::manifest::{self, Parameter};

    const QUICKSTART: &str = include_str!("../../../../manifests/quickstart.toml");

    #[test]
    fn points_outside_the_grid_do_not_read_the_file_again() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("engine.csv");
        std::fs::write(&file, "angle [deg],torque [N m]\n0,1\n90,2\n180,-1\n").unwrap();
        let curve = "[excitation.torque_curve]\npoints = \"engine.csv\"\n";
        let text = format!("{QUICKSTART}\n{curve}");
        let job = manifest::parse(&text, "test.toml", folder.path()).unwrap();
        std::fs::remove_file(&file).unwrap();
        let half_gap = Parameter::named("mesh.half_gap").unwrap();
        let first = job.points.at(0);
        let changed = job.between.changed(&first, &[(&half_gap, 12e-6)]).unwrap();
        assert_eq!(changed.mesh.half_gap, 12e-6);
        assert_eq!(changed.excitation, first.excitation);
    }
}
