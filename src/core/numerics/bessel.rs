//! Spherical Bessel functions of the first kind, sixteen arguments at a time.
//!
//! ```text
//! j_{n−1} = (2n+1)/x j_n − j_{n+1},    j₀ = sin x / x,    j₁ = sin x / x² − cos x / x
//! ```
//!
//! (Abramowitz & Stegun 10.1.19). The upward recurrence is stable for n < x. The downward one is
//! stable for any n (Miller): it starts at an order with negligible j_n, and j₀ and j₁ give the scale.
//! For small x its terms would overflow. There `j_n = xⁿ/(2n+1)!! c_n` is used
//! with the backward recurrence for c_n of [`super::exponential`].

/// Number of orders, n < `ORDERS`. It equals the number of terms of a window's series.
pub const ORDERS: usize = 24;

/// Number of arguments processed together.
pub const LANES: usize = 16;

/// One number per lane.
pub type Lanes = [f64; LANES];

/// Largest argument for which c_n is used.
const SMALL: f64 = 5.0;

/// Number of terms that the power series of the two highest c_n needs for x ≤ [`SMALL`].
const SERIES_TERMS: usize = 12;

/// Writes `j_n(x)`, n < 24, for arguments x > 0, which are given with their sines and cosines. The arguments
/// are equal, or consecutive multiples of a number that is at most π.
#[inline(always)]
pub fn spherical_bessel(x: &Lanes, sin: &Lanes, cos: &Lanes, out: &mut [Lanes; ORDERS]) {
    let (smallest, largest) = (x[0].min(x[LANES - 1]), x[0].max(x[LANES - 1]));
    if largest <= SMALL {
        from_power_series(x, out);
    } else if smallest >= ORDERS as f64 {
        upwards(x, sin, cos, out);
    } else {
        downwards(x, largest, sin, cos, out);
    }
}

/// `j₀` and `j₁`.
#[inline(always)]
fn lowest(x: &Lanes, sin: &Lanes, cos: &Lanes) -> [Lanes; 2] {
    let mut out = [[0.0; LANES]; 2];
    for i in 0..LANES {
        out[0][i] = sin[i] / x[i];
        out[1][i] = (out[0][i] - cos[i]) / x[i];
    }
    out
}

#[inline(always)]
fn upwards(x: &Lanes, sin: &Lanes, cos: &Lanes, out: &mut [Lanes; ORDERS]) {
    let [mut below, mut now] = lowest(x, sin, cos);
    let inverse = x.map(|x| 1.0 / x);
    out[0] = below;
    out[1] = now;
    for (n, row) in out.iter_mut().enumerate().skip(2) {
        let factor = (2 * n - 1) as f64;
        for i in 0..LANES {
            row[i] = factor * inverse[i] * now[i] - below[i];
        }
        below = now;
        now = *row;
    }
}

#[inline(always)]
fn downwards(x: &Lanes, largest: f64, sin: &Lanes, cos: &Lanes, out: &mut [Lanes; ORDERS]) {
    // The first value is arbitrary. From this order its error in j_n, n < 24, is below 1e-17 of the largest of them.
    let start = 22 + (1.1 * largest).ceil() as usize;
    let inverse = x.map(|x| 1.0 / x);
    let mut above = [0.0; LANES];
    // This start is so small that the recurrence does not overflow, and so large that squares do not
    // underflow.
    let mut now = [1e-100; LANES];
    for n in (1..=start).rev() {
        if n < ORDERS {
            out[n] = now;
        }
        let factor = (2 * n + 1) as f64;
        let mut below = [0.0; LANES];
        for i in 0..LANES {
            below[i] = factor * inverse[i] * now[i] - above[i];
        }
        above = now;
        now = below;
    }
    out[0] = now;
    // j₀ and j₁ are never small at the same time.
    let exact = lowest(x, sin, cos);
    let mut scale = [0.0; LANES];
    for i in 0..LANES {
        let product = exact[0][i] * now[i] + exact[1][i] * above[i];
        scale[i] = product / (now[i] * now[i] + above[i] * above[i]);
    }
    for row in out {
        for i in 0..LANES {
            row[i] *= scale[i];
        }
    }
}

