//! Planetary sets: published frequencies, an independent assembly, phases, load sharing, balance of torques, and
//! refusals.

use crate::common;
use crate::train_meshes::bearing_means;
use crate::trains::off_extended;
use common::advance::{Events, advance, advance_with, follows_volterra, volterra};
use gearatlas::analysis::{EnergyAudit, Frequencies, Nvh};
use gearatlas::gear::involute;
use gearatlas::manifest::{self, Job};
use gearatlas::model::{InitialState, Model};
use gearatlas::propagate::{ClosedModes, InstructionSet};
use gearatlas::sweep::build;
use gearatlas::verify::drives::disturbed;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::path::Path;

/// A member: mass \[kg\], inertia over the square of its radius \[kg\], radial support \[N/m\].
#[derive(Clone, Copy)]
pub struct Member(pub [f64; 3]);

/// A planetary set of rigid bodies with a ring on a spring.
#[derive(Clone)]
pub struct Set {
    pub planets: usize,
    /// Numbers of teeth of sun, planet and ring.
    pub teeth: [u32; 3],
    /// Distance of the pins from the axis \[m\].
    pub radius: f64,
    /// Operating pressure angle \[degrees\].
    pub pressure_angle: f64,
    pub sun: Member,
    pub ring: Member,
    pub carrier: Member,
    pub planet: Member,
    /// Torsional support of the ring at its base radius \[N/m\].
    pub twist: f64,
    /// Stiffness of all meshes \[N/m\].
    pub stiffness: f64,
    pub gyroscopic: bool,
    /// Speed of the sun \[rad/s\].
    pub speed: f64,
    /// Stiffness levels of the sun's meshes and the ring's over their cycle, instead of the constant one.
    pub levels: bool,
    /// Further keys of the planets.
    pub more: String,
}

impl Set {
    pub fn lin_parker(planets: usize) -> Self {
        Self {
            planets,
            // Five planets touch unless they are small.
            teeth: if planets == 5 { [40, 25, 90] } else { [24, 36, 96] },
            radius: 88.4e-3,
            pressure_angle: 24.6,
            sun: Member([0.4, 0.39, 1e8]),
            ring: Member([2.35, 3.0, 1e8]),
            carrier: Member([5.43, 6.29, 1e8]),
            planet: Member([0.66, 0.61, 1e8]),
            twist: 1e9,
            stiffness: 5e8,
            gyroscopic: false,
            speed: 100.0,
            levels: false,
            more: String::new(),
        }
    }

    fn cooley_parker(planets: usize) -> Self {
        Self {
            radius: 0.1,
            pressure_angle: 20.0,
            sun: Member([3.0, 1.75, 20e6]),
            ring: Member([7.64, 8.09, 100e6]),
            carrier: Member([12.0, 6.8, 50e6]),
            planet: Member([1.86, 1.25, 10e6]),
            twist: 1e8,
            stiffness: 1e8,
            ..Self::lin_parker(planets)
        }
    }

    /// Pressure angle of the rack, module and profile shifts of sun, planet and ring, without backlash.
    fn rack(&self) -> (f64, f64, [f64; 3]) {
        let working = self.pressure_angle.to_radians();
        let rack = self.pressure_angle.min(22.5).to_radians();
        let [sun, planet, ring] = self.teeth.map(f64::from);
        let module = 2.0 * self.radius * working.cos() / rack.cos() / (sun + planet);
        let bent = (involute(working) - involute(rack)) / (2.0 * rack.tan());
        let shift = 0.5 * (sun + planet) * bent;
        // The shifts are slightly smaller, so that round-off gives no interference of the flanks.
        let hair = 1e-9;
        let of_ring = -(ring - planet) * bent - shift;
        (rack, module, [shift - hair, shift, of_ring - hair])
    }

    /// Base radii of sun, planet and ring \[m\].
    pub fn base_radii(&self) -> [f64; 3] {
        let (rack, module, _) = self.rack();
        self.teeth.map(|z| 0.5 * module * f64::from(z) * rack.cos())
    }

