//! Do result files keep what they promise: round trips, order and names?

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use super::*;
use crate::analysis::{
    AngleOutcome, AttractorOutcome, BasinShare, Bifurcation, CellOutcome, ChaosAverages,
    ChaosOutcome, Character, Class, ConvergenceOutcome, CovariantOutcome, EvidenceOutcome,
    GrowthRecord, HorizonMeasure, HorizonOutcome, HorizonQuantity, KaplanYorke, Kick,
    LyapunovMethod, LyapunovOutcome, MissedState, ModalState, MultistabilityOutcome, NvhOutcome,
    NvhStatistics, OrbitOutcome, OrbitSurvey, OrderLine, PoincareSample, PointOutcome,
    PowerOutcome, ProbeOutcome, SampleKind, SignalOrders, Spectrum, SpectrumLine, SpectrumMethod,
    Status, TraceSample, TraceSink,
};
use crate::model::Quantity;
use crate::model::{ActiveSet, COAST_FLANK};
use crate::numerics::nested_grid::NestedGrid;
use crate::propagate::Event;
use crate::store::{
    AxisColumn, ChainPart, Level, ListElement, MeshUnderLoad, Placement, RefinedColumns,
    ResultTable, TraceLabel, TraceWriter, Transition, bifurcations_table, branches_table,
    contact_changes_table, curves_table, events_table, levels_table, order_tracks_table,
    signals_table, spectrogram_table, trace_table,
};
use strum::VariantArray;

fn layout() -> ResultLayout {
    let axis = |name: &str, unit: &str| AxisColumn {
        name: name.into(),
        unit: unit.into(),
    };
    ResultLayout {
        requested: vec![
            TableKind::Poincare,
            TableKind::Spectra,
            TableKind::Orders,
            TableKind::Probes,
            TableKind::Attractors,
            TableKind::Horizon,
        ],
        axes: vec![
            axis("load", "1"),
            axis("speed", "rad/s"),
            axis("mesh.half_gap", "m"),
        ],
        tied: Vec::new(),
        swept: None,
        basin_axes: Some(["of mode 1", "of mode 2"].map(|name| AxisColumn {
            name: name.into(),
            unit: "m".into(),
        })),
        refined: None,
        samples: None,
        elements: vec![(
            ListElement::Output(Quantity::BearingForce),
            ["pinion 1 x", "pinion 1 y"].map(str::to_owned).to_vec(),
        )],
        shard: None,
    }
}

/// The speed axis, along which the state is carried.
fn swept() -> AxisColumn {
    layout().axes.remove(1)
}

