//! Housings: a beam as a housing compared with the same beam as a shaft, energy and torques of a shipped train, and
//! refusals.

use crate::common;
use crate::trains::off_extended;
use common::advance::{Events, advance_with, volterra};
use gearatlas::analysis::EnergyAudit;
use gearatlas::manifest::{self, Job};
use gearatlas::model::{InitialState, Model, Quantity};
use gearatlas::verify::drives::disturbed;
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// A separate folder for the files of a test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("housing-{test}"));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn job(text: &str, folder: &Path) -> Job {
    manifest::parse(text, "test.toml", folder).unwrap_or_else(|errors| panic!("{errors}"))
}

fn model(text: &str, folder: &Path) -> Model {
    common::parts()
        .model(&job(text, folder).points.at(0))
        .unwrap()
}

/// Direction of all axes, and their frame: the smallest rotation from z to this direction, by Rodrigues' formula.
const ALONG: [f64; 3] = [0.48, -0.6, 0.64];

fn frame() -> Matrix3<f64> {
    let along = Vector3::from(ALONG);
    let across = Vector3::z().cross(&along).cross_matrix();
    Matrix3::identity() + across + across * across / (1.0 + along.z)
}

/// The point in space with these coordinates in the frame of [`ALONG`].
fn place(local: [f64; 3]) -> [f64; 3] {
    (frame() * Vector3::from(local)).into()
}

/// Young's modulus, shear modulus, density, shear coefficient: the defaults of a train.
const STEEL: [f64; 4] = [206e9, 79e9, 7850.0, 0.9];

/// Diameter of the beam, and its stations \[m\].
const OUTER: f64 = 0.03;
const STATIONS: [f64; 4] = [0.0, 0.04, 0.08, 0.12];

/// Stiffness and damping of the bearings at both ends of the beam, by degree of freedom.
const GROUND: [f64; 6] = [6e7, 4e7, 3e7, 9e3, 9e3, 0.0];
const DAMPING: [f64; 2] = [300.0, 200.0];

/// Mass and stiffness of a Timoshenko beam in one plane over (w, slope) at both ends, from its shape functions by
/// quadrature.
fn plane(length: f64) -> [DMatrix<f64>; 2] {
    let [young, shear, density, kappa] = STEEL;
    let (area, moment) = (PI * OUTER.powi(2) / 4.0, PI * OUTER.powi(4) / 64.0);
    let phi = 12.0 * young * moment / (kappa * shear * area * length * length);
    let [mut mass, mut stiffness] = [0, 1].map(|_| DMatrix::zeros(4, 4));
    let (outer, inner) = (0.8611363115940526, 0.33998104358485626);
    let (light, heavy) = (0.34785484513745385, 0.6521451548625461);
    for (node, weight) in [
        (-outer, light),
        (-inner, heavy),
        (inner, heavy),
        (outer, light),
    ] {
        let (s, weight): (f64, f64) = (0.5 * (1.0 + node), 0.5 * weight * length);
        let w = [
            1.0 - 3.0 * s * s + 2.0 * s.powi(3) + phi * (1.0 - s),
            length * (s - 2.0 * s * s + s.powi(3) + 0.5 * phi * (s - s * s)),
            3.0 * s * s - 2.0 * s.powi(3) + phi * s,
            length * (s.powi(3) - s * s + 0.5 * phi * (s * s - s)),
        ];
        let slope = [
            6.0 * (s * s - s) / length,
            1.0 - 4.0 * s + 3.0 * s * s + phi * (1.0 - s),
            6.0 * (s - s * s) / length,
            3.0 * s * s - 2.0 * s + phi * s,
        ];
        let bend = [
            6.0 * (2.0 * s - 1.0) / (length * length),
            (6.0 * s - 4.0 - phi) / length,
            6.0 * (1.0 - 2.0 * s) / (length * length),
            (6.0 * s - 2.0 + phi) / length,
        ];
        // The shear angle: w' minus the slope, which is constant.
        let sheared = [-phi / length, -0.5 * phi, phi / length, -0.5 * phi];
        let norm = weight / (1.0 + phi).powi(2);
        for i in 0..4 {
            for j in 0..4 {
                mass[(i, j)] +=
                    norm * density * (area * w[i] * w[j] + moment * slope[i] * slope[j]);
                stiffness[(i, j)] += norm
                    * (young * moment * bend[i] * bend[j]
                        + kappa * shear * area * sheared[i] * sheared[j]);
            }
        }
    }
    [mass, stiffness]
}

