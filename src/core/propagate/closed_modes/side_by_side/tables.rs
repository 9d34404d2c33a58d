//! What does a lane need to know about a point? The motion of each system over a step, its generator, and the
//! margins of the contacts that may open or close.
//!
//! The state of a lane is the modal state and the inputs, `z = (x, 1, cos θ, sin θ, …)`, with `z' = A z`. Changes of the
//! system change A, not z.

use super::super::ClosedModes;
use super::super::excitation::{Frequencies, error_amplitudes};
use super::super::sets::{ContactClass, CycleBreakpoint, Sets};
use crate::model::{ActiveSet, Model, OUT_OF_REACH, Release};
use crate::propagate::events::{Margin, ROUND_OFF};
use crate::propagate::farthest;
use num_complex::Complex64;

/// Largest number of modes. With more modes, one point alone fills the lanes well enough.
pub const MOST_MODES: usize = 3;

/// Largest number of frequencies of the excitation.
pub const MOST_FREQUENCIES: usize = 3;

/// Largest number of contacts of a model.
pub const MOST_CONTACTS: usize = 4;

/// Largest number of contacts that may open or close in a system.
pub const MOST_WATCHED: usize = 4;

/// Largest length of z.
pub const MOST_LENGTH: usize = 2 * MOST_MODES + 1 + 2 * MOST_FREQUENCIES;

/// Largest angle \[rad\] by which the fastest wave turns in a step.
const ANGLE: f64 = 0.9;

/// Terms of the exponential of a step, and of bounds over a step.
const TERMS: usize = 24;

/// `|f − H| ≤ |f''''| h⁴ / 384` for the cubic H with the values and rates of f at both ends of an interval h.
const CUBIC: f64 = 384.0;

/// The sizes of a point's tables. Lanes that work together have the same shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Number of modes.
    pub modes: usize,
    /// Number of frequencies of the excitation, absent ones included: one, or [`MOST_FREQUENCIES`].
    pub frequencies: usize,
    /// Number of contacts that may open or close in a system.
    pub watched: usize,
}

impl Shape {
    /// Length of a modal state.
    pub fn state(&self) -> usize {
        2 * self.modes
    }

    /// Length of z.
    pub fn length(&self) -> usize {
        self.state() + 1 + 2 * self.frequencies
    }

    /// Position of the generator in [`LaneSystem::columns`]; the step comes first.
    pub fn generator(&self) -> usize {
        self.state() * self.length()
    }

    /// Position of the rows of a watched contact: its margin, the rate, and the bound of the margin's error.
    pub fn rows(&self, watched: usize) -> usize {
        2 * self.generator() + 3 * watched * self.length()
    }

    /// Numbers of a system.
    pub fn numbers(&self) -> usize {
        self.rows(self.watched)
    }
}

/// A contact that may open or close.
#[derive(Debug, Clone, Copy)]
pub struct Watched {
    /// The contact.
    pub contact: usize,
    /// Factor of δ in its margin, ±1.
    pub scale: f64,
}

/// The tables of a system.
#[derive(Debug)]
pub struct LaneSystem {
    /// All numbers that a lane needs while it has this system; see [`Shape`].
    pub columns: Vec<f64>,
    /// The contacts that may open or close.
    pub watched: Vec<Watched>,
}

/// Deflection row w and force input g of a direction.
#[derive(Debug)]
pub struct LaneDirection {
    /// w.
    pub row: Vec<f64>,
    /// g.
    pub pull: Vec<f64>,
}

