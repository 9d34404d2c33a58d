//! What would trajectories of one speed gain as columns of one product, which reads tables once? Times the window
//! product of the structured kernel and the dense product of the table kernels with 1, 2, 4 and 8 columns, and as many
//! single products. Counts the windows in rattle without an event, which trajectories could share.
//!
//! ```text
//! scripts/record columns          runs this and records it under benches/runs/
//! ```
//!
//! Compared codes run alternately, in rounds, timed by the thread's processor time; results are medians. The output is
//! JSON.

// A bench may print and unwrap, like a test.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "columns/dense.rs"]
mod dense;
#[path = "columns/rounds.rs"]
mod rounds;
#[allow(dead_code)]
#[path = "cycle/scenes.rs"]
mod scenes;

use common::Case;
use gearatlas::model::Model;
use gearatlas::propagate::{Counters, InstructionSet, Kernel, Tangents};
use rounds::{Contender, Spell, race};
use scenes::{drive, quiet, settled, volterra};
use serde_json::{Value, json};

/// Numbers of columns in a product.
const COLUMNS: [usize; 4] = [1, 2, 4, 8];
const MODES: [usize; 3] = [40, 160, 640];
const LOADS: [f64; 2] = [0.05, 0.30];
/// Cycles over which windows are counted.
const COUNTED: u64 = 1000;

/// Counted work of [`COUNTED`] cycles of a trajectory.
fn counted(model: &Model) -> Counters {
    let kernel = volterra(model);
    let mut counters = Counters::default();
    let mut trajectory = settled(model);
    let mut workspace = kernel.workspace();
    kernel
        .advance(
            COUNTED,
            &mut trajectory,
            &mut workspace,
            &mut (),
            &mut counters,
        )
        .unwrap();
    counters
}

/// Median, smallest and largest time of each contender \[ns\].
fn told(times: &[Spell]) -> Value {
    let one = |spell: &Spell| json!([spell.median, spell.range[0], spell.range[1]]);
    times.iter().map(one).collect()
}

/// Nanoseconds of a cycle with 1, 2, 4 and 8 columns. The first column is a trajectory; the others are tangents, which
/// share its windows, contacts and events.
fn cycles(case: &Case) -> Value {
    let model = common::model(case);
    let kernel = volterra(&model);
    let start = settled(&model);
    let (model, kernel, start) = (&model, &kernel, &start);
    let mut contenders: Vec<Contender<'_>> = (COLUMNS.iter())
        .map(|&columns| {
            let mut trajectory = start.clone();
            let mut tangents = Tangents::zeros(model.modes(), columns - 1);
            let mut workspace = kernel.workspace();
            Contender::new(move || {
                for i in 0..columns - 1 {
                    tangents.vector_mut(i).fill(1e-9);
                }
                kernel
                    .advance_cycle(
                        &mut trajectory,
                        &mut tangents,
                        &mut workspace,
                        &mut (),
                        &mut Counters::default(),
                    )
                    .unwrap();
            })
        })
        .collect();
    told(&race(&mut contenders))
}

/// Times, windows and events of the structured kernel's cycles, in permanent contact and in rattle.
fn structured() -> Value {
    let rows = MODES.iter().map(|&modes| {
        let full = counted(&common::model(&quiet(modes)));
        let rattle = LOADS.map(|load| {
            let case = drive(modes, load, 1200.0);
            let work = counted(&common::model(&case));
            json!({
                "load": load,
                "cycle_ns": cycles(&case),
                "windows": work.windows as f64 / COUNTED as f64,
                "cut": work.partial_windows as f64 / COUNTED as f64,
                "events": work.events as f64 / COUNTED as f64,
            })
        });
        json!({
            "modes": modes,
            "windows": full.windows as f64 / COUNTED as f64,
            "cut": full.partial_windows as f64 / COUNTED as f64,
            "bytes": volterra(&common::model(&quiet(modes))).bytes(),
            "cycle_ns": cycles(&quiet(modes)),
            "rattle": rattle,
        })
    });
    rows.collect()
}

/// Windows, windows cut at events and events per cycle over the loads and speeds of `manifests/flex80.toml`.
fn plane() -> Value {
    let rows = (0..10)
        .flat_map(|i| (0..8).map(move |j| (i, j)))
        .map(|(i, j)| {
            let speed = 600.0 + 100.0 * f64::from(i);
            let load = 0.05 + 0.25 / 7.0 * f64::from(j);
            let work = counted(&common::model(&drive(40, load, speed)));
            let a_cycle = |count: u64| count as f64 / COUNTED as f64;
            json!([
                speed,
                load,
                a_cycle(work.windows),
                a_cycle(work.partial_windows),
                a_cycle(work.events)
            ])
        });
    rows.collect()
}

fn main() {
    let found = json!({
        "columns": COLUMNS,
        "instructions": InstructionSet::best().name(),
        "structured": structured(),
        "dense": dense::products(),
        "plane": plane(),
    });
    println!("{}", serde_json::to_string_pretty(&found).unwrap());
}
