//! The right-hand side for the general-purpose solvers: the cheapest form of the model's equations, with O(N) work and
//! only loops that can be vectorised.

use gearatlas::model::{ActiveSet, COAST_FLANK, DRIVE_FLANK, Model};
use std::cell::Cell;

/// The equations of a model, in one contact state at a time.
///
/// Time continues from the start of the stretch, so that the end of a mesh cycle needs no restart.
pub struct Field {
    modes: usize,
    /// `v' = position q + velocity v − input F + load + …`, one entry per mode.
    position: Vec<f64>,
    velocity: Vec<f64>,
    input: Vec<f64>,
    load: Vec<f64>,
    /// `δ = Σ deflection q − e`.
    deflection: Vec<f64>,
    /// (angular frequency, amplitude, phase) of the transmission error.
    error: Vec<[f64; 3]>,
    /// Angular frequency, phase at the stretch's start and inputs of the torque ripple.
    ripple: Vec<(f64, f64, Vec<f64>)>,
    pub half_gap: f64,
    pub contact: ActiveSet,
    stiffness: f64,
    damping: f64,
    /// Number of derivative evaluations.
    evaluations: Cell<u64>,
}

impl Field {
    /// The equations of a model, from the start of mesh cycle `cycle`.
    pub fn new(model: &Model, cycle: u64) -> Self {
        for block in &model.blocks {
            assert_eq!(block.generator[0], [0.0, 1.0], "not in companion form");
        }
        let column = |entry: fn(&gearatlas::model::Block) -> f64| -> Vec<f64> {
            model.blocks.iter().map(entry).collect()
        };
        assert_eq!(model.directions.len(), 1, "the mesh force turns");
        assert_eq!(model.lines.len(), 1, "the flanks have lines of their own");
        let gains = model.first_gains();
        Self {
            modes: model.modes(),
            position: column(|b| b.generator[1][0]),
            velocity: column(|b| b.generator[1][1]),
            input: gains.iter().map(|gain| gain.mesh_input[1]).collect(),
            load: column(|b| b.static_input[1]),
            deflection: gains.iter().map(|gain| gain.deflection[0]).collect(),
            error: model
                .transmission_errors()
                .map(|h| [h.angular_frequency, h.amplitude, h.phase])
                .collect(),
            ripple: model
                .ripple
                .iter()
                .map(|r| {
                    let input = r.input.iter().map(|i| i[1]).collect();
                    (r.angular_frequency, r.phase_at(cycle, 0.0), input)
                })
                .collect(),
            half_gap: model.half_gap,
            contact: ActiveSet::FREE,
            stiffness: 0.0,
            damping: 0.0,
            evaluations: Cell::new(0),
        }
    }

    /// Length of a state.
    pub fn dimension(&self) -> usize {
        2 * self.modes
    }

    /// Switches to a contact state, with its stiffness and damping.
    pub fn switch(&mut self, contact: ActiveSet, stiffness: f64, damping: f64) {
        self.contact = contact;
        self.stiffness = stiffness;
        self.damping = damping;
    }

    /// Number of derivative evaluations so far.
    pub fn evaluations(&self) -> u64 {
        self.evaluations.get()
    }

    /// Deflection and its rate, `(δ, δ')`.
    pub fn deflection(&self, time: f64, state: &[f64]) -> (f64, f64) {
        let (q, v) = state.split_at(self.modes);
        let (mut deflection, mut rate) = (dot(&self.deflection, q), dot(&self.deflection, v));
        for &[omega, amplitude, phase] in &self.error {
            let (sin, cos) = (omega * time + phase).sin_cos();
            deflection -= amplitude * cos;
            rate += amplitude * omega * sin;
        }
        (deflection, rate)
    }

    /// Distance to the nearest surface of the contact state, negative beyond it, and its rate.
    pub fn margin(&self, time: f64, state: &[f64]) -> (f64, f64) {
        let (deflection, rate) = self.deflection(time, state);
        match self.contact {
            ActiveSet::DRIVE => (deflection - self.half_gap, rate),
            ActiveSet::COAST => (-self.half_gap - deflection, -rate),
            _ => {
                let side = deflection.signum();
                (self.half_gap - side * deflection, -side * rate)
            }
        }
    }

    /// The surface nearest to a deflection.
    pub fn nearest(&self, time: f64, state: &[f64]) -> usize {
        if self.deflection(time, state).0 > 0.0 { DRIVE_FLANK } else { COAST_FLANK }
    }

    /// Writes the derivative of a state.
    pub fn derivative(&self, time: f64, state: &[f64], out: &mut [f64]) {
        self.evaluations.set(self.evaluations.get() + 1);
        let n = self.modes;
        let (q, v) = state.split_at(n);
        let (dq, dv) = out.split_at_mut(n);
        let mut force = 0.0;
        if self.contact.touching() {
            let (deflection, rate) = self.deflection(time, state);
            force = self.stiffness * (deflection - self.contact.sign() * self.half_gap)
                + self.damping * rate;
        }
        dq.copy_from_slice(v);
        // Equal lengths, stated once, so that the loop needs no checks.
        let (a, b, g, s) = (
            &self.position[..n],
            &self.velocity[..n],
            &self.input[..n],
            &self.load[..n],
        );
        let (q, v, dv) = (&q[..n], &v[..n], &mut dv[..n]);
        for i in 0..n {
            dv[i] = a[i] * q[i] + b[i] * v[i] - g[i] * force + s[i];
        }
        for (omega, phase, input) in &self.ripple {
            let cos = (omega * time + phase).cos();
            for (d, input) in dv.iter_mut().zip(input) {
                *d += cos * input;
            }
        }
    }

    /// Writes the Jacobian's columns; `column(j)` is the memory for the j-th.
    pub fn jacobian<'a>(&self, mut column: impl FnMut(usize) -> &'a mut [f64]) {
        let n = self.modes;
        let (k, c) = if self.contact.touching() {
            (self.stiffness, self.damping)
        } else {
            (0.0, 0.0)
        };
        for j in 0..n {
            for (place, gain, own) in [(j, k, self.position[j]), (n + j, c, self.velocity[j])] {
                let entries = column(place);
                entries.fill(0.0);
                for i in 0..n {
                    entries[n + i] = -self.input[i] * gain * self.deflection[j];
                }
                entries[n + j] += own;
                if place >= n {
                    entries[j] = 1.0;
                }
            }
        }
    }
}

/// Inner product with eight partial sums, so that the additions need not wait for one another.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_chunks, a_rest) = a.as_chunks::<8>();
    let (b_chunks, b_rest) = b.as_chunks::<8>();
    for (x, y) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..8 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    sums.iter().sum::<f64>() + rest
}
