//! How do deflections respond to states, forces and loads?
//!
//! For `z' = A z + Σ b f`, the deflection `δ = w·z` has the coefficients
//! `j! δ_j = h^j w A^j z(0) + Σ_m h^m w A^{m−1} b (j − m)! f_{j−m}` in powers of `u = t/h`. The rows `w A^j` and the
//! numbers `w A^{m−1} b` do not depend on h. The deflections and the forces of the contacts are therefore known
//! before the blocks move.

use super::powers::Powers;
use super::rows::Rows;
use crate::model::LOAD_TERMS;
use crate::propagate::vectors::{Aligned, LANES, TERMS, Vector};

/// j!, exact in doubles up to 22!; 23! is rounded.
pub const FACTORIALS: Powers = {
    let mut all = [1.0; TERMS];
    let mut j = 1;
    while j < TERMS {
        all[j] = all[j - 1] * j as f64;
        j += 1;
    }
    all
};

/// 1/j!.
pub const INVERSE_FACTORIALS: Powers = {
    let mut all = [1.0; TERMS];
    let mut j = 1;
    while j < TERMS {
        all[j] = 1.0 / FACTORIALS[j];
        j += 1;
    }
    all
};

/// A series of coefficients `j! a_j` after [`TERMS`] zeros. To delay the series, a loop reads it from an
/// earlier position.
pub type Delayed = [f64; 2 * TERMS];

/// The inputs for computing responses.
#[derive(Debug)]
pub struct ResponseInputs<'a> {
    /// Generators of the blocks: entries 00, 01, 10, 11.
    pub generator: &'a [Aligned; 4],
    /// ω \[1/s\]: powers of the generator are divided by powers of ω.
    pub rate: f64,
    /// Inputs of a unit force along every direction.
    pub forces: Vec<&'a Rows>,
    /// Inputs of each load; `None` for a load without effect.
    pub loads: &'a [Option<Rows>; LOAD_TERMS],
    /// Inputs of the ripples.
    pub ripples: &'a [Rows],
}

/// The responses along one direction.
#[derive(Debug, Clone)]
pub struct DirectionResponses {
    /// `w (A/ω)^j`: all powers for the first component of block 0, then of block 1, and so on; then the same
    /// for the second components.
    states: Aligned,
    /// Responses `w (A/ω)^{m−1} b` to forces along every direction.
    pub forces: Vec<Powers>,
    /// Responses to loads; `None` for a load without effect.
    pub loads: [Option<Powers>; LOAD_TERMS],
    /// Responses to ripples.
    pub ripples: Vec<Powers>,
}

impl DirectionResponses {
    /// Responses along a direction; `deflection` are the rows that map components to its deflection.
    pub fn new(structure: &ResponseInputs<'_>, deflection: &Rows) -> Self {
        let [a, b, c, d] = structure.generator;
        let ([first, second], n, rate) = (deflection, a.len(), structure.rate);
        let mut states = Aligned::zeros(2 * n * TERMS);
        for i in 0..n {
            let (mut p, mut q) = (first[i], second[i]);
            for j in 0..TERMS {
                states[i * TERMS + j] = p;
                states[(n + i) * TERMS + j] = q;
                (p, q) = ((p * a[i] + q * c[i]) / rate, (p * b[i] + q * d[i]) / rate);
            }
        }
        let to = |input: &Rows| {
            let mut out = [0.0; TERMS];
            // A force causes no instantaneous deflection: the term of m = 1 is zero except for rounding.
            for (m, sum) in out.iter_mut().enumerate().skip(2) {
                for (part, units) in input.iter().enumerate() {
                    for (i, unit) in units.iter().enumerate() {
                        *sum += states[(part * n + i) * TERMS + m - 1] * unit;
                    }
                }
            }
            out
        };
        Self {
            forces: structure.forces.iter().map(|input| to(input)).collect(),
            loads: (structure.loads.each_ref()).map(|input| input.as_ref().map(to)),
            ripples: structure.ripples.iter().map(to).collect(),
            states,
        }
    }

    /// `h^j w A^j z`, from the components z and the powers of h ω.
    #[inline(always)]
    pub fn to_state<V: Vector>(&self, components: [&[f64]; 2], scales: &Powers) -> Powers {
        const GROUPS: usize = TERMS / LANES;
        let n = components[0].len();
        let mut sums = [[V::zero(); GROUPS]; 2];
        let (first, second) = self.states.split_at(n * TERMS);
        let rows = first
            .as_chunks::<TERMS>()
            .0
            .iter()
            .zip(second.as_chunks::<TERMS>().0);
        let values = components[0].iter().zip(components[1]);
        for ((p, q), (x, y)) in rows.zip(values) {
            let (x, y) = (V::splat(*x), V::splat(*y));
            for group in 0..GROUPS {
                let at = group * LANES;
                sums[0][group] = V::read(&p[at..]).multiply_add(x, sums[0][group]);
                sums[1][group] = V::read(&q[at..]).multiply_add(y, sums[1][group]);
            }
        }
        let mut out = [0.0; TERMS];
        for group in 0..GROUPS {
            let at = group * LANES;
            let scale = V::read(&scales[at..]);
            let sum = sums[0][group].plus(sums[1][group]).times(scale);
            sum.write(&mut out[at..]);
        }
        out
    }
}

/// `h^m w A^{m−1} b` as a [`Delayed`] series.
#[inline(always)]
pub fn delayed(answer: &Powers, scales: &Powers, length: f64) -> Delayed {
    let mut out = [0.0; 2 * TERMS];
    for m in 1..TERMS {
        out[TERMS + m] = length * scales[m - 1] * answer[m];
    }
    out
}

/// Adds the response to a coefficient `j! f_j`. The response starts two powers later, so earlier lanes do not
/// change.
#[inline(always)]
pub fn answer<V: Vector>(series: &mut Powers, answer: &Delayed, factor: f64, j: usize) {
    let factor = V::splat(factor);
    let Some(later) = answer[TERMS - j..].first_chunk::<TERMS>() else {
        return;
    };
    for at in ((j + 2) / LANES * LANES..TERMS).step_by(LANES) {
        let sum = V::read(&later[at..]).multiply_add(factor, V::read(&series[at..]));
        sum.write(&mut series[at..]);
    }
}
