//! The tables that a kernel computes once for an operating point.

use super::block_exponential::BlockExponential;
use super::grid::{Grid, distinct};
use super::joint_stretch::{JointStretch, can_join, joint_stretches, missing_lengths};
use super::shapes::{BlockChunk, GapError, LANES, Lanes, TableLayout};
use super::table_requests::{LineView, TableRequests, place};
use super::window_stiffness::WindowStiffness;
use super::window_table::WindowTable;
use crate::model::{Block, DRIFT, MeshGain, Model, SAME_PHASE, Segment, turned};
use crate::numerics::legendre::transforms8;

/// Tables of the structured kernel.
#[derive(Debug)]
pub struct VolterraTables {
    /// Sizes.
    pub layout: TableLayout,
    /// Angular frequencies of all transmission errors \[rad/s\], with their turns per mesh cycle.
    pub frequencies: Vec<[f64; 2]>,
    /// Whether all transmission errors repeat after a base period; orders of a shaft may not.
    pub errors_recur: bool,
    /// Schedules of the mesh cycles of all contacts.
    schedules: Vec<Schedule>,
    /// The schedules of every contact in the mesh cycles of a base period. Equal contacts share them.
    schedules_of_contact: Vec<Vec<usize>>,
    /// Stretches of every mesh cycle of a base period on which no contact changes its segment. Empty if no two
    /// contacts can be closed together.
    pub joint: Vec<Vec<JointStretch>>,
    /// One table per length of window and direction of a contact force.
    pub windows: Vec<WindowTable>,
    /// Constants of every chunk of blocks, one list per direction.
    pub blocks: Vec<Vec<BlockChunk>>,
    /// Input −g of every chunk of blocks, one list per direction.
    pub pulls: Vec<Vec<[Lanes; 2]>>,
    /// Input of every chunk of blocks, one list per torque ripple.
    pub ripple: Vec<Vec<[Lanes; 2]>>,
    /// Whether a contact has gap errors.
    pub gap_errors: Vec<bool>,
    /// Upper bound of the number of windows in a mesh cycle without events.
    most_windows: usize,
}

/// The windows of a mesh cycle of a contact.
#[derive(Debug)]
pub struct Schedule {
    /// Starts of windows.
    pub grid: Grid,
    /// The lines of all contacts on every stretch. The line of the contact comes first; its window table is that of
    /// the stretch.
    pub views_of_stretch: Vec<Vec<LineView>>,
    /// Solution operator of every cell, among those of its window table.
    pub feedback_of_cell: Vec<usize>,
    /// (cos, sin) of the transmission errors' frequencies at the start of every cell, for the first base period.
    pub cell_phases: Vec<f64>,
    /// Gap error of every contact on every cell, unless the contact changes its segment there. Empty if no contact has
    /// gap errors.
    gap_errors: Vec<Option<GapError>>,
}

/// Gap error of loaded flanks over a window of length `delta` \[s\] that starts at `time` \[s\] in a
/// segment.
pub fn gap_error(model: &Model, segment: &Segment, time: f64, delta: f64) -> GapError {
    let place = |time: f64| segment.place(time / model.period());
    let series = segment.error.coefficients();
    transforms8().restrict(series, place(time), place(time + delta))
}

/// Gap errors of all contacts on a cell of length `delta` \[s\] with the given ends \[s\]; `None` for a contact that changes
/// its segment inside.
fn cell_gap_errors(
    model: &Model,
    cycle: u64,
    [start, end]: [f64; 2],
    delta: f64,
) -> impl Iterator<Item = Option<GapError>> {
    let phases = [start, end].map(|time| time / model.period());
    let segments = model.segments_at(cycle, 0.5 * (start + end));
    segments.into_iter().map(move |segment| {
        let whole =
            segment.start - SAME_PHASE <= phases[0] && phases[1] <= segment.end + SAME_PHASE;
        whole.then(|| gap_error(model, &segment, start, delta))
    })
}

