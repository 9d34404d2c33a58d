//! The data of a system at one operating point: its motion, the rows of deflections, and bounds of a
//! deflection between nodes.

use super::basis::{Basis, padded};
use super::excitation::{Drift, Frequencies, Steady, error_amplitudes};
use super::grid::NODES;
use super::lanes::{BlockPropagator, Chunk, MixedModes};
use super::sets::ContactClass;
use crate::model::{Block, Model};
use crate::propagate::vectors::{LANES, Lanes};
use num_complex::{Complex64, c64};

/// The tables of a system at an operating point: exponentials, steady responses and views.
#[derive(Debug)]
pub struct System {
    /// Its blocks.
    pub chunks: Vec<Chunk>,
    /// Matrices of the blocks. The amplitude of a block is the length of the product of its matrix and its
    /// coordinates.
    pub balances: Vec<BlockPropagator>,
    /// `e^{Gt}` of all blocks at the first node, then at the next ones.
    moves: Vec<BlockPropagator>,
    /// Steady responses to the inputs, and the blocks without a steady response to a constant input.
    pub steady: Steady,
    /// Change of the coordinates of each drift from the start of a block to each node, due to its constant
    /// input.
    pub pushes: Vec<[[f64; 2]; NODES]>,
    /// Indices of the coordinates of mixed modes ([`MixedModes`]) and of other modes with an effect on some line; first
    /// and second components alternate.
    pub places: Vec<usize>,
    /// The views of all lines of the model.
    pub views: Vec<LineView>,
    /// Force inputs g of each direction of the model, padded states.
    pub pulls: Vec<Vec<f64>>,
    /// Whether no wave grows: bounds of a block are then valid for all later blocks.
    pub decays: bool,
}

/// The deflection of a system along a line, `δ = row·y + drive·inputs`, and its first two derivatives.
#[derive(Debug)]
pub struct LineView {
    /// Rows of the deflection, its rate and its second derivative.
    pub rows: [Vec<f64>; 3],
    /// Contributions of the inputs to these.
    pub drives: [Vec<f64>; 3],
    /// The deflection at the nodes: a row of node values for each of [`System::places`].
    pub nodes: Vec<Lanes>,
    /// Contribution of each input to the deflection at the nodes, and a row of zeros that makes the number of
    /// rows even.
    pub drive_nodes: Vec<Lanes>,
    /// Largest contribution of a unit amplitude to the deflection \[m\].
    pub size: Vec<f64>,
    /// Largest contribution of a unit amplitude to its second derivative \[m/s²\].
    pub curvature: Vec<f64>,
    /// Largest contribution of the inputs to the second derivative.
    pub drive_curvature: f64,
    /// Largest contributions of blocks that are not waves to the second derivative, per unit rate of their
    /// coordinates.
    pub others: Vec<([f64; 2], Drift)>,
}

/// A block is a wave if its frequency is larger than this part of its rate of growth or decay.
const TURNS: f64 = 0.05;

/// A turn by less than this angle \[rad\] over a block is neglected.
const NEGLECTED_ANGLE: f64 = 1e-3;

/// A mode has only round-off if its participation, relative to the largest, is below this.
const NEGLIGIBLE: f64 = 64.0 * f64::EPSILON;

impl LineView {
    /// Contributions of the inputs to the deflection and its first two derivatives.
    #[inline(always)]
    pub fn driven(&self, inputs: &[f64]) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for order in 0..3 {
            let drive = &self.drives[order][..];
            for (h, share) in drive.iter().enumerate() {
                sums[order] += inputs[h] * share;
            }
        }
        sums
    }
}

/// `e^{Gt}` of a block.
fn exponential(block: &Block, time: f64) -> [[f64; 2]; 2] {
    let (mu, m) = (block.growth(), block.traceless());
    let grown = (mu * time).exp();
    let [even, odd] = match (block.damped_frequency(), block.spread()) {
        (Some(nu), _) if nu * time > 1e-4 => {
            let (sin, cos) = (nu * time).sin_cos();
            [grown * cos, grown * sin / nu]
        }
        (_, Some(sigma)) if sigma * time > 1e-4 => [
            grown * (sigma * time).cosh(),
            grown * (sigma * time).sinh() / sigma,
        ],
        _ => {
            let square = (m[0][0] * m[0][0] + m[0][1] * m[1][0]) * time * time;
            [
                grown * (1.0 + 0.5 * square),
                grown * time * (1.0 + square / 6.0),
            ]
        }
    };
    [
        [even + odd * m[0][0], odd * m[0][1]],
        [odd * m[1][0], even + odd * m[1][1]],
    ]
}