/// Mass, stiffness and damping of the beam on its bearings in its frame, six freedoms per station, with the rotation at
/// the first one fixed.
fn beam() -> [DMatrix<f64>; 3] {
    let size = 6 * STATIONS.len();
    let [mut mass, mut stiffness, mut damping] = [0, 1, 2].map(|_| DMatrix::zeros(size, size));
    let [young, shear, density, _] = STEEL;
    let (area, polar) = (PI * OUTER.powi(2) / 4.0, PI * OUTER.powi(4) / 32.0);
    for (element, ends) in STATIONS.windows(2).enumerate() {
        let (length, start) = (ends[1] - ends[0], 6 * element);
        let [planar_mass, planar_stiffness] = plane(length);
        for ways in [
            [(0, 1.0), (4, 1.0), (6, 1.0), (10, 1.0)],
            [(1, 1.0), (3, -1.0), (7, 1.0), (9, -1.0)],
        ] {
            for (i, (row, one)) in ways.into_iter().enumerate() {
                for (j, (column, two)) in ways.into_iter().enumerate() {
                    let at = (start + row, start + column);
                    mass[at] += one * two * planar_mass[(i, j)];
                    stiffness[at] += one * two * planar_stiffness[(i, j)];
                }
            }
        }
        for (freedom, inertia, spring) in [
            (2, density * area, young * area),
            (5, density * polar, shear * polar),
        ] {
            for (i, j, m, k) in [
                (0, 0, 2.0, 1.0),
                (0, 6, 1.0, -1.0),
                (6, 0, 1.0, -1.0),
                (6, 6, 2.0, 1.0),
            ] {
                let at = (start + freedom + i, start + freedom + j);
                mass[at] += inertia * length / 6.0 * m;
                stiffness[at] += spring / length * k;
            }
        }
    }
    for end in [0, size - 6] {
        for (freedom, spring) in GROUND.into_iter().enumerate() {
            stiffness[(end + freedom, end + freedom)] += spring;
        }
        for (freedom, damper) in DAMPING.into_iter().enumerate() {
            damping[(end + freedom, end + freedom)] += damper;
        }
    }
    [mass, stiffness, damping].map(|matrix| matrix.remove_row(5).remove_column(5))
}

fn rows(matrix: &DMatrix<f64>) -> String {
    let row = |i: usize| {
        let entries: Vec<String> = matrix.row(i).iter().map(|v| format!("{v:e}")).collect();
        format!("[{}]", entries.join(", "))
    };
    let rows: Vec<String> = (0..matrix.nrows()).map(row).collect();
    format!("[{}]", rows.join(",\n"))
}

/// The beam as a housing file: the station of the gear is a node along the axes of space, all others are internal.
fn beam_file() -> String {
    let size = 6 * STATIONS.len() - 1;
    // Put the degrees of freedom of the node first: the second station has 5 to 10 of the 23.
    let order: Vec<usize> = (5..11).chain(0..5).chain(11..size).collect();
    let turn = frame().transpose();
    let mut change = DMatrix::zeros(size, size);
    for (to, &from) in order.iter().enumerate() {
        if to >= 6 {
            change[(from, to)] = 1.0;
            continue;
        }
        for axis in 0..3 {
            change[(from, to / 3 * 3 + axis)] = turn[(to % 3, axis)];
        }
    }
    let [mass, stiffness, damping] = beam().map(|matrix| {
        let turned = change.transpose() * matrix * &change;
        0.5 * (&turned + turned.transpose())
    });
    let internal: Vec<String> = (0..size - 6).map(|i| format!("\"q{i}\"")).collect();
    // The points are the displacements along x and y of the last station.
    let point = |name: &str, local: usize| {
        let at = order.iter().position(|&from| from == local).unwrap();
        let row: Vec<f64> = (0..size).map(|i| f64::from(u8::from(i == at))).collect();
        format!("[[point]]\nname = \"{name}\"\nrow = {row:?}\n")
    };
    format!(
        "mass = {}\nstiffness = {}\ndamping = {}\ninternal = [{}]\n[[node]]\nname = \"middle\"\nposition = {:?}\n{}{}",
        rows(&mass),
        rows(&stiffness),
        rows(&damping),
        internal.join(", "),
        place([0.075, 0.0, 0.04]),
        point("end x", size - 6),
        point("end y", size - 5),
    )
}

