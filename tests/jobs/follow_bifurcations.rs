//! Bifurcations that `atlas follow` must find, each at the value of an independent computation.

#![allow(clippy::unwrap_used)]

use crate::program;
use gearatlas::store::{ResultTable, TableKind};
use program::said;
use std::fs;

/// A row of `bifurcations.parquet`.
#[derive(Debug, Clone, PartialEq)]
struct Found {
    kind: String,
    /// Period of the orbit \[cycles\].
    period: u64,
    /// Speed \[rad/s\].
    at: f64,
    detail: String,
}

/// Results of `atlas follow`, including ends of branches, sorted by speed.
fn follow(modal: &str, manifest: &str) -> Vec<Found> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.modal.toml"), modal).unwrap();
    fs::write(folder.path().join("m.toml"), manifest).unwrap();
    said(
        folder.path(),
        &["follow", "m.toml", "--quiet", "--out", "r"],
    );
    let table = ResultTable::read(&folder.path().join("r"), TableKind::Bifurcations).unwrap();
    let (kinds, details) = (table.text("kind").unwrap(), table.text("detail").unwrap());
    let (periods, speeds) = (table.u64("period").unwrap(), table.f64("speed").unwrap());
    let mut rows: Vec<Found> = (0..table.rows())
        .map(|row| Found {
            kind: kinds[row].clone().unwrap(),
            period: periods[row].unwrap(),
            at: speeds[row].unwrap(),
            detail: details[row].clone().unwrap_or_default(),
        })
        .collect();
    rows.sort_by(|a, b| a.at.total_cmp(&b.at));
    rows
}

#[track_caller]
fn holds(found: &[Found], kind: &str, period: u64, at: f64, within: f64) {
    let own =
        |own: &&Found| own.kind == kind && own.period == period && (own.at - at).abs() < within;
    let times = found.iter().filter(own).count();
    assert_eq!(times, 1, "{kind} of period {period} at {at}: {found:#?}");
}

/// The shipped cascade of an oscillator against a stop. Intervals shrink by ratios that approach Feigenbaum's 4.6692.
#[test]
fn six_doublings_approach_the_ratio_of_feigenbaum() {
    let modal = include_str!("../../manifests/oscillators/stop.modal.toml");
    let manifest = include_str!("../../manifests/oscillators/doublings.toml")
        .replace("stop.modal.toml", "s.modal.toml");
    let mut doublings = follow(modal, &manifest);
    doublings.retain(|own| own.kind == "period_doubling");
    let periods: Vec<u64> = doublings.iter().map(|own| own.period).collect();
    assert_eq!(periods, [2, 4, 8, 16, 32, 64], "{doublings:#?}");
    let intervals: Vec<f64> = doublings
        .windows(2)
        .map(|two| two[1].at - two[0].at)
        .collect();
    let ratios: Vec<f64> = intervals.windows(2).map(|two| two[0] / two[1]).collect();
    assert!(
        ratios.is_sorted() && (ratios[3] / 4.6692 - 1.0).abs() < 0.06,
        "{ratios:?}"
    );
}

/// Two flanks, one mode, a force of 60 N. A branch closes a second contact at a graze at 92.1793 rad/s and folds just
/// after it at 92.17664307 rad/s, by arclength continuation with Runge-Kutta steps. The period doublings at both ends
/// of an interval of doubled orbits have one branch, not two.
#[test]
fn a_fold_beside_a_graze_is_found_and_every_branch_once() {
    let modal = "teeth = 20\nrated_force = 200.0\nfrequency = [3000.0]\ndamping = [0.03]\nmesh = [1.0]\ntorque = [1.0]\n\
                 [[harmonic_load]]\nname = \"s\"\nforce = [60.0]\ncycles = [1, 1]\n";
    let manifest = r#"
job.name = "graze"
model = { kind = "modal", file = "s.modal.toml" }
mesh = { half_gap = 1e-5, stiffness = "constant", mean_stiffness = 6e7, contact_damping = "300 N*s/m", coast_flank = "same_line" }
grid = { load = 0.1, speed = { from = 60, to = 400, count = 18 } }
run = { transient = 300, cycles = 2000 }
continuation = { over = "speed", starts = 8, longest_period = 4 }
"#;
    let found = follow(modal, manifest);
    holds(&found, "fold", 1, 92.176_643_07, 1e-7);
    let jumps: Vec<&Found> = found.iter().filter(|own| own.kind == "jump").collect();
    assert!(jumps.is_empty(), "{jumps:?}");
    let own: Vec<&Found> = (found.iter())
        .filter(|own| own.kind != "end" && own.kind != "merging")
        .collect();
    for pair in own.windows(2) {
        let again = pair[0].kind == pair[1].kind
            && pair[0].period == pair[1].period
            && (pair[0].at - pair[1].at).abs() < 1e-7;
        assert!(!again, "{pair:?}");
    }
}

