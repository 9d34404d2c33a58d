//! Where does friction reverse within the mesh cycle if pairs of teeth share the load evenly?

use super::EvenSharing;
use super::even_sharing::SAME_END;
use crate::model::Division;

impl EvenSharing {
    /// Cuts the divisions of a mesh where the friction of these pairs reverses or steps. Each part has the mean
    /// friction of its stretch between two such phases. For spur pairs the direction is constant there, so its mean is
    /// exact.
    pub fn cut(&self, mesh: &[Division]) -> Vec<Division> {
        let stretches = self.direction_breaks(SAME_END);
        let starts = || std::iter::once(&0.0).chain(&stretches);
        let friction: Vec<[f64; 2]> = (starts().zip(&stretches))
            .map(|(&from, &to)| self.mean([from, to]))
            .map(|mean| [mean.direction, mean.lever])
            .collect();
        let mut cut = Self::cut_at(mesh, &stretches);
        let mut start = 0.0;
        for division in &mut cut {
            let middle = 0.5 * (start + division.end);
            division.friction = friction[stretches.partition_point(|stretch| *stretch < middle)];
            start = division.end;
        }
        cut
    }

    /// Cuts divisions at phases, given in order.
    pub(super) fn cut_at(mesh: &[Division], phases: &[f64]) -> Vec<Division> {
        let mut cut = Vec::with_capacity(mesh.len() + phases.len());
        let mut start = 0.0;
        for division in mesh {
            let inside = |end: &f64| *end > start + SAME_END && *end < division.end - SAME_END;
            let place = |phase: f64| 2.0 * (phase - start) / (division.end - start) - 1.0;
            let mut from = start;
            for end in (phases.iter().copied().filter(inside)).chain([division.end]) {
                let part = [from, end].map(place);
                cut.push(Division {
                    end,
                    stiffness: division.stiffness.part(part[0], part[1]),
                    error: division.error.part(part[0], part[1]),
                    ..*division
                });
                from = end;
            }
            start = division.end;
        }
        cut
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::model::Stiffness;

    /// A pair enters at 0, passes the pitch point at 0.75 and leaves at 1.6.
    pub const PAIRS: EvenSharing = EvenSharing {
        pitch_phase: 0.75,
        contact_ratio: 1.6,
        overlap_ratio: 0.0,
        base_pitch: 12e-3,
        inclination: 1.0,
    };

    fn ends(divisions: &[Division]) -> Vec<f64> {
        divisions.iter().map(|division| division.end).collect()
    }

    /// The stiffness continues across the cuts, and the direction is constant between them.
    #[test]
    fn divisions_are_cut_where_friction_turns() {
        let course = Stiffness::series([4e8, 3e7, -1e7, 4e6, 0.0, 0.0, 0.0, 0.0]);
        let whole = Division {
            stiffness: course,
            ..Division::level(1.0, 4e8)
        };
        let cut = PAIRS.cut(&[whole]);
        assert_eq!(cut.len(), 3);
        let directions: Vec<f64> = cut.iter().map(|division| division.friction[0]).collect();
        assert_eq!(directions, [0.0, 1.0, -1.0]);
        // Two pairs one base pitch apart; then one pair, from 0.15 cycles before the pitch point to 0.25
        // after it.
        for (division, lever) in cut.iter().zip([-6e-3, -0.9e-3, -1.5e-3]) {
            assert!((division.friction[1] / lever - 1.0).abs() < 1e-12);
        }
        let mut start = 0.0;
        for division in &cut {
            for place in [-0.9, 0.2, 0.8] {
                let phase = 0.5 * (start + division.end + place * (division.end - start));
                let exact = course.at(2.0 * phase - 1.0);
                assert!((division.stiffness.at(place) / exact - 1.0).abs() < 1e-14);
            }
            start = division.end;
        }
    }

    /// A step of the stiffness at the exit of a pair coincides with a cut up to rounding, so there is one cut.
    #[test]
    fn a_step_of_the_stiffness_is_a_cut_of_friction() {
        let levels = Division::levels(&[4e8, 3e8], &[0.6]);
        assert_eq!(ends(&PAIRS.cut(&levels)), [0.6, 0.75, 1.0]);
        let segments = Division::levels(&vec![4e8; 60], &[]);
        assert_eq!(PAIRS.cut(&segments).len(), 60);
        let pitch = EvenSharing {
            pitch_phase: 0.7512,
            ..PAIRS
        };
        let segments = pitch.cut(&segments);
        assert_eq!(segments.len(), 61);
        // Equal segments between two cuts have the same friction, so only three different values are left.
        let mut different: Vec<[f64; 2]> =
            segments.iter().map(|segment| segment.friction).collect();
        different.dedup();
        assert_eq!(different.len(), 3);
    }

    /// Friction dissipates on both flanks of every division: Λ₁ < 0, and Λ₀ changes sign with the flank.
    #[test]
    fn the_coast_flank_is_the_mirror_image() {
        let drive = PAIRS.cut(&[Division::level(1.0, 4e8)]);
        let symmetry = 0.9;
        let coast = Division::mirrored(&drive, symmetry);
        let at = |divisions: &[Division], phase: f64| {
            let phase = phase.rem_euclid(1.0);
            let found = divisions
                .iter()
                .find(|division| phase < division.end)
                .unwrap();
            found.friction
        };
        for ahead in [-0.4, -0.2, -0.13, 0.03, 0.12, 0.28, 0.45] {
            let [turn, lever] = at(&drive, symmetry - ahead);
            assert_eq!(at(&coast, symmetry + ahead), [-turn, lever], "{ahead}");
        }
    }
}
