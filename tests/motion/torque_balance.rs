//! Does the mean mesh force balance the load? For every shipped manifest, including the share of friction.
//!
//! Along the relative rotation the mean of `w F + μ (Λ₀ w_f + Λ₁ w_fl) F` balances the load, for any motion. Friction
//! of constant direction on mirrored flanks takes `μ tan α_w` of the mean modulus of the force, kilonewtons of rattle
//! under a load of 66 N; friction that changes its direction takes the difference of approach and recess.
#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance, advance_with, volterra};
use gearatlas::analysis::{Nvh, NvhOutcome};
use gearatlas::manifest::{self, FrictionSpec, Job, PointSpec, StructureSource};
use gearatlas::model::{InitialState, Model};
use gearatlas::propagate::{Observer, Window};
use std::path::{Path, PathBuf};

/// Forces of all flanks over time, and their friction along the relative rotation.
struct Rubbed<'m> {
    model: &'m Model,
    /// The block of the relative rotation.
    relative: usize,
    time: f64,
    force: f64,
    friction: f64,
    modulus: f64,
}

impl Observer for Rubbed<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        self.time += window.duration;
        let of_mesh = window.closed.iter();
        for closed in of_mesh.filter(|closed| self.model.of_mesh(closed.contact)) {
            let gain = &self.model.gains(&window.segments[closed.contact])[self.relative];
            let impulse = closed.force[0] * window.duration;
            let rubbing = gain.mesh_input[1] / gain.deflection[0] - 1.0;
            self.force += impulse;
            self.friction += rubbing * impulse;
            self.modulus += impulse.abs();
        }
    }
}

/// Results over some mesh cycles \[N\].
struct Balance {
    applied: f64,
    /// Force of the first mesh; for a sun with planets, of all its meshes.
    mesh: f64,
    friction: f64,
    modulus: f64,
    nvh: NvhOutcome,
}

impl Balance {
    /// Difference of force and friction from the load, and its bound: four standard errors, and the change of slowly
    /// settling motion in the record.
    fn residual(&self) -> [f64; 2] {
        let error = self.nvh.stderr.as_ref().map_or(0.0, |e| e.force_mean);
        let scale = self.applied.abs() + self.modulus;
        let residual = self.mesh + self.friction - self.applied;
        [residual.abs(), 4.0 * error + 1e-4 * scale]
    }
}

/// The force that the load alone requires of the mesh \[N\]: the rated torque over the pinion's base radius. If another
/// shaft drives the first gear, the power of the driver gives the torque, and the coast flanks carry it.
fn asked_for(point: &PointSpec) -> f64 {
    let gears = point.model.source.gears().unwrap();
    let asked = point.load * gears.rated_torque / gears.base_radii()[0];
    match &point.model.source {
        StructureSource::Train(train) if train.gears[0].shaft != train.driver => {
            let own = &train.shafts[train.gears[0].shaft].name;
            let speeds = train.body_speeds().unwrap();
            let (_, speed) = speeds.iter().find(|(name, _)| name == own).unwrap();
            -asked / speed.abs()
        }
        _ => asked,
    }
}

/// The drive of a point without friction on its flanks.
fn without_friction(point: &PointSpec) -> Model {
    let mut smooth = point.clone();
    smooth.mesh.friction = FrictionSpec::Constant(0.0);
    common::parts().model(&smooth).unwrap()
}

/// The force of the first mesh at rest \[N\], for drives without friction.
fn at_rest(model: &Model) -> f64 {
    let start = model.start(&InitialState::Static);
    let segment = &model.first_cycle().segments[0];
    let (deflection, _) = model.deflection(&start.state, 0.0);
    let flank = (model.contacts[..model.flank_springs].iter())
        .find(|contact| contact.side * deflection > contact.half_gap);
    let [side, gap] = flank.map_or([0.0; 2], |contact| [contact.side, contact.half_gap]);
    side * segment.stiffness_at(0.0) * (side * deflection - gap - segment.error_at(0.0)[0])
}

