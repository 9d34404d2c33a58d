//! Results with known values, written through the public interface and stored in `target/tmp/` for
//! `tests/python/test_readers.py`: `sample/` is one run, `sharded/` has the same points as two shards. The values
//! follow from `point_id` alone (see `row`).

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

use gearatlas::analysis::{
    AttractorOutcome, BasinShare, Bifurcation, CellOutcome, ChaosOutcome, Character, Class,
    ConvergenceOutcome, EvidenceOutcome, GrowthRecord, KaplanYorke, Kick, LyapunovMethod,
    LyapunovOutcome, MissedState, MultistabilityOutcome, NvhOutcome, NvhStatistics, OrbitOutcome,
    OrbitSurvey, OrderLine, PoincareSample, PointOutcome, ProbeOutcome, SampleKind, SignalOrders,
    Spectrum, SpectrumLine, SpectrumMethod, Status,
};
use gearatlas::model::Quantity;
use gearatlas::report::{Style, Summary, render};
use gearatlas::store::{
    AxisColumn, ListElement, MachineRecord, Placement, PlacementRecord, PointRow, ProgramRecord,
    ResultLayout, ResultWriter, RunRecord, RunState, Shard, TableKind, Totals, timestamp,
    write_run,
};
use gearatlas::topology::Topology;

const LOADS: u64 = 8;
const SPEEDS: u64 = 10;

/// Point 13 failed, so all its analyses are absent; every third point is chaotic.
fn row(point_id: u64) -> PointRow {
    let (load, speed) = (point_id / SPEEDS, point_id % SPEEDS);
    let chaotic = point_id.is_multiple_of(3);
    let number = point_id as f64;
    let lambda = if chaotic { 0.01 * number + 0.1 } else { -0.01 * number };
    let mut outcome =
        PointOutcome::without_results(Status::Failed, "point 13 fails by design".into());
    if point_id != 13 {
        outcome = PointOutcome {
            status: Status::Ok,
            reason: "as designed".into(),
            class: Some(if chaotic { Class::Chaotic } else { Class::Periodic(1 + load as u32) }),
            lyapunov: Some(LyapunovOutcome {
                exponents: vec![lambda, -1.0],
                errors: vec![0.01, 0.02],
                dimension: chaotic.then_some(KaplanYorke {
                    value: 1.0 + lambda,
                    stderr: 0.01,
                }),
                twin: chaotic.then_some(lambda + 0.001),
                twin_stderr: chaotic.then_some(0.01),
                twin_agrees: chaotic.then_some(true),
                method: if chaotic { LyapunovMethod::Tangent } else { LyapunovMethod::Multipliers },
                convergence: chaotic.then(|| ConvergenceOutcome {
                    cycles: vec![320.0, 640.0],
                    exponents: vec![lambda, lambda + 0.01, -1.0, -1.01],
                    errors: vec![0.02, 0.01, 0.02, 0.01],
                }),
            }),
            nvh: Some(NvhOutcome {
                cycles: 800,
                values: NvhStatistics {
                    deflection_rms: 1e-6 * number,
                    harmonics: vec![1e-6, 2e-6, 3e-6],
                    bearing_rms: vec![number, 1.0],
                    fractions: [0.5, 0.3, 0.2, 0.0],
                    ..NvhStatistics::default()
                },
                ..NvhOutcome::default()
            }),
            spectra: vec![Spectrum {
                signal: "deflection".to_owned(),
                unit: "m".to_owned(),
                method: SpectrumMethod::Welch,
                bandwidth: Some(0.1),
                lines: vec![SpectrumLine {
                    frequency: 100.0,
                    order: 0.5,
                    amplitude: 1e-6,
                    stderr: None,
                }],
            }],
            orders: vec![SignalOrders {
                signal: "bearing pinion 1 x".to_owned(),
                unit: "N".to_owned(),
                lines: vec![OrderLine {
                    reference: "mesh".to_owned(),
                    multiple: 1,
                    order: 1.0,
                    frequency: 200.0,
                    amplitude: number,
                    stderr: chaotic.then_some(0.5),
                    phase: Some(0.25),
                    phase_stderr: chaotic.then_some(0.1),
                }],
            }],
            poincare: vec![PoincareSample {
                cycle: 999,
                phase: 0.25,
                deflection: 1e-6 * number,
                velocity: 0.0,
                kind: SampleKind::Strobe,
            }],
            events_per_cycle: Some(2.0),
            energy_residual: Some(1e-13),
            evidence: chaotic.then(|| EvidenceOutcome {
                trajectories: 8,
                verified: point_id < 40,
                correlation_cycles: Some(50.0 + number),
                ess: Some(400.0),
                rhat: Some(1.01),
                rotation_number: None,
                chains: Some(GrowthRecord {
                    lengths: vec![2.0, 1.0],
                    growth: vec![lambda, lambda + 0.01, lambda - 0.01],
                }),
            }),
            chaos: chaotic.then_some(ChaosOutcome {
                cycles: 24_000,
                exits: 0,
                trajectories: 8,
                ended_on: None,
                averages_before_exit: None,
            }),
            grazing_count: point_id,
            cycles: 1000,
            measured_cycles: 800,
        };
    }
    PointRow {
        point_id,
        axis_values: vec![0.05 * (1 + load) as f64, 600.0 + 150.0 * speed as f64],
        outcome,
        horizon: None,
        covariant: None,
        mesh: None,
        multistability: (point_id != 13).then(|| probes(point_id)),
        orbits: (point_id != 13).then(|| orbits(point_id)),
        chain: None,
        kernel: "volterra".into(),
        placement: Placement {
            worker: 0,
            numa_node: None,
            wall_time: 0.04,
        },
    }
}

