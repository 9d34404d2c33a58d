//! Static equilibrium of drives with several load paths: compared with every combination of closed contacts, solved in
//! full modal coordinates; a power split and a planetary stage, whose loads follow from symmetry.
// Helpers outside the test functions may also unwrap.
#![allow(clippy::unwrap_used)]

use crate::common;
use common::constant_mesh;
use gearatlas::analysis::Frequencies;
use gearatlas::manifest;
use gearatlas::model::{Drive, InitialState, Model, ModelError, NoStaticState, OperatingPoint};
use gearatlas::structure::{ContactLaw, Coupling, ModalStructure, StructureContact};
use std::f64::consts::TAU;
use std::path::Path;

/// Random numbers from −1 to 1 (splitmix64).
struct Draw(u64);

impl Draw {
    fn any(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
    }

    /// A random number between two positive numbers, uniform in the logarithm.
    fn from(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(0.5 * (self.any() + 1.0))
    }

    fn list(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.any()).collect()
    }
}

/// One side of a mesh, or a stop: it pushes if `Σ w q` exceeds its gap.
#[derive(Clone)]
struct Side {
    deflection: Vec<f64>,
    force: Vec<f64>,
    gap: f64,
    stiffness: f64,
}

/// A contact of a structure.
fn contact(side: &Side) -> StructureContact {
    let mut series = [0.0; 8];
    series[0] = side.stiffness;
    StructureContact {
        name: "path".to_owned(),
        participation: side.deflection.clone(),
        force: side.force.clone(),
        tilt: Vec::new(),
        rubbing: Default::default(),
        sliding: 0.0,
        cycles: [1, 1],
        law: ContactLaw {
            gap: side.gap,
            stiffness: vec![(1.0, series)],
            damping: 50.0,
            ..ContactLaw::default()
        },
        copies: None,
    }
}

fn reversed(values: &[f64]) -> Vec<f64> {
    values.iter().map(|w| -w).collect()
}

/// Both sides of a mesh.
fn mesh(deflection: &[f64], force: &[f64], gap: f64, stiffness: f64) -> [Side; 2] {
    let side = |deflection: Vec<f64>, force: Vec<f64>| Side {
        deflection,
        force,
        gap,
        stiffness,
    };
    [
        side(deflection.to_vec(), force.to_vec()),
        side(reversed(deflection), reversed(force)),
    ]
}

/// A drive with one load path per mesh, and its parts.
struct Paths {
    structure: ModalStructure,
    drive: Drive,
    sides: Vec<Side>,
    load: Vec<f64>,
}

const POINT: OperatingPoint = OperatingPoint {
    load: 1.0,
    speed: 100.0,
};

impl Paths {
    /// Some meshes, then a stop, over one to three rigid motions and some elastic ones; `rubbing` is the fraction of
    /// forces across the deflections.
    fn drawn(paths: usize, rubbing: f64, draw: &mut Draw) -> Self {
        let rigid = 1 + (1.5 * (draw.any() + 1.0)) as usize;
        let elastic = 3 + (1.9 * (draw.any() + 1.0)) as usize;
        let n = rigid + elastic;
        let mut frequency: Vec<f64> = (0..n)
            .map(|i| if i < rigid { 0.0 } else { draw.from(500.0, 3e4) })
            .collect();
        frequency.sort_by(f64::total_cmp);
        let mut sides = Vec::new();
        for path in 0..paths {
            let w = draw.list(n);
            let g: Vec<f64> = match path {
                0 => w.clone(),
                _ => w.iter().map(|w| w + rubbing * draw.any()).collect(),
            };
            let (gap, stiffness) = (draw.from(1e-6, 1e-4), draw.from(1e7, 1e9));
            sides.extend(mesh(&w, &g, gap, stiffness));
        }
        let stop = draw.list(n);
        sides.push(Side {
            force: stop.clone(),
            deflection: stop,
            gap: draw.from(1e-6, 1e-4),
            stiffness: draw.from(1e7, 1e9),
        });
        let size = draw.from(10.0, 1e4);
        let load: Vec<f64> = draw.list(n).iter().map(|f| size * f).collect();
        Self::of(&frequency, sides, load)
    }

    fn of(frequency: &[f64], sides: Vec<Side>, load: Vec<f64>) -> Self {
        let mut structure = ModalStructure::of_modes(frequency, 0.01, &sides[0].deflection, &load);
        structure.contacts = sides[2..].iter().map(contact).collect();
        Self {
            structure,
            drive: constant_mesh(sides[0].gap, sides[0].stiffness),
            sides,
            load,
        }
    }

    fn model(&self) -> Result<Model, ModelError> {
        Model::new(&self.structure, &self.drive, POINT)
    }

