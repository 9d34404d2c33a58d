//! Does a motion grow without bound?
//!
//! Far beyond the gap the motion is linear on either flank, so that it continues to grow by the same factor.
//! The two flanks meet the varying stiffness at different phases. The stiffness makes the motion grow if it
//! supplies more energy than damping dissipates.

use crate::model::{InitialState, Model, Segment};

/// Largest deflection of a bounded motion, as a multiple of the larger of gap and static deflection.
const UNBOUNDED: f64 = 1e3;

/// Ratio of the largest deflections in the last and in the first quarter of the cycles above which a motion
/// grows. Beats of bounded motions stay below this ratio.
const GROWN: f64 = 10.0;

/// Number of latest states that are checked first. If a motion grows, at least one of them has a deflection
/// beyond [`UNBOUNDED`].
const LATEST_STATES: usize = 8;

/// Smallest number of cycles in which growth is detected.
const FEWEST_CYCLES: usize = 40;

/// Detects motions that grow without bound.
#[derive(Debug, Clone)]
pub struct Bounds {
    /// One entry per line that measures a deflection.
    lines: Vec<Line>,
}

/// A line along which contacts deflect.
#[derive(Debug, Clone)]
struct Line {
    /// A segment on this line.
    segment: Segment,
    /// Largest half gap of its contacts that a motion can reach, at least the half gap of the mesh \[m\].
    gap: f64,
    /// Unit of deflections: the larger of `gap` and the static deflection \[m\].
    unit: f64,
}

/// A motion that grows without bound. The message has the remedy.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the deflection grows by {:.2} % per mesh cycle, to {half_gaps:.1e} half gaps, without bound: varying \
     stiffness supplies more energy than damping dissipates; raise mesh.contact_damping, or avoid this \
     speed",
    100.0 * (growth - 1.0)
)]
pub struct Runaway {
    /// Largest deflection of the motion at the start of a mesh cycle, in half gaps of its line.
    pub half_gaps: f64,
    /// Mean factor of growth per mesh cycle.
    pub growth: f64,
}

impl Bounds {
    /// The bounds of a model.
    pub fn new(model: &Model) -> Self {
        let rest = model.start(&InitialState::Static);
        let deflections = |line: &usize| model.lines[*line].direct.is_empty();
        let lines = (0..model.lines.len())
            .filter(deflections)
            .filter_map(|line| {
                let cycles = model.contacts.iter().flat_map(|contact| &contact.cycles);
                let mut segments = cycles.flat_map(|cycle| &cycle.segments);
                let segment = *segments.find(|segment| model.line(segment) == line)?;
                let gap = model.gap_on(line);
                let at_rest = model.deflection_on(&segment, 0, &rest.state, 0.0).0;
                let unit = gap.max(at_rest.abs());
                Some(Line { segment, gap, unit })
            });
        Self {
            lines: lines.collect(),
        }
    }

    /// The largest deflection of a state, in the unit of its line, and the index of that line.
    fn largest_deflection(&self, model: &Model, state: &[f64]) -> (f64, usize) {
        let lines = self.lines.iter().enumerate().map(|(number, line)| {
            let deflection = model.deflection_on(&line.segment, 0, state, 0.0).0;
            (deflection.abs() / line.unit, number)
        });
        lines.fold((0.0, 0), |most, candidate| {
            if candidate.0 > most.0 { candidate } else { most }
        })
    }

    /// The growth, if states at the starts of successive mesh cycles, oldest first, grow without bound.
    pub fn runaway_in<'a>(
        &self,
        model: &Model,
        states: impl ExactSizeIterator<Item = &'a [f64]> + Clone,
    ) -> Option<Runaway> {
        let count = states.len();
        let far = |state: &[f64]| self.largest_deflection(model, state).0 > UNBOUNDED;
        // For nearly every motion, the latest states rule out growth.
        if count < FEWEST_CYCLES || !states.clone().skip(count - LATEST_STATES).any(far) {
            return None;
        }
        let quarter = count / 4;
        let [mut first, mut last] = [(0.0, 0); 2];
        for (cycle, state) in states.enumerate() {
            let most = if cycle < quarter {
                &mut first
            } else if cycle >= count - quarter {
                &mut last
            } else {
                continue;
            };
            let largest = self.largest_deflection(model, state);
            if largest.0 > most.0 {
                *most = largest;
            }
        }
        let (first, (last, line)) = (first.0, last);
        let line = &self.lines[line];
        (last > UNBOUNDED && last > GROWN * first).then(|| Runaway {
            half_gaps: last * line.unit / line.gap,
            growth: (last / first).powf(1.0 / (count - quarter) as f64),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::OperatingPoint;
    use crate::model::fixtures::{constant_mesh, one_mode};

    /// Checks a motion with these deflections \[half gaps\] at the starts of cycles.
    fn check_deflections(deflections: impl Iterator<Item = f64>) -> Option<Runaway> {
        let point = OperatingPoint {
            load: 1.0,
            speed: 1.0,
        };
        let model = Model::new(&one_mode(1.0), &constant_mesh(1.0, 1.0), point).unwrap();
        let gain = model.first_gains()[0].deflection[0];
        let states: Vec<[f64; 2]> = deflections
            .map(|deflection| [deflection * model.half_gap / gain, 0.0])
            .collect();
        Bounds::new(&model).runaway_in(&model, states.iter().map(|state| &state[..]))
    }

    #[test]
    fn growth_beyond_the_gap_is_found_and_beats_are_not() {
        let growing = |from: f64, rate: f64| (0..200).map(move |n| from * rate.powi(n));
        let found = check_deflections(growing(100.0, 1.05)).unwrap();
        assert!((found.growth - 1.05).abs() < 1e-3, "{found:?}");
        assert!((found.half_gaps / (100.0 * 1.05_f64.powi(199)) - 1.0).abs() < 1e-2);
        assert!(found.to_string().contains("5.00 %"), "{found}");
        // Growth within the gap, slow growth, decay, a beat, and too few cycles.
        assert_eq!(check_deflections(growing(1e-3, 1.05)), None);
        assert_eq!(check_deflections(growing(1e4, 1.005)), None);
        assert_eq!(check_deflections(growing(1e9, 0.95)), None);
        let beat = (0..200).map(|n| 1e5 * (0.1 * f64::from(n)).sin());
        assert_eq!(check_deflections(beat), None);
        assert_eq!(check_deflections(growing(1e4, 2.0).take(30)), None);
    }
}
