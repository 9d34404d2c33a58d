//! Which pairs of teeth are in contact, and how compliant is each?

use super::error::{MOST_PAIRS, SharingError};
use crate::gear::{FaceCoupling, FlankLaw};
use std::sync::Arc;

/// A pair within this distance before the start of its reach, in base pitches, counts as within it.
const ON_START: f64 = 1e-12;

/// The face and its slices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Width \[m\].
    pub width: f64,
    /// Number of equal slices, ≥ 1.
    pub slices: usize,
}

impl Face {
    /// Position of the lower border of slice `index`, from mid-face \[m\].
    pub(super) fn border(&self, index: usize) -> f64 {
        (index as f64 / self.slices as f64 - 0.5) * self.width
    }

    /// Rejects a face without width or slices.
    pub(super) fn check(self) -> Result<(), SharingError> {
        let Self { width, slices } = self;
        if slices == 0 || !(width > 0.0 && width.is_finite()) {
            return Err(SharingError::NoFace { width, slices });
        }
        Ok(())
    }
}

/// A pair at one position of the line of action.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::gear) struct PairPoint {
    /// Position on the line of action \[m\].
    pub position: f64,
    /// Material missing \[m\]: by relief, and at one place of the face also by deviation.
    pub missing: f64,
    /// Compliance of the teeth without their contact, times width \[m²/N\].
    pub teeth: f64,
    /// Tangent compliance of the contact, times width \[m²/N\].
    pub contact: f64,
    /// Zero-load intercept of the tangent of the contact law \[m\].
    pub intercept: f64,
    /// Compliance of both gear bodies, times width \[m²/N\].
    pub foundation: f64,
    /// Compliance between this pair and those ahead of it, nearest first \[m²/N\]; without meaning beyond the last
    /// pair within reach.
    pub coupling: [f64; MOST_PAIRS - 1],
}

impl PairPoint {
    /// The pair at `position` of a law, with `ahead` more pairs within reach beyond it.
    pub fn new(law: &impl FlankLaw, position: f64, ahead: usize) -> Self {
        let compliance = law.compliance(position);
        Self {
            position,
            missing: law.relief(position),
            teeth: compliance.tooth[0] + compliance.tooth[1],
            contact: compliance.hertz,
            intercept: 0.0,
            foundation: compliance.foundation[0] + compliance.foundation[1],
            coupling: std::array::from_fn(|pair| {
                if pair < ahead { law.coupling(position, pair + 1) } else { 0.0 }
            }),
        }
    }

    /// Compliance of the pair alone in contact, times width \[m²/N\].
    pub fn compliance(&self) -> f64 {
        self.teeth + self.contact + self.foundation
    }

    /// Gap that the tooth spring has to close \[m\].
    pub fn gap(&self) -> f64 {
        self.missing + self.intercept
    }

    /// Rejects compliances that are not positive and finite, and gaps that are not finite.
    pub(super) fn check(&self, gaps: &[f64]) -> Result<(), SharingError> {
        let tooth = self.teeth + self.contact;
        let bad_coupling = self.coupling.iter().copied().find(|c| !c.is_finite());
        let bad_gap = gaps.iter().copied().find(|gap| !gap.is_finite());
        for (name, value, valid, accepted) in [
            (
                "compliance of teeth and contact [m²/N]",
                tooth,
                tooth > 0.0 && tooth.is_finite(),
                "positive and finite",
            ),
            (
                "compliance of the gear bodies [m²/N]",
                self.foundation,
                self.foundation >= 0.0 && self.foundation.is_finite(),
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
                    position: self.position,
                    accepted,
                });
            }
        }
        Ok(())
    }
}

/// A pair in contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPair {
    pub(super) point: PairPoint,
    /// Whether the position is on the path of contact, where rigid gears would touch.
    pub(super) on_path: bool,
    /// Material missing at the borders of the slices \[m\].
    pub(super) gap: Vec<f64>,
    /// Elastic coupling of its slices; `None` if they are independent.
    pub(super) face_coupling: Option<Arc<FaceCoupling>>,
}

impl ContactPair {
    /// The pair at `position` of a law.
    ///
    /// # Errors
    /// A compliance that is not positive and finite, or a gap that is not finite.
    pub fn new(law: &impl FlankLaw, position: f64, face: Face) -> Result<Self, SharingError> {
        let (path, [_, last]) = (law.path(), law.reach());
        let ahead = (1..MOST_PAIRS)
            .take_while(|&pairs| position + pairs as f64 * path.base_pitch <= last)
            .count();
        let point = PairPoint::new(law, position, ahead);
        let gap: Vec<f64> = (0..=face.slices)
            .map(|border| point.missing + law.deviation(position, face.border(border)))
            .collect();
        point.check(&gap)?;
        Ok(Self {
            point,
            on_path: (path.start..=path.end).contains(&position),
            gap,
            face_coupling: law.face_coupling(),
        })
    }

    /// Position on the line of action \[m\].
    pub fn position(&self) -> f64 {
        self.point.position
    }

    /// Gap that the tooth spring has to close at the border of a slice \[m\].
    pub(super) fn gap(&self, border: usize) -> f64 {
        self.gap[border] + self.point.intercept
    }

    /// Gap that the tooth spring has to close in the middle of a slice \[m\].
    pub(super) fn mean_gap(&self, slice: usize) -> f64 {
        0.5 * (self.gap(slice) + self.gap(slice + 1))
    }
}

/// A slice of a helical face. Only the first `pairs` of each array count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FaceSlice {
    /// Positions of its ends \[m\].
    pub ends: [f64; 2],
    pub pairs: usize,
    /// Positions of the pairs on the line of action in the middle of the slice \[m\].
    pub positions: [f64; MOST_PAIRS],
    /// Whether each pair is on the path of contact, not beyond its ends.
    pub on_path: [bool; MOST_PAIRS],
}

impl FaceSlice {
    /// The equal slices of a face that overlap this span, each with the overlapping part of the span.
    pub fn parts_of_slices(&self, face: Face) -> impl Iterator<Item = (usize, f64)> {
        let [from, to] = self.ends;
        (0..face.slices).filter_map(move |slice| {
            let low = from.max(face.border(slice));
            let high = to.min(face.border(slice + 1));
            (low < high).then(|| (slice, (high - low) / (to - from)))
        })
    }
}

/// The pairs within reach at mesh phase `phase`, the latest pair first. Empty if the reach is
/// shorter than a base pitch and the phase falls between two pairs.
///
/// # Errors
/// Those of [`ContactPair::new`].
pub fn pairs_at(
    law: &impl FlankLaw,
    phase: f64,
    face: Face,
) -> Result<Vec<ContactPair>, SharingError> {
    (positions(law, phase).into_iter())
        .map(|position| ContactPair::new(law, position, face))
        .collect()
}

/// Positions of the pairs within reach on the line of action at a mesh phase \[m\], the latest pair first. Returns at
/// most [`MOST_PAIRS`] + 1 positions, enough to reject them.
pub(super) fn positions(law: &impl FlankLaw, phase: f64) -> Vec<f64> {
    let (path, [first, last]) = (law.path(), law.reach());
    // A pair at the start of its reach is within it, despite rounding of its position.
    let early = ((path.start - first) / path.base_pitch + phase + ON_START).floor();
    (0..=MOST_PAIRS)
        .map(|pair| path.start + (phase - early + pair as f64) * path.base_pitch)
        .take_while(|&position| position <= last)
        .collect()
}
