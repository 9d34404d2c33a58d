//! Summaries of folders written by the store, in every layout and with every kind of missing part.

use std::path::Path;

use super::*;
use crate::analysis::{
    ChaosOutcome, Class, EvidenceOutcome, LyapunovMethod, LyapunovOutcome, PointOutcome, Status,
};
use crate::report::ReportError;
use crate::store::{
    AxisColumn, MachineRecord, Placement, PlacementRecord, PointRow, ProgramRecord, ResultLayout,
    ResultWriter, RunRecord, StoreError, Totals, Written, write_run,
};

fn outcome(status: Status, class: Option<Class>, lambda: Option<f64>) -> PointOutcome {
    PointOutcome {
        status,
        reason: "for a test".into(),
        class,
        lyapunov: lambda.map(|lambda| LyapunovOutcome {
            exponents: vec![lambda],
            errors: vec![0.012],
            dimension: None,
            twin: None,
            twin_stderr: None,
            twin_agrees: None,
            method: LyapunovMethod::Tangent,
            convergence: None,
        }),
        cycles: 1000,
        measured_cycles: 800,
        ..PointOutcome::without_results(Status::Ok, String::new())
    }
}

/// The outcome of a point; its number selects the kind of motion, or a failure.
fn kind(point_id: u64) -> PointOutcome {
    let (ok, lambda) = (Status::Ok, point_id as f64 / 10.0);
    match point_id % 8 {
        0 => outcome(ok, Some(Class::SteadyContact(Some(1))), Some(-0.5)),
        1 => outcome(ok, Some(Class::Periodic(1)), Some(-0.1)),
        2 => outcome(ok, Some(Class::Periodic(12)), Some(-0.05)),
        3 => outcome(ok, Some(Class::QuasiPeriodic), Some(0.0)),
        4 => outcome(Status::NotConverged, Some(Class::NotConverged), Some(0.01)),
        5 => outcome(Status::Diverged, None, None),
        _ => outcome(ok, Some(Class::Chaotic), Some(lambda)),
    }
}

const AXES: [(&str, &str, f64); 3] = [
    ("load", "1", 0.05),
    ("speed", "rad/s", 600.0),
    ("mesh.half_gap", "m", 5e-6),
];

fn write(
    folder: &Path,
    lengths: &[usize],
    missing: &[u64],
    outcome: impl Fn(u64) -> PointOutcome,
) -> Written {
    let axes = AXES[..lengths.len()]
        .iter()
        .map(|&(name, unit, _)| AxisColumn {
            name: name.into(),
            unit: unit.into(),
        })
        .collect();
    let layout = ResultLayout {
        axes,
        ..ResultLayout::default()
    };
    let count = lengths.iter().product::<usize>() as u64;
    let mut writer = ResultWriter::create(folder, &layout, 0..count).unwrap();
    for point_id in (0..count).filter(|id| !missing.contains(id)) {
        let mut rest = point_id as usize;
        let mut axis_values = vec![0.0; lengths.len()];
        for (index, &length) in lengths.iter().enumerate().rev() {
            axis_values[index] = AXES[index].2 * (1 + rest % length) as f64;
            rest /= length;
        }
        let outcome = outcome(point_id);
        let placement = Placement {
            worker: 0,
            numa_node: None,
            wall_time: 0.04,
        };
        let kernel = "volterra".to_owned();
        writer
            .push(PointRow {
                point_id,
                axis_values,
                outcome,
                multistability: None,
                orbits: None,
                chain: None,
                horizon: None,
                covariant: None,
                mesh: None,
                kernel,
                placement,
            })
            .unwrap();
    }
    writer.finish().unwrap()
}

fn record(folder: &Path, written: &Written, state: RunState, points: u64, computed: u64) {
    let record = RunRecord {
        job: "demo".into(),
        state,
        shard: None,
        started: "2026-03-01T12:00:00Z".into(),
        finished: "2026-03-01T12:00:02Z".into(),
        program: ProgramRecord::current(),
        machine: MachineRecord::current(None),
        placement: PlacementRecord {
            threads_asked: Some(2),
            threads: 2,
            asked: "one worker per core".into(),
            obtained: "as asked".into(),
            copies_asked: String::new(),
            copies_obtained: String::new(),
        },
        totals: Totals::new(points, computed, 0, 1000 * computed, 0.5),
        kernels: Vec::new(),
        shards: Vec::new(),
        tables: written.tables.clone(),
        retries: Vec::new(),
        warnings: vec!["the machine was busy".into()],
        manifest_hash: "00".into(),
        manifest: String::new(),
        set: Vec::new(),
        folder: String::new(),
    };
    write_run(folder, &record).unwrap();
}

fn shown(folder: &Path) -> String {
    let mut summary = Summary::read(folder).unwrap();
    summary.folder = "results/demo".into();
    render(&summary, Style::Plain)
}