impl VolterraTables {
    /// Tables for a model; see [`super::Volterra::new`] for `tolerance`.
    pub fn new(model: &Model, tolerance: f64) -> Self {
        let mut frequencies = Vec::new();
        for h in model.transmission_errors() {
            place(&mut frequencies, [h.angular_frequency, h.turns_per_cycle]);
        }
        let layout = TableLayout::new(model, frequencies.len());
        let base = model.base_cycles() as u64;
        let mut grids: Vec<(usize, u64, Grid)> = Vec::new();
        let mut schedules_of_contact: Vec<Vec<usize>> = Vec::new();
        for (index, contact) in model.contacts.iter().enumerate() {
            let alike = model.contacts[..index]
                .iter()
                .position(|c| c.cycles == contact.cycles);
            if let Some(alike) = alike {
                schedules_of_contact.push(schedules_of_contact[alike].clone());
                continue;
            }
            let first = grids.len();
            grids.extend(
                (0..base).map(|cycle| (index, cycle, Grid::new(model, tolerance, index, cycle))),
            );
            schedules_of_contact.push((first..grids.len()).collect());
        }
        let (mut lengths, which) = distinct(grids.iter().flat_map(|g| g.2.lengths.iter().copied()));
        let mut which = which.into_iter();
        let mut requests = TableRequests::default();
        let schedules: Vec<Schedule> = (grids.into_iter())
            .map(|(contact, cycle, grid)| {
                let lengths_of_stretch = which.by_ref().take(grid.lengths.len());
                let which: Vec<usize> = lengths_of_stretch.collect();
                let contact_cycle = (contact, cycle, grid);
                Schedule::new(
                    model,
                    contact_cycle,
                    &lengths,
                    &which,
                    &frequencies,
                    &mut requests,
                )
            })
            .collect();
        let mut joint = Vec::new();
        if can_join(model) {
            lengths.extend(missing_lengths(model, base, &lengths, tolerance));
            let of_cycle =
                |cycle| joint_stretches(model, cycle, &lengths, tolerance, &mut requests);
            joint.extend((0..base).map(of_cycle));
        }
        let exponentials: Vec<Vec<_>> = (lengths.iter())
            .map(|&delta| BlockExponential::all(&model.blocks, delta))
            .collect();
        let mut windows: Vec<WindowTable> = Vec::with_capacity(requests.kinds.len());
        let closures = requests.closures.into_iter().zip(requests.varying);
        let kinds = requests.kinds.iter().zip(closures);
        for ((&(length, direction), closures), lines) in kinds.zip(&requests.response_lines) {
            let table = WindowTable::new(
                (model, layout),
                (lengths[length], direction),
                &exponentials[length],
                closures,
                (lines, &frequencies),
                &windows,
            );
            windows.push(table);
        }
        let blocks: Vec<Vec<BlockChunk>> = (model.directions.iter())
            .map(|direction| block_chunks(model, &direction.gains))
            .collect();
        let most_windows = most_windows(&schedules, &joint, &windows);
        Self {
            layout,
            schedules,
            schedules_of_contact,
            joint,
            windows,
            most_windows,
            pulls: (blocks.iter())
                .map(|blocks| blocks.iter().map(|chunk| chunk.mesh_pull).collect())
                .collect(),
            blocks,
            ripple: (model.ripple.iter())
                .map(|ripple| in_chunks(&ripple.input))
                .collect(),
            gap_errors: (model.contacts.iter())
                .map(|contact| contact.cycles.iter().any(|cycle| cycle.has_error()))
                .collect(),
            errors_recur: (frequencies.iter())
                .all(|[_, turns]| (turns * base as f64).fract() == 0.0),
            frequencies,
        }
    }

    /// Index of the schedule of a contact in a mesh cycle.
    pub fn course_of(&self, contact: usize, cycle: u64) -> usize {
        let schedules = &self.schedules_of_contact[contact];
        match schedules.len() {
            1 => schedules[0],
            count => schedules[(cycle % count as u64) as usize],
        }
    }

