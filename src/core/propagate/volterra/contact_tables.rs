//! Which tables does only a window in contact read?
//!
//! They are computed when a contact first closes on such a window. A motion that stays on one flank needs no
//! tables of the other flank, and none of both flanks together. For a mesh that is computed from a drawing,
//! these are most of the tables.

use super::block_exponential::Kernels;
use super::feedback::Feedback;
use super::lanes;
use super::shapes::{Row, TERMS};
use super::varying::{Factors, Nodal};
use super::window_stiffness::WindowStiffness;
use crate::numerics::convolution::convolution24;
use crate::propagate::vectors::InstructionSet;

/// The data from which the tables of windows in contact are computed.
#[derive(Debug)]
pub struct ContactRequest {
    /// Window length Δ \[s\].
    pub delta: f64,
    /// Stiffnesses of contacts on such windows.
    pub closures: Vec<WindowStiffness>,
    /// Whether the stiffness varies on some window without a tabulated operator.
    pub varying: bool,
    /// Responses along the line of the force.
    pub impulse: Kernels,
    /// Lines with a requested response: other lines, and on joint stretches also the line of the force.
    pub other_lines: Vec<LineResponse>,
}

/// Response of the deflection along a line to a force along the same or another line.
#[derive(Debug)]
pub struct LineResponse {
    pub line: usize,
    /// Deflection per force without delay \[m/N\].
    pub at_once: f64,
    pub impulse: Kernels,
}

/// Tables of windows in contact of one length and one direction of the mesh force.
#[derive(Debug)]
pub struct ContactTables {
    /// Solution operators: one per distinct (k, c), or one per cell with a varying stiffness.
    pub feedback: Vec<Feedback>,
    /// Matrices for windows with a varying stiffness, if there are any.
    pub nodal: Option<Box<Nodal>>,
    /// Responses of the requested lines to the force.
    responses: Vec<Response>,
}

/// Response of the deflection along a line to a force: columns of B and B', series to series.
#[derive(Debug)]
pub struct Response {
    line: usize,
    /// Response of the deflection.
    pub deflection: [Row; TERMS],
    /// Bounds of its terms beyond the first lane group, one per column.
    pub tails: Row,
    /// Response of its rate.
    pub rate: [Row; TERMS],
}

impl ContactRequest {
    /// S̃ and Q̃ of every stiffness, and the responses of the requested lines.
    #[cold]
    pub fn tables(&self, set: InstructionSet) -> ContactTables {
        let convolution = convolution24();
        let response = convolution.operator(&self.impulse.deflection, self.delta);
        let response_rate = convolution.operator(&self.impulse.rate, self.delta);
        let varies = self.varying || self.closures.iter().any(WindowStiffness::varies);
        let nodal = varies.then(|| Nodal::new(&response, &response_rate, self.delta));
        let mut factors = Factors::NONE;
        let feedback = (self.closures.iter())
            .map(|closure| match &nodal {
                Some(nodal) if closure.varies() => closure.feedback(set, nodal, &mut factors),
                _ => {
                    let pair = (closure.stiffness.mean(), closure.damping);
                    Feedback::new(pair, &response, &response_rate, self.delta)
                }
            })
            .collect();
        ContactTables {
            feedback,
            nodal,
            responses: self
                .other_lines
                .iter()
                .map(|line| line.response(self.delta))
                .collect(),
        }
    }
}

impl LineResponse {
    fn response(&self, delta: f64) -> Response {
        let columns = |kernel| convolution24().operator(kernel, delta).map(Row);
        let mut deflection = columns(&self.impulse.deflection);
        for (n, column) in deflection.iter_mut().enumerate() {
            column.0[n] += self.at_once;
        }
        Response {
            line: self.line,
            tails: Row(deflection.each_ref().map(lanes::tail)),
            deflection,
            rate: columns(&self.impulse.rate),
        }
    }
}

impl ContactTables {
    /// Response of the deflection along a line to the force; `None` if it was not requested.
    pub fn response_on(&self, line: usize) -> Option<&Response> {
        self.responses.iter().find(|response| response.line == line)
    }
}
