//! The computed points that represent the places of a refined plane.
//!
//! In an undivided cell, the nearest corner represents a place. Thus a picture always shows computed results,
//! never interpolated ones.

use std::collections::HashMap;

use super::point::{Axis, PointSummary};
use crate::store::RefinedColumns;

/// A refined plane.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plane {
    /// Rows and columns of the finest grid.
    pub sides: [usize; 2],
    /// Number of intervals of the finest grid per interval of the undivided grid.
    pub step: usize,
    /// For every place, row by row, the index of the point that represents it. `u32::MAX` if there is none,
    /// because the run is unfinished.
    representatives: Vec<u32>,
}

impl Plane {
    /// The plane with these points; its indices of points are positions in `points`.
    pub fn new<'p>(
        refined: &RefinedColumns,
        points: impl IntoIterator<Item = &'p PointSummary>,
    ) -> Self {
        let nested = refined.nested;
        let sides @ [rows, columns] = nested.sides(nested.levels);
        let point_indices: HashMap<[usize; 2], u32> = (points.into_iter().zip(0..))
            .map(|(point, index)| (nested.at(point.point_id as usize), index))
            .collect();
        let mut representatives = vec![u32::MAX; rows * columns];
        let mut leaves = nested.leaves(|place| point_indices.contains_key(&place));
        // On an edge that two cells share, the smaller cell has priority.
        leaves.sort_by_key(|cell| std::cmp::Reverse(cell.sides[0] * cell.sides[1]));
        for cell in leaves {
            let [row, column] = cell.corner;
            let [height, width] = cell.sides;
            let corners = cell
                .corners()
                .map(|place| point_indices.get(&place).copied());
            for down in 0..=height {
                for across in 0..=width {
                    let nearest =
                        2 * usize::from(2 * down > height) + usize::from(2 * across > width);
                    if let Some(index) = corners[nearest] {
                        representatives[(row + down) * columns + column + across] = index;
                    }
                }
            }
        }
        // A computed place shows its own point, even if it lies on the edge of a smaller cell.
        for ([row, column], index) in point_indices {
            representatives[row * columns + column] = index;
        }
        Self {
            sides,
            step: 1 << nested.levels,
            representatives,
        }
    }

    /// The index of the point that represents a place; `None` if there is none.
    pub fn at(&self, row: usize, column: usize) -> Option<usize> {
        let index = self.representatives[row * self.sides[1] + column];
        (index != u32::MAX).then_some(index as usize)
    }
}

/// Gives the axes of a refined plane the values of its finest grid. Values without points are interpolated linearly.
pub(super) fn complete(axes: &mut [Axis], refined: &RefinedColumns, points: &[PointSummary]) {
    let nested = refined.nested;
    for (side, name) in refined.axes.iter().enumerate() {
        let Some(index) = axes.iter().position(|axis| axis.name == *name) else {
            continue;
        };
        let mut values = vec![None; nested.sides(nested.levels)[side]];
        for point in points {
            values[nested.at(point.point_id as usize)[side]] = Some(point.axis_values[index]);
        }
        axes[index].values = filled(&values);
    }
}

/// Fills the gaps of a list by linear interpolation. Gaps at its ends get the first or the last known value.
fn filled(values: &[Option<f64>]) -> Vec<f64> {
    let values_by_place: Vec<(usize, f64)> = (values.iter().enumerate())
        .filter_map(|(place, value)| Some((place, (*value)?)))
        .collect();
    let at = |place: usize| {
        let next = values_by_place.partition_point(|(other, _)| *other < place);
        match (
            next.checked_sub(1).map(|i| values_by_place[i]),
            values_by_place.get(next),
        ) {
            (_, Some(&(there, value))) if there == place => value,
            (Some((a, low)), Some(&(b, high))) => {
                low + (high - low) * (place - a) as f64 / (b - a) as f64
            }
            (Some((_, value)), None) | (None, Some(&(_, value))) => value,
            (None, None) => f64::NAN,
        }
    };
    (0..values.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::nested_grid::NestedGrid;

    fn point(nested: NestedGrid, place: [usize; 2]) -> PointSummary {
        PointSummary {
            point_id: nested.number(place) as u64,
            axis_values: place.map(|along| 10.0 * along as f64).to_vec(),
            ..PointSummary::default()
        }
    }

    /// One cell, of which a quarter is divided again.
    fn plane() -> (RefinedColumns, Vec<PointSummary>) {
        let nested = NestedGrid {
            coarse: [2, 2],
            levels: 3,
        };
        let coarse = [[0, 0], [0, 8], [8, 0], [8, 8]];
        let halves = [[0, 4], [4, 0], [4, 4], [4, 8], [8, 4]];
        let quarters = [[0, 2], [2, 0], [2, 2], [2, 4], [4, 2]];
        let places = coarse.into_iter().chain(halves).chain(quarters);
        let refined = RefinedColumns {
            nested,
            axes: ["load".into(), "speed".into()],
            by: "class".into(),
            start: "static".into(),
        };
        (refined, places.map(|place| point(nested, place)).collect())
    }

    #[test]
    fn the_nearest_corner_stands_for_a_place() {
        let (refined, points) = plane();
        let plane = Plane::new(&refined, &points);
        let representatives = |row, column| {
            let point = &points[plane.at(row, column).unwrap()];
            refined.nested.at(point.point_id as usize)
        };
        for point in &points {
            let place @ [row, column] = refined.nested.at(point.point_id as usize);
            assert_eq!(representatives(row, column), place);
        }
        assert_eq!(representatives(7, 7), [8, 8]);
        assert_eq!(representatives(5, 7), [4, 8]);
        assert_eq!(representatives(1, 3), [0, 2], "of a small cell");
        assert_eq!(representatives(3, 4), [2, 4], "the smaller of two cells");
        // Some points of a cancelled run are missing.
        let plane = Plane::new(&refined, &points[..3]);
        assert!(plane.at(7, 7).is_none() && plane.at(1, 1).is_some());
    }

    #[test]
    fn axes_have_all_values_of_the_finest_grid() {
        let (refined, points) = plane();
        let axis = |name: &str| Axis {
            name: name.into(),
            unit: "1".into(),
            values: vec![0.0],
        };
        let mut axes = [axis("load"), axis("speed")];
        complete(&mut axes, &refined, &points);
        for axis in axes {
            let wanted: Vec<f64> = (0..=8).map(|along| 10.0 * f64::from(along)).collect();
            assert_eq!(axis.values, wanted);
        }
    }
}
