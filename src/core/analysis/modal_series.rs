//! The motion of the modal coordinates within a window, as series.
//!
//! A window has the blocks' states at its start and the mesh force as a series. With
//! `e^{At} = C(t) I + S(t) M` (M traceless, C and S as Legendre series) each block follows as
//!
//! ```text
//! x(t) = e^{At} x₀ + ∫₀ᵗ e^{A(t−τ)} (s + Σ r cos(ωτ + φ) − g F(τ)) dτ
//! ```
//!
//! with the generator A, the static input s, the inputs r of the ripples and the mesh input g, from the universal
//! convolution table. This code shares nothing with the kernels' propagation, so that the
//! two check each other.

use super::window_cache::WindowCache;
use crate::model::{Block, Model};
use crate::numerics::convolution::{add_response, convolution24, significant};
use crate::numerics::exponential::legendre_series;
use crate::propagate::Window;
use num_complex::{Complex64, c64};
use std::borrow::Cow;

/// Number of terms of a window's series. The series of kernels have at most as many.
pub const TERMS: usize = 24;

/// Number of terms of the exponentials.
const IMPULSE_RESPONSE_TERMS: usize = 32;

/// A Legendre series on a window.
pub type Series = [f64; TERMS];

/// Response to one input: a series for each term of the exponential.
type Responses = Vec<Series>;

/// Series of the exponential's C (real part) and S (imaginary part).
type Exponential = [Complex64; IMPULSE_RESPONSE_TERMS];

/// The exponentials of all blocks for one window length.
#[derive(Debug, Clone)]
struct Exponentials {
    series: Vec<Exponential>,
    /// Number of terms above round-off.
    terms: usize,
}

impl Exponentials {
    fn new(blocks: usize) -> Self {
        Self {
            series: vec![[Complex64::ZERO; IMPULSE_RESPONSE_TERMS]; blocks],
            terms: 0,
        }
    }

    fn fill(&mut self, blocks: &[Block], tau: f64) {
        self.terms = 0;
        Block::exponentials(blocks, tau, &mut self.series);
        for out in &self.series {
            for part in [out.map(|term| term.re), out.map(|term| term.im)] {
                self.terms = self.terms.max(significant(&part));
            }
        }
    }
}

/// Modal motion of a model, window after window.
#[derive(Debug, Clone)]
pub struct ModalMotion<'m> {
    model: Cow<'m, Model>,
    /// Exponentials of all blocks for the regular window lengths of the kernel (`regular`), and for the last
    /// window of another length (`cut`).
    regular: WindowCache<Exponentials>,
    cut: Exponentials,
}

impl<'m> ModalMotion<'m> {
    /// The motion of a model's blocks.
    pub fn new(model: &'m Model) -> Self {
        Self::of(Cow::Borrowed(model))
    }

    /// The motion of the blocks of a borrowed or owned model.
    pub fn of(model: Cow<'m, Model>) -> Self {
        Self {
            regular: WindowCache::new(),
            cut: Exponentials::new(model.modes()),
            model,
        }
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The motion on a window.
    pub fn on<'a>(&'a mut self, window: &Window<'a>) -> ModalSeries<'a> {
        let tau = window.duration;
        let blocks = &self.model.blocks;
        let regular = self.regular.get_or_insert_recurring(tau, || {
            let mut new = Exponentials::new(blocks.len());
            new.fill(blocks, tau);
            new
        });
        let exponentials = match regular {
            Some(regular) => regular,
            None => {
                self.cut.fill(blocks, tau);
                &self.cut
            }
        };
        let respond = |series: &[f64]| convolution24().responses(series, tau, exponentials.terms);
        ModalSeries {
            model: &self.model,
            exponentials,
            window: *window,
            by_forces: (window.closed.iter())
                .map(|closed| {
                    let segment = &window.segments[closed.contact];
                    (segment.direction, respond(closed.force))
                })
                .collect(),
            ripples: (self.model.ripple.iter())
                .map(|ripple| {
                    let phase = ripple.phase_at(window.cycle, window.start);
                    let series = cosine_series(ripple.angular_frequency, phase, tau);
                    (series, respond(&series))
                })
                .collect(),
        }
    }
}

/// Modal motion on one window.
#[derive(Debug, Clone)]
pub struct ModalSeries<'a> {
    model: &'a Model,
    exponentials: &'a Exponentials,
    window: Window<'a>,
    /// Index of the direction of every closed contact, and the responses to the contact's force.
    by_forces: Vec<(usize, Responses)>,
    ripples: Vec<(Series, Responses)>,
}

