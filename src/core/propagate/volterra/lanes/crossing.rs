//! Inner loops of the search for events.

use super::columns::GROUPS;
use crate::numerics::arithmetic::{Arithmetic, Bounds};
use crate::numerics::legendre::{self, Columns, SAMPLES, Transforms, transforms24};
use crate::propagate::Counters;
use crate::propagate::events::{self, Crossing, Guard};
use crate::propagate::vectors::Vector;
use crate::propagate::volterra::shapes::{LANES, Series, TERMS};
use std::marker::PhantomData;

/// Arithmetic in vectors.
struct Packed<V>(PhantomData<V>);

/// Values of the Legendre polynomials at x = −1.
const ALTERNATING: [f64; LANES] = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0];

/// Independent partial sums of a product: they hide the latency of the multiply-add.
const WAYS: usize = 4;

/// `sums[n % WAYS] += a[n] columns[n]` for the 8 terms n of a group. These columns are zero beyond this group.
#[inline(always)]
fn add_columns<V: Vector, const GROUP: usize>(
    columns: &Columns<TERMS>,
    a: &Series,
    sums: &mut [[V; GROUPS]; WAYS],
) {
    for first in (GROUP * LANES..(GROUP + 1) * LANES).step_by(WAYS) {
        for way in 0..WAYS {
            let (weight, column) = (V::splat(a[first + way]), &columns.0[first + way]);
            for g in 0..=GROUP {
                let group = V::read(&column[g * LANES..]);
                sums[way][g] = group.multiply_add(weight, sums[way][g]);
            }
        }
    }
}

/// The image of a series under a table's map.
#[inline(always)]
fn mapped<V: Vector>(columns: &Columns<TERMS>, a: &Series) -> Series {
    let mut sums = [[V::zero(); GROUPS]; WAYS];
    add_columns::<V, 0>(columns, a, &mut sums);
    add_columns::<V, 1>(columns, a, &mut sums);
    add_columns::<V, 2>(columns, a, &mut sums);
    let mut out = [0.0; TERMS];
    for g in 0..GROUPS {
        let sum = (sums[0][g].plus(sums[1][g])).plus(sums[2][g].plus(sums[3][g]));
        sum.write(&mut out[g * LANES..]);
    }
    out
}

impl<V: Vector> Arithmetic<TERMS> for Packed<V> {
    #[inline(always)]
    fn bounds(series: &Series) -> Bounds {
        let mut group = [V::zero(); GROUPS];
        for g in 0..GROUPS {
            group[g] = V::read(&series[g * LANES..]);
        }
        let total = group[0].plus(group[1].plus(group[2]));
        let sizes = (group[0].size()).plus(group[1].size().plus(group[2].size()));
        Bounds {
            start: total.times(V::read(&ALTERNATING)).sum(),
            end: total.sum(),
            variation: sizes.sum() - series[0].abs(),
        }
    }

    #[inline(always)]
    fn derivative(transforms: &Transforms<TERMS>, series: &Series) -> Series {
        mapped::<V>(transforms.to_derivative(), series)
    }

    #[inline(always)]
    fn quotient(transforms: &Transforms<TERMS>, series: &Series) -> Series {
        mapped::<V>(transforms.to_quotient(), series)
    }

    #[inline(always)]
    fn half(transforms: &Transforms<TERMS>, series: &Series, side: usize) -> Series {
        mapped::<V>(transforms.to_half(side), series)
    }

    #[inline(always)]
    fn scaled(series: &Series, factor: f64, constant: f64) -> Series {
        let mut out = [0.0; TERMS];
        for g in 0..GROUPS {
            let term = match g {
                0 => V::first(constant),
                _ => V::zero(),
            };
            let group = V::read(&series[g * LANES..]).multiply_add(V::splat(factor), term);
            group.write(&mut out[g * LANES..]);
        }
        out
    }

    #[inline(always)]
    fn samples(transforms: &Transforms<TERMS>, series: &Series) -> [f64; SAMPLES] {
        let mut sums = [[V::zero(); SAMPLES / LANES]; WAYS];
        for first in (0..TERMS).step_by(WAYS) {
            for way in 0..WAYS {
                let values = &transforms.to_samples().0[first + way];
                let weight = V::splat(series[first + way]);
                for g in 0..SAMPLES / LANES {
                    let group = V::read(&values[g * LANES..]);
                    sums[way][g] = group.multiply_add(weight, sums[way][g]);
                }
            }
        }
        let mut out = [0.0; SAMPLES];
        for g in 0..SAMPLES / LANES {
            let sum = (sums[0][g].plus(sums[1][g])).plus(sums[2][g].plus(sums[3][g]));
            sum.write(&mut out[g * LANES..]);
        }
        out
    }

    #[inline(always)]
    fn derivatives_at(series: &Series, x: f64) -> [f64; 3] {
        if V::FUSED {
            legendre::evaluate_with_derivatives::<_, true>(series, x)
        } else {
            legendre::evaluate_with_derivatives::<_, false>(series, x)
        }
    }
}

#[inline(always)]
pub(super) fn first_crossing_body<V: Vector>(
    deflection: &Series,
    noise: f64,
    guards: &[Guard<'_, TERMS>],
    limit: f64,
    counters: &mut Counters,
) -> Option<Crossing> {
    let transforms = transforms24();
    events::first_crossing::<_, Packed<V>>(transforms, deflection, noise, guards, limit, counters)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::arithmetic::Portable;
    use crate::numerics::legendre::sample_place;
    use crate::numerics::random::Stream;
    use crate::propagate::vectors::{InstructionSet, for_each_set};

    /// Maps by tables agree with the recurrences, and bounds agree with evaluation.
    fn check<V: Vector>() {
        let (mut stream, t) = (Stream::new(8, 0, 0), transforms24());
        let a: Series = std::array::from_fn(|_| stream.normal());
        let pairs = |found: Series, exact: Series, size: f64| {
            for (found, exact) in found.iter().zip(&exact) {
                assert!((found - exact).abs() <= 1e-15 * size, "{found} {exact}");
            }
        };
        pairs(
            Packed::<V>::derivative(t, &a),
            Portable::derivative(t, &a),
            2e3,
        );
        pairs(Packed::<V>::quotient(t, &a), Portable::quotient(t, &a), 2e4);
        for side in 0..2 {
            pairs(Packed::<V>::half(t, &a, side), t.half(&a, side), 1e2);
        }
        let bounds = Packed::<V>::bounds(&a);
        assert!((bounds.start - legendre::evaluate(&a, -1.0)).abs() < 1e-13);
        assert!((bounds.end - legendre::evaluate(&a, 1.0)).abs() < 1e-13);
        assert!((bounds.variation - legendre::variation(&a)).abs() < 1e-13);
        for (m, found) in Packed::<V>::samples(t, &a).into_iter().enumerate() {
            assert!((found - legendre::evaluate(&a, sample_place(m))).abs() < 1e-13);
        }
        let scaled = Packed::<V>::scaled(&a, -2.0, 0.25);
        assert_eq!((scaled[0], scaled[5]), (0.25 - 2.0 * a[0], -2.0 * a[5]));
    }

    for_each_set! {
        /// Checks the vectors of a set.
        fn check_with() = check
    }

    #[test]
    fn arithmetic_in_vectors_is_that_of_series() {
        for set in InstructionSet::available() {
            check_with(set);
        }
    }
}
