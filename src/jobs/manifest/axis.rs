//! The values of a grid axis, computed on demand: an even range of ten million values needs no more memory than its
//! ends.

use serde::{Serialize, Serializer};
use std::sync::Arc;

/// The quantity that an axis varies.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub enum AxisKey {
    /// A dotted key of the manifest (`mesh.half_gap`).
    Key(String),
    /// Fraction of the rated mesh force.
    Load,
    /// Speed of the pinion \[rad/s\].
    Speed,
    /// Torque on the pinion \[N m\].
    Torque,
}

impl AxisKey {
    /// The quantity of an axis with this name.
    pub(super) fn of(name: &str) -> Self {
        match name {
            "load" => Self::Load,
            "torque" => Self::Torque,
            "speed" => Self::Speed,
            key => Self::Key(key.to_owned()),
        }
    }

    /// Name in manifests and result files.
    pub fn name(&self) -> &str {
        match self {
            Self::Key(key) => key,
            Self::Load => "load",
            Self::Torque => "torque",
            Self::Speed => "speed",
        }
    }

    /// Sort key of axes: first model keys by name, then load or torque, then speed.
    pub(super) fn rank(&self) -> (u8, &str) {
        match self {
            Self::Key(key) => (0, key),
            Self::Load | Self::Torque => (1, ""),
            Self::Speed => (2, ""),
        }
    }

    /// Whether the axis varies a model key instead of the operating point (load, torque, speed).
    pub fn is_model_key(&self) -> bool {
        matches!(self, Self::Key(_))
    }
}

/// The values of an axis in SI; at least one.
#[derive(Debug, Clone)]
pub struct AxisValues(Form);

#[derive(Debug, Clone)]
enum Form {
    Each(Arc<[f64]>),
    Even {
        from: f64,
        to: f64,
        count: usize,
        logarithmic: bool,
    },
}

/// Serialises the values, independent of their form in the manifest.
impl Serialize for AxisValues {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

impl AxisValues {
    /// Values given one by one.
    pub(super) fn each(values: Vec<f64>) -> Self {
        Self(Form::Each(values.into()))
    }

    /// `count` values from `from` to `to`, evenly spaced, or with equal ratios if `logarithmic`. Both ends
    /// are exact.
    pub(super) fn even(from: f64, to: f64, count: usize, logarithmic: bool) -> Self {
        Self(Form::Even {
            from,
            to,
            count,
            logarithmic,
        })
    }

    /// This range with each interval halved `times` times. Existing values keep their bits. `None` for listed
    /// values and for a single value.
    pub(super) fn halved(&self, times: u32) -> Option<Self> {
        match &self.0 {
            Form::Even {
                from,
                to,
                count,
                logarithmic,
            } if *count > 1 => {
                let count = ((count - 1) << times) + 1;
                Some(Self::even(*from, *to, count, *logarithmic))
            }
            _ => None,
        }
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        match &self.0 {
            Form::Each(values) => values.len(),
            Form::Even { count, .. } => *count,
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The i-th value.
    ///
    /// # Panics
    /// `i` is not below [`AxisValues::len`].
    pub fn get(&self, i: usize) -> f64 {
        let (from, to, count, logarithmic) = match &self.0 {
            Form::Each(values) => return values[i],
            Form::Even {
                from,
                to,
                count,
                logarithmic,
            } => (*from, *to, *count, *logarithmic),
        };
        assert!(i < count, "value {i} of {count}");
        let last = count - 1;
        if i == 0 {
            return from;
        }
        if i == last {
            return to;
        }
        let (i, last) = (i as f64, last as f64);
        if logarithmic {
            from * (to / from).powf(i / last)
        } else {
            ((last - i) * from + i * to) / last
        }
    }

    /// All values, in the order of the grid.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = f64> + use<'_> {
        (0..self.len()).map(|i| self.get(i))
    }

    /// Smallest and largest value.
    pub fn ends(&self) -> (f64, f64) {
        match &self.0 {
            Form::Each(values) => values
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
                    (low.min(value), high.max(value))
                }),
            Form::Even { from, to, .. } => (from.min(*to), from.max(*to)),
        }
    }