impl<'a> ModalSeries<'a> {
    /// The model.
    pub fn model(&self) -> &'a Model {
        self.model
    }

    /// Each torque ripple's time course, `cos(ωt + φ)`.
    pub fn ripples(&self) -> impl Iterator<Item = &Series> {
        self.ripples.iter().map(|(series, _)| series)
    }

    /// Series of a block's first (`row = 0`) or second (`row = 1`) component: modal
    /// displacement \[m √kg\] and velocity \[m √kg/s\] of a companion block.
    pub fn component(&self, index: usize, row: usize) -> Series {
        let mut weights = [0.0; 2];
        weights[row] = 1.0;
        self.combination([(index, weights)])
    }

    /// Series of `Σ w·x` over the given blocks. Each block has its index and the weights w of both components
    /// x. The weighted exponentials are added first, so that every input is convolved only once.
    pub fn combination(&self, weights: impl IntoIterator<Item = (usize, [f64; 2])>) -> Series {
        let mut start = [0.0; IMPULSE_RESPONSE_TERMS];
        let mut constant = [0.0; IMPULSE_RESPONSE_TERMS];
        let mut by_forces = vec![[0.0; IMPULSE_RESPONSE_TERMS]; self.by_forces.len()];
        let mut by_ripples = vec![[0.0; IMPULSE_RESPONSE_TERMS]; self.ripples.len()];
        for (index, w) in weights.into_iter().filter(|(_, w)| *w != [0.0; 2]) {
            let block = &self.model.blocks[index];
            let exponential = &self.exponentials.series[index][..self.exponentials.terms];
            let m = block.traceless();
            let add = |u: [f64; 2], out: &mut [f64; IMPULSE_RESPONSE_TERMS]| {
                // Weights of C and S in w·e^{At} u.
                let c = w[0] * u[0] + w[1] * u[1];
                let s = w[0] * (m[0][0] * u[0] + m[0][1] * u[1])
                    + w[1] * (m[1][0] * u[0] + m[1][1] * u[1]);
                for (value, e) in out.iter_mut().zip(exponential) {
                    *value += e.re * c + e.im * s;
                }
            };
            add(
                [self.window.first[index], self.window.second[index]],
                &mut start,
            );
            add(block.static_input, &mut constant);
            for ((direction, _), out) in self.by_forces.iter().zip(&mut by_forces) {
                let gain = &self.model.directions[*direction].gains[index];
                add(gain.mesh_input.map(|g| -g), out);
            }
            for (ripple, out) in self.model.ripple.iter().zip(&mut by_ripples) {
                add(ripple.input[index], out);
            }
        }
        let mut out = padded(&start);
        add_constant(&constant, self.window.duration, &mut out);
        let forces = self.by_forces.iter().map(|(_, responses)| responses);
        let ripples = self.ripples.iter().map(|(_, responses)| responses);
        let kernels = by_forces.iter().chain(&by_ripples);
        for (kernel, responses) in kernels.zip(forces.chain(ripples)) {
            add_response(kernel, responses, &mut out);
        }
        out
    }

    /// Deflection along one of the model's directions \[m\].
    pub fn along(&self, direction: usize) -> Series {
        let direction = &self.model.directions[direction];
        let gains = direction.gains.iter().map(|gain| gain.deflection);
        let mut out = self.combination(gains.enumerate());
        for h in &self.model.lines[direction.line].transmission_error {
            let phase = h.turned(self.window.cycle, self.window.start) + h.phase;
            let cosine = cosine_series(h.angular_frequency, phase, self.window.duration);
            add_multiple(-h.amplitude, &cosine, &mut out);
        }
        out
    }
}

