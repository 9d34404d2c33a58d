//! The eigenvectors of each system, and the products that lead from one to another.
//!
//! In modal displacements and velocities x a system obeys `x' = A x`, with
//! `A = [0 I; −W² − Σ k g wᵀ, −D − Σ c g wᵀ]`, sums over its closed contacts. Its coordinates z make A fall apart into
//! 2 × 2 blocks: `x = T z`, `z' = G z`. Neither speed nor load nor gap is in it. The coordinates of free flight are the
//! modes themselves.

use super::sets::Sets;
use crate::model::{Block, Model};
use crate::numerics::decoupling::decouple;
use crate::propagate::dense::{KeptReader, KeptWriter};
use crate::propagate::vectors::LANES;
use crate::propagate::{DenseError, TableArray, TableSize};
use faer::Mat;
use std::borrow::Cow;

/// Largest error of `A T = T G`, relative.
const LARGEST_ERROR: f64 = 1e-11;

/// Frequency by which rigid displacements are measured, relative to the fastest rate.
const SLOW: f64 = 1e-2;

/// Components of a state, padded: first ones in whole lane groups, then second ones.
pub fn padded(modes: usize) -> usize {
    modes.next_multiple_of(LANES)
}

/// A map between padded states: one column of `2 padded` numbers for each of the `2 modes` components.
#[derive(Debug, Clone)]
pub struct Map<'t> {
    /// Column after column.
    pub columns: Cow<'t, [f64]>,
}

/// The coordinates of a system.
#[derive(Debug, Clone)]
pub struct Basis<'t> {
    /// Blocks G, four numbers each \[1/s\].
    generators: Cow<'t, [f64]>,
    /// T and its inverse; none where the coordinates are the modes.
    maps: Option<[Map<'t>; 2]>,
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

    /// What leads to modes; nothing where the coordinates are these.
    pub fn to_modes(&self) -> Option<&Map<'t>> {
        self.maps.as_ref().map(|[to, _]| to)
    }

    /// What leads back from them.
    pub fn of_modes(&self) -> Option<&Map<'t>> {
        self.maps.as_ref().map(|[_, from]| from)
    }

    /// What a row over modal displacements is over padded coordinates.
    pub fn row(&self, felt: &[f64]) -> Vec<f64> {
        let (n, padded) = (felt.len(), padded(felt.len()));
        let mut row = vec![0.0; 2 * padded];
        match self.to_modes() {
            None => row[..n].copy_from_slice(felt),
            Some(map) => {
                for (j, column) in map.columns.chunks_exact(2 * padded).enumerate() {
                    let place = if j < n { j } else { padded + j - n };
                    row[place] = felt.iter().zip(column).map(|(w, t)| w * t).sum();
                }
            }
        }
        row
    }

    /// What modal forces are to the padded coordinates.
    pub fn input(&self, force: &[f64]) -> Vec<f64> {
        let (n, padded) = (force.len(), padded(force.len()));
        let mut out = vec![0.0; 2 * padded];
        match self.of_modes() {
            None => out[padded..padded + n].copy_from_slice(force),
            Some(map) => {
                // Forces act on velocities: the second half of the columns.
                let columns = map.columns.chunks_exact(2 * padded).skip(n);
                for (column, f) in columns.zip(force) {
                    for (sum, entry) in out.iter_mut().zip(column) {
                        *sum += entry * f;
                    }
                }
            }
        }
        out
    }
}

/// The bases of all systems of a structure and its mesh.
#[derive(Debug)]
pub struct Bases<'t> {
    bases: Vec<Basis<'t>>,
    /// Of each set: contact, state behind, the map.
    changes: Vec<Vec<(usize, usize, Map<'t>)>>,
}