    /// Forces of all equilibria, by trying every combination of closed contacts in modal coordinates.
    fn equilibria(&self) -> Vec<Vec<f64>> {
        let n = self.load.len();
        let count = self.sides.len();
        let possible = |set: &u32| (0..count / 2).all(|mesh| set >> (2 * mesh) & 3 != 3);
        let mut found = Vec::new();
        for set in (0..1_u32 << count).filter(possible) {
            let closed = |i: usize| set >> i & 1 == 1;
            let mut rows: Vec<Vec<f64>> = (0..n)
                .map(|i| {
                    let mut row = vec![0.0; n + 1];
                    row[i] = self.structure.frequency[i].powi(2);
                    row[n] = self.load[i];
                    row
                })
                .collect();
            for side in (0..count).filter(|&i| closed(i)).map(|i| &self.sides[i]) {
                for (row, g) in rows.iter_mut().zip(&side.force) {
                    for (entry, w) in row.iter_mut().zip(&side.deflection) {
                        *entry += side.stiffness * g * w;
                    }
                    row[n] += side.stiffness * g * side.gap;
                }
            }
            let Some(q) = solved(rows) else { continue };
            let stretches: Vec<f64> = (self.sides.iter())
                .map(|side| {
                    let along = side.deflection.iter().zip(&q);
                    along.map(|(w, q)| w * q).sum::<f64>() - side.gap
                })
                .collect();
            if (0..count).all(|i| closed(i) == (stretches[i] > 0.0)) {
                let force = |i: usize| self.sides[i].stiffness * stretches[i].max(0.0);
                found.push((0..count).map(force).collect());
            }
        }
        found
    }
}

/// Gauss elimination with row pivots; `None` for a singular matrix.
fn solved(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    let size = |row: &[f64]| row[..n].iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    let largest = rows.iter().map(|row| size(row)).fold(0.0, f64::max);
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))?;
        rows.swap(k, pivot);
        if rows[k][k].abs() <= 1e-11 * largest {
            return None;
        }
        let own = rows[k].clone();
        for row in &mut rows[k + 1..] {
            let factor = row[k] / own[k];
            for (a, b) in row.iter_mut().zip(&own) {
                *a -= factor * b;
            }
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| rows[k][j] * x[j]).sum();
        x[k] = (rows[k][n] - known) / rows[k][k];
    }
    Some(x)
}

/// Forces of the contacts at the start, pushes positive. Asserts that nothing pulls, nothing moves on its contacts, and
/// every mode is in balance: to 1e-8 of the largest term of forces and of the underlying stretches.
fn forces_at_rest(model: &Model) -> Vec<f64> {
    let start = model.start(&InitialState::Static);
    let segments = model.segments_at(0, 0.0);
    let n = model.modes();
    let mut rate = vec![0.0; 2 * n];
    model.derivative(&segments, start.contact, 0, 0.0, &start.state, &mut rate);
    let mut largest = (model.load_on_modes().iter()).fold(0.0_f64, |most, f| most.max(f.abs()));
    let forces: Vec<f64> = (model.contacts.iter().zip(&segments).enumerate())
        .map(|(i, (contact, segment))| {
            let (deflection, speed) = model.deflection_on(segment, 0, &start.state, 0.0);
            let push = contact.side * contact.force(segment, 0.0, deflection, speed);
            let closed = start.contact.holds(i);
            assert!(
                (push > 0.0) == closed,
                "contact {i}: {push} N, closed {closed}"
            );
            if closed { push } else { 0.0 }
        })
        .collect();
    largest = forces.iter().fold(largest, |most, f| most.max(*f));
    for contact in start.contact.iter() {
        let segment = &segments[contact];
        let terms = (model.gains(segment).iter().zip(&start.state))
            .map(|(gain, q)| (gain.deflection[0] * q).abs());
        largest = largest.max(segment.stiffness_at(0.0) * terms.sum::<f64>());
    }
    for acceleration in &rate[n..] {
        assert!(acceleration.abs() < 1e-8 * largest, "{rate:?} of {largest}");
    }
    forces
}

/// Whether the set and the forces of contacts are those of one equilibrium.
fn agrees(model: &Model, equilibria: &[Vec<f64>]) -> bool {
    let forces = forces_at_rest(model);
    let bearing: Vec<usize> = model.bearing_contacts().iter().collect();
    let largest = forces.iter().fold(0.0_f64, |most, f| most.max(*f));
    equilibria.iter().any(|exact| {
        let pushing: Vec<usize> = (0..exact.len()).filter(|&i| exact[i] > 0.0).collect();
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-6 * largest;
        pushing == bearing && forces.iter().zip(exact).all(near)
    })
}

