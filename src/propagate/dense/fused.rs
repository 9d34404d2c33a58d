//! Certified runs of cells, and whole cycles of constant contact, in one product.
//!
//! Rows give δ at the ends of the cells of a run from the state at its start, and a bound of
//! δ'' over it. Where the smallest of these margins exceeds what a curve can sag between two
//! cell ends, no event is met and one product crosses the run. A whole cycle in contact is
//! certified by its distance from a reference cycle, the steady one, whose smallest margin is
//! known: one sum of sizes. Everything else is left to the spectral form.

use super::course::Course;
use super::exits::{Margin, Sight};
use super::exponential::{self, bound_row};
use super::march::{Exit, Method, Piece, Workspace};
use super::matrix::{Operator, dot, padded, reach};
use super::spectral::{Conditioning, Scratch as SpectralScratch, Tables as SpectralTables};
use super::steady::Steady;
use super::{DenseError, TableSize};
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Counters, Kernel, Observer, Stop, Tangents};
use faer::Mat;

/// Longest run, in cells.
const LONGEST: usize = 8;

/// The kernel of fused runs for one model.
#[derive(Debug)]
pub struct Fused<'m> {
    course: Course<'m>,
    tables: Tables,
}

#[derive(Debug)]
struct Tables {
    spectral: SpectralTables,
    runs: Vec<Run>,
    /// Runs that start at a cell, longest first: indices into `runs`.
    starts: Vec<Vec<usize>>,
    steady: Option<Steady>,
}

/// Cells crossed at once in contact.
#[derive(Debug)]
struct Run {
    /// Classes of its cells.
    classes: Vec<usize>,
    map: Operator,
    /// δ at the ends of its cells.
    ends: Operator,
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

impl Run {
    fn new(course: &Course<'_>, cells: &[Mat<f64>], classes: &[usize]) -> Self {
        let (layout, grid) = (&course.layout, &course.grid);
        let d = layout.dimension();
        let mut map = Mat::<f64>::identity(d, d);
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
                Some(map.as_ref()),
                &mut bound,
            );
            for (sag, bound) in sag.iter_mut().zip(&bound) {
                *sag = sag.max(0.125 * duration * duration * bound);
            }
            map = &cells[class] * &map;
            for j in 0..d {
                ends[(i, j)] = (0..d).map(|k| generator.deflection[k] * map[(k, j)]).sum();
            }
        }
        Self {
            classes: classes.to_vec(),
            map: Operator::new(map.as_ref()),
            ends: Operator::new(ends.as_ref()),
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
        let course = Course::new(model, cells, Tables::REACH, event_limit, None)?;
        let tables = Tables::new(&course)?;
        Ok(Self { course, tables })
    }

    /// How well every basis behaves, contact first.
    pub fn conditioning(&self) -> Vec<Conditioning> {
        self.tables.spectral.conditioning().collect()
    }

    /// Size of the tables.
    pub fn bytes(&self) -> TableSize {
        let runs = self
            .tables
            .runs
            .iter()
            .flat_map(|run| [&run.map, &run.ends]);
        let steady = self.tables.steady.iter().map(Steady::map);
        self.course
            .bytes(self.tables.spectral.operators().chain(runs).chain(steady))
    }
}

impl Kernel for Fused<'_> {
    type Workspace = Workspace<Scratch>;

    fn workspace(&self) -> Self::Workspace {
        let state = self.course.layout.padded();
        self.course.workspace(Scratch {
            spectral: self.tables.spectral.scratch(),
            ends: vec![0.0; padded(LONGEST)],
            next: vec![0.0; state],
            run: None,
        })
    }

    fn march<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Self::Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        self.course.march(
            &self.tables,
            trajectory,
            tangents,
            workspace,
            observer,
            counters,
        )
    }
}

impl Tables {
    fn new(course: &Course<'_>) -> Result<Self, DenseError> {
        let grid = &course.grid;
        let propagators: Vec<Mat<f64>> = (course.contact.iter().zip(&grid.classes))
            .map(|(g, class)| exponential::propagator(g, grid.rate, class.duration))
            .collect();
        let direction = |cell: usize| {
            let segment = grid.cells[cell].segment;
            course.model.cycle.segments[segment].direction
        };
        let mut runs: Vec<Run> = Vec::new();
        let mut starts = vec![Vec::new(); grid.cells.len()];
        for (start, found) in starts.iter_mut().enumerate() {
            let mut length = LONGEST;
            while length > 0 {
                let end = start + length;
                let fits = start % length == 0 && end <= grid.cells.len();
                if fits && (start..end).all(|cell| direction(cell) == direction(start)) {
                    let classes: Vec<usize> =
                        grid.cells[start..end].iter().map(|c| c.class).collect();
                    let known = runs.iter().position(|run| run.classes == classes);
                    found.push(known.unwrap_or_else(|| {
                        runs.push(Run::new(course, &propagators, &classes));
                        runs.len() - 1
                    }));
                }
                length /= 2;
            }
        }
        Ok(Self {
            spectral: SpectralTables::new(course)?,
            runs,
            starts,
            steady: Steady::new(course, &propagators),
        })
    }
}

impl Method for Tables {
    type Scratch = Scratch;
    const REACH: f64 = SpectralTables::REACH;
    const FLIES: bool = SpectralTables::FLIES;

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
        if piece.cell == 0
            && let Some(steady) = &self.steady
            && steady.holds(piece, z)
        {
            counters.certified += 1;
            steady.map().apply(z, &mut scratch.next);
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
        let map = match (scratch.run, &self.steady) {
            (Some(index), _) => &self.runs[index].map,
            (None, Some(steady)) => steady.map(),
            (None, None) => return,
        };
        map.apply(x, &mut scratch.next);
        x.copy_from_slice(&scratch.next);
        counters.matvecs += 1;
    }
}
