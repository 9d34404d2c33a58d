//! The inner loops of the statistics, compiled for several instruction sets and chosen at run time.
//!
//! A series on a window is the sum of an even and an odd part about the window's middle. Both parts at the
//! positive nodes of a Gauss rule give its values at all nodes, with half the work. The results of different
//! instruction sets differ by rounding, because multiply and add are fused or separate. Results of `portable`
//! do not differ.

use crate::numerics::bessel::{LANES as SIXTEEN, spherical_bessel};
use crate::propagate::InstructionSet;
use crate::propagate::vectors::{LANES, Lanes, Row, Series, TERMS, Vector, for_each_set};

/// Real and imaginary parts of eight numbers.
pub type Complex = [Lanes; 2];

/// Eight frequencies, as parts of the mesh frequency.
#[derive(Debug, Clone, Copy)]
pub struct FrequencyGroup {
    /// Orders of the eight frequencies.
    pub orders: Lanes,
    /// 1 for orders that are not whole, whose phases differ between the starts of mesh cycles; 0 for whole orders.
    pub fractions: Lanes,
}

/// `∫ P_n e^{−iω(t − middle)} dt` of eight frequencies over a window by term: the real part of even
/// terms, the imaginary part of odd ones. The other parts are zero.
pub type Integrals = [Lanes; TERMS];

/// A window's length and the phase of its middle.
#[derive(Debug, Clone, Copy)]
pub struct WindowPhase {
    /// Length \[s\].
    pub duration: f64,
    /// Length in mesh cycles.
    pub cycles: f64,
    /// Middle, in mesh cycles from the start of the present one.
    pub middle: f64,
    /// Mesh cycles before the present one, modulo 12, for phases of sub-orders.
    pub before: f64,
}

/// Number of sums in [`sizes`].
pub const SIZES: usize = LANES;

for_each_set! {
    /// Weighted sums over a series, each with a row of weights: of `|a_n|` with the first five rows, of `a_n²`
    /// with the sixth row, of `a_n` with the others.
    fn sizes(weights: &[Row; SIZES], series: &Series) -> [f64; SIZES] = sizes_body
}

for_each_set! {
    /// Writes the even part, then the odd part of a series at positive nodes to `out`. `polynomials` has the values of
    /// P_0, then of P_1, … at these nodes. Returns the smallest and the largest value at all nodes.
    fn parts(polynomials: &[Lanes], series: &Series, out: &mut [Lanes]) -> [f64; 2] = parts_body
}

for_each_set! {
    /// Weighted sums of the third and fourth powers of `(value − centre)/unit` over all nodes.
    fn powers(weights: &[Lanes], parts: &[Lanes], centre: f64, unit: f64) -> [f64; 2] = powers_body
}

for_each_set! {
    /// Adds Fourier integrals of a series over a window to those of all frequencies, from the `integrals` of
    /// its polynomials.
    fn add_by_terms(
        frequencies: &[FrequencyGroup],
        integrals: &[Integrals],
        series: &Series,
        stretch: &WindowPhase,
        sums: &mut [Complex],
    ) = add_by_terms_body
}

for_each_set! {
    /// Adds the same Fourier integrals by a Gauss rule, from the parts of the series at its nodes, for the
    /// frequencies of [`super::fourier`].
    fn add_by_nodes(
        frequencies: &[FrequencyGroup],
        places: &[Lanes],
        weights: &[Lanes],
        parts: &[Lanes],
        stretch: &WindowPhase,
        sums: &mut [Complex],
    ) = add_by_nodes_body
}

for_each_set! {
    /// Writes the integrals of the polynomials for an even number of groups of eight frequencies, by
    /// `τ (−i)ⁿ j_n(ωτ/2)` (A&S 10.1.14).
    fn integrate(frequencies: &[FrequencyGroup], stretch: &WindowPhase, out: &mut [Integrals]) = integrate_body
}

