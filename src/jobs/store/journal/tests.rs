//! A journal returns every bit, and nothing that was damaged.

use super::*;
use crate::analysis::{
    AngleOutcome, AttractorOutcome, BasinShare, CellOutcome, ChaosAverages, ChaosOutcome, Class,
    ConvergenceOutcome, CovariantOutcome, EvidenceOutcome, GrowthRecord, KaplanYorke,
    LyapunovMethod, LyapunovOutcome, MultistabilityOutcome, NvhOutcome, NvhStatistics,
    PoincareSample, PointOutcome, ProbeOutcome, SampleKind, Spectrum, SpectrumLine, SpectrumMethod,
    Status,
};
use crate::analysis::{HorizonMeasure, HorizonOutcome, HorizonQuantity};
use crate::store::Placement;
use proptest::prelude::*;

const HASH: &str = "0123456789abcdef";

fn row(point_id: u64, numbers: &[f64]) -> PointRow {
    let number = |i: usize| numbers[i % numbers.len()];
    PointRow {
        point_id,
        axis_values: numbers.to_vec(),
        outcome: PointOutcome {
            status: Status::NotConverged,
            reason: "µ\n\"quoted\"".into(),
            class: Some(Class::Periodic(3)),
            lyapunov: Some(LyapunovOutcome {
                exponents: numbers.to_vec(),
                errors: vec![number(1), number(0), number(2)],
                dimension: Some(KaplanYorke {
                    value: number(2),
                    stderr: number(0),
                }),
                twin: Some(number(2)),
                twin_stderr: None,
                twin_agrees: Some(false),
                method: LyapunovMethod::Multipliers,
                convergence: Some(ConvergenceOutcome {
                    cycles: numbers.to_vec(),
                    exponents: numbers.to_vec(),
                    errors: numbers.to_vec(),
                }),
            }),
            nvh: Some(NvhOutcome {
                cycles: 5,
                values: NvhStatistics {
                    deflection_mean: number(3),
                    harmonics: numbers.to_vec(),
                    fractions: [number(0), number(1), number(2), number(0)],
                    ..NvhStatistics::default()
                },
                ..NvhOutcome::default()
            }),
            spectra: ["deflection", "force"]
                .map(|signal| Spectrum {
                    signal: signal.to_owned(),
                    unit: "N".to_owned(),
                    method: SpectrumMethod::Fourier,
                    bandwidth: None,
                    lines: vec![SpectrumLine {
                        frequency: number(0),
                        order: number(1),
                        amplitude: number(2),
                        stderr: None,
                    }],
                })
                .into(),
            orders: Vec::new(),
            poincare: vec![PoincareSample {
                cycle: u64::MAX,
                phase: 0.25,
                deflection: number(4),
                velocity: number(5),
                kind: SampleKind::Strobe,
            }],
            events_per_cycle: Some(number(0)),
            energy_residual: None,
            evidence: Some(EvidenceOutcome {
                trajectories: 8,
                verified: true,
                correlation_cycles: Some(number(0)),
                ess: None,
                rhat: Some(number(1)),
                rotation_number: Some(number(2)),
                chains: Some(GrowthRecord {
                    lengths: vec![2.0, 1.0],
                    growth: numbers.to_vec(),
                }),
            }),
            chaos: Some(ChaosOutcome {
                cycles: u64::MAX,
                exits: 8,
                trajectories: 8,
                ended_on: Some("periodic 3 (8)".into()),
                averages_before_exit: Some(ChaosAverages {
                    lambda: [number(3), number(4)],
                    deflection_rms: Some([number(5), number(6)]),
                    force_std: None,
                    impact_velocity: Some([number(7), number(8)]),
                }),
            }),
            grazing_count: 1,
            cycles: u64::MAX,
            measured_cycles: 0,
        },
        horizon: Some(HorizonOutcome {
            horizon: Some(17.0),
            stderr: None,
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
        mesh: None,
        covariant: Some(CovariantOutcome {
            exponents: numbers.to_vec(),
            errors: numbers.to_vec(),
            spreads: numbers.to_vec(),
            unstable: 1,
            stable: 2,
            angle: Some(AngleOutcome {
                min: number(0),
                mean: number(1),
                stderr: number(2),
                quantiles: numbers.to_vec(),
            }),
            cycles: 3,
        }),
        multistability: Some(MultistabilityOutcome {
            attractors: vec![AttractorOutcome {
                class: Class::QuasiPeriodic,
                lambda: Some(number(1)),
                chaos_lifetime_low: Some(number(2)),
                lambda_stderr: None,
                deflection_rms: Some(number(2)),
                force_peak: None,
                events_per_cycle: Some(number(3)),
                probes: 5,
                basin: BasinShare::default(),
                cells: Some(u32::MAX),
                strobe: vec![[number(4), number(5)]],
            }],
            cells: vec![CellOutcome {
                column: 3,
                row: u32::MAX,
                place: [number(6), number(7)],
                attractor: None,
                status: Status::EventStorm,
                class: Some(Class::SteadyContact(Some(1))),
                in_full: true,
                cycles: u64::MAX,
            }],
            probes: vec![ProbeOutcome {
                probe_id: 7,
                amplitude: number(0),
                attractor: Some(1),
                status: Status::Diverged,
                reason: "µ".into(),
                class: None,
                lambda: Some(number(1)),
                lambda_stderr: None,
                deflection_rms: Some(number(2)),
                force_peak: Some(number(3)),
                events_per_cycle: Some(number(4)),
                cycles: u64::MAX,
                basin: BasinShare {
                    share: number(5),
                    low: number(6),
                    high: number(7),
                },
            }],
        }),
        orbits: None,
        chain: None,
        kernel: "volterra".into(),
        placement: Placement {
            worker: 3,
            numa_node: Some(1),
            wall_time: number(0),
        },
    }
}

fn open(folder: &Path) -> Journal {
    Journal::open(folder, HASH, None, false).unwrap()
}

fn replayed(journal: &mut Journal) -> Vec<PointRow> {
    let mut rows = Vec::new();
    journal
        .replay(|row| {
            rows.push(row);
            Ok(())
        })
        .unwrap();
    rows
}

fn ids(journal: &mut Journal) -> Vec<u64> {
    replayed(journal).iter().map(|row| row.point_id).collect()
}

/// Bytes of a journal of points 0, 1, 2, and the ends of its header and of each point.
fn three_points(folder: &Path) -> (Vec<u8>, [usize; 4]) {
    let mut journal = open(folder);
    let mut ends = [journal.end as usize; 4];
    for point_id in 0..3 {
        journal.append(&row(point_id, &[0.1])).unwrap();
        ends[point_id as usize + 1] = journal.end as usize;
    }
    (fs::read(&journal.path).unwrap(), ends)
}

/// Bytes that distinguish rows even if they contain NaN.
fn bits(row: &PointRow) -> Vec<u8> {
    postcard::to_allocvec(row).unwrap()
}

proptest! {
    #[test]
    fn every_bit_comes_back(patterns in prop::collection::vec(any::<u64>(), 6)) {
        let folder = tempfile::tempdir().unwrap();
        let mut numbers: Vec<f64> = patterns.into_iter().map(f64::from_bits).collect();
        numbers.extend([f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -0.0, 5e-324, f64::MAX]);
        let rows = [row(7, &numbers), row(2, &numbers)];
        let mut journal = open(folder.path());
        for row in &rows {
            journal.append(row).unwrap();
        }
        drop(journal);
        let mut journal = open(folder.path());
        let back = replayed(&mut journal);
        prop_assert_eq!(back.len(), 2);
        for (row, back) in rows.iter().zip(&back) {
            prop_assert_eq!(bits(row), bits(back));
            for (a, b) in row.axis_values.iter().zip(&back.axis_values) {
                prop_assert_eq!(a.to_bits(), b.to_bits());
            }
            prop_assert_eq!(&row.outcome.reason, &back.outcome.reason);
            prop_assert_eq!(&row.outcome.spectra[1].signal, &back.outcome.spectra[1].signal);
        }
    }
}

#[test]
fn a_journal_cut_anywhere_gives_the_whole_points_before_the_cut() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, ends) = three_points(folder.path());
    let path = journal_path(folder.path(), None);
    for length in 0..=bytes.len() {
        fs::write(&path, &bytes[..length]).unwrap();
        let whole = ends[1..].iter().filter(|end| **end <= length).count() as u64;
        let mut journal = open(folder.path());
        assert_eq!(ids(&mut journal), (0..whole).collect::<Vec<_>>());
        journal.append(&row(9, &[1.0])).unwrap();
        drop(journal);
        let expected: Vec<u64> = (0..whole).chain([9]).collect();
        assert_eq!(ids(&mut open(folder.path())), expected, "cut at {length}");
    }
}

