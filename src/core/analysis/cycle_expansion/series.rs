//! What do the periodic orbits of a map say of averages over its chaotic set?
//!
//! An orbit p of n_p iterations has the multipliers μ, of which those outside the unit circle
//! multiply to Λ_p, and the sum A_p of an observable along it. With
//!
//! ```text
//! dynamical zeta function    1/ζ(z, β) = Π_p (1 − z^{n_p} e^{βA_p} / |Λ_p|)
//! spectral determinant       F(z, β)   = exp(−Σ_p Σ_r z^{r n_p} e^{rβA_p} / (r |det(1 − M_p^r)|))
//! ```
//!
//! as power series in z, cut off after order n, which takes the orbits of up to n iterations and no
//! others, the average per iteration is `F_β / (z F_z)` at β = 0 and the smallest zero z₀ > 0; an
//! attractor loses nothing, so that the escape rate ln z₀ shows what is missing
//! (Artuso, Aurell & Cvitanović 1990). Both are held against the plain sum over all points of
//! period n with weights `1/|det(1 − Mⁿ)|`, which add up to 1 as n grows.

use num_complex::Complex64;

/// Largest z at which a zero is sought; an escape rate of ln 4 an iteration means nothing.
const FARTHEST_ZERO: f64 = 4.0;

/// Step in z in which the first change of sign is sought.
const STEP: f64 = 1.0 / 512.0;

/// An orbit that is no other's repetition.
#[derive(Debug, Clone, Copy)]
pub struct Prime<'a> {
    /// Iterations of the map in a period.
    pub length: usize,
    /// Its multipliers.
    pub multipliers: &'a [Complex64],
    /// Sums of the observables along it.
    pub sums: &'a [f64],
}

impl Prime<'_> {
    /// `1/|Λ|`: how thin the set is about it.
    fn weight(&self) -> f64 {
        let moduli = self.multipliers.iter().map(|m| m.norm());
        1.0 / moduli.filter(|modulus| *modulus > 1.0).product::<f64>()
    }

    /// `1/|det(1 − Mʳ)|`.
    fn trace(&self, repeats: usize) -> f64 {
        let factors = self.multipliers.iter();
        1.0 / factors
            .map(|m| (1.0 - m.powu(repeats as u32)).norm())
            .product::<f64>()
    }
}

/// A series in z cut off at some order, and its derivatives by the β of every observable.
#[derive(Debug, Clone)]
struct Series {
    terms: Vec<f64>,
    by_beta: Vec<Vec<f64>>,
}

/// What a series says.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Logarithm of its smallest zero, per iteration.
    pub escape: f64,
    /// Averages of the observables, per iteration.
    pub averages: Vec<f64>,
}

impl Series {
    /// The series 1.
    fn one(order: usize, observables: usize) -> Self {
        let mut terms = vec![0.0; order + 1];
        terms[0] = 1.0;
        Self {
            terms,
            by_beta: vec![vec![0.0; order + 1]; observables],
        }
    }

    /// What its terms up to an order say; none where they have no zero.
    fn read(&self, order: usize) -> Option<Reading> {
        let terms = &self.terms[..=order];
        let zero = smallest_zero(terms)?;
        let slope: f64 = (terms.iter().enumerate())
            .map(|(n, a)| n as f64 * a * zero.powi(n as i32))
            .sum();
        let averages = (self.by_beta.iter())
            .map(|by| evaluate(&by[..=order], zero) / slope)
            .collect();
        Some(Reading {
            escape: zero.ln(),
            averages,
        })
    }
}

fn evaluate(terms: &[f64], z: f64) -> f64 {
    terms.iter().rev().fold(0.0, |sum, a| sum * z + a)
}

/// The smallest positive zero of a series that begins with 1.
fn smallest_zero(terms: &[f64]) -> Option<f64> {
    let mut low = 0.0;
    while low < FARTHEST_ZERO {
        let high = low + STEP;
        if evaluate(terms, high) <= 0.0 {
            let (mut inside, mut outside) = (low, high);
            // As far as halving goes in double precision.
            for _ in 0..f64::MANTISSA_DIGITS {
                let middle = 0.5 * (inside + outside);
                match evaluate(terms, middle) > 0.0 {
                    true => inside = middle,
                    false => outside = middle,
                }
            }
            return Some(0.5 * (inside + outside));
        }
        low = high;
    }
    None
}

