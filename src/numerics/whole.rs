//! Whole numbers.

/// The greatest common divisor (Euclid).
pub fn greatest_divisor(a: u128, b: u128) -> u128 {
    if b == 0 {
        a
    } else {
        greatest_divisor(b, a % b)
    }
}
