//! How a load spreads over the pairs in contact and over the face width.
//!
//! Every pair is cut into slices across the face. At place z of the face let x be the
//! approach of the gears along the line of action. A pair j presses with the line load
//!
//! ```text
//! q_j(z) = max(0, y(z) − g_j(z)) / c_j,     x = y(z) + Σ_j f_j q_j(z),     F = Σ_j ∫ q_j dz
//! ```
//!
//! with c its tooth and contact compliance, f the compliance of the gear bodies below it (both
//! times width) and the gap `g_j(z) = ε z + relief + deviation`. The bodies are common to the
//! pairs: their deflection `Σ f_j q_j` is counted once. It is the one of a body with the
//! flexibility `C_ij = (f_i + f_j)/2` at the load's own mean, `Σ p_i u_i`, p the load shares.
//! Conry & Seireg 1973 pose the problem of deformation compatibility; slices do not
//! support each other here, as in any thin-slice model.
//!
//! Within a slice the part of the gap that is common to the pairs is a straight line. F(x) is
//! then piecewise quadratic and monotone, and solved exactly, whatever the number of slices:
//! with plain misalignment one slice is as good as a hundred. Where the gap curves across the
//! face (crowning) the error falls with the square of the slice width.

mod ramp;

use super::FlankLaw;
use ramp::Ramp;

/// Most pairs that share a load.
pub const MOST_PAIRS: usize = 3;

/// How the gear bodies pass on the load of a part of the face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Foundation {
    /// Under the load: each slice of the body bears its own slice of the teeth. Right where
    /// the loaded part is long beside the thickness of a tooth.
    Strips,
    /// As a whole: it gives way over the full width, and does not tilt, wherever the load
    /// acts.
    Body,
}

/// The face and its slices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Width \[m\].
    pub width: f64,
    /// Number of equal slices, ≥ 1.
    pub slices: usize,
}

impl Face {
    /// Distance of the border below slice `index` from mid-face \[m\].
    fn border(&self, index: usize) -> f64 {
        (index as f64 / self.slices as f64 - 0.5) * self.width
    }
}

/// Why a load cannot be shared out.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SharingError {
    /// Nothing to press on.
    #[error("no pair is in contact: the contact ratio is below 1")]
    NoPair,
    /// More pairs than there is room for.
    #[error("{found} pairs in contact; at most {MOST_PAIRS} can share the load")]
    TooManyPairs {
        /// How many.
        found: usize,
    },
    /// A quantity outside its physical range.
    #[error("{name} is {value} at {position} m from the pitch point; it must be {accepted}")]
    OutOfRange {
        /// Which quantity.
        name: &'static str,
        /// Its value, SI.
        value: f64,
        /// Place on the line of action \[m\].
        position: f64,
        /// What would be accepted.
        accepted: &'static str,
    },
    /// A face without width or slices.
    #[error("a face of {width} m in {slices} slices bears nothing; give it a width and a slice")]
    NoFace {
        /// Width \[m\].
        width: f64,
        /// Number of slices.
        slices: usize,
    },
}

/// A pair in contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPair {
    /// Place on the line of action \[m\].
    pub position: f64,
    /// Compliance of teeth and contact, times width \[m²/N\].
    tooth: f64,
    /// Compliance of both gear bodies, times width \[m²/N\].
    foundation: f64,
    /// Material missing at the borders of the slices \[m\].
    gap: Vec<f64>,
}

