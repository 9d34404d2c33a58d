//! The eigenvectors of one system.
//!
//! In modal displacements and velocities x a system obeys `x' = A x`, with `A = [0 I; −K − Σ k g wᵀ, −D − Σ c g wᵀ]`,
//! with sums over its closed contacts. K and D are diagonal; they are full if dampers, drag, gyroscopic terms or
//! cross-coupled bearings couple modes. The coordinates z decompose A into 2 × 2 blocks: `x = T z`, `z' = G z`. They do
//! not depend on load or gap, and on the speed only with gyroscopic terms. The coordinates of free flight are the
//! model's blocks, which are the modes if nothing couples them. Maps to and from "modes" in this file are maps to and
//! from the model's blocks.

use super::sets::Sets;
use crate::model::{Block, Model};
use crate::numerics::decoupling::decouple;
use crate::propagate::vectors::LANES;
use crate::propagate::{Aligned, TableError};
use faer::Mat;
use std::borrow::Cow;
use std::ops::Deref;

/// Largest relative error of `A T = T G`.
const LARGEST_ERROR: f64 = 1e-11;

/// Frequency that scales rigid displacements in the error of a basis, relative to the fastest rate.
const RIGID_FREQUENCY: f64 = 1e-2;

/// Half the length of a padded state: its first components fill whole lane groups, then its second components do.
pub fn padded(modes: usize) -> usize {
    modes.next_multiple_of(LANES)
}

/// A map between padded states: one column of `2 padded` numbers for each of the `2 modes` components, in order.
#[derive(Debug)]
pub enum Map<'t> {
    /// Borrowed from kept tables.
    Kept(&'t [f64]),
    /// Computed by this kernel.
    Own(Aligned),
}

impl Deref for Map<'_> {
    type Target = [f64];

    #[inline]
    fn deref(&self) -> &[f64] {
        match self {
            Self::Kept(columns) => columns,
            Self::Own(columns) => columns,
        }
    }
}

/// The coordinates of a system.
#[derive(Debug)]
pub struct Basis<'t> {
    /// Blocks G, four numbers per block \[1/s\].
    pub generators: Cow<'t, [f64]>,
    /// T and its inverse; `None` if the coordinates are the modes.
    pub maps: Option<[Map<'t>; 2]>,
}

impl<'t> Basis<'t> {
    /// Block of a pair of coordinates.
    pub fn block(&self, index: usize) -> Block {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| self.generators[4 * index + k]);
        Block {
            generator: [[a, b], [c, d]],
            static_input: [0.0; 2],
        }
    }

    /// The map to modes; `None` if the coordinates are the modes.
    pub fn to_modes(&self) -> Option<&Map<'t>> {
        self.maps.as_ref().map(|[to, _]| to)
    }

    /// The map back from modes.
    pub fn of_modes(&self) -> Option<&Map<'t>> {
        self.maps.as_ref().map(|[_, from]| from)
    }

    /// Converts a row over the states of the model's blocks to a row over padded coordinates.
    pub fn row(&self, gains: &[[f64; 2]]) -> Vec<f64> {
        let (n, padded) = (gains.len(), padded(gains.len()));
        let mut row = vec![0.0; 2 * padded];
        match self.to_modes() {
            None => put(gains, &mut row),
            Some(map) => {
                for (j, column) in map.chunks_exact(2 * padded).enumerate() {
                    let place = if j < n { j } else { padded + j - n };
                    let (first, second) = column.split_at(padded);
                    row[place] = (gains.iter().zip(first).zip(second))
                        .map(|((w, a), b)| w[0] * a + w[1] * b)
                        .sum();
                }
            }
        }
        row
    }

    /// Converts inputs of the model's blocks to inputs of the padded coordinates.
    pub fn input(&self, inputs: &[[f64; 2]]) -> Vec<f64> {
        let (n, padded) = (inputs.len(), padded(inputs.len()));
        let mut out = vec![0.0; 2 * padded];
        match self.of_modes() {
            None => put(inputs, &mut out),
            Some(map) => {
                let columns = map.chunks_exact(2 * padded);
                let components = [0, 1].map(|part| (0..n).map(move |i| inputs[i][part]));
                let [first, second] = components;
                for (column, f) in columns.zip(first.chain(second)) {
                    for (sum, entry) in out.iter_mut().zip(column) {
                        *sum += entry * f;
                    }
                }
            }
        }
        out
    }
}

