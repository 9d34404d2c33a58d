//! Pictures of made-up results with few and with many points: texts are complete and do not overlap, and keys agree
//! with the drawing.

use super::canvas::{Canvas, INK, Shape};
use super::picture::Drawn;
use super::*;
use crate::analysis::{
    AttractorOutcome, BasinShare, ChaosOutcome, Class, EvidenceOutcome, LyapunovMethod,
    LyapunovOutcome, MultistabilityOutcome, PoincareSample, PointOutcome, SampleKind, Spectrum,
    SpectrumLine, SpectrumMethod, Status,
};
use crate::store::{AxisColumn, Placement, PointRow, ResultLayout, ResultWriter, TableKind};

/// Numbers of points of a slice.
const SIZES: [usize; 4] = [1, 12, 80, 1000];

/// A point of every kind, in turn, without an exponent where it failed.
fn outcome(id: u64, section: SampleKind) -> PointOutcome {
    let class = match id % 16 {
        0 => Some(Class::SteadyContact(Some(1))),
        1 => Some(Class::QuasiPeriodic),
        2 => Some(Class::Chaotic),
        3 => Some(Class::NotConverged),
        4 => None,
        5 => Some(Class::TransientChaos),
        period => Some(Class::Periodic(period as u32 - 5)),
    };
    let status = if class.is_none() { Status::Diverged } else { Status::Ok };
    let wave = (0.37 * id as f64).sin();
    let lyapunov = class.as_ref().map(|class| LyapunovOutcome {
        exponents: vec![if class.is_chaos() { 0.5 + 0.3 * wave } else { -0.5 + 0.4 * wave }],
        errors: vec![if class.is_chaos() { 0.02 } else { 0.0 }],
        dimension: None,
        twin: None,
        twin_stderr: None,
        twin_agrees: None,
        method: LyapunovMethod::Tangent,
        convergence: None,
    });
    let sample = |cycle: u64| PoincareSample {
        cycle,
        phase: 0.3 + 0.01 * cycle as f64,
        deflection: 1e-5 * (1.0 + 0.1 * cycle as f64),
        velocity: 0.02 * wave + 1e-3 * cycle as f64,
        kind: section,
    };
    let line = |order: u32| SpectrumLine {
        frequency: 100.0 * f64::from(order),
        order: f64::from(order) / 2.0,
        amplitude: 3e-6 * 10f64.powi(-(order as i32) / 3),
        stderr: None,
    };
    let spectrum = |signal: &str| Spectrum {
        signal: signal.into(),
        unit: "m".into(),
        method: SpectrumMethod::Fourier,
        bandwidth: None,
        lines: (0..30).map(line).collect(),
    };
    let is_chaos = class.is_some_and(|class| class.is_chaos());
    let is_transient = class == Some(Class::TransientChaos);
    PointOutcome {
        status,
        reason: "for a test".into(),
        class,
        lyapunov,
        evidence: is_chaos.then(|| EvidenceOutcome {
            trajectories: 8,
            verified: !is_transient,
            ..EvidenceOutcome::default()
        }),
        chaos: is_chaos.then(|| ChaosOutcome {
            cycles: 20_000,
            exits: if is_transient { 3 } else { 0 },
            trajectories: 8,
            ..ChaosOutcome::default()
        }),
        spectra: match id {
            0 => ["deflection", "force"].map(spectrum).to_vec(),
            _ => Vec::new(),
        },
        poincare: (0..3).map(sample).collect(),
        ..PointOutcome::without_results(Status::Ok, String::new())
    }
}

fn attractor(class: Class, share: f64) -> AttractorOutcome {
    AttractorOutcome {
        class,
        lambda: None,
        chaos_lifetime_low: None,
        lambda_stderr: None,
        deflection_rms: Some(1e-5 + 2e-5 * share),
        force_peak: Some(1e4),
        events_per_cycle: Some(2.0),
        probes: 8,
        basin: BasinShare {
            share,
            low: 0.8 * share,
            high: share + 0.1,
        },
        cells: None,
        strobe: Vec::new(),
    }
}

