//! What is the response of two coupled linear equations to an input given as a series?
//!
//! `z' = A z + v` on a window of length τ, A a real 2 × 2 matrix, v and z Legendre series in
//! x = 2 t/τ − 1. With h = τ/2 and `∫ P_n dx = (P_{n+1} − P_{n−1})/(2n + 1)` the integrated equation is
//! tridiagonal in the terms,
//!
//! ```text
//! n = 0:  z_0 − h A (z_0 − z_1/3)                          = z(0) + h (v_0 − v_1/3)
//! n ≥ 1:  z_n − h A (z_{n−1}/(2n−1) − z_{n+1}/(2n+3))      = h (v_{n−1}/(2n−1) − v_{n+1}/(2n+3))
//! ```
//!
//! and is solved by elimination from the first term on. Its leading minors are denominators of Padé
//! approximants of the exponential. Their zeros lie in the right half-plane, so that they do not vanish for
//! motion that does not grow. The omitted term is as small as the truncation error of the window's series.

/// A 2 × 2 matrix, row by row.
type Square = [[f64; 2]; 2];

/// Solves `z' = A z + v` in Legendre series, for one 2 × 2 matrix A and one length of window.
#[derive(Debug, Clone)]
pub struct PairResponse<const P: usize> {
    /// `h A`, where h is half the length of the window.
    scaled: Square,
    /// h, half the length τ of the window.
    half: f64,
    /// Inverses of the pivots.
    inverses: [Square; P],
}

/// The Legendre series of both components.
pub type PairSeries<const P: usize> = [[f64; P]; 2];

impl<const P: usize> PairResponse<P> {
    /// The elimination for `z' = matrix z + v` on a window of length `tau`.
    pub fn new(matrix: &Square, tau: f64) -> Self {
        let half = 0.5 * tau;
        let scaled = matrix.map(|row| row.map(|a| half * a));
        let square = times(&scaled, &scaled);
        let mut inverses = [[[0.0; 2]; 2]; P];
        // The first pivot is I − hA. The next ones are I + (hA)²/((2n−1)(2n+1)) D⁻¹, with D the previous
        // pivot.
        let mut pivot = combined(1.0, &scaled, -1.0);
        for (n, inverse) in inverses.iter_mut().enumerate() {
            *inverse = inverted(&pivot);
            let odd = (2 * n + 1) as f64;
            let below = times(&square, inverse);
            pivot = combined(1.0, &below, 1.0 / (odd * (odd + 2.0)));
        }
        Self {
            scaled,
            half,
            inverses,
        }
    }

    /// The response to the input v with the initial value `start`.
    pub fn to(&self, start: [f64; 2], v: &PairSeries<P>) -> PairSeries<P> {
        let h = self.half;
        let mut right = [[0.0; 2]; P];
        for n in 0..P {
            let below = 1.0 / (2.0 * n as f64 - 1.0);
            let above = 1.0 / (2 * n + 3) as f64;
            for (row, v) in v.iter().enumerate() {
                let next = v.get(n + 1).map_or(0.0, |next| above * next);
                right[n][row] = match n {
                    0 => start[row] + h * (v[0] - next),
                    _ => h * (below * v[n - 1] - next),
                };
            }
            if n > 0 {
                let carried = on(&self.scaled, on(&self.inverses[n - 1], right[n - 1]));
                right[n][0] += below * carried[0];
                right[n][1] += below * carried[1];
            }
        }
        let mut out = [[0.0; P]; 2];
        let mut after = [0.0; 2];
        for n in (0..P).rev() {
            let above = 1.0 / (2 * n + 3) as f64;
            let back = on(&self.scaled, after);
            after = on(
                &self.inverses[n],
                std::array::from_fn(|row| right[n][row] - above * back[row]),
            );
            out[0][n] = after[0];
            out[1][n] = after[1];
        }
        out
    }
}

#[inline]
fn times(a: &Square, b: &Square) -> Square {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

#[inline]
fn on(a: &Square, x: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| a[i][0] * x[0] + a[i][1] * x[1])
}

/// `identity I + factor a`.
#[inline]
fn combined(identity: f64, a: &Square, factor: f64) -> Square {
    [
        [identity + factor * a[0][0], factor * a[0][1]],
        [factor * a[1][0], identity + factor * a[1][1]],
    ]
}

#[inline]
fn inverted(a: &Square) -> Square {
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    [
        [a[1][1] / determinant, -a[0][1] / determinant],
        [-a[1][0] / determinant, a[0][0] / determinant],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::legendre::{at_end, evaluate};

    /// Compares with the closed form for `q'' + 2ζω q' + ω² q = a + b t` from a given start.
    #[test]
    fn an_oscillator_under_a_ramp_is_that_of_the_textbook() {
        let (omega, zeta): (f64, f64) = (3.0, 0.02);
        let nu = omega * (1.0 - zeta * zeta).sqrt();
        let matrix = [[0.0, 1.0], [-omega * omega, -2.0 * zeta * omega]];
        for tau in [0.1, 1.3, 2.6] {
            let response = PairResponse::<24>::new(&matrix, tau);
            let (a, b) = (2.0, -0.7);
            let mut v = [[0.0; 24]; 2];
            v[1][0] = a + 0.5 * b * tau;
            v[1][1] = 0.5 * b * tau;
            let found = response.to([0.3, -0.4], &v);
            // Particular solution c + d t.
            let d = b / (omega * omega);
            let c = (a - 2.0 * zeta * omega * d) / (omega * omega);
            let (q0, v0) = (0.3 - c, -0.4 - d);
            for x in [-1.0, -0.3, 0.8, 1.0] {
                let t = 0.5 * tau * (x + 1.0);
                let decay = (-zeta * omega * t).exp();
                let (sin, cos) = (nu * t).sin_cos();
                let q = decay * (q0 * cos + (v0 + zeta * omega * q0) / nu * sin) + c + d * t;
                assert!((evaluate(&found[0], x) - q).abs() < 3e-15, "{tau} {x}");
            }
        }
    }

    #[test]
    fn a_rigid_pair_integrates_twice() {
        let response = PairResponse::<24>::new(&[[0.0, 1.0], [0.0, 0.0]], 2.0);
        let mut v = [[0.0; 24]; 2];
        v[1][0] = 3.0;
        let found = response.to([1.0, 0.5], &v);
        assert!((at_end(&found[0]) - (1.0 + 1.0 + 6.0)).abs() < 1e-14);
        assert!((at_end(&found[1]) - 6.5).abs() < 1e-14);
    }
}