#[test]
fn a_flipped_bit_ends_the_journal_before_its_record() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, ends) = three_points(folder.path());
    let path = journal_path(folder.path(), None);
    for at in ends[0]..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        fs::write(&path, &damaged).unwrap();
        let whole = ends[1..].iter().filter(|end| **end <= at).count() as u64;
        let mut journal = open(folder.path());
        assert_eq!(
            ids(&mut journal),
            (0..whole).collect::<Vec<_>>(),
            "byte {at}"
        );
        drop(journal);
        let left = fs::metadata(&path).unwrap().len() as usize;
        assert_eq!(left, ends[whole as usize], "what is damaged is cut off");
    }
}

/// A damaged header before points is refused; the file stays as it is. Without points, the journal starts anew.
#[test]
fn a_damaged_header_costs_no_point() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, ends) = three_points(folder.path());
    let path = journal_path(folder.path(), None);
    for at in MAGIC.len()..ends[0] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        fs::write(&path, &damaged).unwrap();
        let error = Journal::open(folder.path(), HASH, None, false).unwrap_err();
        assert!(
            matches!(error, StoreError::ForeignJournal { .. }),
            "{error}"
        );
        assert_eq!(fs::read(&path).unwrap(), damaged, "byte {at}");
        fs::write(&path, &damaged[..ends[0]]).unwrap();
        assert_eq!(ids(&mut open(folder.path())), [0; 0]);
        assert_eq!(fs::read(&path).unwrap(), bytes[..ends[0]]);
    }
}