/// Results over `counts` loads and speeds.
fn written(counts: [usize; 2], section: SampleKind) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let axis = |name: &str, unit: &str| AxisColumn {
        name: name.into(),
        unit: unit.into(),
    };
    let layout = ResultLayout {
        requested: vec![
            TableKind::Poincare,
            TableKind::Spectra,
            TableKind::Probes,
            TableKind::Attractors,
        ],
        axes: vec![axis("load", "1"), axis("speed", "rad/s")],
        ..ResultLayout::default()
    };
    let all = (counts[0] * counts[1]) as u64;
    let mut writer = ResultWriter::create(folder.path(), &layout, 0..all).unwrap();
    for point_id in 0..all {
        let [row, column] = [point_id / counts[1] as u64, point_id % counts[1] as u64];
        let kinds = [
            Class::SteadyContact(Some(1)),
            Class::QuasiPeriodic,
            Class::Chaotic,
        ];
        let turning = kinds[(point_id / 4 % 3) as usize];
        writer
            .push(PointRow {
                point_id,
                axis_values: vec![0.05 + 0.01 * row as f64, 172.9 + 11.387 * column as f64],
                outcome: outcome(point_id, section),
                multistability: Some(MultistabilityOutcome {
                    attractors: vec![attractor(turning, 0.7), attractor(Class::Periodic(2), 0.3)],
                    probes: Vec::new(),
                    cells: Vec::new(),
                }),
                orbits: None,
                chain: None,
                horizon: None,
                covariant: None,
                mesh: None,
                kernel: "volterra".into(),
                placement: Placement {
                    worker: 0,
                    numa_node: None,
                    wall_time: 0.01,
                },
            })
            .unwrap();
    }
    writer.finish().unwrap();
    folder
}

fn drawn(folder: &Path, what: &[PictureKind], over: Option<&str>) -> Drawn {
    let request = PlotRequest {
        what: what
            .iter()
            .map(|what| PictureRequest::Kind(*what))
            .collect(),
        over: over.map(str::to_owned),
        ..PlotRequest::default()
    };
    plot(&[folder.to_path_buf()], &request).unwrap()
}

fn one(folder: &Path, what: PictureKind) -> Canvas {
    let mut drawn = drawn(folder, &[what], None);
    assert_eq!(drawn.pictures.len(), 1);
    drawn.pictures.remove(0).canvas
}

