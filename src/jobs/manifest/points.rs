//! The points of a job, computed on demand: a grid of ten million points needs no more memory than its axes and the
//! combinations that were resolved in advance.

use super::axis::{Ascending, AxisKey, AxisValues};
use super::expand::Expansion;
use super::grid_dimension::GridDimension;
use super::schema;
use super::spec::{Axis, Carried, Direction, PointSpec, Variant};
use crate::numerics::nested_grid::NestedGrid;

/// All points of a job, in `point_id` order.
#[derive(Debug, Clone)]
pub struct Points {
    /// Combinations of values of the model keys, the last key fastest.
    variants: Expansion,
    /// Values of every axis: model keys, load or torque, speed.
    values: Vec<AxisValues>,
    /// The dimensions of the axes, those that vary model keys first.
    dimensions: Vec<GridDimension>,
    /// Quantity of the last axis but one: load or torque.
    load: AxisKey,
    /// Seed of the random streams of points, unless an axis gives it.
    seed: u64,
    seed_axis: Option<usize>,
    chains: Option<Chains>,
    /// Numbering of the points of a refined grid.
    nested: Option<NestedGrid>,
}

/// The chains of points along an axis.
#[derive(Debug, Clone)]
struct Chains {
    directions: Vec<Direction>,
    /// Places along the swept dimension, ordered by the values of the swept axis.
    ascending: Ascending,
    /// Distance in the row-major grid between neighbours along the swept dimension.
    stride: usize,
}

impl Points {
    /// The grid of `axes` (model keys, then load or torque, then speed) along `dimensions`, with one variant per
    /// combination of values of the model keys; `nested` numbers the points of a refined grid.
    pub(super) fn new(
        variants: Expansion,
        seed: u64,
        axes: &[Axis],
        dimensions: &[GridDimension],
        carried: Option<&Carried>,
        nested: Option<NestedGrid>,
    ) -> Self {
        let values: Vec<AxisValues> = axes.iter().map(|axis| axis.values.clone()).collect();
        let chains = carried.map(|carried| {
            let swept = GridDimension::of(dimensions, carried.axis);
            Chains {
                directions: carried.directions.clone(),
                ascending: values[carried.axis].ascending(),
                stride: GridDimension::product(&dimensions[swept + 1..]),
            }
        });
        let load = axes
            .len()
            .checked_sub(2)
            .map(|place| axes[place].key.clone());
        Self {
            variants,
            values,
            dimensions: dimensions.to_vec(),
            load: load.unwrap_or(AxisKey::Load),
            seed,
            seed_axis: axes.iter().position(|axis| axis.name() == schema::SEED),
            chains,
            nested,
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        let directions = self.chains.as_ref().map_or(1, |c| c.directions.len());
        GridDimension::product(&self.dimensions) * directions
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The variants of points, which differ by model keys. In a grid with very many combinations, these are
    /// only the combinations that were resolved in advance, among them the ends of all axes.
    pub fn variants(&self) -> &[Variant] {
        self.variants.judged()
    }

    /// The position of a point in the row-major grid, and the direction of its chain.
    fn place(&self, id: usize) -> (usize, Option<Direction>) {
        assert!(id < self.len(), "point {id} of {}", self.len());
        match (&self.chains, &self.nested) {
            (Some(chains), _) => chains.place(id),
            (None, Some(nested)) => {
                let ([row, column], [_, columns]) = (nested.at(id), nested.sides(nested.levels));
                (row * columns + column, None)
            }
            (None, None) => (id, None),
        }
    }

    /// The combination of model keys at a position in the row-major grid.
    fn combination(&self, place: usize) -> usize {
        let inside = self
            .dimensions
            .iter()
            .filter(|dimension| !dimension.model_keys);
        place / inside.map(|dimension| dimension.length).product::<usize>()
    }

    /// Number of axes that are model keys.
    fn keys(&self) -> usize {
        self.values.len() - 2
    }

    /// The variant of this point if it was resolved in advance, otherwise one near it with about as much
    /// work. Resolves nothing.
    ///
    /// # Panics
    /// `id` is not below [`Points::len`].
    pub fn variant_near(&self, id: usize) -> &Variant {
        self.variants.near(self.combination(self.place(id).0))
    }

    /// The point with this `point_id`.
    ///
    /// # Panics
    /// `id` is not below [`Points::len`].
    pub fn at(&self, id: usize) -> PointSpec {
        let (place, direction) = self.place(id);
        let mut axis_values = vec![0.0; self.values.len()];
        let lengths: Vec<usize> = self
            .dimensions
            .iter()
            .map(|dimension| dimension.length)
            .collect();
        for (dimension, along) in
            (self.dimensions.iter()).zip(GridDimension::places(&lengths, place))
        {
            for &axis in &dimension.axes {
                axis_values[axis] = self.values[axis].get(along);
            }
        }
        let keys = self.keys();
        let (variant, fault) = self.variants.get(self.combination(place));
        let Variant {
            model,
            mesh,
            excitation,
            run,
            analyses,
        } = variant.into_owned();
        let load = match self.load {
            AxisKey::Torque => model.load_of_torque(axis_values[keys]),
            _ => axis_values[keys],
        };
        PointSpec {
            point_id: id as u64,
            direction,
            seed: (self.seed_axis).map_or(self.seed, |axis| axis_values[axis] as u64),
            load,
            speed: axis_values[keys + 1],
            axis_values,
            model,
            mesh,
            excitation,
            run,
            analyses,
            fault,
        }
    }

    /// The first point, if there is one.
    pub fn first(&self) -> Option<PointSpec> {
        (!self.is_empty()).then(|| self.at(0))
    }

    /// All points, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = PointSpec> {
        (0..self.len()).map(|id| self.at(id))
    }
}

impl Chains {
    /// The position of a point in the row-major grid, and the direction of its chain.
    ///
    /// A *chain* has all points along the swept axis in sweep order, with the same values of other axes and the same
    /// direction. Other axes vary slowest, then the direction (up before down), then the swept axis.
    fn place(&self, id: usize) -> (usize, Option<Direction>) {
        let length = self.ascending.len();
        let (chain, along) = (id / length, id % length);
        let (others, turn) = (chain / self.directions.len(), chain % self.directions.len());
        let direction = self.directions[turn];
        let index = match direction {
            Direction::Up => self.ascending.place(along),
            Direction::Down => self.ascending.place(length - 1 - along),
        };
        let (slower, faster) = (others / self.stride, others % self.stride);
        (
            (slower * length + index) * self.stride + faster,
            Some(direction),
        )
    }
}