/// A point with a different number in every column.
fn full(point_id: u64) -> PointRow {
    let base = point_id as f64;
    PointRow {
        point_id,
        axis_values: vec![0.05 + base, 600.0 + base, 1e-5 + base],
        outcome: PointOutcome {
            status: Status::Ok,
            reason: format!("largest exponent {base} is positive"),
            class: Some(Class::Chaotic),
            lyapunov: Some(LyapunovOutcome {
                exponents: vec![0.86 + base, -0.3, -1.0 / 3.0],
                errors: vec![0.01, 0.011, 0.012],
                dimension: Some(KaplanYorke {
                    value: 2.68,
                    stderr: 0.04,
                }),
                twin: Some(0.85),
                twin_stderr: Some(0.02),
                twin_agrees: Some(true),
                method: LyapunovMethod::Tangent,
                convergence: Some(ConvergenceOutcome {
                    cycles: vec![40.0, 80.0],
                    exponents: vec![0.87, 0.86],
                    errors: vec![0.02, 0.013],
                }),
            }),
            nvh: Some(NvhOutcome {
                cycles: 11,
                deflection_pp: 3e-6,
                deflection_peak: 4.1e-6,
                deflection_crest: 4.0,
                force_peak: 10.0,
                friction_coefficient: Some(0.05),
                impacts: [20, 21],
                impact_velocity_max: Some(0.4),
                flights: 22,
                contacts: 23,
                values: NvhStatistics {
                    deflection_mean: 1e-6,
                    deflection_rms: 2e-6,
                    deflection_peak_quantiles: vec![4.2e-6, 4.3e-6],
                    deflection_kurtosis: 5.0,
                    harmonics: vec![6e-6, 7e-6],
                    force_mean: 8.0,
                    force_std: 9.0,
                    force_peak_quantiles: vec![9.1, 9.2],
                    power_loss: Some(10.1),
                    power_transmitted: Some(10.2),
                    efficiency: Some(0.99),
                    power: Some(PowerOutcome {
                        loads: -1.5,
                        error: 6.5,
                        stiffness: 0.25,
                        contact: 3.5,
                        structure: 1.25,
                        friction: 0.375,
                        stored: 0.125,
                    }),
                    impact_rate: 11.0,
                    impact_velocity: 12.0,
                    impact_power: 12.1,
                    rattle_index: 12.2,
                    fractions: [0.5, 0.3, 0.15, 0.05],
                    suborders: vec![1e-7; 5],
                    impact_velocity_quantiles: vec![0.1, 0.2, 0.3],
                    contact_force: vec![11.0, 3.0, 14.0],
                    contact_fraction: vec![0.5, 0.2, 0.6],
                    contact_impact_rate: vec![15.0, 16.0, 17.0],
                    contact_rattle_index: vec![18.0, 19.0, 20.0],
                    contact_loss: vec![21.0, 22.0, 23.0],
                    bearing_mean: vec![-30.0, 31.0],
                    bearing_rms: vec![32.0, 33.0],
                    torque_mean: vec![34.0],
                    torque_rms: vec![35.0],
                    acceleration_rms: vec![36.0, 37.0],
                    angular_acceleration_rms: vec![38.0],
                    mesh_deflection_rms: vec![39.0, 40.0],
                    mesh_force_rms: vec![41.0, 42.0],
                    flight_mean: Some(5e-5),
                    flight_median: Some(6e-5),
                    contact_mean: Some(7e-5),
                    contact_median: Some(8e-5),
                },
                stderr: Some(NvhStatistics {
                    deflection_mean: 2e-8,
                    deflection_rms: 1e-8,
                    deflection_peak_quantiles: vec![1e-8, 1.1e-8],
                    deflection_kurtosis: 3e-8,
                    harmonics: vec![1e-9, 2e-9],
                    suborders: vec![3e-9; 5],
                    force_mean: 4e-8,
                    force_std: 5e-8,
                    // One quantile is infinite: the cycles were too few for it.
                    force_peak_quantiles: vec![0.1, f64::INFINITY],
                    power_loss: Some(5.1e-8),
                    power_transmitted: Some(5.2e-8),
                    efficiency: Some(f64::INFINITY),
                    power: Some(PowerOutcome {
                        loads: 0.1,
                        error: 0.2,
                        stiffness: 0.3,
                        contact: 0.4,
                        structure: 0.5,
                        friction: 0.6,
                        stored: f64::INFINITY,
                    }),
                    impact_rate: 6e-8,
                    impact_velocity: 7e-8,
                    impact_power: 7.1e-8,
                    rattle_index: 7.2e-8,
                    impact_velocity_quantiles: vec![4e-9, 5e-9, 6e-9],
                    flight_mean: Some(8e-8),
                    // Too few flights for an error bar.
                    flight_median: Some(f64::INFINITY),
                    contact_mean: Some(9e-8),
                    contact_median: Some(1e-7),
                    contact_force: vec![1e-6, 2e-6, 3e-6],
                    contact_fraction: vec![4e-6, 5e-6, 6e-6],
                    contact_impact_rate: vec![7e-6, 8e-6, 9e-6],
                    contact_rattle_index: vec![1e-5, 2e-5, 3e-5],
                    contact_loss: vec![4e-5, 5e-5, 6e-5],
                    bearing_mean: vec![7e-9, 8e-9],
                    bearing_rms: vec![9e-9, 1e-8],
                    torque_mean: vec![1.1e-8],
                    torque_rms: vec![1.2e-8],
                    acceleration_rms: vec![1.3e-8, 1.4e-8],
                    angular_acceleration_rms: vec![1.5e-8],
                    mesh_deflection_rms: vec![1.6e-8, 1.7e-8],
                    mesh_force_rms: vec![1.8e-8, 1.9e-8],
                    fractions: [2e-7, 3e-7, 4e-7, 5e-7],
                }),
            }),
            spectra: vec![Spectrum {
                signal: "force".to_owned(),
                unit: "N".to_owned(),
                method: SpectrumMethod::Welch,
                bandwidth: Some(300.0),
                lines: vec![
                    SpectrumLine {
                        frequency: 100.0,
                        order: 0.5,
                        amplitude: 3.0,
                        stderr: Some(0.25),
                    },
                    SpectrumLine {
                        frequency: 200.0,
                        order: 1.0,
                        amplitude: 4.0,
                        stderr: None,
                    },
                ],
            }],
            orders: vec![SignalOrders {
                signal: "torque pinion".to_owned(),
                unit: "N m".to_owned(),
                lines: vec![OrderLine {
                    reference: "pinion".to_owned(),
                    multiple: 2,
                    order: 0.1,
                    frequency: 20.0,
                    amplitude: 5.0,
                    stderr: Some(0.5),
                    phase: Some(-1.0),
                    phase_stderr: None,
                }],
            }],
            poincare: vec![PoincareSample {
                cycle: 7,
                phase: 0.25,
                deflection: base,
                velocity: -2e-3,
                kind: SampleKind::Strobe,
            }],
            events_per_cycle: Some(2.5),
            energy_residual: Some(1e-12),
            evidence: Some(EvidenceOutcome {
                trajectories: 24,
                verified: true,
                correlation_cycles: Some(25.5),
                ess: Some(26.5),
                rhat: Some(1.25),
                rotation_number: Some(0.125),
                chains: Some(GrowthRecord {
                    lengths: vec![2.0, 1.0],
                    growth: vec![0.7, 0.8, 0.9],
                }),
            }),
            chaos: Some(ChaosOutcome {
                cycles: 27_000,
                exits: 2,
                trajectories: 24,
                ended_on: Some("periodic 3 (2)".into()),
                averages_before_exit: Some(ChaosAverages {
                    lambda: [0.61, 0.062],
                    deflection_rms: Some([6.3e-6, 6.4e-7]),
                    force_std: Some([65.0, 66.0]),
                    impact_velocity: None,
                }),
            }),
            grazing_count: 13,
            cycles: 14,
            measured_cycles: 15,
        },
        horizon: Some(HorizonOutcome {
            horizon: Some(17.0),
            stderr: Some(0.5),
            saturation: 1.5,
            averaging_exponent: None,
            cycles: 960,
            measures: vec![HorizonMeasure {
                quantity: HorizonQuantity::Separation,
                cycles: 1,
                value: 2e-6,
                spread: 0.7,
                samples: 16,
            }],
        }),
        mesh: Some(MeshUnderLoad {
            misalignment: 2e-4,
            load_centre: -3e-3,
            stiffness: 4e8,
            contact_ratio: 1.5,
            transmission_error: 6e-6,
        }),
        covariant: Some(CovariantOutcome {
            exponents: vec![0.861, -0.29, -0.35],
            errors: vec![0.021, 0.022, 0.023],
            spreads: vec![1.1, 1.2, 1.3],
            unstable: 1,
            stable: 2,
            angle: Some(AngleOutcome {
                min: 1e-3,
                mean: 0.7,
                stderr: 0.02,
                quantiles: vec![0.01, 0.1, 0.71, 1.3, 1.5],
            }),
            cycles: 1900,
        }),
        multistability: Some(MultistabilityOutcome {
            attractors: vec![attractor()],
            probes: vec![probe(0, Some(0)), probe(1, None)],
            cells: vec![cell(0, Some(0)), cell(1, None)],
        }),
        orbits: None,
        chain: None,
        kernel: "volterra".into(),
        placement: Placement {
            worker: 16,
            numa_node: Some(17),
            wall_time: 18.0,
        },
    }
}

/// A probe with a different number in every column.
fn probe(probe_id: u32, attractor: Option<u32>) -> ProbeOutcome {
    ProbeOutcome {
        probe_id,
        amplitude: 1.5,
        attractor,
        status: Status::NotConverged,
        reason: "for a test".into(),
        class: Some(Class::Periodic(3)),
        lambda: Some(-0.2),
        lambda_stderr: Some(1e-9),
        deflection_rms: Some(3e-5),
        force_peak: Some(1.8e4),
        events_per_cycle: Some(4.0),
        cycles: 2500,
        basin: BasinShare {
            share: 0.5,
            low: 0.09,
            high: 0.91,
        },
    }
}

/// An attractor with a different number in every column.
fn attractor() -> AttractorOutcome {
    AttractorOutcome {
        class: Class::Periodic(2),
        lambda: Some(-0.3),
        chaos_lifetime_low: Some(5000.0),
        lambda_stderr: Some(2e-9),
        deflection_rms: Some(4e-5),
        force_peak: Some(1.7e4),
        events_per_cycle: Some(3.0),
        probes: 1,
        basin: BasinShare {
            share: 0.5,
            low: 0.09,
            high: 0.91,
        },
        cells: Some(12),
        strobe: vec![[1e-6, 2e-6], [3e-6, 4e-6]],
    }
}

/// A cell with a different number in every column.
fn cell(column: u32, attractor: Option<u32>) -> CellOutcome {
    CellOutcome {
        column,
        row: 5,
        place: [-1e-6, 6e-6],
        attractor,
        status: Status::Ok,
        class: Some(Class::Periodic(2)),
        in_full: true,
        cycles: 77,
    }
}

