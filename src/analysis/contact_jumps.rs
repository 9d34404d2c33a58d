//! Many mesh cycles of constant contact at once.
//!
//! While no contact opens or closes, a period of the excitation is an affine map of the state,
//! `x ↦ x₁ + A (x − x₀)`, and n periods are its n-th power, by repeated squaring. A jump is taken
//! only where contact is certain throughout. With the fixed point x* and the eigenvectors v and
//! multipliers μ of A,
//!
//! ```text
//! x₀ − x* = Σ c v,   margin(t) ≥ least of x* − Σ |c| |μ|ⁿ max |dmargin/dx · v| > 0
//! ```
//!
//! in every later period n, since no |μ| exceeds 1: the margin of a contact is `±(s δ − b)`, or its
//! force where it lets go by force. Both come from windows that the kernel shows of x* and of
//! states beside it, and are bounded by their Legendre series, not sampled. What is not certified
//! is integrated.

use super::modal_series::{ModalMotion, Series, TERMS, padded};
use super::norm::EnergyNorm;
use super::recurrence::excitation_period;
use crate::model::{Model, Release, TrajectoryState};
use crate::numerics::legendre::{evaluate, transforms24};
use crate::numerics::linalg::{eigenpair, eigenvalues, product, solve};
use crate::propagate::{Counters, Event, Kernel, Observer, Tangents, Window};
use faer::Mat;

/// Cycles integrated before the first attempt; the next ones follow at doubled counts.
const FIRST_ATTEMPT: u64 = 64;

/// Fewest cycles that are worth an attempt, a mode: an attempt takes some hundred cycles' time.
const WORTH: u64 = 50;

/// Longest period of the excitation that is mapped \[mesh cycles\].
const LONGEST: usize = 64;

/// Size of a disturbance, in units of the norm.
const DISTURBANCE: f64 = 1e-4;

/// Room for rounding in bounds.
const SLACK: f64 = 1.0 + 1e-6;

/// Residual of an eigenvector basis that is let pass, relative to the state taken apart in it.
const RESIDUAL: f64 = 1e-9;

/// Halvings of a window in the search for its least margin.
const HALVINGS: u32 = 5;

/// Jumps over constant contact, for one model.
#[derive(Debug)]
pub struct ContactJumps<'m> {
    model: &'m Model,
    norm: EnergyNorm,
    period: Option<u32>,
    marched: u64,
    next: u64,
}

/// A period of constant contact.
struct Period {
    /// A − I, of all components.
    increment: Mat<f64>,
    /// x₁ − x₀.
    drift: Vec<f64>,
    /// A of what is felt, in energy coordinates.
    felt: Mat<f64>,
    /// x₁ − x₀ there.
    felt_drift: Vec<f64>,
}

impl<'m> ContactJumps<'m> {
    /// None made yet.
    pub fn new(model: &'m Model) -> Self {
        let period = excitation_period(model).filter(|period| *period <= LONGEST);
        Self {
            model,
            norm: EnergyNorm::new(model),
            period: period.map(|period| period as u32),
            marched: 0,
            next: FIRST_ATTEMPT,
        }
    }

    /// Tells of a cycle that was integrated.
    pub fn marched(&mut self) {
        self.marched += 1;
    }

    /// Advances a trajectory by as many of `cycles` mesh cycles as keep contact for certain, whole
    /// periods of the excitation: how many, which is 0 where it is not time for an attempt, where
    /// it would not pay, and where nothing is certain.
    pub fn jump<K: Kernel>(
        &mut self,
        kernel: &K,
        trajectory: &mut TrajectoryState,
        cycles: u64,
        workspace: &mut K::Workspace,
    ) -> u64 {
        let Some(period) = self.period else {
            return 0;
        };
        let worth = WORTH * self.model.modes() as u64;
        if self.marched < self.next || cycles < worth.max(u64::from(period)) {
            return 0;
        }
        self.next = 2 * self.marched;
        let whole = cycles / u64::from(period);
        let jumped = (self.map(kernel, trajectory, period, workspace))
            .filter(|map| self.certain(kernel, trajectory, period, map, workspace))
            .and_then(|map| power(map, whole))
            .map(|moved| {
                for (x, moved) in trajectory.state.iter_mut().zip(moved) {
                    *x += moved;
                }
                trajectory.cycle += whole * u64::from(period);
                whole * u64::from(period)
            });
        jumped.unwrap_or(0)
    }

