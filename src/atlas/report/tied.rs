//! Tied axes: axes of results that advance in step. The code also chooses which of them maps and curves use.

use super::point::Axis;
use crate::store::ResultTable;
use std::cmp::Reverse;

/// Two tied axes span a plane if at least one in `FILLED` of the combinations of their values has a point.
const FILLED: usize = 2;

/// A group of tied axes, by their indices. The axis with most values is first.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Group {
    axes: Vec<usize>,
    /// Two axes of the group that span a plane, if any; these two count as untied.
    plane: Option<[usize; 2]>,
}

/// The axes of results that advance in step.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tied(Vec<Group>);

impl Tied {
    /// The tied axes from the metadata of a table with `points` points.
    pub(super) fn of(head: &ResultTable, axes: &[Axis], points: usize) -> Self {
        let groups: Vec<Vec<String>> = (head.metadata("tied"))
            .and_then(|text| serde_json::from_str(text).ok())
            .unwrap_or_default();
        let place = |name: &String| axes.iter().position(|axis| axis.name == *name);
        let places = groups
            .iter()
            .map(|group| group.iter().filter_map(place).collect());
        Self::new(places.collect(), axes, points)
    }

    /// The tied axes of a table with this number of points; `groups` are indices into `axes`.
    fn new(groups: Vec<Vec<usize>>, axes: &[Axis], points: usize) -> Self {
        let length = |axis: usize| axes[axis].values.len().max(1);
        let untied =
            (0..axes.len()).filter(|axis| !groups.iter().any(|group| group.contains(axis)));
        let untied: usize = untied.map(length).product();
        let longest = |group: &Vec<usize>| group.iter().map(|&axis| length(axis)).max();
        let all = groups.iter().filter_map(longest).product::<usize>() * untied;
        let group = |mut group_axes: Vec<usize>| {
            let others = all / longest(&group_axes).unwrap_or(1);
            // The axis with most values comes first. Of axes with equally many values, the one with the largest
            // index comes first: it varies fastest from point to point.
            group_axes.sort_by_key(|&axis| Reverse((length(axis), axis)));
            let plane = match group_axes[..] {
                [first, second, ..] => Some([second, first]),
                _ => None,
            };
            Group {
                plane: plane.filter(|&[second, first]| {
                    length(second) > 1 && length(first) * length(second) * others <= FILLED * points
                }),
                axes: group_axes,
            }
        };
        Self(groups.iter().cloned().map(group).collect())
    }

    /// Indices of the fixed axes if the axes `free` vary; `axes` is the number of all axes. The fixed axes are all
    /// other axes with two exceptions. In a group without a plane, axes tied to a free one are not fixed. In a group
    /// with a plane, axes outside the plane are not fixed.
    pub(super) fn fixed_axes(&self, axes: usize, free: &[usize]) -> Vec<usize> {
        let with = |axis: usize, group: &Group| {
            group.axes.contains(&axis)
                && match group.plane {
                    Some(plane) => !plane.contains(&axis),
                    None => free.iter().any(|free_axis| group.axes.contains(free_axis)),
                }
        };
        let goes =
            |&axis: &usize| free.contains(&axis) || self.0.iter().any(|group| with(axis, group));
        (0..axes).filter(|axis| !goes(axis)).collect()
    }

    /// The axes for maps, slowest first. A group of tied axes contributes the two axes of its plane or, if it has no
    /// plane, the axis with most values.
    pub(super) fn free(&self, axes: usize) -> Vec<usize> {
        let chosen = |axis: &usize| {
            let containing = self.0.iter().find(|group| group.axes.contains(axis));
            containing.is_none_or(|group| match group.plane {
                Some(plane) => plane.contains(axis),
                None => group.axes.first() == Some(axis),
            })
        };
        (0..axes).filter(chosen).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(lengths: &[usize]) -> Vec<Axis> {
        let axis = |&length: &usize| Axis {
            name: "axis".to_owned(),
            unit: "1".to_owned(),
            values: (0..length).map(|i| i as f64).collect(),
        };
        lengths.iter().map(axis).collect()
    }

    #[test]
    fn without_ties_every_axis_is_free() {
        let tied = Tied::default();
        assert_eq!(tied.free(3), [0, 1, 2]);
        assert_eq!(tied.fixed_axes(3, &[2]), [0, 1]);
    }

    #[test]
    fn samples_beside_a_list_are_no_plane() {
        // A list of three loads and speeds, and four samples of two distributions at each.
        let both = Tied::new(vec![vec![0, 1], vec![2, 3]], &axes(&[3, 3, 4, 4]), 12);
        assert_eq!(both.free(4), [1, 3]);
        assert!(both.fixed_axes(4, &[1, 3]).is_empty());
    }

    #[test]
    fn a_list_goes_along_one_axis_unless_it_fills_a_plane() {
        let list = || vec![vec![0, 2, 3]];
        // Three half gaps, each with a list of twelve points along a course of loads and speeds.
        let course = Tied::new(list(), &axes(&[2, 3, 12, 12]), 36);
        assert_eq!(course.free(4), [1, 3]);
        assert!(course.fixed_axes(4, &[1, 3]).is_empty());
        assert_eq!(course.fixed_axes(4, &[2]), [1]);
        // The same list over a plane of four loads by three speeds, one point missing.
        let plane = Tied::new(list(), &axes(&[1, 3, 4, 3]), 33);
        assert_eq!(plane.free(4), [1, 2, 3]);
        assert_eq!(plane.fixed_axes(4, &[1, 2]), [3]);
        assert_eq!(plane.fixed_axes(4, &[3]), [1, 2]);
    }
}
