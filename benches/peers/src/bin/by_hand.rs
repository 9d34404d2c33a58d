//! How fast is a program written by hand for one drive?
//!
//! ```text
//! scripts/record by-hand    builds this with by_hand/peer.c, runs it and records it under benches/runs/
//! ```
//!
//! The default drive with mirrored flanks rattles at 1200 rad/s under 5 % load. The C program and two kernels of atlas
//! advance the same states alternately, without and with one tangent, in one process on one thread. The clock is the
//! thread's processor time, without set-up. If the C program does not follow `volterra` over five cycles, nothing is
//! recorded.

#[path = "../clock.rs"]
mod clock;
#[path = "../../../../tests/common/mod.rs"]
mod common;
#[path = "../hand_written.rs"]
mod hand_written;

use common::advance::{settled, volterra};
use gearatlas::analysis::EnergyNorm;
use gearatlas::manifest;
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::propagate::{ClosedModes, Counters, InstructionSet, Kernel, Tangents};
use hand_written::HandWritten;
use serde_json::{Value, json};
use std::path::Path;

const MODES: [usize; 4] = [2, 6, 20, 40];

/// Cycles over which the motions are compared.
const COMPARED: u64 = 5;

/// Largest distance of two motions after [`COMPARED`] cycles, in half gaps, and of their tangents relative to their
/// length.
const ACCEPTED: f64 = 1e-9;

/// Cycles before the first state.
const TRANSIENT: u64 = 200;

/// Timed cycles from each state, and number of states. `volterra` ends at each state from the state before.
const STRETCH: u64 = 200;
const STRETCHES: usize = 101;

/// Numbers of tangents with which closed modes are timed alone: what would more states in each product cost?
const MANY: [usize; 2] = [3, 7];

/// Entries of a tangent at its start.
const TANGENT: f64 = 1e-9;

/// End of a stretch, and its duration in seconds.
struct Run {
    end: TrajectoryState,
    tangents: Tangents,
    events: u64,
    seconds: f64,
}

fn main() {
    let cases: Vec<Value> = MODES.into_iter().map(case).collect();
    let record = json!({
        "stretches": STRETCHES,
        "stretch": STRETCH,
        "compared": COMPARED,
        "cases": cases,
    });
    println!("{record:#}");
}

/// The default drive of its manifest, at one point and with its lowest modes. It has no friction, whose change of
/// direction at the pitch point would need more linear systems.
fn model(modes: usize) -> Model {
    let text = include_str!("../../../../manifests/flex80.toml");
    let (head, rest) = text.split_once("[grid]").expect("a grid");
    let (_, rest) = rest.split_once("[run]").expect("a run");
    let head = head
        .replace("modes = 40", &format!("modes = {modes}"))
        .replace("retained = 40", &format!("retained = {modes}"))
        .replace("friction = 0.05", "friction = 0");
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
    let closed_modes = ClosedModes::new(&model, 1000, set).expect("its bases are well conditioned");
    let mut by_hand = HandWritten::new(&model, &format!("by-hand-{modes}"));
    let mut start = settled(&model, TRANSIENT);
    let distance = distances(
        &model,
        &mut by_hand,
        &advance(&volterra, &start, COMPARED, 1),
        &start,
    );
    // The comparison also refuses NaN.
    let same = distance.iter().all(|d| *d <= ACCEPTED);
    assert!(
        same,
        "{modes} modes: the peer computes another motion, {distance:?}"
    );

    let mut times = [const { [const { Vec::new() }; 2] }; 3];
    let mut many = MANY.map(|_| Vec::new());
    let mut events = 0;
    for _ in 0..STRETCHES {
        let mut next = None;
        for count in [0, 1] {
            let tangent = vec![TANGENT; count * 2 * modes];
            let mut last = None;
            let seconds = [
                warm(|| by_hand.advance(&start, &tangent, STRETCH)),
                warm(|| advance(&closed_modes, &start, STRETCH, count).seconds),
                warm(|| {
                    last.insert(advance(&volterra, &start, STRETCH, count))
                        .seconds
                }),
            ];
            for (times, seconds) in times.iter_mut().zip(seconds) {
                times[count].push(seconds / STRETCH as f64);
            }
            next = last;
        }
        for (times, count) in many.iter_mut().zip(MANY) {
            let seconds = warm(|| advance(&closed_modes, &start, STRETCH, count).seconds);
            times.push(seconds / STRETCH as f64);
        }
        let run = next.expect("volterra has run");
        events += run.events;
        start = run.end;
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
        "many_tangents": MANY.into_iter().zip(many.map(quartiles)).collect::<Vec<_>>(),
    });
    for (name, times) in ["peer", "closed_modes", "volterra"].into_iter().zip(times) {
        let [bare, tangent] = times.map(quartiles);
        let medians = [bare, tangent].map(|times| 1e6 * times[1]);
        eprintln!("{modes} modes, {name}: {medians:.3?} µs a cycle, bare and with a tangent");
        record[name] = json!({ "bare": bare, "tangent": tangent });
    }
    record
}

/// Integrates a stretch by a kernel, with `count` tangents.
fn advance<K: Kernel>(kernel: &K, start: &TrajectoryState, cycles: u64, count: usize) -> Run {
    let (mut end, mut workspace) = (start.clone(), kernel.workspace());
    let mut tangents = Tangents::zeros(start.state.len() / 2, count);
    for i in 0..count {
        tangents.vector_mut(i).fill(TANGENT);
    }
    let mut counters = Counters::default();
    let begin = clock::now();
    for _ in 0..cycles {
        kernel
            .advance_cycle(
                &mut end,
                &mut tangents,
                &mut workspace,
                &mut (),
                &mut counters,
            )
            .expect("the default drive does not diverge");
    }
    let (seconds, events) = (clock::now() - begin, counters.events);
    Run {
        end,
        tangents,
        events,
        seconds,
    }
}

/// Distances of the peer's motion, in half gaps, and of its tangent, relative to its length, from those of a kernel,
/// without modes that have no participation in a flank.
fn distances(
    model: &Model,
    by_hand: &mut HandWritten,
    run: &Run,
    start: &TrajectoryState,
) -> [f64; 2] {
    let norm = EnergyNorm::new(model);
    by_hand.advance(start, &vec![TANGENT; start.state.len()], COMPARED);
    let ends = [&run.end.state[..], run.tangents.vector(0)];
    let units = [norm.unit(), norm.length(ends[1])];
    [0, 1].map(|column| norm.length(&by_hand.difference(column, ends[column])) / units[column])
}

/// The second of two runs: the first one loads the tables into the caches.
fn warm(mut seconds: impl FnMut() -> f64) -> f64 {
    seconds();
    seconds()
}

/// First quartile, median and third quartile.
fn quartiles(mut times: Vec<f64>) -> [f64; 3] {
    times.sort_by(f64::total_cmp);
    [1, 2, 3].map(|quarter| times[(times.len() - 1) * quarter / 4])
}