#[test]
fn parallel_paths_share_the_load_as_no_other_combination_does() {
    let mut draw = Draw(1);
    let mut bearing = [0; 12];
    for paths in [3, 4, 5] {
        for number in 0..150 {
            let drawn = Paths::drawn(paths, 0.0, &mut draw);
            let exact = drawn.equilibria();
            assert_eq!(exact.len(), 1, "{paths} {number}: the energy is convex");
            let model = drawn.model().unwrap();
            assert!(agrees(&model, &exact), "{paths} {number}: {exact:?}");
            bearing[model.bearing_contacts().count()] += 1;
        }
    }
    println!("cases by contacts that bear: {bearing:?}");
    assert!(bearing[1..5].iter().all(|cases| *cases > 10), "{bearing:?}");
}

/// With friction an equilibrium is found if there is one; otherwise an error is reported.
#[test]
fn friction_is_in_balance_or_refused() {
    let mut draw = Draw(2);
    let (mut found, mut refused) = (0, 0);
    for (paths, rubbing, cases) in [(3, 0.02, 60), (4, 0.02, 60), (5, 0.02, 60), (3, 1.5, 200)] {
        for number in 0..cases {
            let drawn = Paths::drawn(paths, rubbing, &mut draw);
            let exact = drawn.equilibria();
            match drawn.model() {
                Ok(model) => {
                    // Under strong friction others may be within rounding of these; balance and signs are checked
                    // nevertheless.
                    let same = agrees(&model, &exact);
                    assert!(same || rubbing > 1.0, "{paths} {number}: {exact:?}");
                    found += 1;
                }
                Err(ModelError::NoEquilibrium(NoStaticState { friction, .. })) => {
                    assert!(exact.is_empty(), "{paths} {rubbing} {number}: {exact:?}");
                    assert!(friction > 0.0 && friction <= 1.0, "{friction}");
                    refused += 1;
                }
                Err(other) => panic!("{paths} {number}: {other}"),
            }
        }
    }
    println!("{found} found, {refused} have none");
    assert!(found > 300 && refused > 5);
}

/// A rotating sun, three planets and a ring, by symmetry with six flanks of 250 N; its modes by hand.
#[test]
fn planets_share_the_load_of_sun_and_ring() {
    let (sun, planet, ring) = (0.6, 0.4, 2.5);
    let masses = [sun, planet, planet, planet, ring];
    let [of_sun, of_ring] = [4e8, 3e8];
    let along = |from: usize, to: usize| -> Vec<f64> {
        let mut w = vec![0.0; 5];
        w[from] = 1.0 / f64::sqrt(masses[from]);
        w[to] = -1.0 / f64::sqrt(masses[to]);
        w
    };
    let paths = (1..4).flat_map(|own| [(along(0, own), of_sun), (along(own, 4), of_ring)]);
    let sides = paths.flat_map(|(w, stiffness)| mesh(&w, &w, 60e-6, stiffness));
    for force in [-2000.0, -250.0, 1.0, 250.0, 2000.0] {
        let load = along(0, 4).iter().map(|w| 3.0 * force * w).collect();
        let model = (Paths::of(&[0.0; 5], sides.clone().collect(), load).model()).unwrap();
        for pair in forces_at_rest(&model).chunks_exact(2) {
            let pushed = [force.max(0.0), (-force).max(0.0)];
            for (found, exact) in pair.iter().zip(pushed) {
                assert!(
                    (found - exact).abs() < 1e-9 * force.abs(),
                    "{found} {exact}"
                );
            }
        }
        // Two modes of planets against each other, and those of a chain of three masses.
        let apart = ((of_sun + of_ring) / planet).sqrt();
        let [a, b] = [3.0 * of_sun, 3.0 * of_ring];
        let planets = 3.0 * planet;
        let trace = a / sun + (a + b) / planets + b / ring;
        let minors = a * b * (sun + planets + ring) / (sun * planets * ring);
        let root = (0.25 * trace * trace - minors).sqrt();
        let mut exact = [
            0.0,
            (0.5 * trace - root).sqrt(),
            (0.5 * trace + root).sqrt(),
            apart,
            apart,
        ];
        exact.sort_by(f64::total_cmp);
        let modes = Frequencies::of(&model);
        assert_eq!(modes.contacts.count(), 6);
        for (own, exact) in modes.closed.iter().zip(exact) {
            let found = own.mode.frequency;
            assert!(
                (found - exact).abs() < 1e-9 * apart,
                "{} {}",
                found / TAU,
                exact / TAU
            );
        }
    }
}