/// A driving gear on a flexible shaft, an idler on the beam, a driven gear. `carried` describes idler and beam.
fn chain(modes: usize, carried: &str) -> String {
    let gear = |name: &str, at: f64, teeth: u32| {
        format!("{{ name = \"{name}\", at = {at}, teeth = {teeth}, module = 3e-3, width = 0.02 }}")
    };
    format!(
        "[job]\nname = \"beam\"\n[model]\nkind = \"train\"\nmodes = {modes}\ndamping = 0.01\n\
         [train]\ngears = [\"first\", \"idler\"]\nrated_torque = 60\n\
         [[train.shaft]]\nname = \"input\"\ndirection = {ALONG:?}\nsections = [{{ length = 0.09, outer = 0.025 }}]\n\
         element = 0.06\ndiscs = [{{ at = 0, polar_inertia = 2e-3 }}]\ngears = [{}]\n\
         bearings = [{{ at = 0, x = 1.1e8, y = 9e7, axial = 5e7, tilt = 1e4 }}, {{ at = 0.09, x = 1e8, y = 8e7 }}]\n\
         {carried}\n\
         [[train.shaft]]\nname = \"output\"\norigin = {:?}\ndirection = {ALONG:?}\nmotion = \"rotation\"\noutput = 1\n\
         gears = [{}]\ndiscs = [{{ at = 0, polar_inertia = 4e-2 }}]\n\
         [[train.mesh]]\ngears = [\"idler\", \"last\"]\nstiffness = 3e8\ndamping = 700\nhalf_gap = 3e-5\n\
         [mesh]\nstiffness = \"piecewise\"\nmean_stiffness = 3e8\ncontact_ratio = 1.6\nsingle_pair_drop = 0.3\n\
         contact_damping = \"500 N*s/m\"\nhalf_gap = 3e-5\n\
         [excitation]\ntransmission_error = [{{ harmonic = 1, amplitude = 1.2e-5 }}]\n\
         [grid]\nload = 0.1\nspeed = 500\n[run]\ntransient = 0\ncycles = 10\n",
        gear("first", 0.04, 20),
        place([0.09, 0.104, 0.0]),
        gear("last", 0.04, 40),
    )
}

const IDLER: &str = "teeth = 30, module = 3e-3, width = 0.02, body = { polar_inertia = 9e-4, transverse_inertia = 6e-4, \
                     mass = 0.8 }";
const ON_BEAM: &str = "x = 1.3e8, y = 1.2e8, axial = 6e7, tilt = 2e4";

fn drawn(modes: usize) -> String {
    let [x, y, axial, tilt, ..] = GROUND;
    let end = |at: f64| {
        format!(
            "{{ at = {at}, x = {x}, y = {y}, axial = {axial}, tilt = {tilt}, damping_x = {}, damping_y = {} }}",
            DAMPING[0], DAMPING[1]
        )
    };
    let beam = format!(
        "[[train.shaft]]\nname = \"beam\"\norigin = {:?}\ndirection = {ALONG:?}\nmotion = \"lateral\"\nelement = 0.04\n\
         sections = [{{ length = 0.12, outer = {OUTER} }}]\nbearings = [{}, {}]\n\
         gears = [{{ name = \"idler\", at = 0.04, {IDLER}, loose = {{ {ON_BEAM} }} }}]",
        place([0.075, 0.0, 0.0]),
        end(0.0),
        end(0.12),
    );
    chain(modes, &beam)
}

