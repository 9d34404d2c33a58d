//! Breakpoints of one line that nearly coincide: every kernel needs about as many windows as usual, and the events are
//! those of coinciding breakpoints.

use crate::breakpoint_motion::{ALL, Case, Of, judge, model, moved};
use gearatlas::model::Model;
use gearatlas::propagate::Stop;
use gearatlas_paper::kernels::{DenseError, Dyadic, Fused, Hermite, Spectral};

const CELLS: u32 = 32;
const EVENT_LIMIT: u32 = 1000;

/// A function that advances a model with a kernel; an error if the kernel refuses the model.
type Mover = fn(&Model) -> Result<Result<crate::breakpoint_motion::Motion, Stop>, DenseError>;

const KERNELS: [Mover; 4] = [
    |model| Ok(moved(model, &Dyadic::new(model, CELLS, EVENT_LIMIT)?)),
    |model| Ok(moved(model, &Hermite::new(model, CELLS, EVENT_LIMIT)?)),
    |model| {
        Ok(moved(
            model,
            &Spectral::new(model, CELLS, EVENT_LIMIT, None)?,
        ))
    },
    |model| Ok(moved(model, &Fused::new(model, CELLS, EVENT_LIMIT)?)),
];

#[test]
fn breakpoints_that_nearly_coincide_are_passed() {
    let sizes = (-16..=-6).flat_map(|power| [1.0, 4.0].map(|digit| digit * 10.0_f64.powi(power)));
    let distances = std::iter::once(0.0).chain(sizes.flat_map(|size| [size, -size]));
    let distances: Vec<f64> = distances.collect();
    for (kernel, go) in KERNELS.into_iter().enumerate() {
        for of in ALL {
            let mut taken = 0;
            for &apart in &distances {
                let place = 19;
                let case = Case {
                    of,
                    place,
                    apart,
                    kernel,
                };
                let together = Case { apart: 0.0, ..case };
                let found = [case, together].map(|case| go(&model(case)));
                if let [Ok(found), Ok(exact)] = found {
                    judge(case, found, exact);
                    taken += 1;
                }
            }
            // Tables require one line with constant levels.
            let expected = if of == Of::Levels { distances.len() } else { 0 };
            assert_eq!(taken, expected, "{kernel} {of:?}");
        }
    }
}