    /// Upper bound of the number of windows in a mesh cycle without events, for any closed contacts.
    pub fn most_windows(&self) -> usize {
        self.most_windows
    }

    /// The schedule with an index.
    pub fn schedule(&self, number: usize) -> &Schedule {
        &self.schedules[number]
    }

    /// The first schedule of the first contact.
    pub fn first_schedule(&self) -> &Schedule {
        &self.schedules[0]
    }
}

/// Upper bound of the number of windows in a mesh cycle without events: the cells of all schedules, and the windows of
/// the joint stretches of one cycle.
fn most_windows(
    schedules: &[Schedule],
    joint: &[Vec<JointStretch>],
    windows: &[WindowTable],
) -> usize {
    let cells = schedules
        .iter()
        .map(|schedule| schedule.grid.cells())
        .sum::<usize>();
    let of_cycle = |stretches: &Vec<JointStretch>| -> usize {
        let starts = std::iter::once(0.0).chain(stretches.iter().map(|stretch| stretch.end));
        (starts.zip(stretches))
            .map(|(start, stretch)| {
                let delta = windows[stretch.windows[0]].delta;
                ((stretch.end - start) / delta).ceil() as usize
            })
            .sum()
    };
    cells + joint.iter().map(of_cycle).max().unwrap_or(0)
}

impl Schedule {
    /// A contact's schedule of a mesh cycle. `which` are the indices into `lengths` for the stretches of its grid.
    fn new(
        model: &Model,
        (contact, cycle, grid): (usize, u64, Grid),
        lengths: &[f64],
        which: &[usize],
        frequencies: &[[f64; 2]],
        requests: &mut TableRequests,
    ) -> Self {
        let mut views_of_stretch = Vec::new();
        let mut feedback_of_cell = Vec::new();
        let mut gap_errors = Vec::new();
        let with_errors = (model.contacts.iter()).any(|contact| contact.cycle(cycle).has_error());
        let mut first = 0;
        for (stretch, &length) in which.iter().enumerate() {
            let own_segment = grid.segment_of_stretch[stretch];
            let own_segment = &model.contacts[contact].cycle(cycle).segments[own_segment];
            let cells = first..grid.stretch_end_cell[stretch];
            let inside = 0.5 * (grid.time[first] + grid.time[first + 1]);
            let mut directions: Vec<usize> = (model.segments_at(cycle, inside).iter())
                .map(|segment| segment.direction)
                .collect();
            directions[contact] = own_segment.direction;
            let views = requests.views(model, length, &directions, contact);
            let window = views[0].window;
            for view in &views[1..] {
                requests.request_response(window, view.line);
            }
            for cell in cells {
                let closure =
                    WindowStiffness::new(model, own_segment, grid.time[cell], lengths[length]);
                feedback_of_cell.push(place(&mut requests.closures[window], closure));
                if with_errors {
                    let ends = [grid.time[cell], grid.time[cell + 1]];
                    gap_errors.extend(cell_gap_errors(model, cycle, ends, lengths[length]));
                }
            }
            first = grid.stretch_end_cell[stretch];
            views_of_stretch.push(views);
        }
        let mut cell_phases = Vec::new();
        for &time in &grid.time {
            for &frequency in frequencies {
                cell_phases.extend(phases(frequency, cycle, time));
            }
        }
        Self {
            grid,
            views_of_stretch,
            feedback_of_cell,
            cell_phases,
            gap_errors,
        }
    }

    /// Gap error of one of `contacts` contacts on a cell.
    #[inline]
    pub fn gap_error(&self, cell: usize, contact: usize, contacts: usize) -> Option<GapError> {
        *self.gap_errors.get(cell * contacts + contact)?
    }

    /// The stretch of a cell or of a time \[s\].
    #[inline]
    pub fn stretch(&self, aligned: Option<usize>, time: f64) -> usize {
        match aligned {
            Some(cell) => self.grid.stretch_of_cell[cell],
            None => {
                let ends = &self.grid.stretch_end_cell;
                let stretch = ends.partition_point(|end| self.grid.time[*end] <= time);
                stretch.min(ends.len() - 1)
            }
        }
    }
}

