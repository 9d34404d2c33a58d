//! The mesh cycle: segments of constant stiffness and damping.

/// A boundary this close to one of equal parts, in parts, lies on it: only rounding put it
/// elsewhere.
const ON_BOUNDARY: f64 = 1e-9;

/// A stretch of the mesh cycle with one stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Mesh phase at its start, in cycles.
    pub start: f64,
    /// Mesh phase at its end, in cycles.
    pub end: f64,
    /// Mesh stiffness k \[N/m\].
    pub stiffness: f64,
    /// Contact damping c \[N s/m\].
    pub damping: f64,
}

/// One mesh cycle; equal neighbours are one segment.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshCycle {
    /// Mesh period T \[s\].
    pub period: f64,
    /// The segments, in order, covering the cycle.
    pub segments: Vec<Segment>,
}

impl MeshCycle {
    /// Builds the cycle from one stiffness \[N/m\] a division and the phases between them.
    ///
    /// * `transitions`: where each stiffness gives way to the next, increasing, inside
    ///   (0, 1), one fewer than `stiffness`; none for equal divisions.
    pub fn new(period: f64, stiffness: &[f64], transitions: &[f64], damping: f64) -> Self {
        let equal = |i: usize| i as f64 / stiffness.len() as f64;
        let mut segments: Vec<Segment> = Vec::new();
        for (i, &stiffness) in stiffness.iter().enumerate() {
            let end = transitions.get(i).copied();
            let end = end.unwrap_or(if transitions.is_empty() {
                equal(i + 1)
            } else {
                1.0
            });
            match segments.last_mut() {
                Some(last) if last.stiffness == stiffness => last.end = end,
                last => {
                    let start = last.map_or(0.0, |last| last.end);
                    segments.push(Segment {
                        start,
                        end,
                        stiffness,
                        damping,
                    });
                }
            }
        }
        Self { period, segments }
    }

    /// Start of a segment within the cycle \[s\].
    pub fn start(&self, segment: usize) -> f64 {
        self.period * self.segments[segment].start
    }

    /// End of a segment within the cycle \[s\].
    pub fn end(&self, segment: usize) -> f64 {
        self.period * self.segments[segment].end
    }

    /// The fewest equal parts of the cycle on whose boundaries all segments end; none where
    /// that takes more than `most`.
    pub fn equal_parts(&self, most: usize) -> Option<usize> {
        (1..=most).find(|&parts| {
            self.segments.iter().all(|segment| {
                let end = segment.end * parts as f64;
                (end - end.round()).abs() < ON_BOUNDARY
            })
        })
    }

    /// Mean stiffness over the cycle \[N/m\].
    pub fn mean_stiffness(&self) -> f64 {
        self.segments
            .iter()
            .map(|s| s.stiffness * (s.end - s.start))
            .sum()
    }

    /// Largest stiffness \[N/m\].
    pub fn largest_stiffness(&self) -> f64 {
        self.segments
            .iter()
            .map(|s| s.stiffness)
            .fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_neighbours_are_one_segment() {
        let cycle = MeshCycle::new(1.0, &[2.0, 2.0, 2.0, 1.0, 1.0], &[], 0.1);
        assert_eq!(cycle.segments.len(), 2);
        assert_eq!(cycle.end(0), 0.6);
        assert_eq!(cycle.start(1), 0.6);
        assert_eq!(cycle.end(1), 1.0);
        assert!((cycle.mean_stiffness() - 1.6).abs() < 1e-15);
        assert_eq!(cycle.largest_stiffness(), 2.0);
        assert_eq!(cycle.equal_parts(4), None);
        assert_eq!(cycle.equal_parts(10), Some(5));
    }

    #[test]
    fn transitions_may_lie_anywhere() {
        let place = 1.0 / 2f64.sqrt();
        let cycle = MeshCycle::new(2.0, &[3.0, 1.0], &[place], 0.1);
        assert_eq!((cycle.start(0), cycle.end(0)), (0.0, 2.0 * place));
        assert_eq!((cycle.start(1), cycle.end(1)), (2.0 * place, 2.0));
        assert!((cycle.mean_stiffness() - (1.0 + 2.0 * place)).abs() < 1e-15);
        assert_eq!(cycle.equal_parts(10_000), None);
        let equal = MeshCycle::new(2.0, &[3.0, 3.0], &[place], 0.1);
        assert_eq!(equal.segments.len(), 1);
        assert_eq!(equal.equal_parts(1), Some(1));
    }
}
