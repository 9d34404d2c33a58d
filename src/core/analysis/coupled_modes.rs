//! Which energies and works does the energy balance of a structure with coupled modes contain?
//!
//! If modes are coupled, the blocks of the model are not modes. The model's basis maps the blocks to the
//! modes' displacements q and velocities v. D is the whole damping matrix, including gyroscopic terms. K and
//! K_a are the symmetric and the skew part of the whole stiffness matrix. f is the load on the modes, and F the force
//! of a contact with the input g and the participation w.
//!
//! ```text
//! stored: ½ (v·v + q·K q)      works: ∫ f·v dt,  −∫ v·D v dt,  −∫ v·K_a q dt,  −∫ F (g − w)·v dt
//! ```

use super::energy::Cause;
use super::modal_series::{ModalSeries, Series, TERMS, integral, padded};
use crate::model::{Coupled, Model};
use crate::numerics::legendre::at_start;
use crate::propagate::Window;

/// The coupled modes of a model.
#[derive(Debug, Clone)]
pub(super) struct CoupledModes {
    coupled: Coupled,
    /// Mean load on every mode.
    load: Vec<f64>,
    /// Input of every torque ripple to each mode.
    ripples: Vec<Vec<f64>>,
    /// Participations in deflection and force, per direction.
    participations: Vec<[Vec<f64>; 2]>,
}

impl CoupledModes {
    /// The coupled modes of a model; `None` if damping is modal.
    pub fn of(model: &Model) -> Option<Self> {
        Some(Self {
            coupled: model.basis.coupled()?.clone(),
            load: model.load_on_modes(),
            ripples: (model.ripple.iter())
                .map(|ripple| model.basis.force(&ripple.input))
                .collect(),
            participations: (0..model.directions.len())
                .map(|direction| model.participations(direction))
                .collect(),
        })
    }

    /// Symmetric (`sign` +1) or skew (−1) part of the stiffness.
    fn stiffness(&self, i: usize, j: usize, sign: f64) -> f64 {
        let n = self.load.len();
        let k = &self.coupled.stiffness;
        0.5 * (k[i * n + j] + sign * k[j * n + i])
    }

    /// Energy stored in the structure \[J\].
    pub fn stored(&self, model: &Model, first: &[f64], second: &[f64]) -> f64 {
        let n = first.len();
        let modes = model.basis.turned_modes(&[first, second].concat());
        let (q, v) = modes.split_at(n);
        let mut energy = 0.0;
        for i in 0..n {
            energy += 0.5 * v[i] * v[i];
            for j in 0..n {
                energy += 0.5 * q[i] * self.stiffness(i, j, 1.0) * q[j];
            }
        }
        energy
    }

    /// Magnitude of the energies whose round-off enters the balance, at the start of a window at mesh phase
    /// `phase`.
    pub fn magnitude(&self, model: &Model, window: &Window<'_>, phase: f64) -> f64 {
        let n = self.load.len();
        let modes = model
            .basis
            .turned_modes(&[window.first, window.second].concat());
        let (q, _) = modes.split_at(n);
        let mut sum = self.stored(model, window.first, window.second).abs();
        sum += q
            .iter()
            .zip(&self.load)
            .map(|(q, f)| (q * f).abs())
            .sum::<f64>();
        let springs = (window.closed.iter()).filter(|closed| model.is_spring(closed.contact));
        for closed in springs {
            let segment = &window.segments[closed.contact];
            let contact = &model.contacts[closed.contact];
            let [w, _] = &self.participations[segment.direction];
            let deflection = at_start(&padded(closed.deflection));
            let room = w.iter().zip(q).map(|(w, q)| (w * q).abs()).sum::<f64>()
                + model.half_gap
                + deflection.abs();
            let stretch = (deflection - contact.side * contact.half_gap).abs();
            sum += segment.stiffness_at(phase) * (stretch + f64::EPSILON * room) * room;
        }
        sum
    }

    /// Passes the work of loads, friction, damping and the skew part of the stiffness over a window to
    /// `work`, each with its cause.
    pub fn works(
        &self,
        window: &Window<'_>,
        series: &ModalSeries<'_>,
        work: &mut impl FnMut(Cause, f64),
    ) {
        let (n, tau) = (self.load.len(), window.duration);
        let components: Vec<Series> = (0..2 * n)
            .map(|column| series.component(column % n, column / n))
            .collect();
        let rows: Vec<Series> = (0..2 * n)
            .map(|row| {
                let mut sum = [0.0; TERMS];
                let entries = &self.coupled.to_modes[2 * n * row..][..2 * n];
                for (entry, component) in entries.iter().zip(&components) {
                    for (sum, c) in sum.iter_mut().zip(component) {
                        *sum += entry * c;
                    }
                }
                sum
            })
            .collect();
        let (q, v) = rows.split_at(n);
        let (mut torque, mut damping, mut skew) = (0.0, 0.0, 0.0);
        for i in 0..n {
            torque += self.load[i] * tau * v[i][0];
            for (input, course) in self.ripples.iter().zip(series.ripples()) {
                torque += input[i] * integral(course, &v[i], tau);
            }
            for j in 0..n {
                let d = self.coupled.damping[i * n + j];
                if d != 0.0 {
                    damping -= d * integral(&v[i], &v[j], tau);
                }
                let k = self.stiffness(i, j, -1.0);
                if k != 0.0 {
                    skew -= k * integral(&v[i], &q[j], tau);
                }
            }
        }
        work(Cause::Loads, torque);
        work(Cause::Structure, damping);
        work(Cause::Structure, skew);
        for closed in window.closed {
            let segment = &window.segments[closed.contact];
            let direction = series
                .model()
                .motion_direction_index(closed.contact, segment);
            let [w, g] = &self.participations[direction];
            let force = padded(closed.force);
            for i in (0..n).filter(|&i| g[i] != w[i]) {
                work(
                    Cause::Friction,
                    -(g[i] - w[i]) * integral(&force, &v[i], tau),
                );
            }
        }
    }
}
