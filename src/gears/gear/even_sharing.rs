//! How do pairs slide over the mesh cycle if those in contact share the load evenly?
//!
//! At mesh phase φ the pairs of a spur gear are at `s = (φ + j − φ_p) p_b` from the pitch point, with integer j
//! and `0 ≤ φ + j < ε`. At phase 0 a pair enters at the start of the path, φ_p cycles before it passes the
//! pitch point. Each of n pairs carries 1/n. So `Λ₀ = −Σ sign(s)/n` is piecewise constant, with steps where a
//! pair enters, leaves or passes the pitch point. `Λ₁ = −Σ |s|/n` is linear in between
//! ([`friction_direction`]). Over a cycle the mean of `−Λ₁ (1/r_b1 + 1/r_b2)` is Ohlendorf's (1958) loss
//! factor if `ε ≤ 2`.
//!
//! A helical pair is `ε_β/2` cycles ahead at one end of its face and `ε_β/2` cycles behind at the other. All lines of
//! contact carry the same load per length.

use super::{FrictionDirection, GearError, GearPair, friction_direction};
use crate::numerics::quadrature::GaussLegendre;

/// Largest length of a stretch over which a linearly varying direction is replaced by its mean, in mesh cycles.
const LONGEST_STRETCH: f64 = 1.0 / 24.0;

/// Ends closer than this \[cycles\] coincide.
pub(super) const SAME_END: f64 = 1e-9;

/// Nodes of the rule for means: exact where Λ is linear, elsewhere accurate to round-off up to [`LONGEST_STRETCH`].
const RULE: usize = 8;

/// The pairs of a drawing, described by their times of contact in mesh cycles.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct EvenSharing {
    /// From the first touch of a pair, at mid-face, to the pitch point: φ_p = g_f/p_bt.
    pub pitch_phase: f64,
    /// From the first to the last touch, at one position of the face: the transverse contact ratio ε ≥ 1.
    pub contact_ratio: f64,
    /// Phase lead of one end of the face over the other: the overlap ratio ε_β, 0 for spur gears.
    pub overlap_ratio: f64,
    /// Transverse base pitch p_bt \[m\].
    pub base_pitch: f64,
    /// Force normal to the flanks, which causes friction, per force in the transverse section: `1/cos β_b`.
    pub inclination: f64,
}

impl EvenSharing {
    /// The pairs of a drawing.
    ///
    /// # Errors
    /// As [`GearPair::approach`], and [`GearError::ContactRatio`].
    pub fn new(pair: &GearPair) -> Result<Self, GearError> {
        let (base_pitch, approach) = (pair.base_pitch(), pair.approach()?);
        let contact_ratio = (approach + pair.recess()?) / base_pitch;
        if contact_ratio < 1.0 {
            return Err(GearError::ContactRatio { contact_ratio });
        }
        Ok(Self {
            pitch_phase: approach / base_pitch,
            contact_ratio,
            overlap_ratio: pair.overlap_ratio(),
            base_pitch,
            inclination: 1.0 / pair.base_helix_angle().cos(),
        })
    }

    /// Direction and lever of friction at a mesh phase in \[0, 1\].
    pub fn at(&self, phase: f64) -> FrictionDirection {
        let half = 0.5 * self.overlap_ratio;
        let (mut places, mut lengths) = (Vec::new(), Vec::new());
        let mut add_load = |time: f64, length: f64| {
            places.push((time - self.pitch_phase) * self.base_pitch);
            lengths.push(length);
        };
        let mut middle = phase + (-phase - half).ceil();
        while middle - half < self.contact_ratio {
            let from = (middle - half).max(0.0);
            // Rounding may end a line just before the path begins.
            let to = (middle + half).min(self.contact_ratio).max(from);
            // The mean position on each side of the pitch point is in the middle.
            let pitch = self.pitch_phase.clamp(from, to);
            if half == 0.0 {
                add_load(middle, 1.0);
            } else {
                add_load(0.5 * (from + pitch), pitch - from);
                add_load(0.5 * (pitch + to), to - pitch);
            }
            middle += 1.0;
        }
        let share = self.inclination / lengths.iter().sum::<f64>();
        lengths.iter_mut().for_each(|length| *length *= share);
        friction_direction(&places, &lengths)
    }