#[test]
fn two_axes_with_every_kind_of_point() {
    let folder = tempfile::tempdir().unwrap();
    let written = write(folder.path(), &[2, 8], &[], |point_id| {
        let mut outcome = kind(point_id);
        if let Some(found) = &mut outcome.lyapunov {
            found.twin = Some(0.5);
            found.twin_agrees = Some(point_id != 14);
        }
        outcome.energy_residual = Some(1e-13 * (1 + point_id) as f64);
        outcome
    });
    record(folder.path(), &written, RunState::Complete, 16, 16);
    insta::assert_snapshot!(shown(folder.path()));
}

#[test]
fn one_axis_interrupted() {
    let folder = tempfile::tempdir().unwrap();
    let written = write(folder.path(), &[10], &[3, 4], |_| {
        outcome(Status::Ok, Some(Class::Chaotic), Some(0.8))
    });
    record(folder.path(), &written, RunState::Interrupted, 10, 8);
    insta::assert_snapshot!(shown(folder.path()));
}

#[test]
fn a_complete_shard_is_not_interrupted() {
    let folder = tempfile::tempdir().unwrap();
    let written = write(folder.path(), &[10], &[], |_| {
        outcome(Status::Ok, Some(Class::Chaotic), Some(0.8))
    });
    record(folder.path(), &written, RunState::Complete, 10, 10);
    let mut summary = Summary::read(folder.path()).unwrap();
    (summary.shards, summary.state) = (Some([1, 2]), Some(RunState::Interrupted));
    let text = render(&summary, Style::Plain);
    assert!(
        text.contains("1 of 2 shards\n  the other shards are missing"),
        "{text}"
    );
    assert!(!text.contains("interrupted"), "{text}");
}

#[test]
fn three_axes_show_the_first_slice() {
    let folder = tempfile::tempdir().unwrap();
    // Chaotic in the first slice of the third axis only.
    write(folder.path(), &[2, 3, 4], &[], |point_id| {
        match point_id % 4 {
            0 => outcome(Status::Ok, Some(Class::Chaotic), Some(1.0)),
            _ => outcome(Status::Ok, Some(Class::SteadyContact(Some(1))), Some(-1.0)),
        }
    });
    let text = shown(folder.path());
    assert!(
        text.contains("first of 4 slices: mesh.half_gap [m] = 5e-6"),
        "{text}"
    );
    let rows = text
        .lines()
        .filter(|line| line.ends_with("     @     @     @|"));
    assert_eq!(rows.count(), 2, "{text}");
    assert!(text.contains("no run.json"), "{text}");
}

#[test]
fn without_analyses_it_says_so() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[2, 2], &[], |_| {
        outcome(Status::Ok, None, None)
    });
    let text = shown(folder.path());
    assert!(
        text.contains("no Lyapunov exponents in these results"),
        "{text}"
    );
    assert!(text.contains(". not classified"), "{text}");
    assert!(!text.contains("energy") && !text.contains("twin"), "{text}");
}

#[test]
fn a_wide_grid_is_binned_and_keeps_its_liveliest_point() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[1, 1000], &[], |point_id| match point_id {
        501 => outcome(Status::Ok, Some(Class::Chaotic), Some(0.9)),
        _ => outcome(Status::Ok, Some(Class::Periodic(2)), Some(-0.1)),
    });
    let text = shown(folder.path());
    assert!(text.contains("up to 16 points"), "{text}");
    let row = text.lines().find(|line| line.contains('|')).unwrap();
    let marks = row.split('|').nth(1).unwrap();
    assert_eq!(marks.chars().position(|mark| mark == '@'), Some(501 / 16));
    assert_eq!(marks.matches('2').count(), 1000_usize.div_ceil(16) - 1);
    assert!(text.lines().all(|line| line.chars().count() < 90), "{text}");
}

#[test]
fn colours_only_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[2, 8], &[], kind);
    let summary = Summary::read(folder.path()).unwrap();
    assert!(!render(&summary, Style::Plain).contains('\x1b'));
    let colour = render(&summary, Style::Colour);
    assert_eq!(
        colour.matches("\x1b[48;5;").count(),
        colour.matches("m \x1b[0m").count() + 4
    );
}

#[test]
fn no_point_and_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    let missing = |path: &Path| Summary::read(path).err().unwrap();
    for path in [folder.path().to_path_buf(), folder.path().join("nowhere")] {
        let error = missing(&path);
        assert!(
            matches!(error, ReportError::Store(StoreError::Missing { .. })),
            "{error:?}"
        );
        assert!(error.to_string().contains("atlas run"), "{error}");
    }
    write(folder.path(), &[2, 2], &[0, 1, 2, 3], kind);
    assert!(shown(folder.path()).contains("no point was computed"));
}

#[test]
fn numbers_have_four_digits() {
    for (value, text) in [
        (0.0, "0"),
        (1200.0, "1200"),
        (0.05, "0.05"),
        (1.0 / 3.0, "0.3333"),
        (-0.00123456, "-0.001235"),
        (5e-6, "5e-6"),
        (123_456.7, "123457"),
        (2.5e9, "2.5e9"),
        (100.0, "100"),
    ] {
        assert_eq!(number(value), text);
    }
}

