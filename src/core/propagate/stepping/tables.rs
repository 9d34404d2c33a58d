//! Tables that the steps of a base period read.

use crate::model::{Contact, Direction, MeshGain, Model};

/// Rows of δ and δ', column of the contact force; length 2N each.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    pub line: usize,
    pub deflection: Vec<f64>,
    pub rate: Vec<f64>,
    pub mesh_input: Vec<f64>,
}

/// A contact over a base period.
#[derive(Debug, Clone)]
pub(super) struct ContactTable {
    pub contact: Contact,
    /// Largest gap on any of its lines \[m\].
    pub gap: f64,
    /// Whether its line or its gap changes at the start of some segment.
    pub turns: bool,
    /// The contact at the middle of every step.
    pub middles: Vec<MidStepContact>,
}

/// A contact at the middle of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct MidStepContact {
    /// Its segment in the mesh cycle.
    pub segment: usize,
    /// Whether its line or gap changes at the start of the step, so that it may open or close there.
    pub turned: bool,
    /// Stiffness \[N/m\].
    pub stiffness: f64,
    /// Rate at which its force decays because its own impulse changes the deflection \[1/s\].
    pub decay: f64,
}

impl MidStepContact {
    /// Impulse per unit of the initial force \[s\] over a time \[s\].
    pub fn impulse(&self, time: f64) -> f64 {
        if self.decay == 0.0 {
            time
        } else {
            -(-self.decay * time).exp_m1() / self.decay
        }
    }
}

impl ContactTable {
    /// The table of a contact for `steps` steps per mesh cycle.
    pub fn new(model: &Model, contact: &Contact, directions: &[Rows], steps: usize) -> Self {
        let segments = contact.cycles.iter().flat_map(|cycle| &cycle.segments);
        Self {
            gap: segments.fold(0.0, |most, s| model.gap_on(model.line(s)).max(most)),
            contact: contact.clone(),
            turns: model.ever_turns(contact),
            middles: middles(model, contact, directions, steps),
        }
    }
}

impl Rows {
    /// The rows of a direction.
    pub fn new(direction: &Direction) -> Self {
        let columns = |entry: fn(&MeshGain) -> [f64; 2]| -> Vec<f64> {
            let first = direction.gains.iter().map(|gain| entry(gain)[0]);
            let second = direction.gains.iter().map(|gain| entry(gain)[1]);
            first.chain(second).collect()
        };
        Self {
            line: direction.line,
            deflection: columns(|gain| gain.deflection),
            rate: columns(|gain| gain.rate),
            mesh_input: columns(|gain| gain.mesh_input),
        }
    }
}

/// A contact at the middle of every step of a base period.
fn middles(
    model: &Model,
    contact: &Contact,
    directions: &[Rows],
    steps: usize,
) -> Vec<MidStepContact> {
    let mut out: Vec<MidStepContact> = Vec::new();
    // A segment shorter than a step may have no step. The next step then has its change of line or gap.
    let mut turned = false;
    for number in 0..model.base_cycles() {
        let cycle = contact.cycle(number as u64);
        for (index, s) in cycle.segments.iter().enumerate() {
            let direction = &directions[s.direction];
            let direct = dot(&direction.deflection, &direction.mesh_input);
            let inertial = dot(&direction.rate, &direction.mesh_input);
            let end = (s.end * steps as f64).round() as usize;
            turned |= model.changes_direction(contact, number as u64, index);
            for j in out.len() - number * steps..end {
                let stiffness = s.stiffness_at((j as f64 + 0.5) / steps as f64);
                out.push(MidStepContact {
                    segment: index,
                    turned,
                    stiffness,
                    decay: stiffness * direct + s.damping * inertial,
                });
                turned = false;
            }
        }
    }
    out[0].turned |= turned;
    out
}

/// Scalar product.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Eight independent sums, so that additions do not wait for each other.
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