/// Balanced coordinates y of a block, `x = P y`: P and its inverse. In these coordinates a wave turns and decays. If a
/// block is not a wave but a displacement, its rate is scaled to the displacement over a block of nodes.
fn balance(block: &Block, step: f64) -> [[[f64; 2]; 2]; 2] {
    let m = block.traceless();
    match block.damped_frequency() {
        Some(nu) if is_wave(block, step) => {
            // The first coordinate is along e₁, the second along M e₁ / ν.
            let (p, q) = (m[0][0] / nu, m[1][0] / nu);
            [[[1.0, p], [0.0, q]], [[1.0, -p / q], [0.0, 1.0 / q]]]
        }
        _ if is_displacement(block, step) => {
            let time = NODES as f64 * step;
            [[[1.0, 0.0], [0.0, 1.0 / time]], [[1.0, 0.0], [0.0, time]]]
        }
        _ => [[[1.0, 0.0], [0.0, 1.0]]; 2],
    }
}

/// Whether the coordinates of a block are a displacement and its rate.
fn is_displacement(block: &Block, step: f64) -> bool {
    let [by_value, by_rate] = block.generator[0];
    by_rate == 1.0 && by_value.abs() * NODES as f64 * step < NEGLECTED_ANGLE
}

/// Whether a block turns and decays in its balanced coordinates. A rotation that no closed contact restrains
/// has only a frequency of the size of round-off. Such a slow block is not a wave, because its rate is not an
/// amplitude.
fn is_wave(block: &Block, step: f64) -> bool {
    let angle = |nu: f64| nu * NODES as f64 * step;
    (block.damped_frequency()).is_some_and(|nu| {
        let slow = is_displacement(block, step) && angle(nu) < NEGLECTED_ANGLE;
        nu > TURNS * block.growth().abs() && !slow
    }) && block.generator[1][0] != 0.0
}

fn times(g: &[[f64; 2]; 2], w: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|j| w[0] * g[0][j] + w[1] * g[1][j])
}

/// Data that the systems of a kernel share.
#[derive(Clone, Copy)]
pub struct SharedData<'a> {
    /// The model at its operating point.
    pub model: &'a Model,
    /// Its inputs.
    pub frequencies: &'a Frequencies,
    /// The modes that the maps between systems mix. An event maps the state from one system to another.
    pub mixed: &'a MixedModes,
    /// Distance of nodes \[s\].
    pub step: f64,
}

