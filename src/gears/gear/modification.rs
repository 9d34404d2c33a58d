//! Material that is missing from the involute flanks, normal to the flank, by design or by errors of manufacture. It
//! varies along the profile and along the lead (ISO 21771, clause 9).

use strum::EnumString;

/// Relief of a flank, from 0 at its start to its maximum at the end of the flank.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Relief {
    /// Largest amount of material taken off, normal to the flank \[m\]; 0: no relief.
    pub amount: f64,
    /// Length over which it falls to 0 \[m\]: along the line of action (base radius times roll angle), or along the
    /// face.
    pub length: f64,
    /// How it rises.
    pub course: ReliefCourse,
}

/// How relief rises over its length.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum ReliefCourse {
    /// Proportional to the distance.
    #[default]
    Linear,
    /// Proportional to its square, without a kink at the start.
    Parabolic,
}

impl Relief {
    /// Material missing at a distance from the end of the flank \[m\].
    pub fn at(&self, from_end: f64) -> f64 {
        if self.amount == 0.0 {
            return 0.0;
        }
        let part = (1.0 - from_end / self.length).clamp(0.0, 1.0);
        match self.course {
            ReliefCourse::Linear => self.amount * part,
            ReliefCourse::Parabolic => self.amount * part * part,
        }
    }
}

/// Modification of a gear's whole flank in one direction.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Modification {
    /// Crowning: material missing at both ends, with the square of the distance from the middle \[m\].
    pub crowning: f64,
    /// Slope: difference of the missing material between tip and root, or between the face ends of positive and
    /// negative z \[m\].
    pub slope: f64,
}

impl Modification {
    /// Material missing at a position from −1 to 1 across the flank \[m\]; a slope is 0 in the middle.
    pub fn at(&self, place: f64) -> f64 {
        self.crowning * place * place + 0.5 * self.slope * place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relief_rises_to_its_amount_at_the_end() {
        let linear = Relief {
            amount: 8e-6,
            length: 2e-3,
            course: ReliefCourse::Linear,
        };
        let parabolic = Relief {
            course: ReliefCourse::Parabolic,
            ..linear
        };
        for (from_end, one, other) in [
            (0.0, 8e-6, 8e-6),
            (1e-3, 4e-6, 2e-6),
            (2e-3, 0.0, 0.0),
            (5e-3, 0.0, 0.0),
        ] {
            assert!((linear.at(from_end) - one).abs() < 1e-18);
            assert!((parabolic.at(from_end) - other).abs() < 1e-18);
        }
    }

    #[test]
    fn crowning_is_missing_at_both_ends_and_a_slope_between_them() {
        let both = Modification {
            crowning: 5e-6,
            slope: 4e-6,
        };
        for (place, missing) in [(-1.0, 3e-6), (0.0, 0.0), (1.0, 7e-6)] {
            assert!((both.at(place) - missing).abs() < 1e-18);
        }
    }
}