/// An oscillator against a stop 30 times as stiff doubles its period from 4 to 64. The values are from Newton's method
/// on `det(M + I)` for each period, from a trajectory that starts there.
#[test]
fn no_branch_of_a_cascade_is_lost() {
    let modal = "teeth = 1\nrated_force = 1.0\nfrequency = [1.0]\ndamping = [0.05]\nmesh = [1.0]\ntorque = [1.0]\n\
                 torque_pinion = [1.0]\n\
                 [[contact]]\nname = \"stop\"\nparticipation = [1.0]\ngap = 0.0\nstiffness = 30.0\n";
    let manifest = |longest: u32| {
        format!(
            r#"
job.name = "cascade"
model = {{ kind = "modal", file = "s.modal.toml" }}
mesh = {{ half_gap = 10, stiffness = "constant", mean_stiffness = 1, contact_damping = 0 }}
excitation.torque_ripple = [{{ shaft = "pinion", order = 1, amplitude = 1.0 }}]
grid = {{ load = 0, speed = {{ from = 2.65, to = 3.2, count = 2 }} }}
run = {{ transient = 500, cycles = 1500 }}
analyses.lyapunov = {{ exponents = 2, twin = false }}
continuation = {{ over = "speed", starts = 2, longest_period = {longest} }}
"#
        )
    };
    let found = follow(modal, &manifest(64));
    for (period, at) in [
        (4, 2.727_615_644_910),
        (8, 2.715_356_500_527),
        (16, 2.711_252_622_256),
        (32, 2.710_214_512_134),
    ] {
        holds(&found, "period_doubling", period, at, 1e-10);
    }
    // A branch that is not followed is reported with its start.
    let found = follow(modal, &manifest(4));
    let told = found.iter().any(|own| {
        own.kind == "period_doubling"
            && own.period == 4
            && own.detail.contains("period 8 is above longest_period")
    });
    assert!(told, "{found:#?}");
}

/// An oscillator against a stop, with a mesh so wide that no flank is ever met. For any gap, the orbits are the same
/// above 0.68 rad/s; below, starts lead to different attractors. Two doublings by Newton's method on `det(M + I)` with
/// another integrator.
#[test]
fn bifurcations_do_not_depend_on_a_gap_that_is_never_met() {
    let modal = "teeth = 1\nrated_force = 1.0\nfrequency = [1.0]\ndamping = [0.01]\nmesh = [1.0]\ntorque = [1.0]\n\
                 torque_pinion = [1.0]\n\
                 [[contact]]\nname = \"stop\"\nparticipation = [1.0]\ngap = 1.0\nstiffness = 29.0\n";
    let of_gap = |gap: f64| {
        let manifest = format!(
            r#"
job.name = "gap"
model = {{ kind = "modal", file = "s.modal.toml" }}
mesh = {{ half_gap = {gap}, stiffness = "constant", mean_stiffness = 1, contact_damping = 0 }}
excitation.torque_ripple = [{{ shaft = "pinion", order = 1, amplitude = {} }}]
grid = {{ load = 0, speed = {{ from = 0.6, to = 1.0, count = 5 }} }}
run = {{ transient = 300, cycles = 2000 }}
analyses.lyapunov = {{ exponents = 2, twin = false }}
continuation = {{ over = "speed", starts = 9, longest_period = 8 }}
"#,
            0.9 * 0.64 / 1.26
        );
        let mut found = follow(modal, &manifest);
        found.retain(|own| own.kind != "end" && own.at > 0.68);
        found
    };
    let [near, far, farthest] = [5.0, 100.0, 10_000.0].map(of_gap);
    holds(&near, "period_doubling", 2, 0.898_032_740_513_8, 1e-11);
    holds(&near, "period_doubling", 2, 0.914_851_703_654_7, 1e-11);
    for other in [&far, &farthest] {
        assert_eq!(near.len(), other.len(), "{near:#?} {other:#?}");
        for a in &near {
            let is =
                |b: &Found| a.kind == b.kind && a.period == b.period && (a.at - b.at).abs() < 1e-8;
            assert!(other.iter().any(is), "{a:?} {other:#?}");
        }
    }
}