/// Three equal lay shafts between an input and an output gear.
fn split(load: f64) -> Model {
    let gear = |name: &str, teeth: u32| {
        format!(
            "gears = [{{ name = \"{name}\", at = \"10 mm\", teeth = {teeth}, module = \"2.5 mm\", width = \"20 mm\", \
             thinning = \"50 um\" }}]\n"
        )
    };
    let shaft = |name: &str, origin: String, rest: String| {
        format!(
            "[[train.shaft]]\nname = \"{name}\"\nmotion = \"rotation\"\norigin = {origin}\n{rest}"
        )
    };
    let disc =
        |inertia: &str| format!("discs = [{{ at = 0, polar_inertia = \"{inertia} kg*m^2\" }}]\n");
    let mut text = String::from(
        "[job]\nname = \"split\"\n[model]\nkind = \"train\"\n[train]\ngears = [\"in\", \"w0\"]\nrated_torque = \"100 N*m\"\n",
    );
    text += &shaft(
        "input",
        "[0, 0, 0]".to_owned(),
        disc("5e-3") + &gear("in", 20),
    );
    let output = disc("5e-2") + &gear("out", 40) + "output = 1\n";
    text += &shaft("output", "[0, 0, \"100 mm\"]".to_owned(), output);
    let mesh = |gears: String| {
        format!(
            "[[train.mesh]]\ngears = [{gears}]\nstiffness = \"4e8 N/m\"\ndamping = \"800 N*s/m\"\n"
        )
    };
    for path in 0..3 {
        let (sin, cos) = (TAU * f64::from(path) / 3.0).sin_cos();
        let origin = |z: f64| {
            format!(
                "[\"{:.9} mm\", \"{:.9} mm\", \"{z} mm\"]",
                75.0 * cos,
                75.0 * sin
            )
        };
        text += &shaft(
            &format!("front{path}"),
            origin(0.0),
            gear(&format!("w{path}"), 40),
        );
        text += &shaft(
            &format!("back{path}"),
            origin(100.0),
            gear(&format!("p{path}"), 20),
        );
        text += &format!(
            "[[train.coupling]]\nshafts = [\"front{path}\", \"back{path}\"]\nat = [\"10 mm\", \"-90 mm\"]\n\
             twist = \"5e4 N*m/rad\"\ndamping = \"0.5 N*m*s/rad\"\n"
        );
        if path > 0 {
            text += &mesh(format!("\"in\", \"w{path}\""));
        }
        text += &mesh(format!("\"p{path}\", \"out\""));
    }
    text += "[mesh]\nstiffness = \"constant\"\nmean_stiffness = \"4e8 N/m\"\ncontact_damping = \"800 N*s/m\"\n";
    text += &format!("[grid]\nload = {load}\nspeed = \"3000 rpm\"\n");
    let job = manifest::parse(&text, "split.toml", Path::new(""));
    let job = job.unwrap_or_else(|errors| panic!("{errors}"));
    common::parts().model(&job.points.at(0)).unwrap()
}

/// Each of three equal paths carries a third: the forces on each gear's two flanks have the ratio of its base radii.
#[test]
fn a_power_split_is_even_at_every_load() {
    let base_radius = 0.5 * 20.0 * 2.5e-3 * 20.0_f64.to_radians().cos();
    for load in [0.01, 0.1, 0.5, 1.0, 3.0] {
        let model = split(load);
        assert_eq!(Frequencies::of(&model).contacts.count(), 6, "{load}");
        let first = load * 100.0 / base_radius / 3.0;
        let mut forces = forces_at_rest(&model);
        forces.sort_by(f64::total_cmp);
        let pushing = &forces[forces.len() - 6..];
        // The force on the pinions of half the radius is twice as large.
        for (found, exact) in pushing.iter().zip([1.0, 1.0, 1.0, 2.0, 2.0, 2.0]) {
            assert!((found / first - exact).abs() < 1e-9, "{load}: {forces:?}");
        }
    }
}

/// A rotation with drag that does not move the mesh. Its drag has no static displacement.
#[test]
fn a_rotation_with_drag_beside_the_mesh_leaves_the_equilibrium_finite() {
    let mut structure = ModalStructure::of_modes(&[0.0, 900.0], 0.01, &[0.0, 0.5], &[0.1, 0.5]);
    structure.friction = vec![0.3, 0.0];
    structure.coupling = Some(Coupling {
        damping: vec![1.0, 0.0, 0.0, 0.0],
        gyroscopic: vec![0.0; 4],
        stiffness: vec![0.0; 4],
    });
    let drive = Drive {
        friction: 0.1,
        ..constant_mesh(1e-5, 1e8)
    };
    let model = Model::new(&structure, &drive, POINT).unwrap();
    let state = model.start(&InitialState::Static).state;
    assert!(state.iter().all(|x| x.is_finite()), "{state:?}");
}