/// Adds a multiple of one series to another.
pub fn add_multiple(factor: f64, series: &Series, sum: &mut Series) {
    if factor != 0.0 {
        for (sum, value) in sum.iter_mut().zip(series) {
            *sum += factor * value;
        }
    }
}

/// Adds the response to a constant input: `∫₀ᵗ P_k dt = Δ/2 (P_{k+1} − P_{k−1})/(2k+1)`, with
/// `P_{−1} = −1`.
fn add_constant(kernel: &[f64; IMPULSE_RESPONSE_TERMS], tau: f64, out: &mut Series) {
    for (k, scale) in kernel[..=TERMS].iter().enumerate() {
        let value = 0.5 * tau * scale / (2 * k + 1) as f64;
        if k + 1 < TERMS {
            out[k + 1] += value;
        }
        match k {
            0 => out[0] += value,
            _ => out[k - 1] -= value,
        }
    }
}

/// A window's series with all its terms.
pub fn padded(series: &[f64]) -> Series {
    let mut out = [0.0; TERMS];
    let count = series.len().min(TERMS);
    out[..count].copy_from_slice(&series[..count]);
    out
}

/// `cos(ωt + phase)` on a window.
pub fn cosine_series(omega: f64, phase: f64, tau: f64) -> Series {
    let mut series = [Complex64::ZERO; TERMS];
    legendre_series(c64(0.0, omega), tau, &mut series);
    let turn = Complex64::cis(phase);
    series.map(|u| (turn * u).re)
}