/// Writes pairs as a padded state.
fn put(pairs: &[[f64; 2]], state: &mut [f64]) {
    let padded = state.len() / 2;
    for (i, pair) in pairs.iter().enumerate() {
        [state[i], state[padded + i]] = *pair;
    }
}

/// A matrix as a map between padded states.
pub fn columns(matrix: &Mat<f64>) -> Map<'static> {
    let n = matrix.nrows() / 2;
    let padded = padded(n);
    let mut out = Aligned::zeros(4 * n * padded);
    for (j, column) in out.chunks_exact_mut(2 * padded).enumerate() {
        for i in 0..n {
            column[i] = matrix[(i, j)];
            column[padded + i] = matrix[(n + i, j)];
        }
    }
    Map::Own(out)
}

/// A structure before any contact closes: `q'' + D q' + (W² + S) q = 0`.
struct Modes {
    /// W \[rad/s\].
    frequency: Vec<f64>,
    /// D, row by row \[1/s\].
    damping: Vec<f64>,
    /// S, row by row \[1/s²\].
    stiffness: Vec<f64>,
}

impl Modes {
    fn of(model: &Model) -> Self {
        let n = model.modes();
        if let Some(coupled) = model.basis.coupled() {
            let mut stiffness = coupled.stiffness.clone();
            for (i, w) in coupled.frequency.iter().enumerate() {
                stiffness[i * n + i] -= w.powi(2);
            }
            return Self {
                frequency: coupled.frequency.clone(),
                damping: coupled.damping.clone(),
                stiffness,
            };
        }
        let generator = |i: usize| model.blocks[i].generator;
        let mut damping = vec![0.0; n * n];
        for i in 0..n {
            damping[i * n + i] = -generator(i)[1][1];
        }
        Self {
            frequency: (0..n)
                .map(|i| (-generator(i)[1][0]).max(0.0).sqrt())
                .collect(),
            damping,
            stiffness: vec![0.0; n * n],
        }
    }
}

/// The basis of one system.
pub struct FoundBasis {
    /// Blocks G \[1/s\].
    pub generators: Vec<[[f64; 2]; 2]>,
    /// T.
    pub to_modes: Mat<f64>,
    /// Its inverse.
    pub from_modes: Mat<f64>,
}

impl FoundBasis {
    /// Computes the basis of a set.
    ///
    /// # Errors
    /// Its eigenvectors are too nearly parallel.
    pub fn new(model: &Model, sets: &Sets, set: usize) -> Result<Self, TableError> {
        let n = model.modes();
        if set == Sets::FREE {
            let same = || Mat::identity(2 * n, 2 * n);
            return Ok(Self {
                generators: model.blocks.iter().map(|block| block.generator).collect(),
                to_modes: same(),
                from_modes: same(),
            });
        }
        let Modes {
            frequency,
            mut damping,
            mut stiffness,
        } = Modes::of(model);
        for (_, class) in sets.closed(set) {
            let [w, g] = model.participations(class.direction);
            for i in 0..n {
                for j in 0..n {
                    let product = g[i] * w[j];
                    damping[i * n + j] += class.damping * product;
                    stiffness[i * n + j] += class.stiffness * product;
                }
            }
        }
        let decoupled =
            decouple(&frequency, &damping, &stiffness).map_err(|_| TableError::Defective {
                condition: f64::INFINITY,
                error: f64::INFINITY,
            })?;
        let square = |rows: &[f64]| Mat::from_fn(2 * n, 2 * n, |i, j| rows[2 * n * i + j]);
        let mut new_basis = Self {
            generators: decoupled.generators,
            to_modes: square(&decoupled.to_structure),
            from_modes: square(&decoupled.from_structure),
        };
        for i in 0..n {
            stiffness[i * n + i] += frequency[i].powi(2);
        }
        let error = new_basis.error(&frequency, &damping, &stiffness);
        if let Some(coupled) = model.basis.coupled() {
            new_basis.to_modes = square(&coupled.from_modes) * new_basis.to_modes;
            new_basis.from_modes = new_basis.from_modes * square(&coupled.to_modes);
        }
        if error <= LARGEST_ERROR {
            Ok(new_basis)
        } else {
            Err(TableError::Defective {
                error,
                condition: decoupled.condition,
            })
        }
    }

