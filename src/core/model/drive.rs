//! Mesh and excitation of a drive, and its operating point.

use super::error::{ModelError, check_in_range};
use super::{Film, FlankError, MeshHarmonic, Release, STIFFNESS_TERMS, Stiffness};
use crate::numerics::quadrature::GaussLegendre;
use serde::Serialize;
use std::f64::consts::TAU;
use strum::EnumString;

/// Breakpoints closer than this \[cycles\] coincide. Equal breakpoints differ by up to 6e-12 if input values have
/// twelve digits. Moving a step Δk of a stiffness by this distance changes the rate of a deflection x by
/// `1e-11 T Δk x/m`. In units of ω x this is 1e-11 Δk/k times the phase ω T of the contact's oscillation per cycle
/// \[rad\].
pub const SAME_PHASE: f64 = 1e-11;

/// A gap that no deflection closes \[m\].
const OUT_OF_REACH: f64 = 1.0;

/// A distance from mid-face \[m\] below this counts as zero.
const MID_FACE: f64 = 1e-12;

/// Number of divisions per period of the highest harmonic of a stiffness.
const PIECES_A_HARMONIC: u32 = 15;

/// Divisions by flank (drive, coast), mesh cycle and spring.
pub type ToothCycles = [Vec<Vec<Vec<Division>>>; 2];

/// Mesh and excitation of a drive, without its operating point.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Backlash half gap b \[m\] of either flank, > 0.
    pub half_gap: f64,
    /// The divisions of the mesh cycle on the drive flank, in order; the last ends at 1.
    pub mesh: Vec<Division>,
    /// Further springs of the drive flank, each with the divisions of its cycle. Each is the stiffness that a
    /// further pair of teeth adds across a larger gap. They have no dampers.
    pub further: Vec<Vec<Division>>,
    /// Contact damping c \[N s/m\].
    pub damping: f64,
    /// Coulomb friction coefficient μ.
    pub friction: f64,
    /// Release rule of the contacts, further ones included.
    pub release: Release,
    /// The film of oil on both flanks, if any.
    pub film: Option<Film>,
    /// The coast flank; `None` if it is the back of the drive flank, on the same line.
    pub coast: Option<CoastFlank>,
    /// Imposed transmission error, `e(φ) = Σ amplitude cos(2π harmonic φ + phase)` with the
    /// mesh phase φ in cycles.
    pub transmission_error: Vec<MeshHarmonic>,
    /// Torque ripple, `T(t) = Σ amplitude cos(order Ω_shaft t + phase)`.
    pub torque_ripple: Vec<TorqueRipple>,
    /// If single teeth differ, the divisions of all springs of both flanks in each mesh cycle until the same
    /// teeth meet again; otherwise empty. The sequence of cycles repeats.
    pub tooth_cycles: ToothCycles,
    /// Imposed uneven rotation.
    pub imposed_motion: Vec<ImposedMotion>,
}

impl Drive {
    /// A mesh of constant stiffness \[N/m\] with a half gap \[m\] on both sides, without damping, friction
    /// and errors.
    pub fn constant(half_gap: f64, stiffness: f64) -> Self {
        Self {
            half_gap,
            mesh: Division::levels(&[stiffness], &[]),
            damping: 0.0,
            friction: 0.0,
            release: Release::Deflection,
            film: None,
            coast: None,
            transmission_error: Vec::new(),
            torque_ripple: Vec::new(),
            imposed_motion: Vec::new(),
            tooth_cycles: Default::default(),
            further: Vec::new(),
        }
    }
}

/// The coast (back) flank as a separate flank, with a separate line of action.
#[derive(Debug, Clone, PartialEq)]
pub struct CoastFlank {
    /// The divisions of its cycle, in order; the last ends at 1.
    pub mesh: Vec<Division>,
    /// Further springs, as many as on the drive flank.
    pub further: Vec<Vec<Division>>,
    /// Transmission error imposed on it, with the sign of the drive flank's.
    pub transmission_error: Vec<MeshHarmonic>,
}

/// A division of the mesh cycle: the interval from the end of the previous division to `end`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Division {
    /// Mesh phase at its end, in cycles.
    pub end: f64,
    /// Mesh stiffness over it.
    pub stiffness: Stiffness,
    /// Error of loaded flanks over it.
    pub error: FlankError,
    /// Load centroid z_c: position of the mesh force along the face \[m\].
    pub load_centre: f64,
    /// Friction direction Λ₀ \[1\] and lever Λ₁ \[m\]: factors of the participation in a friction force at
    /// the pitch point, and of its derivative with respect to the position along the path of contact. The
    /// friction force is μ times the mesh force.
    pub friction: [f64; 2],
}

