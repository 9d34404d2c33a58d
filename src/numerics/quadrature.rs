//! Gauss–Legendre nodes and weights.

use std::f64::consts::PI;

/// Gauss–Legendre rule on \[−1, 1\]: exact for polynomials up to degree `2n − 1`.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussLegendre {
    /// Nodes, ascending.
    pub nodes: Vec<f64>,
    /// Weights; they sum to 2.
    pub weights: Vec<f64>,
}

impl GaussLegendre {
    /// The rule with `n ≥ 1` nodes, by Newton's iteration on `P_n` from Tricomi's guess.
    pub fn new(n: usize) -> Self {
        let mut nodes = vec![0.0; n];
        let mut weights = vec![0.0; n];
        for i in 0..n.div_ceil(2) {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            // Quadratic convergence from a guess good to 1e-4: five steps reach round-off.
            for _ in 0..6 {
                let (p, dp) = legendre_and_derivative(n, x);
                x -= p / dp;
            }
            let (_, dp) = legendre_and_derivative(n, x);
            let weight = 2.0 / ((1.0 - x * x) * dp * dp);
            nodes[i] = -x;
            nodes[n - 1 - i] = x;
            weights[i] = weight;
            weights[n - 1 - i] = weight;
        }
        if n % 2 == 1 {
            nodes[n / 2] = 0.0;
        }
        Self { nodes, weights }
    }
}

/// `(P_n(x), P_n'(x))` for |x| < 1 by the three-term recurrence.
fn legendre_and_derivative(n: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut current) = (1.0, x);
    if n == 0 {
        return (1.0, 0.0);
    }
    for k in 1..n {
        let k = k as f64;
        let next = ((2.0 * k + 1.0) * x * current - k * previous) / (k + 1.0);
        previous = current;
        current = next;
    }
    let derivative = n as f64 * (x * current - previous) / (x * x - 1.0);
    (current, derivative)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_monomials_exactly() {
        for n in [1, 2, 5, 16, 33, 64] {
            let rule = GaussLegendre::new(n);
            for degree in 0..2 * n {
                let sum: f64 = rule
                    .nodes
                    .iter()
                    .zip(&rule.weights)
                    .map(|(x, w)| w * x.powi(degree as i32))
                    .sum();
                let exact = if degree % 2 == 0 {
                    2.0 / (degree as f64 + 1.0)
                } else {
                    0.0
                };
                assert!((sum - exact).abs() < 4e-15, "n {n} degree {degree}: {sum}");
            }
        }
    }
}