impl System {
    /// Builds a system with some closed contacts.
    pub fn new(
        shared_data: &SharedData<'_>,
        basis: &Basis<'_>,
        closed: &[(usize, ContactClass)],
    ) -> Self {
        let SharedData {
            model,
            frequencies,
            step,
            ..
        } = *shared_data;
        let n = model.modes();
        let padded = padded(n);
        let blocks: Vec<Block> = (0..n).map(|i| basis.block(i)).collect();
        let steady = Steady::new(model, basis, closed, frequencies);
        let mut chunks = vec![Chunk::ZERO; padded / LANES];
        let mut balances = vec![[Lanes::ZERO; 4]; padded / LANES];
        let mut moves = vec![[Lanes::ZERO; 4]; padded / LANES * NODES];
        for (i, block) in blocks.iter().enumerate() {
            let (chunk, lane) = (&mut chunks[i / LANES], i % LANES);
            let m = block.traceless();
            chunk.growth.0[lane] = block.growth();
            let [_, inverse] = balance(block, step);
            for (target, value) in balances[i / LANES].iter_mut().zip(inverse.as_flattened()) {
                target.0[lane] = *value;
            }
            chunk.square.0[lane] = m[0][0] * m[0][0] + m[0][1] * m[1][0];
            for (target, value) in chunk.traceless.iter_mut().zip(m.as_flattened()) {
                target.0[lane] = *value;
            }
            for node in 0..NODES {
                let e = exponential(block, (node + 1) as f64 * step);
                for (target, value) in moves[node * (padded / LANES) + i / LANES]
                    .iter_mut()
                    .zip(e.as_flattened())
                {
                    target.0[lane] = *value;
                }
            }
        }
        let pushes = (steady.drifts.iter())
            .map(|drift| pushes(drift, &blocks[drift.lane], step))
            .collect();
        let mut system = Self {
            chunks,
            balances,
            moves,
            steady,
            pushes,
            places: Vec::new(),
            views: Vec::new(),
            pulls: Vec::new(),
            decays: (blocks.iter()).all(|block| !is_wave(block, step) || block.growth() <= 0.0),
        };
        system.pulls = (model.directions.iter())
            .map(|direction| {
                let inputs: Vec<_> = direction.gains.iter().map(|g| g.mesh_input).collect();
                basis.input(&inputs)
            })
            .collect();
        let largest = |deflection_gains: &DeflectionGains| {
            deflection_gains
                .iter()
                .fold(0.0_f64, |most, w| most.max(w[0].abs()))
        };
        let deflection_gains: Vec<DeflectionGains> = (0..model.lines.len())
            .map(|line| gains_along(model, line))
            .collect();
        let is_seen = |mode: &usize| {
            shared_data.mixed.modes.contains(mode)
                || (deflection_gains.iter()).any(|deflection_gains| {
                    let [w, by_rate] = deflection_gains[*mode];
                    by_rate != 0.0 || w.abs() > NEGLIGIBLE * largest(deflection_gains)
                })
        };
        system.places = (0..n)
            .filter(is_seen)
            .flat_map(|mode| [mode, padded + mode])
            .collect();
        for line in 0..model.lines.len() {
            let view = system.view(shared_data, basis, &blocks, (line, &deflection_gains[line]));
            system.views.push(view);
        }
        system
    }

    /// `e^{Gt}` of all blocks at a node. Nodes are numbered from 1.
    #[inline(always)]
    pub fn moves_to(&self, node: usize) -> &[BlockPropagator] {
        &self.moves[(node - 1) * self.chunks.len()..][..self.chunks.len()]
    }

