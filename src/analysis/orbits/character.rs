//! How robust is a periodic orbit, and how does it lose its stability?

use super::shooting::PeriodicOrbit;
use crate::analysis::modal_series::padded;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::poincare::extrema;
use crate::model::{Model, TrajectoryState};
use crate::numerics::legendre::evaluate;
use crate::numerics::linalg::{norm, product};
use crate::propagate::{Counters, Event, Kernel, Observer, Stop, Window};
use faer::Mat;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Size of the kick that an orbit is tried with, in half gaps.
pub const KICK: f64 = 1e-5;

/// Power iterations for the direction of strongest growth; they stop when it stands still.
const MOST_ITERATIONS: usize = 200;

/// Turn of the direction, per iteration, at which it stands still.
const STILL: f64 = 1e-10;

/// Modulus of the leading multiplier from which a stable orbit is near losing its stability.
const NEAR_THE_CIRCLE: f64 = 0.9;

/// What its leading multiplier crosses the unit circle as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Bifurcation {
    /// At +1: a fold (saddle-node), or a symmetry that breaks.
    Fold,
    /// At −1: the period doubles.
    Flip,
    /// As a complex pair: a torus is born.
    NeimarkSacker,
}

impl Bifurcation {
    /// The word stored in result files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::Flip => "flip",
            Self::NeimarkSacker => "neimark_sacker",
        }
    }

    /// By the leading multiplier; none of one well inside the unit circle, where a
    /// complex pair may yet meet on the real axis, and nothing is told by where it stands.
    fn of(leading: Complex64) -> Option<Self> {
        (leading.norm() >= NEAR_THE_CIRCLE).then_some(if leading.im != 0.0 {
            Self::NeimarkSacker
        } else if leading.re < 0.0 {
            Self::Flip
        } else {
            Self::Fold
        })
    }
}

/// What is to be said of an orbit beside its multipliers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Character {
    /// Whether all multipliers lie inside the unit circle.
    pub stable: bool,
    /// How it gains or loses stability; none where its leading multiplier is well inside the
    /// unit circle.
    pub bifurcation: Option<Bifurcation>,
    /// Contact-state changes in a period.
    pub events: u64,
    /// Largest minus smallest δ \[m\].
    pub deflection_pp: f64,
    /// Smallest distance of an extreme of δ from a contact surface, in half gaps: 0 is
    /// grazing, where the event sequence changes. None where δ has no extreme.
    pub grazing_margin: Option<f64>,
    /// Growth, over one period of the full system, of a kick of [`KICK`] in the direction of
    /// strongest growth.
    pub kick_growth: f64,
    /// The same as the monodromy matrix has it: its largest singular value.
    pub kick_growth_linear: f64,
}

/// The strobe states of an orbit's period, and its character.
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn of<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    orbit: &PeriodicOrbit,
    workspace: &mut K::Workspace,
) -> Result<(Vec<TrajectoryState>, Character), Stop> {
    let mut counters = Counters::default();
    let mut extremes = Extremes::new(model);
    let mut points = Vec::with_capacity(orbit.period as usize);
    let mut state = orbit.start.clone();
    for _ in 0..orbit.period {
        points.push(state.clone());
        kernel.advance(1, &mut state, workspace, &mut extremes, &mut counters)?;
    }
    let events = counters.events;
    let (direction, kick_growth_linear) = strongest(&orbit.monodromy);
    let mut kicked = orbit.start.state.clone();
    let kick = KICK * norm.unit();
    for (&i, u) in norm.felt().iter().zip(&direction) {
        kicked[i] += kick * u / norm.weights()[i];
    }
    let mut kicked = TrajectoryState::new(model, kicked, orbit.start.cycle);
    kernel.advance(
        u64::from(orbit.period),
        &mut kicked,
        workspace,
        &mut (),
        &mut counters,
    )?;
    let character = Character {
        stable: orbit.spectral_radius() < 1.0,
        bifurcation: Bifurcation::of(orbit.multipliers.first().copied().unwrap_or_default()),
        events,
        deflection_pp: extremes.largest - extremes.smallest,
        grazing_margin: extremes.margin.is_finite().then_some(extremes.margin),
        kick_growth: norm.distance(&kicked.state, &state.state) / kick,
        kick_growth_linear,
    };
    Ok((points, character))
}

/// The direction of unit norm that a matrix stretches most, and by how much: power iteration
/// on `Mᵀ M`.
fn strongest(matrix: &Mat<f64>) -> (Vec<f64>, f64) {
    let n = matrix.nrows();
    let mut direction = Mat::from_fn(n, 1, |i, _| 1.0 + 0.1 * (i as f64).sin());
    direction = &direction * (1.0 / norm(&direction));
    let mut growth = 0.0;
    for _ in 0..MOST_ITERATIONS {
        let image = product(matrix.as_ref(), direction.as_ref());
        growth = norm(&image);
        let back = product(matrix.transpose(), image.as_ref());
        let length = norm(&back);
        if length == 0.0 {
            break;
        }
        let next = &back * (1.0 / length);
        let turned = norm(&(&next - &direction));
        direction = next;
        if turned <= STILL {
            break;
        }
    }
    ((0..n).map(|i| direction[(i, 0)]).collect(), growth)
}

/// Extremes of δ along an orbit.
struct Extremes<'m> {
    model: &'m Model,
    rising: Option<bool>,
    smallest: f64,
    largest: f64,
    margin: f64,
}

impl<'m> Extremes<'m> {
    fn new(model: &'m Model) -> Self {
        Self {
            model,
            rising: None,
            smallest: f64::INFINITY,
            largest: f64::NEG_INFINITY,
            margin: f64::INFINITY,
        }
    }
}

impl Observer for Extremes<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let series = padded(window.deflection);
        for end in [-1.0, 1.0] {
            let value = evaluate(&series, end);
            self.smallest = self.smallest.min(value);
            self.largest = self.largest.max(value);
        }
        let mut rising = self.rising;
        let half_gap = self.model.half_gap;
        extrema(window, half_gap, &mut rising, |x, _| {
            let value = evaluate(&series, x);
            self.smallest = self.smallest.min(value);
            self.largest = self.largest.max(value);
            let time = window.start + 0.5 * window.duration * (1.0 + x);
            let [gap, _] = self.model.contacts[0].gap(&window.segments[0], time);
            let away = (value.abs() - gap).abs() / half_gap;
            self.margin = self.margin.min(away);
        });
        self.rising = rising;
    }

    fn event(&mut self, _: &Event) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::c64;

    #[test]
    fn only_a_multiplier_near_the_circle_or_outside_is_said_to_cross_it() {
        for (multiplier, crossing) in [
            (c64(1.3, 0.0), Some(Bifurcation::Fold)),
            (c64(0.95, 0.0), Some(Bifurcation::Fold)),
            (c64(-1.29, 0.0), Some(Bifurcation::Flip)),
            (c64(-0.91, 0.0), Some(Bifurcation::Flip)),
            (c64(0.6, 0.8), Some(Bifurcation::NeimarkSacker)),
            (c64(0.5, 0.2), None),
            (c64(-0.6, 0.6), None),
            (c64(0.4, 0.0), None),
            (c64(-0.89, 0.0), None),
        ] {
            assert_eq!(Bifurcation::of(multiplier), crossing, "{multiplier}");
        }
    }
}
