//! Is contact certain to last on the way to a periodic motion?
//!
//! While no contact opens or closes, the map of a period is affine. With its fixed point x* and the eigenvectors v and
//! multipliers μ of its matrix,
//!
//! ```text
//! x₀ − x* = Σ c v,   margin(t) ≥ min margin(x*) − Σ |c| |μ|ⁿ max |dmargin/dx · v| > 0
//! ```
//!
//! in every later period n if this holds for n = 0, since every |μ| is below 1. The margin of a contact is
//! `±(s δ − b)`, or its force if it releases by force. The margin and its derivatives come from the kernel's windows
//! for x* and for neighbouring states. They are bounded by their Legendre series, not sampled.

use super::modal_series::{ModalMotion, Series, TERMS, padded};
use super::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::legendre::{evaluate, transforms24};
use crate::numerics::linalg::{eigenpair, eigenvalues, solve};
use crate::propagate::{Counters, Kernel, Observer, Window};
use faer::Mat;

/// Size of the displacement from the periodic motion that gives derivatives, in units of the norm.
const DISTURBANCE: f64 = 1e-4;

/// Factor by which changes of a margin are increased to allow for rounding.
const SLACK: f64 = 1.0 + 1e-6;

/// Largest accepted residual of a state's expansion in eigenvectors, relative to the state.
const RESIDUAL: f64 = 1e-9;

/// Maximum number of successive halvings of a window in the search for its least margin.
const HALVINGS: u32 = 5;

/// Motions in constant contact that decay to a periodic one.
#[derive(Debug)]
pub(super) struct LastingContact<'a> {
    model: &'a Model,
    norm: &'a EnergyNorm,
    /// The periodic motion at the start of a period.
    orbit: TrajectoryState,
    /// Period of the motion in mesh cycles.
    period: u32,
    modes: Modes,
    /// Margins of the periodic motion, once computed.
    steady: Option<ObservedMargins>,
    /// The blocks' motion, with its stored exponentials.
    motion: ModalMotion<'a>,
    /// Largest change of margins per unit of each mode, by contact, once computed.
    margin_changes: Vec<Option<Vec<f64>>>,
}

impl<'a> LastingContact<'a> {
    /// Motions that decay to an orbit, given by a state and its period in mesh cycles. `map` is the map of a
    /// period in energy coordinates, without the neutral pair. `None` if a mode does not decay, or if the
    /// eigenvectors of the map are not a basis.
    pub(super) fn new(
        model: &'a Model,
        norm: &'a EnergyNorm,
        map: &Mat<f64>,
        (orbit, period): (TrajectoryState, u32),
    ) -> Option<Self> {
        let modes = Modes::new(map)?;
        Some(Self {
            model,
            norm,
            orbit,
            period,
            steady: None,
            motion: ModalMotion::new(model),
            margin_changes: vec![None; modes.vectors.len()],
            modes,
        })
    }

    /// Whether contact is certain to last for ever. The motion starts a period at the distance `away` from
    /// the periodic one, in energy coordinates.
    pub(super) fn is_certain<K: Kernel>(
        &mut self,
        kernel: &K,
        away: &[f64],
        workspace: &mut K::Workspace,
    ) -> bool {
        self.remaining_margins(kernel, away, workspace)
            .is_some_and(|remaining| remaining.iter().all(|remaining| *remaining > 0.0))
    }

    /// Lower bounds of the margins in all later periods. The computation ends as soon as one bound is not
    /// positive. `None` if the margins are unknown.
    fn remaining_margins<K: Kernel>(
        &mut self,
        kernel: &K,
        away: &[f64],
        workspace: &mut K::Workspace,
    ) -> Option<Vec<f64>> {
        let sizes = self.modes.sizes(away)?;
        let mut order: Vec<usize> = (0..sizes.len()).collect();
        // The largest components come first, because they reduce the bounds most.
        order.sort_by(|a, b| sizes[*b].total_cmp(&sizes[*a]));
        if self.steady.is_none() {
            self.steady = Some(self.observe_period(kernel, None, workspace)?);
        }
        let mut remaining = self.steady.as_ref()?.lower_bounds.clone()?;
        for mode in order {
            if remaining.iter().any(|remaining| *remaining <= 0.0) {
                break;
            }
            let margin_change = self.margin_change(kernel, mode, workspace)?;
            for (remaining, margin_change) in remaining.iter_mut().zip(margin_change) {
                *remaining -= SLACK * sizes[mode] * margin_change;
            }
        }
        Some(remaining)
    }