impl Division {
    /// A division without contact: its gap is larger than any deflection, so that the stiffness \[N/m\] has
    /// no effect.
    pub fn absent(end: f64, stiffness: f64) -> Self {
        let mut gap = [0.0; STIFFNESS_TERMS];
        gap[0] = OUT_OF_REACH;
        Self {
            error: FlankError::series(gap),
            ..Self::level(end, stiffness)
        }
    }

    /// A division of constant stiffness \[N/m\], loaded at mid-face, whose friction acts at the
    /// pitch point in its positive direction.
    pub const fn level(end: f64, stiffness: f64) -> Self {
        Self {
            end,
            stiffness: Stiffness::constant(stiffness),
            error: FlankError::NONE,
            load_centre: 0.0,
            friction: [1.0, 0.0],
        }
    }

    /// This division without spring and friction.
    pub(super) fn without_spring(&self) -> Self {
        Self {
            stiffness: Stiffness::constant(0.0),
            friction: [0.0; 2],
            ..*self
        }
    }

    /// Its load centroid \[m\]. A position within a picometre of mid-face becomes mid-face: the difference is
    /// round-off, and would create a separate line for every division.
    pub(super) fn centre(&self) -> f64 {
        if self.load_centre.abs() < MID_FACE { 0.0 } else { self.load_centre }
    }

    /// The divisions of the coast flank, from those of the drive flank.
    ///
    /// Flanks of a tooth are mirror images of each other. The pinion's tooth is on the line of centres at the
    /// mesh phase `symmetry` \[cycles\]. The coast flanks then touch at the mirror images of the drive
    /// flanks' positions. Therefore `k_coast(symmetry + φ) = k_drive(symmetry − φ)`, and the same holds for
    /// the error. A load centroid changes its sign, because a misalignment that brings the drive flanks
    /// closer at one end of the face separates the coast flanks there. The pairs are on the other side of the
    /// pitch point, where they slide in the opposite direction, so that Λ₀ changes its sign.
    pub fn mirrored(drive: &[Self], symmetry: f64) -> Vec<Self> {
        let starts = std::iter::once(0.0).chain(drive.iter().map(|division| division.end));
        // A division [a, b] of the drive flank becomes [2 symmetry − b, 2 symmetry − a] on the coast flank.
        // Divisions whose ends coincide are skipped, because rounding could swap these ends.
        let mut pieces: Vec<(f64, f64, &Self)> = (starts.zip(drive))
            .filter(|(start, division)| division.end - start > SAME_PHASE)
            .map(|(start, division)| {
                let from = (2.0 * symmetry - division.end).rem_euclid(1.0);
                let from = if 1.0 - from < SAME_PHASE { 0.0 } else { from };
                (from, division.end - start, division)
            })
            .collect();
        pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut out = Vec::with_capacity(pieces.len() + 1);
        if let Some(&(start, length, division)) = pieces.last() {
            let place = 2.0 * (1.0 - start) / length - 1.0;
            let over = pieces[0].0 > SAME_PHASE;
            // The last piece extends beyond the end of the cycle: cut it there.
            if over {
                out.push(division.mirror_image([place, 1.0], pieces[0].0));
            }
            let ends = pieces[1..].iter().map(|piece| piece.0);
            for (&(_, _, division), end) in pieces.iter().zip(ends) {
                out.push(division.mirror_image([-1.0, 1.0], end));
            }
            out.push(division.mirror_image([-1.0, if over { place } else { 1.0 }], 1.0));
        }
        out
    }

    /// The part `from ≤ x ≤ to` of this division's mirror image, x ∈ \[−1, 1\], as a division that ends at
    /// the phase `end`.
    fn mirror_image(&self, [from, to]: [f64; 2], end: f64) -> Self {
        Self {
            end,
            stiffness: self.stiffness.reversed().part(from, to),
            error: self.error.reversed().part(from, to),
            load_centre: -self.load_centre,
            friction: [-self.friction[0], self.friction[1]],
        }
    }

    /// Divisions of equal length for a stiffness that is given by its mean \[N/m\] and its harmonics. On each
    /// division the stiffness is the polynomial through the values at the Gauss nodes. The number of
    /// divisions is chosen for an error of 1e-12 of the amplitudes.
    pub fn fourier(mean: f64, harmonics: &[StiffnessHarmonic]) -> Vec<Self> {
        let highest = harmonics.iter().map(|h| h.harmonic).max().unwrap_or(0);
        let count = (PIECES_A_HARMONIC * highest).max(1);
        let rule = GaussLegendre::new(STIFFNESS_TERMS);
        (0..count)
            .map(|i| {
                let values = std::array::from_fn(|node| {
                    let place = 0.5 * (rule.nodes[node] + 1.0);
                    let phase = (f64::from(i) + place) / f64::from(count);
                    let waves = harmonics.iter().map(|h| {
                        h.amplitude * (TAU * f64::from(h.harmonic) * phase + h.phase).cos()
                    });
                    mean + waves.sum::<f64>()
                });
                let stiffness = if harmonics.is_empty() {
                    Stiffness::constant(mean)
                } else {
                    Stiffness::through(&values)
                };
                Self {
                    stiffness,
                    ..Self::level(f64::from(i + 1) / f64::from(count), mean)
                }
            })
            .collect()
    }

