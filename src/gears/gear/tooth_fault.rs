//! Teeth with a different stiffness or profile: which mesh cycles do they change, and how?
//!
//! The pair of tooth n first touches at the start of mesh cycle n, at mid-face. While it is in contact it carries the
//! share σ of the mesh, as with evenly shared load. A tooth that reduces its pair's stiffness to the part f and whose
//! flanks miss material d changes the mesh to
//!
//! ```text
//! k' = k (1 − (1 − f) σ),    gap' = gap + σ d,    1/f = 1/f₀ + σ k c,
//! ```
//!
//! where c is the deflection per force that a crack adds ([`RootCrack`]), as long as all pairs of the mesh
//! touch. If both teeth of a pair have faults, their compliances add: 1/f − 1 is the sum of both. Cycles
//! repeat after a revolution of the gear. With faults of both gears they repeat after the hunting cycle, the
//! least common multiple of the numbers of teeth. If every pair is a separate spring, only the pair of the
//! faulty tooth differs ([`FaultyFlanks`](super::FaultyFlanks)).

use super::{EvenSharing, RootCrack};
use crate::model::{Division, FlankError};
use crate::numerics::integers::least_multiple;
use serde::Serialize;

/// Approximate number of cycles after which the middle of a pinion tooth passes the line of centres, counted from the
/// passage of its drive flank at the pitch point: half the thickness of the tooth, which is about half a pitch thick.
const HALF_TOOTH: f64 = 0.25;

/// A tooth that differs from the others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ToothFault {
    /// 0 for the pinion, 1 for the wheel.
    pub gear: usize,
    /// Number of the tooth, from 0, in the order of engagement: tooth 0 engages in mesh cycle 0.
    pub tooth: u32,
    /// Remaining part f₀ of the stiffness of its pair without the crack, in (0, 1].
    pub stiffness: f64,
    /// Crack at the root of its drive flank and its coast flank.
    pub cracks: [Option<RootCrack>; 2],
    /// Material missing from its drive flank and its coast flank along the line of action, d \[m\].
    #[serde(rename = "lacks")]
    pub missing: [f64; 2],
}

impl ToothFault {
    /// Compliance `1/f − 1` that the fault adds to a pair on a flank, relative to that of the sound pair.
    /// `since` is the time after the first touch \[cycles\], `stiffness` that of the sound pair \[N/m\].
    fn added_compliance(&self, flank: usize, since: f64, stiffness: f64) -> f64 {
        let crack = self.cracks[flank].map_or(0.0, |crack| crack.at(since));
        (1.0 / self.stiffness - 1.0) + stiffness * crack
    }
}

/// A pair of gears with some teeth that differ from the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultyTeeth {
    /// The teeth.
    pub faults: Vec<ToothFault>,
    /// Numbers of teeth.
    pub teeth: [u32; 2],
    /// How pairs share the load.
    pub pairs: EvenSharing,
    /// Mesh phase about which coast flanks mirror the drive flanks ([`GearPair::symmetry`](super::GearPair::symmetry)).
    pub symmetry: f64,
}

/// Direction of time on a flank: forwards on drive flanks, mirrored about the time `twice / 2` \[cycles\] on
/// coast flanks.
#[derive(Debug, Clone, Copy)]
enum FlankOrder {
    Drive,
    Coast { twice: f64 },
}

impl FaultyTeeth {
    /// Number of mesh cycles after which all faults repeat.
    pub fn base_cycles(&self) -> usize {
        let of_faults = self
            .faults
            .iter()
            .map(|fault| self.teeth[fault.gear] as usize);
        of_faults.fold(1, least_multiple)
    }

    /// The divisions of each base cycle on the drive flanks, from the divisions of a cycle with equal teeth.
    pub fn on_drive(&self, sound: &[Division]) -> Vec<Vec<Division>> {
        self.cycles(sound, FlankOrder::Drive)
    }

    /// As [`Self::on_drive`], on the coast flanks. They mirror the drive flanks about the time at which tooth 0 of the
    /// pinion is on the line of centres.
    pub fn on_coast(&self, sound: &[Division]) -> Vec<Vec<Division>> {
        let twice = self.coast_turn();
        self.cycles(sound, FlankOrder::Coast { twice })
    }

    /// Twice the time about which coast flanks mirror drive flanks \[cycles\]. At that time tooth 0 of the pinion is on
    /// the line of centres.
    pub fn coast_turn(&self) -> f64 {
        let centred = self.pairs.pitch_phase + HALF_TOOTH;
        let twice = 2.0 * self.symmetry;
        twice + (2.0 * centred - twice).round()
    }

    fn cycles(&self, sound: &[Division], course: FlankOrder) -> Vec<Vec<Division>> {
        let ends = self.pairs.contact_breaks(|mark| match course {
            FlankOrder::Drive => mark,
            FlankOrder::Coast { twice } => twice - mark,
        });
        let pieces = EvenSharing::cut_at(sound, &ends);
        (0..self.base_cycles())
            .map(|cycle| {
                let starts = std::iter::once(0.0).chain(pieces.iter().map(|piece| piece.end));
                let changed: Vec<Division> = (starts.zip(&pieces))
                    .map(|(start, piece)| {
                        let middle = cycle as f64 + 0.5 * (start + piece.end);
                        self.changed(piece, middle, course)
                    })
                    .collect();
                if changed == pieces { sound.to_vec() } else { changed }
            })
            .collect()
    }

