//! The inner loops, compiled for several instruction sets and chosen at run time.
//!
//! Every loop is written once over arrays of lanes ([`window`] for whole windows, [`cut`] for
//! those cut short); with the target features switched on the compiler turns it into the
//! machine's vectors (closures would not inherit the features, so there are none). A call
//! does all that one window needs, so that the choice of the set costs little. Results
//! differ between instruction sets within rounding (fused or separate multiply-add), never
//! between runs on one.

mod cut;
mod varying;
mod window;

pub use cut::{Basis, ExponentialChunk};
pub use window::{Solution, Windows};

use super::TERMS;
use super::feedback::Feedback;
use super::tables::{BlockChunk, Row, Series};
use super::varying::{Factors, Nodal};
use crate::model::{Contact, STIFFNESS_TERMS, Surface};
use crate::numerics::legendre::transforms24;
use crate::propagate::Counters;
use crate::propagate::events::{self, Crossing};

/// Blocks carried side by side.
pub const LANES: usize = 8;

/// One lane group, on a cache line of its own: a vector load never straddles two.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// All zero.
    pub const ZERO: Self = Self([0.0; LANES]);
}

/// Instruction set of the inner loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InstructionSet(Level);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Level {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// What every machine has.
    pub const PORTABLE: Self = Self(Level::Portable);

    /// All sets this machine has, slowest first.
    pub fn available() -> Vec<Self> {
        #[allow(unused_mut)]
        let mut sets = vec![Self::PORTABLE];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                sets.push(Self(Level::Avx2));
                if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                    sets.push(Self(Level::Avx512));
                }
            }
        }
        sets
    }

    /// The fastest set this machine has.
    pub fn best() -> Self {
        Self::available().last().copied().unwrap_or(Self::PORTABLE)
    }

    /// Its usual name.
    pub fn name(self) -> &'static str {
        match self.0 {
            Level::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => "avx512",
        }
    }
}

/// What a body may use: no fused multiply-add.
const PLAIN: u8 = 0;
/// Fused multiply-add.
#[cfg(target_arch = "x86_64")]
const FUSED: u8 = 1;
/// Fused multiply-add and vectors of 8.
#[cfg(target_arch = "x86_64")]
const WIDE: u8 = 2;

