//! One slice of one pair as a spring whose contact spreads from one border to the other.

use super::{ContactPair, Face, MOST_PAIRS};

/// A one-sided spring with a gap that is a straight line across its slice: without load up
/// to `low`, in full contact from `high` on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ramp {
    pub slice: usize,
    /// Smallest and largest gap \[m\].
    pub low: f64,
    pub high: f64,
    /// Places on the face with these gaps \[m\].
    low_place: f64,
    high_place: f64,
    /// What the contact of this pair changes in the stiffness of each pair \[N/m\].
    pub stiffness: [f64; MOST_PAIRS],
}

/// Where a ramp stands at some approach x. Means are over the slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Travel {
    /// Mean of `max(0, x − gap)` \[m\].
    pub mean: f64,
    /// Mean of `z max(0, x − gap)` \[m²\].
    pub moment: f64,
    /// Part in contact; the derivative of `mean` by x.
    pub engaged: f64,
    /// Derivative of `engaged` towards larger x \[1/m\].
    pub growth: f64,
}

impl Ramp {
    /// Sum over the pairs \[N/m\].
    pub fn total(&self) -> f64 {
        self.stiffness.iter().sum()
    }

    /// State at approach x; on a knot, that to its right.
    pub fn travel(&self, x: f64) -> Travel {
        let span = self.high - self.low;
        if x >= self.high {
            let mean = (x - self.low) - 0.5 * span;
            let middle = 0.5 * (self.low_place + self.high_place);
            // Covariance of two straight lines.
            let skew = span * (self.high_place - self.low_place) / 12.0;
            return Travel {
                mean,
                moment: middle * mean - skew,
                engaged: 1.0,
                growth: 0.0,
            };
        }
        if x < self.low {
            return Travel {
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
        Travel {
            mean,
            moment: centroid * mean,
            engaged,
            growth: 1.0 / span,
        }
    }
}

/// Adds one ramp for each pair on a slice.
///
/// The pairs' mean gap, misalignment included, is the line that all follow; what a pair
/// differs from it by is constant on the slice. Above the line the pairs come into contact in
/// the order of their offsets o. Every new contact bends the relation between the approach
/// and the tooth deflection y, `x = y + Σ f max(0, y − o)/c`, and so changes what the older
/// ones gain with x.
pub(super) fn add_slice(
    ramps: &mut Vec<Ramp>,
    pairs: &[ContactPair],
    face: Face,
    slice: usize,
    misalignment: f64,
    local: bool,
) {
    let count = pairs.len() as f64;
    let [from, to] = [slice, slice + 1].map(|border| {
        let mean = pairs.iter().map(|p| p.gap[border]).sum::<f64>() / count;
        let place = face.border(border);
        (misalignment * place + mean, place)
    });
    let [(low, low_place), (high, high_place)] = if from.0 <= to.0 {
        [from, to]
    } else {
        [to, from]
    };
    let mean = pairs.iter().map(|p| p.mean_gap(slice)).sum::<f64>() / count;
    let mut order: Vec<usize> = (0..pairs.len()).collect();
    let offset = |pair: usize| pairs[pair].mean_gap(slice) - mean;
    order.sort_by(|&a, &b| offset(a).total_cmp(&offset(b)));

    let width = face.width / face.slices as f64;
    let mut knot = offset(order[0]);
    // Approach per tooth deflection.
    let mut bend = 1.0;
    let mut before = [0.0; MOST_PAIRS];
    for (rank, &pair) in order.iter().enumerate() {
        if rank > 0 {
            knot += (offset(pair) - offset(order[rank - 1])) * bend;
        }
        if local {
            bend += pairs[pair].foundation / pairs[pair].tooth;
        }
        let mut now = [0.0; MOST_PAIRS];
        for &other in &order[..=rank] {
            now[other] = width / (pairs[other].tooth * bend);
        }
        let mut stiffness = now;
        for (change, before) in stiffness.iter_mut().zip(&before) {
            *change -= before;
        }
        before = now;
        ramps.push(Ramp {
            slice,
            low: low + knot,
            high: high + knot,
            low_place,
            high_place,
            stiffness,
        });
    }
}
