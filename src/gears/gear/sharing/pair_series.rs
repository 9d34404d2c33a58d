//! Pairs along their reach as series: a table of helical gears evaluates pairs at millions of positions.
//!
//! Between the kinks of a law, gap, compliances and couplings of a pair are smooth in its position. Each part of the
//! reach has their Legendre series to rounding. Where no series converges, the pair has to come from the law.

use super::error::MOST_PAIRS;
use super::pairs::PairPoint;
use crate::gear::FlankLaw;
use crate::numerics::legendre::{evaluate_each, transforms24};

/// Quantities of a pair: those of [`PairPoint`] besides position and intercept.
const QUANTITIES: usize = 3 + MOST_PAIRS;

/// Terms up to this, relative to the largest value of their quantity, are rounding errors.
const ROUNDING: f64 = 5e-15;

/// A series counts as converged if at least this number of its last terms are rounding errors.
const LAST_TERMS: usize = 4;

/// Largest number of times that a part of the reach is halved.
const MOST_HALVES: u32 = 6;

/// Parts shorter than this, in base pitches, lie between marks that differ by rounding.
const SHORTEST: f64 = 1e-13;

/// The pairs of a law as series in their position.
#[derive(Debug, Clone)]
pub(in crate::gear) struct PairSeries {
    /// Largest value of each quantity at the ends of the parts.
    scale: [f64; QUANTITIES],
    /// In order of position.
    parts: Vec<Part>,
}

/// A part of the reach.
#[derive(Debug, Clone)]
struct Part {
    /// Its ends on the line of action \[m\].
    ends: [f64; 2],
    /// Coefficients of all quantities, term by term; empty if they do not converge.
    series: Vec<[f64; QUANTITIES]>,
}

impl PairSeries {
    pub fn new(law: &impl FlankLaw) -> Self {
        let (path, [first, last]) = (law.path(), law.reach());
        // A coupling has the kinks of both pairs.
        let kinks = [law.kinks(), vec![path.start, path.end]].concat();
        let pairs = 0..MOST_PAIRS;
        let mut marks: Vec<f64> = (kinks.into_iter())
            .flat_map(|kink| {
                (pairs.clone()).map(move |ahead| kink - ahead as f64 * path.base_pitch)
            })
            .filter(|mark| *mark > first && *mark < last)
            .chain([first, last])
            .collect();
        marks.sort_unstable_by(f64::total_cmp);
        marks.dedup_by(|later, earlier| *later - *earlier < SHORTEST * path.base_pitch);
        let mut series = Self {
            scale: [0.0; QUANTITIES],
            parts: Vec::new(),
        };
        for &mark in &marks {
            for (scale, value) in series.scale.iter_mut().zip(exact(law, mark)) {
                // Rounding may put the end of the reach into a fillet, where the gap is infinite.
                *scale = scale.max(if value.is_finite() { value.abs() } else { 0.0 });
            }
        }
        for ends in marks.windows(2) {
            series.add(law, [ends[0], ends[1]], 0);
        }
        series
    }

    /// Adds the series of a part, halved until they converge. A part whose series do not converge has none.
    fn add(&mut self, law: &impl FlankLaw, ends: [f64; 2], halves: u32) {
        let [from, to] = ends;
        let middle = 0.5 * (from + to);
        let transforms = transforms24();
        let values = transforms
            .nodes()
            .map(|x| exact(law, middle + 0.5 * (to - from) * x));
        let mut series = vec![[0.0; QUANTITIES]; values.len()];
        for quantity in 0..QUANTITIES {
            let terms = transforms.interpolate(&values.map(|values| values[quantity]));
            for (all, term) in series.iter_mut().zip(terms) {
                all[quantity] = term;
            }
        }
        // The comparison also rejects NaN.
        let is_rounding = |terms: &&[f64; QUANTITIES]| {
            let mut terms = terms.iter().zip(&self.scale);
            terms.all(|(term, scale)| term.abs() <= ROUNDING * scale)
        };
        let rounding = series.iter().rev().take_while(is_rounding).count();
        if rounding >= LAST_TERMS {
            series.truncate(series.len() - rounding);
            self.parts.push(Part { ends, series });
        } else if halves < MOST_HALVES {
            self.add(law, [from, middle], halves + 1);
            self.add(law, [middle, to], halves + 1);
        } else {
            let series = Vec::new();
            self.parts.push(Part { ends, series });
        }
    }

    /// The pair at a position within reach. `None` if no series converges there.
    pub fn at(&self, position: f64) -> Option<PairPoint> {
        let part = self.parts.partition_point(|part| part.ends[1] < position);
        let Part { ends, series } = self.parts.get(part)?;
        if series.is_empty() {
            return None;
        }
        let [from, to] = ends;
        let place = (2.0 * position - from - to) / (to - from);
        let [missing, teeth, contact, foundation, one, two] = evaluate_each(series, place);
        Some(PairPoint {
            position,
            missing,
            teeth,
            contact,
            intercept: 0.0,
            foundation,
            coupling: [one, two],
        })
    }
}

/// The quantities of a pair by its law. All couplings are computed, because rounding may put the pair ahead
/// beyond the end of the reach.
fn exact(law: &impl FlankLaw, position: f64) -> [f64; QUANTITIES] {
    let point = PairPoint::new(law, position, MOST_PAIRS - 1);
    let [one, two] = point.coupling;
    [
        point.missing,
        point.teeth,
        point.contact,
        point.foundation,
        one,
        two,
    ]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::gear::{Flanks, Relief, ToothForm, fixtures};

    /// Reliefs, ends of the path and of virtual teeth, and tip edges off the path bend the law.
    #[test]
    fn the_series_are_the_law() {
        let relief = Relief {
            amount: 20e-6,
            length: 2e-3,
            ..Relief::default()
        };
        let form = ToothForm {
            bore: [Some(30e-3), Some(40e-3)],
            tip_relief: [relief; 2],
            ..ToothForm::default()
        };
        for (teeth, helix_angle) in [([20, 30], 0.0), ([20, 30], 0.3), ([45, 80], -0.5)] {
            let pair = crate::gear::GearPair {
                helix_angle,
                ..fixtures::pair(teeth, form.clone())
            };
            let flanks = Flanks::new(&pair).unwrap();
            let series = PairSeries::new(&flanks);
            let [first, last] = FlankLaw::reach(&flanks);
            let pitch = FlankLaw::path(&flanks).base_pitch;
            // Near the base circle of the mate the gap of a tip edge varies as a square root, and no series converges.
            let mut exactly = 0;
            for step in 0..=4000 {
                let position = first + (last - first) * f64::from(step) / 4000.0;
                let ahead = ((last - position) / pitch) as usize;
                let exact = PairPoint::new(&flanks, position, ahead);
                let Some(found) = series.at(position) else {
                    exactly += 1;
                    continue;
                };
                let compliance = exact.compliance();
                let close = |found: f64, exact: f64, scale: f64| {
                    assert!(
                        (found - exact).abs() < 1e-13 * scale,
                        "{position}: {found} {exact}"
                    );
                };
                close(found.missing, exact.missing, 1e-4);
                close(found.teeth, exact.teeth, compliance);
                close(found.contact, exact.contact, compliance);
                close(found.foundation, exact.foundation, compliance);
                for (found, exact) in found.coupling.into_iter().zip(exact.coupling).take(ahead) {
                    close(found, exact, compliance);
                }
            }
            assert!(exactly < 40, "{exactly}");
        }
    }
}
