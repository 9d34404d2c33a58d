//! Closed-form event location in spectral coordinates.
//!
//! One product transforms the state to the basis of its segment and contact state, where the deflection is a sum of
//! damped sinusoids and a polynomial. All work up to the event is scalar there; a second product transforms back. A
//! stretch of free flight may span several cells.

use super::DenseError;
use super::bases::Bases;
use super::basis::{POWERS, REACH};
use super::cell_model::CellModel;
use super::conditioning::Conditioning;
use super::cycle::Method;
use super::exits::{Bounds, DeflectionAt, MarginAt};
use super::generator::Generator;
use super::kernel::{ClassTables, Dense};
use super::matrix::{Operator, dot};
use super::series::locate;
use super::spectral_table::{Coordinates, Factors, Guard, SpectralTable};
use super::state_part::{Exit, StatePart};
use super::waves;
use crate::model::Model;
use crate::propagate::Counters;
use crate::propagate::events::Margin;

/// Round-off of a wave, relative to that of δ.
const OF_A_WAVE: f64 = 0.25;

/// The spectral kernel for one model.
pub type Spectral<'m> = Dense<'m, SpectralTables>;

/// Tables of this kernel.
#[derive(Debug)]
pub struct SpectralTables {
    bases: Bases,
    stock: ClassTables<SpectralTable>,
}

/// Scratch memory.
#[derive(Debug)]
pub struct SpectralScratch {
    at: Coordinates,
    amplitudes: [Vec<f64>; 2],
    factors: Factors,
    /// The table to which `factors` belong: whether it is for contact, and its index.
    prepared: Option<(bool, usize)>,
}

impl<'m> Spectral<'m> {
    /// Builds the kernel's tables for a model.
    ///
    /// * `cells`: smallest number of unit steps per mesh cycle; there are more if a cell would be too long.
    /// * `event_limit`: largest number of events in a mesh cycle; integration stops at more.
    /// * `event_grid`: number of equal parts of the cycle. Every event is delayed to the end of its part,
    ///   where the contact state changes, as in the last step of the published algorithm.
    ///   The error is of first order. `None`: events stay at their times.
    ///
    /// # Errors
    /// [`DenseError`] if tables cannot represent the model, the speed is too slow for them, eigenvectors are nearly
    /// parallel, or an undamped mode is in resonance with a harmonic.
    pub fn new(
        model: &'m Model,
        cells: u32,
        event_limit: u32,
        event_grid: Option<u32>,
    ) -> Result<Self, DenseError> {
        let cell_model =
            CellModel::new(model, cells, SpectralTables::REACH, event_limit, event_grid)?;
        let tables = SpectralTables::new(&cell_model, Bases::new(model)?)?;
        Ok(Self { cell_model, tables })
    }

    /// The kernel of a model with known bases; other arguments as for [`Spectral::new`]. The bases are valid for every
    /// speed, load and half gap, and all excitations with the same number of harmonics.
    ///
    /// # Errors
    /// As for [`Spectral::new`].
    pub fn with_bases(
        model: &'m Model,
        cells: u32,
        event_limit: u32,
        bases: Bases,
    ) -> Result<Self, DenseError> {
        let cell_model = CellModel::new(model, cells, SpectralTables::REACH, event_limit, None)?;
        let tables = SpectralTables::new(&cell_model, bases)?;
        Ok(Self { cell_model, tables })
    }

    /// The kernel with its products in single precision. Everything else keeps 64 bits, also the search for events,
    /// whose tolerance is the round-off of the states. For comparison only; `atlas` does not use it.
    ///
    /// # Errors
    /// As for [`Spectral::new`].
    pub fn in_single_precision(
        model: &'m Model,
        cells: u32,
        event_limit: u32,
    ) -> Result<Self, DenseError> {
        let mut cell_model =
            CellModel::new(model, cells, SpectralTables::REACH, event_limit, None)?;
        cell_model.round_off *= f64::from(f32::EPSILON) / f64::EPSILON;
        let tables = SpectralTables::new(&cell_model, Bases::in_single_precision(model)?)?;
        Ok(Self { cell_model, tables })
    }

    /// Numerical quality of every basis, contact first.
    pub fn conditioning(&self) -> Vec<Conditioning> {
        self.tables.conditioning().collect()
    }
}

impl SpectralTables {
    /// The tables at the speed of a model.
    pub fn new(cell_model: &CellModel<'_>, bases: Bases) -> Result<Self, DenseError> {
        let grid = &cell_model.grid;
        let make = |g: &Generator, class: usize, touching| {
            let class = &grid.classes[class];
            let basis = bases.of(class.segment, touching);
            SpectralTable::new(basis, g, class.duration, grid.period)
        };
        let stock = ClassTables::new(cell_model, make)?;
        Ok(Self { bases, stock })
    }

    pub fn conditioning(&self) -> impl Iterator<Item = Conditioning> {
        self.bases.all().map(|basis| basis.conditioning)
    }

