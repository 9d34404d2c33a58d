//! Do two runs of `atlas machine` agree? Figure by figure, within the spread that each states.

use crate::store::{Characteristics, Figure};
use serde::Serialize;
use std::collections::BTreeMap;

/// One figure of two runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// What was measured.
    pub what: String,
    /// The first run's value.
    pub a: f64,
    /// The second run's value.
    pub b: f64,
    /// b over a.
    pub ratio: f64,
    /// Part of the value within which they should agree; absent where neither run can tell.
    pub spread: Option<f64>,
    /// Whether they do.
    pub agrees: Option<bool>,
}

/// Two runs, figure by figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Figures of both.
    pub pairs: Vec<Pair>,
    /// Figures of the first only.
    pub only_a: usize,
    /// Figures of the second only.
    pub only_b: usize,
}

impl Comparison {
    /// Figures that agree, and those of which that can be said.
    pub fn agreeing(&self) -> (usize, usize) {
        let said = self.pairs.iter().filter_map(|pair| pair.agrees);
        (said.clone().filter(|agrees| *agrees).count(), said.count())
    }

    /// Of each measurement (the words before the first comma): its name, figures, the middle
    /// of b over a, and how many agree of how many that can be judged.
    pub fn by_kind(&self) -> Vec<(String, usize, f64, usize, usize)> {
        let mut kinds: BTreeMap<&str, Vec<&Pair>> = BTreeMap::new();
        for pair in &self.pairs {
            let kind = pair.what.split(',').next().unwrap_or_default();
            kinds.entry(kind).or_default().push(pair);
        }
        (kinds.into_iter())
            .map(|(kind, pairs)| {
                let mut ratios: Vec<f64> = pairs.iter().map(|pair| pair.ratio).collect();
                let judged = pairs.iter().filter_map(|pair| pair.agrees);
                let agreeing = judged.clone().filter(|agrees| *agrees).count();
                let middle = super::figure::median(&mut ratios);
                (
                    kind.to_owned(),
                    pairs.len(),
                    middle,
                    agreeing,
                    judged.count(),
                )
            })
            .collect()
    }
}

/// Compares two runs.
pub fn compare(a: &Characteristics, b: &Characteristics) -> Comparison {
    let figures = |run: &Characteristics| -> BTreeMap<_, _> { run.figures().collect() };
    let (a, b) = (figures(a), figures(b));
    let pairs: Vec<Pair> = (a.iter())
        .filter_map(|(what, a)| Some(pair(what, a, b.get(what)?)))
        .collect();
    Comparison {
        only_a: a.len() - pairs.len(),
        only_b: b.len() - pairs.len(),
        pairs,
    }
}

fn pair(what: &str, a: &Figure, b: &Figure) -> Pair {
    // Each spread is that of a value of its own run; the wider one has seen more.
    let spread = [a.spread, b.spread].into_iter().flatten().reduce(f64::max);
    let ratio = b.value / a.value;
    Pair {
        what: what.to_owned(),
        a: a.value,
        b: b.value,
        ratio,
        spread,
        agrees: spread.map(|spread| (a.value - b.value).abs() <= spread * a.value.max(b.value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(value: f64, spread: Option<f64>) -> Figure {
        Figure {
            value,
            best: value,
            median: value,
            spread,
            rounds: 3,
            repetitions: 9,
        }
    }

    #[test]
    fn figures_agree_within_the_wider_spread() {
        let near = pair("x", &figure(100.0, Some(0.01)), &figure(104.0, Some(0.05)));
        assert_eq!(near.agrees, Some(true));
        assert_eq!(near.ratio, 1.04);
        let far = pair("x", &figure(100.0, Some(0.01)), &figure(104.0, Some(0.02)));
        assert_eq!(far.agrees, Some(false));
        let unknown = pair("x", &figure(100.0, None), &figure(104.0, None));
        assert_eq!((unknown.agrees, unknown.spread), (None, None));
        let comparison = Comparison {
            pairs: vec![near, far, unknown],
            only_a: 0,
            only_b: 1,
        };
        assert_eq!(comparison.agreeing(), (1, 2));
        assert_eq!(comparison.by_kind(), [("x".to_owned(), 3, 1.04, 1, 2)]);
    }
}
