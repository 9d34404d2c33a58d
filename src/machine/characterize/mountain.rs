//! The memory mountain: reading buffers of different sizes line by line, with different strides.
//!
//! A pass with stride s reads the lines 0, s, 2s …, then 1, s + 1, …. It reads every line once, so that the
//! working set is the whole buffer for any stride. The method is that of Bryant and O'Hallaron, *Computer
//! Systems*, section 6.6. Their strides are in elements; here whole lines are read, as kernels read their
//! tables.

use super::buffer::{Buffer, LANES};
use super::error::MeasurementError;
use super::measured::Measured;
use super::memory;
use super::team::{self, HardwareThread, RepetitionTime};
use super::vectors::{self, Set};
use crate::topology::Topology;
use std::time::Duration;

/// Approximate time of a repetition.
const REPETITION: Duration = Duration::from_micros(500);

/// Largest number of lines per repetition, unless the buffer is larger.
const MOST_LINES: usize = 1 << 19;

/// Position of a reader in its buffer.
struct Reader {
    set: Set,
    buffer: Buffer,
    /// First line of the present sweep.
    sweep: usize,
    next: usize,
    /// Number of lines per repetition, for every stride.
    lines: Vec<usize>,
    right: bool,
}

impl Reader {
    /// Reads the next `lines` lines.
    fn read(&mut self, stride: usize, lines: usize) {
        let all = self.buffer.lines();
        let (mut left, mut sum) = (lines, 0.0);
        if stride == 1 && self.next == 0 {
            // Read a small buffer many times per call, because a call itself takes as long as reading some
            // lines.
            let passes = lines / all.len();
            sum += vectors::read(self.set, all, 1, all.len(), passes);
            left -= passes * all.len();
        }
        while left > 0 {
            let count = left.min((all.len() - self.next).div_ceil(stride));
            sum += vectors::read(self.set, &all[self.next..], stride, count, 1);
            left -= count;
            self.next += count * stride;
            if self.next >= all.len() {
                self.sweep = (self.sweep + 1) % stride;
                self.next = self.sweep;
            }
        }
        self.right &= sum == (lines * LANES) as f64;
    }

    /// Returns to the buffer's start.
    fn turn_back(&mut self) {
        (self.sweep, self.next) = (0, 0);
    }
}

/// Times per line \[s\], for every stride.
pub fn measure(
    topology: &Topology,
    thread: HardwareThread,
    lines: usize,
    strides: &[usize],
    pace: RepetitionTime,
) -> Result<Measured, MeasurementError> {
    let prepare = |_| {
        let mut reader = Reader {
            set: Set::widest(),
            buffer: memory::near(lines, 1.0)?,
            sweep: 0,
            next: 0,
            lines: Vec::new(),
            right: true,
        };
        for &stride in strides {
            reader.turn_back();
            let read = team::rounds_for(REPETITION, |n| reader.read(stride, n * 64)) * 64;
            // A small buffer is read in whole passes.
            let line_count = if lines < read { read.next_multiple_of(lines) } else { read };
            reader
                .lines
                .push(line_count.clamp(64, MOST_LINES.max(lines)));
        }
        Ok(reader)
    };
    let results = team::work(
        topology,
        &[thread],
        strides.len(),
        pace,
        prepare,
        // Read everything once, so that the caches contain what fits.
        |reader: &mut Reader, _| {
            reader.turn_back();
            reader.read(1, lines);
        },
        |reader: &mut Reader, task| {
            let lines = reader.lines[task];
            reader.read(strides[task], lines);
        },
        |reader| (reader.right, reader.lines),
    )?;
    let checked = results.checked("reading with a stride")?;
    let lines: Vec<f64> = (checked.results.iter().flatten())
        .map(|&lines| lines as f64)
        .collect();
    Ok(checked.per_unit(&lines).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every line is read once, for any division of a pass into repetitions.
    #[test]
    fn a_pass_reads_every_line_once() {
        for (lines, stride, piece) in [(64, 1, 10), (64, 4, 7), (67, 8, 5), (5, 1, 3)] {
            let mut reader = Reader {
                set: Set::widest(),
                buffer: memory::near(lines, 1.0).unwrap(),
                sweep: 0,
                next: 0,
                lines: Vec::new(),
                right: true,
            };
            let mut left = lines;
            while left > 0 {
                reader.read(stride, left.min(piece));
                left -= left.min(piece);
            }
            assert!(reader.right);
            assert_eq!((reader.sweep, reader.next), (0, 0), "{lines} {stride}");
            reader.buffer.lines_mut()[lines / 2].0[3] = 2.0;
            reader.read(stride, lines);
            assert!(!reader.right, "a wrong number is noticed");
        }
    }
}
