//! Where a trajectory starts, and the state it carries.

use super::{ActiveSet, COAST_FLANK, DRIVE_FLANK, Model};
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
            } => {
                let mut state = self.from_structure(displacement);
                state.extend(self.from_structure(velocity));
                state
            }
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
        let gains = self.gains(segment);
        let elastic = |i: usize| self.blocks[i].natural_frequency() > 0.0;
        // Deflection of the elastic modes: δ = free − flexibility F.
        let mut free = -error;
        let mut flexibility = 0.0;
        for i in (0..n).filter(|&i| elastic(i)) {
            let unit = self.static_response(i, gains[i].mesh_input);
            let load = self.static_response(i, self.blocks[i].static_input);
            let w = gains[i].deflection;
            free += w[0] * load[0] + w[1] * load[1];
            flexibility += w[0] * unit[0] + w[1] * unit[1];
        }
        let asked = match rigid {
            Some(r) => self.blocks[r].static_input[1] / gains[r].mesh_input[1],
            None => k * (free - side * b) / (1.0 + k * flexibility),
        };
        // A contact does not pull.
        let force = match rigid.is_some() || side * asked > 0.0 {
            true => asked,
            false => 0.0,
        };
        let mut state = vec![0.0; 2 * n];
        for i in (0..n).filter(|&i| elastic(i)) {
            let block = &self.blocks[i];
            let input = [0, 1].map(|j| block.static_input[j] - gains[i].mesh_input[j] * force);
            let x = self.static_response(i, input);
            state[i] = x[0];
            state[n + i] = x[1];
        }
        if let Some(r) = rigid {
            let deflection = force / k + side * b;
            state[r] = (deflection - (free - flexibility * force)) / gains[r].deflection[0];
            state[n + r] = (error_rate + side * opening) / gains[r].deflection[0];
        }
        // The flank that is in the way of the load, where none is reached, is the other one.
        (
            state,
            if rigid.is_none() && force == 0.0 {
                free
            } else {
                asked
            },
        )
    }

    /// `−A⁻¹ input` of an elastic block.
    fn static_response(&self, i: usize, input: [f64; 2]) -> [f64; 2] {
        let [[a, b], [c, d]] = self.blocks[i].generator;
        let det = a * d - b * c;
        [
            -(d * input[0] - b * input[1]) / det,
            -(a * input[1] - c * input[0]) / det,
        ]
    }
}