    pub fn text(&self) -> String {
        let (rack, module, [of_sun, of_planet, of_ring]) = self.rack();
        let [sun, planet, ring] = self.base_radii();
        let [zs, zp, zr] = self.teeth;
        let degrees = rack.to_degrees();
        let body = |member: Member, radius: f64| {
            let Member([mass, inertia, _]) = member;
            let polar = inertia * radius * radius;
            format!(
                "polar_inertia = {polar:e}, transverse_inertia = {:e}, mass = {mass:e}",
                0.6 * polar
            )
        };
        let held = |member: Member| {
            let stiffness = member.0[2];
            format!(
                "bearings = [{{ at = 0, x = {stiffness:e}, y = {stiffness:e}, axial = 1e7, tilt = 1e4 }}]"
            )
        };
        let law = |key: &str| {
            let k = self.stiffness;
            match (self.levels, key) {
                (false, "mean_stiffness") => {
                    format!("stiffness = \"constant\"\nmean_stiffness = {k:e}")
                }
                (false, _) => format!("stiffness = {k:e}"),
                (true, "mean_stiffness") => format!(
                    "stiffness = \"fourier\"\nmean_stiffness = {k:e}\nstiffness_harmonics = [{}]",
                    harmonics(k)
                ),
                (true, _) => format!(
                    "stiffness = {k:e}\nstiffness_harmonics = [{}]\ncoast_symmetry = 0.3",
                    harmonics(k)
                ),
            }
        };
        format!(
            "[job]\nname = \"set\"\n[model]\nkind = \"train\"\nmodes = {}\ndamping = 0.01\ngyroscopic = {}\n\
             [train]\ngears = [\"sun\", \"planet\"]\nrated_torque = \"100 N*m\"\n\
             [[train.shaft]]\nname = \"input\"\ngears = [{{ name = \"sun\", at = 0, teeth = {zs}, module = {module:e}, \
             width = \"30 mm\", pressure_angle = \"{degrees} deg\", profile_shift = {of_sun:e}, body = {{ {} }} }}]\n{}\n\
             [[train.shaft]]\nname = \"carrier\"\ndiscs = [{{ at = 0, {} }}]\n{}\noutput = 1\n\
             [[train.shaft]]\nname = \"annulus\"\ngears = [{{ name = \"ring\", internal = true, at = 0, teeth = {zr}, \
             module = {module:e}, width = \"30 mm\", pressure_angle = \"{degrees} deg\", profile_shift = {of_ring:e}, \
             body = {{ {} }} }}]\n{}\n\
             [[train.shaft]]\nname = \"housing\"\nmotion = \"none\"\n\
             [[train.coupling]]\nshafts = [\"annulus\", \"housing\"]\nat = [0, 0]\ntwist = {:e}\n\
             [[train.planetary]]\ncarrier = \"carrier\"\ncount = {}\nteeth = {zp}\nmodule = {module:e}\nwidth = \"30 mm\"\n\
             radius = {:e}\npressure_angle = \"{degrees} deg\"\nprofile_shift = {of_planet:e}\nbody = {{ {} }}\n\
             bearing = {{ radial = {:e}, axial = 1e7, tilt = 1e4 }}\n{}\n\
             [[train.mesh]]\ngears = [\"planet\", \"ring\"]\nhalf_gap = \"20 um\"\n{}\ndamping = 300\n\
             [mesh]\nhalf_gap = \"20 um\"\n{}\ncontact_damping = \"300 N*s/m\"\n\
             [grid]\nload = 1\nspeed = {:e}\n[analyses]\nnvh = {{}}\n",
            6 * (3 + self.planets),
            self.gyroscopic,
            body(self.sun, sun),
            held(self.sun),
            body(self.carrier, self.radius),
            held(self.carrier),
            body(self.ring, ring),
            held(self.ring),
            self.twist * ring * ring,
            self.planets,
            self.radius,
            body(self.planet, planet),
            self.planet.0[2],
            self.more,
            law("stiffness"),
            law("mean_stiffness"),
            self.speed,
        )
    }

    pub fn model(&self) -> Model {
        model(&job(&self.text()))
    }
}

fn harmonics(mean: f64) -> String {
    let one = |harmonic: u32, part: f64| {
        format!(
            "{{ harmonic = {harmonic}, amplitude = {:e}, phase = 0.4 }}",
            part * mean
        )
    };
    [one(1, 0.2), one(2, 0.1), one(3, 0.05)].join(", ")
}

pub fn job(text: &str) -> Job {
    manifest::parse(text, "test.toml", Path::new("")).unwrap_or_else(|errors| panic!("{errors}"))
}

pub fn model(job: &Job) -> Model {
    common::parts().model(&job.points.at(0)).unwrap()
}

pub fn refusal(text: &str) -> String {
    manifest::parse(text, "test.toml", Path::new(""))
        .unwrap_err()
        .to_string()
}

/// Frequencies in contact \[Hz\], ascending.
pub fn in_contact(model: &Model) -> Vec<f64> {
    let found = Frequencies::of(model).closed;
    found.iter().map(|own| own.mode.frequency / TAU).collect()
}

#[derive(serde::Deserialize)]
struct Published {
    planets: usize,
    #[serde(default)]
    simple: Vec<f64>,
    double: Vec<f64>,
    planet: Vec<f64>,
}

#[derive(serde::Deserialize)]
struct AllPublished {
    lin_parker: Vec<Published>,
    cooley_parker: Vec<Published>,
}