impl ContactPair {
    /// The pair at `position` of a law.
    ///
    /// # Errors
    /// A compliance that is not positive and finite, or a gap that is not finite.
    pub fn new(law: &impl FlankLaw, position: f64, face: Face) -> Result<Self, SharingError> {
        let compliance = law.compliance(position);
        let tooth = compliance.tooth[0] + compliance.tooth[1] + compliance.hertz;
        let foundation = compliance.foundation[0] + compliance.foundation[1];
        let relief = law.relief(position);
        let gap: Vec<f64> = (0..=face.slices)
            .map(|border| relief + law.deviation(position, face.border(border)))
            .collect();
        let bad_gap = gap.iter().copied().find(|gap| !gap.is_finite());
        for (name, value, valid, accepted) in [
            (
                "compliance of teeth and contact [m²/N]",
                tooth,
                tooth > 0.0 && tooth.is_finite(),
                "positive and finite",
            ),
            (
                "compliance of the gear bodies [m²/N]",
                foundation,
                foundation >= 0.0 && foundation.is_finite(),
                "finite and not negative",
            ),
            (
                "material missing from the flanks [m]",
                bad_gap.unwrap_or(0.0),
                bad_gap.is_none(),
                "finite",
            ),
        ] {
            if !valid {
                return Err(SharingError::OutOfRange {
                    name,
                    value,
                    position,
                    accepted,
                });
            }
        }
        Ok(Self {
            position,
            tooth,
            foundation,
            gap,
        })
    }

    /// Material missing on the middle of a slice \[m\].
    fn mean_gap(&self, slice: usize) -> f64 {
        0.5 * (self.gap[slice] + self.gap[slice + 1])
    }
}

/// The pairs at mesh phase `phase`, the one that came last first. None where the path is
/// shorter than a base pitch and the phase falls between two pairs.
///
/// # Errors
/// Those of [`ContactPair::new`].
pub fn pairs_at(
    law: &impl FlankLaw,
    phase: f64,
    face: Face,
) -> Result<Vec<ContactPair>, SharingError> {
    let path = law.path();
    (0..)
        .map(|pair| path.start + (phase + f64::from(pair)) * path.base_pitch)
        .take_while(|&position| position <= path.end)
        .map(|position| ContactPair::new(law, position, face))
        .collect()
}

/// How a load is borne.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharedLoad {
    /// Approach of the gears x \[m\]: the loaded static transmission error, counted from
    /// flanks without deviation that touch at mid-face.
    pub deflection: f64,
    /// Tangent stiffness dF/dx \[N/m\].
    pub stiffness: f64,
    /// Centroid of the load across the face, from mid-face \[m\].
    pub centre: f64,
    /// Share of each pair in the load; they sum to 1.
    pub share: [f64; MOST_PAIRS],
    /// Loaded part of the lines of contact of all pairs.
    pub contact_fraction: f64,
}

/// Pairs of teeth pressed together by one approach.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadSharing {
    face: Face,
    pairs: usize,
    /// Compliance of the body as a whole under each pair's load \[m/N\].
    body: [f64; MOST_PAIRS],
    /// One for each pair of each slice.
    ramps: Vec<Ramp>,
    /// Approaches at which a ramp starts or ends, ascending \[m\].
    knots: Vec<f64>,
}

impl LoadSharing {
    /// The pairs in contact on a face.
    ///
    /// * `misalignment`: angle between the flanks in the plane of action ε \[rad\]; the gap
    ///   grows with z.
    ///
    /// # Errors
    /// No pair, more than [`MOST_PAIRS`], a face without width or slices, or an ε that is not
    /// finite.
    pub fn new(
        pairs: &[ContactPair],
        face: Face,
        misalignment: f64,
        foundation: Foundation,
    ) -> Result<Self, SharingError> {
        if pairs.is_empty() {
            return Err(SharingError::NoPair);
        }
        if pairs.len() > MOST_PAIRS {
            return Err(SharingError::TooManyPairs { found: pairs.len() });
        }
        if face.slices == 0 || !(face.width > 0.0 && face.width.is_finite()) {
            let Face { width, slices } = face;
            return Err(SharingError::NoFace { width, slices });
        }
        if !misalignment.is_finite() {
            return Err(SharingError::OutOfRange {
                name: "misalignment [rad]",
                value: misalignment,
                position: pairs[0].position,
                accepted: "finite",
            });
        }
        let local = foundation == Foundation::Strips;
        let mut ramps = Vec::with_capacity(pairs.len() * face.slices);
        for slice in 0..face.slices {
            ramp::add_slice(&mut ramps, pairs, face, slice, misalignment, local);
        }
        let mut knots: Vec<f64> = ramps.iter().flat_map(|r| [r.low, r.high]).collect();
        knots.sort_unstable_by(f64::total_cmp);
        let mut body = [0.0; MOST_PAIRS];
        if !local {
            for (body, pair) in body.iter_mut().zip(pairs) {
                *body = pair.foundation / face.width;
            }
        }
        Ok(Self {
            face,
            pairs: pairs.len(),
            body,
            ramps,
            knots,
        })
    }