#[inline(always)]
fn sizes_body<V: Vector>(weights: &[Row; SIZES], series: &Series) -> [f64; SIZES] {
    let mut sums = [V::zero(); SIZES];
    for base in (0..TERMS).step_by(LANES) {
        let a = V::read(&series[base..]);
        let size = a.size();
        let of = [size, size, size, size, size, a.times(a), a, a];
        for k in 0..SIZES {
            sums[k] = of[k].multiply_add(V::read(&weights[k].0[base..]), sums[k]);
        }
    }
    V::sums(sums).lanes().0
}

#[inline(always)]
fn parts_body<V: Vector>(polynomials: &[Lanes], series: &Series, out: &mut [Lanes]) -> [f64; 2] {
    match out.len() {
        4 => parts_of::<V, 2>(polynomials, series, out),
        _ => parts_of::<V, 3>(polynomials, series, out),
    }
}

#[inline(always)]
fn parts_of<V: Vector, const G: usize>(
    polynomials: &[Lanes],
    series: &Series,
    out: &mut [Lanes],
) -> [f64; 2] {
    let mut sums = [[V::zero(); G]; 2];
    let pairs = polynomials.chunks_exact(2 * G);
    for (a, rows) in series.chunks_exact(2).zip(pairs) {
        for odd in 0..2 {
            let a = V::splat(a[odd]);
            for g in 0..G {
                sums[odd][g] = V::read(&rows[odd * G + g].0).multiply_add(a, sums[odd][g]);
            }
        }
    }
    let [even, odd] = sums;
    let (mut low, mut high) = (V::splat(f64::INFINITY), V::splat(f64::NEG_INFINITY));
    for g in 0..G {
        out[g] = even[g].lanes();
        out[G + g] = odd[g].lanes();
        let (right, left) = (even[g].plus(odd[g]), even[g].minus(odd[g]));
        low = low.smaller(right.smaller(left));
        high = high.larger(right.larger(left));
    }
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for (low, high) in low.lanes().0.into_iter().zip(high.lanes().0) {
        least = if low < least { low } else { least };
        most = if high > most { high } else { most };
    }
    [least, most]
}

/// With e and o the parts about the centre, `Σ w ((e + o)³ + (e − o)³)/2 = Σ w e (e² + 3 o²)`, and
/// `Σ w (e⁴ + 6 e² o² + o⁴)`.
#[inline(always)]
fn powers_body<V: Vector>(weights: &[Lanes], parts: &[Lanes], centre: f64, unit: f64) -> [f64; 2] {
    let (even, odd) = parts.split_at(weights.len());
    let scale = V::splat(1.0 / unit);
    let (mut third, mut fourth) = (V::zero(), V::zero());
    for ((w, e), o) in weights.iter().zip(even).zip(odd) {
        let w = V::read(&w.0);
        let e = V::read(&e.0).minus(V::splat(centre)).times(scale);
        let o = V::read(&o.0).times(scale);
        let (e2, o2) = (e.times(e), o.times(o));
        let three = o2.multiply_add(V::splat(3.0), e2);
        third = w.times(e).multiply_add(three, third);
        let six = e2.multiply_add(V::splat(6.0), o2);
        fourth = w.multiply_add(e2.multiply_add(e2, o2.times(six)), fourth);
    }
    [third.sum(), fourth.sum()]
}

/// Adding and then subtracting this number rounds a small number to the nearest whole one.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// Coefficients of `cos πx` and `sin πx / x` for |x| ≤ 1/2 as polynomials in x², to round-off. The highest
/// power comes first.
const HALF_TURN: [[f64; 11]; 2] = half_turn();

/// `(−1)^k π^{2k + odd}/(2k + odd)!`, with k from the highest to 0.
const fn half_turn() -> [[f64; 11]; 2] {
    let mut out = [[0.0; 11]; 2];
    let (mut odd, mut n, mut term) = (0, 0, 1.0);
    while n < 22 {
        out[odd][10 - n / 2] = term;
        n += 1;
        term *= std::f64::consts::PI / n as f64;
        if odd == 1 {
            term = -term;
        }
        odd = 1 - odd;
    }
    out
}