#[test]
fn another_job_shard_or_program_is_refused_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, _) = three_points(folder.path());
    let path = journal_path(folder.path(), None);
    let error = Journal::open(folder.path(), "fedcba9876543210", None, false).unwrap_err();
    assert!(matches!(error, StoreError::OtherJob { .. }), "{error}");
    assert!(error.to_string().contains("01234567…"), "{error}");

    let shard = Some(Shard { index: 1, count: 2 });
    fs::copy(&path, journal_path(folder.path(), shard)).unwrap();
    let error = Journal::open(folder.path(), HASH, shard, false).unwrap_err();
    assert!(
        matches!(error, StoreError::ForeignJournal { .. }),
        "{error}"
    );

    fs::write(&path, "shopping list: gears").unwrap();
    let error = Journal::open(folder.path(), HASH, None, false).unwrap_err();
    assert!(
        matches!(error, StoreError::ForeignJournal { .. }),
        "{error}"
    );
    assert_eq!(fs::read(&path).unwrap(), b"shopping list: gears");

    let mut header = Header {
        job_hash: HASH.into(),
        shard: None,
        program: ProgramRecord::current(),
        instructions: instructions().to_owned(),
    };
    header.program.commit = Some("another".into());
    let mut other = MAGIC.to_vec();
    other.extend(record(&header, &path).unwrap());
    fs::write(&path, &other).unwrap();
    let error = Journal::open(folder.path(), HASH, None, false).unwrap_err();
    assert!(matches!(error, StoreError::OtherProgram { .. }), "{error}");
    assert!(error.to_string().contains("(another)"), "{error}");

    fs::write(&path, &bytes).unwrap();
    let mut fresh = Journal::open(folder.path(), HASH, None, true).unwrap();
    assert_eq!(ids(&mut fresh), [0; 0]);
}