    /// Largest change of every contact's margin over a period, per unit of a mode.
    fn margin_change<K: Kernel>(
        &mut self,
        kernel: &K,
        mode: usize,
        workspace: &mut K::Workspace,
    ) -> Option<&Vec<f64>> {
        if self.margin_changes[mode].is_none() {
            let mut both = vec![0.0_f64; self.model.contacts.len()];
            for v in self.modes.vectors[mode].clone() {
                if v.iter().any(|x| *x != 0.0) {
                    let disturbed = self.observe_period(kernel, Some(&v), workspace)?;
                    let steady = &self.steady.as_ref()?.windows;
                    for (both, one) in both
                        .iter_mut()
                        .zip(margin_differences(steady, &disturbed.windows)?)
                    {
                        *both = both.hypot(one / (DISTURBANCE * self.norm.unit()));
                    }
                }
            }
            self.margin_changes[mode] = Some(both);
        }
        self.margin_changes[mode].as_ref()
    }

    /// The margins over a period of the orbit, or of a motion displaced along a direction; `None` if an event
    /// occurs, if the kernel stops, or if a margin is unknown.
    fn observe_period<K: Kernel>(
        &mut self,
        kernel: &K,
        along: Option<&[f64]>,
        workspace: &mut K::Workspace,
    ) -> Option<ObservedMargins> {
        let mut state = self.orbit.clone();
        let size = DISTURBANCE * self.norm.unit();
        (self.norm).displace(&mut state.state, size, along.unwrap_or(&[]));
        let mut margins = MarginObserver::new(self.model, &mut self.motion, along.is_none());
        let mut counters = Counters::default();
        let period = u64::from(self.period);
        let advanced = kernel.advance(period, &mut state, workspace, &mut margins, &mut counters);
        (advanced.is_ok() && counters.events == 0 && margins.is_complete)
            .then_some(margins.observed)
    }
}

/// Eigenvectors of a map, each as real and imaginary part. A conjugate pair has one entry.
#[derive(Debug)]
struct Modes {
    vectors: Vec<[Vec<f64>; 2]>,
    /// First column and number of columns of each entry.
    columns: Vec<(usize, usize)>,
    /// All columns.
    basis: Mat<f64>,
}

impl Modes {
    /// `None` if an eigenvalue has a modulus of 1 or more, or if there are too few eigenvectors.
    fn new(map: &Mat<f64>) -> Option<Self> {
        let size = map.nrows();
        let mut all: Vec<Vec<f64>> = Vec::new();
        let (mut vectors, mut columns) = (Vec::new(), Vec::new());
        for value in eigenvalues(map.as_ref())? {
            // A mode that does not decay is not transient. Of a conjugate pair, one eigenvector is used.
            if value.norm() >= 1.0 {
                return None;
            }
            if value.im < 0.0 {
                continue;
            }
            let [real, imaginary] = eigenpair(map.as_ref(), value)?.vector;
            let first = all.len();
            all.push(real.clone());
            if value.im > 0.0 {
                all.push(imaginary.clone());
            }
            columns.push((first, all.len() - first));
            vectors.push([real, imaginary]);
        }
        (all.len() == size).then(|| Self {
            vectors,
            columns,
            basis: Mat::from_fn(size, size, |i, j| all[j][i]),
        })
    }

    /// Size of each mode in a state; `None` if the expansion is inaccurate.
    fn sizes(&self, state: &[f64]) -> Option<Vec<f64>> {
        let size = state.len();
        let shares = solve(self.basis.as_ref(), state);
        let length = |x: &dyn Fn(usize) -> f64| (0..size).map(|i| x(i) * x(i)).sum::<f64>().sqrt();
        let rebuilt = |i: usize| -> f64 { (0..size).map(|j| self.basis[(i, j)] * shares[j]).sum() };
        let off = length(&|i| rebuilt(i) - state[i]);
        // This form of the comparison rejects NaN.
        let accurate = off <= RESIDUAL * length(&|i| state[i]);
        let part = |&(first, count): &(usize, usize)| match count {
            1 => shares[first].abs(),
            _ => shares[first].hypot(shares[first + 1]),
        };
        accurate.then(|| self.columns.iter().map(part).collect())
    }
}

/// The observed margins of all contacts.
#[derive(Debug)]
struct ObservedMargins {
    /// Series of the margins, window after window. Gaps and errors are omitted, because they are the same for
    /// all motions.
    windows: Vec<Vec<Series>>,
    /// Lower bound of every contact's margin, if requested.
    lower_bounds: Option<Vec<f64>>,
}

/// Observes the margins of all contacts.
#[derive(Debug)]
struct MarginObserver<'a, 'm> {
    model: &'m Model,
    motion: &'a mut ModalMotion<'m>,
    observed: ObservedMargins,
    /// Whether every margin of every window is known.
    is_complete: bool,
}

