//! How long a line of memory takes from one hardware thread to another: a square a pair.

use super::squares::Squares;
use super::titled;
use crate::report::plot::picture::Picture;
use crate::store::Characteristics;

/// None of two threads: one number needs no picture.
pub(super) fn draw(machine: &Characteristics) -> Option<Picture> {
    let mut threads: Vec<u32> = (machine.transfer.iter())
        .flat_map(|row| [row.key.a, row.key.b])
        .collect();
    threads.sort_unstable();
    threads.dedup();
    if threads.len() < 3 {
        return None;
    }
    let mut canvas = titled("Handing a line of memory over, one way", machine);
    let squares = machine.transfer.iter().flat_map(|row| {
        let (a, b, time) = (row.key.a, row.key.b, row.figure.value);
        [(a, b, time), (b, a, time)]
    });
    let shown = Squares {
        rows: (&threads, "thread"),
        columns: (&threads, "thread"),
        unit: (1e9, "median time [ns]"),
    };
    shown.draw(&mut canvas, squares.collect());
    Some(Picture::new("machine-transfer".into(), canvas))
}
