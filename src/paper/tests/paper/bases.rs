//! Do the bases of a structure serve every speed, load and gap?

use crate::common::{self, advance::follows_volterra};
use gearatlas_paper::kernels::{Bases, Dyadic, Spectral};

const CELLS: u32 = 60;

/// A kernel that uses the bases of another speed follows the kernel `volterra` as well as with new bases.
#[test]
fn bases_serve_every_speed_load_and_gap() {
    for (name, case) in common::drives() {
        let bases = Bases::new(&common::model(&case)).unwrap();
        for mut other in common::other_speeds(&case) {
            other.2.load *= 1.7;
            other.1.half_gap *= 1.3;
            let model = common::model(&other);
            let kernel = Spectral::with_bases(&model, CELLS, 1000, bases.clone()).unwrap();
            let name = format!("{name} {}", other.2.speed);
            follows_volterra(&name, &model, &kernel);
        }
    }
}

/// The predicted size of dyadic tables is that of the built tables.
#[test]
fn the_dyadic_size_is_known_without_building() {
    for (name, case) in common::drives() {
        let model = common::model(&case);
        let built = Dyadic::new(&model, CELLS, 9).unwrap().bytes();
        assert_eq!(Dyadic::size(&model, CELLS).unwrap(), built, "{name}");
    }
}
