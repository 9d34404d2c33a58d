//! One slice of one pair as a spring whose contact spreads from one border to the other.

use super::error::{MOST_PAIRS, SharingError};
use super::pairs::{ContactPair, Face, PairPoint};

/// Gaps of pairs are equal if they differ from their mean by less than this part of the largest gap.
const SAME_GAP: f64 = 8.0 * f64::EPSILON;

/// Pairs come into contact together if they do so at approaches that differ by less than this \[m\].
const TOGETHER: f64 = 1e-15;

/// A one-sided spring with a gap that is linear across its slice: without load up
/// to `low`, in full contact from `high` on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ContactRamp {
    pub slice: usize,
    /// The pair that comes into contact.
    pub pair: usize,
    /// Width, in slices.
    pub part: f64,
    /// Smallest and largest gap \[m\].
    pub low: f64,
    pub high: f64,
    /// Positions on the face with these gaps \[m\].
    low_place: f64,
    high_place: f64,
    /// Change of the stiffness of each pair by the contact of this pair \[N/m\].
    pub stiffness: [f64; MOST_PAIRS],
}

/// State of a ramp at an approach x. Means are over the slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RampState {
    /// Mean of `max(0, x − gap)` \[m\].
    pub mean: f64,
    /// Mean of `z max(0, x − gap)` \[m²\].
    pub moment: f64,
    /// Part in contact; the derivative of `mean` by x.
    pub engaged: f64,
    /// Derivative of `engaged` towards larger x \[1/m\].
    pub growth: f64,
}

impl ContactRamp {
    /// Total change of stiffness, the sum over the pairs \[N/m\].
    pub fn total(&self) -> f64 {
        self.stiffness.iter().sum()
    }

    /// State at approach x; on a knot, that to its right.
    pub fn state_at(&self, x: f64) -> RampState {
        let span = self.high - self.low;
        if x >= self.high {
            let mean = (x - self.low) - 0.5 * span;
            let middle = 0.5 * (self.low_place + self.high_place);
            // Covariance of two linear functions.
            let skew = span * (self.high_place - self.low_place) / 12.0;
            return RampState {
                mean,
                moment: middle * mean - skew,
                engaged: 1.0,
                growth: 0.0,
            };
        }
        if x < self.low {
            return RampState {
                mean: 0.0,
                moment: 0.0,
                engaged: 0.0,
                growth: 0.0,
            };
        }
        let engaged = (x - self.low) / span;
        let mean = 0.5 * engaged * (x - self.low);
        // A triangle of load has its centroid at a third of its length.
        let centroid = self.low_place + (self.high_place - self.low_place) * engaged / 3.0;
        RampState {
            mean,
            moment: centroid * mean,
            engaged,
            growth: 1.0 / span,
        }
    }
}

/// Adds one ramp for each of the first `most` pairs that come into contact on a slice.
///
/// The pairs' mean gap, misalignment included, is linear and common to all; the deviation of a pair
/// from it is constant on the slice. With u the approach above that line, pairs come
/// into contact one after the other, and between two such knots all loads are linear in u.
pub(super) fn add_slice(
    ramps: &mut Vec<ContactRamp>,
    pairs: &[ContactPair],
    face: Face,
    slice: usize,
    misalignment: f64,
    most: usize,
) -> Result<(), SharingError> {
    let count = pairs.len() as f64;
    let [from, to] = [slice, slice + 1].map(|border| {
        let mean = pairs.iter().map(|p| p.gap(border)).sum::<f64>() / count;
        let place = face.border(border);
        (misalignment * place + mean, place)
    });
    let [(low, low_place), (high, high_place)] =
        if from.0 <= to.0 { [from, to] } else { [to, from] };
    let mean = pairs.iter().map(|p| p.mean_gap(slice)).sum::<f64>() / count;
    // Pairs with gaps that are equal up to rounding come into contact together.
    let gaps = || pairs.iter().map(|pair| pair.mean_gap(slice).abs());
    let rounding = SAME_GAP * gaps().fold(0.0, f64::max);
    let mut sequence = ContactSequence::new(pairs.iter().map(|pair| &pair.point), |pair| {
        let apart = pairs[pair].mean_gap(slice) - mean;
        if apart.abs() <= rounding { 0.0 } else { apart }
    });
    let width = face.width / face.slices as f64;
    for _ in pairs.iter().take(most) {
        let before = sequence.gain;
        let pair = sequence.next()?;
        ramps.push(ContactRamp {
            slice,
            pair,
            part: 1.0,
            low: low + sequence.knot,
            high: high + sequence.knot,
            low_place,
            high_place,
            stiffness: std::array::from_fn(|p| width * (sequence.gain[p] - before[p])),
        });
    }
    Ok(())
}

