//! How is a load shared among the pairs in contact and over the face width?
//!
//! Every pair is cut into slices across the face. All slices have the same approach x of the gears along the line of
//! action. Pair j carries the line load q_j(z) ≥ 0 at position z of the face:
//!
//! ```text
//! x = g_j(z) + Σ_i C_ji q_i(z)  where q_j > 0,    x ≤ g_j(z) + Σ_i C_ji q_i(z)  where q_j = 0
//! F = Σ_j ∫ q_j dz
//! ```
//!
//! `C_jj` is the compliance of teeth, contact and gear bodies (times width). `C_ji` is the compliance of the gear bodies,
//! through which the load of pair i deflects pair j. The gap is `g_j(z) = ε z + relief + deviation`. Conry & Seireg 1973
//! pose the problem of deformation compatibility. Slices are independent, as in any thin-slice model, unless the law of
//! the pairs couples them ([`FaceCoupling`](super::FaceCoupling)).
//!
//! In a slice the mean gap of the pairs is linear in z, and each pair deviates from it by a constant. F(x) is then
//! piecewise quadratic and monotone, and solved exactly for any number of slices: with plain misalignment one slice is
//! as good as a hundred. If the gap curves across the face (crowning), the error falls with the square of the slice
//! width. On a helical face every slice has different pairs ([`HelicalFace`]).

mod contact;
mod coupled;
mod error;
mod helical;
mod kinks;
mod pair_series;
mod pairs;
mod profile;
mod ramp;

pub use contact::Contact;
pub use error::{MOST_PAIRS, SharingError};
pub use helical::HelicalFace;
pub use pairs::{ContactPair, Face, pairs_at};

pub(super) use coupled::ContactRegion;
use coupled::{ContactSolution, Coupled, PairLoad};
pub(super) use pair_series::PairSeries;
use pairs::FaceSlice;
pub(super) use pairs::PairPoint;
use ramp::ContactRamp;

/// How the mesh carries a load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharedLoad {
    /// Approach of the gears x \[m\]: the loaded static transmission error, counted from
    /// flanks without deviation that touch at mid-face.
    pub deflection: f64,
    /// Tangent stiffness dF/dx \[N/m\].
    pub stiffness: f64,
    /// Centroid of the load across the face, from mid-face \[m\]; 0 without load.
    pub centre: f64,
    /// Share of each pair in the load. Shares sum to 1, or are all 0 without load. On a helical face the first share is
    /// that of the pairs that entered last at each position of the face, the second that of the pairs before them.
    pub share: [f64; MOST_PAIRS],
    /// Loaded part of the lines of contact of all pairs on the path of contact. On a helical face lines off the path
    /// count if they carry load.
    pub contact_fraction: f64,
}

/// The spring that a pair adds to the mesh on a slice once the pair is in contact there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PairSpring {
    /// The pair that comes into contact.
    pub pair: usize,
    /// Stiffness that the pair adds to the mesh \[N/m\].
    pub stiffness: f64,
    /// Approach at which it comes into contact, at the middle of the slice \[m\].
    pub gap: f64,
    /// Share of each pair in the load of this spring. Shares sum to 1, and may be negative: a new pair takes
    /// load from its neighbours.
    pub share: [f64; MOST_PAIRS],
}

/// Pairs of teeth pressed together by one approach.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadSharing {
    face: Face,
    pairs: usize,
    /// One ramp per pair and slice; with coupled slices only that of the pair that touches first on each slice.
    ramps: Vec<ContactRamp>,
    /// The slices of a helical face; empty for a spur face, whose slices are equal.
    spans: Vec<FaceSlice>,
    /// Approaches at which a ramp starts or ends, ascending \[m\].
    knots: Vec<f64>,
    /// Whether each pair is on the path of contact.
    on_path: [bool; MOST_PAIRS],
    /// Whether the gap of every pair is constant along the face, without misalignment.
    even: bool,
    /// Line load of each pair minus the smallest line load at which a contact is linearised \[N/m\]; may be
    /// negative. For a linear contact, any positive value.
    line_load_excess: [f64; MOST_PAIRS],
    /// The same pairs with elastically coupled slices. `None` if no gap varies along the face, misalignment included,
    /// or if the law does not couple slices.
    coupled: Option<Coupled>,
}

impl LoadSharing {
    /// The pairs in contact on a face. Its slices are coupled if the law of the pairs describes the coupling
    /// ([`FlankLaw::face_coupling`](super::FlankLaw::face_coupling)).
    ///
    /// * `misalignment`: angle between the flanks in the plane of action ε \[rad\]; the gap
    ///   grows with z.
    ///
    /// # Errors
    /// No pair, more than [`MOST_PAIRS`], a face without width or slices, an ε that is not
    /// finite, or bodies whose coupling of pairs is unphysically strong.
    pub fn new(pairs: &[ContactPair], face: Face, misalignment: f64) -> Result<Self, SharingError> {
        check(pairs, face, misalignment)?;
        let coupled = Coupled::new(pairs, face, misalignment)?;
        // With coupled slices, independent ones only give the first touch of the flanks.
        let joining = if coupled.is_some() { 1 } else { pairs.len() };
        Ok(Self {
            coupled,
            ..Self::of_joining(pairs, face, misalignment, joining)?
        })
    }

