//! Values for window lengths that recur. A kernel has a few regular window lengths. Windows that are cut at
//! events can have any length.

/// Number of remembered windows. In a mesh computed from the gears, windows end at sixty segments of the
/// cycle and at the events of its tooth pairs. Even then, two windows of equal length are less than this
/// number apart.
const REMEMBERED_WINDOWS: usize = 192;

/// Maximum number of kept lengths: as many as a mesh computed from the gears has. With a smaller number, the
/// values of each length would be computed again in every cycle.
const CAPACITY: usize = 96;

/// Values by length of window \[s\], for recent lengths.
#[derive(Debug, Clone)]
pub struct WindowCache<T> {
    /// Recent lengths, the latest before `next`.
    recent: [f64; REMEMBERED_WINDOWS],
    next: usize,
    kept: Vec<(f64, T)>,
    /// Index of the value to replace when the cache is full.
    oldest: usize,
}

impl<T> WindowCache<T> {
    /// An empty cache.
    pub fn new() -> Self {
        Self {
            recent: [0.0; REMEMBERED_WINDOWS],
            next: 0,
            kept: Vec::new(),
            oldest: 0,
        }
    }

    /// The value for a length, computed by `make` when the length recurs; `None` if it is new.
    pub fn get_or_insert_recurring(&mut self, length: f64, make: impl FnOnce() -> T) -> Option<&T> {
        let known = self.kept.iter().position(|(kept, _)| *kept == length);
        let place = match known {
            Some(place) => place,
            None => {
                let again = self.is_recent(length);
                self.recent[self.next] = length;
                self.next = (self.next + 1) % REMEMBERED_WINDOWS;
                if !again {
                    return None;
                }
                let value = (length, make());
                if self.kept.len() < CAPACITY {
                    self.kept.push(value);
                    self.kept.len() - 1
                } else {
                    let place = self.oldest;
                    self.oldest = (place + 1) % CAPACITY;
                    self.kept[place] = value;
                    place
                }
            }
        };
        Some(&self.kept[place].1)
    }

    /// Whether a length is recent. Many lengths are compared at a time, because most lengths are not recent.
    fn is_recent(&self, length: f64) -> bool {
        let any = |lengths: &[f64; 32]| {
            lengths
                .iter()
                .fold(false, |any, recent| any | (*recent == length))
        };
        self.recent.as_chunks().0.iter().any(any)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_again_is_made_once() {
        let mut made = 0;
        let mut kept = WindowCache::new();
        let mut cuts = 0;
        for cycle in 0..10 {
            // Three regular lengths, and a cut that never recurs.
            for length in [1.0, 2.0, 1.0, 3.0, 4.0 + f64::from(cycle)] {
                match kept.get_or_insert_recurring(length, || {
                    made += 1;
                    length
                }) {
                    Some(value) => assert_eq!(*value, length),
                    None => cuts += 1,
                }
            }
        }
        assert_eq!(made, 3);
        assert_eq!(cuts, 10 + 3);
    }

    #[test]
    fn more_lengths_than_places_are_still_right() {
        let mut kept = WindowCache::new();
        for round in 0..4 {
            for i in 0..2 * CAPACITY {
                let length = 1.0 + i as f64;
                if let Some(value) = kept.get_or_insert_recurring(length, || length) {
                    assert_eq!(*value, length);
                    assert!(round > 0);
                }
            }
        }
    }
}
