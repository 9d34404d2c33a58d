//! Do the checks detect a wrong kernel? They must detect a relative error of 10⁻⁹ in one coefficient.

use super::candidate::Candidate;
use super::*;
use crate::model::{Model, Stiffness, TrajectoryState};
use crate::propagate::{
    ClosedModes, Counters, InstructionSet, Kernel, Observer, Stop, Tangents, Volterra,
};

/// Names of the checks that every kernel must pass and that are quick enough for a test.
const OF_KERNELS: [&str; 5] = ["multipliers", "cycle", "contact", "energy", "trace"];

/// The kernel `volterra` of a deliberately changed model.
fn tampered(tamper: fn(&mut Model)) -> Candidate {
    Candidate::new("tampered", move |model| {
        let mut other = model.clone();
        tamper(&mut other);
        // A test leaks a few models here.
        Box::new(Volterra::new(Box::leak(Box::new(other)), f64::EPSILON, 100))
    })
}

fn subjects(kernel: Candidate) -> Subjects {
    let mut cases = drives::cases().unwrap();
    cases.truncate(3);
    Subjects {
        extent: Extent::Quick,
        kernels: vec![kernel],
        cases,
        grid: Vec::new(),
    }
}

fn ladder(kernel: Candidate) -> Report {
    let chosen = CHECKS
        .iter()
        .filter(|check| OF_KERNELS.contains(&check.name));
    let chosen: Vec<Check> = chosen.copied().collect();
    assert_eq!(chosen.len(), OF_KERNELS.len());
    run(&subjects(kernel), &chosen, &mut |_| ())
}

/// Checks with a line that fails.
fn failing(report: &Report) -> Vec<&'static str> {
    let fails = |finding: &&Finding| finding.lines.iter().any(Line::breaks_bound);
    report
        .findings
        .iter()
        .filter(fails)
        .map(|f| f.check)
        .collect()
}

const PART: f64 = 1.0 + 1e-9;

#[test]
fn a_sound_kernel_passes() {
    let report = ladder(tampered(|_| ()));
    assert_eq!(failing(&report), [""; 0], "{report}");
    assert_eq!(report.status(), 0);
    assert!(!report.to_string().contains("FAIL"));
}

/// The check of energy does not detect a wrong stiffness: the energy balance of the changed drive closes as well.
#[test]
fn a_stiffness_off_by_a_part_in_a_billion_fails() {
    let report = ladder(tampered(|model| {
        for contact in &mut model.contacts {
            let segment = &mut contact.cycles[0].segments[0];
            segment.stiffness = Stiffness::constant(PART * segment.stiffness.mean());
        }
    }));
    assert_eq!(
        failing(&report),
        ["multipliers", "cycle", "contact"],
        "{report}"
    );
    assert_eq!(report.status(), 1);
    assert!(report.to_string().contains("  FAIL  cycle"));
}

#[test]
fn so_does_every_other_coefficient() {
    let tampers: [fn(&mut Model); 5] = [
        |model| {
            for contact in &mut model.contacts {
                let segments = contact.cycles[0].segments.iter_mut();
                segments.for_each(|s| s.damping *= PART);
            }
        },
        |model| model.contacts.iter_mut().for_each(|c| c.half_gap *= PART),
        |model| model.lines[0].transmission_error[0].amplitude *= PART,
        |model| model.blocks.last_mut().unwrap().static_input[1] *= PART,
        |model| model.directions[0].gains.last_mut().unwrap().mesh_input[1] *= PART,
    ];
    for (number, tamper) in tampers.into_iter().enumerate() {
        let report = ladder(tampered(tamper));
        assert!(failing(&report).contains(&"cycle"), "{number}: {report}");
        assert_eq!(report.status(), 1, "{number}");
    }
}

/// A kernel with tables for another half gap fails as well. Models that it does not support are reported as
/// skipped.
#[test]
fn a_wrong_table_fails_and_a_drive_left_out_is_said() {
    let wrong = |part: f64| {
        Candidate::of_tables("closed_modes", move |model| {
            let mut other = model.clone();
            for contact in &mut other.contacts {
                contact.half_gap *= part;
            }
            let other = Box::leak(Box::new(other));
            Ok(Box::new(ClosedModes::new(
                other,
                100,
                InstructionSet::best(),
            )?))
        })
    };
    let with_computed_mesh = |kernel: Candidate| {
        let mut subjects = subjects(kernel);
        let computed = drives::cases().unwrap().remove(5);
        subjects.cases.insert(0, computed);
        let cycle = CHECKS.iter().filter(|check| check.name == "cycle");
        run(&subjects, &cycle.copied().collect::<Vec<_>>(), &mut |_| ())
    };
    let valid = with_computed_mesh(wrong(1.0));
    assert_eq!((valid.status(), valid.skips()), (0, 1), "{valid}");
    let text = valid.to_string();
    assert!(text.contains("  skip  cycle"), "{text}");
    assert!(text.contains("fail, 1 skipped"), "{text}");
    let report = with_computed_mesh(wrong(PART));
    assert_eq!((report.status(), report.skips()), (1, 1), "{report}");
    assert_eq!(failing(&report), ["cycle"], "{report}");
}

