//! In which norm are tangents and distances measured?
//!
//! The raw norm ([`EnergyNorm::raw`]) adds metres to metres per second and includes the rigid rotation. It
//! exists to show the effect of the norm on an estimate. In the energy norm, a mode counts with its kinetic
//! and potential energy, `‖x‖² = Σ v² + max(ω, ω_mesh)² q²`. Here `ω_mesh² = k Σ w·g` is the scale of the
//! closed mesh, because a rigid rotation has no stiffness. The neutral pair is omitted. It is the angle and
//! the speed of the free rotation of the whole drive, which affect nothing else. The displacement s of a dry
//! slider counts with the energy of its spring, `k s²`. Under drag the neutral rotation decays, so its speed
//! counts but its angle does not. States that differ only by a displacement without effect are equal
//! ([`EnergyNorm::project`]).

use crate::model::Model;
use std::cmp::Ordering;

/// Energy-scaled norm without the neutral pair.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyNorm {
    /// Weight of each component of a state, length 2N. It is 0 for the second component of a slider. In the
    /// energy norm it is also 0 for the neutral pair and for the indices in `unrestrained`.
    weights: Vec<f64>,
    /// Indices of the components with a weight.
    weighted: Vec<usize>,
    /// Displacements without effect that involve several components. Each has the index of a component
    /// without weight. A multiple of the displacement is subtracted from a difference of states, so that this
    /// component vanishes.
    unrestrained: Vec<(usize, Vec<f64>)>,
    /// Norm of the rigid displacement that closes the half gap: the natural unit of a state.
    unit: f64,
    /// Number of dimensions that events of dry sliders, dry friction and rigid stops can remove from the
    /// tangents.
    taken: usize,
}

impl EnergyNorm {
    /// The norm of a model.
    pub fn new(model: &Model) -> Self {
        let n = model.modes();
        let gains = model.first_gains();
        let participation: f64 = gains.iter().map(|gain| gain.deflection[0].powi(2)).sum();
        let mesh = mesh_scale(model);
        let mut weights = vec![1.0; 2 * n];
        for (i, block) in model.blocks.iter().enumerate() {
            // The first component of a mode is a displacement. The components of a block of coupled modes are
            // already scaled.
            let is_mode = block.generator[0] == [0.0, 1.0];
            weights[i] = if is_mode { block.natural_frequency().max(mesh) } else { 1.0 };
        }
        for &i in &model.neutral {
            weights[i] = 0.0;
            weights[n + i] = 0.0;
        }
        for slider in &model.sliders {
            // A slider counts with the energy of its spring. It has no second component.
            let spring = &model.contacts[slider.spring()].cycles[0];
            weights[slider.block] = spring.mean_stiffness().sqrt();
            weights[n + slider.block] = 0.0;
        }
        // The angle of the whole drive has no effect.
        let unrestrained = reduced(model.unrestrained_displacements());
        for (index, _) in &unrestrained {
            weights[*index] = 0.0;
        }
        Self {
            weighted: weighted(&weights),
            weights,
            unrestrained,
            unit: mesh * model.half_gap / participation.sqrt(),
            taken: event_dimensions(model),
        }
    }

    /// The Euclidean norm of unscaled modal displacements and velocities. It adds metres to metres per
    /// second. It includes the neutral pair: the angle and the speed of the free rotation of the whole drive.
    pub fn raw(model: &Model) -> Self {
        let gains = model.first_gains();
        let participation: f64 = gains.iter().map(|gain| gain.deflection[0].powi(2)).sum();
        let mut weights = vec![1.0; 2 * model.modes()];
        for slider in &model.sliders {
            weights[model.modes() + slider.block] = 0.0;
        }
        Self {
            weighted: weighted(&weights),
            weights,
            unrestrained: Vec::new(),
            unit: model.half_gap / participation.sqrt(),
            taken: event_dimensions(model),
        }
    }