/// Each published frequency occurs as often as its family requires: once, twice, N − 3 times. The planets' own modes,
/// and those out of the plane of the set, are additional.
#[test]
fn families_of_modes_are_the_published_ones() {
    let data = include_str!("../data/planetary-modes.toml");
    let all: AllPublished = toml::from_str(data).unwrap();
    let sets = [
        (
            all.lin_parker,
            Set::lin_parker as fn(usize) -> Set,
            1.0,
            5e-4,
        ),
        // The source prints four digits.
        (
            all.cooley_parker,
            Set::cooley_parker,
            f64::sqrt(1e7 / 1.86) / TAU,
            6e-4,
        ),
    ];
    for (published, set, unit, tolerance) in sets {
        for own in published {
            let found = in_contact(&set(own.planets).model());
            let times = [
                (&own.simple, 1),
                (&own.double, 2),
                (&own.planet, own.planets - 3),
            ];
            for (frequencies, times) in times {
                for frequency in frequencies.iter().map(|frequency| frequency * unit) {
                    let near = |other: &&f64| (**other / frequency - 1.0).abs() < tolerance;
                    let count = found.iter().filter(near).count();
                    // Coincidences with motions out of the plane only increase the count.
                    assert!(
                        count >= times,
                        "{} planets: {frequency} {count}",
                        own.planets
                    );
                }
            }
        }
    }
}

/// The set in its plane, assembled by hand: x, y and rotation of sun, carrier and ring, then of each planet, in the
/// frame of the carrier.
pub struct Plane {
    pub mass: DMatrix<f64>,
    /// Stiffness with all meshes open.
    pub stiffness: DMatrix<f64>,
    /// Coriolis terms.
    pub turning: DMatrix<f64>,
    /// Participations of drive and coast flank: of the sun's mesh with each planet, then of the ring's.
    pub flanks: Vec<[DVector<f64>; 2]>,
    /// The rotation without contact deflections.
    pub neutral: DVector<f64>,
}

impl Plane {
    pub fn of(set: &Set) -> Self {
        let n = 3 * (3 + set.planets);
        let [rs, rp, rr] = set.base_radii();
        let [mut mass, mut stiffness, mut turning] = [0, 1, 2].map(|_| DMatrix::zeros(n, n));
        let mut spring = |k: f64, terms: &[(usize, f64)]| {
            for &(i, a) in terms {
                for &(j, b) in terms {
                    stiffness[(i, j)] += k * a * b;
                }
            }
        };
        let [zs, _, zr] = set.teeth.map(f64::from);
        let ratio = zs / (zs + zr);
        let frame = if set.gyroscopic { set.speed * ratio } else { 0.0 };
        let members = [(set.sun, rs), (set.carrier, set.radius), (set.ring, rr)];
        let planets = std::iter::repeat_n((set.planet, rp), set.planets);
        for (body, (member, radius)) in members.into_iter().chain(planets).enumerate() {
            let Member([m, inertia, support]) = member;
            let at = 3 * body;
            mass[(at, at)] = m;
            mass[(at + 1, at + 1)] = m;
            mass[(at + 2, at + 2)] = inertia * radius * radius;
            turning[(at, at + 1)] = -2.0 * m * frame;
            turning[(at + 1, at)] = 2.0 * m * frame;
            if body < 3 {
                spring(support, &[(at, 1.0)]);
                spring(support, &[(at + 1, 1.0)]);
                spring(-m * frame * frame, &[(at, 1.0)]);
                spring(-m * frame * frame, &[(at + 1, 1.0)]);
            }
        }
        spring(set.twist * rr * rr, &[(8, 1.0)]);
        let mut neutral = DVector::zeros(n);
        (neutral[2], neutral[5]) = (1.0, ratio);
        for planet in 0..set.planets {
            let own = 9 + 3 * planet;
            let [_, t] = directions(set, planet);
            for axis in 0..2 {
                // The pin: u_planet − u_carrier − r θ t.
                let pin = [
                    (own + axis, 1.0),
                    (3 + axis, -1.0),
                    (5, -set.radius * t[axis]),
                ];
                spring(set.planet.0[2], &pin);
                let way = [(own + axis, 1.0), (5, -set.radius * t[axis])];
                spring(-set.planet.0[0] * frame * frame, &way);
                neutral[own + axis] = ratio * set.radius * t[axis];
            }
            neutral[own + 2] = ratio - (1.0 - ratio) * rs / rp;
        }
        let meshes = [(0, rs, 1.0), (6, rr, -1.0)].map(|central| {
            (0..set.planets)
                .map(move |planet| [1.0, -1.0].map(|side| flank(set, planet, central, side)))
        });
        Self {
            mass,
            stiffness,
            turning,
            flanks: meshes.into_iter().flatten().collect(),
            neutral,
        }
    }
}

/// Radial and tangential direction at a planet.
pub fn directions(set: &Set, planet: usize) -> [[f64; 2]; 2] {
    let angle = TAU * planet as f64 / set.planets as f64;
    [[angle.cos(), angle.sin()], [-angle.sin(), angle.cos()]]
}

