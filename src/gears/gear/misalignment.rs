//! How are the flanks misaligned if the shafts deflect under their load?
//!
//! The mesh force F at z_c tilts the gears relative to each other, which moves z_c. With the
//! structure's participations w and w₁ the tilt closes or opens the flanks by
//!
//! ```text
//! θ = a F + b F z_c,   a = Σ w w₁ / ω²,   b = Σ w₁² / ω²
//! ```
//!
//! and the equation is `ε = ε₀ + θ(z_c(ε))`. A load off mid-face turns the gears so that the loaded
//! side recedes (b > 0), while z_c falls as ε grows: `ε − ε₀ − θ` rises with ε, at least as fast
//! as ε, and has one root.

use crate::structure::ModalStructure;

/// Relative tilt of the flanks under a static mesh force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TiltCompliance {
    /// By a force at mid-face, a \[rad/N\].
    pub by_force: f64,
    /// By the moment of a force off mid-face, b ≥ 0 \[rad/(N m)\].
    pub by_moment: f64,
}

impl TiltCompliance {
    /// The compliance of elastic modes: frequencies ω \[rad/s\] (rigid modes have 0 and are
    /// skipped), participations w \[1/√kg\] and w₁ \[1/(m √kg)\].
    pub fn of_modes(frequency: &[f64], mesh: &[f64], mesh_tilt: &[f64]) -> Self {
        let (mut by_force, mut by_moment) = (0.0, 0.0);
        for ((omega, w), tilt) in frequency.iter().zip(mesh).zip(mesh_tilt) {
            if *omega > 0.0 {
                by_force += w * tilt / (omega * omega);
                by_moment += tilt * tilt / (omega * omega);
            }
        }
        Self {
            by_force,
            by_moment,
        }
    }

    /// The compliance of a flank of a structure, by its number in [`ModalStructure::tilt_columns`]: the sum over the
    /// elastic modes of the structure and its omitted modes.
    pub fn of_flank(structure: &ModalStructure, flank: usize) -> Self {
        let columns = structure.tilt_columns().nth(flank);
        let [mesh, tilt] = columns.unwrap_or([&[]; 2]);
        let of_modes = Self::of_modes(&structure.frequency, mesh, tilt);
        let residual = structure.tilt_residuals.get(flank).copied();
        let [by_force, by_moment] = residual.unwrap_or_default();
        Self {
            by_force: of_modes.by_force + by_force,
            by_moment: of_modes.by_moment + by_moment,
        }
    }

    /// The compliance for positions across the face in reversed order: the tilt by a force at mid-face
    /// changes its sign. The coast flank is computed as the mirror image of the drive flank, with reversed
    /// positions. Bent shafts open both flanks at the same end of the face, which is the opposite end in the
    /// image.
    pub fn other_way_round(self) -> Self {
        Self {
            by_force: -self.by_force,
            ..self
        }
    }

    /// Tilt under a force \[N\] at `centre` \[m\] from mid-face \[rad\].
    pub fn tilt(&self, force: f64, centre: f64) -> f64 {
        (self.by_force + self.by_moment * centre) * force
    }
}

/// Settings of the fixed-point search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MisalignmentSearch {
    /// Relaxation of the first step, in (0, 1\]; later steps follow Aitken.
    pub relaxation: f64,
    /// Largest accepted residual of the misalignment, `|ε₀ + θ − ε|` \[rad\].
    pub tolerance: f64,
    /// Largest number of evaluations of the load centroid.
    pub limit: usize,
}

impl Default for MisalignmentSearch {
    fn default() -> Self {
        Self {
            relaxation: 0.7,
            tolerance: 1e-12,
            limit: 50,
        }
    }
}

/// One evaluation of the load centroid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MisalignmentStep {
    /// Trial misalignment \[rad\].
    pub misalignment: f64,
    /// Load centroid there \[m\].
    pub centre: f64,
    /// Misalignment of the structure under that load minus the trial value \[rad\].
    pub residual: f64,
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MisalignmentEnding {
    /// The last step meets the tolerance.
    Converged,
    /// The limit was reached first. The last step need not have the smallest residual.
    LimitReached,
    /// The last step's centroid or residual is not finite.
    NotFinite,
}

/// A search for the misalignment under load.
#[derive(Debug, Clone, PartialEq)]
pub struct MisalignmentReport {
    /// Every evaluation, in order.
    pub steps: Vec<MisalignmentStep>,
    /// How it ended.
    pub ending: MisalignmentEnding,
}

impl MisalignmentReport {
    /// The last trial misalignment \[rad\]: the solution if the search converged. `None` without steps.
    pub fn misalignment(&self) -> Option<f64> {
        self.steps.last().map(|step| step.misalignment)
    }
}

/// Searches the misalignment under load. The first trial value is the misalignment without load, `unloaded` \[rad\].
///
/// * `centre`: load centroid at a misalignment \[m\], averaged over the mesh cycle, under the
///   same mean mesh force `force` \[N\].
///
/// Relaxation follows Irons & Tuck 1969 (Aitken's Δ², the secant in one dimension) within (0, 1\], the range for a
/// rising `ε − ε₀ − θ`: a larger value counts as 1, a value that is not positive is ignored. The signs of the residuals
/// give a bracket. Its middle replaces a step outside the bracket: the search does not oscillate on very soft shafts.
pub fn loaded_misalignment(
    unloaded: f64,
    force: f64,
    compliance: TiltCompliance,
    search: MisalignmentSearch,
    mut centre: impl FnMut(f64) -> f64,
) -> MisalignmentReport {
    let mut steps: Vec<MisalignmentStep> = Vec::new();
    let mut relaxation = search.relaxation;
    let mut misalignment = unloaded;
    // Largest trial value that is too small, smallest that is too large.
    let mut bracket = [f64::NEG_INFINITY, f64::INFINITY];
    let ending = loop {
        if steps.len() == search.limit {
            break MisalignmentEnding::LimitReached;
        }
        let centre = centre(misalignment);
        let residual = unloaded + compliance.tilt(force, centre) - misalignment;
        let last = steps.last().map(|step| step.residual);
        steps.push(MisalignmentStep {
            misalignment,
            centre,
            residual,
        });
        if !residual.is_finite() {
            break MisalignmentEnding::NotFinite;
        }
        if residual.abs() <= search.tolerance {
            break MisalignmentEnding::Converged;
        }
        if let Some(last) = last {
            let aitken = relaxation * last / (last - residual);
            if aitken > 0.0 && aitken.is_finite() {
                relaxation = aitken.min(1.0);
            }
        }
        bracket[usize::from(residual < 0.0)] = misalignment;
        misalignment += relaxation * residual;
        if misalignment <= bracket[0] || misalignment >= bracket[1] {
            misalignment = 0.5 * (bracket[0] + bracket[1]);
        }
    };
    MisalignmentReport { steps, ending }
}
