//! The gear pair of tests. The unit tests use this module, and the tests of the whole program (`tests/common`) compile
//! the same file. `super` is the module `gear` in unit tests, and a module with re-exports of the program in the
//! others.

use super::{GearPair, ToothForm};

/// A spur pair of 4 mm and 20°, 20 mm wide, for 50 N m.
pub fn pair(teeth: [u32; 2], form: ToothForm) -> GearPair {
    GearPair {
        teeth,
        module: 4e-3,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        face_width: 20e-3,
        body_length: [20e-3; 2],
        rated_torque: 50.0,
        form,
    }
}
