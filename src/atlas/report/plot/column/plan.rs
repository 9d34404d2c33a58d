//! The plan of a picture: its curves and their points, before they are drawn.

use std::collections::BTreeMap;
use std::iter;

use super::Source;
use super::series::Series;
use crate::report::plot::display::Scale;
use crate::report::plot::evidence::Evidence;
use crate::report::plot::motion::Motion;
use crate::report::plot::results::Slice;

/// A point of a curve, in shown values ([`Scale::shown`]). `low` and `high` are the ends of its error bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dot {
    pub x: f64,
    pub low: f64,
    pub value: f64,
    pub high: f64,
    /// Kind of motion, if pictures mark it ([`Motion::is_marked`]).
    pub marked: Option<Motion>,
}

/// Key of a curve in a picture. Its parts are the index of the series, the index of the value of the second
/// axis, the index of the source, and the direction of the sweep: 0 for independent points, 1 up, 2 down.
pub(super) type Key = [usize; 4];

/// A curve.
#[derive(Debug, Default)]
pub(super) struct Curve {
    pub dots: Vec<Dot>,
    pub scattered: bool,
    /// Some values have error bars.
    pub barred: bool,
}

/// The plan of a picture.
#[derive(Default)]
pub(super) struct Plan {
    pub words: Vec<Vec<String>>,
    pub points: usize,
    pub evidence: Evidence,
    /// Texts that name the companion axes of the sources, on which the points of a line have equal values.
    pub joins: Vec<String>,
    pub curves: BTreeMap<Key, Curve>,
}

/// The axes of the curves, as indices for each source: the axis along curves, and the second axis.
pub(super) struct Axes {
    pub over: Vec<usize>,
    pub by: Vec<Option<usize>>,
    /// Values of the second axis in all sources, ascending.
    pub values: Vec<f64>,
}

impl Plan {
    /// Adds the points of a slice of a source.
    pub fn take(
        &mut self,
        place: usize,
        source: &Source<'_>,
        slice: &Slice<'_>,
        series: &[Series],
        axes: &Axes,
        scale: &Scale,
    ) {
        let results = source.results;
        let fixed_values = slice
            .fixed_values
            .iter()
            .map(|&(axis, value)| results.axis_value_text(&results.summary.axes[axis], value));
        self.words.resize(place + 1, Vec::new());
        self.words[place] = fixed_values.collect();
        self.points += slice.points.len();
        let evidence = Evidence::of(slice.points.iter().copied());
        self.evidence = self.evidence.and(evidence);
        let over = axes.over[place];
        let axis = &results.summary.axes[over];
        let free: Vec<usize> = iter::once(over).chain(axes.by[place]).collect();
        let lines = results.lines(&free, &slice.points);
        let joins = results.lines_words(&free, &slice.points);
        if !joins.is_empty() && !self.joins.contains(&joins) {
            self.joins.push(joins);
        }
        // A missing point interrupts the line. Exceptions are refined grids, in which most points are
        // missing, and lists of tied values, in which only the listed points exist.
        let is_product =
            results.summary.refined.is_none() && results.companion_axes(&[over]).is_empty();
        let nowhere = |x: f64| Dot {
            x,
            low: f64::NAN,
            value: f64::NAN,
            high: f64::NAN,
            marked: None,
        };
        for (which, series) in series.iter().enumerate() {
            for line in &lines {
                let mut last: BTreeMap<Key, usize> = BTreeMap::new();
                for point in line.iter().map(|&place| slice.points[place]) {
                    let by = axes.by[place].map_or(0, |by| {
                        axes.values
                            .partition_point(|value| *value < point.axis_values[by])
                    });
                    let direction = match point.direction.as_deref() {
                        None => 0,
                        Some("down") => 2,
                        Some(_) => 1,
                    };
                    let key = [which, by, place, direction];
                    let curve = self.curves.entry(key).or_default();
                    curve.scattered = series.scattered;
                    let x = point.axis_values[over];
                    let rank = axis.place(x);
                    let is_apart = match last.insert(key, rank) {
                        Some(last) => is_product && rank > last + 1,
                        None => !curve.dots.is_empty(),
                    };
                    if is_apart {
                        curve.dots.push(nowhere(x));
                    }
                    let samples = results
                        .place(point.point_id)
                        .map(|place| series.samples.of(place));
                    let marked = Some(Motion::of(point)).filter(|motion| motion.is_marked());
                    let before = curve.dots.len();
                    for sample in samples.into_iter().flatten() {
                        let Some(value) = scale.shown(sample.value) else {
                            continue;
                        };
                        let [low, high] = scale.bar(sample.value, sample.error);
                        curve.barred |= sample.error > 0.0;
                        curve.dots.push(Dot {
                            x,
                            low,
                            value,
                            high,
                            marked,
                        });
                    }
                    if curve.dots.len() == before {
                        curve.dots.push(nowhere(x));
                    }
                }
            }
        }
    }

    /// The fixed values that all sources have in common, as text.
    pub fn shared_values(&self) -> Vec<String> {
        let Some((first, others)) = self.words.split_first() else {
            return Vec::new();
        };
        let is_common = |word: &&String| others.iter().all(|words| words.contains(word));
        first.iter().filter(is_common).cloned().collect()
    }

    /// The fixed values of a source that the other sources do not have, as text.
    pub fn distinct_values(&self, source: usize) -> Vec<String> {
        let shared_values = self.shared_values();
        let words = self.words.get(source).into_iter().flatten();
        words
            .filter(|word| !shared_values.contains(word))
            .cloned()
            .collect()
    }
}
