//! The points of a job, made when they are asked for: a grid of a million points takes no more
//! memory than its axes.

use super::spec::{
    AnalysesSpec, Axis, Carried, Direction, ExcitationSpec, MeshSpec, ModelSpec, PointSpec, RunSpec,
};
use std::sync::Arc;

/// Everything about a point but its load and speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// The structure.
    pub model: ModelSpec,
    /// The gear mesh.
    pub mesh: MeshSpec,
    /// Transmission error and torque ripple.
    pub excitation: Arc<ExcitationSpec>,
    /// How to march.
    pub run: Arc<RunSpec>,
    /// What to compute.
    pub analyses: Arc<AnalysesSpec>,
}

/// All points of a job, in `point_id` order.
#[derive(Debug, Clone)]
pub struct Points {
    /// One for each combination of values of the model keys, the last key fastest.
    variants: Vec<Variant>,
    /// Values of every axis: model keys, load, speed.
    values: Vec<Vec<f64>>,
    chains: Option<Chains>,
}

/// How points follow from each other along an axis.
#[derive(Debug, Clone)]
struct Chains {
    directions: Vec<Direction>,
    /// Places on the swept axis from its smallest value to its largest.
    ascending: Vec<usize>,
    /// Points of the row-major grid between neighbours on the swept axis.
    stride: usize,
}

impl Points {
    /// The grid of `axes` (model keys, then load, then speed), a variant for each combination of
    /// values of the model keys.
    pub(super) fn new(variants: Vec<Variant>, axes: &[Axis], carried: Option<&Carried>) -> Self {
        let values: Vec<Vec<f64>> = axes.iter().map(|axis| axis.values.clone()).collect();
        let chains = carried.map(|carried| {
            let swept = &values[carried.axis];
            let mut ascending: Vec<usize> = (0..swept.len()).collect();
            ascending.sort_by(|&a, &b| swept[a].total_cmp(&swept[b]));
            Chains {
                directions: carried.directions.clone(),
                ascending,
                stride: values[carried.axis + 1..].iter().map(Vec::len).product(),
            }
        });
        Self {
            variants,
            values,
            chains,
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        let directions = self.chains.as_ref().map_or(1, |c| c.directions.len());
        self.values.iter().map(Vec::len).product::<usize>() * directions
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What points differ in besides load and speed.
    pub fn variants(&self) -> &[Variant] {
        &self.variants
    }

    /// Where a point stands in the row-major grid, and which way its chain marches.
    fn place(&self, id: usize) -> (usize, Option<Direction>) {
        assert!(id < self.len(), "point {id} of {}", self.len());
        match &self.chains {
            None => (id, None),
            Some(chains) => chains.place(id),
        }
    }

    /// The variant of a place in the row-major grid.
    fn variant_of(&self, place: usize) -> &Variant {
        let inner: usize = self.values[self.keys()..].iter().map(Vec::len).product();
        &self.variants[place / inner]
    }

    /// Axes that are model keys.
    fn keys(&self) -> usize {
        self.values.len() - 2
    }

    /// The point with this `point_id`, but for its load and speed.
    ///
    /// # Panics
    /// There is none: `id` is not below [`Points::len`].
    pub fn variant(&self, id: usize) -> &Variant {
        self.variant_of(self.place(id).0)
    }

    /// The point with this `point_id`.
    ///
    /// # Panics
    /// There is none: `id` is not below [`Points::len`].
    pub fn at(&self, id: usize) -> PointSpec {
        let (place, direction) = self.place(id);
        let mut axis_values = vec![0.0; self.values.len()];
        let mut rest = place;
        for (value, values) in axis_values.iter_mut().zip(&self.values).rev() {
            *value = values[rest % values.len()];
            rest /= values.len();
        }
        let keys = self.keys();
        let Variant {
            model,
            mesh,
            excitation,
            run,
            analyses,
        } = self.variant_of(place).clone();
        PointSpec {
            point_id: id as u64,
            direction,
            load: axis_values[keys],
            speed: axis_values[keys + 1],
            axis_values,
            model,
            mesh,
            excitation,
            run,
            analyses,
        }
    }

    /// The first point, if there is one.
    pub fn first(&self) -> Option<PointSpec> {
        (!self.is_empty()).then(|| self.at(0))
    }

    /// All points, one after the other.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = PointSpec> {
        (0..self.len()).map(|id| self.at(id))
    }
}

impl Chains {
    /// Where a point stands in the row-major grid, and which way its chain marches.
    ///
    /// A *chain* is the points along the swept axis in marching order, all other axes and the
    /// direction held. Other axes vary slowest, then the direction (up before down), then the
    /// swept axis.
    fn place(&self, id: usize) -> (usize, Option<Direction>) {
        let length = self.ascending.len();
        let (chain, along) = (id / length, id % length);
        let (others, turn) = (chain / self.directions.len(), chain % self.directions.len());
        let direction = self.directions[turn];
        let index = match direction {
            Direction::Up => self.ascending[along],
            Direction::Down => self.ascending[length - 1 - along],
        };
        let (slower, faster) = (others / self.stride, others % self.stride);
        (
            (slower * length + index) * self.stride + faster,
            Some(direction),
        )
    }
}
