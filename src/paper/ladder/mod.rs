//! The paper's kernels on the paper's cases, together with the kernel `volterra` in the same run: Tables 1 to 5,
//! Figures 3 to 6, and `spectral` in single precision.
//!
//! Compared codes run alternately, in rounds, timed by the thread's processor time; results are medians.

mod adaptive;
mod contact;
mod drives;
// Shared with the comparison with other solvers.
#[allow(dead_code, missing_docs)]
#[path = "../../../benches/peers/src/field.rs"]
mod field;
mod products;
mod rattle;
// Shared with the benches.
#[allow(missing_docs)]
#[path = "../../../benches/columns/rounds.rs"]
mod rounds;
mod scenes;
mod single;
mod threads;

use gearatlas_core::propagate::InstructionSet;
use serde_json::{Map, Value, json};
use std::time::Instant;

type Part = (&'static str, fn() -> Value);

const PARTS: [Part; 11] = [
    ("small_steps", contact::small_steps),
    ("events", rattle::events),
    ("reduction", rattle::reduction),
    ("conditioning", rattle::conditioning),
    ("contact", contact::cycles),
    ("work_precision", contact::work_precision),
    ("single_precision", single::precision),
    ("products", products::product_times),
    ("threads", threads::scaling),
    ("drift", drives::drift),
    ("friction", drives::friction),
];

/// Names of all parts.
pub fn names() -> impl Iterator<Item = &'static str> {
    PARTS.iter().map(|(name, _)| *name)
}

/// Measures some parts, or all of them if none is named.
pub fn measure(wanted: &[String]) -> Value {
    let mut record = Map::new();
    record.insert("instructions".into(), json!(InstructionSet::best().name()));
    let mut seconds = Map::new();
    for (name, part) in PARTS {
        if wanted.is_empty() || wanted.iter().any(|w| w == name) {
            let clock = Instant::now();
            record.insert(name.into(), part());
            seconds.insert(name.into(), json!(clock.elapsed().as_secs_f64()));
        }
    }
    record.insert("seconds".into(), Value::Object(seconds));
    Value::Object(record)
}