/// `∫ a b dt` over a window.
pub fn integral(a: &Series, b: &Series, tau: f64) -> f64 {
    let mut sum = 0.0;
    for n in 0..TERMS {
        sum += a[n] * b[n] / (2 * n + 1) as f64;
    }
    tau * sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{
        ActiveSet, Drive, DriveShaft, InitialState, OperatingPoint, TorqueRipple, fixtures,
    };
    use crate::numerics::legendre::{at_end, at_start, evaluate};
    use crate::propagate::{ClosedContact, Counters, Event, Kernel, Observer, Volterra};
    use crate::structure::ModalStructure;

    /// A drive that rattles: two rigid rotations and two elastic modes, with friction and ripple.
    fn drive() -> (ModalStructure, Drive) {
        let structure = ModalStructure {
            damping: vec![0.0, 0.0, 0.01, 0.02],
            pinion_torque: Some(vec![16.0, 2.0, 8.0, 1.0]),
            friction: vec![0.1, 0.2, -0.17, 0.3],
            ..fixtures::structure(
                &[0.0, 0.0, 4288.0, 8171.0],
                0.0,
                &[0.61, -0.49, 0.72, -0.48],
                &[0.61, -0.49, 0.33, 0.05],
            )
        };
        let drive = Drive {
            friction: 0.1,
            torque_ripple: vec![TorqueRipple {
                shaft: DriveShaft::Pinion,
                order: 2.0,
                amplitude: 1.5,
                phase: 0.3,
            }],
            ..fixtures::two_level_mesh(10e-6)
        };
        (structure, drive)
    }

    fn model() -> Model {
        let (structure, drive) = drive();
        let point = OperatingPoint {
            load: 0.1,
            speed: 1200.0,
        };
        Model::new(&structure, &drive, point).unwrap()
    }

    /// Compares the end of every window with the state that the next one starts from.
    struct ContinuityCheck<'m> {
        motion: ModalMotion<'m>,
        ends: Vec<[f64; 2]>,
        windows: u64,
        events: u64,
        largest: [f64; 2],
        worst: [f64; 2],
    }

    impl Observer for ContinuityCheck<'_> {
        const WINDOWS: bool = true;

        fn window(&mut self, window: &Window<'_>) {
            for (i, end) in self.ends.iter().enumerate() {
                for (row, now) in [window.first[i], window.second[i]].into_iter().enumerate() {
                    self.worst[row] = self.worst[row].max((end[row] - now).abs());
                    self.largest[row] = self.largest[row].max(now.abs());
                }
            }
            let series = self.motion.on(window);
            self.ends = (0..window.first.len())
                .map(|i| {
                    let start = [0, 1].map(|row| at_start(&series.component(i, row)));
                    for (row, now) in [window.first[i], window.second[i]].into_iter().enumerate() {
                        self.worst[row] = self.worst[row].max((start[row] - now).abs());
                    }
                    [0, 1].map(|row| at_end(&series.component(i, row)))
                })
                .collect();
            self.windows += 1;
        }

        fn event(&mut self, _: &Event) {
            self.events += 1;
        }
    }

    #[test]
    fn series_lead_from_each_window_to_the_next() {
        let model = model();
        let kernel = Volterra::new(&model, f64::EPSILON, 1000);
        let mut trajectory = model.start(&InitialState::Static);
        let mut workspace = kernel.workspace();
        let mut chain = ContinuityCheck {
            motion: ModalMotion::new(&model),
            ends: Vec::new(),
            windows: 0,
            events: 0,
            largest: [0.0; 2],
            worst: [0.0; 2],
        };
        kernel
            .advance(
                40,
                &mut trajectory,
                &mut workspace,
                &mut chain,
                &mut Counters::default(),
            )
            .unwrap();
        assert!(chain.events > 20, "{} events: no rattle", chain.events);
        assert!(chain.windows > 200, "{} windows", chain.windows);
        for row in 0..2 {
            let error = chain.worst[row] / chain.largest[row];
            assert!(error < 2e-14, "component {row}: {error:e}");
        }
    }

    #[test]
    fn a_constant_force_bends_a_damped_oscillator_as_in_the_textbook() {
        let model = model();
        let (index, force, tau) = (2, 700.0, 2e-4);
        let (first, second) = (vec![0.0; 4], vec![0.0; 4]);
        let window = Window {
            along: &[],
            cycle: 0,
            start: 0.0,
            duration: tau,
            segments: &model.segments_at(0, 0.0),
            contact: ActiveSet::DRIVE,
            deflection: &[2e-5],
            force: &[force],
            closed: &[ClosedContact {
                contact: 0,
                deflection: &[2e-5],
                force: &[force],
            }],
            first: &first,
            second: &second,
        };
        let mut unloaded = model.clone();
        unloaded.ripple.clear();
        let mut motion = ModalMotion::new(&unloaded);
        let series = motion.on(&window);
        let (omega, zeta): (f64, f64) = (4288.0, 0.01);
        let nu = omega * (1.0 - zeta * zeta).sqrt();
        let b = &model.blocks[index];
        let load = b.static_input[1] - model.first_gains()[index].mesh_input[1] * force;
        for x in [-1.0, -0.4, 0.3, 1.0] {
            let t = 0.5 * tau * (x + 1.0);
            let decay = (-zeta * omega * t).exp();
            let (sin, cos) = (nu * t).sin_cos();
            let settled = load / (omega * omega);
            let q = settled * (1.0 - decay * (cos + zeta * omega / nu * sin));
            let v = load / nu * decay * sin;
            let scale = [settled, load / nu];
            for (row, exact) in [q, v].into_iter().enumerate() {
                let error = (evaluate(&series.component(index, row), x) - exact) / scale[row];
                assert!(error.abs() < 4e-15, "component {row} at {x}: {error:e}");
            }
        }
    }
}