fn housed(modes: usize) -> String {
    let pin = format!(
        "[[train.shaft]]\nname = \"pin\"\norigin = {:?}\ndirection = {ALONG:?}\n\
         bearings = [{{ at = 0, {ON_BEAM}, housing = \"middle\" }}]\n\
         gears = [{{ name = \"idler\", at = 0, {IDLER} }}]",
        place([0.075, 0.0, 0.04]),
    );
    chain(modes, &pin) + "[train.housing]\nfile = \"beam.toml\"\n"
}

/// Values of outputs with both names at two states, and the largest of them.
fn compared(pairs: &[(f64, f64)]) -> f64 {
    let largest = pairs
        .iter()
        .fold(0.0_f64, |most, (one, _)| most.max(one.abs()));
    let off = pairs
        .iter()
        .fold(0.0_f64, |most, (one, two)| most.max((one - two).abs()));
    assert!(largest > 0.0);
    off / largest
}

/// An output at a state, in which the first components of all blocks precede the second ones.
fn sum(gain: &[[f64; 2]], state: &[f64]) -> f64 {
    let (first, second) = state.split_at(gain.len());
    let blocks = gain.iter().zip(first.iter().zip(second));
    blocks.map(|(gain, (x, y))| gain[0] * x + gain[1] * y).sum()
}

/// Modes, rattle and harmonic response of a beam are the same for a drawing and for a file.
#[test]
fn a_beam_as_a_housing_is_the_beam_as_a_shaft() {
    let folder = folder("beam");
    std::fs::write(folder.join("beam.toml"), beam_file()).unwrap();
    for modes in [48, 30] {
        let [one, two] = [drawn(modes), housed(modes)].map(|text| {
            let job = job(&text, &folder);
            let point = job.points.at(0);
            let structure = gearatlas::sweep::build::structure(&point.model).unwrap();
            (structure, common::parts().model(&point).unwrap())
        });
        let frequencies = one.0.frequency.iter().zip(&two.0.frequency);
        let off = (frequencies.filter(|(a, _)| **a > 0.0))
            .map(|(a, b)| (a / b - 1.0).abs())
            .fold(0.0, f64::max);
        // Rigid rotations with an effect on the meshes may be rotated among themselves, but the products of their
        // participations are the same for both meshes.
        let felt = [&one.0, &two.0].map(|own| {
            let rigid = own.rigid_modes();
            let columns = [&own.mesh, &own.contacts[0].participation];
            let product = |a: usize, b: usize| -> f64 {
                let pairs = columns[a].iter().zip(columns[b]).take(rigid);
                pairs.map(|(a, b)| a * b).sum()
            };
            let products = [product(0, 0), product(0, 1), product(1, 1)];
            let elastic = columns.map(|column| column[rigid..].to_vec());
            [products.to_vec(), elastic[0].clone(), elastic[1].clone()]
        });
        let felt: Vec<f64> = felt[0]
            .iter()
            .zip(&felt[1])
            .map(|(a, b)| compared(&a.iter().copied().zip(b.iter().copied()).collect::<Vec<_>>()))
            .collect();
        println!("{modes} modes: frequencies {off:e}, participations {felt:?}");
        assert!(off < 1e-9, "{off:e}");
        assert!(felt.iter().all(|off| *off < 1e-9), "{felt:?}");

        let runs = [&one.1, &two.1].map(|model| {
            let mut seen = Events::default();
            let start = model.start(&InitialState::Static);
            let (end, _) = advance_with(&volterra(model), &start, 12, &mut seen);
            (seen.0, end.state)
        });
        let [(first, end), (second, other)] = &runs;
        assert_eq!(first.len(), second.len());
        assert!(first.len() > 20, "{}", first.len());
        let late = first.iter().zip(second);
        let late = late
            .map(|(a, b)| (a.time - b.time).abs())
            .fold(0.0, f64::max)
            / one.1.period();
        let force = |model: &Model, name: &str, state: &[f64]| {
            let bearing = model.bearings.iter().find(|own| own.name == name);
            sum(&bearing.unwrap().gain, state)
        };
        let velocity = |model: &Model, name: &str, state: &[f64]| {
            let places = model
                .outputs
                .iter()
                .filter(|own| own.quantity == Quantity::Acceleration);
            let output = places.clone().find(|own| own.name == name);
            let names: Vec<_> = places.map(|own| &own.name).collect();
            sum(
                &output.unwrap_or_else(|| panic!("{name}: {names:?}")).gain,
                state,
            )
        };
        let forces: Vec<_> = [
            ("idler x", "pin 1 x"),
            ("idler y", "pin 1 y"),
            ("input 1 x", "input 1 x"),
            ("input 2 y", "input 2 y"),
        ]
        .iter()
        .map(|(a, b)| (force(&one.1, a, end), force(&two.1, b, other)))
        .collect();
        let velocities: Vec<_> = [
            ("beam 2 x", "housing end x"),
            ("beam 2 y", "housing end y"),
            ("idler x", "pin 1 x"),
            ("idler base y", "pin 1 base y"),
        ]
        .iter()
        .map(|(a, b)| (velocity(&one.1, a, end), velocity(&two.1, b, other)))
        .collect();
        let off = [compared(&forces), compared(&velocities), late];
        println!("{} events: forces, velocities, times {off:?}", first.len());
        assert!(off.into_iter().fold(0.0, f64::max) < 1e-9, "{off:?}");
    }
}