impl<'t> Bases<'t> {
    /// Those handed over by [`arrays`].
    ///
    /// # Errors
    /// They are of another model.
    pub fn read(model: &Model, sets: &Sets, kept: &mut KeptReader<'t>) -> Result<Self, DenseError> {
        let n = model.modes();
        let mut out = Self {
            bases: Vec::new(),
            changes: Vec::new(),
        };
        for set in 0..sets.count() {
            let mut map = |name| -> Result<Map<'t>, DenseError> {
                let columns = kept.take(name, 4 * n * padded(n))?.into();
                Ok(Map { columns })
            };
            let maps = match set {
                Sets::FREE => None,
                _ => Some([map("to_modes")?, map("from_modes")?]),
            };
            let changes = between(sets, set)
                .map(|(contact, state)| Ok((contact, state, map("changes")?)))
                .collect::<Result<_, DenseError>>()?;
            out.changes.push(changes);
            let generators = kept.take("generators", 4 * n)?.into();
            out.bases.push(Basis { generators, maps });
        }
        Ok(out)
    }

    /// That of a set.
    pub fn of(&self, set: usize) -> &Basis<'t> {
        &self.bases[set]
    }

    /// What leads from a set to another one, in which a contact has another state; none where these are no neighbours.
    #[inline]
    pub fn change(&self, set: usize, to: usize, contact: usize, state: usize) -> Option<&Map<'t>> {
        // Free flight is in modes: other systems have what leads there and back.
        match (set, to) {
            (Sets::FREE, _) => self.bases[to].of_modes(),
            (_, Sets::FREE) => self.bases[set].to_modes(),
            _ => (self.changes[set].iter())
                .find(|(own, behind, _)| (*own, *behind) == (contact, state))
                .map(|(_, _, map)| map),
        }
    }
}

/// The changes out of a closed set that do not lead to free flight.
fn between(sets: &Sets, set: usize) -> impl Iterator<Item = (usize, usize)> {
    let closed = move |&(contact, state): &(usize, usize)| {
        set != Sets::FREE && sets.with(set, contact, state) != Sets::FREE
    };
    sets.changes(set).into_iter().filter(closed)
}

impl Bases<'static> {
    /// Computes them; modes are not coupled.
    ///
    /// # Errors
    /// As of [`arrays`].
    pub fn new(model: &Model, sets: &Sets) -> Result<Self, DenseError> {
        let found: Vec<Found> = (0..sets.count())
            .map(|set| Found::new(model, sets, set))
            .collect::<Result<_, _>>()?;
        let map = |matrix: &Mat<f64>| Map {
            columns: columns(matrix).into(),
        };
        let changes = (0..sets.count()).map(|set| {
            between(sets, set)
                .map(|(contact, state)| {
                    let to = &found[sets.with(set, contact, state)];
                    (
                        contact,
                        state,
                        map(&(&to.from_modes * &found[set].to_modes)),
                    )
                })
                .collect()
        });
        let bases = found.iter().enumerate().map(|(set, own)| Basis {
            generators: own.generators.as_flattened().as_flattened().to_vec().into(),
            maps: (set != Sets::FREE).then(|| [map(&own.to_modes), map(&own.from_modes)]),
        });
        Ok(Self {
            bases: bases.collect(),
            changes: changes.collect(),
        })
    }
}

/// Size of the arrays of so many modes.
pub fn size(modes: usize, sets: &Sets) -> TableSize {
    let maps = |set| match set {
        Sets::FREE => 0,
        _ => 2 + between(sets, set).count(),
    };
    let maps: usize = (0..sets.count()).map(maps).sum();
    TableSize {
        operators: sets.count(),
        bytes: 4 * modes * (maps * padded(modes) + sets.count()) * size_of::<f64>(),
        cells: 0,
    }
}

/// The bases of a model as arrays to be kept: they serve every speed, load and gap. Modes are not coupled.
///
/// # Errors
/// Eigenvectors too nearly parallel.
pub fn arrays(model: &Model, sets: &Sets) -> Result<Vec<TableArray>, DenseError> {
    let Bases { bases, changes } = Bases::new(model, sets)?;
    let mut out = KeptWriter::default();
    for (basis, changes) in bases.iter().zip(&changes) {
        if let Some([to, from]) = &basis.maps {
            out.push("to_modes", "mixed", &to.columns);
            out.push("from_modes", "mixed", &from.columns);
        }
        for (_, _, map) in changes {
            out.push("changes", "mixed", &map.columns);
        }
        out.push("generators", "1/s", &basis.generators);
    }
    Ok(out.finish())
}

/// A matrix as the columns of a [`Map`].
fn columns(matrix: &Mat<f64>) -> Vec<f64> {
    let n = matrix.nrows() / 2;
    let padded = padded(n);
    let mut out = vec![0.0; 4 * n * padded];
    for (j, column) in out.chunks_exact_mut(2 * padded).enumerate() {
        for i in 0..n {
            column[i] = matrix[(i, j)];
            column[padded + i] = matrix[(n + i, j)];
        }
    }
    out
}

