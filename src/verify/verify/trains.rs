//! Trains of gears: frequencies of a planetary set as published, and cycles of rattling trains with several meshes.

use super::kernels::{ExactTrajectory, Truths, compare};
use super::report::worse;
use super::{CheckError, Line, Subjects, drives};
use crate::analysis::Frequencies;
use crate::model::Model;
use crate::store::TableStore;
use crate::sweep::Prepared;
use std::f64::consts::TAU;

const PLANETARY: &str = include_str!("../../../tests/data/lin-parker.toml");
const PUBLISHED: &str = include_str!("../../../tests/data/planetary-modes.toml");
const TWO_STAGE: &str = include_str!("../../../manifests/trains/two-stage.toml");

/// Number of planets of the compared set.
const PLANETS: i64 = 4;

/// Published frequencies of a family of modes \[Hz\].
fn family(set: &toml::Table, name: &str) -> Result<Vec<f64>, CheckError> {
    let column = set.get(name).and_then(toml::Value::as_array);
    let column = column.ok_or(CheckError::Missing {
        what: "a family of published frequencies",
    })?;
    Ok(column.iter().filter_map(toml::Value::as_float).collect())
}

/// Compares the natural frequencies in contact of a planetary set with four planets. Each frequency of the torsional modes
/// occurs once, and each one of the modes that move the axes twice. The frequencies of the modes in which only planets move
/// occur as often as the number of planets exceeds three: here once.
pub fn planetary(_: &Subjects) -> Result<Vec<Line>, CheckError> {
    const MISSING: CheckError = CheckError::Missing {
        what: "the published planetary set",
    };
    let table: toml::Table = PUBLISHED.parse().map_err(|_| MISSING)?;
    let sets = table.get("lin_parker").and_then(toml::Value::as_array);
    let mut sets = sets
        .ok_or(MISSING)?
        .iter()
        .filter_map(toml::Value::as_table);
    let has_planets =
        |set: &&toml::Table| set.get("planets").and_then(toml::Value::as_integer) == Some(PLANETS);
    let set = sets.find(has_planets).ok_or(MISSING)?;
    let model = of_manifest(PLANETARY, &[], 0)?;
    let found = Frequencies::of(&model).closed;
    let found: Vec<f64> = found.iter().map(|own| own.mode.frequency / TAU).collect();
    let families = [
        ("simple", 1, "torsion"),
        ("double", 2, "motion of the axes"),
        ("planet", 1, "planets alone"),
    ];
    let mut lines = Vec::new();
    for (name, times, kind) in families {
        let published = family(set, name)?;
        let mut worst = 0.0f64;
        for frequency in &published {
            let mut off: Vec<f64> = found
                .iter()
                .map(|other| (other / frequency - 1.0).abs())
                .collect();
            off.sort_by(f64::total_cmp);
            // The set may have further motions out of the plane at the same frequency.
            worst = worse(worst, off.get(times - 1).copied().unwrap_or(f64::NAN));
        }
        lines.push(Line::at_most(
            format!("planetary set, {} frequencies, {kind}", published.len()),
            "Lin & Parker 1999",
            worst,
            5e-4,
            "relative",
        ));
    }
    Ok(lines)
}

/// The model of a point of a manifest with some changed keys.
fn of_manifest(text: &str, changes: &[&str], point: usize) -> Result<Model, CheckError> {
    let job = drives::read(text, "train.toml", changes)?;
    let parts = Prepared::new(TableStore::in_memory());
    Ok(parts.model(&job.points.at(point)).map_err(Box::new)?)
}

/// Compares single mesh cycles of trains: state, event times, sequence of events.
pub fn trains(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let cycles = subjects.extent.pick(3, 60);
    let models = [
        (
            "two stages, 10 modes",
            of_manifest(TWO_STAGE, &["model.modes=10"], 3)?,
        ),
        (
            "four planets, 42 modes",
            of_manifest(PLANETARY, &["grid.speed=800"], 0)?,
        ),
    ];
    let mut truths = Vec::new();
    for (name, model) in models {
        let start = drives::disturbed(&model);
        truths.push(Truths {
            name: name.to_owned(),
            trajectories: vec![ExactTrajectory::new(model, start, cycles)?],
        });
    }
    compare(subjects, &truths, 2e-12)
}
