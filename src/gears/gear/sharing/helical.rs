//! A helical face: the position of a pair on the line of action varies along the face.
//!
//! At z from mid-face the pairs are `z tan β_b` further along than at mid-face. Each thin slice is a spur
//! pair that is ahead in phase, and the force is the integral over the slices. Their load is smooth in z
//! except where a pair comes within reach or leaves it, passes an end of the path, the pitch point or a kink
//! of its law. The face is cut at these positions, which move uniformly with the mesh phase. Each stretch
//! between cuts has the same number of spans at every phase. The error falls with the square of the width of
//! spans, and so does not jump while the cuts move across the face.

use super::pairs::{self, Face, FaceSlice, PairPoint};
use super::ramp::{self, ContactRamp, Station};
use super::{LoadSharing, MOST_PAIRS, SharingError, check_misalignment};
use crate::gear::{FlankLaw, PathOfContact};

/// Load on stretches narrower than this part of the face is negligible.
const NARROW: f64 = 1e-12;

/// Relative change of line loads at convergence.
const SETTLED: f64 = 1e-9;

/// Relative width of a bracket of line loads at convergence, if they do not repeat.
const ENCLOSED: f64 = 1e-6;

/// Largest number of rounds for a contact that depends on its load.
const ROUNDS: usize = 50;

/// The lines of contact on a helical face at one mesh phase.
#[derive(Debug, Clone)]
pub struct HelicalFace {
    face: Face,
    path: PathOfContact,
    stretches: Vec<Stretch>,
}

/// A part of the face between two cuts.
#[derive(Debug, Clone)]
struct Stretch {
    /// Positions at the ends and in the middle of its spans, from mid-face \[m\].
    places: Vec<f64>,
    /// Number of pairs at each position.
    pairs: usize,
    /// The pairs, position by position, the latest first.
    points: Vec<PairPoint>,
}

impl HelicalFace {
    /// The lines of contact of a law with [`FlankLaw::helix`] at a mesh phase. The face is divided
    /// into about as many spans as `face` has slices.
    ///
    /// # Errors
    /// A position without a pair or with more than [`MOST_PAIRS`], a face without width or slices, those
    /// of [`ContactPair::new`](super::ContactPair::new).
    pub fn new(law: &impl FlankLaw, phase: f64, face: Face) -> Result<Self, SharingError> {
        let point = |position: f64, ahead: usize| PairPoint::new(law, position, ahead);
        Self::of_points(law, &point, phase, face)
    }

    /// As [`Self::new`]; `point` computes the pair at a position, given the number of pairs ahead of it.
    pub(in crate::gear) fn of_points(
        law: &impl FlankLaw,
        point: &impl Fn(f64, usize) -> PairPoint,
        phase: f64,
        face: Face,
    ) -> Result<Self, SharingError> {
        face.check()?;
        let (helix, [first, last]) = (law.helix(), law.reach());
        let (cuts, parts) = cuts(law, phase, face);
        let mut stretches = Vec::with_capacity(cuts.len());
        for ends in cuts.windows(2) {
            let [from, to] = [ends[0], ends[1]];
            if to - from <= NARROW * face.width {
                continue;
            }
            let middle = 0.5 * (from + to);
            let positions = positions(law, phase, middle)?;
            let half = (to - from) / (2 * parts) as f64;
            let places: Vec<f64> = (0..=2 * parts).map(|n| from + half * n as f64).collect();
            let mut points = Vec::with_capacity(places.len() * positions.len());
            for &place in &places {
                for (index, &position) in positions.iter().enumerate() {
                    let s = (position + helix * (place - middle)).clamp(first, last);
                    let mut pair = point(s, positions.len() - 1 - index);
                    pair.missing += law.deviation(s, place);
                    pair.check(&[pair.missing])?;
                    points.push(pair);
                }
            }
            stretches.push(Stretch {
                places,
                pairs: positions.len(),
                points,
            });
        }
        let path = law.path();
        Ok(Self {
            face,
            path,
            stretches,
        })
    }