/// Defines a function for every instruction set from one body that is generic over what it
/// may use.
macro_rules! for_each_set {
    ($(#[$doc:meta])* fn $name:ident($($arg:ident: $type:ty),* $(,)?) $(-> $ret:ty)? = $body:ident) => {
        $(#[$doc])*
        #[inline]
        #[allow(unsafe_code)]
        pub fn $name(set: InstructionSet, $($arg: $type),*) $(-> $ret)? {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma")]
            fn avx2($($arg: $type),*) $(-> $ret)? { $body::<FUSED>($($arg),*) }
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
            fn avx512($($arg: $type),*) $(-> $ret)? { $body::<WIDE>($($arg),*) }
            match set.0 {
                Level::Portable => $body::<PLAIN>($($arg),*),
                // SAFETY: a set beyond the portable one is only ever made by
                // `InstructionSet::available`, after the processor was asked for it.
                #[cfg(target_arch = "x86_64")]
                Level::Avx2 => unsafe { avx2($($arg),*) },
                // SAFETY: as above.
                #[cfg(target_arch = "x86_64")]
                Level::Avx512 => unsafe { avx512($($arg),*) },
            }
        }
    };
}

#[inline(always)]
fn fma<const SET: u8>(a: f64, b: f64, c: f64) -> f64 {
    if SET == PLAIN {
        a * b + c
    } else {
        a.mul_add(b, c)
    }
}

/// `Σ_j rows[k][j] weights[j]` for every k.
#[inline(always)]
#[allow(unsafe_code)]
fn products_of_rows<const SET: u8>(rows: &[Row; TERMS], weights: &Row) -> Series {
    #[cfg(target_arch = "x86_64")]
    if SET == WIDE {
        // SAFETY: a body with this constant runs only inside a function compiled for AVX-512
        // and reached after the processor was asked for it.
        return unsafe { products_of_rows_avx512(rows, weights) };
    }
    let mut out = [0.0; TERMS];
    for (out, row) in out.iter_mut().zip(rows) {
        let mut sums = [0.0; LANES];
        for (v, w) in row.0.chunks_exact(LANES).zip(weights.0.chunks_exact(LANES)) {
            for l in 0..LANES {
                sums[l] = fma::<SET>(v[l], w[l], sums[l]);
            }
        }
        *out = ((sums[0] + sums[4]) + (sums[2] + sums[6]))
            + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
    }
    out
}

/// Sums along a vector by folding two rows into one until one is left: the compiler would
/// rather gather columns.
#[cfg(target_arch = "x86_64")]
#[inline]
#[target_feature(enable = "avx512f")]
#[allow(unsafe_code)]
fn products_of_rows_avx512(rows: &[Row; TERMS], weights: &Row) -> Series {
    use std::arch::x86_64::{
        __m512d, _mm512_add_pd, _mm512_fmadd_pd, _mm512_load_pd, _mm512_mul_pd,
        _mm512_shuffle_f64x2, _mm512_storeu_pd, _mm512_unpackhi_pd, _mm512_unpacklo_pd,
    };
    let load = |row: &Row, group: usize| -> __m512d {
        let lanes = &row.0[group * LANES..(group + 1) * LANES];
        // SAFETY: 8 doubles of a row, which starts at a multiple of 64 bytes.
        unsafe { _mm512_load_pd(lanes.as_ptr()) }
    };
    let w: [__m512d; TERMS / LANES] = std::array::from_fn(|group| load(weights, group));
    let dot = |row: &Row| {
        let mut sum = _mm512_mul_pd(load(row, 0), w[0]);
        for (group, w) in w.iter().enumerate().skip(1) {
            sum = _mm512_fmadd_pd(load(row, group), *w, sum);
        }
        sum
    };
    let fold4 = |a: __m512d, b: __m512d| {
        let low = _mm512_shuffle_f64x2::<0x44>(a, b);
        _mm512_add_pd(low, _mm512_shuffle_f64x2::<0xEE>(a, b))
    };
    let fold2 = |a: __m512d, b: __m512d| {
        let low = _mm512_shuffle_f64x2::<0x88>(a, b);
        _mm512_add_pd(low, _mm512_shuffle_f64x2::<0xDD>(a, b))
    };
    let mut out = [0.0; TERMS];
    for (out, r) in out.chunks_exact_mut(LANES).zip(rows.chunks_exact(LANES)) {
        let quarter = |i: usize| fold4(dot(&r[i]), dot(&r[i + 4]));
        let even = fold2(quarter(0), quarter(2));
        let odd = fold2(quarter(1), quarter(3));
        let (low, high) = (_mm512_unpacklo_pd(even, odd), _mm512_unpackhi_pd(even, odd));
        let sums = _mm512_add_pd(low, high);
        let sums = _mm512_shuffle_f64x2::<0xD8>(sums, sums);
        // SAFETY: `out` is a group of 8 doubles.
        unsafe { _mm512_storeu_pd(out.as_mut_ptr(), sums) };
    }
    out
}

for_each_set! {
    /// Deflection (and in contact force) of a full window from the extended state `x`; the
    /// side's gap s b [m] comes with the contact.
    fn solve(rows: &[Row], x: &[f64], contact: Option<(&Feedback, f64)>, out: &mut Solution)
        = solve_body
}

for_each_set! {
    /// The force series of a tangent vector on a window in contact.
    fn respond(rows: &[Row], x: &[f64], feedback: &Feedback) -> Series = respond_body
}

for_each_set! {
    /// Factorises a window's system; `places` are its nodes within the segment whose
    /// `stiffness` varies.
    fn factorise(
        nodal: &Nodal,
        stiffness: &[f64; STIFFNESS_TERMS],
        places: &Series,
        damping: f64,
        out: &mut Factors,
    ) = factorise_body
}

for_each_set! {
    /// [`solve`] in contact with a stiffness that varies.
    fn solve_varying(
        rows: &[Row],
        x: &[f64],
        nodal: &Nodal,
        factors: &Factors,
        gap: f64,
        out: &mut Solution,
    ) = solve_varying_body
}

for_each_set! {
    /// [`respond`] where the stiffness varies.
    fn respond_varying(rows: &[Row], x: &[f64], nodal: &Nodal, factors: &Factors) -> Series
        = respond_varying_body
}

for_each_set! {
    /// Force series from that of the free deflection; `gap` is s b [m].
    fn force(nodal: &Nodal, factors: &Factors, free: &Series, gap: f64) -> Series = force_body
}

for_each_set! {
    /// Deflection series from those of the free deflection and the force.
    fn deflection(nodal: &Nodal, free: &Series, force: &Series) -> Series = deflection_body
}

for_each_set! {
    /// `out = D x + E f + …` for a full window: `force` none in free flight, `inputs` the
    /// weights of the constant and harmonic inputs (none for a tangent).
    fn advance(
        windows: &Windows,
        force: Option<&Series>,
        inputs: &[f64],
        x: &[f64],
        out: &mut [f64],
    ) = advance_body
}

for_each_set! {
    /// Legendre polynomials of the full window at the nodes and the end of its part up to
    /// `end` ∈ (−1, 1].
    fn basis(nodes: &Series, weights: &Series, end: f64, delta: f64, out: &mut Basis)
        = basis_body
}

for_each_set! {
    /// Values of a full window's series at the nodes of the part.
    fn at_nodes(basis: &Basis, series: &Series) -> Series = at_nodes_body
}

for_each_set! {
    /// `∫₀^τ P_k(ξ(τ−s)) F(s) ds` for every k, F a series on the full window.
    fn moments(basis: &Basis, series: &Series) -> Series = moments_body
}

for_each_set! {
    /// `e^{μτ} cos ντ` and `e^{μτ} sin ντ / ν` of all blocks at the part's end.
    fn ends(basis: &Basis, exponentials: &[ExponentialChunk], out: &mut [[Lanes; 2]])
        = ends_body
}

for_each_set! {
    /// The state at the end of a part, in place: `x = e^{Aτ} x − Σ force[k] ê_k g
    /// + Σ constant[k] ê_k s`.
    fn cut(
        blocks: &[BlockChunk],
        exponentials: &[ExponentialChunk],
        ends: &[[Lanes; 2]],
        force: Option<&Series>,
        constant: Option<&Series>,
        x: &mut [f64],
    ) = cut_body
}

for_each_set! {
    /// `x += Σ weights[k] ê_k input` for an input with its own gains.
    fn push(
        blocks: &[BlockChunk],
        exponentials: &[ExponentialChunk],
        input: &[[Lanes; 2]],
        weights: &Series,
        x: &mut [f64],
    ) = push_body
}

for_each_set! {
    /// [`crate::propagate::events::first_crossing`].
    fn first_crossing(
        deflection: &Series,
        contact: Contact,
        half_gap: f64,
        crossed: Option<Surface>,
        limit: f64,
        noise: f64,
        counters: &mut Counters,
    ) -> Option<Crossing> = first_crossing_body
}

#[inline(always)]
fn first_crossing_body<const SET: u8>(
    deflection: &Series,
    contact: Contact,
    half_gap: f64,
    crossed: Option<Surface>,
    limit: f64,
    noise: f64,
    counters: &mut Counters,
) -> Option<Crossing> {
    let transforms = transforms24();
    if SET == PLAIN {
        events::first_crossing::<_, false>(
            transforms, deflection, contact, half_gap, crossed, limit, noise, counters,
        )
    } else {
        events::first_crossing::<_, true>(
            transforms, deflection, contact, half_gap, crossed, limit, noise, counters,
        )
    }
}

use cut::{at_nodes_body, basis_body, cut_body, ends_body, moments_body, push_body};
use varying::{
    deflection_body, factorise_body, force_body, respond_varying_body, solve_varying_body,
};
use window::{advance_body, respond_body, solve_body};

#[cfg(test)]
mod tests;
