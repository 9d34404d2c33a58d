//! The deflection along a line on a block, as a series for each coordinate and input.

use crate::propagate::vectors::{LANES, Lanes, Row, TERMS};

/// Number of series that are added at once, each to a separate sum.
pub const AT_ONCE: usize = 4;

/// The deflection of a system along a line on a window: a series for each coordinate and input, sorted by the number of
/// significant groups of terms.
#[derive(Debug)]
pub struct Series(pub [Terms; GROUPS]);

/// Groups of terms of a series.
pub const GROUPS: usize = TERMS / LANES;

/// Series with the same number of groups of terms.
#[derive(Debug, Default)]
pub struct Terms {
    /// Indices of the series: coordinates first, then inputs.
    pub places: Vec<usize>,
    /// The groups, one series after another.
    pub rows: Vec<Lanes>,
}

impl Series {
    /// The series of all coordinates and inputs. Terms below round-off of the largest term of a series are omitted.
    pub fn new(rows: &[Row]) -> Self {
        let mut series = Self(Default::default());
        for (place, row) in rows.iter().enumerate() {
            let largest = row.0.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
            let matters = |a: &f64| a.abs() > 0.25 * f64::EPSILON * largest;
            let Some(last) = row.0.iter().rposition(matters) else {
                continue;
            };
            let terms = &mut series.0[last / LANES];
            terms.places.push(place);
            let groups = row.0.as_chunks().0.iter().copied().map(Lanes);
            terms.rows.extend(groups.take(last / LANES + 1));
        }
        for (g, terms) in series.0.iter_mut().enumerate() {
            // Series of zeros fill up the last group of [`AT_ONCE`] series.
            let count = terms.places.len().next_multiple_of(AT_ONCE);
            terms.places.resize(count, 0);
            terms.rows.resize(count * (g + 1), Lanes::ZERO);
        }
        series
    }
}
