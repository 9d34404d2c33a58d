//! The torque of an engine over the angle of its shaft, as harmonics.

use super::{DriveShaft, TorqueRipple};
use num_complex::Complex64;

/// A torque over the angle of a shaft. It is linear between points, and periodic.
#[derive(Debug, Clone, PartialEq)]
pub struct TorqueCurve {
    /// The shaft.
    pub shaft: DriveShaft,
    /// Angles \[rad\], increasing over less than `period`, each with its torque \[N m\].
    pub points: Vec<[f64; 2]>,
    /// Angle after which the torque repeats \[rad\].
    pub period: f64,
}

impl TorqueCurve {
    /// The first `count` harmonics, without the mean. Harmonics that are zero up to rounding are left out.
    ///
    /// The second derivative of a piecewise linear curve is a sum of pulses `m_j`, the changes of slope at angles
    /// `a_j`. So the coefficients are `c_n = −Σ m_j e^{−i ω a_j} / (P ω²)` with the period P and `ω = 2π n / P`, and
    /// the amplitudes `2 |c_n|`.
    pub fn harmonics(&self, count: u32) -> Vec<TorqueRipple> {
        let points = &self.points;
        let slope = |k: usize| {
            let [from, start] = points[k];
            let [to, end] = match points.get(k + 1) {
                Some(next) => *next,
                None => [points[0][0] + self.period, points[0][1]],
            };
            (end - start) / (to - from)
        };
        let last = points.len().saturating_sub(1);
        let pulses: Vec<[f64; 2]> = (0..points.len())
            .map(|k| {
                [
                    points[k][0],
                    slope(k) - slope(if k == 0 { last } else { k - 1 }),
                ]
            })
            .collect();
        let harmonics = (1..=count).map(|n| {
            let order = std::f64::consts::TAU * f64::from(n) / self.period;
            let turned = |[angle, pulse]: &[f64; 2]| Complex64::from_polar(*pulse, -order * angle);
            let sum: Complex64 = pulses.iter().map(turned).sum();
            let value = sum * (-2.0 / (self.period * order * order));
            TorqueRipple {
                shaft: self.shaft,
                order,
                amplitude: value.norm(),
                phase: value.arg(),
            }
        });
        let all: Vec<TorqueRipple> = harmonics.collect();
        let most = all
            .iter()
            .map(|ripple| ripple.amplitude)
            .fold(0.0, f64::max);
        let counts = |ripple: &TorqueRipple| ripple.amplitude > 1e-12 * most;
        all.into_iter().filter(counts).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    fn curve(points: Vec<[f64; 2]>, period: f64) -> TorqueCurve {
        TorqueCurve {
            shaft: DriveShaft::Pinion,
            points,
            period,
        }
    }

    /// A triangle of height 1 over two revolutions: `8/π² Σ cos(n θ/2) / n²` over odd n.
    #[test]
    fn harmonics_of_a_triangle_are_in_closed_form() {
        let found = curve(vec![[0.0, 1.0], [TAU, -1.0]], 2.0 * TAU).harmonics(9);
        let orders: Vec<f64> = found.iter().map(|own| own.order).collect();
        assert_eq!(orders, [0.5, 1.5, 2.5, 3.5, 4.5]);
        for own in found {
            let exact = 8.0 / (PI * 2.0 * own.order).powi(2);
            assert!(
                (own.amplitude - exact).abs() < 1e-15 && own.phase.abs() < 1e-12,
                "{own:?}"
            );
        }
    }

    /// A sampled cosine: its harmonic has the exact phase, and the error of its amplitude falls with the square of
    /// the step.
    #[test]
    fn harmonics_of_a_sampled_wave_are_of_second_order() {
        let off = |count: u32| {
            let angle = |k: u32| TAU * f64::from(k) / f64::from(count) + 0.1;
            let points = (0..count).map(|k| [angle(k), 7.0 + 3.0 * (2.0 * angle(k) + 0.4).cos()]);
            let found = curve(points.collect(), TAU).harmonics(4);
            let own = found.iter().find(|own| own.order == 2.0).unwrap();
            assert!((own.phase - 0.4).abs() < 1e-12, "{own:?}");
            (own.amplitude - 3.0).abs()
        };
        let order = (off(40) / off(160)).log(4.0);
        assert!((order - 2.0).abs() < 0.02, "{order}");
    }

    #[test]
    fn a_constant_torque_has_no_harmonics() {
        assert!(
            curve(vec![[0.0, 2.0], [1.0, 2.0]], TAU)
                .harmonics(5)
                .is_empty()
        );
    }
}