/// Participation along a line of action of a planet and a central gear: its first coordinate, base radius, and the
/// inclination of its drive flanks. The sun rotates forwards and pushes the planet's flank, the planet backwards and
/// pushes the ring's.
fn flank(
    set: &Set,
    planet: usize,
    (body, radius, lean): (usize, f64, f64),
    side: f64,
) -> DVector<f64> {
    let (sin, cos) = set.pressure_angle.to_radians().sin_cos();
    let [e, t] = directions(set, planet);
    let own = 9 + 3 * planet;
    let mut felt = DVector::zeros(3 * (3 + set.planets));
    for axis in 0..2 {
        let line = cos * t[axis] + side * lean * sin * e[axis];
        felt[body + axis] = line;
        felt[own + axis] = -line;
    }
    felt[body + 2] = radius;
    // Rolling in the carrier's frame, a planet rotates against the sun and with the ring.
    felt[own + 2] = lean * set.base_radii()[1];
    felt
}

/// Complex frequencies of the set by hand, with every drive flank closed.
fn by_hand(set: &Set) -> Vec<(f64, f64)> {
    let Plane {
        mass,
        mut stiffness,
        turning,
        flanks,
        neutral,
    } = Plane::of(set);
    for [drive, _] in &flanks {
        stiffness += set.stiffness * drive * drive.transpose();
    }
    frequencies_without(&neutral, mass, &stiffness, turning)
}

/// Complex frequencies without the rotation that has no contact deflection in the Coriolis terms: only its momentum
/// would conserve the mean speed.
pub fn frequencies_without(
    neutral: &DVector<f64>,
    mass: DMatrix<f64>,
    stiffness: &DMatrix<f64>,
    turning: DMatrix<f64>,
) -> Vec<(f64, f64)> {
    let n = mass.nrows();
    let momentum = &mass * neutral;
    let beside = DMatrix::identity(n, n) - neutral * momentum.transpose() / neutral.dot(&momentum);
    let turning = beside.transpose() * turning * &beside;
    let inverse = mass.try_inverse().unwrap();
    frequencies(&(&inverse * stiffness), &(&inverse * turning))
}