/// Orbits with a different number in every column.
fn orbits() -> OrbitSurvey {
    OrbitSurvey {
        orbits: vec![OrbitOutcome {
            state: Some(2),
            start: [vec![1e-7, 2e-7], vec![3e-4, 4e-4]],
            period: 5,
            residual: 1e-14,
            deflection: 8e-6,
            velocity: 9e-3,
            lambda: -0.4,
            multipliers: vec![num_complex::c64(0.7, 0.1), num_complex::c64(0.7, -0.1)],
            character: Character {
                stable: true,
                bifurcation: Some(Bifurcation::NeimarkSacker),
                events: 24,
                deflection_pp: 2e-5,
                grazing_margin: Some(0.6),
                kick_growth: 1.6,
                kick_growth_linear: 1.7,
            },
            kick: Kick {
                distance: vec![1e-5, 1.6e-5],
                linear: vec![1e-5, 1.7e-5],
            },
        }],
        missed: vec![MissedState {
            state: 6,
            period: 8,
            reason: "for a test".into(),
        }],
        cycles: 60,
    }
}

/// A part in a chain, with a change of motion that has a different number in every column.
fn part() -> ChainPart {
    let level = |base: f64| Level {
        mean: [base, 0.0],
        rms: [2.0 * base, 0.0],
    };
    ChainPart {
        upwards: false,
        end: None,
        transition: Some(Transition {
            from: Class::Periodic(6),
            to: Class::SteadyContact(Some(7)),
            bracket: [610.0, 605.0],
            trials: 9,
            jump: Some([level(1e-6), level(3e-6)]),
        }),
        level: None,
    }
}

/// Outputs of a trace, two of one name.
fn outputs() -> Vec<[String; 2]> {
    [
        ["bearing pinion 1 x", "N"],
        ["bearing pinion 1 x", "N"],
        ["torque pinion", "N m"],
    ]
    .map(|own| own.map(str::to_owned))
    .into()
}

/// An instant with a different number in every column.
fn instant() -> TraceSample {
    TraceSample {
        cycle: 3,
        phase: 0.375,
        time: 2e-4,
        deflection: 1e-5,
        velocity: -4e-3,
        force: 250.0,
        contact: ActiveSet::COAST,
        modal: Some(ModalState {
            displacement: vec![1e-7, 2e-7],
            velocity: vec![3e-7, 4e-7],
        }),
        outputs: vec![700.0, 800.0, 7.0],
    }
}

/// A point that failed, without any results.
fn failed(point_id: u64) -> PointRow {
    let mut row = full(point_id);
    row.outcome =
        PointOutcome::without_results(Status::Failed, "the model has no mesh mode".into());
    row.multistability = None;
    row.horizon = None;
    row.covariant = None;
    row.mesh = None;
    row.placement.numa_node = None;
    row
}

