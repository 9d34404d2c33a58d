//! Integrated cases: the default drive with some of its modes, and settled trajectories.

use gearatlas_core::model::{
    Division, Drive, InitialState, MeshHarmonic, Model, OperatingPoint, TrajectoryState,
};
use gearatlas_core::propagate::{Counters, Kernel, Volterra};
use gearatlas_core::structure::ModalStructure;
use gearatlas_verify::verify::drives;
use std::sync::LazyLock;

/// Mesh cycles integrated before the timing.
const TRANSIENT: u64 = 200;

/// A drive at an operating point.
pub type Case = (ModalStructure, Drive, OperatingPoint);

/// The structure of the default drive with its forty modes.
static FORTY_MODES: LazyLock<ModalStructure> = LazyLock::new(|| {
    let cases = drives::cases().expect("the built-in drives");
    let last = cases.last().expect("the default drive");
    last.structure.clone()
});

/// The default drive with its `modes` lowest modes.
pub fn drive(modes: usize, load: f64, speed: f64) -> Case {
    let structure = FORTY_MODES.truncated(modes, false).expect("of forty modes");
    let mesh = Drive {
        mesh: Division::levels(&[4.444e8, 3.333e8], &[0.6]),
        damping: 1483.0,
        transmission_error: vec![MeshHarmonic::new(1, 5e-6, 0.0)],
        ..Drive::constant(9e-6, 4e8)
    };
    (structure, mesh, OperatingPoint { load, speed })
}

/// Full load, no transmission error and a small step of stiffness: the mesh never opens.
pub fn quiet(modes: usize) -> Case {
    let mut case = drive(modes, 1.0, 1200.0);
    case.1.transmission_error.clear();
    case.1.mesh = Division::levels(&[3.4e8, 3.333e8], &[0.6]);
    case
}

/// The model of a case.
pub fn model_of((structure, drive, point): &Case) -> Model {
    Model::new(structure, drive, *point).expect("a case of the paper")
}

/// The kernel `volterra` with a tolerance at round-off.
pub fn volterra(model: &Model) -> Volterra<'_> {
    Volterra::new(model, f64::EPSILON, 1000)
}

/// A trajectory past its transient.
pub fn settled(model: &Model) -> TrajectoryState {
    let kernel = volterra(model);
    let mut trajectory = model.start(&InitialState::Static);
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    kernel
        .advance(
            TRANSIENT,
            &mut trajectory,
            &mut workspace,
            &mut (),
            &mut counters,
        )
        .expect("the default drive does not diverge");
    trajectory
}

/// Largest difference of two states. Displacements and velocities are each relative to their largest entry in `b`.
pub fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let part = |range: std::ops::Range<usize>| {
        let (a, b) = (&a[range.clone()], &b[range]);
        let scale = b.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        let difference = a.iter().zip(b).map(|(x, y)| (x - y).abs());
        difference.fold(0.0, f64::max) / scale
    };
    let n = b.len() / 2;
    part(0..n).max(part(n..2 * n))
}
