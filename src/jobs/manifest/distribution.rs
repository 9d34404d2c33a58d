//! Distributions of the values of an axis, and their quantiles.

use serde::Serialize;
use statrs::function::erf::{erfc, erfc_inv};
use std::f64::consts::SQRT_2;
use std::sync::Arc;
use strum::IntoStaticStr;

/// The distribution of an axis's values, in SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Distribution {
    /// The law before truncation.
    pub law: Law,
    /// The smallest and the largest value, if there are limits.
    pub truncate: Option<[f64; 2]>,
}

/// The law of a distribution.
#[derive(Debug, Clone, PartialEq, Serialize, IntoStaticStr)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum Law {
    /// Normal.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation, above 0.
        deviation: f64,
    },
    /// Values with a normal logarithm.
    Lognormal {
        /// Median, above 0.
        median: f64,
        /// Standard deviation of the natural logarithm, above 0.
        deviation: f64,
    },
    /// Uniform.
    Uniform {
        /// Smallest value.
        low: f64,
        /// Largest value.
        high: f64,
    },
    /// Given values in ascending order, at least one; all are equally likely.
    Empirical(Arc<[f64]>),
}

impl Distribution {
    /// The value below which a share `u`, in (0, 1), of the distribution lies:
    /// `F⁻¹(F(low) + u (F(high) − F(low)))` with the ends of the truncation.
    pub fn quantile(&self, u: f64) -> f64 {
        let [below, up_to] = self.shares();
        let value = self.law.quantile(below + u * (up_to - below));
        match self.truncate {
            Some([low, high]) => value.clamp(low, high),
            None => value,
        }
    }

    /// The share of the law that the truncation keeps.
    pub fn kept(&self) -> f64 {
        let [below, up_to] = self.shares();
        up_to - below
    }

    /// The shares of the law below the lower limit and up to the upper limit of the truncation.
    fn shares(&self) -> [f64; 2] {
        self.truncate.map_or([0.0, 1.0], |[low, high]| {
            [self.law.below(low), self.law.up_to(high)]
        })
    }
}

impl Law {
    /// Name in manifests.
    pub fn name(&self) -> &'static str {
        self.into()
    }

    /// The share of values below `x`.
    fn below(&self, x: f64) -> f64 {
        match self {
            Self::Empirical(values) => {
                values.partition_point(|value| *value < x) as f64 / values.len() as f64
            }
            _ => self.up_to(x),
        }
    }

    /// The share of values that are at most `x`.
    fn up_to(&self, x: f64) -> f64 {
        match self {
            Self::Normal { mean, deviation } => normal_share((x - mean) / deviation),
            Self::Lognormal { .. } if x <= 0.0 => 0.0,
            Self::Lognormal { median, deviation } => normal_share((x / median).ln() / deviation),
            Self::Uniform { low, high } => ((x - low) / (high - low)).clamp(0.0, 1.0),
            Self::Empirical(values) => {
                values.partition_point(|value| *value <= x) as f64 / values.len() as f64
            }
        }
    }

    fn quantile(&self, share: f64) -> f64 {
        match self {
            Self::Normal { mean, deviation } => mean + deviation * normal_quantile(share),
            Self::Lognormal { median, deviation } => {
                median * (deviation * normal_quantile(share)).exp()
            }
            Self::Uniform { low, high } => low + share * (high - low),
            Self::Empirical(values) => {
                let place = (share * values.len() as f64) as usize;
                values[place.min(values.len() - 1)]
            }
        }
    }
}

/// The share of a standard normal distribution up to `z`: `erfc(−z/√2)/2`.
fn normal_share(z: f64) -> f64 {
    0.5 * erfc(-z / SQRT_2)
}

/// The standard normal quantile: `−√2 erfc⁻¹(2p)`.
fn normal_quantile(share: f64) -> f64 {
    -SQRT_2 * erfc_inv(2.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(law: Law, truncate: Option<[f64; 2]>) -> Distribution {
        Distribution { law, truncate }
    }

    /// Published quantiles: Abramowitz & Stegun, Handbook of Mathematical Functions, table 26.6.
    #[test]
    fn normal_quantiles_are_the_published_ones() {
        let law = of(
            Law::Normal {
                mean: 80.0,
                deviation: 10.0,
            },
            None,
        );
        for (share, z) in [
            (0.5, 0.0),
            (0.9, 1.28155),
            (0.95, 1.64485),
            (0.975, 1.95996),
            (0.999, 3.09023),
            (0.0001, -3.71902),
        ] {
            let found = (law.quantile(share) - 80.0) / 10.0;
            assert!((found - z).abs() < 6e-6, "{share}: {found}");
        }
    }

    #[test]
    fn quantiles_invert_the_shares() {
        let laws = [
            Law::Normal {
                mean: 1.0,
                deviation: 0.5,
            },
            Law::Lognormal {
                median: 0.03,
                deviation: 0.4,
            },
            Law::Uniform {
                low: -1.0,
                high: 3.0,
            },
        ];
        for law in laws {
            for k in 1..200 {
                let share = f64::from(k) / 200.0;
                let back = law.up_to(law.quantile(share));
                // The error functions of statrs have at least 10 digits.
                assert!((back - share).abs() < 1e-10, "{law:?} {share} {back}");
            }
        }
    }

    /// The mean of a normal distribution truncated at `a` and `b` is `m + s (φ(a) − φ(b))/(Φ(b) − Φ(a))`.
    #[test]
    fn a_truncated_normal_has_its_mean_and_its_limits() {
        let law = of(
            Law::Normal {
                mean: 10.0,
                deviation: 4.0,
            },
            Some([8.0, 20.0]),
        );
        let density = |z: f64| (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
        let expected =
            10.0 + 4.0 * (density(-0.5) - density(2.5)) / (normal_share(2.5) - normal_share(-0.5));
        let count = 100_000;
        let values: Vec<f64> = (0..count)
            .map(|k| law.quantile((k as f64 + 0.5) / count as f64))
            .collect();
        assert!(values.iter().all(|value| (8.0..=20.0).contains(value)));
        let mean = values.iter().sum::<f64>() / count as f64;
        assert!((mean - expected).abs() < 1e-6, "{mean} {expected}");
    }

    #[test]
    fn given_values_are_equally_likely() {
        let values: Arc<[f64]> = [1.0, 2.0, 2.0, 5.0, 9.0].into();
        let counts = |truncate| {
            let law = of(Law::Empirical(Arc::clone(&values)), truncate);
            let drawn: Vec<f64> = (0..600)
                .map(|k| law.quantile((f64::from(k) + 0.5) / 600.0))
                .collect();
            [1.0, 2.0, 5.0, 9.0].map(|value| drawn.iter().filter(|own| **own == value).count())
        };
        assert_eq!(counts(None), [120, 240, 120, 120]);
        assert_eq!(counts(Some([2.0, 5.0])), [0, 400, 200, 0]);
        assert_eq!(counts(Some([1.5, 8.0])), [0, 400, 200, 0]);
    }
}