fn write(folder: &Path, layout: &ResultLayout, rows: Vec<PointRow>) -> Written {
    let mut expected: Vec<u64> = rows.iter().map(|row| row.point_id).collect();
    expected.sort_unstable();
    let mut writer = ResultWriter::create(folder, layout, expected).unwrap();
    for row in rows {
        writer.push(row).unwrap();
    }
    writer.finish().unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn columns_units_and_descriptions() {
    let points = |layout: ResultLayout| points_table(&layout).unwrap().listing();
    for kind in TableKind::VARIANTS {
        let listed = match kind {
            TableKind::Points => points(layout()),
            TableKind::Poincare => poincare_table().listing(),
            TableKind::Spectra => spectra_table().listing(),
            TableKind::Orders => orders_table().listing(),
            TableKind::Probes => probes_table().listing(),
            TableKind::Orbits => orbits_table().listing(),
            TableKind::Transitions => transitions_table(&swept()).listing(),
            TableKind::Attractors => attractors_table().listing(),
            TableKind::Basins => basins_table().listing(),
            TableKind::Horizon => horizon_table().listing(),
            TableKind::Branches => branches_table(&layout().axes).listing(),
            TableKind::Bifurcations => bifurcations_table(&layout().axes).listing(),
            TableKind::Curves => curves_table(&layout().axes).listing(),
            TableKind::Trace => trace_table(true, &outputs()).listing(),
            TableKind::Events => events_table().listing(),
            TableKind::Signals => signals_table(&outputs()).listing(),
            TableKind::OrderTracks => order_tracks_table().listing(),
            TableKind::Levels => levels_table().listing(),
            TableKind::Spectrogram => spectrogram_table().listing(),
            TableKind::ContactChanges => contact_changes_table().listing(),
        };
        let name = kind.file_name().strip_suffix(".parquet").unwrap();
        insta::assert_snapshot!(name, listed);
    }
    let swept = ResultLayout {
        swept: Some(swept()),
        ..layout()
    };
    insta::assert_snapshot!("points_of_chains", points(swept));
    let refined = Some(RefinedColumns {
        nested: NestedGrid {
            coarse: [9, 9],
            levels: 7,
        },
        axes: ["load".into(), "speed".into()],
        by: "class".into(),
        start: "static".into(),
    });
    let plane = ResultLayout {
        refined,
        ..layout()
    };
    // A refined plane has one more column after the axes than a full grid, and another numbering.
    let (own, full) = (points(plane), points(layout()));
    let more: Vec<&str> = own.lines().filter(|line| !full.contains(*line)).collect();
    assert_eq!(more.len(), 2, "{more:?}");
    assert!(
        more[0].contains("by level") && more[1].contains("halvings"),
        "{more:?}"
    );
}

/// A table that records which of its columns were requested.
struct Asked {
    table: ResultTable,
    columns: RefCell<BTreeSet<String>>,
}

impl Asked {
    fn read(folder: &Path, kind: TableKind) -> Self {
        Self {
            table: ResultTable::read(folder, kind).unwrap(),
            columns: RefCell::default(),
        }
    }

    fn note(&self, name: &str) -> &ResultTable {
        self.columns.borrow_mut().insert(name.to_owned());
        &self.table
    }

    fn f64(&self, name: &str) -> Vec<Option<f64>> {
        self.note(name).f64(name).unwrap()
    }

    fn u64(&self, name: &str) -> Vec<Option<u64>> {
        self.note(name).u64(name).unwrap()
    }

    fn bool(&self, name: &str) -> Vec<Option<bool>> {
        self.note(name).bool(name).unwrap()
    }

    fn text(&self, name: &str) -> Vec<Option<String>> {
        self.note(name).text(name).unwrap()
    }

    fn lists(&self, name: &str) -> Vec<Option<Vec<Option<f64>>>> {
        self.note(name).lists(name).unwrap()
    }

    /// Checks that every column was requested.
    fn read_through(self, kind: TableKind) -> TableKind {
        let all: BTreeSet<String> = self.table.units().unwrap().into_keys().collect();
        assert_eq!(self.columns.into_inner(), all, "{kind:?}");
        kind
    }
}

fn some<const N: usize>(list: [f64; N]) -> Vec<Option<f64>> {
    list.map(Some).to_vec()
}

#[test]
fn every_column_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let whole = ResultLayout {
        requested: [layout().requested, vec![TableKind::Orbits]].concat(),
        swept: Some(swept()),
        ..layout()
    };
    let row = PointRow {
        orbits: Some(orbits()),
        chain: Some(Box::new(part())),
        ..full(0)
    };
    let written = write(folder.path(), &whole, vec![row, failed(1)]);
    let mut read = Vec::new();
    assert_eq!(written.missing, 0);
    for (kind, rows) in [
        (TableKind::Points, 2),
        (TableKind::Poincare, 1),
        (TableKind::Spectra, 2),
        (TableKind::Orders, 1),
        (TableKind::Probes, 2),
        (TableKind::Orbits, 2),
        (TableKind::Transitions, 1),
        (TableKind::Attractors, 1),
        (TableKind::Basins, 2),
        (TableKind::Horizon, 1),
    ] {
        assert_eq!(written.rows(kind), rows, "{kind:?}");
    }

    let points = Asked::read(folder.path(), TableKind::Points);
    assert_eq!(
        points.table.axes().unwrap(),
        ["load", "speed", "mesh.half_gap"]
    );
    let numbers = |name: &str| points.f64(name);
    let counts = |name: &str| points.u64(name);
    let text = |name: &str| points.text(name);
    assert_eq!(counts("point_id"), [Some(0), Some(1)]);
    assert_eq!(numbers("load"), [Some(0.05), Some(1.05)]);
    assert_eq!(numbers("speed"), [Some(600.0), Some(601.0)]);
    assert_eq!(numbers("mesh.half_gap"), [Some(1e-5), Some(1.0 + 1e-5)]);
    assert_eq!(text("status"), [Some("ok".into()), Some("failed".into())]);
    assert_eq!(
        text("reason")[1].as_deref(),
        Some("the model has no mesh mode")
    );
    assert_eq!(text("class"), [Some("chaotic".into()), None]);
    assert_eq!(counts("period"), [None, None]);
    assert_eq!(points.bool("twin_agrees"), [Some(true), None]);
    assert_eq!(text("lambda_method"), [Some("tangent".into()), None]);
    let exponents = Some(vec![Some(0.86), Some(-0.3), Some(-1.0 / 3.0)]);
    assert_eq!(points.lists("exponents"), [exponents, None]);
    for (name, values) in [
        ("exponents_stderr", &[0.01, 0.011, 0.012][..]),
        ("course_cycles", &[40.0, 80.0]),
        ("course_exponents", &[0.87, 0.86]),
        ("course_stderr", &[0.02, 0.013]),
        ("covariant_exponents", &[0.861, -0.29, -0.35]),
        ("covariant_exponents_stderr", &[0.021, 0.022, 0.023]),
        ("covariant_exponents_spread", &[1.1, 1.2, 1.3]),
        ("angle_quantiles", &[0.01, 0.1, 0.71, 1.3, 1.5]),
        ("chain_lengths", &[2.0, 1.0]),
        ("chain_growth", &[0.7, 0.8, 0.9]),
    ] {
        let values = Some(values.iter().copied().map(Some).collect());
        assert_eq!(points.lists(name), [values, None], "{name}");
    }
    assert_eq!(points.bool("errors_verified"), [Some(true), None]);
    assert_eq!(text("ended_on"), [Some("periodic 3 (2)".into()), None]);
    for (name, value) in [
        ("trajectories", 24),
        ("chaos_cycles", 27_000),
        ("chaos_exits", 2),
    ] {
        assert_eq!(counts(name), [Some(value), None], "{name}");
    }
    // Two exits in 27000 cycles, by quantiles of chi-squared with 6 and 4 degrees of freedom.
    for (name, end) in [
        ("chaos_lifetime_low", 2.0 * 27_000.0 / 14.449_375),
        ("chaos_lifetime_high", 2.0 * 27_000.0 / 0.484_419),
    ] {
        let [Some(found), None] = numbers(name)[..] else {
            panic!("{name}");
        };
        assert!((found / end - 1.0).abs() < 1e-5, "{name}: {found} {end}");
    }
    assert_eq!(counts("unstable_directions"), [Some(1), None]);
    assert_eq!(counts("stable_directions"), [Some(2), None]);
    let harmonics = Some(vec![Some(6e-6), Some(7e-6)]);
    assert_eq!(points.lists("harmonics"), [harmonics, None]);
    let peaks = Some(vec![Some(4.2e-6), Some(4.3e-6)]);
    assert_eq!(points.lists("deflection_peak_quantiles"), [peaks, None]);
    let errors = points.lists("deflection_peak_quantiles_stderr");
    assert_eq!(errors, [Some(some([1e-8, 1.1e-8])), None]);
    let peaks = Some(some([9.1, 9.2]));
    assert_eq!(points.lists("force_peak_quantiles"), [peaks, None]);
    let errors = points.lists("force_peak_quantiles_stderr");
    assert_eq!(errors, [None, None], "one of them is not known");
    for (name, value) in [
        ("lambda_max", 0.86),
        ("lambda_stderr", 0.01),
        ("lambda_twin", 0.85),
        ("events_per_cycle", 2.5),
        ("fraction_drive", 0.5),
        ("fraction_free", 0.3),
        ("fraction_coast", 0.15),
        ("fraction_both", 0.05),
        ("deflection_mean", 1e-6),
        ("deflection_rms", 2e-6),
        ("deflection_pp", 3e-6),
        ("deflection_peak", 4.1e-6),
        ("deflection_crest", 4.0),
        ("deflection_kurtosis", 5.0),
        ("force_mean", 8.0),
        ("force_std", 9.0),
        ("force_peak", 10.0),
        ("impact_rate", 11.0),
        ("impact_velocity", 12.0),
        ("impact_power", 12.1),
        ("rattle_index", 12.2),
        ("energy_residual", 1e-12),
    ] {
        assert_eq!(numbers(name), [Some(value), None], "{name}");
    }
    assert_eq!(counts("attractors"), [Some(1), None]);
    assert_eq!(counts("grazing_count"), [Some(13), Some(0)]);
    assert_eq!(counts("cycles"), [Some(14), Some(0)]);
    assert_eq!(counts("measured_cycles"), [Some(15), Some(0)]);
    assert_eq!(counts("nvh_cycles"), [Some(11), None]);
    assert_eq!(
        text("kernel"),
        [Some("volterra".into()), Some("volterra".into())]
    );
    assert_eq!(numbers("wall_time"), [Some(18.0), Some(18.0)]);
    assert_eq!(counts("worker"), [Some(16), Some(16)]);
    assert_eq!(counts("numa_node"), [Some(17), None]);
    assert_eq!(text("direction"), [Some("down".into()), None]);
    for (name, value) in [
        ("lambda_twin_stderr", Some(0.02)),
        ("correlation_cycles", Some(25.5)),
        ("ess", Some(26.5)),
        ("rhat", Some(1.25)),
        ("rotation_number", Some(0.125)),
        ("chaos_lifetime", Some(13_500.0)),
        ("transient_lambda", Some(0.61)),
        ("transient_lambda_stderr", Some(0.062)),
        ("transient_deflection_rms", Some(6.3e-6)),
        ("transient_deflection_rms_stderr", Some(6.4e-7)),
        ("transient_force_std", Some(65.0)),
        ("transient_force_std_stderr", Some(66.0)),
        ("transient_impact_velocity", None),
        ("transient_impact_velocity_stderr", None),
        ("horizon", Some(17.0)),
        ("horizon_stderr", Some(0.5)),
        ("kaplan_yorke", Some(2.68)),
        ("kaplan_yorke_stderr", Some(0.04)),
        ("angle_min", Some(1e-3)),
        ("angle_mean", Some(0.7)),
        ("angle_mean_stderr", Some(0.02)),
        ("saturation", Some(1.5)),
        ("averaging_exponent", None),
        ("fraction_drive_stderr", Some(2e-7)),
        ("fraction_free_stderr", Some(3e-7)),
        ("fraction_coast_stderr", Some(4e-7)),
        ("fraction_both_stderr", Some(5e-7)),
        ("deflection_mean_stderr", Some(2e-8)),
        ("deflection_rms_stderr", Some(1e-8)),
        ("deflection_kurtosis_stderr", Some(3e-8)),
        ("force_mean_stderr", Some(4e-8)),
        ("force_std_stderr", Some(5e-8)),
        ("power_loss", Some(10.1)),
        ("power_loss_stderr", Some(5.1e-8)),
        ("power_transmitted", Some(10.2)),
        ("power_transmitted_stderr", Some(5.2e-8)),
        ("efficiency", Some(0.99)),
        ("efficiency_stderr", None),
        ("friction_coefficient", Some(0.05)),
        ("power_in_loads", Some(-1.5)),
        ("power_in_loads_stderr", Some(0.1)),
        ("power_in_error", Some(6.5)),
        ("power_in_error_stderr", Some(0.2)),
        ("power_in_stiffness", Some(0.25)),
        ("power_in_stiffness_stderr", Some(0.3)),
        ("power_out_contact", Some(3.5)),
        ("power_out_contact_stderr", Some(0.4)),
        ("power_out_structure", Some(1.25)),
        ("power_out_structure_stderr", Some(0.5)),
        ("power_out_friction", Some(0.375)),
        ("power_out_friction_stderr", Some(0.6)),
        ("power_stored", Some(0.125)),
        ("power_stored_stderr", None),
        ("misalignment_loaded", Some(2e-4)),
        ("load_centre", Some(-3e-3)),
        ("mesh_stiffness", Some(4e8)),
        ("contact_ratio_loaded", Some(1.5)),
        ("transmission_error_pp", Some(6e-6)),
        ("impact_rate_stderr", Some(6e-8)),
        ("impact_velocity_stderr", Some(7e-8)),
        ("impact_power_stderr", Some(7.1e-8)),
        ("rattle_index_stderr", Some(7.2e-8)),
        ("impact_velocity_max", Some(0.4)),
        ("flight_mean", Some(5e-5)),
        ("flight_mean_stderr", Some(8e-8)),
        ("flight_median", Some(6e-5)),
        ("flight_median_stderr", None),
        ("contact_mean", Some(7e-5)),
        ("contact_mean_stderr", Some(9e-8)),
        ("contact_median", Some(8e-5)),
        ("contact_median_stderr", Some(1e-7)),
    ] {
        assert_eq!(numbers(name), [value, None], "{name}");
    }
    for (name, value) in [
        ("impacts_drive", 20),
        ("impacts_coast", 21),
        ("flights", 22),
        ("contacts", 23),
    ] {
        assert_eq!(counts(name), [Some(value), None], "{name}");
    }
    for (name, list) in [
        ("harmonics_stderr", some([1e-9, 2e-9])),
        ("suborders", some([1e-7; 5])),
        ("suborders_stderr", some([3e-9; 5])),
        ("impact_velocity_quantiles", some([0.1, 0.2, 0.3])),
        ("impact_velocity_quantiles_stderr", some([4e-9, 5e-9, 6e-9])),
        ("contact_force", some([11.0, 3.0, 14.0])),
        ("contact_force_stderr", some([1e-6, 2e-6, 3e-6])),
        ("contact_fraction", some([0.5, 0.2, 0.6])),
        ("contact_fraction_stderr", some([4e-6, 5e-6, 6e-6])),
        ("contact_impact_rate", some([15.0, 16.0, 17.0])),
        ("contact_impact_rate_stderr", some([7e-6, 8e-6, 9e-6])),
        ("contact_rattle_index", some([18.0, 19.0, 20.0])),
        ("contact_rattle_index_stderr", some([1e-5, 2e-5, 3e-5])),
        ("contact_loss", some([21.0, 22.0, 23.0])),
        ("contact_loss_stderr", some([4e-5, 5e-5, 6e-5])),
        ("bearing_mean", some([-30.0, 31.0])),
        ("bearing_mean_stderr", some([7e-9, 8e-9])),
        ("bearing_rms", some([32.0, 33.0])),
        ("bearing_rms_stderr", some([9e-9, 1e-8])),
        ("torque_mean", some([34.0])),
        ("torque_mean_stderr", some([1.1e-8])),
        ("torque_rms", some([35.0])),
        ("torque_rms_stderr", some([1.2e-8])),
        ("acceleration_rms", some([36.0, 37.0])),
        ("acceleration_rms_stderr", some([1.3e-8, 1.4e-8])),
        ("angular_acceleration_rms", some([38.0])),
        ("angular_acceleration_rms_stderr", some([1.5e-8])),
        ("mesh_deflection_rms", some([39.0, 40.0])),
        ("mesh_deflection_rms_stderr", some([1.6e-8, 1.7e-8])),
        ("mesh_force_rms", some([41.0, 42.0])),
        ("mesh_force_rms_stderr", some([1.8e-8, 1.9e-8])),
    ] {
        assert_eq!(points.lists(name), [Some(list), None], "{name}");
    }
    read.push(points.read_through(TableKind::Points));

    let samples = Asked::read(folder.path(), TableKind::Poincare);
    assert_eq!(samples.u64("point_id"), [Some(0)]);
    assert_eq!(samples.u64("cycle"), [Some(7)]);
    assert_eq!(samples.f64("deflection"), [Some(0.0)]);
    assert_eq!(samples.f64("velocity"), [Some(-2e-3)]);
    assert_eq!(samples.f64("phase"), [Some(0.25)]);
    assert_eq!(samples.text("section"), [Some("strobe".into())]);
    read.push(samples.read_through(TableKind::Poincare));

    let lines = Asked::read(folder.path(), TableKind::Spectra);
    assert_eq!(
        lines.text("signal"),
        [Some("force".into()), Some("force".into())]
    );
    assert_eq!(lines.f64("frequency"), [Some(100.0), Some(200.0)]);
    assert_eq!(lines.f64("order"), [Some(0.5), Some(1.0)]);
    assert_eq!(lines.f64("amplitude"), [Some(3.0), Some(4.0)]);
    assert_eq!(lines.u64("point_id"), [Some(0); 2]);
    let welch = Some("welch".to_owned());
    assert_eq!(lines.text("method"), [welch.clone(), welch]);
    assert_eq!(lines.text("unit"), [Some("N".into()), Some("N".into())]);
    assert_eq!(lines.f64("bandwidth"), [Some(300.0); 2]);
    assert_eq!(lines.f64("amplitude_stderr"), [Some(0.25), None]);
    read.push(lines.read_through(TableKind::Spectra));

    let orders = Asked::read(folder.path(), TableKind::Orders);
    assert_eq!(orders.u64("point_id"), [Some(0)]);
    for (name, value) in [
        ("signal", "torque pinion"),
        ("unit", "N m"),
        ("reference", "pinion"),
    ] {
        assert_eq!(orders.text(name), [Some(value.to_owned())]);
    }
    assert_eq!(orders.u64("multiple"), [Some(2)]);
    for (name, value) in [
        ("order", Some(0.1)),
        ("frequency", Some(20.0)),
        ("amplitude", Some(5.0)),
        ("amplitude_stderr", Some(0.5)),
        ("phase", Some(-1.0)),
        ("phase_stderr", None),
    ] {
        assert_eq!(orders.f64(name), [value], "{name}");
    }
    read.push(orders.read_through(TableKind::Orders));

    let probes = Asked::read(folder.path(), TableKind::Probes);
    for (name, values) in [
        ("point_id", [Some(0), Some(0)]),
        ("probe_id", [Some(0), Some(1)]),
        ("attractor_id", [Some(0), None]),
        ("period", [Some(3), Some(3)]),
        ("cycles", [Some(2500), Some(2500)]),
    ] {
        assert_eq!(probes.u64(name), values, "{name}");
    }
    for (name, value) in [
        ("status", "not_converged"),
        ("reason", "for a test"),
        ("class", "periodic"),
    ] {
        let value = Some(value.to_owned());
        assert_eq!(probes.text(name), [value.clone(), value], "{name}");
    }
    for (name, value) in [
        ("amplitude", 1.5),
        ("lambda", -0.2),
        ("lambda_stderr", 1e-9),
        ("deflection_rms", 3e-5),
        ("force_peak", 1.8e4),
        ("events_per_cycle", 4.0),
        ("basin_share", 0.5),
        ("basin_low", 0.09),
        ("basin_high", 0.91),
    ] {
        assert_eq!(probes.f64(name), [Some(value); 2], "{name}");
    }
    read.push(probes.read_through(TableKind::Probes));

    let found = Asked::read(folder.path(), TableKind::Attractors);
    for (name, value) in [
        ("point_id", 0),
        ("attractor_id", 0),
        ("period", 2),
        ("probes", 1),
        ("cells", 12),
    ] {
        assert_eq!(found.u64(name), [Some(value)], "{name}");
    }
    assert_eq!(found.text("class"), [Some("periodic".into())]);
    for (name, value) in [
        ("lambda", -0.3),
        ("chaos_lifetime_low", 5000.0),
        ("lambda_stderr", 2e-9),
        ("deflection_rms", 4e-5),
        ("force_peak", 1.7e4),
        ("events_per_cycle", 3.0),
        ("basin_share", 0.5),
        ("basin_low", 0.09),
        ("basin_high", 0.91),
    ] {
        assert_eq!(found.f64(name), [Some(value)], "{name}");
    }
    let x = vec![Some(1e-6), Some(3e-6)];
    let y = vec![Some(2e-6), Some(4e-6)];
    assert_eq!(found.lists("slice_x"), [Some(x)]);
    assert_eq!(found.lists("slice_y"), [Some(y)]);
    read.push(found.read_through(TableKind::Attractors));

    let cells = Asked::read(folder.path(), TableKind::Basins);
    for (name, values) in [
        ("point_id", [Some(0), Some(0)]),
        ("i", [Some(0), Some(1)]),
        ("j", [Some(5), Some(5)]),
        ("attractor_id", [Some(0), None]),
        ("period", [Some(2), Some(2)]),
        ("cycles", [Some(77), Some(77)]),
    ] {
        assert_eq!(cells.u64(name), values, "{name}");
    }
    assert_eq!(cells.f64("x"), [Some(-1e-6); 2]);
    assert_eq!(cells.f64("y"), [Some(6e-6); 2]);
    assert_eq!(cells.bool("in_full"), [Some(true); 2]);
    for (name, value) in [("status", "ok"), ("class", "periodic")] {
        let value = Some(value.to_owned());
        assert_eq!(cells.text(name), [value.clone(), value], "{name}");
    }
    read.push(cells.read_through(TableKind::Basins));

    let orbits = Asked::read(folder.path(), TableKind::Orbits);
    for (name, values) in [
        ("point_id", [Some(0), Some(0)]),
        ("state", [Some(3), Some(7)]),
        ("period", [Some(5), Some(8)]),
        ("events", [Some(24), None]),
    ] {
        assert_eq!(orbits.u64(name), values, "{name}");
    }
    for (name, value) in [
        ("residual", 1e-14),
        ("deflection", 8e-6),
        ("velocity", 9e-3),
        ("deflection_pp", 2e-5),
        ("lambda", -0.4),
        ("grazing_margin", 0.6),
        ("kick_growth", 1.6),
        ("kick_growth_linear", 1.7),
    ] {
        assert_eq!(orbits.f64(name), [Some(value), None], "{name}");
    }
    assert_eq!(orbits.bool("found"), [Some(true), Some(false)]);
    assert_eq!(orbits.bool("stable"), [Some(true), None]);
    for (name, texts) in [
        ("reason", [None, Some("for a test")]),
        ("bifurcation", [Some("neimark_sacker"), None]),
    ] {
        assert_eq!(
            orbits.text(name),
            texts.map(|text| text.map(str::to_owned)),
            "{name}"
        );
    }
    for (name, list) in [
        ("multipliers_re", [0.7, 0.7]),
        ("multipliers_im", [0.1, -0.1]),
        ("kick_distance", [1e-5, 1.6e-5]),
        ("kick_distance_linear", [1e-5, 1.7e-5]),
        ("displacement", [1e-7, 2e-7]),
        ("modal_velocity", [3e-4, 4e-4]),
    ] {
        assert_eq!(orbits.lists(name), [Some(some(list)), None], "{name}");
    }
    read.push(orbits.read_through(TableKind::Orbits));

    let changes = Asked::read(folder.path(), TableKind::Transitions);
    for (name, value) in [
        ("point_id", 0),
        ("from_period", 6),
        ("to_period", 7),
        ("trials", 9),
    ] {
        assert_eq!(changes.u64(name), [Some(value)], "{name}");
    }
    for (name, value) in [
        ("axis", "speed"),
        ("direction", "down"),
        ("from_class", "periodic"),
        ("what", "deflection"),
        ("to_class", "steady_contact"),
    ] {
        assert_eq!(changes.text(name), [Some(value.into())], "{name}");
    }
    for (name, value) in [
        ("lower", 605.0),
        ("upper", 610.0),
        ("from_deflection_mean", 1e-6),
        ("to_deflection_mean", 3e-6),
        ("from_deflection_rms", 2e-6),
        ("to_deflection_rms", 6e-6),
    ] {
        assert_eq!(changes.f64(name), [Some(value)], "{name}");
    }
    read.push(changes.read_through(TableKind::Transitions));

    let growth = Asked::read(folder.path(), TableKind::Horizon);
    for (name, value) in [("point_id", 0), ("cycles", 1), ("samples", 16)] {
        assert_eq!(growth.u64(name), [Some(value)], "{name}");
    }
    assert_eq!(growth.text("quantity"), [Some("separation".into())]);
    assert_eq!(growth.f64("value"), [Some(2e-6)]);
    assert_eq!(growth.f64("spread"), [Some(0.7)]);
    read.push(growth.read_through(TableKind::Horizon));

    read.extend(every_column_of_a_trace_comes_back());
    // Followed orbits and run-ups have separate writers and separate tests.
    let others = [
        TableKind::Branches,
        TableKind::Bifurcations,
        TableKind::Curves,
        TableKind::Signals,
        TableKind::OrderTracks,
        TableKind::Levels,
        TableKind::Spectrogram,
        TableKind::ContactChanges,
    ];
    for kind in TableKind::VARIANTS {
        assert!(read.contains(kind) || others.contains(kind), "{kind:?}");
    }
}

