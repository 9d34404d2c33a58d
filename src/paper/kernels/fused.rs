//! A kernel that advances several cells, or a whole cycle of constant contact, by one matrix product.
//!
//! A run is a group of neighbouring cells. The rows of a table give δ at the ends of its cells from the state at its
//! start, and a bound of δ''. The bound limits how far δ sags below the chord between two cell ends. If the margin at
//! every cell end exceeds this sag, the run has no event, and one product advances the state. A whole cycle has no
//! event if the smallest margin of the steady cycle exceeds a bound of the difference in δ, which is a weighted sum of
//! the absolute differences of the state from the steady one. The spectral kernel does everything else.

use super::DenseError;
use super::bases::Bases;
use super::cell_model::CellModel;
use super::conditioning::Conditioning;
use super::cycle::Method;
use super::exits::{DeflectionAt, MarginAt};
use super::exponential::{self, bound_row};
use super::kernel::Dense;
use super::matrix::{Operator, dot, padded, reach};
use super::spectral::{SpectralScratch, SpectralTables};
use super::state_part::{Exit, StatePart};
use super::steady::{CycleMap, Steady};
use crate::model::Model;
use crate::propagate::Counters;
use crate::propagate::events::Margin;
use faer::Mat;

/// Largest number of cells in a run.
const LONGEST: usize = 8;

/// The kernel of fused runs for one model.
pub type Fused<'m> = Dense<'m, FusedTables>;

/// Tables of this kernel.
#[derive(Debug)]
pub struct FusedTables {
    spectral: SpectralTables,
    runs: Vec<Run>,
    /// Runs that start at a cell, longest first: indices into `runs`.
    starts: Vec<Vec<usize>>,
    steady: Steady,
}

/// Products of the propagators of cells, for one speed.
struct Products {
    runs: Vec<Run>,
    cycle: CycleMap,
}

/// Cells crossed at once in contact.
#[derive(Debug)]
struct Run {
    /// Classes of its cells.
    classes: Vec<usize>,
    map: Operator,
    /// δ at the ends of its cells.
    ends: Operator,
    /// Row whose product with the absolute values of a state bounds |δ''| Δ²/8 over the run.
    sag: Vec<f64>,
}

/// Scratch memory.
#[derive(Debug)]
pub struct FusedScratch {
    spectral: SpectralScratch,
    ends: Vec<f64>,
    next: Vec<f64>,
    /// Index of the last run; `None` if the last run was a whole cycle.
    run: Option<usize>,
}

impl Run {
    /// The run of cells of the given classes; `cells` are propagators minus the identity, by class.
    fn new(cell_model: &CellModel<'_>, cells: &[Mat<f64>], classes: &[usize]) -> Self {
        let (layout, grid) = (&cell_model.layout, &cell_model.grid);
        let d = layout.dimension();
        let mut map = Mat::<f64>::zeros(d, d);
        let mut end_rows = Mat::<f64>::zeros(classes.len(), d);
        let mut sag = vec![0.0f64; layout.padded()];
        for (i, &class) in classes.iter().enumerate() {
            let generator = &cell_model.contact_generators[class];
            let duration = grid.classes[class].duration;
            let mut bound = vec![0.0; layout.padded()];
            let curvature = generator.curvature();
            bound_row(
                generator,
                grid.rate,
                duration,
                &curvature,
                Some(exponential::plus_one(map.clone()).as_ref()),
                &mut bound,
            );
            for (sag, bound) in sag.iter_mut().zip(&bound) {
                *sag = sag.max(0.125 * duration * duration * bound);
            }
            map = exponential::after(&cells[class], &map);
            for j in 0..d {
                let moved = (0..d).map(|k| generator.deflection[k] * map[(k, j)]);
                end_rows[(i, j)] = generator.deflection[j] + moved.sum::<f64>();
            }
        }
        Self {
            classes: classes.to_vec(),
            map: Operator::new(exponential::plus_one(map).as_ref()),
            ends: Operator::new(end_rows.as_ref()),
            sag,
        }
    }
}

impl<'m> Fused<'m> {
    /// Builds the kernel's tables for a model; arguments as for
    /// [`Spectral::new`](super::Spectral::new).
    ///
    /// # Errors
    /// As for [`Spectral::new`](super::Spectral::new).
    pub fn new(model: &'m Model, cells: u32, event_limit: u32) -> Result<Self, DenseError> {
        let cell_model = CellModel::new(model, cells, FusedTables::REACH, event_limit, None)?;
        let products = Products::new(&cell_model);
        let tables = FusedTables::new(&cell_model, Bases::new(model)?, products)?;
        Ok(Self { cell_model, tables })
    }

    /// Numerical quality of every basis, contact first.
    pub fn conditioning(&self) -> Vec<Conditioning> {
        self.tables.spectral.conditioning().collect()
    }
}

