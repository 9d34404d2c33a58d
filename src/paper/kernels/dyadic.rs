//! Dyadic descent: only propagators for Δ/2ᵐ.
//!
//! A cell without a certificate is halved, left half first, with one product per guard evaluation, down to Δ/2²⁰. On
//! this last interval δ is a polynomial. The rest of a cell after an event is crossed in steps from the binary digits
//! of its length.

use super::cell_model::CellModel;
use super::cycle::Method;
use super::exits::{Bounds, DeflectionAt, Verdict};
use super::exponential;
use super::generator::{Generator, Layout};
use super::grid::Grid;
use super::kernel::{ClassTables, Dense};
use super::matrix::{Operator, dot, numbers_of};
use super::series::{BoundRows, Series, judge_all, locate};
use super::show::Taylor;
use super::state_part::{Exit, StatePart};
use super::{DenseError, TableSize};
use crate::model::Model;
use crate::propagate::Counters;

/// Largest number of halvings of a cell.
pub const LEVELS: usize = 20;

/// Terms of the polynomial on the last interval: (2·2⁻²⁰)⁵/5! is below 10⁻³⁰.
const LAST_TERMS: usize = 4;

/// The kernel of dyadic descent for one model.
pub type Dyadic<'m> = Dense<'m, DyadicTables>;

/// Tables of this kernel.
#[derive(Debug)]
pub struct DyadicTables(ClassTables<DyadicTable>);

/// Propagators of one class in one state.
#[derive(Debug)]
pub struct DyadicTable {
    /// `e^{LΔ/2ᵐ}`, m = 0 … 20.
    levels: Vec<Operator>,
    bounds: BoundRows,
    curvature: Vec<f64>,
    duration: f64,
}

/// Scratch memory.
#[derive(Debug)]
pub struct DyadicScratch {
    next: Vec<f64>,
    taylor: Taylor,
}

impl DyadicTable {
    fn new(generator: &Generator, rate: f64, duration: f64) -> Self {
        let levels = exponential::levels(generator, rate, duration, LEVELS);
        Self {
            levels: levels
                .into_iter()
                .map(|p| Operator::new(exponential::plus_one(p).as_ref()))
                .collect(),
            bounds: BoundRows::new(generator, rate, duration),
            curvature: generator.curvature(),
            duration,
        }
    }

    /// Length of a step of level m \[s\].
    fn step(&self, level: usize) -> f64 {
        self.duration / (1u64 << level) as f64
    }
}

impl<'m> Dyadic<'m> {
    /// Builds the kernel's tables for a model.
    ///
    /// * `cells`: smallest number of unit steps per mesh cycle; there are more if a cell would be too long.
    /// * `event_limit`: largest number of events in a mesh cycle; integration stops at more.
    ///
    /// # Errors
    /// [`DenseError`] if tables cannot represent the model, or the speed is too slow for them.
    pub fn new(model: &'m Model, cells: u32, event_limit: u32) -> Result<Self, DenseError> {
        let cell_model = CellModel::new(model, cells, DyadicTables::REACH, event_limit, None)?;
        let tables = ClassTables::new(&cell_model, |generator, class, _| {
            let duration = cell_model.grid.classes[class].duration;
            Ok(DyadicTable::new(generator, cell_model.grid.rate, duration))
        })?;
        let tables = DyadicTables(tables);
        Ok(Self { cell_model, tables })
    }

    /// Size of the tables of a model.
    ///
    /// # Errors
    /// As for [`Dyadic::new`].
    pub fn size(model: &Model, cells: u32) -> Result<TableSize, DenseError> {
        let (grid, layout) = (
            Grid::new(model, cells, DyadicTables::REACH)?,
            Layout::new(model),
        );
        let systems = grid.classes.len() + grid.flights.len();
        Ok(TableSize {
            operators: systems * (LEVELS + 1),
            bytes: bytes(&layout, systems),
            cells: grid.cells.len(),
        })
    }
}

/// Bytes of the tables for `systems` linear systems, one per length of cells and generator.
pub fn bytes(layout: &Layout, systems: usize) -> usize {
    let d = layout.dimension();
    systems * (LEVELS + 1) * numbers_of(d, d) * size_of::<f64>()
}

impl DyadicScratch {
    fn new(cell_model: &CellModel<'_>) -> Self {
        let padded = cell_model.layout.padded();
        Self {
            next: vec![0.0; padded],
            taylor: Taylor::new(padded),
        }
    }
}

/// A pending step of the descent.
#[derive(Debug, Clone, Copy)]
struct PendingStep {
    level: usize,
    /// Whether exactly one root lies in this step or in the step before it.
    holds_root: bool,
}

impl Method for DyadicTables {
    type Scratch = DyadicScratch;
    const REACH: f64 = 2.0;
    const FLIES: bool = false;

    fn operators(&self) -> impl Iterator<Item = &Operator> {
        self.0.all().flat_map(|table| &table.levels)
    }