    /// As [`Self::new`], with independent slices.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn of_slices(
        pairs: &[ContactPair],
        face: Face,
        misalignment: f64,
    ) -> Result<Self, SharingError> {
        check(pairs, face, misalignment)?;
        Self::of_joining(pairs, face, misalignment, pairs.len())
    }

    /// The first `joining` pairs that come into contact on each of the independent slices.
    fn of_joining(
        pairs: &[ContactPair],
        face: Face,
        misalignment: f64,
        joining: usize,
    ) -> Result<Self, SharingError> {
        let mut ramps = Vec::with_capacity(joining * face.slices);
        for slice in 0..face.slices {
            ramp::add_slice(&mut ramps, pairs, face, slice, misalignment, joining)?;
        }
        let mut knots: Vec<f64> = ramps.iter().flat_map(|r| [r.low, r.high]).collect();
        knots.sort_unstable_by(f64::total_cmp);
        Ok(Self {
            face,
            pairs: pairs.len(),
            ramps,
            spans: Vec::new(),
            knots,
            on_path: std::array::from_fn(|pair| {
                pairs.get(pair).is_some_and(|this_pair| this_pair.on_path)
            }),
            even: (pairs.iter()).all(|pair| pair.gap.windows(2).all(|gap| gap[0] == gap[1])),
            line_load_excess: [1.0; MOST_PAIRS],
            coupled: None,
        })
    }

    /// Distribution of a force ≥ 0 \[N\]. Without force the deflection is the approach at which flanks first touch.
    pub fn distribute(&self, force: f64) -> SharedLoad {
        self.distribute_with_lengths(force).0
    }

    /// Distribution of a force, and lengths \[m\] (line loads \[N/m\] last) whose signs select its formula; zero counts
    /// as positive. The law is smooth while none of the lengths changes its sign. The number of lengths depends only on
    /// pairs and slices. On a helical face there are none, because pairs come into contact gradually.
    pub fn distribute_with_margins(&self, force: f64) -> (SharedLoad, Vec<f64>) {
        let (load, margins, _) = self.distribute_from(force, &ContactRegion::default());
        (load, margins)
    }

    /// As [`Self::distribute_with_margins`], with the part of the face in contact. If slices are coupled, its search
    /// starts from `near`, the contact at another mesh phase, or from the whole face.
    pub(in crate::gear) fn distribute_from(
        &self,
        force: f64,
        near: &ContactRegion,
    ) -> (SharedLoad, Vec<f64>, ContactRegion) {
        match self.coupled.as_ref().filter(|_| force > 0.0) {
            None => {
                let load = self.distribute(force);
                (
                    load,
                    self.margins(load.deflection),
                    ContactRegion::default(),
                )
            }
            Some(coupled) => {
                let solution = coupled.solve_from(force, near);
                let mut margins = coupled.margins(&solution);
                margins.extend(&self.line_load_excess[..self.pairs]);
                (
                    self.shared(coupled, &solution).0,
                    margins,
                    solution.touching,
                )
            }
        }
    }

    /// Distribution of a force, and the loaded length of each pair \[m\].
    fn distribute_with_lengths(&self, force: f64) -> (SharedLoad, [f64; MOST_PAIRS]) {
        // Without a force coupled slices touch where independent ones do.
        if let Some(coupled) = self.coupled.as_ref().filter(|_| force > 0.0) {
            return self.shared(coupled, &coupled.solve(force));
        }
        let approach = self.approach(force);
        let mut loads = [0.0; MOST_PAIRS];
        let mut stiffness = 0.0;
        let (mut moment, mut loaded) = (0.0, [0.0; MOST_PAIRS]);
        for ramp in &self.ramps {
            let state = ramp.state_at(approach);
            for (load, stiffness) in loads.iter_mut().zip(&ramp.stiffness) {
                *load += stiffness * state.mean;
            }
            stiffness += ramp.total() * state.engaged;
            moment += ramp.total() * state.moment;
            loaded[ramp.pair] += state.engaged * ramp.part;
        }
        let total: f64 = loads.iter().sum();
        let part = |value: f64| if total > 0.0 { value / total } else { 0.0 };
        let shared = SharedLoad {
            deflection: approach,
            stiffness,
            centre: part(moment),
            share: loads.map(part),
            contact_fraction: self.contact_fraction(approach, loaded),
        };
        let slice = self.face.width / self.face.slices as f64;
        (shared, loaded.map(|slices| slices * slice))
    }

    /// Load on coupled slices, and the loaded length of each pair \[m\].
    fn shared(
        &self,
        coupled: &Coupled,
        solution: &ContactSolution,
    ) -> (SharedLoad, [f64; MOST_PAIRS]) {
        let (loads, moment, loaded) = PairLoad::sums(&coupled.pairs(solution));
        let total: f64 = loads.iter().sum();
        let slices = loaded.map(|part| part * self.face.slices as f64);
        let shared = SharedLoad {
            deflection: solution.approach,
            stiffness: solution.stiffness,
            centre: moment / total,
            share: loads.map(|load| load / total),
            contact_fraction: self.contact_fraction(solution.approach, slices),
        };
        (shared, loaded.map(|part| part * self.face.width))
    }

    /// [`SharedLoad::contact_fraction`] at an approach; `loaded` is the number of slices on which each pair carries
    /// load.
    fn contact_fraction(&self, approach: f64, loaded: [f64; MOST_PAIRS]) -> f64 {
        if self.spans.is_empty() {
            let on_path = || (loaded.iter().zip(self.on_path)).filter(|(_, on_path)| *on_path);
            let touching: f64 = on_path().map(|(slices, _)| slices).sum();
            return touching / (on_path().count().max(1) * self.face.slices) as f64;
        }
        let all: f64 = (self.ramps.iter())
            .map(|ramp| {
                if self.spans[ramp.slice].on_path[ramp.pair] {
                    ramp.part
                } else {
                    ramp.part * ramp.state_at(approach).engaged
                }
            })
            .sum();
        loaded.iter().sum::<f64>() / all
    }

    /// The springs of the pairs, slice by slice in their order of contact as the gears approach.
    pub(super) fn springs(&self) -> impl Iterator<Item = PairSpring> {
        self.ramps.iter().map(|ramp| {
            let total = ramp.total();
            PairSpring {
                pair: ramp.pair,
                stiffness: total,
                gap: 0.5 * (ramp.low + ramp.high),
                share: ramp.stiffness.map(|stiffness| stiffness / total),
            }
        })
    }

    /// Mean line load on each slice under a force \[N/m\], pair by pair.
    pub fn pattern(&self, force: f64) -> Vec<f64> {
        if let Some(coupled) = self.coupled.as_ref().filter(|_| force > 0.0) {
            let slice = self.face.width / self.face.slices as f64;
            let pairs = coupled.pairs(&coupled.solve(force));
            let loads = pairs.iter().flat_map(|pair| &pair.pattern);
            return loads.map(|load| load / slice).collect();
        }
        let approach = self.approach(force);
        let mut pattern = vec![0.0; self.pairs * self.face.slices];
        let width = self.face.width / self.face.slices as f64;
        for ramp in &self.ramps {
            let mean = ramp.state_at(approach).mean / width;
            if let Some(span) = self.spans.get(ramp.slice) {
                for (slice, part) in span.parts_of_slices(self.face) {
                    for pair in 0..self.pairs {
                        let load = ramp.stiffness[pair] * mean * part;
                        pattern[pair * self.face.slices + slice] += load;
                    }
                }
                continue;
            }
            for pair in 0..self.pairs {
                pattern[pair * self.face.slices + ramp.slice] += ramp.stiffness[pair] * mean;
            }
        }
        pattern
    }

    /// Approach of the gears under a force \[m\].
    ///
    /// Finds the last knot that needs no more than this force, and solves the quadratic beyond it. The terms
    /// of the quadratic are sums over the engaged ramps, not of changes since the first knot, so nothing
    /// cancels.
    fn approach(&self, force: f64) -> f64 {
        let engaged = |x: f64| -> f64 {
            let forces = self.ramps.iter().map(|r| r.total() * r.state_at(x).mean);
            forces.sum()
        };
        let above = self.knots.partition_point(|&knot| engaged(knot) <= force);
        let knot = self.knots[above.saturating_sub(1)];
        let (mut at_knot, mut slope, mut curvature) = (0.0, 0.0, 0.0);
        for ramp in &self.ramps {
            let state = ramp.state_at(knot);
            at_knot += ramp.total() * state.mean;
            slope += ramp.total() * state.engaged;
            curvature += ramp.total() * state.growth;
        }
        let rest = (force - at_knot).max(0.0);
        if rest == 0.0 {
            return knot;
        }
        // The root of slope d + curvature d²/2 = rest, in the form without cancellation.
        knot + 2.0 * rest / (slope + (slope * slope + 2.0 * curvature * rest).max(0.0).sqrt())
    }
}

/// Rejects pairs, a face or an angle that cannot share a load.
fn check(pairs: &[ContactPair], face: Face, misalignment: f64) -> Result<(), SharingError> {
    if pairs.is_empty() {
        return Err(SharingError::NoPair);
    }
    if pairs.len() > MOST_PAIRS {
        return Err(SharingError::TooManyPairs { found: pairs.len() });
    }
    face.check()?;
    check_misalignment(misalignment, pairs[0].position())
}

/// Rejects an infinite misalignment of the flanks of a pair at a position \[m\].
fn check_misalignment(value: f64, position: f64) -> Result<(), SharingError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(SharingError::OutOfRange {
        name: "misalignment [rad]",
        value,
        position,
        accepted: "finite",
    })
}

#[cfg(test)]
mod bearing_tests;
