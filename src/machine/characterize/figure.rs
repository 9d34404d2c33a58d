//! Computes a figure from the times of the repetitions in several rounds.

use crate::numerics::statistics::student;
use crate::store::Figure;

/// Conversion of the time of a repetition to the value of a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// This work divided by the time.
    Rate(f64),
    /// The time divided by this number of pieces.
    Time(f64),
}

/// The figure of rounds of times \[s\]; `None` without a repetition. Its value is the median over the rounds of their
/// best repetitions.
pub fn figure(rounds: &[Vec<f64>], kind: Kind) -> Option<Figure> {
    let value = |time: f64| match kind {
        Kind::Rate(work) => work / time,
        Kind::Time(pieces) => time / pieces,
    };
    let of_round = |times: &Vec<f64>| times.iter().copied().reduce(f64::min);
    let of_rounds: Vec<f64> = rounds.iter().filter_map(of_round).map(value).collect();
    let mut all: Vec<f64> = rounds.iter().flatten().copied().map(value).collect();
    let best = match kind {
        Kind::Rate(_) => all.iter().copied().reduce(f64::max),
        Kind::Time(_) => all.iter().copied().reduce(f64::min),
    }?;
    Some(Figure {
        value: median(&mut of_rounds.clone()),
        best,
        median: median(&mut all),
        spread: spread(&of_rounds),
        rounds: of_rounds.len() as u64,
        repetitions: all.len() as u64,
    })
}

/// The median of values, which it sorts; NaN without values.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => f64::NAN,
        _ => 0.5 * (values[(n - 1) / 2] + values[n / 2]),
    }
}

/// Half the width of the 95 % prediction interval for one more value, divided by the mean of the values. The
/// interval is Student's, for normally distributed values. `None` for fewer than two values.
fn spread(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Some(student(values.len() - 1) * (variance * (1.0 + 1.0 / n)).sqrt() / mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Stream;

    #[test]
    fn a_round_gives_its_best_and_rounds_their_middle() {
        let rounds = [vec![4.0, 2.0], vec![8.0, 5.0, 9.0], vec![4.0]];
        let time = figure(&rounds, Kind::Time(2.0)).unwrap();
        assert_eq!((time.value, time.best, time.median), (2.0, 1.0, 2.25));
        assert_eq!((time.rounds, time.repetitions), (3, 6));
        let rate = figure(&rounds, Kind::Rate(40.0)).unwrap();
        assert_eq!((rate.value, rate.best), (10.0, 20.0));
        assert_eq!(figure(&[vec![1.0]], Kind::Time(1.0)).unwrap().spread, None);
        assert_eq!(figure(&[vec![]], Kind::Time(1.0)), None);
    }

    /// The next normal value is within the spread in 95 of 100 cases.
    #[test]
    fn the_spread_covers_the_next_value() {
        let mut stream = Stream::new(1, 2, 3);
        let mut covered = 0;
        for _ in 0..2000 {
            let values: Vec<f64> = (0..4).map(|_| 100.0 + stream.normal()).collect();
            let mean = values[..3].iter().sum::<f64>() / 3.0;
            let spread = spread(&values[..3]).unwrap() * mean;
            covered += usize::from((values[3] - mean).abs() <= spread);
        }
        assert!((1860..=1940).contains(&covered), "{covered} of 2000");
    }
}