#[test]
fn nothing_written_is_cut_off_or_covered_whatever_the_number_of_points() {
    for section in [SampleKind::Strobe, SampleKind::Entry, SampleKind::Maximum] {
        for columns in SIZES {
            for rows in [1, 3] {
                let folder = written([rows, columns], section);
                for over in [None, Some("speed")]
                    .into_iter()
                    .take(if columns > 1 { 2 } else { 1 })
                {
                    for picture in drawn(folder.path(), &[], over).pictures {
                        let faults = picture.canvas.faults();
                        let name = &picture.name;
                        assert!(faults.is_empty(), "{name}, {rows} x {columns}: {faults:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn an_error_bar_is_explained_only_where_there_is_one() {
    let folder = written([1, 12], SampleKind::Strobe);
    let canvas = one(folder.path(), PictureKind::Lambda);
    assert!(canvas.texts().any(|text| text == "± standard error"));
    // The third of three points is chaotic and has an error. The first two have none.
    let calm = written([3, 1], SampleKind::Strobe);
    let pictures = drawn(calm.path(), &[PictureKind::Lambda], None).pictures;
    let texts: Vec<&str> = pictures[0].canvas.texts().collect();
    assert!(texts.contains(&"± standard error"), "{texts:?}");
    let calm = written([2, 1], SampleKind::Strobe);
    let pictures = drawn(calm.path(), &[PictureKind::Lambda], None).pictures;
    let texts: Vec<&str> = pictures[0].canvas.texts().collect();
    assert!(
        !texts.iter().any(|text| text.contains("standard error")),
        "{texts:?}"
    );
    assert!(texts.contains(&"λ = 0"), "{texts:?}");
}

#[test]
fn a_point_that_failed_looks_as_in_the_key() {
    let folder = written([1, 12], SampleKind::Strobe);
    let canvas = one(folder.path(), PictureKind::Lambda);
    let texts: Vec<&str> = canvas.texts().collect();
    assert!(texts.contains(&"at the edge: no λ (1)"), "{texts:?}");
    // The cross of ink, once on the lower edge and once in the key.
    let strokes = canvas.shapes.iter().filter(|shape| match shape {
        Shape::Line {
            points,
            colour,
            width,
        } => {
            let [from, to] = [points[0], points[points.len() - 1]];
            let [wide, high] = [0, 1].map(|i| (from[i] - to[i]).abs());
            let diagonal = (wide - high).abs() < 1e-6;
            *colour == INK && *width == 1.2 && diagonal && points.len() == 2
        }
        _ => false,
    });
    assert_eq!(strokes.count(), 4);
}

#[test]
fn a_thousand_kinds_of_motion_leave_their_colours_to_be_seen() {
    let folder = written([1, 1000], SampleKind::Strobe);
    let canvas = one(folder.path(), PictureKind::Classes);
    let wide = |from: [f64; 2], to: [f64; 2]| (to[0] - from[0]) * (to[1] - from[1]);
    let (mut edges, mut inner) = (0.0, 0.0);
    for shape in &canvas.shapes {
        if let Shape::Rectangle { from, to, colour } = shape {
            if *colour == canvas::SOFT {
                edges += wide(*from, *to)
            } else {
                inner += wide(*from, *to)
            }
        }
    }
    assert!(inner > 0.5 * edges, "{inner} of {edges}");
}

#[test]
fn narrow_maps_say_that_letters_are_missing_and_have_round_ticks() {
    let folder = written([3, 80], SampleKind::Strobe);
    let canvas = one(folder.path(), PictureKind::Classes);
    let texts: Vec<&str> = canvas.texts().collect();
    // Two digits do not fit into eight pixels; one does.
    assert!(texts.contains(&"q") && texts.contains(&"400"), "{texts:?}");
    assert!(
        texts.iter().any(|text| text.contains("cells without")),
        "{texts:?}"
    );
    assert!(!texts.contains(&"172.9"), "{texts:?}");
    let folder = written([3, 4], SampleKind::Strobe);
    let texts: Vec<String> = one(folder.path(), PictureKind::Classes)
        .texts()
        .map(str::to_owned)
        .collect();
    assert!(texts.contains(&"172.9".to_owned()), "{texts:?}");
    assert!(
        !texts.iter().any(|text| text.contains("cells without")),
        "{texts:?}"
    );
}

#[test]
fn shares_stand_at_their_points() {
    let folder = written([1, 12], SampleKind::Strobe);
    let canvas = one(folder.path(), PictureKind::Shares);
    let mut places: Vec<f64> = (canvas.shapes.iter())
        .filter_map(|shape| match shape {
            Shape::Disc { centre, colour, .. } if *colour == INK && centre[0] < 690.0 => {
                Some(centre[0])
            }
            Shape::Polygon { points, colour } if *colour == INK && points[0][0] < 690.0 => {
                let [low, high] = axis::range(points.iter().map(|at| at[0]));
                Some(0.5 * (low + high))
            }
            _ => None,
        })
        .collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    assert_eq!(places.len(), 12, "{places:?}");
}

#[test]
fn peaks_of_a_spectrum_have_orders_and_the_unit_of_their_axis() {
    let folder = written([1, 1], SampleKind::Strobe);
    let canvas = one(folder.path(), PictureKind::Spectrum);
    let texts: Vec<&str> = canvas.texts().collect();
    assert!(
        texts.iter().any(|text| text.starts_with("order ")),
        "{texts:?}"
    );
    assert!(texts.contains(&"deflection amplitude [µm]"), "{texts:?}");
    assert!(!texts.iter().any(|text| text.ends_with(" nm")), "{texts:?}");
}

#[test]
fn samples_of_an_entry_section_are_over_the_mesh_phase() {
    let folder = written([1, 1], SampleKind::Entry);
    let canvas = one(folder.path(), PictureKind::Phase);
    let texts: Vec<&str> = canvas.texts().collect();
    assert!(
        texts.contains(&"mesh phase [–]") && texts.contains(&"3 samples"),
        "{texts:?}"
    );
    assert!(
        !texts.iter().any(|text| text.starts_with("deflection")),
        "{texts:?}"
    );
}

/// Lines that go up to the right by 45 degrees.
fn hatching(canvas: &Canvas) -> Vec<[[f64; 2]; 2]> {
    let lines = canvas.shapes.iter().filter_map(|shape| match shape {
        Shape::Line { points, .. } if points.len() == 2 => Some([points[0], points[1]]),
        _ => None,
    });
    let slanted = |[from, to]: &[[f64; 2]; 2]| {
        let [across, up] = [to[0] - from[0], from[1] - to[1]];
        across > 0.0 && (across - up).abs() < 1e-9
    };
    lines.filter(slanted).collect()
}

#[test]
fn transient_chaos_is_hatched_and_errors_that_are_not_verified_have_a_dot() {
    // Among the twelve points, point 2 is chaotic. Point 5, in the second row and column, is transient chaos.
    let folder = written([3, 4], SampleKind::Strobe);
    let picture = drawn(folder.path(), &[PictureKind::Lambda], None)
        .pictures
        .remove(0);
    let canvas = &picture.canvas;
    let texts: Vec<&str> = canvas.texts().collect();
    for wanted in ["transient chaos (1)", "error not verified (1)"] {
        assert!(texts.contains(&wanted), "{wanted}: {texts:?}");
    }
    let subtitle = "errors of 1 point not verified";
    assert!(
        texts.iter().any(|text| text.contains(subtitle)),
        "{texts:?}"
    );
    let [cell, key]: [Vec<_>; 2] = {
        let (cell, key) = hatching(canvas)
            .into_iter()
            .partition(|[at, _]| at[0] < 740.0);
        [cell, key]
    };
    assert!(cell.len() > 20 && !key.is_empty());
    let inside = |[x, y]: [f64; 2]| (252.0..414.0).contains(&x) && (223.0..375.0).contains(&y);
    assert!(cell.iter().flatten().all(|at| inside(*at)), "{cell:?}");
    // The dot lies on a disc in the colour of the cell, so that hatching does not touch the dot.
    let is_dot = |shape: &&Shape| matches!(shape, Shape::Disc { centre, .. } if inside(*centre));
    assert_eq!(canvas.shapes.iter().filter(is_dot).count(), 2);
    // The SVG file contains all lines of the hatching.
    let source = picture.svg().unwrap();
    let document = roxmltree::Document::parse(&source).unwrap();
    let lines = document
        .descendants()
        .filter(|node| node.has_tag_name("polyline"));
    assert!(lines.count() >= cell.len() + key.len());
}

#[test]
fn the_map_of_classes_has_transient_chaos_hatched_with_its_letter() {
    let folder = written([3, 4], SampleKind::Strobe);
    let canvas = one(folder.path(), PictureKind::Classes);
    let texts: Vec<&str> = canvas.texts().collect();
    assert_eq!(
        texts.iter().filter(|text| **text == "t").count(),
        2,
        "{texts:?}"
    );
    assert!(texts.contains(&"transient chaos (1)"), "{texts:?}");
    assert!(hatching(&canvas).len() > 20);
    // A map of classes has no marks for errors that are not verified.
    assert!(
        !texts.iter().any(|text| text.contains("verified")),
        "{texts:?}"
    );
}

#[test]
fn maps_without_transient_chaos_have_no_lines_over_cells() {
    let folder = written([2, 2], SampleKind::Strobe);
    for what in [PictureKind::Lambda, PictureKind::Classes] {
        let canvas = one(folder.path(), what);
        assert_eq!(hatching(&canvas).len(), 0, "{what:?}");
    }
}