fn shipped() -> (String, PathBuf) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/trains");
    (
        std::fs::read_to_string(folder.join("housing.toml")).unwrap(),
        folder,
    )
}

#[test]
fn a_shipped_housing_is_exact_and_keeps_its_energy() {
    let (text, folder) = shipped();
    let model = model(&text, &folder);
    let start = disturbed(&model);
    let ([worst, late], [seen, exact]) = off_extended(&model, &start);
    println!("states {worst:.1e}, times {late:.1e} of a cycle, {seen} events");
    assert_eq!(seen, exact);
    assert!(worst < 1e-12 && late < 1e-13, "{worst:e} {late:e}");
    let mut audit = EnergyAudit::new(&model);
    let (end, _) = advance_with(&volterra(&model), &start, 30, &mut audit);
    let residual = audit.residual(&end).unwrap();
    println!("energy {residual:.1e}");
    assert!(residual < 1e-12, "{residual:e}");
}

/// Two nodes with one freedom each, three freedoms in all, and a manifest with this housing.
const SMALL: &str = "mass = [[1, 0, 0], [0, 2, 0], [0, 0, 1]]\n\
                     stiffness = [[3e8, -1e8, 0], [-1e8, 3e8, 0], [0, 0, 1e8]]\ninternal = [\"mode 1\"]\n\
                     [[node]]\nname = \"left\"\nposition = [0, 0, 0]\nfreedoms = [\"x\"]\n\
                     [[node]]\nname = \"right\"\nposition = [0, 0, 0.09]\nfreedoms = [\"x\"]\n\
                     [[point]]\nname = \"cover\"\nfreedom = \"left x\"\n";

fn on_small() -> String {
    drawn(20)
        .replace(&format!("direction = {ALONG:?}\n"), "")
        .replacen(
            "axial = 5e7, tilt = 1e4",
            "axial = 5e7, tilt = 1e4, housing = \"left\"",
            1,
        )
        .replacen(
            &format!("{:?}", place([0.075, 0.0, 0.0])),
            "[0.075, 0, 0]",
            1,
        )
        .replacen(
            &format!("{:?}", place([0.09, 0.104, 0.0])),
            "[0.09, 0.104, 0]",
            1,
        )
        + "[train.housing]\nfile = \"small.toml\"\n"
}