#[test]
fn one_run_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let journal = open(folder.path());
    for fresh in [false, true] {
        let error = Journal::open(folder.path(), HASH, None, fresh).unwrap_err();
        assert!(matches!(error, StoreError::Busy { .. }), "{error}");
    }
    let shard = Some(Shard { index: 1, count: 2 });
    drop(Journal::open(folder.path(), HASH, shard, false).unwrap());
    journal.remove().unwrap();
    assert!(!journal_path(folder.path(), None).exists());
    drop(open(folder.path()));
}

#[test]
fn only_an_empty_journal_is_abandoned() {
    let folder = tempfile::tempdir().unwrap();
    let path = journal_path(folder.path(), None);
    open(folder.path()).abandon();
    assert!(!path.exists());
    let mut journal = open(folder.path());
    journal.append(&row(0, &[1.0])).unwrap();
    journal.abandon();
    assert!(path.exists());
    // A journal with points stays, even if they were not read yet.
    open(folder.path()).abandon();
    assert_eq!(ids(&mut open(folder.path())), [0]);
}

/// A journal lists the instructions of its points, and those of the process that continues it if they differ.
#[test]
fn a_journal_knows_the_instructions_of_its_points() {
    let folder = tempfile::tempdir().unwrap();
    let path = journal_path(folder.path(), None);
    let header = Header {
        job_hash: HASH.into(),
        shard: None,
        program: ProgramRecord::current(),
        instructions: "another".into(),
    };
    let mut bytes = MAGIC.to_vec();
    bytes.extend(record(&header, &path).unwrap());
    fs::write(&path, &bytes).unwrap();
    let here = instructions().to_owned();
    assert_eq!(
        open(folder.path()).instructions(),
        std::slice::from_ref(&here),
        "no point yet"
    );
    bytes.extend(record(&row(0, &[1.0]), &path).unwrap());
    fs::write(&path, &bytes).unwrap();
    let both = ["another".to_owned(), here.clone()];
    assert_eq!(open(folder.path()).instructions(), both);
    // A journal that starts anew lists only the instruction set of this process.
    drop(Journal::open(folder.path(), HASH, None, true).unwrap());
    open(folder.path()).append(&row(0, &[1.0])).unwrap();
    assert_eq!(open(folder.path()).instructions(), [here]);
}

/// Points that were finished in any order are returned once, in the order of their numbers; the journal continues after
/// them.
#[test]
fn points_come_back_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut journal = open(folder.path());
    for point_id in [5, 1, 9, 1, 3] {
        journal.append(&row(point_id, &[point_id as f64])).unwrap();
    }
    let ordered = |journal: &mut Journal| {
        let mut rows = Vec::new();
        let keep = |row| {
            rows.push(row);
            Ok(())
        };
        journal.in_order(keep).unwrap();
        rows
    };
    let rows = ordered(&mut journal);
    let numbers: Vec<u64> = rows.iter().map(|row| row.point_id).collect();
    assert_eq!(numbers, [1, 3, 5, 9]);
    assert_eq!(bits(&rows[2]), bits(&row(5, &[5.0])));
    journal.append(&row(2, &[2.0])).unwrap();
    assert_eq!(ordered(&mut journal).len(), 5);
    assert_eq!(ids(&mut journal), [5, 1, 9, 1, 3, 2]);
}
