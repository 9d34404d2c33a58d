//! How is a window with several closed contacts solved?
//!
//! Let `B_ij` map the force of contact j to the deflection of contact i. With the free deflections d and the
//! operators S̃ of single contacts ([`super::feedback`]),
//!
//! ```text
//! f_i = S̃_i (d_i − Σ_{j≠i} B_ij f_j − s_i b_i)
//! ```
//!
//! in series, with P unknowns per contact. The contacts are solved in turn, each under the latest forces of the
//! others (block Gauss–Seidel). A force acts only on later times, so the error after n rounds falls like
//! `(ω Δ)^{4n} / (4n)!` with the rate ω of a closed contact, faster in each round. The rounds end when another change
//! as large as the last one would be within round-off. After too many rounds, the system of all contacts,
//!
//! ```text
//! f_i + Σ_j (k_i B_ij + c_i B'_ij) f_j = k_i (d_i − s_i b_i) + c_i 𝒟 (d_i − s_i b_i)
//! ```
//!
//! is eliminated instead. The force of a dry slider that slips is its limit and known from the start. A varying
//! stiffness multiplies values at the Gauss nodes, which is a matrix between series.

use super::contact_tables::{ContactTables, Response};
use super::feedback::ContactSolve;
use super::joint_stretch::JointStretch;
use super::lanes::{self, Solution};
use super::shapes::{GapError, Row, Series, TERMS};
use super::tables::{VolterraTables, gap_error};
use super::varying::Factors;
use super::window_stiffness::WindowStiffness;
use super::window_table::WindowTable;
use crate::model::{ActiveSet, MOST_CONTACTS, Model, Segment};
use crate::numerics::legendre::{self, evaluate, transforms24};
use crate::propagate::events::ROUND_OFF;
use crate::propagate::vectors::InstructionSet;

/// Largest number of rounds before elimination.
const MOST_ROUNDS: usize = 40;

/// Memory for windows with several closed contacts, reused from window to window.
#[derive(Debug, Default)]
pub struct JointWorkspace {
    /// The system, row by row, with its right-hand sides at the end.
    system: Vec<f64>,
    /// Free deflections of all columns, contact after contact. The gap error is subtracted from that of the trajectory.
    free: Vec<Row>,
    /// As `free`, but under the forces of the other contacts.
    seen: Vec<Row>,
    /// As `seen`, for one contact in the current round.
    next: Vec<Row>,
    /// Factors of every contact with a varying stiffness.
    factors: Vec<Factors>,
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
    /// Solves the window. Writes the contact forces of all columns (the trajectory, then its tangents) to
    /// `joint.forces`. Writes the trajectory's deflection along every line of the stretch to `solutions`.
    pub fn solve(
        &self,
        inputs: &[f64],
        columns: &[f64],
        count: usize,
        joint: &mut JointWorkspace,
        solutions: &mut [Solution],
    ) {
        let size = self.active.count() * count;
        for rows in [&mut joint.free, &mut joint.seen, &mut joint.forces] {
            rows.resize(size, Row::ZERO);
        }
        joint.next.resize(count, Row::ZERO);
        for (contact, free) in self.active.iter().zip(joint.free.chunks_exact_mut(count)) {
            lanes::free(self.set, &self.table(contact).rows, inputs, columns, free);
            self.add_gap_error(contact, -1.0, &mut free[0]);
        }
        self.set_slips(count, &mut joint.forces);
        if !self.gauss_seidel(count, joint) {
            self.eliminate(count, joint);
        }
        for (view, solution) in self.stretch.views.iter().zip(solutions) {
            let mut deflection = [Row::ZERO];
            let mut closed = self.active.iter().enumerate();
            match closed.find(|(_, contact)| view.contacts.contains(contact)) {
                Some((i, contact)) => {
                    deflection[0] = joint.free[i * count];
                    self.add_gap_error(contact, 1.0, &mut deflection[0]);
                }
                None => {
                    let rows = &self.tables.windows[view.window].rows;
                    lanes::free(self.set, rows, inputs, columns, &mut deflection);
                }
            }
            let size = lanes::size(&deflection[0].0);
            for (i, contact) in self.active.iter().enumerate() {
                if let Some(response) = self.contact(contact).response_on(view.line) {
                    let force = &joint.forces[i * count..][..1];
                    lanes::yielded(self.set, &response.deflection, force, &mut deflection);
                }
            }
            *solution = Solution::of(&deflection[0], size);
        }
    }