    fn scratch(&self, cell_model: &CellModel<'_>) -> DyadicScratch {
        DyadicScratch::new(cell_model)
    }

    fn pass(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        z: &mut [f64],
        scratch: &mut DyadicScratch,
        counters: &mut Counters,
    ) -> Option<Exit> {
        let (table, _) = self.0.of(cell_model, stretch);
        let generator = cell_model.generator(stretch.cell, stretch.contact);
        let contacts = &cell_model.model.contacts;
        let see = |z: &[f64], time: f64| DeflectionAt {
            time,
            deflection: [
                dot(&generator.deflection, z),
                dot(&generator.rate, z),
                dot(&table.curvature, z),
            ],
        };
        let mut time = 0.0;
        let mut left = see(z, time);
        let mut pending = [PendingStep {
            level: 0,
            holds_root: false,
        }; LEVELS + 2];
        let mut depth = 0;
        loop {
            let rest = stretch.duration - time;
            // Take a pending step, else the longest step that fits.
            let (level, certain) = match depth {
                0 if stretch.whole && time == 0.0 => (0, false),
                0 if stretch.whole => return None,
                0 => match (0..=LEVELS).find(|&level| table.step(level) <= rest) {
                    Some(level) => (level, false),
                    None => break,
                },
                _ => {
                    depth -= 1;
                    let step = pending[depth];
                    (step.level, step.holds_root)
                }
            };
            let step = table.step(level);
            let bounds = table.bounds.at(z, stretch.noise);
            let starts = time == 0.0;
            if level == LEVELS {
                let found = self.finish(
                    cell_model, stretch, time, step, &bounds, z, scratch, counters,
                );
                if found.is_some() {
                    return found;
                }
                time += step;
                left = see(z, time);
                continue;
            }
            let verdict = if certain {
                Verdict::Single
            } else {
                table.levels[level].apply(z, &mut scratch.next);
                counters.matvecs += 1;
                counters.guard_evaluations += 1;
                let right = see(&scratch.next, time + step);
                let verdict = judge_all(stretch, contacts, [&left, &right], &bounds, starts);
                if verdict == Verdict::Clear {
                    z.copy_from_slice(&scratch.next);
                    time += step;
                    left = right;
                    counters.certified += u64::from(level == 0);
                    continue;
                }
                verdict
            };
            counters.bisections += 1;
            pending[depth] = PendingStep {
                level: level + 1,
                holds_root: verdict == Verdict::Single,
            };
            pending[depth + 1] = PendingStep {
                level: level + 1,
                holds_root: false,
            };
            depth += 2;
        }
        let rest = stretch.duration - time;
        if rest <= 0.0 {
            return None;
        }
        let bounds = table.bounds.at(z, stretch.noise);
        self.finish(
            cell_model, stretch, time, rest, &bounds, z, scratch, counters,
        )
    }

    fn follow(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        time: f64,
        x: &mut [f64],
        scratch: &mut DyadicScratch,
        counters: &mut Counters,
    ) {
        let (table, _) = self.0.of(cell_model, stretch);
        let mut rest = time;
        if stretch.whole && time == stretch.duration {
            rest = table.duration;
        }
        for (level, operator) in table.levels.iter().enumerate() {
            if table.step(level) <= rest {
                operator.apply(x, &mut scratch.next);
                x.copy_from_slice(&scratch.next);
                counters.matvecs += 1;
                rest -= table.step(level);
            }
        }
        let generator = cell_model.generator(stretch.cell, stretch.contact);
        scratch.taylor.step(generator, rest, LAST_TERMS, x);
    }
}

impl DyadicTables {
    /// Passes an interval no longer than the shortest step of the tables, with a polynomial. Returns its first event.
    #[expect(
        clippy::too_many_arguments,
        reason = "the state of the published algorithms"
    )]
    fn finish(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        time: f64,
        step: f64,
        bounds: &Bounds,
        z: &mut [f64],
        scratch: &mut DyadicScratch,
        counters: &mut Counters,
    ) -> Option<Exit> {
        let generator = cell_model.generator(stretch.cell, stretch.contact);
        let series = Series::new(generator, z, LAST_TERMS, &mut scratch.taylor);
        let mut evaluations = 1;
        let mut guard = |t: f64| {
            evaluations += 1;
            series.at(t)
        };
        let here = |time: f64| DeflectionAt {
            time,
            deflection: series.at(time),
        };
        let ends = [&here(0.0), &here(step)];
        let starts = time == 0.0;
        let found = locate(
            stretch,
            &cell_model.model.contacts,
            ends,
            bounds,
            starts,
            &mut guard,
            counters,
        );
        counters.guard_evaluations += evaluations;
        let passed = found.map_or(step, |exit| exit.time);
        scratch.taylor.step(generator, passed, LAST_TERMS, z);
        found.map(|exit| Exit {
            time: time + exit.time,
            ..exit
        })
    }
}
