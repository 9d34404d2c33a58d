//! The mesh stiffness of a segment.

use crate::numerics::{
    legendre::{self, transforms8, transforms24},
    quadrature::GaussLegendre,
};

/// Number of terms of the series of a segment's stiffness.
pub const STIFFNESS_TERMS: usize = 8;

/// Mesh stiffness \[N/m\] over a segment: a Legendre series in x ∈ \[−1, 1\], from the
/// segment's start to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiffness {
    series: [f64; STIFFNESS_TERMS],
}

impl Stiffness {
    /// A constant stiffness \[N/m\].
    pub const fn constant(value: f64) -> Self {
        let mut series = [0.0; STIFFNESS_TERMS];
        series[0] = value;
        Self { series }
    }

    /// The stiffness with these Legendre coefficients \[N/m\].
    pub const fn series(series: [f64; STIFFNESS_TERMS]) -> Self {
        Self { series }
    }

    /// Its Legendre coefficients \[N/m\].
    pub fn coefficients(&self) -> &[f64; STIFFNESS_TERMS] {
        &self.series
    }

    /// Its Legendre coefficients \[N/m\], mutable.
    pub(super) fn coefficients_mut(&mut self) -> &mut [f64; STIFFNESS_TERMS] {
        &mut self.series
    }

    /// The mirror image of the stiffness over the segment: its value at −x.
    pub fn reversed(&self) -> Self {
        Self {
            series: reversed(&self.series),
        }
    }

    /// The part of the stiffness between two positions x of the segment, as a series over this part.
    pub fn part(&self, from: f64, to: f64) -> Self {
        if self.is_constant() {
            *self
        } else {
            Self {
                series: part(&self.series, from, to),
            }
        }
    }

    /// This stiffness times a factor.
    pub fn times(&self, factor: f64) -> Self {
        Self {
            series: self.series.map(|a| factor * a),
        }
    }

    /// Whether it is constant.
    pub fn is_constant(&self) -> bool {
        self.series[1..].iter().all(|&a| a == 0.0)
    }

    /// Its mean over the segment \[N/m\].
    pub fn mean(&self) -> f64 {
        self.series[0]
    }

    /// Its value \[N/m\] at x ∈ \[−1, 1\].
    pub fn at(&self, x: f64) -> f64 {
        if self.is_constant() {
            self.series[0]
        } else {
            legendre::evaluate(&self.series, x)
        }
    }

    /// The series of its derivative with respect to x \[N/m\].
    pub fn slope(&self) -> [f64; STIFFNESS_TERMS] {
        legendre::derivative(&self.series)
    }

    /// A bound of the modulus of its values \[N/m\].
    pub fn bound(&self) -> f64 {
        self.series.iter().map(|a| a.abs()).sum()
    }

    /// The smallest of its values at the ends and at the nodes of a fine quadrature rule \[N/m\].
    pub fn smallest(&self) -> f64 {
        if self.is_constant() {
            return self.series[0];
        }
        let inside = transforms24().nodes().iter().copied();
        inside
            .chain([-1.0, 1.0])
            .map(|x| self.at(x))
            .fold(f64::INFINITY, f64::min)
    }

    /// The stiffness in series with a flexibility c \[m/N\], `k/(1 + c k)`: exact if it is
    /// constant, otherwise the polynomial through the values at the Gauss nodes.
    pub fn in_series_with(&self, flexibility: f64) -> Self {
        let joined = |k: f64| k / (1.0 + flexibility * k);
        if self.is_constant() || flexibility == 0.0 {
            let mut series = self.series;
            series[0] = joined(series[0]);
            return Self { series };
        }
        let rule = GaussLegendre::new(STIFFNESS_TERMS);
        let values: [f64; STIFFNESS_TERMS] =
            std::array::from_fn(|i| joined(self.at(rule.nodes[i])));
        Self::through(&values)
    }

    /// The polynomial through values \[N/m\] at the Gauss–Legendre nodes of the segment.
    pub fn through(values: &[f64; STIFFNESS_TERMS]) -> Self {
        let rule = GaussLegendre::new(STIFFNESS_TERMS);
        let mut series = [0.0; STIFFNESS_TERMS];
        let mut polynomials = [0.0; STIFFNESS_TERMS];
        for ((x, weight), value) in rule.nodes.iter().zip(&rule.weights).zip(values) {
            legendre::polynomials(*x, &mut polynomials);
            for (n, (term, p)) in series.iter_mut().zip(&polynomials).enumerate() {
                *term += 0.5 * (2 * n + 1) as f64 * weight * value * p;
            }
        }
        Self { series }
    }
}

/// The series of `f(−x)`.
pub(super) fn reversed(series: &[f64; STIFFNESS_TERMS]) -> [f64; STIFFNESS_TERMS] {
    std::array::from_fn(|n| if n % 2 == 0 { series[n] } else { -series[n] })
}

/// The series on the part between two positions, rescaled to \[−1, 1\].
pub(super) fn part(series: &[f64; STIFFNESS_TERMS], from: f64, to: f64) -> [f64; STIFFNESS_TERMS] {
    if [from, to] == [-1.0, 1.0] {
        *series
    } else {
        transforms8().restrict(series, from, to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Legendre coefficients of x³ are those of (3 P₁ + 2 P₃)/5.
    #[test]
    fn a_cubic_goes_through_its_values() {
        let rule = GaussLegendre::new(STIFFNESS_TERMS);
        let values = std::array::from_fn(|i| 2.0 + rule.nodes[i].powi(3));
        let cubic = Stiffness::through(&values);
        let expected = [2.0, 0.6, 0.0, 0.4];
        for (n, value) in cubic.coefficients().iter().enumerate() {
            let expected = expected.get(n).copied().unwrap_or(0.0);
            assert!((value - expected).abs() < 1e-14, "{n}: {value}");
        }
        assert!((cubic.at(0.5) - 2.125).abs() < 1e-14);
        assert!((legendre::evaluate(&cubic.slope(), 0.5) - 0.75).abs() < 1e-14);
        assert!((cubic.mean() - 2.0).abs() < 1e-15 && !cubic.is_constant());
        assert!((cubic.smallest() - 1.0).abs() < 1e-14 && cubic.bound() >= 3.0);
    }

    #[test]
    fn flexibility_in_series_is_exact_where_constant_and_close_where_not() {
        let constant = Stiffness::constant(4.0).in_series_with(0.25);
        assert_eq!(constant, Stiffness::constant(2.0));
        let ramp = Stiffness::series([4.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let joined = ramp.in_series_with(0.25);
        for x in [-1.0, -0.3, 0.0, 0.8, 1.0] {
            let k = 4.0 + 0.4 * x;
            assert!((joined.at(x) - k / (1.0 + 0.25 * k)).abs() < 1e-11);
        }
    }
}
