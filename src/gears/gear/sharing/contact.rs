//! How is the contact law of flanks that stiffen under load linearised at the load of each pair?

use super::LoadSharing;
use super::error::{MOST_PAIRS, SharingError};
use super::helical::HelicalFace;
use super::pairs::{Face, PairPoint, pairs_at};
use crate::gear::FlankLaw;

/// How the flanks flatten at their contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Contact {
    /// In proportion to the load.
    Linear,
    /// In proportion to the load, with the secant of [`FlankLaw::contact`] at the line load of a pair that carries the
    /// whole force.
    Secant,
    /// By [`FlankLaw::contact`] at the mean line load of each pair's loaded part; for helical gears at the mean line
    /// load of all pairs.
    LoadDependent,
}

/// Relative change of line loads at convergence.
const SETTLED: f64 = 1e-12;

/// Largest number of rounds. Each linearises the law at the result of the previous one, so a smooth law
/// takes a few.
const ROUNDS: usize = 50;

/// The contact of a pair below this part of the mean line load is linearised at
/// that part: laws that stiffen have no finite compliance at zero load.
const LEAST_LOAD: f64 = 1e-2;

impl LoadSharing {
    /// The pairs at mesh phase `phase`, with their contact linearised at its load under a force > 0 \[N\].
    /// Valid for that force only.
    ///
    /// The tangent of the contact law, a compliance and an intercept, replaces the law of each pair at the mean line
    /// load over its loaded length. The load is shared again until the line loads repeat. If the line load is even
    /// across the face, deflection and stiffness are those of the law. Otherwise the mean represents the line load.
    ///
    /// # Errors
    /// Those of [`LoadSharing::new`], a contact law that is not
    /// finite or does not converge.
    pub fn under(
        law: &impl FlankLaw,
        phase: f64,
        face: Face,
        misalignment: f64,
        force: f64,
    ) -> Result<Self, SharingError> {
        if law.helix() != 0.0 {
            let face = HelicalFace::new(law, phase, face)?;
            return face.sharing_under(law, misalignment, force);
        }
        let mut pairs = pairs_at(law, phase, face)?;
        let least = LEAST_LOAD * force / face.width;
        let mut line_load = [force / face.width / pairs.len().max(1) as f64; MOST_PAIRS];
        let mut moved = 0;
        for _ in 0..ROUNDS {
            for (pair, line_load) in pairs.iter_mut().zip(line_load) {
                pair.point.linearise(law, line_load)?;
            }
            let mut sharing = Self::new(&pairs, face, misalignment)?;
            let (shared, lengths) = sharing.distribute_with_lengths(force);
            let settled = |old: f64, new: f64| (new - old).abs() <= SETTLED * old;
            let forces: [f64; MOST_PAIRS] = std::array::from_fn(|pair| {
                if lengths[pair] > 0.0 {
                    shared.share[pair] * force / lengths[pair]
                } else {
                    0.0
                }
            });
            let next = forces.map(|line_load| line_load.max(least));
            let unsettled = (0..pairs.len()).find(|&pair| !settled(line_load[pair], next[pair]));
            match unsettled {
                None => {
                    sharing.line_load_excess = forces.map(|line_load| line_load - least);
                    return Ok(sharing);
                }
                Some(pair) => moved = pair,
            }
            line_load = next;
        }
        Err(SharingError::Unsettled {
            position: pairs[moved].position(),
        })
    }
}

impl PairPoint {
    /// Takes the tangent of the contact law at a line load \[N/m\].
    pub(super) fn linearise(
        &mut self,
        law: &impl FlankLaw,
        line_load: f64,
    ) -> Result<(), SharingError> {
        let [approach, slope] = law.contact(self.position, line_load);
        for (name, value, valid, accepted) in [
            (
                "approach of the flanks by their contact [m]",
                approach,
                approach.is_finite(),
                "finite",
            ),
            (
                "tangent compliance of teeth and contact [m²/N]",
                self.teeth + slope,
                self.teeth + slope > 0.0 && slope.is_finite(),
                "positive and finite",
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
        self.contact = slope;
        self.intercept = approach - slope * line_load;
        Ok(())
    }
}