/// The distinct runs, each as the classes of its cells. For every cell the indices of the runs that can start there,
/// longest first.
fn runs(cell_model: &CellModel<'_>) -> (Vec<Vec<usize>>, Vec<Vec<usize>>) {
    let grid = &cell_model.grid;
    let direction = |cell: usize| {
        let segment = grid.cells[cell].segment;
        cell_model.model.first_cycle().segments[segment].direction
    };
    let mut runs: Vec<Vec<usize>> = Vec::new();
    let mut starts = vec![Vec::new(); grid.cells.len()];
    for (start, found) in starts.iter_mut().enumerate() {
        let mut length = LONGEST;
        while length > 0 {
            let end = start + length;
            let fits = start % length == 0 && end <= grid.cells.len();
            if fits && (start..end).all(|cell| direction(cell) == direction(start)) {
                let classes: Vec<usize> = grid.cells[start..end].iter().map(|c| c.class).collect();
                let known = runs.iter().position(|run| *run == classes);
                found.push(known.unwrap_or_else(|| {
                    runs.push(classes);
                    runs.len() - 1
                }));
            }
            length /= 2;
        }
    }
    (runs, starts)
}

impl Products {
    fn new(cell_model: &CellModel<'_>) -> Self {
        let grid = &cell_model.grid;
        let increments: Vec<Mat<f64>> = (cell_model.contact_generators.iter().zip(&grid.classes))
            .map(|(g, class)| exponential::increment(g, grid.rate, class.duration))
            .collect();
        let (lists, _) = runs(cell_model);
        let runs = lists.iter();
        Self {
            runs: runs
                .map(|classes| Run::new(cell_model, &increments, classes))
                .collect(),
            cycle: CycleMap::new(cell_model, &increments),
        }
    }
}

impl FusedTables {
    fn new(
        cell_model: &CellModel<'_>,
        bases: Bases,
        Products { runs: made, cycle }: Products,
    ) -> Result<Self, DenseError> {
        let (_, starts) = runs(cell_model);
        let alone = |class: usize| made.iter().find(|run| run.classes == [class]);
        let cells: Vec<&Operator> = (0..cell_model.grid.classes.len())
            .filter_map(|class| Some(&alone(class)?.map))
            .collect();
        let steady = Steady::new(cell_model, cycle, &cells);
        Ok(Self {
            spectral: SpectralTables::new(cell_model, bases)?,
            runs: made,
            starts,
            steady,
        })
    }
}

impl Method for FusedTables {
    type Scratch = FusedScratch;
    const REACH: f64 = SpectralTables::REACH;
    const FLIES: bool = SpectralTables::FLIES;

    fn operators(&self) -> impl Iterator<Item = &Operator> {
        let runs = self.runs.iter().flat_map(|run| [&run.map, &run.ends]);
        let spectral = self.spectral.operators();
        spectral.chain(runs).chain([&self.steady.cycle().map])
    }

    fn scratch(&self, cell_model: &CellModel<'_>) -> FusedScratch {
        FusedScratch {
            spectral: self.spectral.scratch(cell_model),
            ends: vec![0.0; padded(LONGEST)],
            next: vec![0.0; cell_model.layout.padded()],
            run: None,
        }
    }

    fn pass(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        z: &mut [f64],
        scratch: &mut FusedScratch,
        counters: &mut Counters,
    ) -> Option<Exit> {
        self.spectral
            .pass(cell_model, stretch, z, &mut scratch.spectral, counters)
    }

    fn follow(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        time: f64,
        x: &mut [f64],
        scratch: &mut FusedScratch,
        counters: &mut Counters,
    ) {
        self.spectral.follow(
            cell_model,
            stretch,
            time,
            x,
            &mut scratch.spectral,
            counters,
        );
    }

    fn run(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        z: &mut [f64],
        scratch: &mut FusedScratch,
        counters: &mut Counters,
    ) -> Option<usize> {
        if !stretch.contact.touching() || stretch.crossed.is_some() {
            return None;
        }
        let margin = Margin::of(&cell_model.model.contacts, stretch.contact).next()?;
        let inside = |deflection: f64| {
            let here = DeflectionAt {
                time: 0.0,
                deflection: [deflection, 0.0, 0.0],
            };
            MarginAt::of(&margin, &here).value
        };
        if stretch.cell == 0 && self.steady.holds(stretch, z) {
            counters.certified += 1;
            self.steady.cycle().map.apply(z, &mut scratch.next);
            counters.matvecs += 1;
            z.copy_from_slice(&scratch.next);
            scratch.run = None;
            return Some(cell_model.grid.cells.len());
        }
        let generator = cell_model.generator(stretch.cell, stretch.contact);
        let margin_at_start = inside(dot(&generator.deflection, z));
        for &index in &self.starts[stretch.cell] {
            let run = &self.runs[index];
            let sag = reach(&run.sag, z) + stretch.noise;
            if margin_at_start <= sag {
                continue;
            }
            let cells = run.classes.len();
            run.ends.apply(z, &mut scratch.ends);
            counters.guard_evaluations += cells as u64;
            if scratch.ends[..cells]
                .iter()
                .all(|&deflection| inside(deflection) > sag)
            {
                counters.certified += 1;
                run.map.apply(z, &mut scratch.next);
                counters.matvecs += 1;
                z.copy_from_slice(&scratch.next);
                scratch.run = Some(index);
                return Some(cells);
            }
        }
        None
    }

    fn follow_run(&self, x: &mut [f64], scratch: &mut FusedScratch, counters: &mut Counters) {
        let map = match scratch.run {
            Some(index) => &self.runs[index].map,
            None => &self.steady.cycle().map,
        };
        map.apply(x, &mut scratch.next);
        x.copy_from_slice(&scratch.next);
        counters.matvecs += 1;
    }
}
