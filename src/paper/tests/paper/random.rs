//! Random modal drives: the rules of `tests/motion/fuzz_drives.rs` for the kernels that diagonalise a segment. They
//! allow the additional error that tables report for nearly parallel eigenvectors.

use crate::drawn::Drawn;
use crate::random_drives::{EVENT_LIMIT, KernelCall, Tally, put, refuse};
use gearatlas_paper::kernels::{Conditioning, Fused, Spectral, TableSize};

const CELLS: u32 = 30;

const KERNELS: [(&str, KernelCall); 2] = [
    ("spectral", |trial, name| {
        match Spectral::new(trial.model, CELLS, EVENT_LIMIT, None) {
            Ok(kernel) => {
                let off = reported_error(&kernel.conditioning(), kernel.bytes());
                trial.put(name, &kernel, off);
            }
            Err(_) => refuse(trial, name),
        }
    }),
    ("fused", |trial, name| {
        match Fused::new(trial.model, CELLS, EVENT_LIMIT) {
            Ok(kernel) => {
                let off = reported_error(&kernel.conditioning(), kernel.bytes());
                trial.put(name, &kernel, off);
            }
            Err(_) => refuse(trial, name),
        }
    }),
];

/// Allowed error of tables over a cycle: the largest measured error of a cell's propagator, times the number of cells.
/// The factor 2 is for the inputs, whose errors are not measured.
fn reported_error(bases: &[Conditioning], size: TableSize) -> f64 {
    let worst = bases.iter().map(|basis| basis.reconstruction);
    2.0 * worst.fold(0.0, f64::max) * size.cells as f64
}

/// Tests both kernels on drives of seed 1.
fn fuzz(numbers: impl IntoIterator<Item = u64>) -> Tally {
    let mut tally = Tally::default();
    for number in numbers {
        let faults = put(&Drawn::new(1, number), &mut tally, &KERNELS);
        assert!(faults.is_empty(), "drive {number}: {faults:#?}");
    }
    tally
}

#[test]
fn no_row_of_a_random_drive_is_wrong() {
    let tally = fuzz(0..30);
    // Every kernel answered for some drives.
    for (kernel, _) in KERNELS {
        let answered = tally.rows.get(&(kernel, "ok".into()));
        assert!(answered.is_some_and(|count| *count >= 15), "{tally:#?}");
        let compared = tally.compared.get(kernel);
        assert!(compared.is_some_and(|count| *count >= 40), "{tally:#?}");
    }
}

/// Drives whose orbits disappear in round-off; `tests/motion/fuzz_drives.rs` explains how.
#[test]
fn orbits_are_told_where_round_off_hides_them() {
    fuzz([75, 307, 407, 730, 1012, 1470, 1549, 1807, 2255, 2485, 2863]);
}
