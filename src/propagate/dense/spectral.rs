//! Closed-form event location in spectral coordinates.
//!
//! One product takes the state to the basis of its segment and contact state, where the
//! deflection is a sum of damped sinusoids and a polynomial. Everything up to the event is scalar
//! work there; a second product goes back. Free flight is one such piece however many cells it
//! spans.

use super::basis::{Basis, POWERS};
use super::course::Course;
use super::exits::{Bounds, Margin, Sight};
use super::exponential;
use super::generator::Generator;
use super::march::{Exit, Method, Piece, Workspace};
use super::matrix::{Operator, dot, padded};
use super::series::locate;
use super::waves;
use super::{DenseError, TableSize};
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Counters, Kernel, Observer, Stop, Tangents};
use faer::Mat;

/// Round-off of a wave, in units of its size.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

/// The spectral kernel for one model.
#[derive(Debug)]
pub struct Spectral<'m> {
    course: Course<'m>,
    tables: Tables,
}

/// How well one basis behaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditioning {
    /// A mesh segment it serves.
    pub segment: usize,
    /// Whether it is that of contact.
    pub touching: bool,
    /// Condition number of the eigenvector basis of the blocks that are diagonalised, each
    /// velocity in units of its frequency.
    pub condition: f64,
    /// Largest error of a cell's propagator rebuilt from the basis, relative to its largest
    /// entry, against the Taylor series.
    pub reconstruction: f64,
}

#[derive(Debug)]
pub(super) struct Tables {
    contact: Vec<Table>,
    flight: Vec<Table>,
}

/// One basis, ready for use.
#[derive(Debug)]
struct Table {
    /// W⁻¹ and W.
    inverse: Operator,
    matrix: Operator,
    alpha: Vec<f64>,
    nu: Vec<f64>,
    /// |λ| of the waves.
    sizes: Vec<f64>,
    /// Growth of the fastest growing wave \[1/s\]; none grows without friction.
    growth: f64,
    /// Deflection in terms of u and v.
    gains: [Vec<f64>; 2],
    /// Deflection of the slow group, row k times the k-th power of time; rows of `slow`.
    polynomial: Vec<f64>,
    /// Slow coordinates with their constants.
    slow: usize,
    /// Gᵏ/k!, row by row.
    powers: Vec<Vec<f64>>,
    /// δ'' as a row over z.
    curvature: Vec<f64>,
    /// Factors over the whole cell.
    whole: Factors,
    conditioning: Conditioning,
}

/// What moves spectral coordinates over a time.
#[derive(Debug, Clone)]
struct Factors {
    time: f64,
    cosine: Vec<f64>,
    sine: Vec<f64>,
    /// `e^{Gt}`, row by row.
    slow: Vec<f64>,
}

/// Scratch memory.
#[derive(Debug)]
pub struct Scratch {
    y: Vec<f64>,
    amplitudes: [Vec<f64>; 2],
    slow: Vec<f64>,
    factors: Factors,
    /// Whether `factors` are those of a contact table, and which.
    prepared: Option<(bool, usize)>,
}

impl Factors {
    fn new(lanes: usize, slow: usize) -> Self {
        Self {
            time: f64::NAN,
            cosine: vec![0.0; lanes],
            sine: vec![0.0; lanes],
            slow: vec![0.0; slow * slow],
        }
    }
}

impl Table {
    fn new(
        generator: &Generator,
        course: &Course<'_>,
        class: usize,
        touching: bool,
    ) -> Result<Self, DenseError> {
        let (grid, layout) = (&course.grid, &course.layout);
        let basis = Basis::new(generator, grid.period, touching)?;
        let lanes = basis.alpha.len();
        let slow = basis.slow + 2;
        let row = Mat::from_fn(1, layout.dimension(), |_, j| generator.deflection[j]);
        let seen = &row * &basis.matrix;
        let slow_row = Mat::from_fn(1, slow, |_, j| seen[(0, 2 * lanes + j)]);
        let mut polynomial: Vec<f64> = (basis.powers.iter())
            .flat_map(|power| {
                let row = &slow_row * power;
                (0..slow).map(move |j| row[(0, j)])
            })
            .collect();
        // A nilpotent group's polynomial ends early.
        while polynomial.len() > slow
            && polynomial[polynomial.len() - slow..]
                .iter()
                .all(|p| *p == 0.0)
        {
            polynomial.truncate(polynomial.len() - slow);
        }
        let duration = grid.classes[class].duration;
        let propagator = exponential::propagator(generator, grid.rate, duration);
        let conditioning = Conditioning {
            segment: grid.classes[class].segment,
            touching,
            condition: basis.condition,
            reconstruction: basis.reconstruction(&propagator, duration, layout.modes, grid.rate),
        };
        let rates = basis.alpha.iter().zip(&basis.nu);
        let flat = |power: &Mat<f64>| {
            (0..slow * slow)
                .map(|i| power[(i / slow, i % slow)])
                .collect()
        };
        let mut table = Self {
            inverse: Operator::new(basis.inverse.as_ref()),
            matrix: Operator::new(basis.matrix.as_ref()),
            sizes: rates.map(|(a, n)| a.hypot(*n)).collect(),
            growth: basis.alpha.iter().fold(0.0, |most: f64, a| most.max(*a)),
            gains: [0, lanes].map(|from| (from..from + lanes).map(|j| seen[(0, j)]).collect()),
            polynomial,
            slow,
            powers: basis.powers.iter().map(flat).collect(),
            curvature: generator.curvature(),
            whole: Factors::new(lanes, slow),
            alpha: basis.alpha,
            nu: basis.nu,
            conditioning,
        };
        let mut whole = table.whole.clone();
        table.prepare(duration, &mut whole);
        table.whole = whole;
        Ok(table)
    }