/// Reads every column of the tables of a traced trajectory.
fn every_column_of_a_trace_comes_back() -> [TableKind; 2] {
    let folder = tempfile::tempdir().unwrap();
    let label = TraceLabel {
        job: "test".into(),
        manifest_hash: "0".into(),
        point: Vec::new(),
        period: 8e-4,
        half_gap: Some(1e-5),
        outputs: outputs(),
    };
    let mut writer = TraceWriter::create(folder.path(), &label, true).unwrap();
    writer.sample(instant()).unwrap();
    let event = Event {
        cycle: 4,
        time: 2e-4,
        from: ActiveSet::FREE,
        to: ActiveSet::COAST,
        contact: COAST_FLANK,
        rate: -5e-3,
    };
    writer.event(&event).unwrap();
    writer.finish().unwrap();

    let trace = Asked::read(folder.path(), TableKind::Trace);
    assert_eq!(trace.u64("cycle"), [Some(3)]);
    for (name, value) in [
        ("time", 2e-4),
        ("phase", 0.375),
        ("deflection", 1e-5),
        ("velocity", -4e-3),
        ("force", 250.0),
        ("bearing_pinion_1_x", 700.0),
        ("bearing_pinion_1_x_2", 800.0),
        ("torque_pinion", 7.0),
    ] {
        assert_eq!(trace.f64(name), [Some(value)], "{name}");
    }
    assert_eq!(trace.text("contact"), [Some("coast".into())]);
    assert_eq!(trace.u64("closed"), [Some(2)]);
    assert_eq!(trace.u64("closed_from_65"), [Some(0)]);
    assert_eq!(trace.lists("displacement"), [Some(some([1e-7, 2e-7]))]);
    assert_eq!(trace.lists("modal_velocity"), [Some(some([3e-7, 4e-7]))]);

    let events = Asked::read(folder.path(), TableKind::Events);
    assert_eq!(events.u64("cycle"), [Some(4)]);
    assert_eq!(events.f64("time"), [Some((4.0 + 2e-4 / 8e-4) * 8e-4)]);
    assert_eq!(events.f64("phase"), [Some(2e-4 / 8e-4)]);
    assert_eq!(events.f64("rate"), [Some(-5e-3)]);
    assert_eq!(events.text("kind"), [Some("coast_entry".into())]);
    assert_eq!(events.u64("contact"), [Some(COAST_FLANK as u64 + 1)]);
    [
        trace.read_through(TableKind::Trace),
        events.read_through(TableKind::Events),
    ]
}

