//! How a load spreads over the pairs in contact and over the face width.
//!
//! Every pair is cut into slices across the face. At place z of the face let x be the
//! approach of the gears along the line of action. A pair j presses with the line load
//!
//! ```text
//! x = g_j(z) + Σ_i C_ji q_i(z) where q_j > 0, x ≤ that elsewhere,     F = Σ_j ∫ q_j dz
//! ```
//!
//! with the compliance of teeth, contact and gear bodies `C_jj` (times width), that of the
//! bodies between two pairs `C_ji`, and the gap `g_j(z) = ε z + relief + deviation`. A body is
//! one for all pairs: what its share of `C_jj` and `C_ji` have in common counts once. Conry &
//! Seireg 1973 pose the problem of deformation compatibility; slices do not support each other
//! here, as in any thin-slice model.
//!
//! Within a slice the part of the gap that is common to the pairs is a straight line. F(x) is
//! then piecewise quadratic and monotone, and solved exactly, whatever the number of slices:
//! with plain misalignment one slice is as good as a hundred. Where the gap curves across the
//! face (crowning) the error falls with the square of the slice width.

mod contact;
mod kinks;
mod ramp;

pub use contact::Contact;

use super::FlankLaw;
use ramp::Ramp;

/// Most pairs that share a load.
pub const MOST_PAIRS: usize = 3;

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
        /// How many, counted no further than that.
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
    /// A contact law that does not settle.
    #[error(
        "the contact compliance at {position} m from the pitch point does not settle under its own load; is the law's derivative its own?"
    )]
    Unsettled {
        /// Place on the line of action \[m\].
        position: f64,
    },
    /// Pairs that take each other's load away.
    #[error(
        "the gear bodies couple the pair at {position} m from the pitch point so strongly with another that one loses load when the gears approach"
    )]
    Coupling {
        /// Place on the line of action \[m\].
        position: f64,
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
    /// Compliance of the teeth without their contact, times width \[m²/N\].
    teeth: f64,
    /// Tangent compliance of the contact, times width \[m²/N\].
    contact: f64,
    /// Where the tangent of the contact law meets zero load \[m\].
    intercept: f64,
    /// Compliance of both gear bodies, times width \[m²/N\].
    foundation: f64,
    /// That between this pair and the ones ahead of it, nearest first \[m²/N\].
    coupling: Vec<f64>,
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
        let teeth = compliance.tooth[0] + compliance.tooth[1];
        let tooth = teeth + compliance.hertz;
        let foundation = compliance.foundation[0] + compliance.foundation[1];
        let relief = law.relief(position);
        let gap: Vec<f64> = (0..=face.slices)
            .map(|border| relief + law.deviation(position, face.border(border)))
            .collect();
        let path = law.path();
        let ahead = |pairs: usize| position + pairs as f64 * path.base_pitch;
        let coupling: Vec<f64> = (1..)
            .take_while(|&pairs| pairs < MOST_PAIRS && ahead(pairs) <= path.end)
            .map(|pairs| law.coupling(position, pairs))
            .collect();
        let bad_coupling = coupling.iter().copied().find(|c| !c.is_finite());
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
                "compliance of the gear bodies between two pairs [m²/N]",
                bad_coupling.unwrap_or(0.0),
                bad_coupling.is_none(),
                "finite",
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
            teeth,
            contact: compliance.hertz,
            intercept: 0.0,
            foundation,
            coupling,
            gap,
        })
    }

    /// Compliance of the pair alone in contact, times width \[m²/N\].
    fn compliance(&self) -> f64 {
        self.teeth + self.contact + self.foundation
    }

    /// What the tooth spring has to close at the border of a slice \[m\].
    fn gap(&self, border: usize) -> f64 {
        self.gap[border] + self.intercept
    }

    /// The same on the middle of a slice \[m\].
    fn mean_gap(&self, slice: usize) -> f64 {
        0.5 * (self.gap(slice) + self.gap(slice + 1))
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
    // One too many is enough to be refused.
    (0..=MOST_PAIRS)
        .map(|pair| path.start + (phase + pair as f64) * path.base_pitch)
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
    /// One for each pair of each slice.
    ramps: Vec<Ramp>,
    /// Approaches at which a ramp starts or ends, ascending \[m\].
    knots: Vec<f64>,
    /// Whether every pair lacks the same all along its face.
    even: bool,
    /// By how much the line load of each pair exceeds the least at which its contact is
    /// linearised \[N/m\]; of a linear contact, anything positive.
    above_least: [f64; MOST_PAIRS],
}

