//! The paper's kernels on the paper's cases, and the structured kernel beside them in the same
//! run: Tables 1 to 4, Figures 3, 5c and 6, and operators in single precision.
//!
//! ```text
//! scripts/record ladder           runs this and records it under benches/runs/
//! ```
//!
//! What is compared is timed in turn, in rounds, by the thread's processor time; figures are
//! medians. The output is JSON.

// A bench may print, and end on an unwrap, as a test may.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "ladder/adaptive.rs"]
mod adaptive;
// The clock of the C library.
#[allow(unsafe_code)]
#[path = "peers/src/clock.rs"]
mod clock;
#[path = "../tests/common/mod.rs"]
mod common;
#[path = "ladder/contact.rs"]
mod contact;
#[allow(dead_code)]
#[path = "peers/src/field.rs"]
mod field;
#[path = "ladder/rattle.rs"]
mod rattle;
#[path = "ladder/rounds.rs"]
mod rounds;
#[allow(dead_code)]
#[path = "cycle/scenes.rs"]
mod scenes;
#[path = "ladder/single.rs"]
mod single;
#[path = "ladder/threads.rs"]
mod threads;

use gearatlas::propagate::InstructionSet;
use serde_json::{Map, Value, json};
use std::time::Instant;

type Part = (&'static str, fn() -> Value);

const PARTS: [Part; 8] = [
    ("small_steps", contact::small_steps),
    ("events", rattle::events),
    ("reduction", rattle::reduction),
    ("conditioning", rattle::conditioning),
    ("contact", contact::cycles),
    ("work_precision", contact::work_precision),
    ("single_precision", single::precision),
    ("threads", threads::scaling),
];

/// Arguments other than the harness's own name parts to run alone.
fn main() {
    let wanted: Vec<String> = (std::env::args().skip(1))
        .filter(|argument| !argument.starts_with('-'))
        .collect();
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
    println!("{:#}", Value::Object(record));
}