#[test]
fn periods_are_stored_where_there_is_one() {
    let classes = [
        (Class::SteadyContact(Some(20)), Some(20)),
        (Class::SteadyContact(None), None),
        (Class::Periodic(4), Some(4)),
        (Class::QuasiPeriodic, None),
        (Class::NotConverged, None),
    ];
    let folder = tempfile::tempdir().unwrap();
    let rows = classes.iter().zip(0..).map(|(&(class, _), point_id)| {
        let mut row = full(point_id);
        row.outcome.class = Some(class);
        row
    });
    write(folder.path(), &layout(), rows.collect());
    let points = ResultTable::read(folder.path(), TableKind::Points).unwrap();
    assert_eq!(
        points.u64("period").unwrap(),
        classes.map(|(_, period)| period)
    );
    let words: Vec<_> = classes
        .iter()
        .map(|(class, _)| Some(class.name().to_owned()))
        .collect();
    assert_eq!(points.text("class").unwrap(), words);
}

#[test]
fn what_is_not_finite_becomes_a_null_and_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut row = full(0);
    let nvh = row.outcome.nvh.as_mut().unwrap();
    nvh.deflection_crest = f64::NAN;
    nvh.values.harmonics[1] = f64::INFINITY;
    write(folder.path(), &layout(), vec![row]);
    let points = ResultTable::read(folder.path(), TableKind::Points).unwrap();
    assert_eq!(points.f64("deflection_crest").unwrap(), [None]);
    assert_eq!(
        points.lists("harmonics").unwrap(),
        [Some(vec![Some(6e-6), None])]
    );
    let reason = points.text("reason").unwrap().remove(0).unwrap();
    assert!(
        reason.ends_with("(not a finite number: deflection_crest, harmonics)"),
        "{reason}"
    );
}