    /// Divisions with one constant stiffness \[N/m\] each.
    ///
    /// * `transitions`: the phases between one stiffness and the next, increasing, inside
    ///   (0, 1), one fewer than `stiffness`; empty for equal divisions.
    pub fn levels(stiffness: &[f64], transitions: &[f64]) -> Vec<Self> {
        let count = stiffness.len() as f64;
        let end = |i: usize| {
            if transitions.is_empty() {
                (i + 1) as f64 / count
            } else {
                transitions.get(i).copied().unwrap_or(1.0)
            }
        };
        (stiffness.iter().enumerate())
            .map(|(i, &level)| Self::level(end(i), level))
            .collect()
    }
}

/// One harmonic of a stiffness over its cycle, `amplitude cos(2π harmonic φ + phase)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StiffnessHarmonic {
    /// Multiple of the cycle's frequency, ≥ 1.
    pub harmonic: u32,
    /// Amplitude \[N/m\].
    pub amplitude: f64,
    /// Phase \[rad\].
    pub phase: f64,
}

/// One harmonic of the torque on a shaft.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TorqueRipple {
    /// The shaft.
    pub shaft: DriveShaft,
    /// Multiple of that shaft's speed, > 0 (need not be an integer: firing orders).
    pub order: f64,
    /// Amplitude \[N m\].
    pub amplitude: f64,
    /// Phase \[rad\].
    pub phase: f64,
}

/// One harmonic of an imposed uneven rotation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ImposedMotion {
    /// The shaft whose torque imposes it.
    pub shaft: DriveShaft,
    /// Multiple of that shaft's speed, > 0.
    pub order: f64,
    /// Amplitude a of the angle of that shaft \[rad\].
    pub amplitude: f64,
    /// Phase \[rad\].
    pub phase: f64,
}

/// One of the two shafts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum DriveShaft {
    /// The driving shaft.
    Pinion,
    /// The driven shaft.
    Wheel,
}

/// Load and speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatingPoint {
    /// Fraction of the rated mesh force.
    pub load: f64,
    /// Pinion speed Ω \[rad/s\], > 0.
    pub speed: f64,
}

/// Checks that ends of divisions increase, and that the last is 1.
pub(super) fn ends_are_in_order(mesh: &[Division]) -> Result<(), ModelError> {
    let mut before = 0.0;
    for division in mesh {
        let inside = before < division.end && division.end <= 1.0;
        let accepted = "between its neighbours";
        check_in_range("mesh transition", division.end, inside, accepted)?;
        before = division.end;
    }
    check_in_range("end of the mesh cycle", before, before == 1.0, "1")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divisions_end_one_after_the_other_and_the_last_at_1() {
        let refused = |ends: &[f64]| {
            let mesh: Vec<Division> = ends.iter().map(|&end| Division::level(end, 4e8)).collect();
            ends_are_in_order(&mesh).is_err()
        };
        assert!(!refused(&[1.0]) && !refused(&[0.2, 0.6, 1.0]));
        assert!(refused(&[0.6, 0.2, 1.0]) && refused(&[0.5, 0.5, 1.0]));
        assert!(refused(&[0.5]) && refused(&[0.5, 1.2]) && refused(&[0.0, 1.0]));
        assert!(refused(&[]) && refused(&[f64::NAN, 1.0]));
    }

    /// A division whose mirror image starts at the start of the cycle, up to rounding, is not cut.
    #[test]
    fn rounding_cuts_no_mirror_image() {
        let drive = [(0.3, 4e8), (0.7, 3e8), (1.0, 2e8)].map(|(end, k)| Division::level(end, k));
        for off in [-1e-14, 0.0, 1e-14] {
            let coast = Division::mirrored(&drive, 0.5 * (0.7 + off));
            let found: Vec<f64> = coast.iter().map(|own| own.stiffness.mean()).collect();
            assert_eq!(found, [3e8, 4e8, 2e8], "{off}");
            for (own, end) in coast.iter().zip([0.4, 0.7, 1.0]) {
                assert!((own.end - end).abs() < 1e-13, "{off}: {}", own.end);
            }
            assert!(ends_are_in_order(&coast).is_ok());
        }
    }
}
