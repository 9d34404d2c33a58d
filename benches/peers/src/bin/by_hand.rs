//! What does a program cost that is written by hand for one drive?
//!
//! ```text
//! scripts/peers by-hand    builds this with by_hand/peer.c, runs it and records it under benches/runs/
//! ```
//!
//! The default drive with mirrored flanks rattles at 1200 rad/s under 5 % load. The C program and two kernels of atlas
//! advance the same states in turn, bare and with one tangent, in one process on one thread. The clock is the thread's
//! processor time; set-up is outside. The C program must follow `volterra` over five cycles, or nothing is recorded.

#[path = "../clock.rs"]
mod clock;
#[path = "../../../../tests/common/mod.rs"]
mod common;
#[path = "../hand_written.rs"]
mod hand_written;

use atlas::analysis::EnergyNorm;
use atlas::manifest;
use atlas::model::{Model, TrajectoryState};
use atlas::propagate::{ClosedModes, Counters, InstructionSet, Kernel, Tangents};
use common::advance::{settled, volterra};
use hand_written::HandWritten;
use serde_json::{Value, json};
use std::path::Path;

const MODES: [usize; 4] = [2, 6, 20, 40];

/// Cycles over which the motions are compared.
const COMPARED: u64 = 5;

/// Largest distance of two motions after them, in half gaps, and of their tangents by their length.
const ACCEPTED: f64 = 1e-9;

/// Cycles before the first state.
const TRANSIENT: u64 = 200;

/// Cycles under the clock from each state, and states: each is where `volterra` came to from the one before.
const STRETCH: u64 = 200;
const STRETCHES: usize = 101;

fn main() {
    let cases: Vec<Value> = MODES.into_iter().map(case).collect();
    println!(
        "{:#}",
        json!({ "stretches": STRETCHES, "stretch": STRETCH, "compared": COMPARED, "cases": cases })
    );
}

/// The default drive of its manifest, at one point and with its lowest modes.
fn model(modes: usize) -> Model {
    let text = include_str!("../../../../manifests/flex80.toml");
    let (head, rest) = text.split_once("[grid]").expect("a grid");
    let (_, rest) = rest.split_once("[run]").expect("a run");
    let head = head
        .replace("modes = 40", &format!("modes = {modes}"))
        .replace("retained = 40", &format!("retained = {modes}"));
    let text = format!("{head}[grid]\nload = 0.05\nspeed = \"1200 rad/s\"\n[run]{rest}");
    let job = manifest::parse(&text, "flex80.toml", Path::new("")).expect("the manifest is right");
    common::parts()
        .model(&job.points.at(0))
        .expect("the drive can be built")
}

/// Compares and times one number of modes.
fn case(modes: usize) -> Value {
    let model = model(modes);
    let (volterra, set) = (volterra(&model), InstructionSet::best());
    let closed_modes =
        ClosedModes::new(&model, 1000, set).expect("its eigenvectors are independent");
    let mut by_hand = HandWritten::new(&model, &format!("by-hand-{modes}"));
    let mut start = settled(&model, TRANSIENT);
    let distance = compare(&model, &mut by_hand, &volterra, &start);
    let accepted = |d: &f64| *d <= ACCEPTED;
    assert!(
        distance.iter().all(accepted),
        "{modes} modes: another motion, {distance:?}"
    );

    // Kernels in this order, each bare and with a tangent.
    let names = ["peer", "closed_modes", "volterra"];
    let mut times = [const { [const { Vec::new() }; 2] }; 3];
    let mut events = 0;
    for _ in 0..STRETCHES {
        for tangents in [0, 1] {
            let mut clocked = |kernel: usize, time: f64| times[kernel][tangents].push(time);
            clocked(0, by_hand.time(&start, STRETCH, tangents));
            clocked(1, time(&closed_modes, &start, tangents).0);
            let (seconds, end, met) = time(&volterra, &start, tangents);
            clocked(2, seconds);
            if tangents == 1 {
                (start, events) = (end, events + met);
            }
        }
    }
    let events_per_cycle = events as f64 / (STRETCHES as f64 * STRETCH as f64);
    assert!(events_per_cycle > 1.0, "{modes} modes do not rattle");
    let mut record = json!({
        "modes": modes,
        "felt": by_hand.modes(),
        "instructions": set.name(),
        "events_per_cycle": events_per_cycle,
        "distance": distance[0],
        "tangent_distance": distance[1],
    });
    for (name, times) in names.iter().zip(times) {
        let [bare, tangent] = times.map(quartiles);
        eprintln!(
            "{modes} modes, {name}: {:.3} µs a cycle, {:.3} with a tangent",
            1e6 * bare[1],
            1e6 * tangent[1]
        );
        record[name] = json!({ "bare": bare, "tangent": tangent });
    }
    record
}

/// Distances of the peer's motion, in half gaps, and of its tangent, by its length, from those of a kernel. Modes that no
/// flank feels are left out.
fn compare<K: Kernel>(
    model: &Model,
    by_hand: &mut HandWritten,
    kernel: &K,
    start: &TrajectoryState,
) -> [f64; 2] {
    let norm = EnergyNorm::new(model);
    let mut tangents = Tangents::zeros(model.modes(), 1);
    tangents.vector_mut(0).fill(1e-9);
    by_hand.set(start, tangents.vector(0));
    by_hand.run(COMPARED, 1);
    let (mut end, mut workspace) = (start.clone(), kernel.workspace());
    for _ in 0..COMPARED {
        kernel
            .advance_cycle(
                &mut end,
                &mut tangents,
                &mut workspace,
                &mut (),
                &mut Counters::default(),
            )
            .expect("the default drive does not diverge");
    }
    let apart = [&end.state[..], tangents.vector(0)].map(|own| by_hand.felt(own));
    let distance = |column: usize| -> Vec<f64> {
        let found = by_hand.get(column);
        by_hand.padded(
            &found
                .iter()
                .zip(&apart[column])
                .map(|(a, b)| a - b)
                .collect::<Vec<_>>(),
        )
    };
    let length = norm.length(tangents.vector(0));
    [
        norm.length(&distance(0)) / norm.unit(),
        norm.length(&distance(1)) / length,
    ]
}

/// Seconds a cycle of a stretch, where it ends, and the events on it.
fn time<K: Kernel>(
    kernel: &K,
    start: &TrajectoryState,
    count: usize,
) -> (f64, TrajectoryState, u64) {
    let (mut trajectory, mut workspace) = (start.clone(), kernel.workspace());
    let mut tangents = Tangents::zeros(start.state.len() / 2, count);
    if count > 0 {
        tangents.vector_mut(0).fill(1e-9);
    }
    let mut counters = Counters::default();
    let begin = clock::now();
    for _ in 0..STRETCH {
        kernel
            .advance_cycle(
                &mut trajectory,
                &mut tangents,
                &mut workspace,
                &mut (),
                &mut counters,
            )
            .expect("the default drive does not diverge");
    }
    (
        (clock::now() - begin) / STRETCH as f64,
        trajectory,
        counters.events,
    )
}

/// First quartile, median and third.
fn quartiles(mut times: Vec<f64>) -> [f64; 3] {
    times.sort_by(f64::total_cmp);
    [1, 2, 3].map(|quarter| times[(times.len() - 1) * quarter / 4])
}
