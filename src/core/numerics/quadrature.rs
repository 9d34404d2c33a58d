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
    /// The rule with `n ≥ 1` nodes, by Newton's iteration on `P_n` from Tricomi's guess. The unknown is the
    /// distance y = 1 − x from the end. It also gives the weight `2 / ((1 − x²) P_n'²)`. With a rounded x the
    /// weight would lose the digits that cancel in 1 − x²: three digits with 64 nodes.
    pub fn new(n: usize) -> Self {
        let mut nodes = vec![0.0; n];
        let mut weights = vec![0.0; n];
        for i in 0..n.div_ceil(2) {
            let half_angle = 0.5 * PI * (i as f64 + 0.75) / (n as f64 + 0.5);
            let mut y = 2.0 * half_angle.sin().powi(2);
            // The error of the guess is 1e-4, and convergence is quadratic: six steps are more than enough.
            for _ in 0..6 {
                let (p, dp) = legendre_and_derivative(n, y);
                y += p / dp;
            }
            let (_, dp) = legendre_and_derivative(n, y);
            let weight = 2.0 / (y * (2.0 - y) * dp * dp);
            nodes[i] = y - 1.0;
            nodes[n - 1 - i] = 1.0 - y;
            weights[i] = weight;
            weights[n - 1 - i] = weight;
        }
        if n % 2 == 1 {
            nodes[n / 2] = 0.0;
        }
        Self { nodes, weights }
    }
}

/// `(P_n(x), P_n'(x))` at x = 1 − y, 0 < y ≤ 1, n ≥ 1, by the recurrence of the differences `D_k = P_k − P_{k−1}`,
/// `(k+1) D_{k+1} = k D_k − (2k+1) y P_k`. This recurrence loses no digits near the end.
fn legendre_and_derivative(n: usize, y: f64) -> (f64, f64) {
    let (mut value, mut difference) = (1.0 - y, -y);
    for k in 1..n {
        let k = k as f64;
        difference = (k * difference - (2.0 * k + 1.0) * y * value) / (k + 1.0);
        value += difference;
    }
    let derivative = n as f64 * (y * value - difference) / (y * (2.0 - y));
    (value, derivative)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference with fifty digits (mpmath 1.3): index of the node from the end, node, weight.
    #[test]
    fn weights_keep_their_digits_towards_the_ends() {
        let digits = [
            (64, 0, 0.999_305_041_735_772_1, 0.001_783_280_721_696_433),
            (64, 1, 0.996_340_116_771_955_3, 0.004_147_033_260_562_468),
            (64, 7, 0.929_569_172_131_939_6, 0.017_951_715_775_697_34),
            (64, 31, 0.024_350_292_663_424_43, 0.048_690_957_009_139_72),
            (120, 0, 0.999_800_865_658_958_9, 0.000_511_026_063_694_612_1),
            (120, 1, 0.998_950_921_674_034_7, 0.001_189_234_327_793_163),
            (120, 7, 0.979_648_291_821_042_2, 0.005_231_963_814_295_594),
            (120, 59, 0.013_035_172_768_578_64, 0.026_068_868_824_110_29),
        ];
        for (n, place, node, weight) in digits {
            let rule = GaussLegendre::new(n);
            let (found, own) = (rule.nodes[n - 1 - place], rule.weights[place]);
            assert!((found - node).abs() <= f64::EPSILON, "{n} {place}: {found}");
            let off = (own / weight - 1.0).abs();
            assert!(off < 4e-15, "{n} {place}: {off:e}");
        }
    }

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
                let exact = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
                assert!((sum - exact).abs() < 4e-15, "n {n} degree {degree}: {sum}");
            }
        }
    }
}