/// The tables of a [`full`] point.
const TABLES: [&str; 8] = [
    "attractors.parquet",
    "basins.parquet",
    "horizon.parquet",
    "orders.parquet",
    "poincare.parquet",
    "points.parquet",
    "probes.parquet",
    "spectra.parquet",
];

/// With equal placement, files are equal byte by byte: values, row groups and encoding depend on the points
/// alone.
#[test]
fn arrival_order_leaves_no_trace() {
    let [ascending, scattered] = [(), ()].map(|()| tempfile::tempdir().unwrap());
    let row = |id| if id % 7 == 3 { failed(id) } else { full(id) };
    write(ascending.path(), &layout(), (0..500).map(row).collect());
    // 211 and 500 are coprime, so every point is visited once.
    write(
        scattered.path(),
        &layout(),
        (0..500).map(|i| row(i * 211 % 500)).collect(),
    );
    for name in ["points.parquet", "poincare.parquet", "spectra.parquet"] {
        let bytes =
            [&ascending, &scattered].map(|folder| fs::read(folder.path().join(name)).unwrap());
        assert!(bytes[0] == bytes[1], "{name}");
    }
}

#[test]
fn a_file_has_its_name_only_when_whole() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &layout(), vec![full(0)]);
    let before = fs::read(folder.path().join("points.parquet")).unwrap();

    let mut writer = ResultWriter::create(folder.path(), &layout(), 0..2).unwrap();
    writer.push(full(1)).unwrap();
    let partial = names(folder.path());
    assert_eq!(
        partial
            .iter()
            .filter(|name| name.ends_with(".partial"))
            .count(),
        8,
        "{partial:?}"
    );
    assert!(
        partial
            .iter()
            .all(|name| name.starts_with('.') != name.ends_with(".parquet"))
    );
    drop(writer);

    assert_eq!(names(folder.path()), TABLES);
    assert_eq!(
        fs::read(folder.path().join("points.parquet")).unwrap(),
        before
    );
}

