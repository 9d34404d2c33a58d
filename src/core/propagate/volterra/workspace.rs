//! Scratch memory of an integration.

use super::joint::JointWorkspace;
use super::lanes::Solution;
use super::partial::Cut;
use super::shapes::{LANES, Row};
use super::tables::VolterraTables;
use super::varying::Factors;
use crate::model::{MeshGain, Model, Segment, TrajectoryState};
use crate::propagate::Tangents;
use crate::propagate::tangents::{read_padded, write_padded};

/// Scratch memory of the structured kernel.
#[derive(Debug)]
pub struct Workspace {
    /// Columns: the trajectory, then its tangents. Each column has the first and then the second components of all
    /// blocks, padded to whole chunks. Later integrations reuse the memory of earlier ones.
    columns: Vec<f64>,
    /// Entries of a column.
    length: usize,
    /// Columns in this integration.
    count: usize,
    /// Values of the inputs at the start of the present window.
    pub inputs: Vec<f64>,
    /// Force series of every column on the present window, meaningless in free flight.
    pub forces: Vec<Row>,
    /// Solutions of the trajectory on the present window, one per line. The first is along the line of the force.
    pub solutions: Vec<Solution>,
    /// The segment of every contact on the present window.
    pub segments: Vec<Segment>,
    /// Memory for windows with several closed contacts.
    pub joint: JointWorkspace,
    /// Delay of the last event of dry friction for every tangent \[s\].
    pub delays: Vec<f64>,
    /// Cycle and time of that event.
    pub delays_from: (u64, f64),
    /// The position where a window was cut.
    pub cut: Cut,
    /// Factors of the present window, if it is off the grid and its stiffness varies.
    pub factors: Factors,
}

impl Workspace {
    /// Memory for a trajectory without tangents.
    pub fn new(model: &Model, tables: &VolterraTables) -> Self {
        let layout = tables.layout;
        Self {
            columns: vec![0.0; 2 * layout.padded],
            length: 2 * layout.padded,
            count: 1,
            inputs: vec![0.0; layout.inputs],
            forces: vec![Row::ZERO],
            solutions: vec![Solution::ZERO; model.lines.len()],
            segments: model.segments_at(0, 0.0),
            joint: JointWorkspace::default(),
            delays: Vec::new(),
            delays_from: (u64::MAX, 0.0),
            cut: Cut::new(layout.padded / LANES),
            factors: Factors::NONE,
        }
    }

    /// Tangents in this integration.
    pub fn tangents(&self) -> usize {
        self.count - 1
    }

    /// First and second components of the trajectory's first `modes` blocks.
    pub fn components(&self, modes: usize) -> [&[f64]; 2] {
        let (first, second) = self.columns[..self.length].split_at(self.length / 2);
        [&first[..modes], &second[..modes]]
    }

    /// Inputs and outputs of the solution of a window: inputs, columns, factors, forces, solution.
    pub fn solving(&mut self) -> (&[f64], &[f64], &Factors, &mut [Row], &mut Solution) {
        (
            &self.inputs,
            &self.columns[..self.count * self.length],
            &self.factors,
            &mut self.forces[..self.count],
            &mut self.solutions[0],
        )
    }

    /// Inputs, trajectory and its force, and memory for the solution along another line.
    pub fn trajectory(&mut self) -> (&[f64], &[f64], &Row, &mut [Solution]) {
        (
            &self.inputs,
            &self.columns[..self.length],
            &self.forces[0],
            &mut self.solutions,
        )
    }

    /// Inputs, all columns, and memory for the joint solution with the number of columns.
    pub fn joining(&mut self) -> (&[f64], &[f64], &mut JointWorkspace, &mut [Solution], usize) {
        (
            &self.inputs,
            &self.columns[..self.count * self.length],
            &mut self.joint,
            &mut self.solutions,
            self.count,
        )
    }

    /// Data for the move over a full or cut window: columns, forces, inputs, cut, and memory of a joint
    /// solution. Without contact there are no forces.
    pub fn cutting(
        &mut self,
        touching: bool,
    ) -> (
        &mut [f64],
        &mut [Row],
        &[f64],
        &mut Cut,
        &mut JointWorkspace,
    ) {
        let forces = if touching { self.count } else { 0 };
        (
            &mut self.columns[..self.count * self.length],
            &mut self.forces[..forces],
            &self.inputs,
            &mut self.cut,
            &mut self.joint,
        )
    }

    /// All tangents, one after the other.
    pub fn tangents_mut(&mut self) -> &mut [f64] {
        &mut self.columns[self.length..self.count * self.length]
    }

    /// All columns, the trajectory first: first and second components of the blocks.
    pub fn columns_in_parts(&mut self) -> impl Iterator<Item = [&mut [f64]; 2]> {
        let (length, half) = (self.length, self.length / 2);
        let columns = self.columns[..self.count * length].chunks_exact_mut(length);
        columns.map(move |column| {
            let (first, second) = column.split_at_mut(half);
            [first, second]
        })
    }

    /// Sets the first component of a block of every column to the deflection along a line from all other blocks.
    /// Subtracts `offset` for the trajectory.
    pub fn follow(&mut self, block: usize, gains: &[MeshGain], offset: f64) {
        let (length, padded) = (self.length, self.length / 2);
        let mut offset = Some(offset);
        for column in self.columns[..self.count * length].chunks_exact_mut(length) {
            column[block] = 0.0;
            let terms = gains.iter().enumerate().map(|(i, gain)| {
                gain.deflection[0] * column[i] + gain.deflection[1] * column[padded + i]
            });
            column[block] = terms.sum::<f64>() - offset.take().unwrap_or(0.0);
        }
    }

    /// Copies trajectory and tangents into the padded layout.
    pub fn load(&mut self, trajectory: &TrajectoryState, tangents: &Tangents) {
        self.count = 1 + tangents.count();
        // Delays of another trajectory do not apply.
        self.delays_from = (u64::MAX, 0.0);
        if self.forces.len() < self.count {
            self.forces.resize(self.count, Row::ZERO);
            self.columns.resize(self.count * self.length, 0.0);
        }
        write_padded(&mut self.columns, self.length, &trajectory.state, tangents);
    }

    /// Copies trajectory and tangents back.
    pub fn store(&self, trajectory: &mut TrajectoryState, tangents: &mut Tangents) {
        read_padded(&self.columns, self.length, &mut trajectory.state, tangents);
    }
}
