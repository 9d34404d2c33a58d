//! The mesh cycle: segments of constant stiffness and damping.

/// A run of equal neighbouring divisions of the mesh cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// First division.
    pub first: usize,
    /// Number of divisions.
    pub length: usize,
    /// Mesh stiffness k \[N/m\].
    pub stiffness: f64,
    /// Contact damping c \[N s/m\].
    pub damping: f64,
}

/// One mesh cycle, cut into `divisions` equal parts; equal neighbours are one segment.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshCycle {
    /// Mesh period T \[s\].
    pub period: f64,
    /// Number of equal parts the segment boundaries lie on.
    pub divisions: usize,
    /// The segments, in order, covering the cycle.
    pub segments: Vec<Segment>,
}

impl MeshCycle {
    /// Builds the cycle from one stiffness a division, merging equal neighbours.
    pub fn new(period: f64, stiffness: &[f64], damping: f64) -> Self {
        let mut segments: Vec<Segment> = Vec::new();
        for (division, &stiffness) in stiffness.iter().enumerate() {
            match segments.last_mut() {
                Some(last) if last.stiffness == stiffness => last.length += 1,
                _ => segments.push(Segment {
                    first: division,
                    length: 1,
                    stiffness,
                    damping,
                }),
            }
        }
        Self {
            period,
            divisions: stiffness.len(),
            segments,
        }
    }

    /// Start of a segment within the cycle \[s\].
    pub fn start(&self, segment: usize) -> f64 {
        self.period * self.segments[segment].first as f64 / self.divisions as f64
    }

    /// End of a segment within the cycle \[s\].
    pub fn end(&self, segment: usize) -> f64 {
        let s = &self.segments[segment];
        self.period * (s.first + s.length) as f64 / self.divisions as f64
    }

    /// Mean stiffness over the cycle \[N/m\].
    pub fn mean_stiffness(&self) -> f64 {
        let sum: f64 = self
            .segments
            .iter()
            .map(|s| s.stiffness * s.length as f64)
            .sum();
        sum / self.divisions as f64
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
        let cycle = MeshCycle::new(1.0, &[2.0, 2.0, 2.0, 1.0, 1.0], 0.1);
        assert_eq!(cycle.segments.len(), 2);
        assert_eq!(cycle.end(0), 0.6);
        assert_eq!(cycle.start(1), 0.6);
        assert_eq!(cycle.end(1), 1.0);
        assert!((cycle.mean_stiffness() - 1.6).abs() < 1e-15);
        assert_eq!(cycle.largest_stiffness(), 2.0);
    }
}