    /// Writes the forces of slipping sliders and of slipping dry friction. They are constant, so those of
    /// tangents are zero.
    fn set_slips(&self, count: usize, forces: &mut [Row]) {
        for (contact, forces) in self.active.iter().zip(forces.chunks_exact_mut(count)) {
            if let Some(limit) = self.limit(contact) {
                forces.fill(Row::ZERO);
                forces[0].0[0] = limit;
            }
        }
    }

    /// Force of a slipping slider or of slipping dry friction \[N\]; `None` for other contacts.
    fn limit(&self, contact: usize) -> Option<f64> {
        self.model.contacts[contact].constant_force(&self.segments[contact])
    }

    /// Solves the contacts in turn. Returns whether the rounds converge.
    fn gauss_seidel(&self, count: usize, joint: &mut JointWorkspace) -> bool {
        let rests = self
            .active
            .iter()
            .filter(|contact| self.model.is_constraint(*contact));
        if rests.count() > 1 {
            // Each of their forces acts on the others without delay.
            return false;
        }
        self.factorise(&mut joint.factors);
        let mut before = [1.0; MOST_CONTACTS];
        for round in 0..MOST_ROUNDS {
            let mut settled = round > 0;
            for (i, contact) in self.active.iter().enumerate() {
                if self.model.is_slip(contact) {
                    continue;
                }
                let range = i * count..(i + 1) * count;
                let next = &mut joint.next[..count];
                next.copy_from_slice(&joint.free[range.clone()]);
                for (j, other) in self.active.iter().enumerate() {
                    // In the first round, later contacts have no force yet, except slips.
                    let known = j < i || (j > i && (round > 0 || self.model.is_slip(other)));
                    if let Some(response) = self.response_of(other, contact).filter(|_| known) {
                        let forces = &joint.forces[j * count..][..count];
                        lanes::yielded(self.set, &response.deflection, forces, next);
                    }
                }
                let closed = self.closed(i, contact, &joint.factors);
                let gap = self.model.contacts[contact].side * self.model.contacts[contact].half_gap;
                let (free, seen) = (&joint.free[range.clone()], &mut joint.seen[range.clone()]);
                let forces = &mut joint.forces[range];
                let moved = lanes::close(self.set, closed, gap, free, next, seen, forces);
                settled &= moved * moved <= ROUND_OFF * before[i];
                before[i] = if round > 0 { moved } else { 1.0 };
            }
            if settled {
                return true;
            }
        }
        false
    }

    /// Factorises the systems of contacts with a varying stiffness.
    fn factorise(&self, factors: &mut Vec<Factors>) {
        let varies = |contact: usize| self.stretch.feedback[contact].is_none();
        if !self.active.iter().any(varies) {
            return;
        }
        factors.resize(self.active.count(), Factors::NONE);
        for (contact, factors) in self.active.iter().zip(factors) {
            if let (true, Some(nodal)) = (varies(contact), &self.contact(contact).nodal) {
                let segment = &self.segments[contact];
                let closure = WindowStiffness::new(self.model, segment, self.time, self.delta);
                closure.factorise(self.set, nodal, factors);
            }
        }
    }

    /// The solution operator of the contact, the i-th closed one.
    fn closed<'f>(&'f self, i: usize, contact: usize, factors: &'f [Factors]) -> ContactSolve<'f> {
        let tables = self.contact(contact);
        match (self.stretch.feedback[contact], &tables.nodal) {
            (None, Some(nodal)) => ContactSolve::Factors(nodal, &factors[i]),
            (kept, _) => ContactSolve::Table(&tables.feedback[kept.unwrap_or(0)]),
        }
    }

    /// Window table of a contact.
    fn table(&self, contact: usize) -> &WindowTable {
        &self.tables.windows[self.stretch.windows[contact]]
    }

