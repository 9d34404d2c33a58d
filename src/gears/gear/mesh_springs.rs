//! The mesh at any load: every pair of teeth, on every slice of the face, is a spring across a separate gap.
//!
//! At a mesh phase the force that presses gears together is piecewise linear in their approach x. Each pair
//! adds stiffness once x exceeds the approach at which the pair comes into contact ([`LoadSharing`]). The
//! force is
//!
//! ```text
//! F(x) = Σ_l k_l max(0, x − g_l)
//! ```
//!
//! exactly, even if bodies couple pairs: k_l is the stiffness that the l-th pair adds, g_l the approach at which
//! it comes into contact. A mesh is then a set of parallel one-sided contacts. Their stiffness and gap depend on
//! the mesh phase but not on the load. If two pairs swap their order of contact their gaps are equal, so the
//! force does not step.
//!
//! Slices are independent here, so each has separate springs. The gap of a slice is that of its middle: misaligned
//! flanks close slice by slice, with an error of second order in the width of a slice.

use super::mesh_table::{EXTRAPOLATED_AT, EXTRAPOLATION_LIMITS, MeshTableError, breaks};
use super::sharing::{Face, LoadSharing, MOST_PAIRS, PairSpring, pairs_at};
use super::{FlankLaw, NODES, friction_direction};
use crate::numerics::legendre::{evaluate, transforms8};

/// Largest length of a stretch, in mesh cycles.
const LONGEST_STRETCH: f64 = 0.25;

/// Largest error of the interpolated stiffness, as a part of this stiffness, and of a gap, relative to [`GAP_SCALE`].
const TOLERANCE: f64 = 1e-9;

/// Reference for errors of a gap \[m\]: typical deflections of loaded teeth.
const GAP_SCALE: f64 = 1e-5;

/// Gaps closer than this \[m\] are equal: only round-off separates them.
const SAME_GAP: f64 = 1e-15;

/// Largest number of stretches of a cycle.
const MOST_STRETCHES: usize = 1024;

/// Smallest length of a stretch, in mesh cycles.
const SHORTEST: f64 = 1e-9;

/// The springs of a mesh over its cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSprings {
    /// Position of each slice along the face \[m\], from mid-face.
    pub centres: Vec<f64>,
    /// Stretches of the mesh cycle with the same pairs in the same order of contact, in order.
    pub stretches: Vec<SpringStretch>,
}

/// A stretch of the mesh cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct SpringStretch {
    /// Mesh phase at its end, in cycles.
    pub end: f64,
    /// The springs of each slice in their order of contact.
    pub springs: Vec<Vec<SpringPiece>>,
}

/// A spring over a stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpringPiece {
    /// Legendre series of its stiffness \[N/m\] over the stretch.
    pub stiffness: [f64; NODES],
    /// Legendre series of its gap \[m\].
    pub gap: [f64; NODES],
    /// Mean direction of friction Λ₀ \[1\] and its mean lever Λ₁ \[m\] per unit of the spring's force.
    pub friction: [f64; 2],
}

/// The springs at a phase.
struct PhaseSprings {
    phase: f64,
    springs: Vec<PairSpring>,
    /// One entry per spring.
    friction: Vec<[f64; 2]>,
}

impl PhaseSprings {
    /// The pairs in their order of contact, slice by slice.
    fn order(&self) -> impl Iterator<Item = usize> {
        self.springs.iter().map(|spring| spring.pair)
    }

    /// Whether pairs come into contact in the same order on each of `slices` slices. Pairs that come into contact
    /// together may have any order, because it depends on rounding.
    fn same_order(&self, other: &Self, slices: usize) -> bool {
        let on_slice = self.springs.len() / slices;
        if self.springs.len() != other.springs.len() {
            return false;
        }
        let [own, others] = [self, other].map(|column| column.springs.chunks(on_slice));
        own.zip(others).all(|(own, other)| {
            let distance = |springs: &[PairSpring], [one, later]: [usize; 2]| {
                let gap = |pair| springs.iter().find(|s| s.pair == pair).map(|s| s.gap);
                gap(later).zip(gap(one)).map(|(b, a)| b - a)
            };
            let mut pairs = (own.iter().enumerate())
                .flat_map(|(i, one)| own[i + 1..].iter().map(|later| [one.pair, later.pair]));
            pairs.all(|pair| {
                let [here, there] = [own, other].map(|springs| distance(springs, pair));
                match (here, there) {
                    (Some(here), Some(there)) => here.min(there.abs()) <= SAME_GAP || there > 0.0,
                    _ => false,
                }
            })
        })
    }
}

