//! How are the points of a grid with two axes numbered, if parts of the grid are halved repeatedly?
//!
//! Level 0 is a grid of `rows × columns` places. Level l divides each interval of level 0 into `2^l`
//! intervals. A place belongs to the first level that contains it. Places are numbered level by level, and
//! row by row within a level. Numbers do not change if further levels follow. The numbers of level 0 are
//! those of the grid without levels. Coordinates `[row, column]` count the intervals of the last level.

use serde::{Deserialize, Serialize};

/// A grid with two axes, whose intervals may be halved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct NestedGrid {
    /// Rows and columns of level 0, two or more each.
    pub coarse: [usize; 2],
    /// Number of times that its intervals may be halved.
    pub levels: u32,
}

/// A rectangle of the plane between four places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cell {
    /// Its smallest row and column.
    pub corner: [usize; 2],
    /// Its height and width in intervals of the last level, powers of two.
    pub sides: [usize; 2],
}

impl NestedGrid {
    /// Rows and columns of the grid after all intervals are halved `level` times.
    pub fn sides(&self, level: u32) -> [usize; 2] {
        self.coarse.map(|places| ((places - 1) << level) + 1)
    }

    /// Number of places of levels 0 to `level`.
    pub fn places(&self, level: u32) -> usize {
        let [rows, columns] = self.sides(level);
        rows * columns
    }

    /// The level of a place, from its number.
    pub fn level(&self, number: usize) -> u32 {
        (0..self.levels)
            .find(|&level| number < self.places(level))
            .unwrap_or(self.levels)
    }

    /// Row and column of a place, from its number.
    pub fn at(&self, number: usize) -> [usize; 2] {
        let level = self.level(number);
        let [_, columns] = self.sides(level);
        let [row, column] = match level.checked_sub(1) {
            None => [number / columns, number % columns],
            Some(before) => {
                // In the first row of each pair every second place already has a number.
                let between = self.sides(before)[1] - 1;
                let rest = number - self.places(before);
                let (pair, along) = (rest / (between + columns), rest % (between + columns));
                match along.checked_sub(between) {
                    None => [2 * pair, 2 * along + 1],
                    Some(along) => [2 * pair + 1, along],
                }
            }
        };
        [row, column].map(|along| along << (self.levels - level))
    }

    /// The number of a place.
    pub fn number(&self, [row, column]: [usize; 2]) -> usize {
        let halvings = (row | column).trailing_zeros().min(self.levels);
        let level = self.levels - halvings;
        let [row, column] = [row >> halvings, column >> halvings];
        let [_, columns] = self.sides(level);
        match level.checked_sub(1) {
            None => row * columns + column,
            Some(before) => {
                let between = self.sides(before)[1] - 1;
                let first = self.places(before) + row / 2 * (between + columns);
                match row % 2 {
                    0 => first + column / 2,
                    _ => first + between + column,
                }
            }
        }
    }

    /// The cells that are not divided further, row by row within each cell of level 0. A cell is halved along
    /// an axis if `known` is true for the middles of both its edges along this axis.
    pub fn leaves(&self, known: impl Fn([usize; 2]) -> bool) -> Vec<Cell> {
        let side = 1 << self.levels;
        let mut leaves = Vec::new();
        for row in 0..self.coarse[0] - 1 {
            for column in 0..self.coarse[1] - 1 {
                let corner = [row * side, column * side];
                let sides = [side; 2];
                let mut open = vec![Cell { corner, sides }];
                while let Some(cell) = open.pop() {
                    let halved = |&axis: &usize| {
                        let middles = cell.edges(axis).map(|[from, to]| middle(from, to));
                        cell.sides[axis] > 1 && middles.into_iter().all(&known)
                    };
                    match (0..2).find(halved) {
                        Some(axis) => open.extend(cell.halves(axis).into_iter().rev()),
                        None => leaves.push(cell),
                    }
                }
            }
        }
        leaves
    }
}

/// The place in the middle of an edge.
pub fn middle(from: [usize; 2], to: [usize; 2]) -> [usize; 2] {
    [0, 1].map(|axis| usize::midpoint(from[axis], to[axis]))
}

impl Cell {
    fn place(&self, rows: usize, columns: usize) -> [usize; 2] {
        [self.corner[0] + rows, self.corner[1] + columns]
    }

    /// Its corners, row by row.
    pub fn corners(&self) -> [[usize; 2]; 4] {
        let [rows, columns] = self.sides;
        [[0, 0], [0, columns], [rows, 0], [rows, columns]].map(|[r, c]| self.place(r, c))
    }

    /// The ends of its two edges along an axis: 0 down the rows, 1 across the columns.
    pub fn edges(&self, axis: usize) -> [[[usize; 2]; 2]; 2] {
        let [a, b, c, d] = self.corners();
        if axis == 0 { [[a, c], [b, d]] } else { [[a, b], [c, d]] }
    }

    /// The two cells of its division along an axis.
    fn halves(&self, axis: usize) -> [Self; 2] {
        let mut first = *self;
        first.sides[axis] /= 2;
        let mut second = first;
        second.corner[axis] += first.sides[axis];
        [first, second]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    const GRIDS: [NestedGrid; 3] = [
        NestedGrid {
            coarse: [3, 4],
            levels: 3,
        },
        NestedGrid {
            coarse: [2, 2],
            levels: 4,
        },
        NestedGrid {
            coarse: [5, 2],
            levels: 0,
        },
    ];

    #[test]
    fn every_place_has_one_number() {
        for grid in GRIDS {
            let all = grid.places(grid.levels);
            let places: BTreeSet<[usize; 2]> = (0..all).map(|number| grid.at(number)).collect();
            assert_eq!(places.len(), all);
            for number in 0..all {
                assert_eq!(grid.number(grid.at(number)), number);
            }
        }
    }

    /// The numbers of a grid do not change if levels are added.
    #[test]
    fn further_levels_leave_numbers_as_they_are() {
        for grid in GRIDS {
            for levels in 0..grid.levels {
                let fewer = NestedGrid { levels, ..grid };
                for number in 0..fewer.places(levels) {
                    let scaled = fewer.at(number).map(|c| c << (grid.levels - levels));
                    assert_eq!(scaled, grid.at(number));
                }
            }
            let [_, columns] = grid.coarse;
            let side = 1 << grid.levels;
            assert_eq!(grid.at(columns + 1), [side, side]);
        }
    }

    #[test]
    fn leaves_cover_the_plane_once() {
        let grid = GRIDS[0];
        // The grid is divided down to the last level around one place, and across the columns near the last
        // row.
        let known = |place: [usize; 2]| {
            let level = grid.level(grid.number(place));
            let reach = 2 << (grid.levels - level);
            place.iter().all(|&along| along.abs_diff(9) <= reach)
                || place[0] >= 8 && place[0].is_multiple_of(8)
        };
        let leaves = grid.leaves(known);
        let area: usize = leaves
            .iter()
            .map(|cell| cell.sides[0] * cell.sides[1])
            .sum();
        assert_eq!(area, 16 * 24);
        for sides in [[1, 1], [8, 8], [8, 1]] {
            assert!(leaves.iter().any(|cell| cell.sides == sides), "{sides:?}");
        }
        for cell in leaves {
            for axis in 0..2 {
                let mut middles = cell
                    .edges(axis)
                    .map(|[from, to]| middle(from, to))
                    .into_iter();
                assert!(cell.sides[axis] == 1 || !middles.all(known), "{cell:?}");
            }
        }
    }
}
