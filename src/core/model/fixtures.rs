//! Structures and meshes for tests. The unit tests use them from here. The tests of the whole program
//! (`tests/common`) compile the same file. It therefore names its types through `super`, which is the model
//! here, and the re-exports of the program there.

use super::{Division, Drive, MeshHarmonic, ModalStructure, OperatingPoint};

/// A structure with the given frequencies \[rad/s\], damping ratio of the elastic modes, mesh and torque
/// participations.
pub fn structure(frequency: &[f64], ratio: f64, mesh: &[f64], torque: &[f64]) -> ModalStructure {
    ModalStructure {
        teeth: 20,
        wheel_teeth: Some(30),
        rated_force: 1330.0,
        ..ModalStructure::of_modes(frequency, ratio, mesh, torque)
    }
}

/// One undamped mode `q'' + ω² q = load − F`, whose displacement q is the mesh deflection. The mesh force at
/// full load is 1 N, and the pinion has one tooth.
pub fn one_mode(frequency: f64) -> ModalStructure {
    ModalStructure::of_modes(&[frequency], 0.0, &[1.0], &[1.0])
}

/// A mesh of constant stiffness \[N/m\] with a half gap \[m\], without damping, friction and excitation.
pub fn constant_mesh(half_gap: f64, stiffness: f64) -> Drive {
    Drive::constant(half_gap, stiffness)
}

/// The mesh of the default pair: two levels of stiffness, one harmonic of transmission error.
pub fn two_level_mesh(half_gap: f64) -> Drive {
    Drive {
        mesh: Division::levels(&[4.444e8, 3.333e8], &[0.6]),
        damping: 1483.0,
        transmission_error: vec![MeshHarmonic::new(1, 5e-6, 0.0)],
        ..constant_mesh(half_gap, 4e8)
    }
}

/// Strong rattle: light load, 1200 rad/s.
pub fn strong_rattle() -> OperatingPoint {
    OperatingPoint {
        load: 0.05,
        speed: 1200.0,
    }
}
