//! Timing in rounds: compared codes run alternately, so that changes of the processor's speed affect all. The clock is
//! the thread's processor time.

use rustix::time::{ClockId, clock_gettime};

/// Number of rounds; results are medians over the rounds.
const ROUNDS: usize = 9;

/// Length of a batch \[s\].
const BATCH: f64 = 0.02;

/// Processor time \[s\] that this thread has used.
fn now() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// A timed function.
pub struct Contender<'a> {
    once: Box<dyn FnMut() + 'a>,
}

impl<'a> Contender<'a> {
    pub fn new(once: impl FnMut() + 'a) -> Self {
        Self {
            once: Box::new(once),
        }
    }

    fn batch(&mut self, count: usize) -> f64 {
        let begun = now();
        for _ in 0..count {
            (self.once)();
        }
        (now() - begun) / count as f64
    }

    /// Number of calls that fill a batch.
    fn count(&mut self) -> usize {
        let mut count = 1;
        loop {
            let spent = self.batch(count) * count as f64;
            if spent > 0.25 * BATCH {
                return ((BATCH / spent * count as f64) as usize).max(1);
            }
            count *= 4;
        }
    }
}

/// Time of one call: median, smallest and largest over the rounds \[ns\].
#[derive(Debug, Clone, Copy)]
pub struct Spell {
    pub median: f64,
    pub range: [f64; 2],
}

/// Times of one call of each contender.
pub fn race(contenders: &mut [Contender<'_>]) -> Vec<Spell> {
    let counts: Vec<usize> = contenders.iter_mut().map(Contender::count).collect();
    let mut times = vec![Vec::new(); contenders.len()];
    for _ in 0..ROUNDS {
        for ((contender, count), times) in contenders.iter_mut().zip(&counts).zip(&mut times) {
            times.push(1e9 * contender.batch(*count));
        }
    }
    let spell = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        Spell {
            median: times[ROUNDS / 2],
            range: [times[0], times[ROUNDS - 1]],
        }
    };
    times.into_iter().map(spell).collect()
}
