//! Profiles and leads through points, compared with the built-in reliefs and crownings.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common;
use gearatlas::gear::{
    FlankCourse, Flanks, GearError, GearPair, MeshTable, MeshTableInputs, Modification, Relief,
    ToothForm,
};
use gearatlas::manifest;
use gearatlas::numerics::point_course::{BetweenPoints, PointCourse};
use std::path::Path;

fn pair(form: ToothForm) -> GearPair {
    GearPair {
        form: ToothForm {
            bore: [Some(48e-3), Some(76e-3)],
            ..form
        },
        ..common::default_drive::gears()
    }
}

fn course(points: Vec<[f64; 2]>, between: BetweenPoints) -> PointCourse {
    PointCourse { points, between }
}

fn table(form: ToothForm, slices: usize) -> MeshTable {
    let pair = pair(form);
    let mut inputs = MeshTableInputs::of_gears(&pair);
    inputs.slices = slices;
    MeshTable::build(&Flanks::new(&pair).unwrap(), &inputs, &|_, _| ()).unwrap()
}

/// Largest relative differences over the cycle of the stiffness, and of the loaded transmission error.
fn apart(one: &MeshTable, other: &MeshTable) -> [f64; 2] {
    let (one, other) = (one.cycle(0, 0), other.cycle(0, 0));
    let mut worst = [0.0_f64; 2];
    for phase in (0..997).map(|i| (f64::from(i) + 0.5) / 997.0) {
        let values = [
            [(&one, &one.stiffness), (&other, &other.stiffness)],
            [
                (&one, &one.transmission_error),
                (&other, &other.transmission_error),
            ],
        ];
        for (worst, both) in worst.iter_mut().zip(values) {
            let [a, b] = both.map(|(cycle, values)| cycle.value(values, phase));
            *worst = worst.max((a / b - 1.0).abs());
        }
    }
    worst
}

/// Ends of the active profile of a gear \[m\]: roll lengths at its lowest point and at its tip.
fn active(gear: usize) -> [f64; 2] {
    let flanks = Flanks::new(&pair(ToothForm::default())).unwrap();
    let path = flanks.path();
    let mut ends = [path.start, path.end].map(|s| flanks.roll_length(gear, s));
    ends.sort_by(f64::total_cmp);
    ends
}

/// A linear tip relief of both gears and the same relief through three points give the same table, including kinks.
#[test]
fn linear_relief_through_points_is_the_built_in_one() {
    let relief = Relief {
        amount: 8e-6,
        length: 2.5e-3,
        ..Relief::default()
    };
    let built_in = table(
        ToothForm {
            tip_relief: [relief; 2],
            ..ToothForm::default()
        },
        1,
    );
    let points = [0, 1].map(|gear| {
        let [from, to] = active(gear);
        course(
            vec![[from, 0.0], [to - 2.5e-3, 0.0], [to, 8e-6]],
            BetweenPoints::Linear,
        )
    });
    let own = table(
        ToothForm {
            profile_points: points,
            ..ToothForm::default()
        },
        1,
    );
    let [stiffness, error] = apart(&built_in, &own);
    let off = stiffness.max(error);
    println!(
        "linear relief: {off:.1e}, {} and {} pieces",
        built_in.breaks.len(),
        own.breaks.len()
    );
    assert!(off < 1e-8, "{off:e}");
}

/// Crowning of profile and lead through n points tends to the built-in one with the square of their distance; cubics
/// are closer.
#[test]
fn crowning_through_points_converges() {
    let amount = 4e-6;
    let crowned = Modification {
        crowning: amount,
        slope: 0.0,
    };
    let profile = table(
        ToothForm {
            profile: [crowned; 2],
            ..ToothForm::default()
        },
        1,
    );
    let through = |count: u32, between| {
        let points = [0, 1].map(|gear| {
            let [from, to] = active(gear);
            let place = |x: f64| from + 0.5 * (x + 1.0) * (to - from);
            let points = (0..=count).map(|i| 2.0 * f64::from(i) / f64::from(count) - 1.0);
            course(
                points.map(|x| [place(x), amount * x * x]).collect(),
                between,
            )
        });
        let form = ToothForm {
            profile_points: points,
            ..ToothForm::default()
        };
        // The stiffness jumps where a pair comes into contact, at another phase if a point differs elsewhere.
        apart(&profile, &table(form, 1))[1]
    };
    let [coarse, fine] = [8, 32].map(|count| through(count, BetweenPoints::Linear));
    let cubic = through(8, BetweenPoints::Monotone);
    println!(
        "profile crowning: {coarse:.1e} with 9 points, {fine:.1e} with 33; cubics {cubic:.1e} with 9"
    );
    assert!(
        coarse < 0.05 && fine < coarse / 8.0 && cubic < coarse,
        "{coarse:e} {fine:e} {cubic:e}"
    );

    let lead = table(
        ToothForm {
            lead: [crowned; 2],
            ..ToothForm::default()
        },
        16,
    );
    let places = (0..=16).map(|i| f64::from(i) / 8.0 - 1.0);
    let points: Vec<[f64; 2]> = places.map(|x| [10e-3 * x, amount * x * x]).collect();
    let own = table(
        ToothForm {
            lead_points: [0, 1].map(|_| course(points.clone(), BetweenPoints::Linear)),
            ..ToothForm::default()
        },
        16,
    );
    // The borders of the slices are the points.
    let [stiffness, error] = apart(&lead, &own);
    let off = stiffness.max(error);
    println!("lead crowning on the borders of 16 slices: {off:.1e}");
    assert!(off < 1e-8, "{off:e}");
}