/// The tables of a point.
#[derive(Debug)]
pub struct PointTables {
    /// Their sizes.
    pub shape: Shape,
    /// The numbered systems.
    pub sets: Sets,
    /// The tables of each system.
    pub systems: Vec<LaneSystem>,
    /// The directions of the model.
    pub directions: Vec<LaneDirection>,
    /// The frequencies of the excitation.
    pub frequencies: Frequencies,
    /// Each frequency \[rad/s\], and the cosine and sine of its turn over a step.
    pub turns: Vec<[f64; 3]>,
    /// The breakpoints of each mesh cycle of a base period.
    pub breakpoints: Vec<Vec<CycleBreakpoint>>,
    /// State that each contact has if it is closed, at the start of each of these cycles.
    pub starts: Vec<Vec<usize>>,
    /// Step \[s\].
    pub step: f64,
    /// Mesh period \[s\].
    pub period: f64,
    /// The row of each deflection over the modal state, and the deflection beyond which a motion has diverged \[m\].
    pub ranges: Vec<(Vec<f64>, f64)>,
    /// Largest number of events in a cycle.
    pub event_limit: u32,
}

impl PointTables {
    /// The tables of a kernel's point. `None` if its model has too many modes, contacts, frequencies or sets for
    /// lanes, or if a contact changes its line.
    pub fn new(kernel: &ClosedModes<'_>) -> Option<Self> {
        let model = kernel.model;
        let lines_of = |starts: &[(usize, usize)]| -> Vec<usize> {
            starts.iter().map(|&(_, line)| line).collect()
        };
        let lines = lines_of(&kernel.starts[0]);
        let turns = (kernel.breakpoints.iter().flatten()).any(|breakpoint| breakpoint.turns)
            || kernel.starts.iter().any(|starts| lines_of(starts) != lines);
        let frequencies = Frequencies::new(model);
        let fits = model.modes() <= MOST_MODES
            && model.contacts.len() <= MOST_CONTACTS
            && frequencies.all.len() <= MOST_FREQUENCIES
            && kernel.sets.are_few()
            && (model.contacts.iter()).all(|contact| contact.release == Release::Deflection);
        if !fits || turns {
            return None;
        }
        let active = |set: usize| {
            (kernel.sets.closed(set)).fold(ActiveSet::FREE, |active, (contact, _)| {
                active.toggled(contact)
            })
        };
        let margins: Vec<Vec<Margin>> = (0..kernel.sets.count())
            .map(|set| watched(model, &lines, active(set)))
            .collect();
        let most = margins.iter().map(Vec::len).max().unwrap_or(0);
        if most > MOST_WATCHED {
            return None;
        }
        let shape = Shape {
            modes: model.modes(),
            frequencies: if frequencies.all.len() > 1 { MOST_FREQUENCIES } else { 1 },
            watched: most.max(1),
        };
        let rate = kernel.fastest();
        let step = model.period() / (model.period() * rate / ANGLE).ceil().max(1.0);
        let equations = Equations::new(model, &frequencies, shape);
        let systems = (margins.iter().enumerate())
            .map(|(set, margins)| {
                let closed: Vec<_> = kernel.sets.closed(set).collect();
                equations.system(&closed, margins, &lines, step)
            })
            .collect();
        let n = shape.modes;
        let flat = |of: fn(&crate::model::MeshGain) -> [f64; 2],
                    gains: &[crate::model::MeshGain]| {
            let mut out = vec![0.0; 2 * n];
            for (i, gain) in gains.iter().enumerate() {
                [out[i], out[n + i]] = of(gain);
            }
            out
        };
        let directions = (model.directions.iter())
            .map(|direction| LaneDirection {
                row: flat(|gain| gain.deflection, &direction.gains),
                pull: flat(|gain| gain.mesh_input, &direction.gains),
            })
            .collect();
        Some(Self {
            shape,
            systems,
            directions,
            turns: (0..shape.frequencies)
                .map(|h| frequencies.all.get(h).map_or(0.0, |[omega, _]| *omega))
                .map(|omega| [omega, (omega * step).cos(), (omega * step).sin()])
                .collect(),
            step,
            period: model.period(),
            ranges: (equations.deflections.iter().zip(farthest(model)))
                .map(|(row, farthest)| (row[..shape.state()].to_vec(), farthest))
                .collect(),
            event_limit: kernel.event_limit,
            sets: kernel.sets.clone(),
            breakpoints: kernel.breakpoints.clone(),
            starts: (kernel.starts.iter())
                .map(|contacts| contacts.iter().map(|&(state, _)| state).collect())
                .collect(),
            frequencies,
        })
    }
}