fn balance(point: &PointSpec, [lead, cycles]: [u64; 2]) -> Balance {
    let model = common::parts().model(point).unwrap();
    let kernel = volterra(&model);
    let start = advance(&kernel, &model.start(&InitialState::Static), lead);
    let two_shafts = matches!(
        point.model.source,
        StructureSource::Rigid(_) | StructureSource::Flexible(_)
    );
    let felt = |block: &usize| {
        let rigid = [[0.0, 1.0], [0.0, 0.0]];
        model.blocks[*block].generator == rigid && model.first_gains()[*block].deflection[0] != 0.0
    };
    let relative = (0..model.modes()).find(felt);
    assert!(relative.is_some() || !point.mesh.friction.acts());
    let mut rubbed = Rubbed {
        model: &model,
        relative: relative.unwrap_or(0),
        time: 0.0,
        force: 0.0,
        friction: 0.0,
        modulus: 0.0,
    };
    let mut nvh = Nvh::new(&model, 0);
    advance_with(&kernel, &start, cycles, &mut (&mut nvh, &mut rubbed));
    let nvh = nvh.outcome().unwrap();
    let [force, friction, modulus] =
        [rubbed.force, rubbed.friction, rubbed.modulus].map(|impulse| impulse / rubbed.time);
    assert!(
        (force - nvh.values.force_mean).abs() <= 1e-9 * modulus,
        "{force} {} of {modulus}",
        nvh.values.force_mean
    );
    // If the first gear drives further meshes, all paths together carry its torque.
    let shared: Vec<usize> = match &point.model.source {
        StructureSource::Train(train) => {
            let meshes = (1..).zip(&train.meshes);
            let own = meshes.filter(|(_, mesh)| mesh.gears[0] == train.gears[0]);
            own.map(|(number, _)| number).collect()
        }
        _ => Vec::new(),
    };
    let others = shared.iter().map(|mesh| {
        let flanks = &nvh.values.contact_force[2 * mesh..];
        flanks[0] - flanks[1]
    });
    Balance {
        mesh: nvh.values.force_mean + others.sum::<f64>(),
        applied: if two_shafts || !shared.is_empty() {
            asked_for(point)
        } else {
            at_rest(&without_friction(point))
        },
        friction: if point.mesh.friction.acts() { friction } else { 0.0 },
        modulus,
        nvh,
    }
}

fn job(path: &Path) -> Job {
    let text = std::fs::read_to_string(path).unwrap();
    let name = path.file_name().unwrap().to_str().unwrap();
    manifest::parse(&text, name, path.parent().unwrap()).unwrap_or_else(|e| panic!("{e}"))
}

/// The shipped manifests that have a mesh.
fn shipped() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests");
    let mut found = Vec::new();
    for folder in ["", "orbits", "tiers", "trains"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let toml = path.extension().is_some_and(|end| end == "toml");
            if toml && std::fs::read_to_string(&path).unwrap().contains("\n[mesh]") {
                found.push(path);
            }
        }
    }
    found.sort();
    assert!(found.len() >= 29, "{found:?}");
    found
}

/// The balance holds at the first and at the middle point of each shipped manifest.
#[test]
fn every_shipped_mesh_bears_its_load() {
    for path in shipped() {
        let job = job(&path);
        let mut points = vec![0, job.points.len() / 2];
        points.dedup();
        for number in points {
            let point = job.points.at(number);
            let met = balance(&point, [200, 1500]);
            let [residual, bar] = met.residual();
            let told = format!(
                "{} at load {}, {:.0} rad/s: asked {:.2} N, mesh {:.2} N, friction {:.3} N, mean |F| {:.1} N, off by {residual:.3} N of {bar:.3} N",
                path.file_stem().unwrap().to_string_lossy(),
                point.load,
                point.speed,
                met.applied,
                met.nvh.values.force_mean,
                met.friction,
                met.modulus,
            );
            println!("{told}");
            assert!(residual <= bar, "{told}");
        }
    }
}

/// At 5 % load, 2.5 N m on the base radius of 37.588 mm, the mesh carries 66.51 N over the whole range of speeds,
/// except for the share of friction. With friction of constant direction it carried up to three times the load.
#[test]
fn the_default_drive_bears_its_load_through_rattle() {
    let manifests = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests");
    let mut point = job(&manifests.join("flex80.toml")).points.at(0);
    let gears = point.model.source.gears().unwrap();
    // The arm of a friction force at the pitch point is tan α_w of the base radii.
    let most = 0.05 * gears.operating_pressure_angle().unwrap().tan();
    for speed in [600.0, 900.0, 1200.0, 1500.0] {
        (point.load, point.speed) = (0.05, speed);
        let met = balance(&point, [1000, 20_000]);
        let [residual, bar] = met.residual();
        let error = met.nvh.stderr.as_ref().unwrap().force_mean;
        println!(
            "{speed} rad/s: mesh {:.2} ± {error:.2} N, friction {:.2} N, mean |F| {:.1} N, of one direction {:.1} N",
            met.nvh.values.force_mean,
            met.friction,
            met.modulus,
            most * met.modulus,
        );
        assert!((met.applied - 66.511).abs() < 1e-3);
        assert!(residual <= bar, "{speed}: {residual} N, {bar} N");
        assert!(
            met.friction.abs() < 0.5 * most * met.modulus,
            "{speed}: {}",
            met.friction
        );
    }
}