    /// Advances the coordinates `scratch.at` over the first `time` of a stretch, and writes the state to `z`.
    fn back(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        time: f64,
        z: &mut [f64],
        scratch: &mut SpectralScratch,
        counters: &mut Counters,
    ) {
        let (table, key) = self.stock.of(cell_model, stretch);
        let SpectralScratch {
            at,
            factors,
            prepared,
            ..
        } = scratch;
        if stretch.whole && time == stretch.duration {
            table.advance(&table.whole, at);
        } else {
            if *prepared != Some(key) || factors.time != time {
                table.prepare(time, factors);
                *prepared = Some(key);
            }
            table.advance(factors, at);
        }
        table.to_state(at, z);
        counters.matvecs += 1;
    }
}

impl Method for SpectralTables {
    type Scratch = SpectralScratch;
    const REACH: f64 = REACH;
    const FLIES: bool = true;

    fn operators(&self) -> impl Iterator<Item = &Operator> {
        let of_tables = self.stock.all().flat_map(SpectralTable::operators);
        self.bases.operators().chain(of_tables)
    }

    fn scratch(&self, _: &CellModel<'_>) -> SpectralScratch {
        let most =
            |size: fn(&SpectralTable) -> usize| self.stock.all().map(size).max().unwrap_or(0);
        let (lanes, slow) = (most(|table| table.alpha.len()), most(|table| table.slow));
        SpectralScratch {
            at: Coordinates::new(self.stock.all()),
            amplitudes: [vec![0.0; lanes], vec![0.0; lanes]],
            factors: Factors::new(lanes, slow),
            prepared: None,
        }
    }

    fn pass(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        z: &mut [f64],
        scratch: &mut SpectralScratch,
        counters: &mut Counters,
    ) -> Option<Exit> {
        let (table, _) = self.stock.of(cell_model, stretch);
        let generator = cell_model.generator(stretch.cell, stretch.contact);
        let lanes = table.alpha.len();
        table.to_spectral(z, &mut scratch.at);
        counters.matvecs += 1;
        let [re, im] = &mut scratch.amplitudes;
        let (u, rest) = scratch.at.y.split_at(lanes);
        let v = &rest[..lanes];
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
            *q = row.iter().zip(&scratch.at.slow).map(|(p, x)| p * x).sum();
        }
        let growth = (table.growth * stretch.duration).exp();
        let drift = guard.bounds(stretch.duration);
        let [first, second, third] = [0, 1, 2].map(|i| growth * sums[i + 1] + drift[i]);
        let start = DeflectionAt {
            time: 0.0,
            deflection: [
                dot(&generator.deflection, z),
                dot(&generator.rate, z),
                dot(&table.curvature, z),
            ],
        };
        let contacts = &cell_model.model.contacts;
        let reach = first * stretch.duration;
        let clear = stretch.crossed.is_none()
            && Margin::of(contacts, stretch.contact)
                .all(|margin| MarginAt::of(&margin, &start).value > reach + stretch.noise);
        let exit = if clear {
            counters.certified += 1;
            None
        } else {
            let bounds = Bounds {
                second,
                third,
                noise: stretch.noise + OF_A_WAVE * cell_model.round_off * sums[0],
            };
            let mut evaluations = 1;
            let end = DeflectionAt {
                time: stretch.duration,
                deflection: guard.at(stretch.duration),
            };
            let mut at = |time: f64| {
                evaluations += 1;
                guard.at(time)
            };
            let found = locate(
                stretch,
                contacts,
                [&start, &end],
                &bounds,
                true,
                &mut at,
                counters,
            );
            counters.guard_evaluations += evaluations;
            found
        };
        let time = exit.map_or(stretch.duration, |exit| exit.time);
        self.back(cell_model, stretch, time, z, scratch, counters);
        exit
    }

    fn follow(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        time: f64,
        x: &mut [f64],
        scratch: &mut SpectralScratch,
        counters: &mut Counters,
    ) {
        let (table, _) = self.stock.of(cell_model, stretch);
        table.to_spectral(x, &mut scratch.at);
        counters.matvecs += 1;
        self.back(cell_model, stretch, time, x, scratch, counters);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::fixtures;
    use crate::model::{InitialState, OperatingPoint};
    use crate::propagate::Kernel;

    /// Deep in contact, a bound of the deflection's swing excludes events: nothing is searched.
    #[test]
    fn stretches_far_from_a_surface_are_not_searched() {
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &[1.0, 0.1], &[1.0, 0.1]);
        let drive = fixtures::constant_mesh(1e-5, 4e8);
        let point = OperatingPoint {
            load: 1.0,
            speed: 1200.0,
        };
        let model = Model::new(&structure, &drive, point).unwrap();
        let kernel = Spectral::new(&model, 60, 100, None).unwrap();
        let mut trajectory = model.start(&InitialState::Static);
        let mut counters = Counters::default();
        let mut workspace = kernel.workspace();
        (kernel.advance(3, &mut trajectory, &mut workspace, &mut (), &mut counters)).unwrap();
        assert_eq!(counters.events, 0);
        assert_eq!(
            (counters.certified, counters.guard_evaluations),
            (counters.windows, 0)
        );
    }
}
