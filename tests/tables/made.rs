//! A made-up mesh table: shapes like those of a real one, values from closed forms.

use std::convert::Infallible;
use std::path::Path;

use gearatlas::gear::MeshTable;
use gearatlas::store::{CacheContent, Origin, TableStore};
use serde_json::{Value, json};

/// Nodes of Gauss and Legendre \[Abramowitz and Stegun, table 25.4\].
pub const NODES: [f64; 8] = [
    -0.960289856497536,
    -0.796666477413627,
    -0.525532409916329,
    -0.183434642495650,
    0.183434642495650,
    0.525532409916329,
    0.796666477413627,
    0.960289856497536,
];
/// Breaks of the mesh phase; two pairs of teeth are in contact up to 0.6.
const BREAKS: [f64; 9] = [0.0, 0.15, 0.3, 0.45, 0.6, 0.7, 0.8, 0.9, 1.0];
const MISALIGNMENT: [f64; 4] = [0.0, 1e-4, 3e-4, 1e-3];
const TORQUE: [f64; 3] = [20.0, 50.0, 200.0];

pub fn inputs() -> Value {
    json!({
        "method": "closed forms",
        "pinion": { "teeth": 25, "module": 0.003, "face_width": 0.02 },
        "wheel": { "teeth": 31 },
        "torque": TORQUE,
    })
}

/// Share of the face that carries load.
fn contact(misalignment: f64, torque: f64) -> f64 {
    (torque / (torque + 4e4 * misalignment)).sqrt()
}

fn shares(phase: f64) -> [f64; 3] {
    match phase {
        p if p < 0.6 => [0.35 + 0.3 * p / 0.6, 0.65 - 0.3 * p / 0.6, 0.0],
        _ => [1.0, 0.0, 0.0],
    }
}

fn stiffness(phase: f64) -> f64 {
    match phase {
        p if p < 0.6 => 4.2e8 + 0.4e8 * (1.0 - ((p - 0.3) / 0.3).powi(2)),
        p => 2.6e8 + 0.3e8 * (1.0 - ((p - 0.8) / 0.2).powi(2)),
    }
}

/// A mesh table with these values, with a contact pattern or without.
pub fn mesh(with_pattern: bool) -> MeshTable {
    let over = |value: &dyn Fn(f64, f64, f64) -> Vec<f64>| -> Vec<f64> {
        let mut values = Vec::new();
        for (misalignment, torque) in grid() {
            for ends in BREAKS.windows(2) {
                let phase = |x: f64| 0.5 * (ends[0] + ends[1] + x * (ends[1] - ends[0]));
                values.extend(
                    NODES
                        .iter()
                        .flat_map(|x| value(misalignment, torque, phase(*x))),
                );
            }
        }
        values
    };
    let k = |e: f64, t: f64, p: f64| stiffness(p) * contact(e, t);
    let slices = 32;
    let load = |misalignment: f64, torque: f64, phase: f64| -> Vec<f64> {
        let reach = contact(misalignment, torque);
        let load = 2.0 * torque / 0.035 / 0.02 * shares(phase)[0] / reach;
        let wedge = |slice: usize| {
            let z = (slice as f64 + 0.5) / slices as f64;
            if misalignment > 0.0 { (1.0 - (1.0 - z) / reach).max(0.0) } else { 0.5 }
        };
        (0..slices).map(|slice| load * wedge(slice)).collect()
    };
    MeshTable {
        base_radius: 0.035,
        misalignment: MISALIGNMENT.to_vec(),
        torque: TORQUE.to_vec(),
        breaks: BREAKS.to_vec(),
        node: NODES.to_vec(),
        stiffness: over(&|e, t, p| vec![k(e, t, p)]),
        centre: over(&|e, t, _| vec![0.01 * (1.0 - contact(e, t))]),
        transmission_error: over(&|e, t, p| vec![t / 0.035 / k(e, t, p)]),
        friction: over(&|_, _, p| vec![if p < 0.45 { 1.0 } else { -1.0 }]),
        friction_lever: over(&|_, _, p| vec![0.004 * (p - 0.45)]),
        contact_fraction: over(&|e, t, _| vec![contact(e, t)]),
        loaded_pairs: over(&|_, _, p| vec![if p < 0.6 { 2.0 } else { 1.0 }]),
        share: over(&|_, _, p| shares(p).to_vec()),
        pattern: if with_pattern { over(&load) } else { Vec::new() },
        slices,
    }
}

fn grid() -> impl Iterator<Item = (f64, f64)> {
    let over = |misalignment: f64| TORQUE.into_iter().map(move |torque| (misalignment, torque));
    MISALIGNMENT.into_iter().flat_map(over)
}

/// Stores a table in `folder/tables` and returns its file, relative to the folder.
pub fn keep(folder: &Path, table: impl CacheContent) -> String {
    let store = TableStore::open(folder.join("tables"));
    let fetched = store
        .get_or_build(&inputs(), || Ok::<_, Infallible>(table))
        .unwrap();
    assert!(fetched.warnings.is_empty() && fetched.origin == Origin::Built);
    let name = fetched.file.file_name().unwrap().to_str().unwrap();
    format!("tables/{name}")
}