    /// Weights of the components, length 2N; 0 for components that do not count.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Number of components that count, which is the number of exponents.
    pub fn dimension(&self) -> usize {
        self.weighted.len()
    }

    /// Number of independent tangents after every dry slider has slipped, and every dry friction and every rigid
    /// stop has held the structure.
    pub fn dimension_when_stuck(&self) -> usize {
        self.dimension().saturating_sub(self.taken)
    }

    /// Indices of the components that count, those with a weight.
    pub fn weighted_components(&self) -> &[usize] {
        &self.weighted
    }

    /// The natural unit: the norm of a displacement by half a gap.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// Norm of a vector.
    pub fn length(&self, x: &[f64]) -> f64 {
        self.product(x, x).sqrt()
    }

    /// Norm of a difference.
    pub fn distance(&self, x: &[f64], y: &[f64]) -> f64 {
        if !self.unrestrained.is_empty() {
            let deviation = self.difference(x, y);
            return deviation.iter().map(|d| d * d).sum::<f64>().sqrt();
        }
        let mut sum = 0.0;
        for ((w, a), b) in self.weights.iter().zip(x).zip(y) {
            let d = w * (a - b);
            sum += d * d;
        }
        sum.sqrt()
    }

    /// Whether the norm of a difference is at most `limit`. The sum ends early, because most larger
    /// differences exceed the limit with their first components.
    pub fn is_within(&self, limit: f64, x: &[f64], y: &[f64]) -> bool {
        if !self.unrestrained.is_empty() {
            return self.distance(x, y) <= limit;
        }
        let limit = limit * limit;
        let mut sum = 0.0;
        for ((w, a), b) in self.weights.iter().zip(x).zip(y) {
            let d = w * (a - b);
            sum += d * d;
            // This form of the comparison rejects NaN.
            if !matches!(
                sum.partial_cmp(&limit),
                Some(Ordering::Less | Ordering::Equal)
            ) {
                return false;
            }
        }
        true
    }

    /// Scalar product.
    pub fn product(&self, x: &[f64], y: &[f64]) -> f64 {
        let mut sum = 0.0;
        for ((w, a), b) in self.weights.iter().zip(x).zip(y) {
            sum += (w * a) * (w * b);
        }
        sum
    }

    /// The weighted components of a difference, in the order of [`Self::weighted_components`].
    pub fn difference(&self, x: &[f64], y: &[f64]) -> Vec<f64> {
        let mut deviation: Vec<f64> = x.iter().zip(y).map(|(a, b)| a - b).collect();
        self.project(&mut deviation);
        let scaled = |&i: &usize| self.weights[i] * deviation[i];
        self.weighted.iter().map(scaled).collect()
    }

    /// Displaces a state by `factor` times a vector of weighted components, as in [`Self::difference`].
    pub fn displace(&self, state: &mut [f64], factor: f64, along: &[f64]) {
        for (&i, component) in self.weighted.iter().zip(along) {
            state[i] += factor * component / self.weights[i];
        }
    }

    /// Removes the neutral pair, and displacements without effect, from a vector.
    pub fn project(&self, x: &mut [f64]) {
        for (index, along) in &self.unrestrained {
            let part = x[*index];
            for (a, n) in x.iter_mut().zip(along) {
                *a -= part * n;
            }
        }
        for (w, a) in self.weights.iter().zip(x) {
            if *w == 0.0 {
                *a = 0.0;
            }
        }
    }
}

/// Indices of the components with a weight.
fn weighted(weights: &[f64]) -> Vec<usize> {
    (0..weights.len()).filter(|&i| weights[i] > 0.0).collect()
}

/// Number of dimensions that events may remove from the tangents: one for each dry slider and each element of
/// dry friction, two for each rigid stop.
fn event_dimensions(model: &Model) -> usize {
    model.sliders.len() + model.frictions.len() + 2 * model.stops.len()
}