/// Frequencies \[Hz\], ascending, and growths \[1/s\] of `q'' + D q' + K q = 0` that are not zero.
fn frequencies(stiffness: &DMatrix<f64>, damping: &DMatrix<f64>) -> Vec<(f64, f64)> {
    // Use a unit of time that makes the parts of the companion matrix similar in size.
    let (n, unit) = (stiffness.nrows(), 1e4);
    let parts = [-stiffness / (unit * unit), -damping / unit];
    let mut companion = DMatrix::zeros(2 * n, 2 * n);
    companion.view_mut((0, n), (n, n)).fill_with_identity();
    for (column, part) in parts.iter().enumerate() {
        companion.view_mut((n, column * n), (n, n)).copy_from(part);
    }
    let values = companion.complex_eigenvalues();
    let mut found: Vec<(f64, f64)> = (values.iter())
        .filter(|value| value.im > 1e-4)
        .map(|value| (unit * value.im / TAU, unit * value.re))
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

/// Complex frequencies of a train from its modes, with all drive flanks closed.
pub fn of_train(set: &Set, text: &str) -> Vec<(f64, f64)> {
    let structure = build::structure(&job(text).points.at(0).model).unwrap();
    let n = structure.modes();
    let diagonal = structure.frequency.iter().map(|omega| omega * omega);
    let mut stiffness = DMatrix::from_diagonal(&DVector::from_iterator(n, diagonal));
    let mut turning = DMatrix::zeros(n, n);
    if let Some(coupling) = &structure.coupling {
        turning = set.speed * DMatrix::from_row_slice(n, n, &coupling.gyroscopic);
        stiffness += set.speed.powi(2) * DMatrix::from_row_slice(n, n, &structure.frame.stiffness);
    }
    let further = structure
        .contacts
        .iter()
        .filter(|own| own.name.starts_with("drive"));
    let flanks = std::iter::once(&structure.mesh).chain(further.map(|own| &own.participation));
    for flank in flanks {
        let along = DVector::from_column_slice(flank);
        stiffness += set.stiffness * &along * along.transpose();
    }
    frequencies(&stiffness, &turning)
}

/// The train equals the set assembled by hand, at rest and in the rotating frame, where Coriolis terms split the pairs.
#[test]
fn a_set_is_that_of_an_assembly_by_hand() {
    for (planets, gyroscopic, speed) in [(3, false, 100.0), (4, true, 800.0), (5, true, 3000.0)] {
        let set = Set {
            gyroscopic,
            speed,
            ..Set::lin_parker(planets)
        };
        let found = of_train(&set, &set.text());
        let exact = by_hand(&set);
        let mut worst = 0.0_f64;
        for (frequency, growth) in &exact {
            assert!(growth.abs() < 1e-8 * frequency, "{frequency}: {growth}");
            let near = found.iter().map(|own| (own.0 / frequency - 1.0).abs());
            let near = near.fold(f64::INFINITY, f64::min);
            println!("{frequency} {near:e}");
            worst = worst.max(near);
        }
        println!(
            "{planets} planets, {speed} rad/s: {} modes in the plane, {worst:.1e}",
            exact.len()
        );
        assert_eq!(exact.len(), 3 * (3 + planets) - 1);
        assert!(worst < 1e-9, "{planets} planets: {worst:e}");
    }
}

/// For a rattling set, events, states and energy agree with extended precision; both kernels agree.
#[test]
fn sets_rattle_exactly() {
    for (planets, gyroscopic) in [(3, false), (4, true)] {
        let set = Set {
            gyroscopic,
            speed: 800.0,
            levels: true,
            more: format!(
                "pin_errors = [{}]",
                ["8e-6", "0", "3e-6", "0"][..planets].join(", ")
            ),
            ..Set::lin_parker(planets)
        };
        let model = set.model();
        let start = disturbed(&model);
        let ([worst, _], [seen, exact]) = off_extended(&model, &start);
        println!("{planets} planets: states {worst:.1e}, {seen} events");
        assert_eq!(seen, exact);
        assert!(seen > 6, "{seen} events");
        assert!(worst < 1e-11, "{worst:e}");
        let mut audit = EnergyAudit::new(&model);
        let (end, _) = advance_with(&volterra(&model), &start, 20, &mut audit);
        let residual = audit.residual(&end).unwrap();
        assert!(residual < 1e-11, "{residual:e}");
    }
    let set = Set {
        speed: 2000.0,
        more: "pin_errors = [8e-6, 0, 3e-6]".to_owned(),
        ..Set::lin_parker(3)
    };
    let model = set.model();
    let kernel = ClosedModes::new(&model, 1000, InstructionSet::best()).unwrap();
    follows_volterra("three planets", &model, &kernel);
}

/// On average sun and ring carry the force from their torque, all planets together, and the carrier the sum.
#[test]
fn torques_balance() {
    let set = Set {
        levels: true,
        ..Set::lin_parker(3)
    };
    let model = set.model();
    let kernel = volterra(&model);
    let start = advance(&kernel, &model.start(&InitialState::Static), 3000);
    let mut nvh = Nvh::new(&model, 0);
    advance_with(&kernel, &start, 300, &mut nvh);
    let forces = nvh.outcome().unwrap().values.contact_force;
    let mesh = |mesh: usize| forces[2 * mesh] - forces[2 * mesh + 1];
    let [sun, _, ring] = set.base_radii();
    let of_sun: f64 = (0..3).map(mesh).sum();
    let of_ring: f64 = (3..6).map(mesh).sum();
    println!(
        "{:e} {:e}",
        of_sun * sun / 100.0 - 1.0,
        of_ring * ring / 400.0 - 1.0
    );
    assert!((of_sun * sun / 100.0 - 1.0).abs() < 1e-6);
    // The ring has z_r/z_s = 4 times the torque of the sun.
    assert!((of_ring * ring / 400.0 - 1.0).abs() < 1e-6);
    assert!((0..6).all(|own| (mesh(own) / mesh(0) - 1.0).abs() < 1e-6));
}

/// Forces of the sun's meshes at rest \[N\].
fn at_rest(model: &Model, planets: usize) -> Vec<f64> {
    let start = model.start(&InitialState::Static);
    (0..planets)
        .map(|planet| {
            let contact = &model.contacts[2 * planet];
            let segment = contact.cycles[0].segment_at(0.0);
            let (deflection, _) = model.deflection_on(segment, 0, &start.state, 0.0);
            segment.stiffness_at(0.0) * (deflection - contact.half_gap).max(0.0)
        })
        .collect()
}

/// If a pin is ahead of its position, the planets share the load according to the closed form (Bodas & Kahraman 2004,
/// Singh 2010). A floating sun shares equally between three planets. With four planets it loads one pair of opposite
/// planets more than the other.
#[test]
fn planets_share_the_load() {
    let error = 5e-6;
    for (planets, fixed, shares) in [
        (3, true, &[2.0 / 3.0, -1.0 / 3.0, -1.0 / 3.0][..]),
        (3, false, &[0.0; 3]),
        (4, true, &[0.75, -0.25, -0.25, -0.25]),
        (4, false, &[0.25, -0.25, 0.25, -0.25]),
        (
            5,
            false,
            &[0.4, -0.323_606_8, 0.123_606_8, 0.123_606_8, -0.323_606_8],
        ),
    ] {
        let mut set = Set::lin_parker(planets);
        set.sun.0[2] = 1e2;
        set.more = format!("pin_errors = [{error:e}{}]", ", 0".repeat(planets - 1));
        let mut text = set.text();
        let mut moves = |name: &str, motion: &str| {
            let name = format!("name = \"{name}\"");
            text = text.replacen(&name, &format!("{name}\nmotion = \"{motion}\""), 1);
        };
        moves("annulus", "none");
        moves("carrier", "rotation");
        if fixed {
            moves("input", "rotation");
        }
        let modes = format!("modes = {}", 6 * (3 + planets));
        let model = model(&job(&text.replace(&modes, "")));
        let [radius, _, _] = set.base_radii();
        let cos = set.pressure_angle.to_radians().cos();
        let path = 2.0 * cos / (2.0 / set.stiffness + 4.0 * cos * cos / set.planet.0[2]);
        for (planet, (force, share)) in at_rest(&model, planets).iter().zip(shares).enumerate() {
            // The carrier is driven: a planet whose pin is ahead gets less load.
            let expected = 100.0 / (planets as f64 * radius) - path * error * share;
            let unit = path * error;
            assert!(
                (force - expected).abs() < 2e-3 * unit,
                "{planets} {fixed} {planet}: {force} {expected}"
            );
        }
    }
}

/// Excitation of the sun at a harmonic by the stiffness of its meshes, as net force and net torque per unit of one
/// mesh.
fn excitation(model: &Model, planets: usize, harmonic: usize) -> [f64; 2] {
    const SAMPLES: usize = 240;
    let mut sums = [[0.0; 2]; 3];
    let mut unit = 0.0_f64;
    for planet in 0..planets {
        let cycle = &model.contacts[2 * planet].cycles[0];
        let (mut re, mut im) = (0.0, 0.0);
        for sample in 0..SAMPLES {
            let phase = (sample as f64 + 0.5) / SAMPLES as f64;
            let segment = cycle.segments.iter().find(|own| phase < own.end).unwrap();
            let (sin, cos) = (TAU * harmonic as f64 * phase).sin_cos();
            let k = segment.stiffness_at(phase) / SAMPLES as f64;
            (re, im) = (re + k * cos, im - k * sin);
        }
        let (sin, cos) = (TAU * planet as f64 / planets as f64).sin_cos();
        for (sum, weight) in sums.iter_mut().zip([1.0, cos, sin]) {
            *sum = [sum[0] + weight * re, sum[1] + weight * im];
        }
        unit = unit.max(re.hypot(im));
    }
    let size = |sum: [f64; 2]| sum[0].hypot(sum[1]) / unit;
    [size(sums[1]).hypot(size(sums[2])), size(sums[0])]
}

/// Whether a harmonic pushes the sun aside or rotates it follows from `l z_s mod N` alone (Parker 2000, Kahraman &
/// Blankenship 1994); the others cancel.
#[test]
fn phases_of_planets_cancel_harmonics() {
    for (planets, teeth) in [
        (3, [19, 20, 59]),
        (3, [24, 36, 96]),
        (4, [24, 36, 96]),
        (4, [25, 35, 95]),
        (4, [26, 34, 94]),
        (5, [41, 24, 89]),
    ] {
        let set = Set {
            teeth,
            levels: true,
            pressure_angle: 22.0,
            ..Set::lin_parker(planets)
        };
        let model = set.model();
        for harmonic in 1..=3 {
            let [force, torque] = excitation(&model, planets, harmonic);
            let kind = harmonic * teeth[0] as usize % planets;
            let (pushes, turns) = (kind == 1 || kind == planets - 1, kind == 0);
            let says = |acts: bool, size: f64| if acts { size > 1.0 } else { size < 1e-10 };
            assert!(
                says(pushes, force) && says(turns, torque),
                "{planets} {teeth:?} {harmonic}: {force:e} {torque:e}"
            );
        }
    }
}

/// If all planets are in phase, no net force acts on the sun: it stays on its axis while the set runs.
#[test]
fn planets_in_phase_keep_the_sun_in_place() {
    let set = Set {
        levels: true,
        ..Set::lin_parker(3)
    };
    let source = &job(&set.text()).points.at(0).model;
    let structure = build::structure(source).unwrap();
    let model = set.model();
    let end = advance(&volterra(&model), &model.start(&InitialState::Static), 50);
    let [displacement, _] = model.basis.modes(&end.state);
    let moved = |name: &str| -> f64 {
        let own = structure
            .motions
            .iter()
            .find(|motion| motion.name == name)
            .unwrap();
        own.gain
            .iter()
            .zip(&displacement)
            .map(|(gain, q)| gain * q)
            .sum()
    };
    let planet = DVector::from_vec(vec![moved("planet 1 x"), moved("planet 1 y")]).norm();
    for direction in ["x", "y"] {
        let sun = moved(&format!("input 1 {direction}"));
        assert!(sun.abs() < 1e-9 * planet, "{sun:e} {planet:e}");
    }
    assert!(planet > 1e-7);
}

/// Impossible assemblies are reported with numbers and a remedy, before anything runs.
#[test]
fn sets_that_do_not_fit_are_refused() {
    let good = Set::lin_parker(3).text();
    for (from, to, told) in [
        (
            "count = 3",
            "angles = [0, \"120 deg\", \"241 deg\"]",
            "`planet 3` does not fit between the teeth at 241",
        ),
        (
            "count = 3",
            "count = 6",
            "planets `planet 1` and `planet 2` touch",
        ),
        (
            "count = 3",
            "count = 3\npin_errors = [0, 0]",
            "2 pin errors for 3 planets",
        ),
        (
            "motion = \"none\"",
            "motion = \"all\"\ndiscs = [{ at = 0, polar_inertia = 1 }]",
            "can turn in two ways",
        ),
        (
            "output = 1\n",
            "output = 1\nmotion = \"lateral\"\n",
            "are both held",
        ),
        (
            "x = 1e8, y = 1e8",
            "x = 1e8, y = 2e8",
            "bearing 1 of shaft `input` is not the same in all directions",
        ),
        (
            "rated_torque = \"100 N*m\"\n[[train.shaft]]\nname = \"input\"\ngears = [{ ",
            "driver = \"carrier\"\nrated_torque = \"100 N*m\"\n[[train.shaft]]\nname = \"input\"\n\
             gears = [{ loose = { x = 1e8, y = 2e8, axial = 1e7, tilt = 1e4 }, ",
            "the bearing of the loose gear `sun` is not the same in all directions",
        ),
        (
            "stiffness = \"constant\"\nmean_stiffness = 5e8",
            "stiffness = \"table\"\nresolution = \"pairs\"",
            "all planets share the law",
        ),
        ("internal = true, ", "", "cannot mesh"),
        (
            "carrier = \"carrier\"",
            "carrier = \"arm\"",
            "there is no shaft `arm`",
        ),
        (
            "name = \"annulus\"",
            "name = \"planet 2\"",
            "has the name `planet 2`",
        ),
        (
            "gears = [\"sun\", \"planet\"]",
            "gears = [\"sun\", \"planet 2\"]",
            "write \"planet\": it stands for every planet",
        ),
        (
            "gears = [\"planet\", \"ring\"]",
            "gears = [\"planet 2\", \"ring\"]",
            "write \"planet\": it stands for every planet",
        ),
        (
            "rated_torque",
            "driver = \"planet 1\"\nrated_torque",
            "no motor drives one of them alone",
        ),
        (
            "name = \"annulus\"",
            "name = \"annulus\"\norigin = [\"10 um\", 0, 0]",
            "not on the axis of the carrier",
        ),
    ] {
        assert!(good.contains(from), "{from}");
        let said = refusal(&good.replacen(from, to, 1));
        assert!(said.contains(told), "{told}: {said}");
    }
}

/// A mesh cycle of the set is one in the carrier's frame: the sun's speed minus the carrier's.
#[test]
fn the_mesh_period_is_that_of_the_carriers_frame() {
    let model = Set::lin_parker(3).model();
    let frequency = 24.0 * 96.0 / 120.0 * 100.0 / TAU;
    assert!((model.period() * frequency - 1.0).abs() < 1e-12);
}

/// Centrifugal forces of planets: their bearings carry `m Ω_c² r` at rest, and nothing else does.
#[test]
fn bearings_hold_what_flies_outwards() {
    let set = Set {
        gyroscopic: true,
        // At 1500 rad/s centrifugal forces would press the planets into the ring until both flanks of their teeth
        // touch.
        speed: 1000.0,
        ..Set::lin_parker(3)
    };
    let (spinning, still) = (
        set.text(),
        set.text()
            .replace("gyroscopic = true", "gyroscopic = false"),
    );
    let radial = |text: &str| -> Vec<f64> {
        let model = model(&job(text));
        let state = model.start(&InitialState::Static).state;
        let modes = model.modes();
        ["planet 1 x", "planet 1 y", "planet 2 x", "input 1 x"]
            .map(|name| {
                let own = model.bearings.iter().find(|own| own.name == name).unwrap();
                let gains = own.gain.iter().enumerate();
                gains
                    .map(|(i, g)| g[0] * state[i] + g[1] * state[modes + i])
                    .sum()
            })
            .to_vec()
    };
    let pull = 0.66 * 200.0_f64.powi(2) * set.radius;
    let (spinning, still) = (radial(&spinning), radial(&still));
    // A planet displaced outwards on its bearing has a slightly larger centrifugal force.
    let more = 1.0 / (1.0 - 0.66 * 200.0_f64.powi(2) / 1e8);
    for (place, part) in [1.0, 0.0, -0.5, 0.0].into_iter().enumerate() {
        let found = spinning[place] - still[place];
        println!("{place}: {found} {}", part * pull * more);
        assert!(
            (found.abs() - (part * pull * more).abs()).abs() < 1e-3 * pull,
            "{place}: {found}"
        );
    }
}

/// A planet is in equilibrium: the bearing on its pin carries what sun and ring push along, also if the pin is out of
/// place.
#[test]
fn the_bearing_of_a_planet_carries_its_flanks() {
    for error in [0.0, 5e-6, 20e-6] {
        let set = Set {
            more: format!("pin_errors = [{error:e}, 0, 0]"),
            ..Set::lin_parker(3)
        };
        let model = set.model();
        let kernel = volterra(&model);
        let start = advance(&kernel, &model.start(&InitialState::Static), 3000);
        let mut nvh = Nvh::new(&model, 0);
        advance_with(&kernel, &start, 40, &mut nvh);
        let forces = nvh.outcome().unwrap().values.contact_force;
        let mesh = |mesh: usize| forces[2 * mesh] - forces[2 * mesh + 1];
        let tangential = (mesh(0) + mesh(3)) * set.pressure_angle.to_radians().cos();
        let means = bearing_means(&model, [3000, 40]);
        let found = means
            .iter()
            .find(|(name, _)| name == "planet 1 y")
            .unwrap()
            .1
            .abs();
        println!("{error}: {found} {tangential}");
        assert!(
            (found - tangential).abs() < 1e-3 * tangential,
            "{error}: {found} {tangential}"
        );
    }
}

/// If the drawing determines its phase, a planet's tooth touches sun and ring as in a drawing of both flanks: the
/// ring's flank passes its pitch point when the planet has rotated from the sun's by the angle between both flanks of
/// its tooth.
#[test]
fn the_ring_follows_the_sun_by_the_teeth_of_the_planet() {
    for teeth in [[24, 36, 96], [23, 37, 97], [40, 25, 90]] {
        let set = Set {
            teeth,
            pressure_angle: 21.0,
            ..Set::lin_parker(2)
        };
        let text = set
            .text()
            .replace("count = 2", "count = 1")
            .replace("modes = 30", "modes = 24");
        let train = match &job(&text).points.at(0).model.source {
            manifest::StructureSource::Train(train) => train.clone(),
            _ => unreachable!(),
        };
        let gearatlas::shaft::MeshLaw::Own(flanks) = &train.meshes[0].law else {
            panic!("the mesh of the ring");
        };
        // Compare positions along both lines of action, in base pitches: the planet's rotation times its base radius.
        let [_, base, ring] = set.base_radii();
        let (rack, module, shifts) = set.rack();
        let pitch = std::f64::consts::PI * module * rack.cos();
        let working = set.pressure_angle.to_radians();
        let sun_path = train.pair.approach().unwrap() / pitch;
        let tip = 0.5 * module * f64::from(teeth[2]) - module * (1.0 + shifts[2]);
        let start = (tip * tip - ring * ring).sqrt() - set.radius * working.sin();
        let ring_path = (base * working.tan() - start) / pitch;
        // From the flank at the sun's pitch point to the other flank at the ring's: half a revolution minus a tooth, in
        // pitches.
        let tooth = train.pair.operating_thickness(1).unwrap() * working.cos() / pitch;
        let turns = 0.5 * f64::from(teeth[1]) - tooth;
        let expected = (ring_path - (sun_path + turns)).rem_euclid(1.0);
        let apart = (flanks[0].phase - expected).rem_euclid(1.0);
        assert!(
            apart.min(1.0 - apart) < 1e-7,
            "{teeth:?}: {} {expected}",
            flanks[0].phase
        );
    }
}

/// A planet without a closed contact has a frequency at round-off in the coordinates of closed modes. The rate of the
/// planet must not count as the amplitude of a wave, because the round-off of margins would hide events.
#[test]
fn closed_modes_see_loose_planets_come() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/trains");
    let text = std::fs::read_to_string(folder.join("planetary.toml")).unwrap();
    let text = text
        .replace("gyroscopic = true", "gyroscopic = false")
        .replace("\"5 um\"", "\"15 um\"");
    let model = model(&job(&text.replace("\"1500 rpm\"", "\"4500 rpm\"")));
    let exact = volterra(&model);
    let kernel = ClosedModes::new(&model, 1000, InstructionSet::best()).unwrap();
    let mut start = advance(&exact, &model.start(&InitialState::Static), 200);
    let mut events = 0;
    for cycle in 0..12 {
        let (mut seen, mut told) = (Events::default(), Events::default());
        let (end, _) = advance_with(&exact, &start, 1, &mut seen);
        let (found, _) = advance_with(&kernel, &start, 1, &mut told);
        let off = common::state_difference(&model, &found.state, &end.state);
        assert_eq!(seen.0.len(), told.0.len(), "cycle {cycle}");
        assert!(off < 1e-11, "cycle {cycle}: {off:e}");
        events += seen.0.len();
        start = end;
    }
    assert!(events > 100, "{events}");
}

/// The position of the first planet is irrelevant: phases count from it.
#[test]
fn phases_count_from_the_first_planet() {
    let set = Set {
        levels: true,
        teeth: [19, 20, 59],
        pressure_angle: 22.0,
        ..Set::lin_parker(3)
    };
    let turned = set.text().replace(
        "count = 3",
        "angles = [\"10 deg\", \"130 deg\", \"250 deg\"]",
    );
    let (one, other) = (set.model(), model(&job(&turned)));
    for (a, b) in one.contacts.iter().zip(&other.contacts) {
        let starts = |contact: &gearatlas::model::Contact| -> Vec<f64> {
            let segments = contact.cycles[0].segments.iter();
            segments
                .map(|segment| segment.stiffness_at(segment.start))
                .collect()
        };
        for (a, b) in starts(a).iter().zip(starts(b)) {
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }
    for (a, b) in in_contact(&one).iter().zip(in_contact(&other)) {
        assert!((a - b).abs() < 1e-6 * (1.0 + b), "{a} {b}");
    }
}