    /// Factors over a time.
    fn prepare(&self, time: f64, factors: &mut Factors) {
        let lanes = self.alpha.len();
        waves::factors(
            [&self.alpha, &self.nu],
            time,
            &mut factors.cosine[..lanes],
            &mut factors.sine[..lanes],
        );
        let entries = self.slow * self.slow;
        factors.slow[..entries].fill(0.0);
        for power in self.powers.iter().rev() {
            for (entry, p) in factors.slow[..entries].iter_mut().zip(power) {
                *entry = *entry * time + p;
            }
        }
        factors.time = time;
    }

    /// Moves spectral coordinates in place.
    fn advance(&self, factors: &Factors, y: &mut [f64], spare: &mut [f64]) {
        let lanes = self.alpha.len();
        let (u, rest) = y.split_at_mut(lanes);
        let (v, rest) = rest.split_at_mut(lanes);
        waves::turn([&factors.cosine[..lanes], &factors.sine[..lanes]], u, v);
        let old = &mut spare[..self.slow];
        old.copy_from_slice(&rest[..self.slow]);
        let rows = factors.slow[..self.slow * self.slow].chunks_exact(self.slow);
        for (new, row) in rest.iter_mut().zip(rows) {
            *new = row.iter().zip(&*old).map(|(g, x)| g * x).sum();
        }
    }
}

/// The deflection of a piece in closed form.
struct Guard<'t> {
    table: &'t Table,
    amplitudes: [&'t [f64]; 2],
    polynomial: [f64; POWERS + 1],
    /// Powers of time in use.
    terms: usize,
}

impl Guard<'_> {
    /// δ, δ', δ'' at a time.
    fn at(&self, time: f64) -> [f64; 3] {
        let table = self.table;
        let [a, b, c] = waves::sum([&table.alpha, &table.nu], self.amplitudes, time);
        let [mut value, mut slope, mut half_curvature] = [0.0; 3];
        for q in self.polynomial[..self.terms].iter().rev() {
            half_curvature = half_curvature * time + slope;
            slope = slope * time + value;
            value = value * time + q;
        }
        [a + value, b + slope, c + 2.0 * half_curvature]
    }

    /// Bounds of the polynomial's first three derivatives up to a time.
    fn bounds(&self, time: f64) -> [f64; 3] {
        let mut bounds = [0.0; 3];
        for (order, bound) in bounds.iter_mut().enumerate() {
            for k in (order + 1..self.terms).rev() {
                let falling: usize = (k - order..=k).product();
                *bound = *bound * time + falling as f64 * self.polynomial[k].abs();
            }
        }
        bounds
    }
}

impl<'m> Spectral<'m> {
    /// Builds the kernel's tables for a model.
    ///
    /// * `cells`: fewest unit steps a mesh cycle; more where a cell would be too long.
    /// * `event_limit`: most events in a mesh cycle before marching stops.
    /// * `event_grid`: puts every event off to the end of its part of so many equal ones, and
    ///   takes the contact state from there, as the published algorithm does in its last step:
    ///   an error of first order. None: events are where they are.
    ///
    /// # Errors
    /// Stiffness that varies within a segment, a speed too slow for tables, eigenvectors too
    /// nearly parallel, an undamped mode in resonance with a harmonic.
    pub fn new(
        model: &'m Model,
        cells: u32,
        event_limit: u32,
        event_grid: Option<u32>,
    ) -> Result<Self, DenseError> {
        let course = Course::new(model, cells, Tables::REACH, event_limit, event_grid)?;
        let tables = Tables::new(&course)?;
        Ok(Self { course, tables })
    }

    /// How well every basis behaves, contact first.
    pub fn conditioning(&self) -> Vec<Conditioning> {
        self.tables.conditioning().collect()
    }

    /// Size of the tables.
    pub fn bytes(&self) -> TableSize {
        self.course.bytes(self.tables.operators())
    }
}