    /// How a force ≥ 0 \[N\] is borne. Without force: where the flanks first touch.
    pub fn bear(&self, force: f64) -> SharedLoad {
        let teeth = self.approach(force);
        let mut loads = [0.0; MOST_PAIRS];
        let mut slopes = [0.0; MOST_PAIRS];
        let (mut moment, mut loaded) = (0.0, 0.0);
        for ramp in &self.ramps {
            let travel = ramp.travel(teeth);
            for (pair, stiffness) in ramp.stiffness.iter().enumerate() {
                loads[pair] += stiffness * travel.mean;
                slopes[pair] += stiffness * travel.engaged;
            }
            moment += ramp.total() * travel.moment;
            loaded += travel.engaged;
        }
        let total: f64 = loads.iter().sum();
        let part = |value: f64| if total > 0.0 { value / total } else { 0.0 };
        let yields = |values: &[f64]| -> f64 {
            let terms = values.iter().zip(&self.body);
            terms.map(|(value, body)| value * body).sum()
        };
        SharedLoad {
            deflection: teeth + yields(&loads),
            stiffness: slopes.iter().sum::<f64>() / (1.0 + yields(&slopes)),
            centre: part(moment),
            share: loads.map(part),
            contact_fraction: loaded / self.ramps.len() as f64,
        }
    }

    /// Line load under a force \[N/m\], pair by pair the mean on each slice.
    pub fn pattern(&self, force: f64) -> Vec<f64> {
        let teeth = self.approach(force);
        let mut pattern = vec![0.0; self.pairs * self.face.slices];
        let width = self.face.width / self.face.slices as f64;
        for ramp in &self.ramps {
            let mean = ramp.travel(teeth).mean / width;
            for pair in 0..self.pairs {
                pattern[pair * self.face.slices + ramp.slice] += ramp.stiffness[pair] * mean;
            }
        }
        pattern
    }

    /// Approach of the teeth under a force \[m\].
    ///
    /// The last knot that needs no more force is found, and the quadratic from there on
    /// solved; its terms are sums of what is engaged, not of changes since the first knot, so
    /// that nothing cancels.
    fn approach(&self, force: f64) -> f64 {
        let engaged = |x: f64| -> f64 {
            let forces = self.ramps.iter().map(|r| r.total() * r.travel(x).mean);
            forces.sum()
        };
        let above = self.knots.partition_point(|&knot| engaged(knot) <= force);
        let knot = self.knots[above.saturating_sub(1)];
        let (mut at_knot, mut slope, mut curvature) = (0.0, 0.0, 0.0);
        for ramp in &self.ramps {
            let travel = ramp.travel(knot);
            at_knot += ramp.total() * travel.mean;
            slope += ramp.total() * travel.engaged;
            curvature += ramp.total() * travel.growth;
        }
        let rest = (force - at_knot).max(0.0);
        if rest == 0.0 {
            return knot;
        }
        // The root of slope d + curvature d²/2 = rest that does not cancel.
        knot + 2.0 * rest / (slope + (slope * slope + 2.0 * curvature * rest).max(0.0).sqrt())
    }
}