#[test]
fn housings_that_do_not_fit_are_refused() {
    let folder = folder("refused");
    let file = folder.join("small.toml");
    let answer = |text: &str, housing: &str| {
        std::fs::write(&file, housing).unwrap();
        match manifest::parse(text, "test.toml", &folder) {
            Ok(job) => match gearatlas::sweep::build::structure(&job.points.at(0).model) {
                Ok(_) => "none".to_owned(),
                Err(error) => error.to_string(),
            },
            Err(errors) => errors.to_string(),
        }
    };
    let text = on_small();
    assert_eq!(answer(&text, SMALL), "none");
    // The hash of a job depends on the content of the file.
    let before = job(&text, &folder).hash;
    std::fs::write(&file, SMALL.replacen("[0, 2, 0]", "[0, 3, 0]", 1)).unwrap();
    assert_ne!(job(&text, &folder).hash, before);
    let in_file = |from: &str, to: &str| {
        assert!(SMALL.contains(from), "{from}");
        answer(&text, &SMALL.replacen(from, to, 1))
    };
    let in_text = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        answer(&text.replacen(from, to, 1), SMALL)
    };
    let cases = [
        (in_text("\"left\"", "\"lift\""), "no node `lift`"),
        (
            in_text(", housing = \"left\"", ""),
            "no bearing stands on the housing",
        ),
        (
            in_text("\n[train.housing]\nfile = \"small.toml\"", ""),
            "the train has no housing",
        ),
        (in_text("small.toml", "absent.toml"), "cannot be read"),
        (
            in_text(
                "name = \"input\"",
                "name = \"input\"\nmotion = \"rotation\"",
            ),
            "mounts the shaft rigidly",
        ),
        (
            in_file("[0, 0, 0]\nfree", "[0, 0.004, 0]\nfree"),
            "is 4.000000e-3 m from node `left`",
        ),
        (
            in_file("[-1e8, 3e8, 0]", "[-2e8, 3e8, 0]"),
            "row 2, column 1 (`right x`, `left x`)",
        ),
        (in_file("[0, 2, 0]", "[0, -2, 0]"), "freedom `right x`"),
        (in_file("[[3e8,", "[[3e6,"), "no eigenvalue may be negative"),
        (
            in_file("[0, 0, 1e8]]", "[0, 0, 0]]"),
            "free to move as a rigid body",
        ),
        (
            in_file("[0, 2, 0]", "[0, 2]"),
            "row 2 of `mass` has 2 entries, but",
        ),
        (in_file("[\"mode 1\"]", "[]"), "`mass` has 3 rows, but"),
        (in_file("[0, 2, 0]", "[0, nan, 0]"), "not a finite number"),
        (in_file("\"right\"", "\"left\""), "have the name `left`"),
        (
            in_file("\"left x\"", "\"left y\""),
            "is not the displacement of a node",
        ),
        (in_file("[\"x\"]", "[\"y\", \"x\"]"), "in this order"),
        (in_file("internal =", "internat ="), "internat"),
        (
            answer(&text, &format!("{SMALL}{}", "#".repeat(17 << 20))),
            "cannot be read",
        ),
    ];
    for (said, wanted) in cases {
        assert!(said.contains(wanted), "{wanted}: {said}");
    }
    // For faults in the file the message names file and line.
    let said = in_file("[-1e8, 3e8, 0]", "[-2e8, 3e8, 0]");
    assert!(said.contains("small.toml:2"), "{said}");
    let many: Vec<String> = (0..401).map(|i| format!("\"m{i}\"")).collect();
    let said = in_file("[\"mode 1\"]", &format!("[{}]", many.join(", ")));
    assert!(said.contains("403 freedoms, but 1 to 400"), "{said}");
    let planets = include_str!("../../manifests/trains/planetary.toml");
    let first = "bearings = [{";
    assert!(planets.contains(first));
    let planets = planets.replacen(first, "bearings = [{ housing = \"left\",", 1)
        + "\n[train.housing]\nfile = \"small.toml\"\n";
    let said = answer(&planets, SMALL);
    assert!(
        said.contains("`annulus` cannot stand on the housing") && said.contains("hold the carrier"),
        "{said}"
    );
}