    /// The view of a line.
    fn view(
        &self,
        shared_data: &SharedData<'_>,
        basis: &Basis<'_>,
        blocks: &[Block],
        (line, deflection_gains): (usize, &DeflectionGains),
    ) -> LineView {
        let SharedData {
            model,
            frequencies,
            step,
            ..
        } = *shared_data;
        let n = blocks.len();
        let padded = padded(n);
        let inputs = frequencies.inputs();
        let row = basis.row(deflection_gains);
        let pair = |state: &[f64], i: usize| [state[i], state[padded + i]];
        let [mut rate, mut bend] = [0, 1].map(|_| vec![0.0; 2 * padded]);
        let (mut size, mut curvature) = (vec![0.0; padded], vec![0.0; padded]);
        let mut others = Vec::new();
        for (i, block) in blocks.iter().enumerate() {
            let w = pair(&row, i);
            let first = times(&block.generator, w);
            let second = times(&block.generator, first);
            for (derivative, of) in [(&mut rate, first), (&mut bend, second)] {
                [derivative[i], derivative[padded + i]] = of;
            }
            let [to, _] = balance(block, step);
            let balanced = times(&to, w);
            size[i] = balanced[0].hypot(balanced[1]);
            let grown = (block.growth().max(0.0) * NODES as f64 * step).exp();
            if is_wave(block, step) {
                curvature[i] = grown * size[i] * block.natural_frequency().powi(2);
            } else {
                let input = (self.steady.drifts.iter())
                    .find(|drift| drift.lane == i)
                    .map_or([0.0; 2], |drift| drift.input);
                let drift = Drift::new(i, block.generator, input);
                others.push((variation_bounds(block, first, step), drift));
            }
        }
        let mut view = LineView {
            drives: [0; 3].map(|_| vec![0.0; inputs]),
            nodes: Vec::new(),
            drive_nodes: vec![Lanes::ZERO; inputs + 1],
            size,
            curvature,
            drive_curvature: 0.0,
            others,
            rows: [row, rate, bend],
        };
        for &[i, _] in self.places.as_chunks::<2>().0 {
            let w = pair(&view.rows[0], i);
            for part in 0..2 {
                view.nodes.push(Lanes(std::array::from_fn(|node| {
                    let e = &self.moves_to(node + 1)[i / LANES];
                    w[0] * e[part].0[i % LANES] + w[1] * e[2 + part].0[i % LANES]
                })));
            }
        }
        let response = |input: usize| -> f64 {
            let state = &self.steady.responses[2 * padded * input..][..2 * padded];
            view.rows[0].iter().zip(state).map(|(w, x)| w * x).sum()
        };
        let responses: Vec<f64> = (0..inputs).map(response).collect();
        view.drives[0][0] = responses[0];
        view.drive_nodes[0].0 = [responses[0]; LANES];
        for (drift, pushes) in self.steady.drifts.iter().zip(&self.pushes) {
            for order in 1..3 {
                let w = pair(&view.rows[order - 1], drift.lane);
                view.drives[order][0] += w[0] * drift.input[0] + w[1] * drift.input[1];
            }
            let w = pair(&view.rows[0], drift.lane);
            for (value, push) in view.drive_nodes[0].0.iter_mut().zip(pushes) {
                *value += w[0] * push[0] + w[1] * push[1];
            }
        }
        let errors = error_amplitudes(model, line, frequencies);
        for (h, (&[omega, _], error)) in frequencies.all.iter().zip(&errors).enumerate() {
            // Re a e^{iθ}: cos has Re a, sin has −Im a.
            let amplitude = c64(responses[1 + 2 * h], -responses[2 + 2 * h]) - error;
            let mut derivative = amplitude;
            for drive in &mut view.drives {
                (drive[1 + 2 * h], drive[2 + 2 * h]) = (derivative.re, -derivative.im);
                derivative *= c64(0.0, omega);
            }
            view.drive_curvature += omega * omega * amplitude.norm();
            for node in 0..NODES {
                let there = amplitude * Complex64::cis(omega * (node + 1) as f64 * step);
                view.drive_nodes[1 + 2 * h].0[node] = there.re;
                view.drive_nodes[2 + 2 * h].0[node] = -there.im;
            }
        }
        view
    }
}

/// Gains of the model's blocks in a deflection, one pair per block.
type DeflectionGains = Vec<[f64; 2]>;

/// The gains along a line.
fn gains_along(model: &Model, line: usize) -> DeflectionGains {
    let along = (model.directions.iter()).find(|direction| direction.line == line);
    along.map_or_else(
        || vec![[0.0; 2]; model.modes()],
        |direction| direction.gains.iter().map(|gain| gain.deflection).collect(),
    )
}

/// Change of the coordinates of a drift from the start of a block to each node, due to its constant input.
fn pushes(drift: &Drift, block: &Block, step: f64) -> [[f64; 2]; NODES] {
    let (first, e) = (drift.push(step), exponential(block, step));
    let mut all = [first; NODES];
    for node in 1..NODES {
        let [x, y] = all[node - 1];
        all[node] = [0, 1].map(|i| e[i][0] * x + e[i][1] * y + first[i]);
    }
    all
}

/// Largest contributions per unit rate of each of a block's coordinates to the second derivative of a deflection, over
/// all nodes. `rate` is the row of the first derivative over the coordinates. `|e^{Gt}| ≤ e^{(μ+σ)t} (I + t |M|)`.
fn variation_bounds(block: &Block, rate: [f64; 2], step: f64) -> [f64; 2] {
    let time = NODES as f64 * step;
    let grown = ((block.growth() + block.spread().unwrap_or(0.0)).max(0.0) * time).exp();
    let m = block.traceless();
    let stays = |i: usize, j: usize| f64::from(u8::from(i == j)) + time * m[i][j].abs();
    [0, 1].map(|j| grown * (rate[0].abs() * stays(0, j) + rate[1].abs() * stays(1, j)))
}
