//! Damped sinusoids, many at a time: `Re Σ z e^{(α + iν)t}` and its derivatives.
//!
//! Sine, cosine and exponential are evaluated lane by lane with the polynomials of fdlibm (Sun Microsystems 1993) and a
//! Taylor series, to about one unit in the last place, for
//! |νt| below 10⁵.

use super::matrix::fma;
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// 1.5 · 2⁵²: adding it rounds to an integer, which then occupies the low bits of the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// π/2 in three parts, the first two of 33 bits.
const HALF_PI: [f64; 3] = [
    1.570_796_326_734_125_6,
    6.077_100_506_303_966e-11,
    2.022_266_248_795_950_6e-21,
];

/// ln 2 in two parts, the first of 32 bits.
const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];

/// Exponents are limited to this size, because larger ones overflow.
const LARGEST_EXPONENT: f64 = 700.0;

const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// 1/k!, k = 13 … 0.
const EXPONENTIAL: [f64; 14] = [
    1.605_904_383_682_161_3e-10,
    2.087_675_698_786_81e-9,
    2.505_210_838_544_172e-8,
    2.755_731_922_398_589e-7,
    2.755_731_922_398_589_3e-6,
    2.480_158_730_158_73e-5,
    1.984_126_984_126_984e-4,
    1.388_888_888_888_889e-3,
    8.333_333_333_333_333e-3,
    4.166_666_666_666_666_4e-2,
    1.666_666_666_666_666_6e-1,
    0.5,
    1.0,
    1.0,
];

/// `e^{αt} (cos νt, sin νt)`.
#[inline(always)]
fn factor<const FUSED: bool>(alpha: f64, nu: f64, time: f64) -> (f64, f64) {
    let x = nu * time;
    let shifted = fma::<FUSED>(x, std::f64::consts::FRAC_2_PI, ROUNDER);
    let quadrant = shifted.to_bits();
    let q = shifted - ROUNDER;
    let r = fma::<FUSED>(-q, HALF_PI[0], x);
    let r = fma::<FUSED>(-q, HALF_PI[1], r);
    let r = fma::<FUSED>(-q, HALF_PI[2], r);
    let z = r * r;
    let mut p = SINE[5];
    let mut c = COSINE[5];
    for k in (0..5).rev() {
        p = fma::<FUSED>(p, z, SINE[k]);
        c = fma::<FUSED>(c, z, COSINE[k]);
    }
    let sine = fma::<FUSED>(r * z, p, r);
    let half = 0.5 * z;
    let whole = 1.0 - half;
    let cosine = whole + fma::<FUSED>(z * z, c, (1.0 - whole) - half);
    let swap = 0u64.wrapping_sub(quadrant & 1);
    let (s, k) = (sine.to_bits(), cosine.to_bits());
    let s_turned = ((s & !swap) | (k & swap)) ^ ((quadrant & 2) << 62);
    let c_turned = ((k & !swap) | (s & swap)) ^ ((quadrant.wrapping_add(1) & 2) << 62);

    let y = (alpha * time).clamp(-LARGEST_EXPONENT, LARGEST_EXPONENT);
    let shifted = fma::<FUSED>(y, std::f64::consts::LOG2_E, ROUNDER);
    let n = shifted - ROUNDER;
    let r = fma::<FUSED>(-n, LN_2[0], y);
    let r = fma::<FUSED>(-n, LN_2[1], r);
    let mut e = EXPONENTIAL[0];
    for term in &EXPONENTIAL[1..] {
        e = fma::<FUSED>(e, r, *term);
    }
    let power = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0f64.to_bits()));
    let size = e * power;
    (
        size * f64::from_bits(c_turned),
        size * f64::from_bits(s_turned),
    )
}

/// Writes `e^{αt} (cos νt, sin νt)` of all waves.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub fn factors(rates: [&[f64]; 2], time: f64, cosine: &mut [f64], sine: &mut [f64]) {
    if target_cfg_f!(target_feature = "fma") {
        factors_body::<true>(rates, time, cosine, sine);
    } else {
        factors_body::<false>(rates, time, cosine, sine);
    }
}

#[inline(always)]
fn factors_body<const FUSED: bool>(
    [alpha, nu]: [&[f64]; 2],
    time: f64,
    cosine: &mut [f64],
    sine: &mut [f64],
) {
    let rates = alpha.iter().zip(nu);
    for ((a, n), (c, s)) in rates.zip(cosine.iter_mut().zip(sine)) {
        (*c, *s) = factor::<FUSED>(*a, *n, time);
    }
}

/// Value, first and second derivative at a time of the sum of waves with complex amplitudes.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub fn sum(rates: [&[f64]; 2], amplitudes: [&[f64]; 2], time: f64) -> [f64; 3] {
    if target_cfg_f!(target_feature = "fma") {
        sum_body::<true>(rates, amplitudes, time)
    } else {
        sum_body::<false>(rates, amplitudes, time)
    }
}

const LANES: usize = 8;

/// Number of waves per block.
const BLOCK: usize = 64;

/// The sum of whole lane groups.
#[inline(always)]
fn total(values: &[f64]) -> f64 {
    let mut s = [0.0; LANES];
    for chunk in values.as_chunks::<LANES>().0 {
        for l in 0..LANES {
            s[l] += chunk[l];
        }
    }
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}

