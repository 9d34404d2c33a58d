//! Certified runs of cells, and whole cycles of constant contact, in one product.
//!
//! Rows give δ at the ends of the cells of a run from the state at its start, and a bound of
//! δ'' over it. Where the smallest of these margins exceeds what a curve can sag between two
//! cell ends, no event is met and one product crosses the run. A whole cycle in contact is
//! certified by its distance from a reference cycle, the steady one, whose smallest margin is
//! known: one sum of sizes. Everything else is left to the spectral form.

use super::DenseError;
use super::course::Course;
use super::exits::{Margin, Sight};
use super::exponential::{self, bound_row};
use super::kept::{KeptTables, Reader, TableArray, Writer};
use super::kernel::Dense;
use super::march::{Exit, Method, Piece};
use super::matrix::{Operator, dot, numbers_of, padded, reach};
use super::spectral::{Conditioning, Scratch as SpectralScratch, Tables as SpectralTables};
use super::steady::{CycleMap, Steady};
use crate::model::Model;
use crate::propagate::Counters;
use faer::Mat;

/// Longest run, in cells.
const LONGEST: usize = 8;

/// The kernel of fused runs for one model.
pub type Fused<'m> = Dense<'m, Tables<'m>>;

/// Its tables.
#[derive(Debug)]
pub struct Tables<'t> {
    spectral: SpectralTables<'t>,
    runs: Vec<Run<'t>>,
    /// Runs that start at a cell, longest first: indices into `runs`.
    starts: Vec<Vec<usize>>,
    steady: Steady<'t>,
}

/// Cells crossed at once in contact.
#[derive(Debug)]
struct Run<'t> {
    /// Classes of its cells.
    classes: Vec<usize>,
    map: Operator<'t>,
    /// δ at the ends of its cells.
    ends: Operator<'t>,
    /// Bound of δ'' over the run, as a row over sizes, times Δ²/8.
    sag: Vec<f64>,
}

/// Scratch memory.
#[derive(Debug)]
pub struct Scratch {
    spectral: SpectralScratch,
    ends: Vec<f64>,
    next: Vec<f64>,
    /// The operator of the run just passed; none where it was a whole cycle.
    run: Option<usize>,
}

impl<'t> Run<'t> {
    /// The run of cells whose propagators less the identity these are, by class.
    fn new(course: &Course<'_>, cells: &[Mat<f64>], classes: &[usize]) -> Self {
        let (layout, grid) = (&course.layout, &course.grid);
        let d = layout.dimension();
        let mut map = Mat::<f64>::zeros(d, d);
        let mut ends = Mat::<f64>::zeros(classes.len(), d);
        let mut sag = vec![0.0f64; layout.padded()];
        for (i, &class) in classes.iter().enumerate() {
            let generator = &course.contact[class];
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
                ends[(i, j)] = generator.deflection[j] + moved.sum::<f64>();
            }
        }
        Self {
            classes: classes.to_vec(),
            map: Operator::new(exponential::plus_one(map).as_ref()),
            ends: Operator::new(ends.as_ref()),
            sag,
        }
    }

    fn keep(&self, out: &mut Writer) {
        out.push("run_map", "mixed", self.map.numbers());
        out.push("run_ends", "mixed", self.ends.numbers());
        out.push("run_sag", "mixed", &self.sag);
    }

    fn read(
        kept: &mut Reader<'t>,
        course: &Course<'_>,
        classes: Vec<usize>,
    ) -> Result<Self, DenseError> {
        let d = course.layout.dimension();
        let mut operator = |name, rows| {
            let numbers = kept.take(name, numbers_of(rows, d))?;
            Operator::lent(numbers, rows, d).ok_or(DenseError::Kept { name })
        };
        Ok(Self {
            map: operator("run_map", d)?,
            ends: operator("run_ends", classes.len())?,
            sag: kept.take("run_sag", course.layout.padded())?.to_vec(),
            classes,
        })
    }
}

impl<'m> Fused<'m> {
    /// Builds the kernel's tables for a model; arguments as for
    /// [`Spectral::new`](super::Spectral::new).
    ///
    /// # Errors
    /// As for [`Spectral::new`](super::Spectral::new).
    pub fn new(model: &'m Model, cells: u32, event_limit: u32) -> Result<Self, DenseError> {
        let course = Course::new(model, cells, Tables::REACH, event_limit, None)?;
        let tables = Tables::new(&course)?;
        Ok(Self { course, tables })
    }

    /// The kernel of a model whose tables, for as many `cells`, are kept. Load and half gap may be
    /// others than those of the model they were built for.
    ///
    /// # Errors
    /// As for [`Spectral::of_kept`](super::Spectral::of_kept).
    pub fn of_kept(
        model: &'m Model,
        cells: u32,
        event_limit: u32,
        kept: &'m dyn KeptTables,
    ) -> Result<Self, DenseError> {
        let course = Course::new(model, cells, Tables::REACH, event_limit, None)?;
        let mut reader = Reader::new(kept);
        let tables = Tables::read(&course, &mut reader)?;
        reader.finish()?;
        Ok(Self { course, tables })
    }

    /// The tables as arrays to be kept.
    pub fn arrays(&self) -> Vec<TableArray> {
        let mut out = Writer::default();
        self.tables.spectral.keep(&mut out);
        for run in &self.tables.runs {
            run.keep(&mut out);
        }
        self.tables.steady.cycle().keep(&mut out);
        out.finish()
    }