/// The basis of one system.
struct Found {
    generators: Vec<[[f64; 2]; 2]>,
    to_modes: Mat<f64>,
    from_modes: Mat<f64>,
}

impl Found {
    fn new(model: &Model, sets: &Sets, set: usize) -> Result<Self, DenseError> {
        let n = model.modes();
        let generator = |i: usize| model.blocks[i].generator;
        let frequency: Vec<f64> = (0..n)
            .map(|i| (-generator(i)[1][0]).max(0.0).sqrt())
            .collect();
        let mut damping = vec![0.0; n * n];
        let mut stiffness = vec![0.0; n * n];
        for i in 0..n {
            damping[i * n + i] = -generator(i)[1][1];
        }
        for (_, class) in sets.closed(set) {
            let gains = &model.directions[class.direction].gains;
            for i in 0..n {
                for j in 0..n {
                    let felt = gains[i].mesh_input[1] * gains[j].deflection[0];
                    damping[i * n + j] += class.damping * felt;
                    stiffness[i * n + j] += class.stiffness * felt;
                }
            }
        }
        let found =
            decouple(&frequency, &damping, &stiffness).map_err(|_| DenseError::Defective {
                condition: f64::INFINITY,
                error: f64::INFINITY,
            })?;
        let square = |rows: &[f64]| Mat::from_fn(2 * n, 2 * n, |i, j| rows[2 * n * i + j]);
        let own = Self {
            generators: found.generators,
            to_modes: square(&found.to_structure),
            from_modes: square(&found.from_structure),
        };
        for i in 0..n {
            stiffness[i * n + i] += frequency[i].powi(2);
        }
        let error = own.error(&frequency, &damping, &stiffness);
        match error <= LARGEST_ERROR {
            true => Ok(own),
            false => Err(DenseError::Defective {
                error,
                condition: found.condition,
            }),
        }
    }

    /// Largest entry of `A T − T G`, by the fastest rate and the size of each column, and of `T T⁻¹ − I`; displacements are
    /// measured by their frequencies, rigid ones by a slow one.
    fn error(&self, frequency: &[f64], damping: &[f64], stiffness: &[f64]) -> f64 {
        let n = self.generators.len();
        let block = |generator: &[[f64; 2]; 2]| Block {
            generator: *generator,
            static_input: [0.0; 2],
        };
        let rates = self.generators.iter().map(|own| block(own).fastest());
        // A rotation alone has no rate.
        let rate = rates.fold(1.0, f64::max);
        let (t, inverse) = (&self.to_modes, &self.from_modes);
        let product = t * inverse;
        let unit = |i: usize| match i < n {
            true => frequency[i].max(SLOW * rate),
            false => 1.0,
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
                    let moved = match i < n {
                        true => column(n + i, part),
                        false => -(0..n)
                            .map(|j| {
                                stiffness[(i - n) * n + j] * column(j, part)
                                    + damping[(i - n) * n + j] * column(n + j, part)
                            })
                            .sum::<f64>(),
                    };
                    let own = g[0][part] * column(i, 0) + g[1][part] * column(i, 1);
                    let off = (moved - own).abs() * unit(i) / (rate * size);
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

    /// `x' = A x` in every system: what leads to modes and back is the identity, blocks are those of A; a basis that is
    /// off by 1e-9 is refused.
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
            let mut found = Found::new(&model, &sets, set).unwrap();
            let own = |found: &Found| {
                let frequency = [0.0_f64, 900.0, 9000.0];
                let (mut damping, mut stiffness) = (vec![0.0; n * n], vec![0.0; n * n]);
                for i in 0..n {
                    damping[i * n + i] = 0.02 * frequency[i];
                    stiffness[i * n + i] = frequency[i].powi(2);
                    for (_, class) in sets.closed(set) {
                        let gains = &model.directions[class.direction].gains;
                        for j in 0..n {
                            let felt = gains[i].mesh_input[1] * gains[j].deflection[0];
                            damping[i * n + j] += class.damping * felt;
                            stiffness[i * n + j] += class.stiffness * felt;
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