impl LoadSharing {
    /// The pairs in contact on a face.
    ///
    /// * `misalignment`: angle between the flanks in the plane of action ε \[rad\]; the gap
    ///   grows with z.
    ///
    /// # Errors
    /// No pair, more than [`MOST_PAIRS`], a face without width or slices, an ε that is not
    /// finite, or bodies that couple pairs more strongly than any body does.
    pub fn new(pairs: &[ContactPair], face: Face, misalignment: f64) -> Result<Self, SharingError> {
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
        let mut ramps = Vec::with_capacity(pairs.len() * face.slices);
        for slice in 0..face.slices {
            ramp::add_slice(&mut ramps, pairs, face, slice, misalignment)?;
        }
        let mut knots: Vec<f64> = ramps.iter().flat_map(|r| [r.low, r.high]).collect();
        knots.sort_unstable_by(f64::total_cmp);
        Ok(Self {
            face,
            pairs: pairs.len(),
            ramps,
            knots,
            even: (pairs.iter()).all(|pair| pair.gap.windows(2).all(|gap| gap[0] == gap[1])),
            above_least: [1.0; MOST_PAIRS],
        })
    }

    /// How a force ≥ 0 \[N\] is borne. Without force: where the flanks first touch.
    pub fn bear(&self, force: f64) -> SharedLoad {
        self.bear_with_lengths(force).0
    }

    /// How a force is borne, and the loaded length of each pair \[m\].
    fn bear_with_lengths(&self, force: f64) -> (SharedLoad, [f64; MOST_PAIRS]) {
        let approach = self.approach(force);
        let mut loads = [0.0; MOST_PAIRS];
        let mut stiffness = 0.0;
        let (mut moment, mut loaded) = (0.0, [0.0; MOST_PAIRS]);
        for ramp in &self.ramps {
            let travel = ramp.travel(approach);
            for (load, stiffness) in loads.iter_mut().zip(&ramp.stiffness) {
                *load += stiffness * travel.mean;
            }
            stiffness += ramp.total() * travel.engaged;
            moment += ramp.total() * travel.moment;
            loaded[ramp.pair] += travel.engaged;
        }
        let total: f64 = loads.iter().sum();
        let part = |value: f64| if total > 0.0 { value / total } else { 0.0 };
        let shared = SharedLoad {
            deflection: approach,
            stiffness,
            centre: part(moment),
            share: loads.map(part),
            contact_fraction: loaded.iter().sum::<f64>() / self.ramps.len() as f64,
        };
        let slice = self.face.width / self.face.slices as f64;
        (shared, loaded.map(|slices| slices * slice))
    }

    /// Line load under a force \[N/m\], pair by pair the mean on each slice.
    pub fn pattern(&self, force: f64) -> Vec<f64> {
        let approach = self.approach(force);
        let mut pattern = vec![0.0; self.pairs * self.face.slices];
        let width = self.face.width / self.face.slices as f64;
        for ramp in &self.ramps {
            let mean = ramp.travel(approach).mean / width;
            for pair in 0..self.pairs {
                pattern[pair * self.face.slices + ramp.slice] += ramp.stiffness[pair] * mean;
            }
        }
        pattern
    }

    /// Approach of the gears under a force \[m\].
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
