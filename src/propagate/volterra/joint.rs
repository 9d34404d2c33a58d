//! Windows with several contacts closed.
//!
//! With `B_ij` what the force of contact j does to the deflection of contact i and d the free
//! deflections,
//!
//! ```text
//! f_i + Σ_j (k_i B_ij + c_i B'_ij) f_j = k_i (d_i − s_i b_i) + c_i 𝒟 (d_i − s_i b_i)
//! ```
//!
//! in series, P unknowns a contact. A stiffness that varies multiplies values at the Gauss nodes:
//! between series it is a matrix. The system is solved where it is met, once for all columns: few
//! windows have more than one contact closed.

use super::lanes::{self, InstructionSet, Solution};
use super::shapes::{Row, Series, TERMS};
use super::tables::{JointStretch, VolterraTables};
use crate::model::{ActiveSet, Model, STIFFNESS_TERMS, Segment};
use crate::numerics::legendre::{self, evaluate, transforms24};

/// What a window with several closed contacts is solved with; what one window made room for, later
/// ones use.
#[derive(Debug, Default)]
pub struct Joint {
    /// The system, row by row, with its right sides behind.
    system: Vec<f64>,
    /// Free deflections of all columns, contact after contact.
    free: Vec<Row>,
    /// Forces of all columns, contact after contact.
    pub forces: Vec<Row>,
}

/// The window to be solved.
pub struct JointWindow<'a> {
    pub model: &'a Model,
    pub tables: &'a VolterraTables,
    pub set: InstructionSet,
    pub stretch: &'a JointStretch,
    pub segments: &'a [Segment],
    pub active: ActiveSet,
    /// Start \[s\] within the mesh cycle.
    pub time: f64,
    /// Length \[s\].
    pub delta: f64,
}

impl JointWindow<'_> {
    /// Forces of all columns, and the trajectory's motion along every line.
    pub fn solve(
        &self,
        inputs: &[f64],
        columns: &[f64],
        count: usize,
        joint: &mut Joint,
        solutions: &mut [Solution],
    ) {
        let windows = &self.tables.windows;
        let order = TERMS * self.active.count();
        let width = order + count;
        joint.free.resize(self.active.count() * count, Row::ZERO);
        joint.forces.resize(self.active.count() * count, Row::ZERO);
        joint.system.clear();
        joint.system.resize(order * width, 0.0);
        for (i, contact) in self.active.iter().enumerate() {
            let rows = &windows[self.stretch.windows[contact]].rows;
            let free = &mut joint.free[i * count..][..count];
            lanes::free(self.set, rows, inputs, columns, free);
            let spring = self.spring(contact);
            let damping = self.segments[contact].damping;
            for (j, other) in self.active.iter().enumerate() {
                let line = self.model.line(&self.segments[contact]);
                let Some(felt) = windows[self.stretch.windows[other]].felt_on(line) else {
                    continue;
                };
                for m in 0..TERMS {
                    let sprung = spring.of(&felt.deflection[m].0);
                    for n in 0..TERMS {
                        let own = f64::from(u8::from(i == j && m == n));
                        joint.system[(i * TERMS + n) * width + j * TERMS + m] =
                            own + sprung[n] + damping * felt.rate[m].0[n];
                    }
                }
            }
            for (column, free) in free.iter().enumerate() {
                let mut stretch = free.0;
                if column == 0 {
                    let side = self.model.contacts[contact].side;
                    for (term, gap) in stretch.iter_mut().zip(self.gap(contact)) {
                        *term -= side * gap;
                    }
                }
                let sprung = spring.of(&stretch);
                let rate = legendre::derivative(&stretch);
                for n in 0..TERMS {
                    joint.system[(i * TERMS + n) * width + order + column] =
                        sprung[n] + damping * (2.0 / self.delta) * rate[n];
                }
            }
        }
        eliminate(&mut joint.system, order, width);
        for i in 0..self.active.count() {
            for column in 0..count {
                for n in 0..TERMS {
                    joint.forces[i * count + column].0[n] =
                        joint.system[(i * TERMS + n) * width + order + column];
                }
            }
        }
        for (sight, solution) in self.stretch.sights.iter().zip(solutions) {
            let mut deflection = [Row::ZERO];
            lanes::free(
                self.set,
                &windows[sight.window].rows,
                inputs,
                columns,
                &mut deflection,
            );
            let size = lanes::size(&deflection[0].0);
            for (i, contact) in self.active.iter().enumerate() {
                let table = &windows[self.stretch.windows[contact]];
                if let Some(felt) = table.felt_on(sight.line) {
                    let force = &joint.forces[i * count];
                    lanes::yielded(self.set, &felt.deflection, force, &mut deflection[0]);
                }
            }
            *solution = Solution::of(&deflection[0], size);
        }
    }

    /// The stiffness of a contact over the window.
    fn spring(&self, contact: usize) -> Spring {
        let segment = &self.segments[contact];
        match segment.stiffness.is_constant() {
            true => Spring::Constant(segment.stiffness.mean()),
            false => {
                let period = self.model.period();
                let start = segment.place(self.time / period);
                let end = segment.place((self.time + self.delta) / period);
                let place = |x: f64| 0.5 * ((end - start) * x + (start + end));
                let at = |x: &f64| evaluate(segment.stiffness.coefficients(), place(*x));
                Spring::AtNodes(std::array::from_fn(|j| at(&transforms24().nodes()[j])))
            }
        }
    }

    /// Series of a contact's gap over the window \[m\].
    fn gap(&self, contact: usize) -> [f64; STIFFNESS_TERMS] {
        let mut gap = [0.0; STIFFNESS_TERMS];
        if self.tables.lacks[contact] {
            let segment = &self.segments[contact];
            gap = super::tables::lack(self.model, segment, self.time, self.delta);
        }
        gap[0] += self.model.contacts[contact].half_gap;
        gap
    }
}

