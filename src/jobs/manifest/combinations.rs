//! Numbers the combinations of values of the model keys of a grid; the last key varies fastest. Rows of a
//! list of points with equal values of all model keys are one combination.

use super::grid::GridAxis;
use super::grid_dimension::GridDimension;
use std::collections::{BTreeSet, HashMap};

/// Largest number of dimensions whose ends are combined with one another to form corners. In a corner, further
/// dimensions have the same end as the last combined one.
const MOST_CORNERED: u32 = 8;

/// The dimensions of the model keys of a grid.
#[derive(Debug)]
pub(super) struct Combinations {
    /// Number of positions along each dimension.
    pub lengths: Vec<usize>,
    /// The index in `lengths` of the dimension of each model key.
    of_keys: Vec<usize>,
    /// The groups of equal positions of each dimension; `None` if no values repeat.
    alike: Vec<Option<EqualPlaces>>,
}

/// Groups of positions along a dimension with equal values of all model keys.
#[derive(Debug)]
struct EqualPlaces {
    /// For each position, the first position with the same values.
    first: Vec<u32>,
    /// The first positions of all groups, ascending.
    distinct: Vec<u32>,
}

impl EqualPlaces {
    /// The groups of a dimension with several axes or samples; `None` if no values repeat.
    fn new(axes: &[GridAxis], dimension: &GridDimension) -> Option<Self> {
        if !dimension.is_tied() {
            return None;
        }
        let keys: Vec<_> = (dimension.axes.iter().map(|&axis| &axes[axis]))
            .filter(|axis| axis.is_model_key())
            .map(|axis| &axis.axis.values)
            .collect();
        let mut first_place = HashMap::<Vec<u64>, u32>::new();
        let mut values = Vec::new();
        let (mut first, mut distinct) = (Vec::with_capacity(dimension.length), Vec::new());
        for place in 0..dimension.length as u32 {
            values.clear();
            values.extend(keys.iter().map(|key| key.get(place as usize).to_bits()));
            if let Some(&known) = first_place.get(&values) {
                first.push(known);
                continue;
            }
            first_place.insert(values.clone(), place);
            first.push(place);
            distinct.push(place);
        }
        (distinct.len() < first.len()).then_some(Self { first, distinct })
    }
}

impl Combinations {
    pub fn new(axes: &[GridAxis], dimensions: &[GridDimension]) -> Self {
        let keys = (axes.iter().enumerate()).filter(|(_, axis)| axis.is_model_key());
        let own = || dimensions.iter().filter(|dimension| dimension.model_keys);
        Self {
            lengths: own().map(|dimension| dimension.length).collect(),
            of_keys: keys
                .map(|(axis, _)| GridDimension::of(dimensions, axis))
                .collect(),
            alike: own().map(|own| EqualPlaces::new(axes, own)).collect(),
        }
    }

    /// The index of the value of each model key in a combination.
    pub fn places(&self, number: usize) -> Vec<usize> {
        let places = GridDimension::places(&self.lengths, number);
        self.of_keys
            .iter()
            .map(|&dimension| places[dimension])
            .collect()
    }

    /// The number of the combination at these positions along the dimensions.
    fn number(&self, places: impl Iterator<Item = usize>) -> usize {
        (self.lengths.iter().zip(places)).fold(0, |number, (length, place)| number * length + place)
    }

    /// The smallest number of a combination with the same values.
    pub fn first_like(&self, number: usize) -> usize {
        if self.alike.iter().all(Option::is_none) {
            return number;
        }
        let places = GridDimension::places(&self.lengths, number);
        let first = places.iter().zip(&self.alike).map(|(&place, alike)| {
            (alike.as_ref()).map_or(place, |alike| alike.first[place] as usize)
        });
        self.number(first)
    }

    /// Number of different values along each dimension.
    pub fn distinct(&self) -> Vec<usize> {
        let each = self.lengths.iter().zip(&self.alike);
        each.map(|(&length, alike)| alike.as_ref().map_or(length, |alike| alike.distinct.len()))
            .collect()
    }

    /// The numbers of all combinations with different values. `distinct` is the number of different values
    /// along each dimension.
    pub fn each(&self, distinct: Vec<usize>) -> impl Iterator<Item = usize> + use<'_> {
        (0..distinct.iter().product()).map(move |nth| {
            let places = GridDimension::places(&distinct, nth).into_iter();
            self.number(places.zip(&self.alike).map(|(place, alike)| {
                (alike.as_ref()).map_or(place, |alike| alike.distinct[place] as usize)
            }))
        })
    }
}

/// Numbers of the combinations among `all` that are resolved in advance: the corners, and `budget` evenly spaced ones.
pub(super) fn chosen(all: usize, budget: usize, lengths: &[usize]) -> Vec<usize> {
    let cornered = lengths
        .len()
        .min(budget.ilog2().min(MOST_CORNERED) as usize);
    let corner = |ends: usize| {
        (lengths.iter().enumerate()).fold(0, |number, (axis, length)| {
            let high = ends >> axis.min(cornered - 1) & 1 == 1;
            number * length + if high { length - 1 } else { 0 }
        })
    };
    let even = (0..budget).map(|i| (i as u128 * all as u128 / budget as u128) as usize);
    let numbers: BTreeSet<usize> = (0..1 << cornered).map(corner).chain(even).collect();
    numbers.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two dimensions; values repeat along the second one.
    #[test]
    fn rows_that_are_alike_are_one_combination() {
        let combinations = Combinations {
            lengths: vec![2, 4],
            of_keys: vec![0, 1],
            alike: vec![
                None,
                Some(EqualPlaces {
                    first: vec![0, 1, 0, 1],
                    distinct: vec![0, 1],
                }),
            ],
        };
        let first: Vec<usize> = (0..8).map(|n| combinations.first_like(n)).collect();
        assert_eq!(first, [0, 1, 0, 1, 4, 5, 4, 5]);
        assert_eq!(combinations.distinct(), [2, 2]);
        let each: Vec<usize> = combinations.each(vec![2, 2]).collect();
        assert_eq!(each, [0, 1, 4, 5]);
    }
}