#[test]
fn an_exponent_shows_two_digits_of_its_error() {
    let point = |lambda, stderr| PointSummary {
        lambda,
        stderr,
        ..PointSummary::default()
    };
    assert_eq!(
        exponent(&point(Some(0.86123), Some(0.0123))),
        "λ = 0.861 ± 0.012"
    );
    assert_eq!(exponent(&point(Some(9.8), Some(2.34))), "λ = 9.8 ± 2.3");
    assert_eq!(exponent(&point(Some(0.5), Some(0.0))), "λ = 0.5");
    assert_eq!(exponent(&point(None, None)), "λ unknown");
}

#[test]
fn an_axis_with_one_value_is_told_once() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[1, 3], &[], |_| {
        outcome(Status::Ok, Some(Class::Chaotic), Some(0.8))
    });
    let text = shown(folder.path());
    assert_eq!(text.matches("0.05").count(), 1, "{text}");
    assert!(
        text.contains("  3 points: 3 ok\n  all at load 0.05\n"),
        "{text}"
    );
    assert!(text.contains("   point  speed [rad/s]\n"), "{text}");
    let single = tempfile::tempdir().unwrap();
    write(single.path(), &[1, 1], &[], kind);
    let text = shown(single.path());
    assert!(
        text.contains("  1 point: 1 ok\n  at load 0.05, speed 600 rad/s\n"),
        "{text}"
    );
}

#[test]
fn an_energy_balance_that_does_not_close_is_a_warning() {
    let text_of = |residual: f64| {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &[1, 3], &[], |point_id| PointOutcome {
            energy_residual: Some(residual / (1 + point_id) as f64),
            ..outcome(Status::Ok, Some(Class::Periodic(1)), Some(-0.1))
        });
        shown(folder.path())
    };
    let text = text_of(2.5e-6);
    let wanted = "energy_residual is above 1e-6 at 2 points, 2.5e-6 at point 0:";
    assert!(text.contains(wanted), "{text}");
    let text = text_of(0.9e-6);
    assert!(!text.contains("energy_residual"), "{text}");
    assert!(text.contains("worst energy residual 9.0e-7"), "{text}");
}

/// A point with eight trajectories and `cycles` chaotic cycles in total; `exits` trajectories left the chaos.
fn once_chaotic(class: Class, cycles: u64, exits: u32, verified: bool) -> PointOutcome {
    PointOutcome {
        evidence: Some(EvidenceOutcome {
            trajectories: 8,
            verified,
            ..EvidenceOutcome::default()
        }),
        chaos: Some(ChaosOutcome {
            cycles,
            exits,
            trajectories: 8,
            ended_on: (exits > 0).then(|| "periodic 3 (2), quasi_periodic (1)".into()),
            averages_before_exit: None,
        }),
        ..outcome(Status::Ok, Some(class), Some(0.4))
    }
}

#[test]
fn the_life_of_chaos_is_told_by_how_many_trajectories_left_it() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[1, 6], &[], |point_id| match point_id {
        0 => once_chaotic(Class::Chaotic, 20_100, 0, true),
        1 => once_chaotic(Class::Chaotic, 39_900, 0, false),
        2 => once_chaotic(Class::TransientChaos, 8000, 4, true),
        3 => once_chaotic(Class::TransientChaos, 3000, 3, true),
        4 => once_chaotic(Class::Periodic(3), 6400, 8, true),
        _ => outcome(Status::Ok, Some(Class::Periodic(1)), Some(-0.1)),
    });
    let text = shown(folder.path());
    for wanted in [
        "  2 points: no trajectory left chaos; its mean life is at least 6700 … 13300 (95 %)\n",
        "  1 point: all trajectories left chaos; its mean life is 800; the class describes the following motion\n",
        "  2 points: some trajectories left chaos, the shortest mean life first\n",
        "3 of 8 trajectories ended on period 3 (2), quasi-periodic (1)\n",
        "λ = 0.400 ± 0.012  transient\n",
        "t transient chaos",
        "  transient chaos              2\n",
        "standard errors are not verified for 1 of 5 points that do not settle; set run.cycles to 40000 or more",
    ] {
        assert!(text.contains(wanted), "{wanted}\n{text}");
    }
    let [short, long] = ["life 1000 (95 %: ", "life 2000 (95 %: "].map(|life| text.find(life));
    assert!(short.is_some() && short < long, "{text}");
    // With colours, the mark has the colour of its λ.
    let summary = Summary::read(folder.path()).unwrap();
    let colour = render(&summary, Style::Colour);
    assert!(
        colour.contains("\x1b[48;5;227m\x1b[38;5;16m     t\x1b[0m"),
        "{colour}"
    );
}

#[test]
fn without_chaos_nothing_is_said_of_its_life() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[2, 2], &[], |_| {
        outcome(Status::Ok, Some(Class::Periodic(2)), Some(-0.1))
    });
    let text = shown(folder.path());
    assert!(!text.contains("life of chaos"), "{text}");
    assert!(!text.contains("not verified"), "{text}");
}