    /// The load on the face at a misalignment \[rad\]; the gap grows with z.
    ///
    /// # Errors
    /// As [`LoadSharing::new`].
    pub fn sharing(&self, misalignment: f64) -> Result<LoadSharing, SharingError> {
        check_misalignment(misalignment, self.position())?;
        let unit = self.face.width / self.face.slices as f64;
        let on_path = |s: f64| s >= self.path.start && s <= self.path.end;
        let mut ramps: Vec<ContactRamp> = Vec::new();
        let mut spans = Vec::new();
        for Stretch {
            places,
            pairs,
            points,
        } in &self.stretches
        {
            let inside = &points[places.len() / 2 * pairs..][..*pairs];
            let at = |(points, &place)| Station::new(points, place, misalignment, inside);
            let stations: Vec<Station> = (points.chunks_exact(*pairs).zip(places))
                .map(at)
                .collect::<Result<_, _>>()?;
            for from in (0..places.len() - 1).step_by(2) {
                let three = [from, from + 1, from + 2].map(|index| &stations[index]);
                ramp::add_span(&mut ramps, three, (spans.len(), *pairs), unit);
                let middle = &points[(from + 1) * pairs..][..*pairs];
                let positions = std::array::from_fn(|pair| middle[pair.min(pairs - 1)].position);
                spans.push(FaceSlice {
                    ends: [places[from], places[from + 2]],
                    pairs: *pairs,
                    positions,
                    on_path: positions.map(on_path),
                });
            }
        }
        let mut knots: Vec<f64> = ramps.iter().flat_map(|r| [r.low, r.high]).collect();
        knots.sort_unstable_by(f64::total_cmp);
        Ok(LoadSharing {
            // Unused here: spans have this for each pair.
            on_path: [true; MOST_PAIRS],
            face: self.face,
            pairs: spans.iter().map(|span| span.pairs).max().unwrap_or(0),
            ramps,
            spans,
            knots,
            even: false,
            line_load_excess: [1.0; MOST_PAIRS],
            coupled: None,
        })
    }

    /// Position of a pair, for messages \[m\].
    fn position(&self) -> f64 {
        self.stretches[0].points[0].position
    }

    /// As [`Self::sharing`], with the contact of all pairs linearised at the mean line load under a force > 0
    /// \[N\] on the lines of contact. Valid for that force only.
    ///
    /// # Errors
    /// As [`LoadSharing::under`].
    pub fn sharing_under(
        mut self,
        law: &impl FlankLaw,
        misalignment: f64,
        force: f64,
    ) -> Result<LoadSharing, SharingError> {
        let mut line_load = force / self.face.width;
        // The loaded length steps where pairs swap their order of contact. If the solution is at such a step,
        // this bracket encloses it.
        let mut bracket = [0.0, f64::INFINITY];
        for _ in 0..ROUNDS {
            for point in self.stretches.iter_mut().flat_map(|part| &mut part.points) {
                point.linearise(law, line_load)?;
            }
            let sharing = self.sharing(misalignment)?;
            let (_, lengths) = sharing.distribute_with_lengths(force);
            let next = force / lengths.iter().sum::<f64>();
            bracket[usize::from(next < line_load)] = line_load;
            let [low, high] = bracket;
            let settled = (next - line_load).abs() <= SETTLED * line_load;
            if settled || high - low <= ENCLOSED * line_load {
                return Ok(sharing);
            }
            let within = next > low && next < high;
            line_load = if within { next } else { 0.5 * (low + high) };
        }
        let position = self.position();
        Err(SharingError::Unsettled { position })
    }
}

