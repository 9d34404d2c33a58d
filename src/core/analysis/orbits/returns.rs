//! Which states of a path have the nearest returns?

/// Indices of the states of a path that return nearest after `period` steps, nearest first, at most `most`. No two are
/// within a period of each other. `apart` gives the distance of a state from its return; `places` are the indices of
/// all states with a return.
pub fn nearest(
    places: impl Iterator<Item = usize>,
    apart: impl Fn(usize) -> f64,
    period: usize,
    most: usize,
) -> Vec<usize> {
    let mut returns: Vec<(f64, usize)> = places.map(|n| (apart(n), n)).collect();
    returns.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let length = returns.iter().map(|(_, n)| n + 1).max().unwrap_or(0);
    let mut taken = vec![false; length];
    let mut chosen = Vec::new();
    for (_, n) in returns {
        if chosen.len() == most {
            break;
        }
        let near = n.saturating_sub(period)..(n + period + 1).min(length);
        if !taken[near].contains(&true) {
            taken[n] = true;
            chosen.push(n);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_come_first_and_none_is_within_a_period_of_another() {
        let apart = [5.0, 1.0, 0.5, 3.0, 2.0, 0.5, 4.0];
        let all = |period, most| nearest(0..apart.len(), |n| apart[n], period, most);
        assert_eq!(all(1, 9), [2, 5, 0]);
        assert_eq!(all(2, 9), [2, 5]);
        assert_eq!(all(1, 1), [2]);
        let even = nearest((0..apart.len()).step_by(2), |n| apart[n], 1, 9);
        assert_eq!(even, [2, 4, 6, 0]);
        assert!(nearest(0..0, |_| 0.0, 3, 4).is_empty());
    }
}
