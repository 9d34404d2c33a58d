//! The cubic that an observer sees on a step, as a Legendre series.

/// Legendre coefficients of the cubic through a value and its rate at both ends of a window.
///
/// From `p(±1) = a₀ ± a₁ + a₂ ± a₃` and `p'(±1) = a₁ ± 3 a₂ + 6 a₃`.
pub(super) fn hermite([p, left]: [f64; 2], [q, right]: [f64; 2], duration: f64) -> [f64; 4] {
    let (s, t) = (0.5 * duration * left, 0.5 * duration * right);
    let a2 = (t - s) / 6.0;
    let a3 = (0.5 * (s + t) - 0.5 * (q - p)) / 5.0;
    [0.5 * (p + q) - a2, 0.5 * (q - p) - a3, a2, a3]
}

/// Legendre coefficients of the time derivative of a cubic.
pub(super) fn derivative(a: [f64; 4], duration: f64) -> [f64; 4] {
    let scale = 2.0 / duration;
    [
        scale * (a[1] + a[3]),
        scale * 3.0 * a[2],
        scale * 5.0 * a[3],
        0.0,
    ]
}