/// The dynamical zeta function up to an order.
fn zeta(orbits: &[Prime<'_>], order: usize, observables: usize) -> Series {
    let mut series = Series::one(order, observables);
    for orbit in orbits.iter().filter(|orbit| orbit.length <= order) {
        let weight = orbit.weight();
        let n = orbit.length;
        for (by, sum) in series.by_beta.iter_mut().zip(orbit.sums) {
            for k in (n..=order).rev() {
                by[k] -= weight * (by[k - n] + sum * series.terms[k - n]);
            }
        }
        for k in (n..=order).rev() {
            series.terms[k] -= weight * series.terms[k - n];
        }
    }
    series
}

/// Sums over the points of each period 1 … order, with repetitions: of the weights
/// `1/|det(1 − Mⁿ)|`, and of the weights times the observables' sums.
struct Traces {
    weights: Vec<f64>,
    sums: Vec<Vec<f64>>,
}

impl Traces {
    fn new(orbits: &[Prime<'_>], order: usize, observables: usize) -> Self {
        let mut traces = Self {
            weights: vec![0.0; order + 1],
            sums: vec![vec![0.0; order + 1]; observables],
        };
        for orbit in orbits {
            for repeats in 1..=order / orbit.length {
                let n = repeats * orbit.length;
                let weight = orbit.length as f64 * orbit.trace(repeats);
                traces.weights[n] += weight;
                for (by, sum) in traces.sums.iter_mut().zip(orbit.sums) {
                    by[n] += weight * repeats as f64 * sum;
                }
            }
        }
        traces
    }

    /// The spectral determinant: `n F_n = −Σ_m C_m F_{n−m}` with C_m the weights of period m.
    fn determinant(&self) -> Series {
        let order = self.weights.len() - 1;
        let mut series = Series::one(order, self.sums.len());
        for n in 1..=order {
            for m in 1..=n {
                let share = -self.weights[m] / n as f64;
                series.terms[n] += share * series.terms[n - m];
            }
        }
        for (by, sums) in series.by_beta.iter_mut().zip(&self.sums) {
            for n in 1..=order {
                for m in 1..=n {
                    by[n] -=
                        (self.weights[m] * by[n - m] + sums[m] * series.terms[n - m]) / n as f64;
                }
            }
        }
        series
    }

    /// The plain sum over the points of one period; none where there are none.
    fn plain(&self, n: usize) -> Option<Vec<f64>> {
        let weight = self.weights[n];
        (weight > 0.0).then(|| {
            let sums = self.sums.iter();
            sums.map(|by| by[n] / (n as f64 * weight)).collect()
        })
    }
}

/// What the orbits of up to an order say.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// Sum of `1/|det(1 − Mⁿ)|` over the points of period n, 1 where they are all there.
    pub conservation: f64,
    /// Growth rate per iteration of the number of points, from the orbits' own zeta function.
    pub entropy: Option<f64>,
    /// The dynamical zeta function's reading.
    pub zeta: Option<Reading>,
    /// The spectral determinant's.
    pub determinant: Option<Reading>,
    /// Averages by the plain sum.
    pub plain: Option<Vec<f64>>,
}

/// What orbits say at the orders 1 … `order`, in turn. Every orbit has as many `observables`.
pub fn expand(orbits: &[Prime<'_>], order: usize, observables: usize) -> Vec<Order> {
    let zeta = zeta(orbits, order, observables);
    let traces = Traces::new(orbits, order, observables);
    let determinant = traces.determinant();
    // Of the number of points, all orbits count alike.
    let alike: Vec<Prime<'_>> = (orbits.iter())
        .map(|orbit| Prime {
            multipliers: &[],
            sums: &[],
            ..*orbit
        })
        .collect();
    let topological = self::zeta(&alike, order, 0);
    (1..=order)
        .map(|n| Order {
            conservation: traces.weights[n],
            entropy: topological.read(n).map(|reading| -reading.escape),
            zeta: zeta.read(n),
            determinant: determinant.read(n),
            plain: traces.plain(n),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The orbits of a map that stretches by branch, one a word of symbols that is allowed: the
    /// inverse of branch s is `x = slope y + offset`. Observables x, x² and ln|Λ|.
    struct Planted {
        inverse: [[f64; 2]; 2],
        allowed: fn(&[usize]) -> bool,
        /// What is observed of a point.
        seen: fn(f64) -> f64,
    }

    struct Orbit {
        multipliers: Vec<Complex64>,
        sums: Vec<f64>,
        length: usize,
    }

    impl Planted {
        /// All prime orbits up to a length: words that are smaller than all of their rotations.
        fn orbits(&self, longest: usize) -> Vec<Orbit> {
            let mut orbits = Vec::new();
            for length in 1..=longest {
                for code in 0..1usize << length {
                    let word: Vec<usize> = (0..length).map(|i| code >> i & 1).collect();
                    let rotated = |by: usize| [&word[by..], &word[..by]].concat();
                    let prime = (1..length).all(|by| rotated(by) > word);
                    if prime && (self.allowed)(&word) {
                        orbits.push(self.orbit(&word));
                    }
                }
            }
            orbits
        }

        fn orbit(&self, word: &[usize]) -> Orbit {
            let length = word.len();
            let mut sums = vec![0.0; 3];
            let mut inverse = 1.0;
            for first in 0..length {
                // x = slope x + offset around the word.
                let (mut slope, mut offset) = (1.0, 0.0);
                for place in 0..length {
                    let [own, by] = self.inverse[word[(first + place) % length]];
                    (slope, offset) = (slope * own, offset + slope * by);
                }
                let x = (self.seen)(offset / (1.0 - slope));
                sums[0] += x;
                sums[1] += x * x;
                inverse = slope;
            }
            sums[2] = -inverse.abs().ln();
            Orbit {
                multipliers: vec![Complex64::new(1.0 / inverse, 0.0)],
                sums,
                length,
            }
        }
    }

    fn skew_tent(a: f64) -> Planted {
        Planted {
            inverse: [[a, 0.0], [a - 1.0, 1.0]],
            allowed: |_| true,
            seen: |x| x,
        }
    }

    fn golden() -> f64 {
        0.5 * (1.0 + 5f64.sqrt())
    }

    /// `x → φ x mod 1`: one 1 never follows another.
    fn golden_mean() -> Planted {
        let slope = 1.0 / golden();
        Planted {
            inverse: [[slope, 0.0], [slope, slope]],
            allowed: |word| {
                let n = word.len();
                (0..n).all(|i| word[i] + word[(i + 1) % n] < 2)
            },
            seen: |x| x,
        }
    }

    fn primes(orbits: &[Orbit]) -> Vec<Prime<'_>> {
        (orbits.iter())
            .map(|orbit| Prime {
                length: orbit.length,
                multipliers: &orbit.multipliers,
                sums: &orbit.sums,
            })
            .collect()
    }

    fn numbers(orbits: &[Orbit], longest: usize) -> Vec<usize> {
        let of = |n| orbits.iter().filter(|orbit| orbit.length == n).count();
        (1..=longest).map(of).collect()
    }

    /// Largest error of the averages by each way at an order.
    fn errors(order: &Order, exact: [f64; 3]) -> [f64; 3] {
        let error = |averages: &[f64]| {
            let apart = averages.iter().zip(exact).map(|(a, b)| (a - b).abs());
            apart.fold(0.0, f64::max)
        };
        [
            error(&order.zeta.as_ref().unwrap().averages),
            error(&order.determinant.as_ref().unwrap().averages),
            error(order.plain.as_ref().unwrap()),
        ]
    }

    #[test]
    fn a_full_shift_has_all_its_words_and_their_averages() {
        let a: f64 = 0.3;
        let orbits = skew_tent(a).orbits(10);
        assert_eq!(numbers(&orbits, 10), [2, 1, 2, 3, 6, 9, 18, 30, 56, 99]);
        let found = expand(&primes(&orbits), 10, 3);
        let lambda = -a * a.ln() - (1.0 - a) * (1.0 - a).ln();
        let exact = [0.5, 1.0 / 3.0, lambda];
        for (n, order) in found.iter().enumerate() {
            assert!((order.entropy.unwrap() - 2f64.ln()).abs() < 1e-12);
            let zeta = order.zeta.as_ref().unwrap();
            // All orbits are shadowed by shorter ones.
            assert!(zeta.escape.abs() < 1e-12, "{n}: {}", zeta.escape);
            assert!((zeta.averages[2] - lambda).abs() < 1e-11);
        }
        let last = &found[9];
        assert!((last.conservation - 1.0).abs() < 2e-4, "{last:?}");
        let [zeta, determinant, plain] = errors(last, exact);
        println!("{zeta:e} {determinant:e} {plain:e}");
        assert!(zeta < 1e-4 && determinant < 1e-8 && plain < 1e-4);
        // Errors fall from order to order.
        assert!(errors(&found[5], exact)[1] > 30.0 * determinant);
    }

    #[test]
    fn the_logistic_map_converges_though_one_orbit_is_twice_as_unstable() {
        let logistic = Planted {
            seen: |y| (0.5 * std::f64::consts::PI * y).sin().powi(2),
            ..skew_tent(0.5)
        };
        let mut orbits = logistic.orbits(10);
        // That of the word 0, where the sine squared is flat.
        orbits[0].multipliers[0] = Complex64::new(4.0, 0.0);
        orbits[0].sums[2] = 4f64.ln();
        let found = expand(&primes(&orbits), 10, 3);
        let exact = [0.5, 0.375, 2f64.ln()];
        let [zeta, determinant, plain] = errors(&found[9], exact);
        println!("{zeta:e} {determinant:e} {plain:e}");
        assert!(zeta < 2e-3 && determinant < 2e-3 && plain < 5e-4);
        // No orbit shadows the one at 0: errors halve from order to order, and no faster.
        for (before, now) in errors(&found[8], exact)
            .iter()
            .zip([zeta, determinant, plain])
        {
            assert!((1.7..2.1).contains(&(before / now)), "{before} {now}");
        }
        let escape = found[9].determinant.as_ref().unwrap().escape;
        assert!(escape.abs() < 5e-4, "{escape}");
    }

    #[test]
    fn a_pruned_shift_counts_what_is_allowed() {
        let orbits = golden_mean().orbits(10);
        assert_eq!(numbers(&orbits, 10), [1, 1, 1, 1, 2, 2, 4, 5, 8, 11]);
        let phi = golden();
        // Density of the map: φ h below 1/φ and h above.
        let h = 1.0 / (1.0 + phi.powi(-2));
        let moment = |k: i32| {
            let part = phi.powi(-k - 1);
            h * (phi * part + 1.0 - part) / f64::from(k + 1)
        };
        let found = expand(&primes(&orbits), 10, 3);
        let exact = [moment(1), moment(2), phi.ln()];
        let last = &found[9];
        assert!((last.entropy.unwrap() - phi.ln()).abs() < 1e-12);
        let [zeta, determinant, plain] = errors(last, exact);
        println!("{zeta:e} {determinant:e} {plain:e}");
        assert!(zeta < 2e-3 && determinant < 2e-6 && plain < 2e-3);
    }

    #[test]
    fn an_orbit_left_out_shows_as_escape() {
        let mut orbits = skew_tent(0.4).orbits(8);
        let whole = expand(&primes(&orbits), 8, 3);
        orbits.remove(2);
        let broken = expand(&primes(&orbits), 8, 3);
        let own = |found: &[Order]| found[1].zeta.as_ref().unwrap().escape;
        assert!(own(&whole).abs() < 1e-12 && own(&broken) > 0.5);
        let later = |found: &[Order]| found[7].determinant.as_ref().unwrap().escape;
        assert!(later(&whole).abs() < 1e-8 && later(&broken) > 1e-3);
        assert!(broken[1].conservation < 0.8 && (whole[7].conservation - 1.0).abs() < 1e-3);
    }
}