/// (cos, sin) of a frequency \[rad/s\], with its turns per mesh cycle, at a time \[s\] within a cycle.
pub fn phases([angular, turns]: [f64; 2], cycle: u64, time: f64) -> [f64; 2] {
    let (sin, cos) = turned(angular, turns, cycle, time).sin_cos();
    [cos, sin]
}

/// Pairs of numbers, one per block, by chunks.
fn in_chunks(pairs: &[[f64; 2]]) -> Vec<[Lanes; 2]> {
    let chunk = |group: &[[f64; 2]]| {
        let mut lanes = [Lanes::ZERO; 2];
        for (l, pair) in group.iter().enumerate() {
            for j in 0..2 {
                lanes[j].0[l] = pair[j];
            }
        }
        lanes
    };
    pairs.chunks(LANES).map(chunk).collect()
}

/// `−A⁻¹ s`: with `A = μ I + M` and `M² = −ν² I`, `A⁻¹ = (μ I − M) / (μ² + ν²)`.
fn rest(block: &Block) -> [f64; 2] {
    let (mu, m, s) = (block.growth(), block.traceless(), block.static_input);
    let square = block.natural_frequency().powi(2);
    [0, 1].map(|i| (m[i][0] * s[0] + m[i][1] * s[1] - mu * s[i]) / square)
}

fn block_chunks(model: &Model, gains: &[MeshGain]) -> Vec<BlockChunk> {
    let slowest = DRIFT / model.period();
    (model.blocks.chunks(LANES).zip(gains.chunks(LANES)))
        .map(|(group, gains)| {
            let mut chunk = BlockChunk {
                traceless: [Lanes::ZERO; 4],
                deflection: [Lanes::ZERO; 2],
                mesh_pull: [Lanes::ZERO; 2],
                static_input: [Lanes::ZERO; 2],
                rest: [Lanes::ZERO; 2],
                drifts: group.iter().any(|b| b.natural_frequency() < slowest),
            };
            for (l, (block, gain)) in group.iter().zip(gains).enumerate() {
                for (k, value) in block.traceless().as_flattened().iter().enumerate() {
                    chunk.traceless[k].0[l] = *value;
                }
                for j in 0..2 {
                    chunk.deflection[j].0[l] = gain.deflection[j];
                    chunk.mesh_pull[j].0[l] = -gain.mesh_input[j];
                    if chunk.drifts {
                        chunk.static_input[j].0[l] = block.static_input[j]
                    } else {
                        chunk.rest[j].0[l] = rest(block)[j]
                    }
                }
            }
            chunk
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Division, fixtures};

    /// The end of a cycle, also with a rounding error, belongs to its last stretch.
    #[test]
    fn every_time_of_a_cycle_has_a_stretch() {
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &[1.0, 0.5], &[1.0, 0.5]);
        let mut drive = fixtures::two_level_mesh(1e-5);
        drive.mesh = Division::levels(&[4e8, 3e8, 2e8], &[0.25, 0.6]);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        let tables = VolterraTables::new(&model, f64::EPSILON);
        let schedule = tables.first_schedule();
        for (phase, stretch) in [
            (0.0, 0),
            (0.2, 0),
            (0.3, 1),
            (0.59, 1),
            (0.7, 2),
            (1.0, 2),
            (1.0 + f64::EPSILON, 2),
        ] {
            assert_eq!(
                schedule.stretch(None, phase * model.period()),
                stretch,
                "{phase}"
            );
        }
    }

    #[test]
    fn at_rest_nothing_moves() {
        let block = Block {
            static_input: [0.3, -2.0],
            ..Block::mode(7.0, 0.2, 0.0)
        };
        let (r, m) = (rest(&block), block.traceless());
        for i in 0..2 {
            let rate = block.growth() * r[i] + m[i][0] * r[0] + m[i][1] * r[1];
            assert!((rate + block.static_input[i]).abs() < 1e-15);
        }
    }
}