    /// A division at a time \[cycles\], changed by the faults of the pairs that are in contact then.
    fn changed(&self, division: &Division, time: f64, course: FlankOrder) -> Division {
        let mean = division.stiffness.mean();
        // Time since the first touch, share and added compliance of every pair with a fault.
        let mut pairs: Vec<[f64; 3]> = Vec::new();
        let mut missing = 0.0;
        for fault in &self.faults {
            let number = f64::from(fault.tooth);
            let (since, flank) = match course {
                FlankOrder::Drive => (time - number, 0),
                // On coast flanks tooth n of the wheel meets tooth n − 1 of the pinion.
                FlankOrder::Coast { twice } => (twice + number - fault.gear as f64 - time, 1),
            };
            let since = self.pairs.within_turn(since, self.teeth[fault.gear]);
            let share = self.pairs.share(since);
            missing += share * fault.missing[flank];
            let added = fault.added_compliance(flank, since, share * mean);
            // The first touches of different pairs are at least one cycle apart.
            match pairs.iter_mut().find(|pair| (pair[0] - since).abs() < 0.5) {
                Some(pair) => pair[2] += added,
                None => pairs.push([since, share, added]),
            }
        }
        let lost = |[_, share, added]: &[f64; 3]| share * added / (1.0 + added);
        let left = 1.0 - pairs.iter().map(lost).sum::<f64>();
        let mut error = *division.error.coefficients();
        error[0] += missing;
        Division {
            stiffness: division.stiffness.times(left),
            error: FlankError::series(error),
            ..*division
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::friction_turns::tests::PAIRS;

    fn teeth(gear: usize, tooth: u32) -> FaultyTeeth {
        let fault = ToothFault {
            gear,
            tooth,
            stiffness: 0.6,
            cracks: [None; 2],
            missing: [4e-6, 1e-6],
        };
        FaultyTeeth {
            faults: vec![fault],
            teeth: [5, 7],
            pairs: PAIRS,
            symmetry: 0.48,
        }
    }

    /// Stiffness and gap in the middle of each division, and its end.
    fn summary(cycle: &[Division]) -> Vec<[f64; 3]> {
        let one = |division: &Division| {
            [
                division.end,
                division.stiffness.mean(),
                division.error.coefficients()[0],
            ]
        };
        cycle.iter().map(one).collect()
    }

    fn near(found: &[[f64; 3]], exact: &[[f64; 3]]) {
        assert_eq!(found.len(), exact.len(), "{found:?}");
        for (a, b) in found.iter().flatten().zip(exact.iter().flatten()) {
            assert!((a - b).abs() <= 1e-12 * b.abs(), "{found:?} {exact:?}");
        }
    }

    /// Tooth 3 shares the load with tooth 2, carries it alone, and shares it with tooth 4.
    #[test]
    fn a_tooth_changes_the_cycles_of_its_pair() {
        let sound = Division::levels(&[4.0, 3.0], &[0.6]);
        let cycles = teeth(0, 3).on_drive(&sound);
        assert_eq!(cycles.len(), 5);
        near(&summary(&cycles[3]), &[[0.6, 3.2, 2e-6], [1.0, 1.8, 4e-6]]);
        near(&summary(&cycles[4]), &[[0.6, 3.2, 2e-6], [1.0, 3.0, 0.0]]);
        assert!(cycles[..3].iter().all(|cycle| *cycle == sound));
        // The last tooth stays in contact into the next revolution.
        let cycles = teeth(1, 6).on_drive(&sound);
        near(&summary(&cycles[0]), &[[0.6, 3.2, 2e-6], [1.0, 3.0, 0.0]]);
        assert_eq!((cycles.len(), &cycles[1]), (7, &sound));
    }

    /// The coast flank of tooth 0 of the pinion mirrors its drive flank about 0.98, where the tooth is on the line of
    /// centres.
    #[test]
    fn coast_flanks_mirror_the_tooth() {
        let drive = Division::levels(&[4.0, 3.0], &[0.6]);
        let sound = Division::mirrored(&drive, 0.98);
        // Touches from 2 · 0.98 − 1.6 = 0.36 to 1.96, alone from 0.96 to 1.36.
        let cycles = teeth(0, 0).on_coast(&sound);
        near(
            &summary(&cycles[0]),
            &[[0.36, 3.0, 0.0], [0.96, 3.2, 5e-7], [1.0, 1.8, 1e-6]],
        );
        near(
            &summary(&cycles[1]),
            &[[0.36, 1.8, 1e-6], [0.96, 3.2, 5e-7], [1.0, 3.0, 0.0]],
        );
        // Tooth 1 of the wheel touches the coast flank of tooth 0 of the pinion.
        let of_wheel = teeth(1, 1).on_coast(&sound);
        assert_eq!(of_wheel[..2], cycles[..2]);
        assert_eq!(of_wheel.len(), 7);
    }

    /// Faults of both gears repeat after the hunting cycle. Shares of a helical pair add up to one.
    #[test]
    fn hunting_cycles_have_all_pairs_of_teeth() {
        let mut both = teeth(0, 3);
        both.faults.push(teeth(1, 2).faults[0]);
        both.pairs.overlap_ratio = 0.7;
        assert_eq!(both.base_cycles(), 35);
        let cycles = both.on_drive(&Division::levels(&[4.0], &[]));
        let lost: f64 = (cycles.iter())
            .map(|cycle| {
                let starts = std::iter::once(0.0).chain(cycle.iter().map(|own| own.end));
                let lost = starts
                    .zip(cycle)
                    .map(|(start, own)| (own.end - start) * (1.0 - own.stiffness.mean() / 4.0));
                lost.sum::<f64>()
            })
            .sum();
        // Each pair carries one cycle's load in total. The pinion's faulty tooth is in contact 7 times, that of the
        // wheel 5 times, once with each other. Their pair is left with 1/(1 + 2 (1/0.6 − 1)) = 3/7 of its stiffness.
        assert!(
            (lost / (0.4 * 10.0 + 4.0 / 7.0) - 1.0).abs() < 1e-3,
            "{lost}"
        );
    }
}