/// A stiffness \[N/m\] over a window.
enum Spring {
    Constant(f64),
    AtNodes(Series),
}

impl Spring {
    /// The force of a stretch, series to series.
    fn of(&self, stretch: &Series) -> Series {
        match self {
            Self::Constant(k) => stretch.map(|a| k * a),
            Self::AtNodes(k) => {
                let nodes = transforms24().nodes();
                let values = std::array::from_fn(|j| k[j] * evaluate(stretch, nodes[j]));
                transforms24().interpolate(&values)
            }
        }
    }
}

/// Solves a linear system by Gaussian elimination with exchange of rows. `system` is row by row, its
/// right sides behind its `order` columns, and is left with the solutions there.
fn eliminate(system: &mut [f64], order: usize, width: usize) {
    for step in 0..order {
        let size = |row: &usize| system[row * width + step].abs();
        let pivot = (step..order)
            .max_by(|a, b| size(a).total_cmp(&size(b)))
            .unwrap_or(step);
        if pivot != step {
            let (above, below) = system.split_at_mut(pivot * width);
            above[step * width..][..width].swap_with_slice(&mut below[..width]);
        }
        let (above, below) = system.split_at_mut((step + 1) * width);
        let top = &above[step * width..];
        for row in below.chunks_exact_mut(width) {
            let factor = row[step] / top[step];
            if factor != 0.0 {
                for (entry, above) in row[step..].iter_mut().zip(&top[step..]) {
                    *entry -= factor * above;
                }
            }
        }
    }
    for step in (0..order).rev() {
        let (above, below) = system.split_at_mut(step * width);
        let own = &mut below[..width];
        let pivot = own[step];
        for value in &mut own[order..] {
            *value /= pivot;
        }
        for row in above.chunks_exact_mut(width) {
            let factor = row[step];
            for (entry, solved) in row[order..].iter_mut().zip(&own[order..]) {
                *entry -= factor * solved;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elimination_exchanges_rows_and_solves_all_columns() {
        // x = (1, 2, 3) and (−1, 0, 2), the first pivot being zero.
        let matrix = [[0.0, 2.0, 1.0], [3.0, -1.0, 2.0], [1.0, 4.0, -2.0]];
        let solutions = [[1.0, 2.0, 3.0], [-1.0, 0.0, 2.0]];
        let mut system = Vec::new();
        for row in matrix {
            system.extend(row);
            let product = |x: [f64; 3]| row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
            system.extend(solutions.map(product));
        }
        eliminate(&mut system, 3, 5);
        for (i, row) in system.chunks_exact(5).enumerate() {
            for (found, exact) in row[3..].iter().zip(solutions) {
                assert!((found - exact[i]).abs() < 1e-15, "{found} {exact:?}");
            }
        }
    }
}
