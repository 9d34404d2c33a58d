//! The mesh cycle in cells, the unit steps of the table kernels.

use super::DenseError;
use crate::model::{Contact, Model, Release};
use crate::propagate::TableError;
use crate::propagate::{SAME_LENGTH, Volterra};

/// Largest excess of a segment over a whole number of equal parts of the cycle that adds no cell, in lengths of a part.
const ON_BOUNDARY: f64 = 1e-9;

/// Largest number of cells per cycle: their tables are dense.
const MOST_CELLS: f64 = 20_000.0;

/// One cell.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Mesh segment.
    pub segment: usize,
    /// Index in [`Grid::classes`].
    pub class: usize,
    /// Start within the mesh cycle \[s\].
    pub start: f64,
}

/// Common data of cells with the same operators.
#[derive(Debug, Clone, Copy)]
pub struct Class {
    /// A segment of this class.
    pub segment: usize,
    /// Length Δ \[s\].
    pub duration: f64,
    /// Index in [`Grid::flights`]: cells of one length and direction share the operators of free flight.
    pub flight: usize,
}

/// The cells of a mesh cycle.
#[derive(Debug, Clone)]
pub struct Grid {
    /// The cells, in order.
    pub cells: Vec<Cell>,
    /// Distinct (stiffness, damping, direction, length).
    pub classes: Vec<Class>,
    /// Distinct (direction, length), each by the index of one of its classes.
    pub flights: Vec<usize>,
    /// Mesh period \[s\].
    pub period: f64,
    /// Upper bound of the rates of the model \[rad/s\].
    pub rate: f64,
}

/// Whether the mean load of every block is proportional to the rated one, as tables require.
fn loads_are_rated(model: &Model) -> bool {
    (model.blocks.iter().zip(&model.rated_input))
        .all(|(block, rated)| block.static_input == rated.map(|input| input * model.load))
}

/// Whether a model's contacts are the two flanks of a mesh on one line of action, equal except for their side.
fn one_line(model: &Model) -> bool {
    let [drive, coast] = &model.contacts[..] else {
        return false;
    };
    let is_equal = drive.cycles == coast.cycles && drive.half_gap == coast.half_gap;
    is_equal && drive.cycles.len() == 1 && drive.side == -coast.side
}

/// Checks that tables can represent a model, at any speed.
///
/// # Errors
/// The reason why they cannot.
pub fn fits(model: &Model) -> Result<(), DenseError> {
    if model.basis.coupled().is_some() || !loads_are_rated(model) {
        return Err(DenseError::Coupled);
    }
    if model.blocks.iter().any(|block| block.spread().is_some()) {
        return Err(DenseError::Overdamped);
    }
    if !one_line(model) {
        return Err(DenseError::Contacts);
    }
    let by_force = |contact: &Contact| contact.release == Release::Force;
    if model.contacts.iter().any(by_force) {
        return Err(TableError::Release.into());
    }
    let cycle = model.first_cycle();
    if cycle.has_error() {
        return Err(TableError::FlankError.into());
    }
    if cycle.segments.iter().all(|s| s.stiffness.is_constant()) {
        Ok(())
    } else {
        Err(TableError::VaryingStiffness.into())
    }
}

impl Grid {
    /// At least `cells` cells per cycle, a whole number of equal ones in every segment, none of them longer than
    /// `reach` divided by the fastest rate.
    ///
    /// # Errors
    /// As for [`fits`], or tables would need too many cells.
    pub fn new(model: &Model, cells: u32, reach: f64) -> Result<Self, DenseError> {
        fits(model)?;
        let cycle = model.first_cycle();
        let rate = Volterra::fastest_rate(model);
        let mut grid = Self {
            cells: Vec::new(),
            classes: Vec::new(),
            flights: Vec::new(),
            period: cycle.period,
            rate,
        };
        let fewest = f64::from(cells).max(rate * cycle.period / reach);
        if fewest.is_nan() || fewest > MOST_CELLS {
            return Err(DenseError::TooManyCells { cells: fewest });
        }
        for (segment, s) in cycle.segments.iter().enumerate() {
            let (start, end) = (cycle.start(segment), cycle.end(segment));
            let count = (fewest * (s.end - s.start) - ON_BOUNDARY).ceil().max(1.0);
            let class = grid.class(model, segment, (end - start) / count);
            grid.cells.extend((0..count as usize).map(|i| Cell {
                segment,
                class,
                start: start + (end - start) * (i as f64 / count),
            }));
        }
        Ok(grid)
    }

    /// Index of the class of a segment's cells; adds the class if it is new.
    fn class(&mut self, model: &Model, segment: usize, duration: f64) -> usize {
        let segments = &model.first_cycle().segments;
        let same_length =
            |known: &Class| (known.duration - duration).abs() <= SAME_LENGTH * duration;
        let turned =
            |known: &Class| segments[known.segment].direction == segments[segment].direction;
        let same_mesh = |known: &Class| {
            let (a, b) = (&segments[known.segment], &segments[segment]);
            a.stiffness == b.stiffness && a.damping == b.damping
        };
        let is_equal = |known: &&Class| same_length(known) && turned(known);
        if let Some(known) = (self.classes.iter()).position(|k| is_equal(&k) && same_mesh(k)) {
            return known;
        }
        let flight = self.classes.iter().find(is_equal).map(|known| known.flight);
        let class = self.classes.len();
        self.classes.push(Class {
            segment,
            duration,
            flight: flight.unwrap_or(self.flights.len()),
        });
        if flight.is_none() {
            self.flights.push(class);
        }
        class
    }

    /// Start of a cell, or the end of the cycle \[s\].
    pub fn time(&self, cell: usize) -> f64 {
        self.cells.get(cell).map_or(self.period, |cell| cell.start)
    }