impl PointTables {
    /// Largest number of tangents in a lane.
    pub fn most_tangents(&self) -> usize {
        self.shape.state()
    }

    /// The breakpoints of a cycle.
    pub fn breakpoints_of(&self, cycle: u64) -> &[CycleBreakpoint] {
        &self.breakpoints[(cycle % self.breakpoints.len() as u64) as usize]
    }
}

/// The margins of the contacts that may open or close. An open contact is out of reach while a contact on the other
/// side of its line is closed. A contact with a gap beyond any motion ([`OUT_OF_REACH`]) never closes.
fn watched(model: &Model, lines: &[usize], active: ActiveSet) -> Vec<Margin> {
    let contacts = &model.contacts;
    let reachable = |contact: usize| {
        let opposite = |other: usize| {
            lines[other] == lines[contact] && contacts[other].side == -contacts[contact].side
        };
        let is_near = contacts[contact].half_gap < OUT_OF_REACH * model.half_gap;
        is_near && (active.holds(contact) || !active.iter().any(opposite))
    };
    (0..contacts.len())
        .filter(|&contact| reachable(contact))
        .map(|contact| Margin::new(&contacts[contact], contact, active.holds(contact)))
        .collect()
}

/// A row over z.
type Row = [f64; MOST_LENGTH];

/// A matrix over z, row by row.
type Matrix = [Row; MOST_LENGTH];

/// The equations of motion of a point.
struct Equations<'m> {
    model: &'m Model,
    shape: Shape,
    /// A of free flight.
    free: Matrix,
    /// The deflection along each line.
    deflections: Vec<Row>,
}

impl<'m> Equations<'m> {
    fn new(model: &'m Model, frequencies: &Frequencies, shape: Shape) -> Self {
        let n = shape.modes;
        let mut free = [[0.0; MOST_LENGTH]; MOST_LENGTH];
        for (i, block) in model.blocks.iter().enumerate() {
            for (part, row) in block.generator.iter().enumerate() {
                let to = &mut free[part * n + i];
                [to[i], to[n + i]] = *row;
                to[2 * n] = block.static_input[part];
            }
        }
        let input = |h: usize| 2 * n + 1 + 2 * h;
        for (h, &[omega, _]) in frequencies.all.iter().enumerate() {
            let [cos, sin] = [input(h), input(h) + 1];
            free[cos][sin] = -omega;
            free[sin][cos] = omega;
        }
        for ripple in &model.ripple {
            let frequency = [ripple.angular_frequency, ripple.turns_per_cycle];
            let h = (frequencies.all.iter()).position(|known| *known == frequency);
            let [cos, sin] = h.map_or([0; 2], |h| [input(h), input(h) + 1]);
            let (sine, cosine) = ripple.phase.sin_cos();
            for (i, of_block) in ripple.input.iter().enumerate() {
                for (part, amplitude) in of_block.iter().enumerate() {
                    let to = &mut free[part * n + i];
                    to[cos] += amplitude * cosine;
                    to[sin] -= amplitude * sine;
                }
            }
        }
        let deflections = (0..model.lines.len()).map(|line| {
            let mut row = [0.0; MOST_LENGTH];
            let along = (model.directions.iter()).find(|direction| direction.line == line);
            for (i, gain) in (along.iter()).flat_map(|along| along.gains.iter().enumerate()) {
                [row[i], row[n + i]] = gain.deflection;
            }
            let errors = error_amplitudes(model, line, frequencies);
            for (h, Complex64 { re, im }) in errors.into_iter().enumerate() {
                [row[input(h)], row[input(h) + 1]] = [-re, im];
            }
            row
        });
        Self {
            deflections: deflections.collect(),
            model,
            shape,
            free,
        }
    }

