//! Where and in which direction do contact forces act on the blocks? The line of action, the load centroid and the
//! friction of every segment.

use super::basis::Basis;
use super::{Block, Division, MeshGain, TransmissionErrorHarmonic};
use crate::structure::FlankParticipation;

/// Gains between a contact and all blocks while its line of action and the direction of its friction are
/// constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// One entry per block.
    pub gains: Vec<MeshGain>,
    /// Line of its deflection, as an index into [`super::Model::lines`].
    pub line: usize,
    /// Friction power per contact force and per relative rotational speed of the gears of the first mesh,
    /// `μ_f Σ p |s|` \[m\], with the load shares p of the pairs of teeth and their positions s on the path of
    /// contact. It is negative if a new pair takes load from a pair that slides faster.
    pub rubbing: f64,
    /// Static force on each bearing per unit of the contact force, from the omitted modes; empty if
    /// there are none.
    pub on_bearings: Vec<f64>,
}

impl Direction {
    /// `w·g` and `w A·g` of every block, with the g of another direction.
    fn effects(&self, other: &Self) -> [impl Iterator<Item = f64>; 2] {
        [
            |gain: &MeshGain| gain.deflection,
            |gain: &MeshGain| gain.rate,
        ]
        .map(|row| {
            let pairs = self.gains.iter().zip(&other.gains);
            pairs.map(move |(own, other)| {
                let ([r1, r2], [g1, g2]) = (row(own), other.mesh_input);
                r1 * g1 + r2 * g2
            })
        })
    }

    /// `Σ |w·g|` and `Σ |w A·g|` over the blocks: upper bounds of the effect of a unit force on the first and
    /// on the second derivative of the deflection \[1/kg\].
    pub fn effect_bounds(&self) -> [f64; 2] {
        self.effects(self)
            .map(|effects| effects.map(f64::abs).sum())
    }

    /// `|Σ w·g|` and `|Σ w A·g|` with the g of another direction: the effect of a unit force along the other
    /// direction on the first and on the second derivative of the deflection along this one \[1/kg\].
    pub fn effect_of(&self, other: &Self) -> [f64; 2] {
        self.effects(other)
            .map(|effects| effects.sum::<f64>().abs())
    }
}

/// A line along which a deflection is measured, `δ = Σ w·x − e(t)`. All directions of a line have the same w.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Harmonics of the imposed transmission error e.
    pub transmission_error: Vec<TransmissionErrorHarmonic>,
    /// Immediate effect of an input of each block on the quantity of the line. It is empty if this quantity
    /// is a deflection, which inputs change only through the state. It is not empty if the quantity is the
    /// force of a constraint, such as a rigid stop on which the structure rests ([`super::Stop`]).
    pub direct: Vec<[f64; 2]>,
}

impl Line {
    /// Transmission error and its rate, `(e [m], e' [m/s])`, at a time \[s\] within a mesh cycle.
    pub fn transmission_error_at(&self, cycle: u64, time: f64) -> (f64, f64) {
        let mut error = 0.0;
        let mut rate = 0.0;
        for h in &self.transmission_error {
            let (sin, cos) = (h.turned(cycle, time) + h.phase).sin_cos();
            error += h.amplitude * cos;
            rate -= h.amplitude * h.angular_frequency * sin;
        }
        (error, rate)
    }
}

/// The distinct directions and lines of a model's contacts.
#[derive(Debug, Default)]
pub(super) struct Directions {
    pub directions: Vec<Direction>,
    pub lines: Vec<Line>,
}

impl Directions {
    /// The indices of the directions of a flank's divisions, with `w = mesh + z_c tilt` and
    /// `g = w + μ (Λ₀ friction + Λ₁ lever)` for every block. `left_out` has the static forces on each bearing
    /// per unit force of the flank ([`crate::structure::OmittedModeForces`]).
    pub fn of_flank(
        &mut self,
        flank: &FlankParticipation,
        mesh: &[Division],
        friction: f64,
        error: &[TransmissionErrorHarmonic],
        left_out: &[[f64; 4]],
        (basis, blocks): (&Basis, &[Block]),
    ) -> Vec<usize> {
        // Most divisions have the same direction as the previous one.
        let mut last: Option<([f64; 3], usize)> = None;
        (mesh.iter())
            .map(|division| {
                let [turn, lever] = division.friction;
                let centre = division.centre();
                let law = [centre, turn, lever];
                if let Some((_, same)) = last.filter(|(known, _)| *known == law) {
                    return same;
                }
                let (w, g): (Vec<f64>, Vec<f64>) = (0..blocks.len())
                    .map(|i| {
                        let w = flank.mesh[i] + centre * flank.tilt[i];
                        let rubbing = turn * flank.friction[i] + lever * flank.lever[i];
                        (w, w + friction * rubbing)
                    })
                    .unzip();
                let weights = [1.0, centre, friction * turn, friction * lever];
                let on_bearings = (left_out.iter())
                    .map(|share| -share.iter().zip(weights).map(|(s, w)| s * w).sum::<f64>())
                    .collect();
                let gains = basis.gains(blocks, &w, &g);
                let index = self.add(gains, -friction * lever, error, on_bearings);
                last = Some((law, index));
                index
            })
            .collect()
    }

    /// The index of the direction with these gains, this [`Direction::rubbing`] \[m\], this transmission
    /// error and these static forces on bearings. The direction is added if it is new.
    pub fn add(
        &mut self,
        gains: Vec<MeshGain>,
        rubbing: f64,
        error: &[TransmissionErrorHarmonic],
        on_bearings: Vec<f64>,
    ) -> usize {
        let line = Line {
            transmission_error: error.to_vec(),
            direct: Vec::new(),
        };
        self.add_along(line, gains, rubbing, on_bearings)
    }

    /// As [`Self::add`], for a direction whose line has these errors and immediate effects.
    pub fn add_along(
        &mut self,
        line: Line,
        gains: Vec<MeshGain>,
        rubbing: f64,
        on_bearings: Vec<f64>,
    ) -> usize {
        let along = |known: &Direction| {
            let pairs = known.gains.iter().zip(&gains);
            let mut same = pairs.map(|(a, b)| a.deflection == b.deflection);
            self.lines[known.line] == line && same.all(|same| same)
        };
        let line = match self.directions.iter().find(|known| along(known)) {
            Some(known) => known.line,
            None => {
                self.lines.push(line);
                self.lines.len() - 1
            }
        };
        let direction = Direction {
            gains,
            line,
            rubbing,
            on_bearings,
        };
        let known = self.directions.iter().position(|known| *known == direction);
        known.unwrap_or_else(|| {
            self.directions.push(direction);
            self.directions.len() - 1
        })
    }
}
