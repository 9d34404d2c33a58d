//! Divisors and multiples of integers.

/// The greatest common divisor (Euclid).
pub fn greatest_divisor(a: u128, b: u128) -> u128 {
    if b == 0 { a } else { greatest_divisor(b, a % b) }
}

/// The least common multiple of two positive numbers; `usize::MAX` if it is larger than that.
pub fn least_multiple(a: usize, b: usize) -> usize {
    let divisor = greatest_divisor(a as u128, b as u128) as usize;
    (a / divisor).saturating_mul(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_that_are_too_large_stay_so() {
        assert_eq!(
            [(4, 6), (1, 7), (9, 9)].map(|(a, b)| least_multiple(a, b)),
            [12, 7, 9]
        );
        let large = (900..=1000).fold(1, least_multiple);
        assert!(large > usize::MAX / 2, "{large}");
    }
}
