//! A summary of the tables of followed orbits, in numbers.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Followed;

/// Followed orbits in numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FollowedSummary {
    /// The axis over which orbits are followed.
    pub over: String,
    /// Unit of this axis.
    pub unit: String,
    /// The second axis of the curves, if any.
    pub second: Option<String>,
    /// Smallest and largest value of the followed axis among the orbits.
    pub range: [f64; 2],
    /// Number of combinations of values of the other axes.
    pub lines: usize,
    /// Number of branches.
    pub branches: usize,
    /// Number of orbits on the branches.
    pub orbits: usize,
    /// Number of stable orbits among them.
    pub stable_orbits: usize,
    /// Bifurcations by kind.
    pub bifurcations: BTreeMap<String, usize>,
    /// Number of pairs of neighbouring orbits on a branch with different contact sequences.
    pub changes_of_sequence: usize,
    /// Ends of branches by reason.
    pub ends: BTreeMap<String, usize>,
    /// Curves by kind.
    pub curves: BTreeMap<String, usize>,
    /// Points of codimension two on them, by kind.
    pub codimension_two: BTreeMap<String, usize>,
}

impl FollowedSummary {
    /// The summary of followed orbits.
    pub(in crate::report) fn of(followed: &Followed) -> Self {
        let axis = followed.axis();
        let orbits = || followed.branches.values().flatten();
        let bifurcations = followed.bifurcations.iter().filter(|b| !b.is_end());
        let pairs = followed
            .branches
            .values()
            .flat_map(|branch| branch.windows(2));
        let ends = [axis.values.first(), axis.values.last()];
        Self {
            over: axis.name.clone(),
            unit: axis.unit.clone(),
            second: followed.second.map(|axis| followed.axes[axis].name.clone()),
            range: ends.map(|end| end.copied().unwrap_or_default()),
            lines: followed.lines().len(),
            branches: followed.branches.len(),
            orbits: orbits().count(),
            stable_orbits: orbits().filter(|orbit| orbit.stable).count(),
            bifurcations: count_words(bifurcations.map(|bifurcation| &bifurcation.kind[..])),
            changes_of_sequence: pairs
                .filter(|pair| !are_cyclic_shifts(&pair[0].sequence, &pair[1].sequence))
                .count(),
            ends: count_words(followed.bifurcations.iter().filter_map(|b| b.end())),
            curves: count_words(followed.curves.values().map(|curve| &curve.kind[..])),
            codimension_two: count_words(
                (followed.curves.values())
                    .flat_map(|curve| curve.codimension_two().map(|(_, note)| note)),
            ),
        }
    }
}

fn count_words<'a>(words: impl Iterator<Item = &'a str>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for word in words {
        *counts.entry(word.to_owned()).or_insert(0) += 1;
    }
    counts
}

/// Whether two contact sequences are cyclic shifts of each other.
fn are_cyclic_shifts(a: &str, b: &str) -> bool {
    let [a, b]: [Vec<&str>; 2] = [a, b].map(|text| text.split_whitespace().collect());
    let equal_after_shift = |shift: usize| a[shift..].iter().chain(&a[..shift]).eq(&b);
    a.len() == b.len() && (a.is_empty() || (0..a.len()).any(equal_after_shift))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_is_the_same_from_any_of_its_changes_on() {
        assert!(are_cyclic_shifts("1+ 1- 2+ 2-", "2+ 2- 1+ 1-"));
        assert!(are_cyclic_shifts("", ""));
        assert!(!are_cyclic_shifts("1+ 1- 2+ 2-", "1+ 2- 2+ 1-"));
        assert!(!are_cyclic_shifts("1+ 1-", "1+ 1- 1+ 1-"));
    }
}