impl MeshSprings {
    /// The springs of the pairs of a law on equal slices of a face, with flanks misaligned by `misalignment` \[rad\]
    /// in the plane of action.
    ///
    /// # Errors
    /// [`MeshTableError`]: the load cannot be shared, no polynomials follow the springs, or the
    /// gears are helical, whose slices each have separate pairs.
    pub fn new(law: &impl FlankLaw, face: Face, misalignment: f64) -> Result<Self, MeshTableError> {
        if law.helix() != 0.0 {
            return Err(MeshTableError::HelicalPairs { helix: law.helix() });
        }
        let pitch_point = law.path().pitch_point;
        let column = |phase: f64| -> Result<PhaseSprings, MeshTableError> {
            let sharing = |source| MeshTableError::Sharing { phase, source };
            let pairs = pairs_at(law, phase, face).map_err(sharing)?;
            let springs: Vec<PairSpring> = (LoadSharing::of_slices(&pairs, face, misalignment))
                .map_err(sharing)?
                .springs()
                .collect();
            let positions: Vec<f64> = pairs.iter().map(|p| p.position() - pitch_point).collect();
            let friction = (springs.iter())
                .map(|spring| friction_direction(&positions, &spring.share))
                .map(|friction| [friction.direction, friction.lever])
                .collect();
            Ok(PhaseSprings {
                phase,
                springs,
                friction,
            })
        };
        let cuts = breaks(law, face.width, LONGEST_STRETCH)?;
        let mut left: Vec<[f64; 2]> = cuts.windows(2).rev().map(|c| [c[0], c[1]]).collect();
        let mut stretches = Vec::new();
        while let Some([from, to]) = left.pop() {
            match check_piece(&column, [from, to], face.slices)? {
                FitResult::Follows(springs) => stretches.push(SpringStretch { end: to, springs }),
                FitResult::Cut(_, error)
                    if to - from < SHORTEST || left.len() + stretches.len() > MOST_STRETCHES =>
                {
                    return Err(MeshTableError::Unresolved {
                        quantity: "stiffness of a pair",
                        phase: from,
                        error,
                        tolerance: TOLERANCE,
                    });
                }
                FitResult::Cut(at, _) => left.extend([[at, to], [from, at]]),
            }
        }
        let width = face.width / face.slices as f64;
        let middle = |slice: usize| (slice as f64 + 0.5) * width - 0.5 * face.width;
        Ok(Self {
            centres: (0..face.slices).map(middle).collect(),
            stretches,
        })
    }

    /// Largest number of springs of one slice at one time.
    pub fn most(&self) -> usize {
        let counts = self
            .stretches
            .iter()
            .flat_map(|column| &column.springs)
            .map(Vec::len);
        counts.max().unwrap_or(0)
    }
}

/// Result of a fit to a stretch.
enum FitResult {
    /// The springs, as polynomials within the tolerance.
    Follows(Vec<Vec<SpringPiece>>),
    /// Phase at which the stretch must be cut, and the error of the polynomials.
    Cut(f64, f64),
}

