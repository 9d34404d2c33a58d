//! How much of the power through the mesh do the flanks lose in friction?
//!
//! At the mean speeds of rotation, friction takes the power `μ_f |F| (Ω₁ + Ω₂) Σ p |s|` at a contact. The
//! mesh transmits `F r_b1 Ω₁` from the pinion to the wheel. μ_f Σ p |s| is constant on a segment, so the loss
//! is an integral of |F| over windows. This integral is exact, even if F changes its sign.

use super::rule::NodeValues;
use crate::analysis::modal_series::{Series, TERMS, padded};
use crate::analysis::outcome::NvhStatistics;
use crate::model::{COAST_FLANK, DRIVE_FLANK, Model, Rolling};
use crate::numerics::legendre::{
    at_end, at_start, derivative, evaluate_with_derivatives, transforms24, variation,
};
use crate::numerics::roots::sign_changes;
use crate::propagate::{InstructionSet, Window};

/// Largest force, relative to the largest one of a window, that the search for sign changes treats as
/// round-off.
const NOISE: f64 = 1e-14;

/// How the gears roll, and the friction of each direction of the mesh force.
#[derive(Debug, Clone)]
pub(super) struct Losses {
    rolling: Rolling,
    /// Loss divided by |F| \[m/s\], by direction.
    speeds: Vec<f64>,
    /// Number of contacts that are springs of the flanks of the first mesh.
    flank_springs: usize,
}

impl Losses {
    /// The losses of a model; `None` if the geometry of its gears is unknown.
    pub fn of(model: &Model) -> Option<Self> {
        let rolling = model.rolling?;
        let speeds = (model.directions.iter())
            .map(|direction| direction.rubbing * rolling.sliding)
            .collect();
        Some(Self {
            rolling,
            speeds,
            flank_springs: model.flank_springs,
        })
    }

    /// Passes the index of every closed contact with friction to `lost`, with the energy \[J\] lost on it over a
    /// window. `force` is the force of the first mesh at nodes.
    pub fn each(
        &self,
        set: InstructionSet,
        window: &Window<'_>,
        force: Option<&NodeValues<'_>>,
        mut lost: impl FnMut(usize, f64),
    ) {
        let is_in_first_mesh = |contact: usize| contact < self.flank_springs;
        let closed_in_first_mesh =
            (window.closed.iter()).filter(|closed| is_in_first_mesh(closed.contact));
        let only = force.filter(|_| closed_in_first_mesh.count() == 1);
        for closed in window.closed {
            let speed = self.speeds[window.segments[closed.contact].direction];
            if speed == 0.0 {
                continue;
            }
            let force = match only.filter(|_| is_in_first_mesh(closed.contact)) {
                Some(force) => modulus_at_nodes(set, force),
                None => modulus(&padded(closed.force)),
            };
            lost(closed.contact, window.duration * speed * force);
        }
    }

    /// Writes the statistics from the mean losses \[W\] of all contacts; `values` already have the mean force.
    pub fn write_statistics(&self, losses: Vec<f64>, values: &mut NvhStatistics) {
        let loss = losses[DRIVE_FLANK] + losses[COAST_FLANK];
        let through = self.rolling.base_speed * values.force_mean;
        values.power_transmitted = Some(through);
        values.power_loss = Some(loss);
        values.contact_loss = losses;
        values.efficiency = (through != 0.0).then(|| 1.0 - loss / through.abs());
    }

    /// Writes the standard errors, from those of the mean force, of the mean loss and of their quotient.
    pub fn write_errors(&self, quotient: f64, loss: f64, errors: &mut NvhStatistics) {
        errors.power_transmitted = Some(self.rolling.base_speed * errors.force_mean);
        errors.power_loss = Some(loss);
        errors.efficiency = Some(quotient);
    }

    /// Coulomb friction coefficient of the flanks.
    pub fn friction(&self) -> f64 {
        self.rolling.friction
    }

    /// Power through the mesh divided by the mean force \[m/s\].
    pub fn base_speed(&self) -> f64 {
        self.rolling.base_speed
    }
}

/// Mean of the modulus of a series over its window, from its values at nodes if possible.
fn modulus_at_nodes(set: InstructionSet, at_nodes: &NodeValues<'_>) -> f64 {
    if at_nodes.range.has_one_sign() {
        return at_nodes.series[0].abs();
    }
    let slope = derivative(at_nodes.series);
    let slope = at_nodes.at_same_nodes(set, &slope);
    modulus_of_one_change(at_nodes, &slope).unwrap_or_else(|| modulus(at_nodes.series))
}

/// Mean of the modulus of a series whose sign changes only once; `None` if the values and slopes at nodes and
/// ends do not prove this. The proof: between two neighbouring positions, the series or its slope stays too
/// close to its chord to reach zero.
fn modulus_of_one_change(at_nodes: &NodeValues<'_>, slope: &NodeValues<'_>) -> Option<f64> {
    /// Step below which the parabola is exact to round-off.
    const EXACT_STEP: f64 = 1e-5;
    let mut all = at_nodes.values().zip(slope.values());
    let mut before = all.next()?;
    let mut change = None;
    for here in all {
        let ((_, a), (_, b)) = (before.0, here.0);
        let ((_, p), (_, q)) = (before.1, here.1);
        let stays = |a: f64, b: f64, rise: f64| a * b > 0.0 && a.abs().min(b.abs()) > rise;
        if !stays(a, b, at_nodes.range.rise) && !stays(p, q, slope.range.rise) {
            return None;
        }
        if (a > 0.0) != (b > 0.0) && change.replace((before, here)).is_some() {
            return None;
        }
        before = here;
    }
    let ((start, a), (end, b)) = change.map(|(before, here)| (before.0, here.0))?;
    let integral = integral(at_nodes.series);
    // The integral has its extreme at the sign change.
    let mut x = (start * b - end * a) / (b - a);
    for _ in 0..4 {
        let [value, force, slope] = evaluate_with_derivatives::<_, false>(&integral, x);
        let step = -force / slope;
        if step.abs() < EXACT_STEP {
            let extreme = value + 0.5 * force * step;
            let sides = [extreme - at_start(&integral), at_end(&integral) - extreme];
            return Some(0.5 * (sides[0].abs() + sides[1].abs()));
        }
        x += step;
    }
    None
}

