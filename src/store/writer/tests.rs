//! Round trips, order, names: what a result file promises.

use std::fs;
use std::path::Path;

use super::*;
use crate::analysis::{
    AttractorOutcome, BasinShare, CellOutcome, Class, DurationOutcome, HorizonMeasure,
    HorizonOutcome, HorizonQuantity, LyapunovMethod, LyapunovOutcome, MultistabilityOutcome,
    NvhErrors, NvhOutcome, PoincareSample, PointOutcome, ProbeOutcome, SampleKind, Spectrum,
    SpectrumLine, SpectrumMethod, Status,
};
use crate::store::{Placement, ResultTable, Table};

fn layout() -> ResultLayout {
    let axis = |name: &str, unit: &str| AxisColumn {
        name: name.into(),
        unit: unit.into(),
    };
    ResultLayout {
        axes: vec![
            axis("load", "1"),
            axis("speed", "rad/s"),
            axis("mesh.half_gap", "m"),
        ],
        poincare: true,
        spectra: true,
        probes: true,
        orbits: false,
        chains: None,
        basins: Some(["of mode 1".into(), "of mode 2".into()]),
        horizon: true,
        shard: None,
    }
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
                stderr: 0.01,
                twin: Some(0.85),
                twin_stderr: Some(0.02),
                twin_agrees: Some(true),
                method: LyapunovMethod::Tangent,
            }),
            nvh: Some(NvhOutcome {
                deflection_mean: 1e-6,
                deflection_rms: 2e-6,
                deflection_pp: 3e-6,
                deflection_crest: 4.0,
                deflection_kurtosis: 5.0,
                harmonics: vec![6e-6, 7e-6],
                force_mean: 8.0,
                force_std: 9.0,
                force_peak: 10.0,
                impact_rate: 11.0,
                impact_velocity: 12.0,
                fractions: [0.5, 0.3, 0.2],
                suborders: vec![1e-7; 5],
                impacts: [20, 21],
                impact_velocity_quantiles: vec![0.1, 0.2, 0.3],
                impact_velocity_max: Some(0.4),
                bearing_mean: vec![-30.0, 31.0],
                bearing_rms: vec![32.0, 33.0],
                flights: DurationOutcome {
                    count: 22,
                    mean: Some(5e-5),
                    median: Some(6e-5),
                },
                contacts: DurationOutcome {
                    count: 23,
                    mean: Some(7e-5),
                    median: Some(8e-5),
                },
                stderr: Some(NvhErrors {
                    deflection_rms: 1e-8,
                    harmonics: vec![1e-9, 2e-9],
                    // Too few flights for an error bar.
                    flight_median: f64::INFINITY,
                    ..NvhErrors::default()
                }),
            }),
            spectra: vec![Spectrum {
                signal: "force".to_owned(),
                method: SpectrumMethod::Welch,
                lines: vec![
                    SpectrumLine {
                        frequency: 100.0,
                        order: 0.5,
                        amplitude: 3.0,
                    },
                    SpectrumLine {
                        frequency: 200.0,
                        order: 1.0,
                        amplitude: 4.0,
                    },
                ],
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

/// A point of which nothing is known but that it failed.
fn failed(point_id: u64) -> PointRow {
    let mut row = full(point_id);
    row.outcome = PointOutcome {
        status: Status::Failed,
        reason: "the model has no mesh mode".into(),
        class: None,
        lyapunov: None,
        nvh: None,
        spectra: Vec::new(),
        poincare: Vec::new(),
        events_per_cycle: None,
        energy_residual: None,
        grazing_count: 0,
        cycles: 0,
        measured_cycles: 0,
    };
    row.multistability = None;
    row.horizon = None;
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

fn listing<R>(table: &Table<R>) -> String {
    let fields = table.schema();
    let lines = fields.fields().iter().map(|field| {
        let (metadata, kind) = (field.metadata(), field.data_type());
        format!(
            "{}: {kind} [{}] {}",
            field.name(),
            &metadata["unit"],
            &metadata["description"]
        )
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn columns_units_and_descriptions() {
    insta::assert_snapshot!(
        "points",
        listing(&points_table(&layout().axes, None).unwrap())
    );
    insta::assert_snapshot!("poincare", listing(&poincare_table()));
    insta::assert_snapshot!("spectra", listing(&spectra_table()));
    insta::assert_snapshot!("probes", listing(&probes_table()));
    insta::assert_snapshot!("attractors", listing(&attractors_table()));
    insta::assert_snapshot!("basins", listing(&basins_table()));
}

#[test]
fn every_column_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let written = write(folder.path(), &layout(), vec![full(0), failed(1)]);
    assert_eq!(written.missing, 0);
    for (kind, rows) in [
        (TableKind::Points, 2),
        (TableKind::Poincare, 1),
        (TableKind::Spectra, 2),
        (TableKind::Probes, 2),
        (TableKind::Orbits, 0),
        (TableKind::Transitions, 0),
        (TableKind::Attractors, 1),
        (TableKind::Basins, 2),
        (TableKind::Horizon, 1),
    ] {
        assert_eq!(written.rows(kind), rows, "{kind:?}");
    }

    let points = ResultTable::read(folder.path(), TableKind::Points).unwrap();
    assert_eq!(points.axes().unwrap(), ["load", "speed", "mesh.half_gap"]);
    let numbers = |name: &str| points.f64(name).unwrap();
    let counts = |name: &str| points.u64(name).unwrap();
    let text = |name: &str| points.text(name).unwrap();
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
    assert_eq!(points.bool("twin_agrees").unwrap(), [Some(true), None]);
    assert_eq!(text("lambda_method"), [Some("tangent".into()), None]);
    let exponents = Some(vec![Some(0.86), Some(-0.3), Some(-1.0 / 3.0)]);
    assert_eq!(points.lists("exponents").unwrap(), [exponents, None]);
    let harmonics = Some(vec![Some(6e-6), Some(7e-6)]);
    assert_eq!(points.lists("harmonics").unwrap(), [harmonics, None]);
    for (name, value) in [
        ("lambda_max", 0.86),
        ("lambda_stderr", 0.01),
        ("lambda_twin", 0.85),
        ("events_per_cycle", 2.5),
        ("fraction_drive", 0.5),
        ("fraction_free", 0.3),
        ("fraction_coast", 0.2),
        ("deflection_mean", 1e-6),
        ("deflection_rms", 2e-6),
        ("deflection_pp", 3e-6),
        ("deflection_crest", 4.0),
        ("deflection_kurtosis", 5.0),
        ("force_mean", 8.0),
        ("force_std", 9.0),
        ("force_peak", 10.0),
        ("impact_rate", 11.0),
        ("impact_velocity", 12.0),
        ("energy_residual", 1e-12),
    ] {
        assert_eq!(numbers(name), [Some(value), None], "{name}");
    }
    assert_eq!(counts("attractors"), [Some(1), None]);
    assert_eq!(counts("grazing_count"), [Some(13), Some(0)]);
    assert_eq!(counts("cycles"), [Some(14), Some(0)]);
    assert_eq!(counts("measured_cycles"), [Some(15), Some(0)]);
    assert_eq!(
        text("kernel"),
        [Some("volterra".into()), Some("volterra".into())]
    );
    assert_eq!(numbers("wall_time"), [Some(18.0), Some(18.0)]);
    assert_eq!(counts("worker"), [Some(16), Some(16)]);
    assert_eq!(counts("numa_node"), [Some(17), None]);

    let samples = ResultTable::read(folder.path(), TableKind::Poincare).unwrap();
    assert_eq!(samples.u64("point_id").unwrap(), [Some(0)]);
    assert_eq!(samples.u64("cycle").unwrap(), [Some(7)]);
    assert_eq!(samples.f64("deflection").unwrap(), [Some(0.0)]);
    assert_eq!(samples.f64("velocity").unwrap(), [Some(-2e-3)]);

    let lines = ResultTable::read(folder.path(), TableKind::Spectra).unwrap();
    assert_eq!(
        lines.text("signal").unwrap(),
        [Some("force".into()), Some("force".into())]
    );
    assert_eq!(lines.f64("frequency").unwrap(), [Some(100.0), Some(200.0)]);
    assert_eq!(lines.f64("order").unwrap(), [Some(0.5), Some(1.0)]);
    assert_eq!(lines.f64("amplitude").unwrap(), [Some(3.0), Some(4.0)]);

    let probes = ResultTable::read(folder.path(), TableKind::Probes).unwrap();
    for (name, values) in [
        ("point_id", [Some(0), Some(0)]),
        ("probe_id", [Some(0), Some(1)]),
        ("attractor_id", [Some(0), None]),
        ("period", [Some(3), Some(3)]),
        ("cycles", [Some(2500), Some(2500)]),
    ] {
        assert_eq!(probes.u64(name).unwrap(), values, "{name}");
    }
    for (name, value) in [
        ("status", "not_converged"),
        ("reason", "for a test"),
        ("class", "periodic"),
    ] {
        let value = Some(value.to_owned());
        assert_eq!(probes.text(name).unwrap(), [value.clone(), value], "{name}");
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
        assert_eq!(probes.f64(name).unwrap(), [Some(value); 2], "{name}");
    }

    let found = ResultTable::read(folder.path(), TableKind::Attractors).unwrap();
    for (name, value) in [
        ("point_id", 0),
        ("attractor_id", 0),
        ("period", 2),
        ("probes", 1),
        ("cells", 12),
    ] {
        assert_eq!(found.u64(name).unwrap(), [Some(value)], "{name}");
    }
    assert_eq!(found.text("class").unwrap(), [Some("periodic".into())]);
    for (name, value) in [
        ("lambda", -0.3),
        ("lambda_stderr", 2e-9),
        ("deflection_rms", 4e-5),
        ("force_peak", 1.7e4),
        ("events_per_cycle", 3.0),
        ("basin_share", 0.5),
        ("basin_low", 0.09),
        ("basin_high", 0.91),
    ] {
        assert_eq!(found.f64(name).unwrap(), [Some(value)], "{name}");
    }
    let x = vec![Some(1e-6), Some(3e-6)];
    let y = vec![Some(2e-6), Some(4e-6)];
    assert_eq!(found.lists("slice_x").unwrap(), [Some(x)]);
    assert_eq!(found.lists("slice_y").unwrap(), [Some(y)]);

    let cells = ResultTable::read(folder.path(), TableKind::Basins).unwrap();
    for (name, values) in [
        ("point_id", [Some(0), Some(0)]),
        ("i", [Some(0), Some(1)]),
        ("j", [Some(5), Some(5)]),
        ("attractor_id", [Some(0), None]),
        ("period", [Some(2), Some(2)]),
        ("cycles", [Some(77), Some(77)]),
    ] {
        assert_eq!(cells.u64(name).unwrap(), values, "{name}");
    }
    assert_eq!(cells.f64("x").unwrap(), [Some(-1e-6); 2]);
    assert_eq!(cells.f64("y").unwrap(), [Some(6e-6); 2]);
    assert_eq!(cells.bool("in_full").unwrap(), [Some(true); 2]);
    for (name, value) in [("status", "ok"), ("class", "periodic")] {
        let value = Some(value.to_owned());
        assert_eq!(cells.text(name).unwrap(), [value.clone(), value], "{name}");
    }
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
    nvh.harmonics[1] = f64::INFINITY;
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

/// With equal placement, files are equal byte by byte: values, row groups and encoding
/// follow from the points alone.
#[test]
fn arrival_order_leaves_no_trace() {
    let [ascending, scattered] = [(), ()].map(|()| tempfile::tempdir().unwrap());
    let row = |id| if id % 7 == 3 { failed(id) } else { full(id) };
    write(ascending.path(), &layout(), (0..500).map(row).collect());
    // 211 is prime to 500, so this visits every point once.
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
        7,
        "{partial:?}"
    );
    assert!(
        partial
            .iter()
            .all(|name| name.starts_with('.') != name.ends_with(".parquet"))
    );
    drop(writer);

    assert_eq!(
        names(folder.path()),
        [
            "attractors.parquet",
            "basins.parquet",
            "horizon.parquet",
            "poincare.parquet",
            "points.parquet",
            "probes.parquet",
            "spectra.parquet"
        ]
    );
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
        poincare: false,
        spectra: false,
        probes: false,
        orbits: false,
        basins: None,
        horizon: false,
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
    assert_eq!(
        names(folder.path()),
        [
            "attractors.parquet",
            "basins.parquet",
            "horizon.parquet",
            "poincare.parquet",
            "points.parquet",
            "probes.parquet",
            "spectra.parquet"
        ]
    );
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