/// How the pairs come into contact at one position of a helical face.
pub(super) struct Station {
    /// Distance from mid-face \[m\].
    place: f64,
    /// Approach at which each pair comes into contact \[m\].
    knots: [f64; MOST_PAIRS],
    /// `[pair][other]`: change of the stiffness of `other` per width by the contact of `pair` \[N/m²\].
    gains: [[f64; MOST_PAIRS]; MOST_PAIRS],
}

impl Station {
    /// The station at a place of the face. `inside` has the pairs at another position of the same stretch.
    /// Their gaps there order pairs that come into contact together here. Where a relief ends, rounding alone
    /// would decide which of two equal gaps is smaller, but next to it the relieved pair has the larger gap.
    pub fn new(
        points: &[PairPoint],
        place: f64,
        misalignment: f64,
        inside: &[PairPoint],
    ) -> Result<Self, SharingError> {
        let gap = |pair: usize| misalignment * place + points[pair].gap();
        let mut sequence = ContactSequence::new(points.iter(), gap);
        for (order, point) in sequence.order.iter_mut().zip(inside) {
            *order = point.gap();
        }
        let mut station = Self {
            place,
            knots: [0.0; MOST_PAIRS],
            gains: [[0.0; MOST_PAIRS]; MOST_PAIRS],
        };
        for _ in points {
            let before = sequence.gain;
            let pair = sequence.next()?;
            station.knots[pair] = sequence.knot;
            station.gains[pair] = std::array::from_fn(|p| sequence.gain[p] - before[p]);
        }
        Ok(station)
    }
}

/// Adds one ramp for each pair on a span of a helical face, from the pairs at its two ends and at its
/// middle.
///
/// At either end of the span a pair comes into contact at the approach for that position. Its stiffness is the mean,
/// by Simpson's rule, of its additional stiffness at the three positions. Neighbouring spans share
/// an end: the border of the contact moves across it without a step.
pub(super) fn add_span(
    ramps: &mut Vec<ContactRamp>,
    [from, middle, to]: [&Station; 3],
    (slice, pairs): (usize, usize),
    unit: f64,
) {
    let width = to.place - from.place;
    for pair in 0..pairs {
        let ends = [from, to].map(|end| (end.knots[pair], end.place));
        let [(low, low_place), (high, high_place)] =
            if ends[0].0 <= ends[1].0 { ends } else { [ends[1], ends[0]] };
        let gains = [from, middle, to].map(|station| station.gains[pair]);
        ramps.push(ContactRamp {
            slice,
            pair,
            part: width / unit,
            low,
            high,
            low_place,
            high_place,
            stiffness: std::array::from_fn(|p| {
                width / 6.0 * (gains[0][p] + 4.0 * gains[1][p] + gains[2][p])
            }),
        });
    }
}

/// Pairs that come into contact as the gears approach, at one position of the face.
struct ContactSequence {
    pairs: usize,
    /// Position of each pair on the line of action \[m\].
    position: [f64; MOST_PAIRS],
    /// Compliances times width \[m²/N\].
    compliance: [[f64; MOST_PAIRS]; MOST_PAIRS],
    /// Gap of each pair \[m\].
    offset: [f64; MOST_PAIRS],
    /// Decides which of several pairs that come into contact together is first.
    order: [f64; MOST_PAIRS],
    joined: [bool; MOST_PAIRS],
    /// Inverse of the compliances among the joined pairs; 0 for the others \[N/m²\].
    inverse: [[f64; MOST_PAIRS]; MOST_PAIRS],
    /// Approach at which the last pair came into contact \[m\].
    knot: f64,
    /// Line loads at the knot \[N/m\].
    load: [f64; MOST_PAIRS],
    /// Derivatives of the line loads by the approach beyond the knot \[N/m²\].
    gain: [f64; MOST_PAIRS],
}