/// An orbit whose leading multiplier is −2 for odd `point_id` and 1/2 for even ones, and a given state that led to
/// none.
fn orbits(point_id: u64) -> OrbitSurvey {
    let stable = point_id.is_multiple_of(2);
    let leading: f64 = if stable { 0.5 } else { -2.0 };
    let modulus = leading.abs();
    let orbit = OrbitOutcome {
        state: None,
        start: [vec![1e-6], vec![1e-3]],
        period: 2,
        residual: 1e-14,
        deflection: 1e-6,
        velocity: 0.0,
        lambda: 0.5 * modulus.ln(),
        multipliers: vec![leading.into(), 0.1.into()],
        character: Character {
            stable,
            bifurcation: (!stable).then_some(Bifurcation::Flip),
            events: 4,
            deflection_pp: 2e-5,
            grazing_margin: (point_id > 5).then_some(0.01 * point_id as f64),
            kick_growth: 3.0,
            kick_growth_linear: 2.0,
        },
        kick: Kick {
            distance: vec![1e-5, 3e-5],
            linear: vec![1e-5, 2e-5],
        },
    };
    OrbitSurvey {
        orbits: vec![orbit],
        missed: vec![MissedState {
            state: 0,
            period: 3,
            reason: "as designed".into(),
        }],
        cycles: 0,
    }
}

/// Three probes on two attractors and one that diverged; on one attractor for odd `point_id`.
fn probes(point_id: u64) -> MultistabilityOutcome {
    let second = u32::from(point_id.is_multiple_of(2));
    let attractors = [Some(0), Some(second), Some(0), None];
    let probe = |(attractor, probe_id): (Option<u32>, u32)| {
        let alike = attractors
            .iter()
            .filter(|other| **other == attractor)
            .count();
        ProbeOutcome {
            probe_id,
            amplitude: f64::from(probe_id),
            attractor,
            status: match attractor {
                Some(_) => Status::Ok,
                None => Status::Diverged,
            },
            reason: "as designed".into(),
            class: attractor.map(|id| Class::Periodic(id + 1)),
            lambda: attractor.map(|_| -0.1),
            lambda_stderr: attractor.map(|_| 0.0),
            deflection_rms: attractor.map(|id| 1e-6 * f64::from(id + 1)),
            force_peak: attractor.map(|_| 1e4),
            events_per_cycle: attractor.map(|_| 4.0),
            cycles: 100,
            basin: BasinShare {
                share: alike as f64 / 4.0,
                low: 0.01,
                high: 0.99,
            },
        }
    };
    let probes: Vec<ProbeOutcome> = attractors.into_iter().zip(0..).map(probe).collect();
    let on = |id: u32| probes.iter().filter(move |p| p.attractor == Some(id));
    let attractor = |id: u32| {
        let first = on(id).next().unwrap();
        AttractorOutcome {
            class: first.class.unwrap(),
            lambda: first.lambda,
            chaos_lifetime_low: None,
            lambda_stderr: first.lambda_stderr,
            deflection_rms: first.deflection_rms,
            force_peak: first.force_peak,
            events_per_cycle: first.events_per_cycle,
            probes: on(id).count() as u32,
            basin: first.basin,
            cells: Some(4 * (1 - id) + 2 * id),
            strobe: vec![[1e-6, -1e-6]; 1 + id as usize],
        }
    };
    let attractors = (0..=second).map(attractor).collect();
    let cell = |index: u32| CellOutcome {
        column: index % 3,
        row: index / 3,
        place: [f64::from(index % 3) * 1e-6, f64::from(index / 3) * 1e-6],
        attractor: (index != 8).then_some(second * (index % 2)),
        status: match index {
            8 => Status::EventStorm,
            _ => Status::Ok,
        },
        class: (index != 8).then_some(Class::Periodic(1 + second * (index % 2))),
        in_full: index == 0,
        cycles: 10,
    };
    let cells = (0..9).map(cell).collect();
    MultistabilityOutcome {
        attractors,
        probes,
        cells,
    }
}

