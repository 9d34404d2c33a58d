//! Integrated cycles do not allocate.

use crate::common;
use crate::counting::{allocations, count};
use gearatlas_paper::kernels::{Dyadic, Fused, Hermite, Spectral};

const CELLS: u32 = 60;
const EVENT_LIMIT: u32 = 1000;

#[test]
fn integrating_allocates_nothing() {
    for (drive, case) in common::drives() {
        let model = common::model(&case);
        let dyadic = Dyadic::new(&model, CELLS, EVENT_LIMIT).unwrap();
        let hermite = Hermite::new(&model, CELLS, EVENT_LIMIT).unwrap();
        let fused = Fused::new(&model, CELLS, EVENT_LIMIT).unwrap();
        let [exact, gridded] =
            [None, Some(240)].map(|grid| Spectral::new(&model, CELLS, EVENT_LIMIT, grid).unwrap());
        for (name, counted) in [
            ("dyadic", allocations(&dyadic, &model)),
            ("hermite", allocations(&hermite, &model)),
            ("spectral", allocations(&exact, &model)),
            ("spectral on a grid", allocations(&gridded, &model)),
            ("fused", allocations(&fused, &model)),
        ] {
            assert_eq!(counted, 0, "{name} on {drive}");
        }
    }
}

#[test]
fn allocator_counts() {
    let before = count();
    let boxed = std::hint::black_box(Box::new(1));
    assert!(count() > before, "{boxed}");
}
