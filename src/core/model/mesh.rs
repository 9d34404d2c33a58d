//! The mesh cycle: segments between the phases at which stiffness or direction change.

use super::{Division, FlankError, Stiffness};
use crate::numerics::legendre;

/// A breakpoint is on a boundary of equal parts if its distance, in lengths of a part, is below this. The
/// distance is then a rounding error.
const ON_BOUNDARY: f64 = 1e-9;

/// An interval of the mesh cycle with one polynomial for the stiffness and one direction of the mesh force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Mesh phase at its start, in cycles.
    pub start: f64,
    /// Mesh phase at its end, in cycles.
    pub end: f64,
    /// Mesh stiffness k.
    pub stiffness: Stiffness,
    /// Error of loaded flanks: it adds to the half gap.
    pub error: FlankError,
    /// Contact damping c \[N s/m\].
    pub damping: f64,
    /// Direction of the mesh force, as an index into [`super::Model::directions`].
    pub direction: usize,
}

impl Segment {
    /// The position x ∈ \[−1, 1\] of a mesh phase within the segment.
    pub fn place(&self, phase: f64) -> f64 {
        (2.0 * phase - self.start - self.end) / (self.end - self.start)
    }

    /// Mesh stiffness \[N/m\] at a mesh phase within the segment.
    pub fn stiffness_at(&self, phase: f64) -> f64 {
        if self.stiffness.is_constant() {
            self.stiffness.mean()
        } else {
            self.stiffness.at(self.place(phase))
        }
    }
}

impl Segment {
    /// Error of loaded flanks at a mesh phase within the segment \[m\], and its derivative with respect to
    /// the phase \[m\].
    pub fn error_at(&self, phase: f64) -> [f64; 2] {
        if self.error.is_none() {
            return [0.0; 2];
        }
        let x = self.place(phase);
        let slope = legendre::evaluate(&self.error.slope(), x);
        [self.error.at(x), 2.0 * slope / (self.end - self.start)]
    }

    /// Derivative of the mesh stiffness with respect to the phase \[N/m\], and second derivative of the error
    /// of loaded flanks \[m\], at a mesh phase within the segment.
    pub fn bends_at(&self, phase: f64) -> [f64; 2] {
        let (x, places) = (self.place(phase), 2.0 / (self.end - self.start));
        let stiffening = legendre::evaluate(&self.stiffness.slope(), x);
        let curvature = legendre::evaluate(&legendre::derivative(&self.error.slope()), x);
        [places * stiffening, places * places * curvature]
    }
}

/// One mesh cycle. Neighbouring segments with the same direction, the same constant stiffness and no errors are
/// merged.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshCycle {
    /// Mesh period T \[s\].
    pub period: f64,
    /// The segments, in order, covering the cycle.
    pub segments: Vec<Segment>,
}

impl MeshCycle {
    /// The cycle of `divisions` with a contact damping c \[N s/m\]. `directions` has the direction of each
    /// division.
    pub fn new(period: f64, divisions: &[Division], directions: &[usize], damping: f64) -> Self {
        let mut segments: Vec<Segment> = Vec::new();
        for (division, &direction) in divisions.iter().zip(directions) {
            let (stiffness, end) = (division.stiffness, division.end);
            if let Some(last) = segments.last_mut()
                && last.stiffness == stiffness
                && stiffness.is_constant()
                && last.direction == direction
                && last.error.is_none()
                && division.error.is_none()
            {
                last.end = end;
                continue;
            }
            segments.push(Segment {
                start: segments.last().map_or(0.0, |last| last.end),
                end,
                stiffness,
                error: division.error,
                damping,
                direction,
            });
        }
        Self { period, segments }
    }

    /// The segment at a time \[s\] within the cycle. At a border it is the later segment.
    pub fn segment_at(&self, time: f64) -> &Segment {
        let phase = time / self.period;
        let later = |segment: &&Segment| phase < segment.end;
        (self.segments.iter().find(later)).unwrap_or(&self.segments[self.segments.len() - 1])
    }

    /// Start of a segment within the cycle \[s\].
    pub fn start(&self, segment: usize) -> f64 {
        self.period * self.segments[segment].start
    }

    /// End of a segment within the cycle \[s\].
    pub fn end(&self, segment: usize) -> f64 {
        self.period * self.segments[segment].end
    }

    /// Whether loaded flanks have an error.
    pub fn has_error(&self) -> bool {
        self.segments.iter().any(|segment| !segment.error.is_none())
    }

    /// Mean stiffness over the cycle \[N/m\].
    pub fn mean_stiffness(&self) -> f64 {
        self.segments
            .iter()
            .map(|s| s.stiffness.mean() * (s.end - s.start))
            .sum()
    }
}