impl LoadSharing {
    /// Positions on the line of action of the pairs on each span of a helical face \[m\], and their shares in
    /// the load at an approach.
    pub fn lines(&self, approach: f64) -> [Vec<f64>; 2] {
        let slice_shares = self.shares_along(approach);
        let spans = (self.spans.iter().zip(&slice_shares)).flat_map(|(span, shares)| {
            let positions = span.positions.into_iter().take(span.pairs);
            positions.zip(shares.iter().copied())
        });
        let (positions, shares) = spans.unzip();
        [positions, shares]
    }

    /// Positions z \[m\] on a helical face where a pair carries more than a share of the load at an approach. With each
    /// z comes the position of this pair on the path of contact \[m\].
    pub(in crate::gear) fn loaded_lines(
        &self,
        approach: f64,
        least: f64,
    ) -> impl Iterator<Item = [f64; 2]> {
        let slice_shares = self.shares_along(approach);
        self.spans
            .iter()
            .zip(slice_shares)
            .flat_map(move |(span, shares)| {
                let middle = 0.5 * (span.ends[0] + span.ends[1]);
                (span.positions.iter().zip(shares))
                    .filter(move |(_, share)| *share > least)
                    .map(move |(&position, _)| [middle, position])
            })
    }

    /// The share in the load of each pair on each span of a helical face at an approach.
    fn shares_along(&self, approach: f64) -> Vec<[f64; MOST_PAIRS]> {
        let mut loads: Vec<[f64; MOST_PAIRS]> = vec![[0.0; MOST_PAIRS]; self.spans.len()];
        for ramp in &self.ramps {
            let mean = ramp.state_at(approach).mean;
            for (load, stiffness) in loads[ramp.slice].iter_mut().zip(&ramp.stiffness) {
                *load += stiffness * mean;
            }
        }
        let total: f64 = loads.iter().flatten().sum();
        let share = |load: f64| if total > 0.0 { load / total } else { 0.0 };
        loads.iter().map(|loads| loads.map(share)).collect()
    }
}

/// Cuts of the face, ends included and in order \[m\], and the number of spans per stretch.
/// The number of cuts on the face changes with the phase, the number of spans per stretch does not.
fn cuts(law: &impl FlankLaw, phase: f64, face: Face) -> (Vec<f64>, usize) {
    let (path, helix, [first, last]) = (law.path(), law.helix(), law.reach());
    let half = 0.5 * face.width;
    // Phase difference between the pairs at an end of the face and those at mid-face, in cycles.
    let ahead = helix.abs() * half / path.base_pitch;
    let mut marks: Vec<f64> = (law.kinks().into_iter())
        .chain([path.start, path.end, path.pitch_point])
        .filter(|s| *s > first && *s < last)
        .chain([first, last])
        .collect();
    marks.sort_unstable_by(f64::total_cmp);
    marks.dedup();
    let most = marks.len() * (2.0 * ahead).ceil() as usize;
    let mut cuts = vec![-half, half];
    for mark in marks {
        // Number of the pair that is at the mark at mid-face; not an integer in general.
        let pair = (mark - path.start) / path.base_pitch - phase;
        let (low, high) = ((pair - ahead).ceil() as i64, (pair + ahead).floor() as i64);
        for number in low..=high {
            let place = (pair - number as f64) * path.base_pitch / helix;
            cuts.push(place.clamp(-half, half));
        }
    }
    cuts.sort_unstable_by(f64::total_cmp);
    (cuts, face.slices.div_ceil(most + 1))
}

/// Positions of the pairs on the line of action \[m\] at a place on the face; the pair that entered contact last comes
/// first.
fn positions(law: &impl FlankLaw, phase: f64, place: f64) -> Result<Vec<f64>, SharingError> {
    let ahead = phase + law.helix() * place / law.path().base_pitch;
    let positions = pairs::positions(law, ahead.rem_euclid(1.0));
    match positions.len() {
        0 => Err(SharingError::NoPair),
        found if found > MOST_PAIRS => Err(SharingError::TooManyPairs { found }),
        _ => Ok(positions),
    }
}