fn check_piece(
    column: &impl Fn(f64) -> Result<PhaseSprings, MeshTableError>,
    [from, to]: [f64; 2],
    slices: usize,
) -> Result<FitResult, MeshTableError> {
    let transforms = transforms8();
    let phase = |x: f64| 0.5 * ((to - from) * x + (to + from));
    let inset = SHORTEST.min(0.125 * (to - from));
    let nodes: Vec<PhaseSprings> = (transforms.nodes().iter())
        .map(|&x| column(phase(x)))
        .collect::<Result<_, _>>()?;
    let between = transforms
        .nodes()
        .windows(2)
        .map(|pair| phase(0.5 * (pair[0] + pair[1])));
    let mut checks: Vec<PhaseSprings> = ([from + inset].into_iter().chain(between))
        .chain([to - inset])
        .map(column)
        .collect::<Result<_, _>>()?;
    let mut fitted_phases: Vec<&PhaseSprings> = nodes.iter().chain(&checks).collect();
    fitted_phases.sort_by(|a, b| a.phase.total_cmp(&b.phase));
    if let Some(pair) = fitted_phases
        .windows(2)
        .find(|pair| !pair[0].same_order(pair[1], slices))
    {
        let [mut low, mut high] = [pair[0].phase, pair[1].phase];
        while high - low > 4.0 * f64::EPSILON {
            let middle = 0.5 * (low + high);
            if column(middle)?.same_order(pair[0], slices) {
                low = middle
            } else {
                high = middle
            }
        }
        return Ok(FitResult::Cut(0.5 * (low + high), f64::INFINITY));
    }
    // Pairs that come into contact together may do so in another order, with the same total stiffness. A check can
    // be compared spring by spring only if its pairs have the order of those at the nodes.
    checks.retain(|check| check.order().eq(nodes[0].order()));
    let count = nodes[0].springs.len();
    let through = |value: &dyn Fn(&PhaseSprings) -> f64| -> [f64; NODES] {
        transforms.interpolate(&std::array::from_fn(|node| value(&nodes[node])))
    };
    let mut error: f64 = 0.0;
    let pieces: Vec<SpringPiece> = (0..count)
        .map(|spring| {
            let stiffness = through(&|column| column.springs[spring].stiffness);
            let gap = through(&|column| column.springs[spring].gap);
            let [turn, lever] = [0, 1].map(|part| through(&|c| c.friction[spring][part])[0]);
            for check in &checks {
                let x = (2.0 * check.phase - from - to) / (to - from);
                let spring = &check.springs[spring];
                let off = (evaluate(&stiffness, x) / spring.stiffness - 1.0).abs();
                error = error.max(off);
                error = error.max((evaluate(&gap, x) - spring.gap).abs() / GAP_SCALE);
            }
            // A window of propagation that starts in this stretch may extend beyond its end.
            let end = evaluate(&stiffness, 1.0);
            let [least, most] = EXTRAPOLATION_LIMITS.map(|part| part * end);
            let inside = |x: &f64| (least..=most).contains(&evaluate(&stiffness, *x));
            if !EXTRAPOLATED_AT.iter().all(inside) {
                error = f64::INFINITY;
            }
            SpringPiece {
                stiffness,
                gap,
                friction: [turn, lever],
            }
        })
        .collect();
    if error > TOLERANCE {
        return Ok(FitResult::Cut(0.5 * (from + to), error));
    }
    // Every slice has the same number of springs, because the same pairs are within reach.
    let on_slice = count / slices;
    debug_assert!(on_slice <= MOST_PAIRS);
    Ok(FitResult::Follows(
        pieces.chunks(on_slice).map(joined_at_once).collect(),
    ))
}