/// Kernels seek a division of the cycle into equal parts whose boundaries include the ends of all segments. This
/// is the largest number of parts that they try.
pub const MOST_PARTS: usize = 10_000;

/// The smallest number of equal parts of a cycle such that all `ends` (phases in cycles) are boundaries of
/// parts. `None` if the number exceeds `most`.
pub fn equal_parts(ends: &[f64], most: usize) -> Option<usize> {
    (1..=most).find(|&parts| {
        ends.iter().all(|end| {
            let end = end * parts as f64;
            (end - end.round()).abs() < ON_BOUNDARY
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(cycle: &MeshCycle, most: usize) -> Option<usize> {
        let ends: Vec<_> = cycle.segments.iter().map(|s| s.end).collect();
        equal_parts(&ends, most)
    }

    fn cycle(period: f64, levels: &[f64], transitions: &[f64]) -> MeshCycle {
        let divisions = Division::levels(levels, transitions);
        MeshCycle::new(period, &divisions, &vec![0; divisions.len()], 0.1)
    }

    #[test]
    fn equal_neighbours_are_one_segment() {
        let cycle = cycle(1.0, &[2.0, 2.0, 2.0, 1.0, 1.0], &[]);
        assert_eq!(cycle.segments.len(), 2);
        assert_eq!(cycle.end(0), 0.6);
        assert_eq!(cycle.start(1), 0.6);
        assert_eq!(cycle.end(1), 1.0);
        assert!((cycle.mean_stiffness() - 1.6).abs() < 1e-15);
        assert_eq!(parts(&cycle, 4), None);
        assert_eq!(parts(&cycle, 10), Some(5));
        assert_eq!(cycle.segment_at(0.59).stiffness_at(0.59), 2.0);
        assert_eq!(cycle.segment_at(0.6).stiffness_at(0.6), 1.0);
        assert_eq!(cycle.segment_at(1.0), &cycle.segments[1]);
    }

    #[test]
    fn transitions_may_lie_anywhere() {
        let place = 1.0 / 2f64.sqrt();
        let uneven = cycle(2.0, &[3.0, 1.0], &[place]);
        assert_eq!((uneven.start(0), uneven.end(0)), (0.0, 2.0 * place));
        assert_eq!((uneven.start(1), uneven.end(1)), (2.0 * place, 2.0));
        assert!((uneven.mean_stiffness() - (1.0 + 2.0 * place)).abs() < 1e-15);
        assert_eq!(parts(&uneven, 10_000), None);
        let equal = cycle(2.0, &[3.0, 3.0], &[place]);
        assert_eq!(equal.segments.len(), 1);
        assert_eq!(parts(&equal, 1), Some(1));
    }

    #[test]
    fn a_change_of_direction_or_a_slope_starts_a_segment() {
        let mut divisions = Division::levels(&[2.0; 4], &[]);
        let turned = MeshCycle::new(1.0, &divisions, &[0, 0, 1, 1], 0.1);
        assert_eq!(turned.segments.len(), 2);
        let slope = Stiffness::series([2.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        divisions[1].stiffness = slope;
        divisions[2].stiffness = slope;
        let sloping = MeshCycle::new(1.0, &divisions, &[0; 4], 0.1);
        assert_eq!(sloping.segments.len(), 4);
        assert_eq!(sloping.segments[1].stiffness_at(0.5), 2.5);
        assert_eq!(sloping.segments[2].stiffness_at(0.5), 1.5);
        assert_eq!(sloping.mean_stiffness(), 2.0);
    }

    /// Compares with differences of `stiffness_at` and `error_at`, on a segment in the middle of the cycle.
    #[test]
    fn bends_are_differences_of_the_courses() {
        let mut divisions = Division::levels(&[4e8; 3], &[0.3, 0.7]);
        divisions[1].stiffness = Stiffness::series([4e8, 3e7, -1e7, 4e6, 0.0, 0.0, 0.0, 0.0]);
        let mut cycle = MeshCycle::new(1.0, &divisions, &[0; 3], 0.1);
        let error = FlankError::series([1e-6, 2e-6, -3e-6, 1e-6, 0.0, 0.0, 0.0, 0.0]);
        let segment = &mut cycle.segments[1];
        segment.error = error;
        let step = 1e-4;
        for phase in [0.35, 0.5, 0.68] {
            let stiffness = |at: f64| segment.stiffness_at(at);
            let difference = (stiffness(phase + step) - stiffness(phase - step)) / (2.0 * step);
            let [before, after] = [-step, step].map(|s| segment.error_at(phase + s)[1]);
            let [stiffening, curvature] = segment.bends_at(phase);
            assert!((stiffening / difference - 1.0).abs() < 1e-5);
            assert!((curvature * 2.0 * step / (after - before) - 1.0).abs() < 1e-5);
        }
    }
}