    /// How well every basis behaves, contact first.
    pub fn conditioning(&self) -> Vec<Conditioning> {
        self.tables.spectral.conditioning().collect()
    }
}

/// Runs that may start at each cell, longest first, as indices into the list of their cells'
/// classes.
fn runs(course: &Course<'_>) -> (Vec<Vec<usize>>, Vec<Vec<usize>>) {
    let grid = &course.grid;
    let direction = |cell: usize| {
        let segment = grid.cells[cell].segment;
        course.model.cycle.segments[segment].direction
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

impl<'t> Tables<'t> {
    fn new(course: &Course<'_>) -> Result<Self, DenseError> {
        let grid = &course.grid;
        let increments: Vec<Mat<f64>> = (course.contact.iter().zip(&grid.classes))
            .map(|(g, class)| exponential::increment(g, grid.rate, class.duration))
            .collect();
        let (lists, starts) = runs(course);
        let runs = (lists.iter())
            .map(|classes| Run::new(course, &increments, classes))
            .collect();
        let cycle = CycleMap::new(course, &increments);
        let spectral = SpectralTables::new(course)?;
        Ok(Self::assembled(course, spectral, runs, starts, cycle))
    }

    fn read(course: &Course<'_>, kept: &mut Reader<'t>) -> Result<Self, DenseError> {
        let spectral = SpectralTables::read(course, kept)?;
        let (lists, starts) = runs(course);
        let runs = (lists.into_iter())
            .map(|classes| Run::read(kept, course, classes))
            .collect::<Result<_, _>>()?;
        let cycle = CycleMap::read(course, kept)?;
        Ok(Self::assembled(course, spectral, runs, starts, cycle))
    }

    fn assembled(
        course: &Course<'_>,
        spectral: SpectralTables<'t>,
        runs: Vec<Run<'t>>,
        starts: Vec<Vec<usize>>,
        cycle: CycleMap<'t>,
    ) -> Self {
        let alone = |class: usize| runs.iter().find(|run| run.classes == [class]);
        let cells: Vec<&Operator<'_>> = (0..course.grid.classes.len())
            .filter_map(|class| Some(&alone(class)?.map))
            .collect();
        let steady = Steady::new(course, cycle, &cells);
        Self {
            spectral,
            runs,
            starts,
            steady,
        }
    }
}

impl Method for Tables<'_> {
    type Scratch = Scratch;
    const REACH: f64 = SpectralTables::REACH;
    const FLIES: bool = SpectralTables::FLIES;

    fn operators(&self) -> impl Iterator<Item = &Operator<'_>> {
        let runs = self.runs.iter().flat_map(|run| [&run.map, &run.ends]);
        let spectral = self.spectral.operators();
        spectral.chain(runs).chain([&self.steady.cycle().map])
    }

    fn scratch(&self, course: &Course<'_>) -> Scratch {
        Scratch {
            spectral: self.spectral.scratch(course),
            ends: vec![0.0; padded(LONGEST)],
            next: vec![0.0; course.layout.padded()],
            run: None,
        }
    }

    fn pass(
        &self,
        course: &Course<'_>,
        piece: &Piece,
        z: &mut [f64],
        scratch: &mut Scratch,
        counters: &mut Counters,
    ) -> Option<Exit> {
        self.spectral
            .pass(course, piece, z, &mut scratch.spectral, counters)
    }

    fn follow(
        &self,
        course: &Course<'_>,
        piece: &Piece,
        time: f64,
        x: &mut [f64],
        scratch: &mut Scratch,
        counters: &mut Counters,
    ) {
        self.spectral
            .follow(course, piece, time, x, &mut scratch.spectral, counters);
    }

    fn run(
        &self,
        course: &Course<'_>,
        piece: &Piece,
        z: &mut [f64],
        scratch: &mut Scratch,
        counters: &mut Counters,
    ) -> Option<usize> {
        if !piece.contact.touching() || piece.crossed.is_some() {
            return None;
        }
        let margin = Margin::of(piece.contact, course.model.half_gap).next()?;
        let inside = |deflection: f64| {
            margin
                .see(&Sight {
                    time: 0.0,
                    deflection: [deflection, 0.0, 0.0],
                })
                .value
        };
        if piece.cell == 0 && self.steady.holds(piece, z) {
            counters.certified += 1;
            self.steady.cycle().map.apply(z, &mut scratch.next);
            counters.matvecs += 1;
            z.copy_from_slice(&scratch.next);
            scratch.run = None;
            return Some(course.grid.cells.len());
        }
        let generator = course.generator(piece.cell, piece.contact);
        let start = inside(dot(&generator.deflection, z));
        for &index in &self.starts[piece.cell] {
            let run = &self.runs[index];
            let sag = reach(&run.sag, z) + piece.noise;
            if start <= sag {
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

    fn follow_run(&self, x: &mut [f64], scratch: &mut Scratch, counters: &mut Counters) {
        let map = match scratch.run {
            Some(index) => &self.runs[index].map,
            None => &self.steady.cycle().map,
        };
        map.apply(x, &mut scratch.next);
        x.copy_from_slice(&scratch.next);
        counters.matvecs += 1;
    }
}