    /// The map of the period ahead; none where contact changes in it.
    fn map<K: Kernel>(
        &self,
        kernel: &K,
        start: &TrajectoryState,
        period: u32,
        workspace: &mut K::Workspace,
    ) -> Option<Period> {
        let size = start.state.len();
        if !start.contact.touching() {
            return None;
        }
        let mut counters = Counters::default();
        let mut ahead = start.clone();
        // Rattle is seen without the tangents' cost.
        kernel
            .advance(
                u64::from(period),
                &mut ahead,
                workspace,
                &mut (),
                &mut counters,
            )
            .ok()?;
        if counters.events > 0 {
            return None;
        }
        let mut ahead = start.clone();
        let mut tangents = Tangents::zeros(size / 2, size);
        for i in 0..size {
            tangents.vector_mut(i)[i] = 1.0;
        }
        for _ in 0..period {
            kernel
                .advance_cycle(&mut ahead, &mut tangents, workspace, &mut (), &mut counters)
                .ok()?;
        }
        if counters.events > 0 || ahead.contact != start.contact {
            return None;
        }
        let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
        let increment = Mat::from_fn(size, size, |i, j| tangents.vector(j)[i] - unit(i, j));
        for j in 0..size {
            self.norm.project(tangents.vector_mut(j));
        }
        let (weights, felt) = (self.norm.weights(), self.norm.felt());
        Some(Period {
            increment,
            drift: (ahead.state.iter().zip(&start.state))
                .map(|(end, start)| end - start)
                .collect(),
            felt: Mat::from_fn(felt.len(), felt.len(), |row, column| {
                let (i, j) = (felt[row], felt[column]);
                weights[i] * tangents.vector(j)[i] / weights[j]
            }),
            felt_drift: self.norm.difference(&ahead.state, &start.state),
        })
    }

    /// Whether contact is kept for ever by a trajectory whose period ahead has this map.
    fn certain<K: Kernel>(
        &self,
        kernel: &K,
        start: &TrajectoryState,
        period: u32,
        map: &Period,
        workspace: &mut K::Workspace,
    ) -> bool {
        let size = map.felt_drift.len();
        let rest = Mat::from_fn(size, size, |i, j| {
            f64::from(u8::from(i == j)) - map.felt[(i, j)]
        });
        // From the trajectory to the fixed point.
        let apart = solve(rest.as_ref(), &map.felt_drift);
        let Some(parts) = parts(&map.felt, &apart) else {
            return false;
        };
        let mut margins = |shift: &dyn Fn(usize) -> f64| {
            let mut state = start.clone();
            for (row, &i) in self.norm.felt().iter().enumerate() {
                state.state[i] += shift(row) / self.norm.weights()[i];
            }
            let mut seen = Margins::new(self.model);
            let mut counters = Counters::default();
            let advanced = kernel.advance(
                u64::from(period),
                &mut state,
                workspace,
                &mut seen,
                &mut counters,
            );
            (advanced.is_ok() && counters.events == 0 && seen.whole).then_some(seen.windows)
        };
        let Some(steady) = margins(&|row| apart[row]) else {
            return false;
        };
        let mut left: Vec<f64> = (0..self.model.contacts.len())
            .map(|contact| {
                (steady.iter())
                    .map(|window| least(&window[contact], HALVINGS))
                    .fold(f64::INFINITY, f64::min)
            })
            .collect();
        let kept = |left: &[f64]| left.iter().all(|left| *left > 0.0);
        let step = DISTURBANCE * self.norm.unit();
        for part in &parts {
            if !kept(&left) {
                return false;
            }
            let Some(reach) = part
                .vector
                .each_ref()
                .map(|v| {
                    let beside = margins(&|row| apart[row] + step * v[row])?;
                    reach(&steady, &beside, step)
                })
                .into_iter()
                .collect::<Option<Vec<_>>>()
            else {
                return false;
            };
            for (contact, left) in left.iter_mut().enumerate() {
                *left -= SLACK * part.size * reach[0][contact].hypot(reach[1][contact]);
            }
        }
        kept(&left)
    }
}

/// A part of a state along a pair of eigenvectors.
struct Part {
    /// |c|.
    size: f64,
    /// Real and imaginary part of v.
    vector: [Vec<f64>; 2],
}

/// A state taken apart along the eigenvectors of a map; none where a part grows, or where the
/// eigenvectors do not tell the parts.
fn parts(map: &Mat<f64>, state: &[f64]) -> Option<Vec<Part>> {
    let size = state.len();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut pairs = Vec::new();
    for value in eigenvalues(map.as_ref())? {
        // A conjugate comes with its other half; what grows or stays is no transient.
        if value.norm() >= 1.0 {
            return None;
        }
        if value.im < 0.0 {
            continue;
        }
        let found = eigenpair(map.as_ref(), value)?;
        let first = columns.len();
        let [real, imaginary] = found.vector.clone();
        columns.push(real);
        if value.im > 0.0 {
            columns.push(imaginary);
        }
        pairs.push((first, columns.len() - first, found.vector));
    }
    if columns.len() != size {
        return None;
    }
    let basis = Mat::from_fn(size, size, |i, j| columns[j][i]);
    let shares = solve(basis.as_ref(), state);
    let length = |x: &dyn Fn(usize) -> f64| (0..size).map(|i| x(i) * x(i)).sum::<f64>().sqrt();
    let rebuilt = |i: usize| -> f64 { (0..size).map(|j| basis[(i, j)] * shares[j]).sum() };
    let off = length(&|i| rebuilt(i) - state[i]);
    // Written so that what is no number is refused.
    let told = off <= RESIDUAL * length(&|i| state[i]);
    let part = |(first, count, vector): (usize, usize, [Vec<f64>; 2])| Part {
        size: match count {
            1 => shares[first].abs(),
            _ => shares[first].hypot(shares[first + 1]),
        },
        vector,
    };
    let mut parts: Vec<Part> = pairs.into_iter().map(part).collect();
    // What is too much is soon seen.
    parts.sort_by(|a, b| b.size.total_cmp(&a.size));
    told.then_some(parts)
}