/// Cosines and sines of 2πx.
#[inline(always)]
fn turn<V: Vector>(turns: V) -> [V; 2] {
    let whole = turns.plus(V::splat(ROUNDING)).minus(V::splat(ROUNDING));
    let rest = turns.minus(whole);
    let square = rest.times(rest);
    let mut half = [V::splat(HALF_TURN[0][0]), V::splat(HALF_TURN[1][0])];
    for k in 1..HALF_TURN[0].len() {
        for odd in 0..2 {
            half[odd] = half[odd].multiply_add(square, V::splat(HALF_TURN[odd][k]));
        }
    }
    half[1] = half[1].times(rest);
    product(half, half)
}

/// The product of complex numbers.
#[inline(always)]
fn product<V: Vector>(a: [V; 2], b: [V; 2]) -> [V; 2] {
    let minus = a[1].times(V::splat(-1.0));
    [
        a[0].multiply_add(b[0], minus.times(b[1])),
        a[0].multiply_add(b[1], a[1].times(b[0])),
    ]
}

/// Adds integrals about a window's middle, times `e^{−iφ}` with φ the middle's phase.
#[inline(always)]
fn add_turned<V: Vector>(
    group: &FrequencyGroup,
    stretch: &WindowPhase,
    value: [V; 2],
    sum: &mut Complex,
) {
    let before = V::read(&group.fractions.0).times(V::splat(stretch.before));
    let cycles = before.plus(V::splat(stretch.middle));
    let [cos, sin] = turn(V::read(&group.orders.0).times(cycles));
    let turned = product([cos, sin.times(V::splat(-1.0))], value);
    for (sum, value) in sum.iter_mut().zip(turned) {
        *sum = V::read(&sum.0).plus(value).lanes();
    }
}

#[inline(always)]
fn add_by_terms_body<V: Vector>(
    frequencies: &[FrequencyGroup],
    integrals: &[Integrals],
    series: &Series,
    stretch: &WindowPhase,
    sums: &mut [Complex],
) {
    for ((group, integrals), sum) in frequencies.iter().zip(integrals).zip(sums) {
        // Four independent sums, because in a single sum each addition waits for the previous one.
        let mut value = [[V::zero(); 2]; 2];
        for (half, (terms, rows)) in
            (series.chunks_exact(2).zip(integrals.chunks_exact(2))).enumerate()
        {
            for odd in 0..2 {
                let a = V::splat(terms[odd]);
                let sum = &mut value[half % 2][odd];
                *sum = V::read(&rows[odd].0).multiply_add(a, *sum);
            }
        }
        let [first, second] = value;
        let value = [first[0].plus(second[0]), first[1].plus(second[1])];
        add_turned(group, stretch, value, sum);
    }
}

/// Coefficients of `cos θ` and `sin θ / θ` for |θ| ≤ 0.3 as polynomials in θ². The highest power comes first.
const SLOW: [[f64; 7]; 2] = {
    let mut out = [[1.0; 7]; 2];
    let mut k = 6;
    while k > 0 {
        let n = (2 * (7 - k)) as f64;
        out[0][k - 1] = -out[0][k] / (n * (n - 1.0));
        out[1][k - 1] = -out[1][k] / (n * (n + 1.0));
        k -= 1;
    }
    out
};

/// `e^{iθ}` for |θ| ≤ 0.3.
#[inline(always)]
fn slow_turn<V: Vector>(theta: V) -> [V; 2] {
    let square = theta.times(theta);
    let mut out = [V::splat(SLOW[0][0]), V::splat(SLOW[1][0])];
    for k in 1..SLOW[0].len() {
        for odd in 0..2 {
            out[odd] = out[odd].multiply_add(square, V::splat(SLOW[odd][k]));
        }
    }
    [out[0], out[1].times(theta)]
}