fn write(folder: &Path, shard: Option<Shard>) {
    let axis = |name: &str, unit: &str| AxisColumn {
        name: name.into(),
        unit: unit.into(),
    };
    let axes = vec![axis("load", "1"), axis("speed", "rad/s")];
    let layout = ResultLayout {
        requested: vec![
            TableKind::Poincare,
            TableKind::Spectra,
            TableKind::Orders,
            TableKind::Probes,
            TableKind::Attractors,
            TableKind::Orbits,
        ],
        axes,
        tied: Vec::new(),
        swept: None,
        basin_axes: Some(["mode 1", "mode 2"].map(|name| AxisColumn {
            name: name.to_owned(),
            unit: "m".to_owned(),
        })),
        refined: None,
        samples: None,
        elements: vec![(
            ListElement::Output(Quantity::BearingForce),
            ["pinion 1 x", "pinion 1 y"].map(str::to_owned).to_vec(),
        )],
        shard,
    };
    let all = 0..LOADS * SPEEDS;
    let points: Vec<u64> = match shard {
        None => all.collect(),
        Some(shard) => {
            let (count, index) = (u64::from(shard.count), u64::from(shard.index));
            all.filter(|id| id % count == index - 1).collect()
        }
    };
    let mut writer = ResultWriter::create(folder, &layout, points.clone()).unwrap();
    for &point_id in points.iter().rev() {
        writer.push(row(point_id)).unwrap();
    }
    let written = writer.finish().unwrap();
    let failed = u64::from(points.contains(&13));
    let count = points.len() as u64;
    assert_eq!(written.missing, 0);
    for (kind, rows) in [
        (TableKind::Points, count),
        (TableKind::Poincare, count - failed),
        (TableKind::Spectra, count - failed),
        (TableKind::Orders, count - failed),
        (TableKind::Probes, 4 * (count - failed)),
        (TableKind::Orbits, 2 * (count - failed)),
    ] {
        assert_eq!(written.rows(kind), rows, "{kind:?}");
    }
    let now = timestamp(std::time::SystemTime::now());
    let record = RunRecord {
        job: "sample".into(),
        state: RunState::Complete,
        shard,
        started: now.clone(),
        finished: now,
        program: ProgramRecord::current(),
        machine: MachineRecord::current(Some(&Topology::current().unwrap())),
        placement: PlacementRecord {
            threads_asked: None,
            threads: 1,
            asked: "none".into(),
            obtained: "none".into(),
            copies_asked: String::new(),
            copies_obtained: String::new(),
        },
        totals: Totals::new(count, count - failed, failed, 1000 * (count - failed), 1.0),
        kernels: Vec::new(),
        shards: Vec::new(),
        tables: written.tables.clone(),
        retries: Vec::new(),
        warnings: Vec::new(),
        manifest_hash: "0".into(),
        manifest: "# written by a test\n[job]\nname = \"sample\"\n".into(),
        set: Vec::new(),
        folder: String::new(),
    };
    write_run(folder, &record).unwrap();
}

#[test]
fn one_run_and_two_shards_say_the_same() {
    let folders =
        ["sample", "sharded"].map(|name| PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name));
    for folder in &folders {
        if folder.exists() {
            fs::remove_dir_all(folder).unwrap();
        }
    }
    write(&folders[0], None);
    for index in [1, 2] {
        write(&folders[1], Some(Shard { index, count: 2 }));
    }
    let [whole, sharded] = folders.map(|folder| Summary::read(&folder).unwrap());
    assert_eq!(whole.all, sharded.all);
    assert_eq!(whole.classes, sharded.classes);
    assert_eq!(whole.coexisting, sharded.coexisting);
    assert_eq!(whole.coexisting.len(), 40);
    let [orbits, of_shards] = [&whole, &sharded].map(|summary| summary.orbits.clone().unwrap());
    assert_eq!(orbits.orbits, of_shards.orbits);
    assert_eq!(
        (orbits.points, orbits.orbits.len(), orbits.missed.len()),
        (79, 79, 79)
    );
    assert_eq!(orbits.periods, of_shards.periods);
    let [stable, unstable] = orbits.periods.as_slice() else {
        panic!("{:?}", orbits.periods);
    };
    for (count, is_stable, number, modulus) in [(stable, true, 40, 0.5), (unstable, false, 39, 2.0)]
    {
        assert_eq!((count.period, count.stable), (2, is_stable));
        assert_eq!((count.orbits, count.points), (number, number));
        assert!(
            count
                .modulus
                .iter()
                .all(|found| (found - modulus).abs() < 1e-12)
        );
    }
    let both = [stable, unstable];
    let margins = both.iter().filter_map(|count| count.grazing_margin);
    assert_eq!(margins.reduce(f64::min), Some(0.06));
    let kicks = both.iter().filter_map(|count| count.kick_over_linear);
    assert_eq!(kicks.reduce(f64::max), Some(1.5));
    assert_eq!(sharded.shards, Some([2, 2]));
    assert_eq!(sharded.state, Some(RunState::Complete));
    let text = render(&whole, Style::Plain);
    for wanted in [
        "80 points: 1 failed, 79 ok",
        "       2  stable        40      40  0.5 ",
        "       2  unstable      39      39  2 ",
        "orbits.parquet and `atlas show --json` list every orbit",
        "       0       1       3  as designed\n",
        "  … and 59 more\n",
    ] {
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
}