    /// Length of a cell \[s\].
    pub fn duration(&self, cell: usize) -> f64 {
        self.classes[self.cells[cell].class].duration
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::fixtures;
    use crate::model::{CoastFlank, Division, Drive, FlankError, OperatingPoint, Stiffness};

    fn model(drive: &Drive) -> Model {
        let structure = fixtures::structure(&[0.0, 3000.0], 0.01, &[1.0, 0.3], &[1.0, 0.3]);
        Model::new(&structure, drive, fixtures::strong_rattle()).unwrap()
    }

    fn levels(stiffness: &[f64], transitions: &[f64]) -> Drive {
        Drive {
            mesh: Division::levels(stiffness, transitions),
            ..fixtures::two_level_mesh(1e-5)
        }
    }

    /// Cells cover their segments consecutively, and classes distinguish them by stiffness and length.
    #[test]
    fn cells_of_one_kind_share_a_class() {
        let (a, b) = (4e8, 3e8);
        for (drive, cells, counts, classes, flights) in [
            (levels(&[a, b], &[0.6]), 10, vec![6, 4], 2, 1),
            (levels(&[a, b], &[0.6]), 7, vec![5, 3], 2, 2),
            (levels(&[a, b, a, b], &[]), 8, vec![2, 2, 2, 2], 2, 1),
            (
                levels(&[a, b, a, b], &[0.2, 0.5, 0.8]),
                10,
                vec![2, 3, 3, 2],
                2,
                1,
            ),
            (levels(&[a, b, a], &[0.26, 0.5]), 4, vec![2, 1, 2], 3, 3),
        ] {
            let model = model(&drive);
            let grid = Grid::new(&model, cells, f64::INFINITY).unwrap();
            let of = |segment| grid.cells.iter().filter(|c| c.segment == segment).count();
            assert_eq!((0..counts.len()).map(of).collect::<Vec<_>>(), counts);
            assert_eq!(
                (grid.classes.len(), grid.flights.len()),
                (classes, flights),
                "{counts:?}"
            );
            let segments = &model.first_cycle().segments;
            for (i, cell) in grid.cells.iter().enumerate() {
                let length = grid.time(i + 1) - grid.time(i);
                assert!((grid.duration(i) / length - 1.0).abs() < 1e-12);
                let class = &grid.classes[cell.class];
                let [own, known] = [cell.segment, class.segment].map(|s| segments[s].stiffness);
                assert_eq!(own, known);
                let flight = &grid.classes[grid.flights[class.flight]];
                assert!((flight.duration / length - 1.0).abs() < 1e-12);
            }
            assert_eq!(
                (grid.time(0), grid.time(grid.cells.len())),
                (0.0, model.period())
            );
        }
    }

    #[test]
    fn no_cell_is_longer_than_its_reach() {
        let model = model(&levels(&[4e8, 3e8], &[0.6]));
        for reach in [0.1, 2.0] {
            let grid = Grid::new(&model, 1, reach).unwrap();
            let longest = (0..grid.cells.len())
                .map(|i| grid.duration(i))
                .fold(0.0, f64::max);
            assert!(grid.rate * longest <= reach * (1.0 + 1e-9), "{longest}");
            // Rounding adds at most one cell per segment.
            assert!(grid.cells.len() as f64 <= grid.rate * grid.period / reach + 2.0);
        }
        let most = Grid::new(&model, 20_000, f64::INFINITY);
        assert_eq!(most.map(|grid| grid.cells.len()), Ok(20_000));
        let refused = Grid::new(&model, 20_001, f64::INFINITY).map(|_| ());
        assert_eq!(refused, Err(DenseError::TooManyCells { cells: 20_001.0 }));
    }

    #[test]
    fn what_tables_do_not_follow_is_named() {
        let plain = levels(&[4e8, 3e8], &[]);
        assert_eq!(fits(&model(&plain)), Ok(()));
        let mut varying = plain.clone();
        varying.mesh[1].stiffness = Stiffness::series([3e8, 1e7, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(
            fits(&model(&varying)),
            Err(TableError::VaryingStiffness.into())
        );
        let mut with_gap_error = plain.clone();
        with_gap_error.mesh[1].error =
            FlankError::series([1e-6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(
            fits(&model(&with_gap_error)),
            Err(TableError::FlankError.into())
        );
        let by_force = Drive {
            release: Release::Force,
            ..plain.clone()
        };
        assert_eq!(fits(&model(&by_force)), Err(TableError::Release.into()));
        let coast = Some(CoastFlank {
            mesh: Division::levels(&[3e8, 4e8], &[]),
            further: Vec::new(),
            transmission_error: Vec::new(),
        });
        let of_its_own = Drive {
            coast,
            ..plain.clone()
        };
        assert_eq!(fits(&model(&of_its_own)), Err(DenseError::Contacts));
        let mut alone = model(&plain);
        alone.contacts.truncate(1);
        assert_eq!(fits(&alone), Err(DenseError::Contacts));
        let point = OperatingPoint {
            load: 0.1,
            speed: 100.0,
        };
        let mut structure = fixtures::structure(&[0.0, 3000.0], 1.5, &[1.0, 0.3], &[1.0, 0.3]);
        let overdamped = Model::new(&structure, &plain, point).unwrap();
        assert_eq!(fits(&overdamped), Err(DenseError::Overdamped));
        structure.damping = vec![0.0, 0.01];
        structure.constant_load = vec![3.0, 0.0];
        let loaded = Model::new(&structure, &plain, point).unwrap();
        assert_eq!(fits(&loaded), Err(DenseError::Coupled));
    }
}
