//! Parallel springs in series with one flexibility. The springs are the pairs of teeth of a flank. The
//! flexibility is that of the omitted modes under the total force of the springs.
//!
//! The force of springs that come into contact one after the other is `F(x) = Σ k_l max(0, x − g_l)` of their approach
//! x. In series with a flexibility c the total approach is `X = x + c F(x)`. F over X is again piecewise linear, with
//! its kinks in the same order: parallel springs with the stiffnesses and gaps
//!
//! ```text
//! K_l  = k_1 + … + k_l,   s_l = 1/(1 + c K_l)
//! k'_l = K_l s_l − K_{l−1} s_{l−1},        g'_l = g_l + c Σ_{i<l} k_i (g_l − g_i)
//! ```
//!
//! exactly. With the friction t_l per unit force of spring l, the friction force `T(x) = Σ t_l k_l max(0, x − g_l)` is
//! piecewise linear too: `t'_l k'_l = Φ_l s_l − Φ_{l−1} s_{l−1}` with `Φ_l = t_1 k_1 + … + t_l k_l`.

use super::error::ModelError;
use super::{Division, FlankError, STIFFNESS_TERMS, Stiffness};
use crate::numerics::legendre::transforms8;
use crate::structure::FlankParticipation;

/// Gaps that are out of order by less than this \[m\] count as in order. Interpolation of the gaps by
/// polynomials causes such differences.
const IN_ORDER: f64 = 1e-11;

/// The springs of a flank, in their order of contact, in series with a common flexibility \[m/N\]. Their
/// stiffness and gap are polynomials through the exact values at the nodes of every division.
///
/// # Errors
/// [`ModelError::SpringsApart`] if the springs differ in their lines or divisions, or if their order of
/// contact changes.
fn in_series_with_flexibility(
    springs: &[&[Division]],
    flexibility: f64,
) -> Result<Vec<Vec<Division>>, ModelError> {
    if springs.len() == 1 || flexibility == 0.0 {
        let alone = |division: &Division| Division {
            stiffness: division.stiffness.in_series_with(flexibility),
            ..*division
        };
        let all = springs.iter();
        return Ok(all
            .map(|spring| spring.iter().map(alone).collect())
            .collect());
    }
    let first = springs[0];
    let mut out = vec![Vec::with_capacity(first.len()); springs.len()];
    for (place, at_first) in first.iter().enumerate() {
        let together: Option<Vec<&Division>> = (springs.iter())
            .map(|spring| {
                spring
                    .get(place)
                    .filter(|spring| on_one_line(at_first, spring))
            })
            .collect();
        let joined = (together
            .filter(|_| springs.iter().all(|spring| spring.len() == first.len())))
        .and_then(|together| joined(&together, flexibility))
        .ok_or(ModelError::SpringsApart { flexibility })?;
        for (spring, division) in out.iter_mut().zip(joined) {
            spring.push(division);
        }
    }
    Ok(out)
}

/// The first and the further springs of a flank, in series with the residual flexibility of the flank.
///
/// # Errors
/// As [`in_series_with_flexibility`].
pub(super) fn of_flank(
    first: &[Division],
    further: &[Vec<Division>],
    flank: &FlankParticipation,
) -> Result<Vec<Vec<Division>>, ModelError> {
    let springs: Vec<&[Division]> = std::iter::once(first)
        .chain(further.iter().map(Vec::as_slice))
        .collect();
    in_series_with_flexibility(&springs, flank.residual_flexibility)
}

/// Whether two divisions have the same end and the same load centroid.
fn on_one_line(one: &Division, other: &Division) -> bool {
    one.end == other.end && one.load_centre == other.load_centre
}

