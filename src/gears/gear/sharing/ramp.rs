//! One slice of one pair as a spring whose contact spreads from one border to the other.

use super::error::{MOST_PAIRS, SharingError};
use super::pairs::{ContactPair, Face, FacePosition};
use crate::numerics::linalg::invert;

/// Gaps of two pairs are equal if they differ by less than this part of them.
const SAME_GAP: f64 = 8.0 * f64::EPSILON;

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

/// Adds one ramp for each of the first pairs that come into contact on a slice, `most` at most.
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
    // Pairs with equal gaps come into contact together, not in an order due to rounding.
    let gaps = || pairs.iter().map(|pair| pair.mean_gap(slice).abs());
    let rounding = SAME_GAP * gaps().fold(0.0, f64::max);
    let mut sequence = ContactSequence::new(pairs, |pair| {
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

/// Adds one ramp for each pair on a span of a helical face, from the pairs at its two ends and at its
/// middle.
///
/// At either end of the span a pair comes into contact at the approach for that position. Its stiffness is the mean,
/// by Simpson's rule, of its additional stiffness at the three positions. Neighbouring spans share
/// an end: the border of the contact moves across it without a step.
pub(super) fn add_span(
    ramps: &mut Vec<ContactRamp>,
    stations: &[FacePosition; 3],
    slice: usize,
    unit: f64,
    misalignment: f64,
) -> Result<(), SharingError> {
    let [from, _, to] = stations;
    let width = to.place - from.place;
    let count = from.pairs.len();
    let mut knots = [[0.0; MOST_PAIRS]; 3];
    let mut stiffness = [[0.0; MOST_PAIRS]; MOST_PAIRS];
    for ((station, knots), weight) in stations.iter().zip(&mut knots).zip([1.0, 4.0, 1.0]) {
        let slope = misalignment * station.place;
        let mut sequence =
            ContactSequence::new(&station.pairs, |p| slope + station.pairs[p].gap(0));
        for _ in 0..count {
            let before = sequence.gain;
            let pair = sequence.next()?;
            knots[pair] = sequence.knot;
            for (sum, (after, before)) in
                (stiffness[pair].iter_mut()).zip(sequence.gain.iter().zip(before))
            {
                *sum += width * weight / 6.0 * (after - before);
            }
        }
    }
    for (pair, stiffness) in stiffness.into_iter().enumerate().take(count) {
        let ends = [(knots[0][pair], from.place), (knots[2][pair], to.place)];
        let [(low, low_place), (high, high_place)] =
            if ends[0].0 <= ends[1].0 { ends } else { [ends[1], ends[0]] };
        ramps.push(ContactRamp {
            slice,
            pair,
            part: width / unit,
            low,
            high,
            low_place,
            high_place,
            stiffness,
        });
    }
    Ok(())
}

/// Pairs that come into contact as the gears approach, at one position of the face.
struct ContactSequence<'a> {
    pairs: &'a [ContactPair],
    /// Compliances times width \[m²/N\].
    compliance: [[f64; MOST_PAIRS]; MOST_PAIRS],
    /// Gap of each pair \[m\].
    offset: [f64; MOST_PAIRS],
    joined: [bool; MOST_PAIRS],
    /// Approach at which the last pair came into contact \[m\].
    knot: f64,
    /// Line loads at the knot \[N/m\].
    load: [f64; MOST_PAIRS],
    /// Derivatives of the line loads by the approach beyond the knot \[N/m²\].
    gain: [f64; MOST_PAIRS],
}

impl<'a> ContactSequence<'a> {
    fn new(pairs: &'a [ContactPair], offset: impl Fn(usize) -> f64) -> Self {
        let mut compliance = [[0.0; MOST_PAIRS]; MOST_PAIRS];
        for (i, pair) in pairs.iter().enumerate() {
            compliance[i][i] = pair.compliance();
            for (j, &coupling) in (i + 1..pairs.len()).zip(&pair.coupling) {
                compliance[i][j] = coupling;
                compliance[j][i] = coupling;
            }
        }
        let count = pairs.len();
        Self {
            pairs,
            compliance,
            offset: std::array::from_fn(|pair| if pair < count { offset(pair) } else { 0.0 }),
            joined: [false; MOST_PAIRS],
            knot: 0.0,
            load: [0.0; MOST_PAIRS],
            gain: [0.0; MOST_PAIRS],
        }
    }

    /// The next pair to come into contact. Sets knot, loads and gains to those at its contact.
    fn next(&mut self) -> Result<usize, SharingError> {
        // A pair's gap closes by the approach less its displacement by the others' loads.
        let pushed = |pair: usize, loads: &[f64; MOST_PAIRS]| -> f64 {
            let terms = self.compliance[pair].iter().zip(loads);
            terms.map(|(c, q)| c * q).sum()
        };
        let first = !self.joined.contains(&true);
        let next = (0..self.pairs.len())
            .filter(|&pair| !self.joined[pair])
            .filter_map(|pair| {
                if first {
                    return Some((pair, self.offset[pair]));
                }
                let closing = 1.0 - pushed(pair, &self.gain);
                let open = self.offset[pair] + pushed(pair, &self.load) - self.knot;
                (closing > 0.0).then(|| (pair, self.knot + open.max(0.0) / closing))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let position = self.pairs[0].position;
        let (pair, knot) = next.ok_or(SharingError::Coupling { position })?;
        for (load, gain) in self.load.iter_mut().zip(&self.gain) {
            *load += gain * (knot - self.knot);
        }
        self.knot = knot;
        self.joined[pair] = true;
        self.gain = self.gains();
        let gaining = (0..self.pairs.len()).all(|p| !self.joined[p] || self.gain[p] > 0.0);
        let position = self.pairs[pair].position;
        gaining
            .then_some(pair)
            .ok_or(SharingError::Coupling { position })
    }

    /// Derivatives of the line loads of the joined pairs by the approach: `C⁻¹ 1` among them.
    fn gains(&self) -> [f64; MOST_PAIRS] {
        let mut joined = (0..MOST_PAIRS).filter(|&pair| self.joined[pair]);
        if let (Some(alone), None) = (joined.next(), joined.next()) {
            let gain = 1.0 / self.compliance[alone][alone];
            return std::array::from_fn(|pair| if pair == alone { gain } else { 0.0 });
        }
        let scale = self.compliance[0][0];
        // The others are decoupled by a diagonal entry.
        let among: [[f64; MOST_PAIRS]; MOST_PAIRS] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                if self.joined[i] && self.joined[j] {
                    self.compliance[i][j] / scale
                } else {
                    f64::from(u8::from(i == j))
                }
            })
        });
        let inverse = invert(&among);
        std::array::from_fn(|i| {
            let row = (0..MOST_PAIRS).filter(|&j| self.joined[i] && self.joined[j]);
            row.map(|j| inverse[i][j] / scale).sum()
        })
    }
}