/// Legendre series of an antiderivative: `∫ P_n dx = (P_{n+1} − P_{n−1})/(2n + 1), ∫ P_0 dx = P_1`.
fn integral(series: &Series) -> [f64; TERMS + 1] {
    let mut integral = [0.0; TERMS + 1];
    for (n, a) in series.iter().enumerate() {
        let part = a / (2 * n + 1) as f64;
        integral[n + 1] += part;
        if n > 0 {
            integral[n - 1] -= part;
        }
    }
    integral
}

/// Mean of the modulus of a series over \[−1, 1\].
fn modulus(series: &Series) -> f64 {
    if series[0].abs() >= variation(series) {
        return series[0].abs();
    }
    let integral = integral(series);
    let largest = series[0].abs() + variation(series);
    let mut before = at_start(&integral);
    let mut sum = 0.0;
    let mut to = |here: f64| {
        sum += (here - before).abs();
        before = here;
    };
    let noise = NOISE * largest;
    sign_changes(transforms24(), series, noise, &mut None, |x, _| {
        to(evaluate_with_derivatives::<_, false>(&integral, x)[0]);
    });
    to(at_end(&integral));
    0.5 * sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::nvh::rule::Rules;
    use crate::numerics::legendre::evaluate;
    use crate::numerics::quadrature::GaussLegendre;

    #[test]
    fn the_modulus_is_exact_across_changes_of_sign() {
        // cos(5 x + 0.3) has its roots where 5 x + 0.3 is an odd multiple of π/2.
        let series: Series = transforms24().interpolate(&std::array::from_fn(|i| {
            (5.0 * transforms24().nodes()[i] + 0.3).cos()
        }));
        let primitive = |x: f64| (5.0 * x + 0.3).sin() / 5.0;
        let roots = (-2..2).map(|k| ((f64::from(k) + 0.5) * std::f64::consts::PI - 0.3) / 5.0);
        let ends: Vec<f64> = [-1.0]
            .into_iter()
            .chain(roots.filter(|x| x.abs() < 1.0))
            .chain([1.0])
            .collect();
        assert!(ends.len() > 4);
        let exact: f64 = (ends.windows(2))
            .map(|e| 0.5 * (primitive(e[1]) - primitive(e[0])).abs())
            .sum();
        assert!((modulus(&series) - exact).abs() < 1e-13, "{exact}");
    }

    #[test]
    fn the_modulus_of_a_rough_series_is_that_of_a_fine_rule() {
        let rough = |n: usize| (1.7 * n as f64 + 0.4).sin() / (n + 1) as f64;
        let series: Series = std::array::from_fn(|n| if n == 0 { 0.1 } else { rough(n) });
        let rule = GaussLegendre::new(24);
        let (mut sum, parts) = (0.0, 4000);
        for part in 0..parts {
            for (x, weight) in rule.nodes.iter().zip(&rule.weights) {
                let x = -1.0 + (2.0 * f64::from(part) + 1.0 + x) / f64::from(parts);
                sum += 0.5 * weight * evaluate(&series, x).abs() / f64::from(parts);
            }
        }
        let found = modulus(&series);
        assert!((found / sum - 1.0).abs() < 1e-6, "{found} {sum}");
        assert!(found > 1.05 * series[0].abs(), "it changes its sign");
        assert_eq!(
            modulus(&std::array::from_fn(|n| if n == 0 { -2.0 } else { 0.01 })),
            2.0
        );
    }

    /// A force near its release has one sign change, at different positions and with different widths. A
    /// series with several changes is integrated from one change to the next.
    #[test]
    fn one_change_of_sign_is_proved_at_the_nodes() {
        let rules = Rules::shared();
        let series_of = |turn: f64, phase: f64| -> Series {
            transforms24().interpolate(&std::array::from_fn(|i| {
                (turn * transforms24().nodes()[i] + phase).sin()
            }))
        };
        for set in InstructionSet::available() {
            let (mut proved, mut changes) = (0, 0);
            for step in 0..300 {
                let phase = 0.021 * f64::from(step);
                let (series, several) = (series_of(1.9, phase), series_of(5.0, phase));
                for series in [series, several] {
                    let slope = derivative(&series);
                    let at_nodes = rules.evaluate_at_nodes(set, &series, 0.0, 0.0);
                    let slope = at_nodes.at_same_nodes(set, &slope);
                    let exact = modulus(&series);
                    let once = modulus_of_one_change(&at_nodes, &slope);
                    proved += usize::from(once.is_some());
                    changes += usize::from(!at_nodes.range.has_one_sign());
                    let found = [once, Some(modulus_at_nodes(set, &at_nodes))];
                    for found in found.into_iter().flatten() {
                        assert!((found - exact).abs() < 1e-14, "{phase}: {found} {exact}");
                    }
                }
            }
            assert!(proved > 200 && proved < changes, "{proved} of {changes}");
        }
    }
}