impl ContactSequence {
    fn new<'a>(
        points: impl ExactSizeIterator<Item = &'a PairPoint>,
        offset: impl Fn(usize) -> f64,
    ) -> Self {
        let none = [0.0; MOST_PAIRS];
        let mut sequence = Self {
            pairs: points.len(),
            position: none,
            compliance: [none; MOST_PAIRS],
            offset: none,
            order: none,
            joined: [false; MOST_PAIRS],
            inverse: [none; MOST_PAIRS],
            knot: 0.0,
            load: none,
            gain: none,
        };
        let pairs = sequence.pairs;
        for (i, point) in points.enumerate() {
            sequence.position[i] = point.position;
            sequence.offset[i] = offset(i);
            sequence.compliance[i][i] = point.compliance();
            for (j, &coupling) in (i + 1..pairs).zip(&point.coupling) {
                sequence.compliance[i][j] = coupling;
                sequence.compliance[j][i] = coupling;
            }
        }
        sequence
    }

    /// The index of the next pair to come into contact. Sets knot, loads and gains to those at its contact.
    fn next(&mut self) -> Result<usize, SharingError> {
        let first = self.joined == [false; MOST_PAIRS];
        let mut next: Option<(usize, f64, f64)> = None;
        for pair in (0..self.pairs).filter(|&pair| !self.joined[pair]) {
            // A pair's gap closes by the approach less its displacement by the others' loads.
            let closing = 1.0 - product(&self.compliance[pair], &self.gain);
            let open = self.offset[pair] + product(&self.compliance[pair], &self.load) - self.knot;
            let knot = if first { open } else { self.knot + open.max(0.0) / closing };
            let is_before = |(other, earliest, _): (usize, f64, f64)| {
                if (knot - earliest).abs() < TOGETHER {
                    self.order[pair] < self.order[other]
                } else {
                    knot < earliest
                }
            };
            if closing > 0.0 && next.is_none_or(is_before) {
                next = Some((pair, knot, closing));
            }
        }
        let position = self.position[0];
        let (pair, knot, closing) = next.ok_or(SharingError::Coupling { position })?;
        for (load, gain) in self.load.iter_mut().zip(&self.gain) {
            *load += gain * (knot - self.knot);
        }
        self.knot = knot;
        self.joined[pair] = true;
        self.join(pair, closing);
        let all_gain = (0..self.pairs).all(|p| !self.joined[p] || self.gain[p] > 0.0);
        let position = self.position[pair];
        all_gain
            .then_some(pair)
            .ok_or(SharingError::Coupling { position })
    }

    /// Adds a pair to the inverse of the compliances and to the gains, `C⁻¹ 1` among the joined pairs: with its
    /// couplings c to them and its own compliance d, `u = (C⁻¹ c, −1)` and `σ = d − c C⁻¹ c` the inverse grows by
    /// `u uᵀ/σ` (bordering). `closing` is `1 − c C⁻¹ 1`.
    fn join(&mut self, pair: usize, closing: f64) {
        let row = self.compliance[pair];
        let mut moved = self.inverse.map(|inverse| product(&inverse, &row));
        let own = (row[pair] - product(&row, &moved)).recip();
        moved[pair] = -1.0;
        for i in 0..MOST_PAIRS {
            self.gain[i] -= moved[i] * (closing * own);
            for j in 0..MOST_PAIRS {
                self.inverse[i][j] += moved[i] * (moved[j] * own);
            }
        }
    }
}

fn product(one: &[f64; MOST_PAIRS], other: &[f64; MOST_PAIRS]) -> f64 {
    let [a, b, c] = one;
    let [x, y, z] = other;
    a * x + b * y + c * z
}