/// A report with only skipped lines proves nothing.
#[test]
fn a_report_of_skips_alone_does_not_pass() {
    let report = Report {
        extent: Extent::Quick,
        seconds: 0.0,
        findings: vec![Finding {
            check: "cycle",
            group: Group::Kernels,
            seconds: 0.0,
            lines: vec![Line::skipped("closed_modes", "no table")],
        }],
    };
    assert_eq!((report.failures(), report.status()), (0, 1));
}

/// A kernel that finds every event but reports none.
struct Silent<'m>(Volterra<'m>);

impl Kernel for Silent<'_> {
    type Workspace = <Volterra<'static> as Kernel>::Workspace;

    fn workspace(&self) -> Self::Workspace {
        self.0.workspace()
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Self::Workspace,
        _: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        (self.0).advance_cycle(trajectory, tangents, workspace, &mut (), counters)
    }
}

#[test]
fn events_that_are_not_told_fail() {
    let silent = Candidate::new("silent", |model| {
        Box::new(Silent(Volterra::new(model, f64::EPSILON, 100)))
    });
    let report = ladder(silent);
    let failing = failing(&report);
    assert!(
        failing.contains(&"cycle") && failing.contains(&"energy"),
        "{report}"
    );
}

/// If a kernel stops, its check fails with the reason. The other checks continue.
#[test]
fn a_kernel_that_gives_up_is_a_line() {
    let impatient = Candidate::new("impatient", |model| {
        Box::new(Volterra::new(model, f64::EPSILON, 0))
    });
    let report = ladder(impatient);
    assert_eq!(report.findings.len(), OF_KERNELS.len());
    let line = report.lines().find(|line| line.value.is_nan()).unwrap();
    assert!(line.what.contains("more than 0 events"), "{}", line.what);
    assert_eq!(report.status(), 1);
}

#[test]
fn checks_have_names_of_their_own_and_groups_are_together() {
    for (place, check) in CHECKS.iter().enumerate() {
        assert!(CHECKS[..place].iter().all(|other| other.name != check.name));
    }
    let mut groups: Vec<Group> = CHECKS.iter().map(|check| check.group).collect();
    groups.dedup();
    let mut reported = Vec::new();
    for group in groups {
        assert!(!reported.contains(&group), "{group:?} is split");
        reported.push(group);
    }
}

/// An empty report proves nothing.
#[test]
fn an_empty_report_does_not_pass() {
    let report = run(&subjects(tampered(|_| ())), &[], &mut |_| ());
    assert_eq!(report.status(), 1);
}

#[test]
fn the_text_is_aligned() {
    let report = Report {
        extent: Extent::Quick,
        seconds: 1.25,
        findings: vec![
            Finding {
                check: "alpha",
                group: Group::ClosedForms,
                seconds: 0.5,
                lines: vec![
                    Line::at_most("short", "a closed form", 3e-15, 1e-13, "relative"),
                    Line::at_most("rather longer", "x", 2e-3, 1e-13, "half gaps"),
                ],
            },
            Finding {
                check: "be",
                group: Group::Fidelity,
                seconds: 0.5,
                lines: vec![
                    Line::between("order", "reference", 2.0, [1.9, 2.1], "1"),
                    Line::failed(&CheckError::Missing {
                        what: "a drive that turns and turns",
                    }),
                ],
            },
        ],
    };
    insta::assert_snapshot!(report.to_string(), @r"
    Exactness: closed forms
      pass  alpha  short          a closed form  3e-15  <= 1e-13    relative
      FAIL  alpha  rather longer  x               2e-3  <= 1e-13    half gaps

    Fidelity: approximate on purpose, physical tolerances
      pass  be     order          reference          2  1.9 .. 2.1  1
      FAIL  be     not carried out: a drive that turns and turns is missing                   NaN  <= 0

    2 of 4 lines pass, 2 fail (quick, 1.2 s)
    ");
}