    /// Ends of the stretches over which friction may be averaged, in order, 1 last: with a constant direction for spur
    /// gears, and at most 1/24 of a cycle long for helical gears. No stretch is shorter than `least_distance`.
    pub fn direction_breaks(&self, least_distance: f64) -> Vec<f64> {
        self.ends_at(
            &[0.0, self.pitch_phase, self.contact_ratio],
            least_distance,
            |mark| mark,
        )
    }

    /// Phases at which pairs enter or leave, mapped by `moved`, in order, 1 last. Helical faces have further
    /// cuts at equal distances, between which the load may count as linear.
    pub(super) fn contact_breaks(&self, moved: impl Fn(f64) -> f64) -> Vec<f64> {
        self.ends_at(&[0.0, self.contact_ratio], SAME_END, moved)
    }

    /// Ends of stretches in order, 1 last: phases at which a pair passes one of `marks`. Marks are times
    /// after its first touch \[cycles\], and `moved` maps them to phases.
    fn ends_at(&self, marks: &[f64], least_distance: f64, moved: impl Fn(f64) -> f64) -> Vec<f64> {
        let half = 0.5 * self.overlap_ratio;
        let mut ends: Vec<f64> = (marks.iter())
            .flat_map(|mark| [mark - half, mark + half])
            .map(|mark| moved(mark).rem_euclid(1.0))
            .collect();
        if half > 0.0 {
            let parts = (1.0 / LONGEST_STRETCH).round() as u32;
            ends.extend((1..parts).map(|part| f64::from(part) * LONGEST_STRETCH));
        }
        ends.retain(|end| *end > least_distance && *end < 1.0 - least_distance);
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|later, earlier| *later - *earlier < least_distance);
        ends.push(1.0);
        ends
    }

    /// Converts a time after any first touch of a tooth to a time after its latest one, at mid-face \[cycles\]. The
    /// tooth touches again every `teeth` cycles. Negative while only one end of the face touches.
    pub(super) fn within_turn(&self, since: f64, teeth: u32) -> f64 {
        let half = 0.5 * self.overlap_ratio;
        (since + half).rem_euclid(f64::from(teeth)) - half
    }

    /// Part of the load on the pair of a tooth at a time after its first touch at mid-face \[cycles\].
    pub(super) fn share(&self, since: f64) -> f64 {
        let half = 0.5 * self.overlap_ratio;
        let line = |middle: f64| {
            let length = (middle + half).min(self.contact_ratio) - (middle - half).max(0.0);
            if half > 0.0 {
                length.max(0.0)
            } else {
                f64::from(u8::from((0.0..self.contact_ratio).contains(&middle)))
            }
        };
        let this_pair = line(since);
        let others = (-half).floor() as i32..=(self.contact_ratio + half).ceil() as i32;
        let phase = since.rem_euclid(1.0);
        let all: f64 = others.map(|number| line(phase + f64::from(number))).sum();
        this_pair / all
    }

    /// Mean over a stretch of the mesh cycle that contains no end of [`Self::direction_breaks`].
    pub fn mean(&self, [from, to]: [f64; 2]) -> FrictionDirection {
        let rule = GaussLegendre::new(RULE);
        let (mut direction, mut lever) = (0.0, 0.0);
        for (x, weight) in rule.nodes.iter().zip(&rule.weights) {
            let here = self.at(0.5 * ((to - from) * x + from + to));
            direction += 0.5 * weight * here.direction;
            lever += 0.5 * weight * here.lever;
        }
        FrictionDirection { direction, lever }
    }
}

#[cfg(test)]
#[path = "even_sharing_tests.rs"]
mod tests;
