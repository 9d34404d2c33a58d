//! Where a trajectory starts, and the state it carries.

use super::{ActiveSet, COAST_FLANK, DRIVE_FLANK, Model};
use crate::numerics::linalg;
use faer::Mat;
use serde::Serialize;

/// Where a trajectory starts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum InitialState {
    /// Static equilibrium under the mean torques with the mesh as it is at the start of the
    /// mesh cycle. The flanks do not move against each other: the rotation goes along with a
    /// transmission error that changes there.
    Static,
    /// All modal coordinates and velocities zero.
    Rest,
    /// Given modal coordinates, in the structure's own basis.
    Modal {
        /// Displacements \[m √kg\], one a mode.
        displacement: Vec<f64>,
        /// Velocities \[m √kg/s\], one a mode.
        velocity: Vec<f64>,
    },
}

/// A trajectory's state at the start of a mesh cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryState {
    /// First components of all blocks, then second components: length 2N.
    pub state: Vec<f64>,
    /// The contacts that are closed.
    pub contact: ActiveSet,
    /// Mesh cycles since the start of the simulation.
    pub cycle: u64,
}

impl TrajectoryState {
    /// The state `state` at the start of mesh cycle `cycle`; which contacts are closed follows
    /// from the deflections.
    pub fn new(model: &Model, state: Vec<f64>, cycle: u64) -> Self {
        let segments = model.segments_at(cycle, 0.0);
        Self {
            contact: model.active_set(&segments, cycle, &state, 0.0),
            state,
            cycle,
        }
    }
}

impl Model {
    /// The trajectory that starts as asked, at mesh cycle 0.
    pub fn start(&self, initial: &InitialState) -> TrajectoryState {
        let n = self.blocks.len();
        let state = match initial {
            InitialState::Rest => vec![0.0; 2 * n],
            InitialState::Static => self.static_equilibrium(),
            InitialState::Modal {
                displacement,
                velocity,
            } => self.basis.state(displacement, velocity),
        };
        TrajectoryState::new(self, state, 0)
    }

    /// Static equilibrium under the mean torques with the mesh at the start of its cycle: on the
    /// drive flank where that pushes, else on the coast flank.
    fn static_equilibrium(&self) -> Vec<f64> {
        let (state, force) = self.equilibrium_on(DRIVE_FLANK);
        match force < 0.0 && COAST_FLANK < self.contacts.len() {
            true => self.equilibrium_on(COAST_FLANK).0,
            false => state,
        }
    }

    /// Static equilibrium with no more than one contact closed, and the force that it would have
    /// to bear along its direction \[N\]. That is the one that the rigid relative rotation asks for,
    /// where there is one; otherwise the one that stiffness and gap settle on.
    fn equilibrium_on(&self, contact: usize) -> (Vec<f64>, f64) {
        let n = self.blocks.len();
        let contact = &self.contacts[contact];
        let segment = &contact.cycle(0).segments[0];
        let k = segment.stiffness_at(0.0);
        let [b, opening] = contact.gap(segment, 0.0);
        let side = contact.side;
        let (error, error_rate) = self.lines[self.line(segment)].transmission_error_at(0, 0.0);
        let rigid = self.relative_rotation();
        let [w, g] = self.participations(segment.direction);
        let load = self.load_on_modes();
        let along = |first: f64, x: &[f64]| w.iter().zip(x).fold(first, |sum, (w, x)| sum + w * x);
        // Deflection of the elastic modes: δ = free − flexibility F.
        let [at_load, at_unit] = [&load, &g].map(|force| self.elastic_response(force));
        let free = along(-error, &at_load);
        let flexibility = along(0.0, &at_unit);
        let asked = match rigid {
            Some(r) => load[r] / g[r],
            None => k * (free - side * b) / (1.0 + k * flexibility),
        };
        // A contact does not pull.
        let force = match rigid.is_some() || side * asked > 0.0 {
            true => asked,
            false => 0.0,
        };
        let left: Vec<f64> = load
            .iter()
            .zip(&g)
            .map(|(load, g)| load - g * force)
            .collect();
        let mut modes = self.elastic_response(&left);
        modes.resize(2 * n, 0.0);
        if let Some(r) = rigid {
            let deflection = force / k + side * b;
            modes[r] = (deflection - (free - flexibility * force)) / w[r];
            modes[n + r] = (error_rate + side * opening) / w[r];
        }
        // The flank that is in the way of the load, where none is reached, is the other one.
        let asked = if rigid.is_none() && force == 0.0 {
            free
        } else {
            asked
        };
        (self.basis.state_of_turned(&modes), asked)
    }

    /// The mean load on the turned modes.
    pub fn load_on_modes(&self) -> Vec<f64> {
        let inputs: Vec<_> = self.blocks.iter().map(|block| block.static_input).collect();
        self.basis.force(&inputs)
    }

    /// Participations w and g of a direction in deflection and force, of the turned modes.
    pub fn participations(&self, direction: usize) -> [Vec<f64>; 2] {
        let n = self.blocks.len();
        let gains = &self.directions[direction].gains;
        let w = match self.basis.coupled() {
            None => gains.iter().map(|gain| gain.deflection[0]).collect(),
            Some(coupled) => {
                let along = |k: usize| {
                    let row = |i: usize| coupled.from_modes[2 * n * i + k];
                    let terms = gains.iter().enumerate().map(|(i, gain)| {
                        gain.deflection[0] * row(i) + gain.deflection[1] * row(n + i)
                    });
                    terms.sum()
                };
                (0..n).map(along).collect()
            }
        };
        let inputs: Vec<_> = gains.iter().map(|gain| gain.mesh_input).collect();
        [w, self.basis.force(&inputs)]
    }

    /// Displacements of the turned modes under a constant force; those of rigid ones are left zero.
    fn elastic_response(&self, force: &[f64]) -> Vec<f64> {
        let n = force.len();
        let mut out = vec![0.0; n];
        let elastic: Vec<usize> = (0..n).filter(|i| !self.basis.rigid().contains(i)).collect();
        match self.basis.coupled() {
            None => {
                for &i in &elastic {
                    out[i] = force[i] / -self.blocks[i].generator[1][0];
                }
            }
            Some(coupled) if !elastic.is_empty() => {
                let entry = |i: usize, j: usize| coupled.stiffness[n * elastic[i] + elastic[j]];
                let matrix = Mat::from_fn(elastic.len(), elastic.len(), entry);
                let right: Vec<f64> = elastic.iter().map(|&i| force[i]).collect();
                for (&i, x) in elastic.iter().zip(linalg::solve(matrix.as_ref(), &right)) {
                    out[i] = x;
                }
            }
            Some(_) => {}
        }
        out
    }
}