    /// Tables of windows with a contact closed.
    fn contact(&self, contact: usize) -> &ContactTables {
        self.table(contact).contact(self.set)
    }

    /// The response of a contact's deflection to the force of contact `source`.
    fn response_of(&self, source: usize, contact: usize) -> Option<&Response> {
        let line = self.model.line(&self.segments[contact]);
        self.contact(source).response_on(line)
    }

    /// Solves the system of all contacts by elimination.
    fn eliminate(&self, count: usize, joint: &mut JointWorkspace) {
        let order = TERMS * self.active.count();
        let width = order + count;
        joint.system.clear();
        joint.system.resize(order * width, 0.0);
        for (i, contact) in self.active.iter().enumerate() {
            if let Some(limit) = self.limit(contact) {
                for n in 0..TERMS {
                    joint.system[(i * TERMS + n) * width + i * TERMS + n] = 1.0;
                }
                joint.system[i * TERMS * width + order] = limit;
                continue;
            }
            let spring = self.spring(contact);
            let damping = self.segments[contact].damping;
            for (j, other) in self.active.iter().enumerate() {
                let Some(response) = self.response_of(other, contact) else {
                    continue;
                };
                for m in 0..TERMS {
                    let sprung = spring.of(&response.deflection[m].0);
                    for n in 0..TERMS {
                        let identity = f64::from(u8::from(i == j && m == n));
                        joint.system[(i * TERMS + n) * width + j * TERMS + m] =
                            identity + sprung[n] + damping * response.rate[m].0[n];
                    }
                }
            }
            for (column, free) in joint.free[i * count..][..count].iter().enumerate() {
                let mut stretch = free.0;
                if column == 0 {
                    let contact = &self.model.contacts[contact];
                    stretch[0] -= contact.side * contact.half_gap;
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
    }

    /// The stiffness of a contact over the window.
    fn spring(&self, contact: usize) -> Spring {
        let segment = &self.segments[contact];
        if segment.stiffness.is_constant() {
            Spring::Constant(segment.stiffness.mean())
        } else {
            let period = self.model.period();
            let start = segment.place(self.time / period);
            let end = segment.place((self.time + self.delta) / period);
            let place = |x: f64| 0.5 * ((end - start) * x + (start + end));
            let at = |x: &f64| evaluate(segment.stiffness.coefficients(), place(*x));
            Spring::AtNodes(std::array::from_fn(|j| at(&transforms24().nodes()[j])))
        }
    }

    /// Adds a multiple of the gap error of a contact over the window \[m\], on its side.
    fn add_gap_error(&self, contact: usize, times: f64, deflection: &mut Row) {
        if self.tables.gap_errors[contact] {
            let segment = &self.segments[contact];
            let gap_error: GapError = gap_error(self.model, segment, self.time, self.delta);
            let factor = times * self.model.contacts[contact].side;
            for (term, a) in deflection.0.iter_mut().zip(gap_error) {
                *term += factor * a;
            }
        }
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

/// Solves a linear system by Gaussian elimination with row exchanges. `system` is row by row, with its right-hand
/// sides after its `order` columns. They are replaced by the solutions.
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
        let row_below = &mut below[..width];
        let pivot = row_below[step];
        for value in &mut row_below[order..] {
            *value /= pivot;
        }
        for row in above.chunks_exact_mut(width) {
            let factor = row[step];
            for (entry, solved) in row[order..].iter_mut().zip(&row_below[order..]) {
                *entry -= factor * solved;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::fixtures::{strong_rattle, structure, two_level_mesh};
    use crate::model::{CoastFlank, Division, Stiffness};
    use crate::numerics::random::Stream;
    use crate::structure::FlankParticipation;

    /// Two flanks; one elastic mode acts on them in opposite senses.
    fn model(mesh: Vec<Division>) -> Model {
        let own = [0.9, 0.4, 0.3];
        let mut structure = structure(&[0.0, 9e3, 3e4], 0.01, &own, &own);
        structure.coast = Some(FlankParticipation {
            mesh: vec![own[0], -own[1], own[2]],
            tilt: vec![0.0; 3],
            friction: vec![0.0; 3],
            lever: vec![0.0; 3],
            residual_flexibility: 0.0,
        });
        let mut drive = two_level_mesh(10e-6);
        drive.coast = Some(CoastFlank {
            mesh: Division::mirrored(&mesh, 0.17),
            transmission_error: drive.transmission_error.clone(),
            further: Vec::new(),
        });
        drive.mesh = mesh;
        Model::new(&structure, &drive, strong_rattle()).unwrap()
    }

    #[test]
    fn in_turn_or_at_once_forces_are_the_same() {
        let set = InstructionSet::best();
        let varying = Stiffness::series([4e8, 3e7, -1e7, 2e6, 0.0, 0.0, 0.0, 0.0]);
        let curved = Division {
            stiffness: varying,
            ..Division::level(1.0, 4e8)
        };
        let levels = Division::levels(&[4.444e8, 3.333e8], &[0.6]);
        for mesh in [levels, vec![curved]] {
            let model = model(mesh);
            let tables = VolterraTables::new(&model, f64::EPSILON);
            let mut random = Stream::new(3, 0, 0);
            let length = 2 * tables.layout.padded;
            let count = 3;
            let columns: Vec<f64> = (0..count * length)
                .map(|_| 1e-5 * random.normal())
                .collect();
            let mut inputs = vec![0.0; tables.layout.inputs];
            inputs[..3].copy_from_slice(&[1.0, 0.6, 0.8]);
            for (index, stretch) in tables.joint[0].iter().enumerate() {
                let segments: Vec<Segment> = (model.contacts.iter().zip(&stretch.segments))
                    .map(|(contact, &segment)| contact.cycles[0].segments[segment])
                    .collect();
                let window = JointWindow {
                    model: &model,
                    tables: &tables,
                    set,
                    stretch,
                    segments: &segments,
                    active: ActiveSet::DRIVE.toggled(crate::model::COAST_FLANK),
                    time: segments[0].start.max(segments[1].start) * model.period(),
                    delta: tables.windows[stretch.windows[0]].delta,
                };
                let mut solutions = vec![Solution::ZERO; 2];
                let mut joint = JointWorkspace::default();
                window.solve(&inputs, &columns, count, &mut joint, &mut solutions);
                assert!(window.gauss_seidel(count, &mut joint), "stretch {index}");
                let in_turn = joint.forces.clone();
                window.eliminate(count, &mut joint);
                for (one, other) in in_turn.iter().zip(&joint.forces) {
                    let difference: Series = std::array::from_fn(|n| one.0[n] - other.0[n]);
                    let share = lanes::size(&difference) / lanes::size(&other.0);
                    assert!(share < 1e-12, "stretch {index}: {share:e}");
                }
            }
        }
    }

    /// Polynomials are not extrapolated beyond a segment by more than its length.
    #[test]
    fn windows_are_no_longer_than_the_segments_that_bend() {
        let bent = Stiffness::series([4e8, 3e7, -1e7, 2e6, 1e3, 0.0, 0.0, 0.0]);
        let piece = |end| Division {
            stiffness: bent,
            ..Division::level(end, 4e8)
        };
        let model = model(vec![piece(0.7), piece(0.7001), piece(1.0)]);
        let tables = VolterraTables::new(&model, f64::EPSILON);
        let mut shortest = f64::INFINITY;
        for stretch in &tables.joint[0] {
            for (contact, window) in stretch.windows.iter().enumerate() {
                let segment = model.contacts[contact].cycles[0].segments[stretch.segments[contact]];
                let length = (segment.end - segment.start) * model.period();
                let delta = tables.windows[*window].delta;
                assert!(delta <= length * (1.0 + 1e-9), "{delta:e} {length:e}");
                shortest = shortest.min(delta);
            }
        }
        // Long segments keep longer windows.
        assert!(shortest < 2e-4 * model.period());
        let longest = tables.joint[0]
            .iter()
            .map(|own| tables.windows[own.windows[0]].delta);
        assert!(longest.fold(0.0, f64::max) > 1e-2 * model.period());
    }

    #[test]
    fn elimination_exchanges_rows_and_solves_all_columns() {
        // x = (1, 2, 3) and (−1, 0, 2), with a zero first pivot.
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