    /// Whether there are different values.
    pub(super) fn vary(&self) -> bool {
        let (low, high) = self.ends();
        low < high
    }

    /// The indices of the values, from the smallest value to the largest.
    pub(super) fn ascending(&self) -> Ascending {
        match &self.0 {
            Form::Each(values) => {
                let mut places: Vec<usize> = (0..values.len()).collect();
                places.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
                Ascending(Ranks::Listed(places.into()))
            }
            Form::Even {
                from, to, count, ..
            } => Ascending(Ranks::Even {
                count: *count,
                descends: to < from,
            }),
        }
    }
}

impl PartialEq for AxisValues {
    fn eq(&self, other: &Self) -> bool {
        self.len() == other.len() && self.iter().eq(other.iter())
    }
}

/// The indices of an axis's values, smallest value first.
#[derive(Debug, Clone)]
pub(super) struct Ascending(Ranks);

#[derive(Debug, Clone)]
enum Ranks {
    Listed(Arc<[usize]>),
    Even { count: usize, descends: bool },
}

impl Ascending {
    pub fn len(&self) -> usize {
        match &self.0 {
            Ranks::Listed(places) => places.len(),
            Ranks::Even { count, .. } => *count,
        }
    }

    /// The index of the value with this rank. Rank 0 is the smallest value.
    pub fn place(&self, rank: usize) -> usize {
        match &self.0 {
            Ranks::Listed(places) => places[rank],
            Ranks::Even {
                count,
                descends: true,
            } => count - 1 - rank,
            Ranks::Even { .. } => rank,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(from: f64, to: f64, count: usize, logarithmic: bool) -> Vec<f64> {
        AxisValues::even(from, to, count, logarithmic)
            .iter()
            .collect()
    }

    #[test]
    fn ends_are_exact_and_steps_even() {
        let linear = samples(0.05, 0.30, 6, false);
        assert_eq!((linear[0], linear[5]), (0.05, 0.30));
        for (value, wanted) in linear.iter().zip([0.05, 0.10, 0.15, 0.20, 0.25, 0.30]) {
            assert!((value - wanted).abs() < 1e-16, "{value} {wanted}");
        }
        let whole = samples(600.0, 1500.0, 10, false);
        assert_eq!(whole[3], 900.0);
        let log = samples(5e-6, 5e-5, 3, true);
        assert_eq!((log[0], log[2]), (5e-6, 5e-5));
        assert!((log[1] / (5e-6 * 10f64.sqrt()) - 1.0).abs() < 1e-15);
        assert_eq!(samples(3.0, 3.0, 1, true), [3.0]);
    }

    #[test]
    fn halved_ranges_keep_their_values() {
        for (from, to, count, logarithmic) in [(0.05, 0.30, 9, false), (5e-6, 5e-5, 4, true)] {
            let coarse = AxisValues::even(from, to, count, logarithmic);
            let fine = coarse.halved(5).unwrap();
            assert_eq!(fine.len(), 32 * (count - 1) + 1);
            for i in 0..count {
                assert_eq!(fine.get(32 * i), coarse.get(i));
            }
        }
        assert!(AxisValues::each(vec![1.0, 2.0]).halved(1).is_none());
        assert!(AxisValues::even(3.0, 3.0, 1, false).halved(1).is_none());
    }

    #[test]
    fn ranks_are_those_of_the_values_written_out() {
        for (from, to) in [(1.0, 9.0), (9.0, 1.0)] {
            let even = AxisValues::even(from, to, 5, false);
            let written = AxisValues::each(even.iter().collect());
            assert_eq!(even, written);
            assert_eq!(even.ends(), written.ends());
            let ranks = |values: &AxisValues| -> Vec<usize> {
                let places = values.ascending();
                (0..places.len()).map(|rank| places.place(rank)).collect()
            };
            assert_eq!(ranks(&even), ranks(&written));
        }
    }
}