#[inline(always)]
fn from_power_series(x: &Lanes, out: &mut [Lanes; ORDERS]) {
    let mut square = [0.0; LANES];
    for i in 0..LANES {
        square[i] = -x[i] * x[i];
    }
    let series = |n: usize| {
        let mut sum = [1.0; LANES];
        for k in (1..=SERIES_TERMS).rev() {
            let factor = 0.5 / (k * (2 * n + 2 * k + 1)) as f64;
            for i in 0..LANES {
                sum[i] = 1.0 + factor * square[i] * sum[i];
            }
        }
        sum
    };
    let mut above = series(ORDERS);
    let mut now = series(ORDERS - 1);
    out[ORDERS - 1] = now;
    for n in (1..ORDERS).rev() {
        let factor = 1.0 / ((2 * n + 1) * (2 * n + 3)) as f64;
        let mut below = [0.0; LANES];
        for i in 0..LANES {
            below[i] = now[i] + factor * square[i] * above[i];
        }
        above = now;
        now = below;
        out[n - 1] = now;
    }
    let mut power = [1.0; LANES];
    for (n, row) in out.iter_mut().enumerate() {
        let next = 1.0 / (2 * n + 3) as f64;
        for i in 0..LANES {
            row[i] *= power[i];
            power[i] *= x[i] * next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `j_n(x) = xⁿ / (2ⁿ⁺¹ n!) ∫ cos(x t) (1 − t²)ⁿ dt` over −1 … 1 (A&S 10.1.13).
    fn by_integral(n: usize, x: f64) -> f64 {
        let rule = crate::numerics::quadrature::GaussLegendre::new(120);
        let scale: f64 = (1..=n).map(|k| 0.5 * x / k as f64).product();
        let integral: f64 = (rule.nodes.iter().zip(&rule.weights))
            .map(|(t, w)| w * (x * t).cos() * (1.0 - t * t).powi(n as i32))
            .sum();
        0.5 * scale * integral
    }

    fn of_multiples(x: f64, first: usize) -> (Lanes, [Lanes; ORDERS]) {
        let x: Lanes = std::array::from_fn(|i| x * (first + i) as f64);
        let mut out = [[f64::NAN; LANES]; ORDERS];
        spherical_bessel(&x, &x.map(f64::sin), &x.map(f64::cos), &mut out);
        (x, out)
    }

    #[test]
    fn every_order_is_the_integral_of_poisson() {
        for (step, first) in [
            (1e-9, 1),
            (0.01, 1),
            (0.6, 1),
            (0.63, 1),
            (0.9, 1),
            (3.1, 1),
            (3.1, 9),
            (0.7, 33),
            (0.25, 17),
            (0.1, 240),
        ] {
            let (x, out) = of_multiples(step, first);
            for n in 0..ORDERS {
                // Beyond this range the integral, unlike the recurrence, loses digits.
                for i in (0..LANES).filter(|&i| n < 12 || x[i] < 12.0) {
                    let exact = by_integral(n, x[i]);
                    let error = (out[n][i] - exact).abs();
                    let lost: f64 = (1..=n).map(|k| 0.5 * x[i] / k as f64).product();
                    assert!(
                        error < 8e-16 * (1.0 + lost),
                        "j_{n}({}): {} not {exact}",
                        x[i],
                        out[n][i]
                    );
                }
            }
        }
    }

    /// `j_n y_{n−1} − j_{n−1} y_n = 1/x²` (A&S 10.1.31), with y from the upward recurrence, which is
    /// stable for it.
    #[test]
    fn cross_products_are_one_over_the_square() {
        for (step, first) in [
            (0.8, 1),
            (0.8, 9),
            (0.8, 17),
            (0.8, 25),
            (3.1, 1),
            (3.1, 300),
        ] {
            let (x, out) = of_multiples(step, first);
            for i in 0..LANES {
                let (sin, cos) = x[i].sin_cos();
                let mut below = -cos / x[i];
                let mut y = -cos / (x[i] * x[i]) - sin / x[i];
                for n in 1..ORDERS {
                    let (a, b) = (out[n][i] * below, out[n - 1][i] * y);
                    let product = x[i] * x[i] * (a - b);
                    let size = 1.0 + x[i] * x[i] * (a.abs() + b.abs());
                    assert!(
                        (product - 1.0).abs() < 4e-15 * size,
                        "{n} at {}: {product}",
                        x[i]
                    );
                    (below, y) = (y, (2 * n + 1) as f64 / x[i] * y - below);
                }
            }
        }
    }

    /// Published to ten digits: Abramowitz & Stegun, tables 10.1 and 10.5.
    #[test]
    fn published_values_are_met() {
        let (_, out) = of_multiples(1.0, 1);
        for (n, i, value) in [
            (0, 0, 0.841_470_984_8),
            (1, 0, 0.301_168_678_9),
            (2, 4, 0.134_731_210_1),
            (10, 0, 7.116_552_640_1e-11),
            (20, 4, 5.427_726_761e-12),
        ] {
            assert!(
                (out[n][i] / value - 1.0).abs() < 1e-9,
                "{n} {i}: {}",
                out[n][i]
            );
        }
    }
}