/// The springs in one division, in series with a common flexibility \[m/N\]. `None` if their order of contact
/// differs from the order of `springs`.
fn joined(springs: &[&Division], flexibility: f64) -> Option<Vec<Division>> {
    let mut stiffness = vec![[0.0; STIFFNESS_TERMS]; springs.len()];
    let mut gap = stiffness.clone();
    let mut friction = vec![[0.0; 2]; springs.len()];
    for (node, &x) in transforms8().nodes().iter().enumerate() {
        // Of the springs up to this one: Σ k, Σ k g, and their total stiffness in series with the
        // flexibility.
        let (mut sum, mut moment, mut before) = (0.0, 0.0, 0.0);
        let mut last = f64::NEG_INFINITY;
        for (l, spring) in springs.iter().enumerate() {
            let (k, g) = (spring.stiffness.at(x), spring.error.at(x));
            if g < last - IN_ORDER {
                return None;
            }
            last = g;
            gap[l][node] = g + flexibility * (sum * g - moment);
            sum += k;
            moment += k * g;
            let behind = sum / (1.0 + flexibility * sum);
            stiffness[l][node] = behind - before;
            before = behind;
        }
    }
    // The friction of a division uses the mean stiffnesses.
    let (mut sum, mut before) = (0.0, [0.0; 2]);
    let (mut turned, mut behind) = ([0.0; 2], 0.0);
    for (l, spring) in springs.iter().enumerate() {
        let k = spring.stiffness.mean();
        sum += k;
        let softer = 1.0 / (1.0 + flexibility * sum);
        let added = sum * softer - behind;
        behind = sum * softer;
        for part in 0..2 {
            turned[part] += k * spring.friction[part];
            friction[l][part] = (turned[part] * softer - before[part]) / added;
            before[part] = turned[part] * softer;
        }
    }
    let through = |values: &[f64; STIFFNESS_TERMS]| transforms8().interpolate(values);
    Some(
        (springs.iter().enumerate())
            .map(|(l, spring)| Division {
                stiffness: Stiffness::series(through(&stiffness[l])),
                error: FlankError::series(through(&gap[l])),
                friction: friction[l],
                ..**spring
            })
            .collect(),
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn springs() -> [Division; 3] {
        let spring = |k: [f64; 3], g: [f64; 3], friction| {
            let series = |a: [f64; 3]| std::array::from_fn(|n| a.get(n).copied().unwrap_or(0.0));
            Division {
                stiffness: Stiffness::series(series(k)),
                error: FlankError::series(series(g)),
                friction,
                ..Division::level(1.0, 1.0)
            }
        };
        [
            spring([3e8, 2e7, -1e7], [1e-7, 0.0, 0.0], [0.8, -1e-3]),
            spring([2e8, -3e7, 0.0], [3e-6, 1e-6, 0.0], [-0.6, -4e-3]),
            spring([1e8, 0.0, 1e6], [9e-6, -1e-6, 2e-7], [-1.0, -6e-3]),
        ]
    }

    /// Force and friction force of springs at a position and an approach.
    fn forces_of(springs: &[Division], x: f64, approach: f64) -> [f64; 2] {
        springs.iter().fold([0.0; 2], |[force, turned], own| {
            let closing = (approach - own.error.at(x)).max(0.0);
            let bears = own.stiffness.at(x) * closing;
            [force + bears, turned + own.friction[0] * bears]
        })
    }

    /// Compares with F = Σ k max(0, X − c F − g), solved by bisection.
    #[test]
    fn springs_share_one_flexibility() {
        let springs = springs();
        let own: Vec<&[Division]> = springs.iter().map(std::slice::from_ref).collect();
        let c = 1.3e-9;
        let joined: Vec<Division> = in_series_with_flexibility(&own, c)
            .unwrap()
            .into_iter()
            .flatten()
            .collect();
        for x in [-0.9, -0.2, 0.4, 1.0] {
            for seen in [1e-6, 4e-6, 9e-6, 2e-5, 5e-5] {
                let (mut low, mut high) = (0.0, forces_of(&springs, x, seen)[0]);
                for _ in 0..200 {
                    let force = 0.5 * (low + high);
                    if forces_of(&springs, x, seen - c * force)[0] > force {
                        low = force
                    } else {
                        high = force
                    }
                }
                let [force, _] = forces_of(&joined, x, seen);
                assert!(
                    (force - high).abs() < 1e-7 * high.max(1.0),
                    "{x} {seen}: {force} {high}"
                );
                // The force is wrong if each spring is in series with a separate flexibility.
                let separate: Vec<Division> = springs
                    .iter()
                    .map(|spring| Division {
                        stiffness: spring.stiffness.in_series_with(c),
                        ..*spring
                    })
                    .collect();
                let several = seen - c * high > springs[1].error.at(x);
                let far = forces_of(&separate, x, seen)[0] / high - 1.0;
                assert!(!several || far > 1e-3, "{far}");
            }
        }
    }

    /// For constant springs, the friction is that of the exact forces in series with the flexibility.
    #[test]
    fn friction_follows_the_forces() {
        let springs = springs().map(|own| Division {
            stiffness: Stiffness::constant(own.stiffness.mean()),
            ..own
        });
        let own: Vec<&[Division]> = springs.iter().map(std::slice::from_ref).collect();
        let c = 2e-9;
        let joined: Vec<Division> = in_series_with_flexibility(&own, c)
            .unwrap()
            .into_iter()
            .flatten()
            .collect();
        for seen in [2e-6, 7e-6, 3e-5] {
            let [force, turned] = forces_of(&joined, 0.3, seen);
            let exact = forces_of(&springs, 0.3, seen - c * force);
            assert!((force / exact[0] - 1.0).abs() < 1e-9);
            assert!(
                (turned - exact[1]).abs() < 1e-9 * force,
                "{turned} {exact:?}"
            );
        }
    }

    #[test]
    fn springs_on_several_lines_are_refused() {
        let [one, mut other, _] = springs();
        other.load_centre = 5e-3;
        let c = 1e-10;
        let refused = in_series_with_flexibility(&[&[one], &[other]], c);
        assert_eq!(refused, Err(ModelError::SpringsApart { flexibility: c }));
        assert!(in_series_with_flexibility(&[&[one], &[other]], 0.0).is_ok());
    }
}