#[inline(always)]
fn sum_body<const FUSED: bool>(
    [alpha, nu]: [&[f64]; 2],
    [re, im]: [&[f64]; 2],
    time: f64,
) -> [f64; 3] {
    let mut sums = [0.0; 3];
    let mut room = [[0.0; BLOCK]; 3];
    for start in (0..alpha.len()).step_by(BLOCK) {
        let end = alpha.len().min(start + BLOCK);
        let (alpha, nu) = (&alpha[start..end], &nu[start..end]);
        let [x, y, z] = &mut room;
        let size = end - start;
        let (x, y, z) = (&mut x[..size], &mut y[..size], &mut z[..size]);
        factors_body::<FUSED>([alpha, nu], time, x, y);
        let amplitudes = re[start..end].iter().zip(&im[start..end]);
        let values = x.iter_mut().zip(y.iter_mut().zip(z.iter_mut()));
        for (((a, n), (p, q)), (x, (y, z))) in alpha.iter().zip(nu).zip(amplitudes).zip(values) {
            let (c, s) = (*x, *y);
            let (u, v) = (p * c - q * s, p * s + q * c);
            let (du, dv) = (a * u - n * v, a * v + n * u);
            (*x, *y, *z) = (u, du, a * du - n * dv);
        }
        for (sum, values) in sums.iter_mut().zip([&*x, &*y, &*z]) {
            *sum += total(values);
        }
    }
    sums
}

/// Rotates the coordinates (u, v) of all waves by the factors.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub fn turn(factors: [&[f64]; 2], u: &mut [f64], v: &mut [f64]) {
    let [cosine, sine] = factors;
    for ((c, s), (u, v)) in cosine.iter().zip(sine).zip(u.iter_mut().zip(v)) {
        (*u, *v) = (c * *u - s * *v, s * *u + c * *v);
    }
}

/// Writes the complex amplitudes `(g − ih)(u + iv)` of the waves of δ to `re` and `im`. Returns the sums of
/// |re| + |im|, weighted by the powers 0 … 3 of the rates `sizes`.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub fn amplitudes(
    gains: [&[f64]; 2],
    coordinates: [&[f64]; 2],
    sizes: &[f64],
    re: &mut [f64],
    im: &mut [f64],
) -> [f64; 4] {
    let [g, h] = gains;
    let [u, v] = coordinates;
    let (g, h, u, v) = (g.iter(), h.iter(), u.iter(), v.iter());
    let terms = g.zip(h).zip(u.zip(v));
    for (((g, h), (u, v)), (re, im)) in terms.zip(re.iter_mut().zip(im.iter_mut())) {
        (*re, *im) = (g * u + h * v, g * v - h * u);
    }
    let mut sums = [0.0; 4];
    let mut room = [[0.0; BLOCK]; 4];
    for start in (0..re.len()).step_by(BLOCK) {
        let end = re.len().min(start + BLOCK);
        let [a, b, c, d] = &mut room;
        let size = end - start;
        let (a, b, c, d) = (
            &mut a[..size],
            &mut b[..size],
            &mut c[..size],
            &mut d[..size],
        );
        let parts = re[start..end]
            .iter()
            .zip(&im[start..end])
            .zip(&sizes[start..end]);
        let out = a
            .iter_mut()
            .zip(b.iter_mut())
            .zip(c.iter_mut().zip(d.iter_mut()));
        for (((re, im), rate), ((a, b), (c, d))) in parts.zip(out) {
            *a = re.abs() + im.abs();
            *b = *a * rate;
            *c = *b * rate;
            *d = *c * rate;
        }
        for (sum, values) in sums.iter_mut().zip([&*a, &*b, &*c, &*d]) {
            *sum += total(values);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_those_of_the_library() {
        for t in [1e-9, 0.01, 0.3, 1.0, 7.7] {
            for (alpha, nu) in [
                (0.0, 0.1),
                (-0.3, 2.0),
                (-1.0, 33.3),
                (0.5, 1234.5),
                (-80.0, 0.0),
            ] {
                let (mut c, mut s) = ([f64::NAN; 8], [f64::NAN; 8]);
                factors([&[alpha; 8], &[nu; 8]], t, &mut c, &mut s);
                let (sin, cos) = (nu * t).sin_cos();
                let size = (alpha * t).exp();
                let off = (c[0] - size * cos).abs().max((s[7] - size * sin).abs());
                assert!(off < 4e-16 * size, "{alpha} {nu} {t}: {off:e}");
            }
        }
    }

    #[test]
    fn sums_have_their_derivatives() {
        let (alpha, nu) = ([-0.3; 8], [2.0; 8]);
        let (re, im) = ([0.4; 8], [-0.7; 8]);
        let at = |t: f64| sum([&alpha, &nu], [&re, &im], t);
        let exact = |t: f64| {
            let (sin, cos) = (2.0 * t).sin_cos();
            8.0 * (-0.3 * t).exp() * (0.4 * cos + 0.7 * sin)
        };
        let h = 1e-4;
        for t in [0.0, 0.9, 3.3] {
            let [value, slope, curvature] = at(t);
            assert!((value - exact(t)).abs() < 1e-14);
            assert!((slope - (at(t + h)[0] - at(t - h)[0]) / (2.0 * h)).abs() < 1e-6);
            assert!((curvature - (at(t + h)[1] - at(t - h)[1]) / (2.0 * h)).abs() < 1e-6);
        }
    }
}