/// Merges springs of a slice that always come into contact together: on flanks without missing material two
/// pairs touch at the same approach.
fn joined_at_once(springs: &[SpringPiece]) -> Vec<SpringPiece> {
    let mut out: Vec<SpringPiece> = Vec::new();
    for spring in springs {
        let same = |last: &SpringPiece| {
            let mut gaps = last.gap.iter().zip(&spring.gap);
            gaps.all(|(a, b)| (a - b).abs() <= SAME_GAP)
        };
        match out.last_mut().filter(|last| same(last)) {
            None => out.push(*spring),
            Some(last) => {
                let [own, other] = [last.stiffness[0], spring.stiffness[0]];
                for (sum, k) in last.stiffness.iter_mut().zip(&spring.stiffness) {
                    *sum += k;
                }
                for (mean, value) in last.friction.iter_mut().zip(spring.friction) {
                    *mean = (own * *mean + other * value) / (own + other);
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::gear::fixtures::pair;
    use crate::gear::{Flanks, Modification, Relief, ReliefCourse, ToothForm};

    fn relieved() -> Flanks {
        let relief = Relief {
            amount: 10e-6,
            length: 2e-3,
            ..Relief::default()
        };
        let form = ToothForm {
            tip_relief: [relief; 2],
            bore: [Some(48e-3), Some(76e-3)],
            ..ToothForm::default()
        };
        Flanks::new(&pair([20, 30], form)).unwrap()
    }

    /// At any phase and load the springs carry the load of load sharing, with the same stiffness.
    #[test]
    fn springs_bear_what_the_pairs_share() {
        let flanks = relieved();
        let face = Face {
            width: 20e-3,
            slices: 1,
        };
        let springs = MeshSprings::new(&flanks, face, 0.0).unwrap();
        assert!(springs.most() >= 2);
        for step in 0..97 {
            let phase = (f64::from(step) + 0.37) / 97.0;
            let pairs = pairs_at(&flanks, phase, face).unwrap();
            let sharing = LoadSharing::new(&pairs, face, 0.0).unwrap();
            let index = springs.stretches.partition_point(|own| own.end <= phase);
            let from = if index == 0 { 0.0 } else { springs.stretches[index - 1].end };
            let stretch = &springs.stretches[index];
            let x = (2.0 * phase - from - stretch.end) / (stretch.end - from);
            for force in [10.0, 300.0, 2e3, 2e4] {
                let shared = sharing.distribute(force);
                let (mut sum, mut stiffness) = (0.0, 0.0);
                for spring in &stretch.springs[0] {
                    let closing = shared.deflection - evaluate(&spring.gap, x);
                    if closing > 0.0 {
                        let own = evaluate(&spring.stiffness, x);
                        sum += own * closing;
                        stiffness += own;
                    }
                }
                assert!((sum / force - 1.0).abs() < 1e-6, "{phase} {force}: {sum}");
                assert!(
                    (stiffness / shared.stiffness - 1.0).abs() < 1e-8,
                    "{phase} {force}"
                );
            }
        }
    }

    #[test]
    fn helical_gears_are_refused() {
        let mut pair = relieved().pair.clone();
        pair.helix_angle = 0.2;
        let flanks = Flanks::new(&pair).unwrap();
        let face = Face {
            width: 20e-3,
            slices: 1,
        };
        let helix = flanks.base_helix_angle.tan();
        let refused = MeshSprings::new(&flanks, face, 0.0);
        assert_eq!(refused, Err(MeshTableError::HelicalPairs { helix }));
    }

    /// Misaligned flanks: the error of the force over the approach falls with the square of the slice width.
    #[test]
    fn slices_close_a_wedge_with_second_order() {
        let flanks = relieved();
        let whole = Face {
            width: 20e-3,
            slices: 1,
        };
        let (phase, misalignment) = (0.7, 1e-3);
        let exact = LoadSharing::of_slices(
            &pairs_at(&flanks, phase, whole).unwrap(),
            whole,
            misalignment,
        );
        let shared = exact.unwrap().distribute(2e3);
        let off = |slices: usize| {
            let face = Face { slices, ..whole };
            let springs = MeshSprings::new(&flanks, face, misalignment).unwrap();
            let index = springs.stretches.partition_point(|own| own.end <= phase);
            let from = if index == 0 { 0.0 } else { springs.stretches[index - 1].end };
            let stretch = &springs.stretches[index];
            let x = (2.0 * phase - from - stretch.end) / (stretch.end - from);
            let forces = stretch.springs.iter().flatten().map(|spring| {
                evaluate(&spring.stiffness, x)
                    * (shared.deflection - evaluate(&spring.gap, x)).max(0.0)
            });
            (forces.sum::<f64>() / 2e3 - 1.0).abs()
        };
        // The error depends on the position of the wedge's end in a slice: take the worst of neighbouring divisions.
        let worst = |around: usize| (around..around + 4).map(off).fold(0.0, f64::max);
        let [coarse, fine] = [worst(8), worst(32)];
        assert!(fine < coarse / 8.0, "{coarse} {fine}");
    }

    /// At the start of a parabolic relief two pairs have equal gaps up to rounding: this creates no extra stretch.
    #[test]
    fn rounding_cuts_no_stretches() {
        let mut pair = relieved().pair.clone();
        for relief in &mut pair.form.tip_relief {
            relief.course = ReliefCourse::Parabolic;
        }
        for slope in [0.0, 0.4e-6, 3e-6] {
            pair.form.lead[0].slope = slope;
            let flanks = Flanks::new(&pair).unwrap();
            let face = Face {
                width: 20e-3,
                slices: 2,
            };
            let springs = MeshSprings::new(&flanks, face, 0.0).unwrap();
            let ends = springs.stretches.iter().map(|own| own.end);
            let starts = [0.0].into_iter().chain(ends.clone());
            let shortest = ends.zip(starts).map(|(end, start)| end - start);
            let shortest = shortest.fold(f64::INFINITY, f64::min);
            assert!(shortest > 1e-4, "{slope}: {shortest:e}");
        }
    }

    /// Crowned leads on slices: pairs with equal gaps come into contact together on each slice.
    #[test]
    fn crowned_leads_have_springs_of_their_own() {
        let mut pair = relieved().pair.clone();
        for amount in [0.1e-6, 1e-6, 5e-6] {
            pair.form.lead = [Modification {
                crowning: amount,
                slope: 0.0,
            }; 2];
            let flanks = Flanks::new(&pair).unwrap();
            for slices in [2, 3, 4] {
                let face = Face {
                    width: 20e-3,
                    slices,
                };
                let springs = MeshSprings::new(&flanks, face, 0.0).unwrap();
                assert!(springs.stretches.len() < 60, "{}", springs.stretches.len());
                let all = springs
                    .stretches
                    .iter()
                    .flat_map(|own| own.springs.iter().flatten());
                for spring in all {
                    for x in [-1.0, 0.3, 1.0, 2.0] {
                        let stiffness = evaluate(&spring.stiffness, x);
                        assert!((1e6..1e9).contains(&stiffness), "{stiffness:e}");
                    }
                }
            }
        }
    }
}