#[inline(always)]
fn add_by_nodes_body<V: Vector>(
    frequencies: &[FrequencyGroup],
    places: &[Lanes],
    weights: &[Lanes],
    parts: &[Lanes],
    stretch: &WindowPhase,
    sums: &mut [Complex],
) {
    match weights.len() {
        2 => add_by_nodes_of::<V, 2>(frequencies, places, weights, parts, stretch, sums),
        _ => add_by_nodes_of::<V, 3>(frequencies, places, weights, parts, stretch, sums),
    }
}

#[inline(always)]
fn add_by_nodes_of<V: Vector, const G: usize>(
    frequencies: &[FrequencyGroup],
    places: &[Lanes],
    weights: &[Lanes],
    parts: &[Lanes],
    stretch: &WindowPhase,
    sums: &mut [Complex],
) {
    let slowest = V::splat(std::f64::consts::PI / 12.0 * stretch.cycles);
    let zero = [[V::zero(); 2]; G];
    let [mut weighted, mut one] = [zero; 2];
    for g in 0..G {
        let w = V::read(&weights[g].0).times(V::splat(stretch.duration));
        weighted[g][0] = w.times(V::read(&parts[g].0));
        weighted[g][1] = w.times(V::read(&parts[G + g].0)).times(V::splat(-1.0));
        one[g] = slow_turn(slowest.times(V::read(&places[g].0)));
    }
    let three = products(products(one, one), one);
    let four = products(three, one);
    let six = products(three, three);
    let twelve = products(six, six);
    let two_dozens = products(twelve, twelve);
    let mut z = products(two_dozens, twelve);
    // In the order of the frequencies of `fourier`, in twelfths of the mesh frequency: 3, 4, 6, 8, 9, 12, 24,
    // 36.
    let first = [
        three,
        four,
        six,
        products(four, four),
        products(six, three),
        twelve,
        two_dozens,
        z,
    ];
    for (eight, (group, sum)) in frequencies.iter().zip(sums).enumerate() {
        let mut found = [[V::zero(); LANES]; 2];
        for lane in 0..LANES {
            let z = match eight {
                0 => first[lane],
                _ => {
                    z = products(z, twelve);
                    z
                }
            };
            for part in 0..2 {
                let mut sum = z[0][part].times(weighted[0][part]);
                for g in 1..G {
                    sum = z[g][part].multiply_add(weighted[g][part], sum);
                }
                found[part][lane] = sum;
            }
        }
        let value = [V::sums(found[0]), V::sums(found[1])];
        add_turned(group, stretch, value, sum);
    }
}

#[inline(always)]
fn products<V: Vector, const G: usize>(a: [[V; 2]; G], b: [[V; 2]; G]) -> [[V; 2]; G] {
    let mut out = a;
    for g in 0..G {
        out[g] = product(a[g], b[g]);
    }
    out
}

#[inline(always)]
fn integrate_body<V: Vector>(
    frequencies: &[FrequencyGroup],
    stretch: &WindowPhase,
    out: &mut [Integrals],
) {
    for (pair, out) in frequencies.chunks_exact(2).zip(out.chunks_exact_mut(2)) {
        let (mut x, mut cos, mut sin) = ([0.0; SIXTEEN], [0.0; SIXTEEN], [0.0; SIXTEEN]);
        for (half, group) in pair.iter().enumerate() {
            let turns = V::read(&group.orders.0).times(V::splat(0.5 * stretch.cycles));
            let at = half * LANES;
            turns
                .times(V::splat(std::f64::consts::TAU))
                .write(&mut x[at..]);
            let [c, s] = turn(turns);
            c.write(&mut cos[at..]);
            s.write(&mut sin[at..]);
        }
        let mut bessel = [[0.0; SIXTEEN]; TERMS];
        spherical_bessel(&x, &sin, &cos, &mut bessel);
        for (n, j) in bessel.iter().enumerate() {
            let sign = [1.0, -1.0, -1.0, 1.0][n % 4] * stretch.duration;
            for half in 0..2 {
                let values = V::read(&j[half * LANES..]).times(V::splat(sign));
                out[half][n] = values.lanes();
            }
        }
    }
}