impl Kernel for Spectral<'_> {
    type Workspace = Workspace<Scratch>;

    fn workspace(&self) -> Self::Workspace {
        self.course.workspace(self.tables.scratch())
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
    pub fn new(course: &Course<'_>) -> Result<Self, DenseError> {
        let contact = course.contact.iter().enumerate();
        let flight = course.flight.iter().zip(&course.grid.flights);
        Ok(Self {
            contact: contact
                .map(|(class, g)| Table::new(g, course, class, true))
                .collect::<Result<_, _>>()?,
            flight: flight
                .map(|(g, &class)| Table::new(g, course, class, false))
                .collect::<Result<_, _>>()?,
        })
    }

    fn all(&self) -> impl Iterator<Item = &Table> {
        self.contact.iter().chain(&self.flight)
    }

    pub fn conditioning(&self) -> impl Iterator<Item = Conditioning> {
        self.all().map(|table| table.conditioning)
    }

    pub fn operators(&self) -> impl Iterator<Item = &Operator> {
        self.all().flat_map(|table| [&table.inverse, &table.matrix])
    }

    pub fn scratch(&self) -> Scratch {
        let most = |size: fn(&Table) -> usize| self.all().map(size).max().unwrap_or(0);
        let (lanes, slow) = (most(|table| table.alpha.len()), most(|table| table.slow));
        Scratch {
            y: vec![0.0; padded(2 * lanes + slow)],
            amplitudes: [vec![0.0; lanes], vec![0.0; lanes]],
            slow: vec![0.0; slow],
            factors: Factors::new(lanes, slow),
            prepared: None,
        }
    }

    fn table(&self, course: &Course<'_>, piece: &Piece) -> (&Table, (bool, usize)) {
        let class = course.grid.cells[piece.cell].class;
        match piece.contact.touching() {
            true => (&self.contact[class], (true, class)),
            false => {
                let flight = course.grid.classes[class].flight;
                (&self.flight[flight], (false, flight))
            }
        }
    }

    /// Moves `scratch.y` over the first `time` of a piece and writes the state.
    fn back(
        &self,
        course: &Course<'_>,
        piece: &Piece,
        time: f64,
        z: &mut [f64],
        scratch: &mut Scratch,
        counters: &mut Counters,
    ) {
        let (table, key) = self.table(course, piece);
        let Scratch {
            y,
            slow,
            factors,
            prepared,
            ..
        } = scratch;
        if piece.whole && time == piece.duration {
            table.advance(&table.whole, y, slow);
        } else {
            if *prepared != Some(key) || factors.time != time {
                table.prepare(time, factors);
                *prepared = Some(key);
            }
            table.advance(factors, y, slow);
        }
        table.matrix.apply(y, z);
        counters.matvecs += 1;
    }
}

impl Method for Tables {
    type Scratch = Scratch;
    const REACH: f64 = 8.0;
    const FLIES: bool = true;

    fn pass(
        &self,
        course: &Course<'_>,
        piece: &Piece,
        z: &mut [f64],
        scratch: &mut Scratch,
        counters: &mut Counters,
    ) -> Option<Exit> {
        let (table, _) = self.table(course, piece);
        let generator = course.generator(piece.cell, piece.contact);
        let lanes = table.alpha.len();
        table.inverse.apply(z, &mut scratch.y);
        counters.matvecs += 1;
        let [re, im] = &mut scratch.amplitudes;
        let (u, rest) = scratch.y.split_at(lanes);
        let (v, slow) = rest.split_at(lanes);
        let gains = [&table.gains[0][..], &table.gains[1][..]];
        let sums = waves::amplitudes(
            gains,
            [u, v],
            &table.sizes,
            &mut re[..lanes],
            &mut im[..lanes],
        );
        let mut guard = Guard {
            table,
            amplitudes: [&re[..lanes], &im[..lanes]],
            polynomial: [0.0; POWERS + 1],
            terms: table.polynomial.len() / table.slow,
        };
        let rows = table.polynomial.chunks_exact(table.slow);
        for (q, row) in guard.polynomial.iter_mut().zip(rows) {
            *q = row.iter().zip(slow).map(|(p, x)| p * x).sum();
        }
        let growth = (table.growth * piece.duration).exp();
        let drift = guard.bounds(piece.duration);
        let [first, second, third] = [0, 1, 2].map(|i| growth * sums[i + 1] + drift[i]);
        let start = Sight {
            time: 0.0,
            deflection: [
                dot(&generator.deflection, z),
                dot(&generator.rate, z),
                dot(&table.curvature, z),
            ],
        };
        let half_gap = course.model.half_gap;
        let reach = first * piece.duration;
        let clear = piece.crossed.is_none()
            && Margin::of(piece.contact, half_gap)
                .all(|margin| margin.see(&start).value > reach + piece.noise);
        let exit = if clear {
            counters.certified += 1;
            None
        } else {
            let bounds = Bounds {
                second,
                third,
                noise: piece.noise + ROUND_OFF * sums[0],
            };
            let mut evaluations = 1;
            let end = Sight {
                time: piece.duration,
                deflection: guard.at(piece.duration),
            };
            let mut at = |time: f64| {
                evaluations += 1;
                guard.at(time)
            };
            let found = locate(
                piece,
                half_gap,
                [&start, &end],
                &bounds,
                true,
                &mut at,
                counters,
            );
            counters.guard_evaluations += evaluations;
            found
        };
        let time = exit.map_or(piece.duration, |exit| exit.time);
        self.back(course, piece, time, z, scratch, counters);
        exit
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
        let (table, _) = self.table(course, piece);
        table.inverse.apply(x, &mut scratch.y);
        counters.matvecs += 1;
        self.back(course, piece, time, x, scratch, counters);
    }
}