/// Scale of the closed mesh `√(k Σ w·g)` \[rad/s\].
fn mesh_scale(model: &Model) -> f64 {
    let mut coupling = 0.0;
    for gain in model.first_gains() {
        let (rate, g) = (gain.rate, gain.mesh_input);
        coupling += rate[0] * g[0] + rate[1] * g[1];
    }
    (model.first_cycle().mean_stiffness() * coupling.abs()).sqrt()
}

/// Scale of the displacement of each mode in energy, `max(ω, ω_mesh)` \[rad/s\], for coupled modes too.
pub fn modal_scales(model: &Model) -> Vec<f64> {
    let (n, mesh) = (model.modes(), mesh_scale(model));
    let frequency = |mode: usize| match model.basis.coupled() {
        None => model.blocks[mode].natural_frequency(),
        Some(coupled) => coupled.stiffness[mode * n + mode].max(0.0).sqrt(),
    };
    (0..n).map(|mode| frequency(mode).max(mesh)).collect()
}

/// Vectors that span the same space, each with the index of its largest component. There it is 1, and the
/// other vectors are 0.
fn reduced(vectors: Vec<Vec<f64>>) -> Vec<(usize, Vec<f64>)> {
    let mut out: Vec<(usize, Vec<f64>)> = Vec::new();
    for mut vector in vectors {
        for (index, other) in &out {
            let part = vector[*index];
            subtract(&mut vector, part, other);
        }
        let largest = (vector.iter().enumerate()).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let Some((index, &value)) = largest else {
            continue;
        };
        vector.iter_mut().for_each(|v| *v /= value);
        for (_, other) in &mut out {
            let part = other[index];
            subtract(other, part, &vector);
        }
        out.push((index, vector));
    }
    out
}

fn subtract(from: &mut [f64], factor: f64, vector: &[f64]) {
    for (a, b) in from.iter_mut().zip(vector) {
        *a -= factor * b;
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::model::{OperatingPoint, fixtures};
    use crate::structure::Coupling;

    /// The drive of the tests of `multistability`, with drag \[1/s\] on its rotations.
    pub fn dragged(drag: f64) -> Model {
        let mesh = [0.8, -0.6, 0.5, 0.1];
        let mut structure = fixtures::structure(&[0.0, 0.0, 2.0, 3.0], 0.1, &mesh, &mesh);
        structure.rated_force = 1.0;
        let mut damping = vec![0.0; 16];
        (damping[0], damping[5]) = (drag, 2.0 * drag);
        structure.coupling = Some(Coupling {
            damping,
            gyroscopic: vec![0.0; 16],
            stiffness: vec![0.0; 16],
        });
        let point = OperatingPoint {
            load: 1.0,
            speed: 1.0,
        };
        Model::new(&structure, &fixtures::constant_mesh(1.0, 1.0), point).unwrap()
    }

    /// Reduced vectors have the same span: each original vector is the sum of the reduced ones, weighted by its
    /// components at their indices.
    #[test]
    fn reduced_vectors_span_what_they_came_from() {
        let vectors = vec![
            vec![3.0, 1.0, 0.0, 2.0, -1.0],
            vec![1.0, 4.0, 1.0, 0.0, 0.5],
            vec![2.0, -1.0, 0.5, 1.0, 6.0],
        ];
        let found = reduced(vectors.clone());
        assert_eq!(found.len(), 3);
        for (number, (index, own)) in found.iter().enumerate() {
            assert!((own[*index] - 1.0).abs() < 1e-15);
            for (other, _) in found.iter().filter(|(other, _)| other != index) {
                assert!(own[*other].abs() < 1e-15, "{number}: {own:?}");
            }
        }
        for vector in vectors {
            for (i, value) in vector.iter().enumerate() {
                let sum: f64 = found
                    .iter()
                    .map(|(index, own)| vector[*index] * own[i])
                    .sum();
                assert!((sum - value).abs() < 1e-14, "{i}: {sum} {value}");
            }
        }
    }
}