    /// Converts to a [`Basis`].
    pub fn basis(&self, set: usize) -> Basis<'static> {
        let maps = [&self.to_modes, &self.from_modes];
        Basis {
            generators: self
                .generators
                .as_flattened()
                .as_flattened()
                .to_vec()
                .into(),
            maps: (set != Sets::FREE).then(|| maps.map(columns)),
        }
    }

    /// Largest relative error of `A T − T G` and of `T T⁻¹ − I`. The first is relative to the fastest rate and the size
    /// of each column. Displacements are scaled by their frequencies, rigid ones by a slow frequency.
    fn error(&self, frequency: &[f64], damping: &[f64], stiffness: &[f64]) -> f64 {
        let n = self.generators.len();
        let block = |generator: &[[f64; 2]; 2]| Block {
            generator: *generator,
            static_input: [0.0; 2],
        };
        let rates = self
            .generators
            .iter()
            .map(|generator| block(generator).fastest());
        // A rotation without other modes has the rate 0.
        let rate = rates.fold(1.0, f64::max);
        let (t, inverse) = (&self.to_modes, &self.from_modes);
        let product = t * inverse;
        let unit = |i: usize| {
            if i < n { frequency[i].max(RIGID_FREQUENCY * rate) } else { 1.0 }
        };
        let mut worst = 0.0_f64;
        for i in 0..2 * n {
            for j in 0..2 * n {
                let identity = f64::from(u8::from(i == j));
                let off = (product[(i, j)] - identity).abs() * unit(i) / unit(j);
                worst = worst.max(if off.is_nan() { f64::INFINITY } else { off });
            }
        }
        for (k, g) in self.generators.iter().enumerate() {
            for part in 0..2 {
                let column = |i: usize, part: usize| t[(i, k + n * part)];
                let size =
                    (0..2 * n).fold(0.0_f64, |most, i| most.max(column(i, part).abs() * unit(i)));
                for i in 0..2 * n {
                    let moved = if i < n {
                        column(n + i, part)
                    } else {
                        -(0..n)
                            .map(|j| {
                                stiffness[(i - n) * n + j] * column(j, part)
                                    + damping[(i - n) * n + j] * column(n + j, part)
                            })
                            .sum::<f64>()
                    };
                    let predicted = g[0][part] * column(i, 0) + g[1][part] * column(i, 1);
                    let off = (moved - predicted).abs() * unit(i) / (rate * size);
                    worst = worst.max(if off.is_nan() { f64::INFINITY } else { off });
                }
            }
        }
        worst
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{OperatingPoint, fixtures};

    /// In every system, the maps to modes and back give the identity, and the blocks are those of `x' = A x`.
    /// A basis with an error of 1e-9 is refused.
    #[test]
    fn bases_take_systems_apart() {
        let structure = fixtures::structure(
            &[0.0, 900.0, 9000.0],
            0.01,
            &[1.0, 0.5, 0.4],
            &[1.0, 0.5, 0.4],
        );
        let (drive, load) = (fixtures::two_level_mesh(1e-5), 0.1);
        let model = Model::new(
            &structure,
            &drive,
            OperatingPoint {
                load,
                speed: 1200.0,
            },
        )
        .unwrap();
        let sets = Sets::new(&model).unwrap();
        let n = model.modes();
        for set in 0..sets.count() {
            let mut found = FoundBasis::new(&model, &sets, set).unwrap();
            let own = |found: &FoundBasis| {
                let frequency = [0.0_f64, 900.0, 9000.0];
                let (mut damping, mut stiffness) = (vec![0.0; n * n], vec![0.0; n * n]);
                for i in 0..n {
                    damping[i * n + i] = 0.02 * frequency[i];
                    stiffness[i * n + i] = frequency[i].powi(2);
                    for (_, class) in sets.closed(set) {
                        let gains = &model.directions[class.direction].gains;
                        for j in 0..n {
                            let product = gains[i].mesh_input[1] * gains[j].deflection[0];
                            damping[i * n + j] += class.damping * product;
                            stiffness[i * n + j] += class.stiffness * product;
                        }
                    }
                }
                found.error(&frequency, &damping, &stiffness)
            };
            let error = own(&found);
            assert!(error < 1e-13, "{set}: {error:e}");
            found.to_modes[(1, 1)] *= 1.0 + 1e-9;
            let error = own(&found);
            assert!(error > LARGEST_ERROR, "{set}: {error:e}");
        }
    }
}
