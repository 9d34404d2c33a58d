//! The start of a trajectory, and its state.

use super::{ActiveSet, Model};
use serde::Serialize;

/// The start of a trajectory.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum InitialState {
    /// Static equilibrium under the mean torques with the contacts at the start of their cycles. Rigid rotations
    /// have the velocity at which touching contacts follow the rates of their errors and gaps. Elastic modes have
    /// no velocity.
    Static,
    /// All modal coordinates and velocities zero.
    Rest,
    /// Given modal coordinates, in the structure's modes.
    Modal {
        /// Displacements \[m √kg\], one per mode.
        displacement: Vec<f64>,
        /// Velocities \[m √kg/s\], one per mode.
        velocity: Vec<f64>,
    },
}

/// A trajectory's state at the start of a mesh cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryState {
    /// First components of all blocks, then second components: length 2N. The blocks of dry sliders come last.
    pub state: Vec<f64>,
    /// The closed contacts.
    pub contact: ActiveSet,
    /// Mesh cycles since the start of the simulation.
    pub cycle: u64,
}

impl TrajectoryState {
    /// A state at the start of a mesh cycle. The deflections determine the closed contacts. Dry sliders move
    /// if their springs are stretched beyond their limits. A state beyond a rigid stop is moved onto the
    /// stop.
    pub fn new(model: &Model, mut state: Vec<f64>, cycle: u64) -> Self {
        let segments = model.segments_at(cycle, 0.0);
        model.clamp_sliders(&segments, cycle, &mut state);
        model.move_onto_stops(&segments, cycle, &mut state);
        let springs = model.active_set(&segments, cycle, &state, 0.0);
        Self {
            contact: model.with_rests(&segments, springs, cycle, &state),
            state,
            cycle,
        }
    }
}

impl Model {
    /// The state of a trajectory at the start of mesh cycle 0. Dry sliders start without a force.
    ///
    /// # Panics
    /// If the static equilibrium is requested, and a model changed after [`Model::new`] has none.
    pub fn start(&self, initial: &InitialState) -> TrajectoryState {
        let n = self.blocks.len();
        let mut state = match initial {
            InitialState::Rest => vec![0.0; 2 * n],
            InitialState::Static => self.resting().state,
            InitialState::Modal {
                displacement,
                velocity,
            } => self.basis.state(displacement, velocity),
        };
        self.relax_sliders(&mut state);
        TrajectoryState::new(self, state, 0)
    }

    /// The mean modal forces on the rotated modes \[N/√kg\].
    pub fn load_on_modes(&self) -> Vec<f64> {
        let inputs: Vec<_> = self.blocks.iter().map(|block| block.static_input).collect();
        self.basis.force(&inputs)
    }

    /// The participations w in the deflection and g in the force of a direction, one entry per rotated mode.
    pub fn participations(&self, direction: usize) -> [Vec<f64>; 2] {
        let gains = &self.directions[direction].gains;
        let rows: Vec<_> = gains.iter().map(|gain| gain.deflection).collect();
        let inputs: Vec<_> = gains.iter().map(|gain| gain.mesh_input).collect();
        [
            self.basis.displacement_gains(&rows),
            self.basis.force(&inputs),
        ]
    }
}