    /// `row A`.
    fn after(&self, row: &Row, a: &Matrix) -> Row {
        let mut out = [0.0; MOST_LENGTH];
        for (weight, of_row) in row[..self.shape.length()].iter().zip(a) {
            for (sum, entry) in out.iter_mut().zip(of_row) {
                *sum += weight * entry;
            }
        }
        out
    }

    /// A with some closed contacts: each adds `−g (k (δ − s b) + c δ')`.
    fn matrix(&self, closed: &[(usize, ContactClass)]) -> Matrix {
        let n = self.shape.modes;
        let mut a = self.free;
        for (contact, class) in closed {
            let direction = &self.model.directions[class.direction];
            let contact = &self.model.contacts[*contact];
            let deflection = &self.deflections[direction.line];
            let rate = self.after(deflection, &self.free);
            let mut force: Row =
                std::array::from_fn(|j| class.stiffness * deflection[j] + class.damping * rate[j]);
            force[2 * n] -= class.stiffness * contact.side * contact.half_gap;
            for (i, gain) in direction.gains.iter().enumerate() {
                for (part, g) in gain.mesh_input.into_iter().enumerate() {
                    for (sum, f) in a[part * n + i].iter_mut().zip(&force) {
                        *sum -= g * f;
                    }
                }
            }
        }
        a
    }

    fn system(
        &self,
        closed: &[(usize, ContactClass)],
        margins: &[Margin],
        lines: &[usize],
        step: f64,
    ) -> LaneSystem {
        let (state, length) = (self.shape.state(), self.shape.length());
        let a = self.matrix(closed);
        let mut columns = Vec::with_capacity(self.shape.numbers());
        let mut put = |row: &Row| columns.extend_from_slice(&row[..length]);
        for i in 0..state {
            let mut unit = [0.0; MOST_LENGTH];
            unit[i] = 1.0;
            put(&self.exponential_row(unit, &a, step));
        }
        a[..state].iter().for_each(&mut put);
        for margin in margins {
            let mut row = self.deflections[lines[margin.contact]].map(|x| margin.scale * x);
            row[state] += margin.shift;
            put(&row);
            put(&self.after(&row, &a));
            put(&self.error_bound(&row, &a, step));
        }
        // Unused places have the constant margin 1, which stays positive.
        let (mut one, zero) = ([0.0; MOST_LENGTH], [0.0; MOST_LENGTH]);
        one[state] = 1.0;
        for _ in margins.len()..self.shape.watched {
            [one, zero, zero].iter().for_each(&mut put);
        }
        LaneSystem {
            columns,
            watched: (margins.iter())
                .map(|margin| Watched {
                    contact: margin.contact,
                    scale: margin.scale,
                })
                .collect(),
        }
    }

    /// `row e^{A h}`.
    fn exponential_row(&self, row: Row, a: &Matrix, step: f64) -> Row {
        let (mut term, mut sum) = (row, row);
        for k in 1..TERMS {
            term = self.after(&term, a).map(|x| x * step / k as f64);
            for (sum, x) in sum.iter_mut().zip(&term) {
                *sum += x;
            }
        }
        sum
    }

    /// Weights of the sizes of z in a bound of the error of the margin's cubic on a step, with the round-off of the
    /// margin: `h⁴ / 384 Σ |row A^{4+k}| h^k / k!`.
    fn error_bound(&self, row: &Row, a: &Matrix, step: f64) -> Row {
        let mut bound = row.map(|x| ROUND_OFF * x.abs());
        let mut term = *row;
        for _ in 0..4 {
            term = self.after(&term, a);
        }
        let mut factor = step.powi(4) / CUBIC;
        for k in 0..TERMS {
            for (bound, x) in bound.iter_mut().zip(&term) {
                *bound += factor * x.abs();
            }
            term = self.after(&term, a);
            factor *= step / (k + 1) as f64;
        }
        bound
    }
}