#[test]
fn only_the_dead_are_swept() {
    let folder = tempfile::tempdir().unwrap();
    let mut alive = ResultWriter::create(folder.path(), &layout(), 0..1).unwrap();
    fs::write(
        folder.path().join(".points.parquet.abc.partial"),
        "of a killed process",
    )
    .unwrap();
    fs::write(folder.path().join("notes.partial"), "of the user").unwrap();
    drop(ResultWriter::create(folder.path(), &layout(), 0..1).unwrap());
    assert!(!folder.path().join(".points.parquet.abc.partial").exists());
    assert!(folder.path().join("notes.partial").exists());
    alive.push(full(0)).unwrap();
    assert_eq!(alive.finish().unwrap().rows(TableKind::Points), 1);
}

#[test]
fn an_interrupted_run_keeps_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = ResultWriter::create(folder.path(), &layout(), 0..10).unwrap();
    for point_id in [7, 0, 3] {
        writer.push(full(point_id)).unwrap();
    }
    assert_eq!(writer.waiting(), 2);
    assert_eq!(writer.finish().unwrap().missing, 7);
    let points = ResultTable::read(folder.path(), TableKind::Points).unwrap();
    assert_eq!(points.u64("point_id").unwrap(), [Some(0), Some(3), Some(7)]);
}

#[test]
fn a_stranger_is_refused_at_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = ResultWriter::create(folder.path(), &layout(), [0, 2]).unwrap();
    for point_id in [0, 2] {
        writer.push(full(point_id)).unwrap();
    }
    assert!(writer.push(full(2)).is_err(), "twice");
    drop(writer);
    let mut writer = ResultWriter::create(folder.path(), &layout(), [0, 2]).unwrap();
    writer.push(full(1)).unwrap();
    let error = writer.finish().unwrap_err();
    assert!(
        matches!(error, StoreError::UnexpectedPoint { point_id: 1 }),
        "{error:?}"
    );
    assert!(names(folder.path()).is_empty());
}

#[test]
fn a_hundred_thousand_points_stream() {
    let folder = tempfile::tempdir().unwrap();
    let count = 100_000;
    let layout = ResultLayout {
        basin_axes: None,
        ..layout()
    };
    let mut writer = ResultWriter::create(folder.path(), &layout, 0..count).unwrap();
    // Eight workers, each a block of eight points ahead of or behind the others.
    for block in (0..count).step_by(64) {
        for lane in (0..8).rev() {
            for step in 0..8 {
                let point_id = block + 8 * lane + step;
                if point_id < count {
                    writer.push(full(point_id)).unwrap();
                }
                assert!(writer.waiting() <= 64);
            }
        }
    }
    assert_eq!(writer.finish().unwrap().rows(TableKind::Points), count);
    let points = ResultTable::read(folder.path(), TableKind::Points).unwrap();
    let ids: Vec<_> = (0..count).map(Some).collect();
    assert_eq!(points.u64("point_id").unwrap(), ids);
    let last = points.f64("lambda_max").unwrap().pop().unwrap().unwrap();
    assert_eq!(last, 0.86 + (count - 1) as f64);
}

#[test]
fn shards_read_as_one_table() {
    let folder = tempfile::tempdir().unwrap();
    for index in [2, 1] {
        let shard = Some(Shard { index, count: 2 });
        let rows = (0..3).map(|i| full(2 * i + u64::from(index) - 1)).collect();
        write(folder.path(), &ResultLayout { shard, ..layout() }, rows);
    }
    assert_eq!(names(folder.path()), TABLES);
    let shards = names(&folder.path().join("points.parquet"));
    assert_eq!(shards, ["shard-1-of-2.parquet", "shard-2-of-2.parquet"]);
    let points = ResultTable::read(folder.path(), TableKind::Points).unwrap();
    assert_eq!(
        points.u64("point_id").unwrap(),
        (0..6).map(Some).collect::<Vec<_>>()
    );
    let loads: Vec<_> = (0..6).map(|id| Some(0.05 + f64::from(id))).collect();
    assert_eq!(points.f64("load").unwrap(), loads);

    let error = ResultWriter::create(folder.path(), &layout(), 0..2)
        .err()
        .unwrap();
    assert!(matches!(error, StoreError::OtherLayout { .. }), "{error:?}");
}

#[test]
fn impossible_folders_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    for path in [file.clone(), file.join("below")] {
        let error = ResultWriter::create(&path, &layout(), 0..1).err().unwrap();
        assert!(error.to_string().contains("not a folder"), "{error:?}");
    }
    let mut taken = layout();
    taken.axes[0].name = "period".into();
    let error = ResultWriter::create(folder.path(), &taken, 0..1)
        .err()
        .unwrap();
    assert!(
        matches!(error, StoreError::AxisNameTaken { .. }),
        "{error:?}"
    );
}

#[test]
fn foreign_files_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let read = || {
        ResultTable::read(folder.path(), TableKind::Points)
            .err()
            .unwrap()
    };
    assert!(matches!(read(), StoreError::Missing { .. }));
    fs::write(folder.path().join("points.parquet"), "not Parquet at all").unwrap();
    assert!(matches!(read(), StoreError::Parquet { .. }));
}

/// Columns of lists and their standard errors have the names of the elements.
#[test]
fn elements_of_lists_have_their_names() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &layout(), vec![full(0)]);
    let columns = ResultTable::head(folder.path(), TableKind::Points).unwrap();
    let names = |wanted: &str| {
        let columns = columns.columns().unwrap().into_iter();
        let mut own = columns.filter(|column| column.name == wanted);
        own.next().unwrap().elements
    };
    for name in ["bearing_mean", "bearing_rms", "bearing_rms_stderr"] {
        assert_eq!(names(name), ["pinion 1 x", "pinion 1 y"], "{name}");
    }
    for name in ["torque_rms", "harmonics", "speed"] {
        assert_eq!(names(name), [] as [&str; 0], "{name}");
    }
}
