//! Bearing forces with few modes: the static share of omitted modes is added.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common;
use common::advance::{advance, advance_with, volterra};
use common::default_drive::flexible;
use gearatlas::analysis::{Outputs, Signals};
use gearatlas::model::{Division, Drive, InitialState, Model, OperatingPoint, Quantity};
use gearatlas::propagate::{Observer, Window};
use gearatlas::structure::{ModalStructure, OmittedModeForces};

/// Number of degrees of freedom of the drive: sixteen nodes with six each on either shaft.
const ALL: usize = 192;

/// Bearing forces of whole cycles.
struct Watch(Outputs);

impl Observer for Watch {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        self.0.window(window);
    }
}

/// The structure without the static share of omitted modes.
fn bare(mut structure: ModalStructure) -> ModalStructure {
    for bearing in &mut structure.bearings {
        bearing.left_out = OmittedModeForces::default();
    }
    structure
}

/// Names, means and root mean squares of the bearing forces, settled from rest.
fn forces(
    structure: &ModalStructure,
    drive: &Drive,
    speed: f64,
    cycles: u64,
) -> Vec<(String, [f64; 2])> {
    let point = OperatingPoint { load: 0.3, speed };
    let model = Model::new(structure, drive, point).unwrap();
    let kernel = volterra(&model);
    let start = advance(&kernel, &model.start(&InitialState::Static), cycles);
    let bearings = Signals {
        bearings: true,
        ..Signals::NONE
    };
    let mut watch = Watch(Outputs::new(&model, bearings).unwrap());
    let (_, counters) = advance_with(&kernel, &start, 40, &mut watch);
    assert_eq!(counters.events, 0);
    let [values, _] = watch.0.statistics(Quantity::BearingForce);
    let names = model.bearings.iter().map(|bearing| bearing.name.clone());
    names
        .zip(
            values
                .mean
                .into_iter()
                .zip(values.rms)
                .map(|(mean, rms)| [mean, rms]),
        )
        .collect()
}

fn constant() -> Drive {
    let mut drive = common::two_level_mesh(10e-6);
    drive.mesh = Division::levels(&[4e8], &[]);
    drive.transmission_error.clear();
    drive
}

/// At rest the shafts are levers: without tilt stiffness the load of each bearing follows from the distance of the
/// other one from the gear, for any number and choice of modes.
#[test]
fn at_rest_bearings_balance_the_mesh_force() {
    let mut drive = flexible();
    for shaft in &mut drive.shafts {
        for bearing in &mut shaft.bearings {
            bearing.tilt = 0.0;
        }
    }
    let force = 0.3 * 50.0 / drive.gears.base_radii()[0];
    let (sin, cos) = 20f64.to_radians().sin_cos();
    for (computed, retained, mta) in [
        (ALL, ALL, false),
        (40, 40, false),
        (40, 6, true),
        (40, 6, false),
        (8, 2, false),
    ] {
        let structure = drive.modes(computed, retained, mta).unwrap();
        let with = forces(&structure, &constant(), 1200.0, 0);
        let without = forces(&bare(structure), &constant(), 1200.0, 0);
        let (mut worst, mut before) = (0.0_f64, 0.0_f64);
        for ((name, [value, _]), (_, [bare, _])) in with.iter().zip(&without) {
            let side = if name.starts_with("pinion") { -1.0 } else { 1.0 };
            let lever = if name.contains(" 1 ") { 0.55 } else { 0.45 };
            let exact = match name.split(' ').nth(2) {
                Some("x") => side * lever * force * sin,
                Some("y") => side * lever * force * cos,
                _ => 0.0,
            };
            worst = worst.max((value - exact).abs() / force);
            before = before.max((bare - exact).abs() / force);
        }
        println!(
            "{retained} of {computed} modes: {worst:.1e} of the mesh force off, {before:.1e} without the share of the others"
        );
        assert!(worst < 1e-8, "{worst:e}");
        // If all modes are retained, there is no share of omitted modes.
        assert_eq!(before < 1e-8, computed == ALL, "{before:e}");
    }
}

/// In motion the share of omitted modes makes bearing forces converge faster with the number of modes.
#[test]
fn bearing_forces_converge_with_the_modes() {
    let mut mesh = constant();
    mesh.mesh = Division::levels(&[4.444e8, 3.333e8], &[0.6]);
    let drive = flexible();
    let speed = 350.0;
    let exact = forces(&drive.modes(ALL, ALL, false).unwrap(), &mesh, speed, 400);
    let largest = |part: usize| {
        exact
            .iter()
            .map(|(_, values)| values[part].abs())
            .fold(0.0, f64::max)
    };
    let off = |structure: &ModalStructure| -> [f64; 2] {
        let found = forces(structure, &mesh, speed, 400);
        [0, 1].map(|part| {
            let apart = found
                .iter()
                .zip(&exact)
                .map(|((_, a), (_, b))| (a[part] - b[part]).abs());
            apart.fold(0.0, f64::max) / largest(part)
        })
    };
    for retained in [6, 10, 20, 40] {
        let structure = drive.modes(60, retained, true).unwrap();
        let [[mean, rms], [bare_mean, bare_rms]] = [off(&structure), off(&bare(structure))];
        println!(
            "{retained} modes: mean {mean:.1e} (without {bare_mean:.1e}), RMS {rms:.1e} (without {bare_rms:.1e})"
        );
        assert!(
            mean < 1e-4 && mean < 0.1 * bare_mean,
            "{mean:e} {bare_mean:e}"
        );
        // With fewer modes the motion itself is different.
        assert!(retained < 20 || rms < bare_rms, "{rms:e} {bare_rms:e}");
    }
}