impl<'a, 'm> MarginObserver<'a, 'm> {
    fn new(model: &'m Model, motion: &'a mut ModalMotion<'m>, with_bounds: bool) -> Self {
        Self {
            model,
            motion,
            observed: ObservedMargins {
                windows: Vec::new(),
                lower_bounds: with_bounds.then(|| vec![f64::INFINITY; model.contacts.len()]),
            },
            is_complete: true,
        }
    }
}

/// Reduces the lower bound of a contact's margin by its series over a window, if bounds are requested.
fn lower_bound_by(bounds: &mut Option<Vec<f64>>, contact: usize, margin: &Series) {
    if let Some(bounds) = bounds {
        let known = bounds[contact];
        bounds[contact] = known.min(lower_bound(margin, HALVINGS, known));
    }
}

impl Observer for MarginObserver<'_, '_> {
    const WINDOWS: bool = true;
    const LINES: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let model = self.model;
        let has_other_direction =
            |index: usize| window.segments[index].direction != window.segments[0].direction;
        // If the window does not contain the deflection of an open contact on another line, it is rebuilt
        // from the blocks' motion.
        let needs_motion = window.along.is_empty()
            && (0..model.contacts.len()).any(|index| {
                has_other_direction(index) && !window.closed.iter().any(|c| c.contact == index)
            });
        let motion = needs_motion.then(|| self.motion.on(window));
        let mut margins = Vec::with_capacity(model.contacts.len());
        for (index, contact) in model.contacts.iter().enumerate() {
            if model.is_passed(index, window.contact) {
                // A thinner layer of the oil film, or the flank, is closed: this layer exerts no force until that
                // contact opens.
                margins.push([0.0; TERMS]);
                continue;
            }
            let segment = &window.segments[index];
            let closed = window.closed.iter().find(|closed| closed.contact == index);
            if let Some(closed) = closed
                && contact.release.is_by_force()
            {
                let margin = padded(closed.force).map(|force| contact.side * force);
                lower_bound_by(&mut self.observed.lower_bounds, index, &margin);
                margins.push(margin);
                continue;
            }
            let inside = match (closed.is_some(), window.contact.holds(index)) {
                (true, true) => 1.0,
                (false, false) => -1.0,
                _ => {
                    self.is_complete = false;
                    return;
                }
            };
            let (series, errors) = match (closed, window.along.get(index), &motion) {
                (Some(closed), ..) => (padded(closed.deflection), false),
                (None, Some(along), _) => (padded(along), false),
                (None, None, Some(motion)) if has_other_direction(index) => {
                    let gains = model.gains(segment).iter().map(|gain| gain.deflection);
                    (motion.combination(gains.enumerate()), true)
                }
                (None, ..) => (padded(window.deflection), false),
            };
            margins.push(series.map(|a| inside * contact.side * a));
            if self.observed.lower_bounds.is_none() {
                continue;
            }
            let transforms = transforms24();
            let margin = transforms.nodes().map(|x| {
                let time = window.start + 0.5 * (x + 1.0) * window.duration;
                let line = &model.lines[model.line(segment)];
                let error =
                    if errors { line.transmission_error_at(window.cycle, time).0 } else { 0.0 };
                let deflection = evaluate(&series, x) - error;
                inside * (contact.side * deflection - contact.gap(segment, time)[0])
            });
            lower_bound_by(
                &mut self.observed.lower_bounds,
                index,
                &transforms.interpolate(&margin),
            );
        }
        self.observed.windows.push(margins);
    }
}

/// A lower bound of a series, refined by halving while it is below `known`.
fn lower_bound(series: &Series, halvings: u32, known: f64) -> f64 {
    let bound = series[0] - series[1..].iter().map(|a| a.abs()).sum::<f64>();
    if halvings == 0 || bound >= known {
        return bound;
    }
    let half = |side, known| lower_bound(&transforms24().half(series, side), halvings - 1, known);
    let low = half(0, known);
    low.min(half(1, known.min(low))).max(bound)
}

/// Largest differences of margins, by contact; `None` if the windows differ.
fn margin_differences(steady: &[Vec<Series>], disturbed: &[Vec<Series>]) -> Option<Vec<f64>> {
    if steady.len() != disturbed.len() {
        return None;
    }
    let contacts = steady.first().map_or(0, Vec::len);
    let change = |contact: usize| {
        (steady.iter().zip(disturbed))
            .map(|(a, b)| {
                let terms = a[contact].iter().zip(&b[contact]);
                terms.map(|(a, b)| (b - a).abs()).sum::<f64>()
            })
            .fold(0.0, f64::max)
    };
    Some((0..contacts).map(change).collect())
}