#[test]
fn bad_courses_are_refused() {
    let refused = |form: ToothForm| Flanks::new(&pair(form)).unwrap_err();
    let profile = |points: Vec<[f64; 2]>| ToothForm {
        profile_points: [
            course(points, BetweenPoints::Linear),
            PointCourse::default(),
        ],
        ..ToothForm::default()
    };
    let [from, to] = active(0);
    let on = |error| {
        matches!(
            error,
            GearError::OnePoint {
                course: FlankCourse::Profile,
                gear: 1
            }
        )
    };
    assert!(on(refused(profile(vec![[to, 0.0]]))));
    let order = refused(profile(vec![[to, 0.0], [from, 0.0]]));
    assert!(
        matches!(
            order,
            GearError::PointOrder {
                point: 2,
                gear: 1,
                ..
            }
        ),
        "{order}"
    );
    let off = refused(profile(vec![[from, 0.0], [to + 1e-3, 0.0]]));
    assert!(
        matches!(off, GearError::PointOffFlank { gear: 1, .. }),
        "{off}"
    );
    let lead = refused(ToothForm {
        lead_points: [
            PointCourse::default(),
            course(vec![[0.0, 0.0], [11e-3, 0.0]], BetweenPoints::Linear),
        ],
        ..ToothForm::default()
    });
    let lead_off = GearError::PointOffFlank {
        course: FlankCourse::Lead,
        gear: 2,
        place: 11e-3,
        from: -10e-3,
        to: 10e-3,
    };
    assert_eq!(lead, lead_off);
}

const MANIFEST: &str = include_str!("../../manifests/flex80-table.toml");

/// Manifests accept points over both scales, and report faults with their keys.
#[test]
fn manifests_have_courses() {
    let parse = |points: &str| {
        let text = MANIFEST.replace("rated_torque =", &format!("{points}\nrated_torque ="));
        manifest::parse(&text, "m.toml", Path::new("")).map(|job| {
            let source = job.points.at(0).model.source.clone();
            source.gears().unwrap().form.clone()
        })
    };
    let [base, _] = common::default_drive::gears().base_radii();
    let lengths = parse(
        "profile_points = [{ gear = \"pinion\", roll_length = [\"14 mm\", \"18 mm\", \"20 mm\"], missing = [0, 0, \"8 um\"] }]",
    )
    .unwrap();
    assert_eq!(lengths.profile_points[0].points[2], [20e-3, 8e-6]);
    assert!(lengths.profile_points[1].points.is_empty());
    let diameter = |length: f64| 2e3 * (length * length + base * base).sqrt();
    let diameters = parse(&format!(
        "profile_points = [{{ gear = \"pinion\", diameter = [\"{} mm\", \"{} mm\"], missing = [0, \"8 um\"], between = \"monotone\" }}]",
        diameter(14e-3),
        diameter(20e-3)
    ))
    .unwrap();
    let [_, last] = diameters.profile_points[0].points[..] else {
        panic!()
    };
    assert!((last[0] - 20e-3).abs() < 1e-12);
    assert_eq!(diameters.profile_points[0].between, BetweenPoints::Monotone);
    let leads = parse(
        "lead_points = [{ gear = \"wheel\", place = [\"-10 mm\", \"10 mm\"], missing = [\"-2 um\", \"5 um\"] }]",
    )
    .unwrap();
    assert_eq!(
        leads.lead_points[1].points,
        [[-10e-3, -2e-6], [10e-3, 5e-6]]
    );
    for (points, key, said) in [
        (
            "profile_points = [{ gear = \"pinion\", roll_length = [\"14 mm\", \"13 mm\"], missing = [0, 0] }]",
            "roll_length",
            "increase",
        ),
        (
            "profile_points = [{ gear = \"pinion\", roll_length = [\"14 mm\", \"18 mm\"], missing = [0] }]",
            "missing",
            "1 values at 2 positions",
        ),
        (
            "profile_points = [{ gear = \"pinion\", roll_length = [\"14 mm\"], missing = [0] }]",
            "missing",
            "fewer than two",
        ),
        (
            "profile_points = [{ gear = \"pinion\", roll_length = [\"14 mm\", \"28 mm\"], missing = [0, 0] }]",
            "profile_points",
            "but the flank reaches",
        ),
        (
            "profile_points = [{ gear = \"pinion\", roll_length = [\"14 Hz\", \"18 mm\"], missing = [0, 0] }]",
            "roll_length",
            "Hz",
        ),
        (
            "profile_points = [{ gear = \"pinion\", diameter = [\"70 mm\", \"85 mm\"], missing = [0, 0] }]",
            "diameter",
            "base circle",
        ),
        (
            "profile_points = [{ gear = \"pinion\", missing = [0, 0] }]",
            "roll_length",
            "missing",
        ),
        (
            "profile_points = [{ gear = \"gear\", roll_length = [\"14 mm\", \"18 mm\"], missing = [0, 0] }]",
            "gear",
            "pinion",
        ),
        (
            "lead_points = [{ gear = \"wheel\", place = [0, \"12 mm\"], missing = [0, 0] }]",
            "lead_points",
            "but the flank reaches",
        ),
        (
            "lead_points = [{ gear = \"wheel\", place = [0, \"2 mm\"], missing = [0, 0] }, { gear = \"wheel\", place = [0, \"2 mm\"], missing = [0, 0] }]",
            "gear",
            "two curves",
        ),
    ] {
        let error = format!("{:?}", parse(points).unwrap_err());
        assert!(
            error.contains(key) && error.contains(said),
            "{points}: {error}"
        );
    }
}