/// What so many periods move a state by.
fn power(map: Period, periods: u64) -> Option<Vec<f64>> {
    let size = map.drift.len();
    let (mut increment, mut drift) = (map.increment, map.drift);
    let mut moved = vec![0.0; size];
    let through = |increment: &Mat<f64>, x: &[f64], y: &[f64]| -> Vec<f64> {
        let sum = |i: usize| (0..size).map(|j| increment[(i, j)] * x[j]).sum::<f64>();
        (0..size).map(|i| x[i] + sum(i) + y[i]).collect()
    };
    let mut left = periods;
    while left > 0 {
        if left & 1 == 1 {
            moved = through(&increment, &moved, &drift);
        }
        left >>= 1;
        if left > 0 {
            drift = through(&increment, &drift, &drift);
            let square = product(increment.as_ref(), increment.as_ref());
            increment = Mat::from_fn(size, size, |i, j| 2.0 * increment[(i, j)] + square[(i, j)]);
        }
    }
    moved.iter().all(|x| x.is_finite()).then_some(moved)
}

/// The margins of all contacts, window after window.
struct Margins<'m> {
    model: &'m Model,
    motion: ModalMotion<'m>,
    windows: Vec<Vec<Series>>,
    /// Whether every margin of every window could be told.
    whole: bool,
}

impl<'m> Margins<'m> {
    fn new(model: &'m Model) -> Self {
        Self {
            model,
            motion: ModalMotion::new(model),
            windows: Vec::new(),
            whole: true,
        }
    }
}

impl Observer for Margins<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let model = self.model;
        let mut all = Vec::with_capacity(model.contacts.len());
        for (index, contact) in model.contacts.iter().enumerate() {
            let segment = &window.segments[index];
            let closed = window.closed.iter().find(|closed| closed.contact == index);
            if let Some(closed) = closed
                && contact.release == Release::Force
            {
                all.push(padded(closed.force).map(|force| contact.side * force));
                continue;
            }
            let inside = match (closed.is_some(), window.contact.holds(index)) {
                (true, true) => 1.0,
                (false, false) => -1.0,
                _ => {
                    self.whole = false;
                    return;
                }
            };
            let own = segment.direction != window.segments[0].direction;
            // The line of an open contact is seen through the blocks, where it is its own.
            let (series, errors) = match closed {
                Some(closed) => (padded(closed.deflection), false),
                None if !own => (padded(window.deflection), false),
                None => {
                    let motion = self.motion.on(window);
                    let mut sum: Series = [0.0; TERMS];
                    for (block, gain) in model.gains(segment).iter().enumerate() {
                        for (row, w) in gain.deflection.into_iter().enumerate() {
                            if w == 0.0 {
                                continue;
                            }
                            for (sum, x) in sum.iter_mut().zip(motion.component(block, row)) {
                                *sum += w * x;
                            }
                        }
                    }
                    (sum, true)
                }
            };
            let transforms = transforms24();
            let margin = transforms.nodes().map(|x| {
                let time = window.start + 0.5 * (x + 1.0) * window.duration;
                let line = &model.lines[model.line(segment)];
                let error = match errors {
                    true => line.transmission_error_at(window.cycle, time).0,
                    false => 0.0,
                };
                let deflection = evaluate(&series, x) - error;
                inside * (contact.side * deflection - contact.gap(segment, time)[0])
            });
            all.push(transforms.interpolate(&margin));
        }
        self.windows.push(all);
    }

    fn event(&mut self, _: &Event) {}
}

/// The least value of a series, or something smaller.
fn least(series: &Series, halvings: u32) -> f64 {
    let bound = series[0] - series[1..].iter().map(|a| a.abs()).sum::<f64>();
    if halvings == 0 {
        return bound;
    }
    let half = |side| least(&transforms24().half(series, side), halvings - 1);
    half(0).min(half(1)).max(bound)
}

/// How far margins change at most, by contact, with a disturbance of so large a step; none where
/// the windows are others.
fn reach(steady: &[Vec<Series>], beside: &[Vec<Series>], step: f64) -> Option<Vec<f64>> {
    if steady.len() != beside.len() {
        return None;
    }
    let contacts = steady.first().map_or(0, Vec::len);
    let change = |contact: usize| {
        (steady.iter().zip(beside))
            .map(|(a, b)| {
                let terms = a[contact].iter().zip(&b[contact]);
                terms.map(|(a, b)| (b - a).abs()).sum::<f64>() / step
            })
            .fold(0.0, f64::max)
    };
    Some((0..contacts).map(change).collect())
}
