//! The inner loops, compiled for several instruction sets and chosen at run time.
//!
//! Every loop is written once over arrays of lanes; with the target features switched on
//! the compiler turns it into the machine's vectors (closures would not inherit the
//! features, so there are none). Results differ between instruction
//! sets within rounding (fused or separate multiply-add), never between runs on one.

use super::TERMS;

/// Blocks carried side by side.
pub const LANES: usize = 8;

/// One lane group.
pub type Lanes = [f64; LANES];

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

/// Defines a function for every instruction set from one body that is generic over fused
/// multiply-add.
macro_rules! for_each_set {
    ($(#[$doc:meta])* fn $name:ident($($arg:ident: $type:ty),* $(,)?) $(-> $ret:ty)? = $body:ident) => {
        $(#[$doc])*
        #[inline]
        #[allow(unsafe_code)]
        pub fn $name(set: InstructionSet, $($arg: $type),*) $(-> $ret)? {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma")]
            fn avx2($($arg: $type),*) $(-> $ret)? { $body::<true>($($arg),*) }
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
            fn avx512($($arg: $type),*) $(-> $ret)? { $body::<true>($($arg),*) }
            match set.0 {
                Level::Portable => $body::<false>($($arg),*),
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
fn fma<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

for_each_set! {
    /// `Σ weights[i] rows[i]`; both lengths are the same multiple of 4.
    fn combine(rows: &[[f64; TERMS]], weights: &[f64]) -> [f64; TERMS] = combine_body
}

#[inline(always)]
fn combine_body<const FUSED: bool>(rows: &[[f64; TERMS]], weights: &[f64]) -> [f64; TERMS] {
    // Four sums in flight hide the latency of the multiply-add.
    let mut sums = [[0.0; TERMS]; 4];
    for (row, weight) in rows.chunks_exact(4).zip(weights.chunks_exact(4)) {
        for u in 0..4 {
            for j in 0..TERMS {
                sums[u][j] = fma::<FUSED>(row[u][j], weight[u], sums[u][j]);
            }
        }
    }
    std::array::from_fn(|j| (sums[0][j] + sums[1][j]) + (sums[2][j] + sums[3][j]))
}

/// Tables of a full window for one chunk of blocks.
#[derive(Debug, Clone, Copy)]
pub struct WindowChunk {
    /// `e^{AΔ}`, row by row.
    pub propagator: [Lanes; 4],
    /// Response to a unit force series term, for both components.
    pub response: [[Lanes; 2]; TERMS],
}

for_each_set! {
    /// `out = D x + E f` for a full window; `x` and `out` hold first components, then second
    /// components; `force = None` in free flight.
    fn advance(chunks: &[WindowChunk], force: Option<&[f64; TERMS]>, x: &[f64], out: &mut [f64])
        = advance_body
}

#[inline(always)]
fn advance_body<const FUSED: bool>(
    chunks: &[WindowChunk],
    force: Option<&[f64; TERMS]>,
    x: &[f64],
    out: &mut [f64],
) {
    let (x1, x2) = x.split_at(chunks.len() * LANES);
    let (y1, y2) = out.split_at_mut(chunks.len() * LANES);
    let first = x1.chunks_exact(LANES).zip(x2.chunks_exact(LANES));
    let second = y1.chunks_exact_mut(LANES).zip(y2.chunks_exact_mut(LANES));
    for ((chunk, (a, b)), (ya, yb)) in chunks.iter().zip(first).zip(second) {
        let d = &chunk.propagator;
        let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            u[l] = fma::<FUSED>(d[0][l], a[l], d[1][l] * b[l]);
            v[l] = fma::<FUSED>(d[2][l], a[l], d[3][l] * b[l]);
        }
        if let Some(force) = force {
            for (e, f) in chunk.response.iter().zip(force) {
                for l in 0..LANES {
                    u[l] = fma::<FUSED>(e[0][l], *f, u[l]);
                    v[l] = fma::<FUSED>(e[1][l], *f, v[l]);
                }
            }
        }
        ya.copy_from_slice(&u);
        yb.copy_from_slice(&v);
    }
}

/// Eigenvalues and gains of one chunk of blocks.
#[derive(Debug, Clone, Copy)]
pub struct BlockChunk {
    /// Growth rate μ \[1/s\].
    pub growth: Lanes,
    /// Damped frequency ν \[rad/s\], never zero.
    pub frequency: Lanes,
    /// 1/ν \[s\].
    pub inverse_frequency: Lanes,
    /// Traceless part M, row by row.
    pub traceless: [Lanes; 4],
    /// Gain g of the mesh force.
    pub mesh_input: [Lanes; 2],
    /// Constant input of the mean torques.
    pub static_input: [Lanes; 2],
}

/// Legendre series of `e^{μt} cos νt` and `e^{μt} sin νt / ν` of one chunk on a window.
#[derive(Debug, Clone, Copy)]
pub struct ExponentialChunk {
    /// Coefficients of `e^{μt} cos νt`.
    pub cosine: [Lanes; TERMS],
    /// Coefficients of `e^{μt} sin νt / ν`.
    pub sine: [Lanes; TERMS],
    /// Both at the window's end.
    pub end: [Lanes; 2],
}

impl ExponentialChunk {
    /// All zero.
    pub const ZERO: Self = Self {
        cosine: [[0.0; LANES]; TERMS],
        sine: [[0.0; LANES]; TERMS],
        end: [[0.0; LANES]; 2],
    };
}

for_each_set! {
    /// The exponential series of all blocks on a window of length τ; the method of
    /// [`crate::numerics::exponential`], lane by lane.
    fn exponentials(blocks: &[BlockChunk], tau: f64, out: &mut [ExponentialChunk])
        = exponentials_body
}

/// Terms of the Taylor series of `e^z` for |z| ≤ 2: 2²⁶/26! is below 2⁻⁵².
const TAYLOR_TERMS: usize = 26;

/// Terms of the power series of the highest Bessel functions for |z|²/2 ≤ 2.
const BESSEL_TERMS: usize = 8;

#[inline(always)]
fn times<const FUSED: bool>(a: (Lanes, Lanes), b: (Lanes, Lanes)) -> (Lanes, Lanes) {
    let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        re[l] = fma::<FUSED>(a.0[l], b.0[l], -(a.1[l] * b.1[l]));
        im[l] = fma::<FUSED>(a.0[l], b.1[l], a.1[l] * b.0[l]);
    }
    (re, im)
}

/// `1 + factor a b`.
#[inline(always)]
fn one_plus<const FUSED: bool>(
    factor: f64,
    a: (Lanes, Lanes),
    b: (Lanes, Lanes),
) -> (Lanes, Lanes) {
    let (mut re, mut im) = times::<FUSED>(a, b);
    for l in 0..LANES {
        re[l] = fma::<FUSED>(factor, re[l], 1.0);
        im[l] *= factor;
    }
    (re, im)
}

/// `c_n` of the highest orders by its power series.
#[inline(always)]
fn scaled_bessel<const FUSED: bool>(n: usize, square: (Lanes, Lanes)) -> (Lanes, Lanes) {
    let mut sum = ([1.0; LANES], [0.0; LANES]);
    for k in (1..=BESSEL_TERMS).rev() {
        sum = one_plus::<FUSED>(0.5 / (k * (2 * n + 2 * k + 1)) as f64, square, sum);
    }
    sum
}

#[inline(always)]
fn exponentials_body<const FUSED: bool>(
    blocks: &[BlockChunk],
    tau: f64,
    out: &mut [ExponentialChunk],
) {
    for (block, target) in blocks.iter().zip(out) {
        let mut z = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            z.0[l] = 0.5 * tau * block.growth[l];
            z.1[l] = 0.5 * tau * block.frequency[l];
        }
        let square = times::<FUSED>(z, z);
        let one = ([1.0; LANES], [0.0; LANES]);
        // e^z by Horner's rule.
        let mut half = one;
        for k in (1..=TAYLOR_TERMS).rev() {
            half = one_plus::<FUSED>(1.0 / k as f64, z, half);
        }
        let end = times::<FUSED>(half, half);
        // c_n from the top: two power series, then the backward recurrence.
        let mut above = scaled_bessel::<FUSED>(TERMS, square);
        let mut current = scaled_bessel::<FUSED>(TERMS - 1, square);
        let mut scaled = [one; TERMS];
        scaled[TERMS - 1] = current;
        for k in (1..TERMS).rev() {
            let factor = 1.0 / ((2 * k + 1) * (2 * k + 3)) as f64;
            let term = times::<FUSED>(square, above);
            above = current;
            for l in 0..LANES {
                current.0[l] = fma::<FUSED>(factor, term.0[l], current.0[l]);
                current.1[l] = fma::<FUSED>(factor, term.1[l], current.1[l]);
            }
            scaled[k - 1] = current;
        }
        // e^z zⁿ/(2n−1)!! from the bottom.
        let mut power = half;
        for k in 0..TERMS {
            let value = times::<FUSED>(scaled[k], power);
            target.cosine[k] = value.0;
            for l in 0..LANES {
                target.sine[k][l] = value.1[l] * block.inverse_frequency[l];
            }
            power = times::<FUSED>(power, z);
            let next = 1.0 / (2 * k + 1) as f64;
            for l in 0..LANES {
                power.0[l] *= next;
                power.1[l] *= next;
            }
        }
        target.end[0] = end.0;
        for l in 0..LANES {
            target.end[1][l] = end.1[l] * block.inverse_frequency[l];
        }
    }
}

for_each_set! {
    /// The state at the end of a cut window, in place: `x = e^{Aτ} x − ∫ e^{A(τ−s)} g F ds`
    /// (+ the mean torques where `with_static`). `moments[n]` is `(−1)ⁿ τ/(2n+1)` times
    /// coefficient n of the force on the cut window.
    fn cut(
        blocks: &[BlockChunk],
        exponentials: &[ExponentialChunk],
        tau: f64,
        moments: Option<&[f64; TERMS]>,
        with_static: bool,
        x: &mut [f64],
    ) = cut_body
}

/// `sum + (c I + s M) u`.
#[inline(always)]
fn add_applied<const FUSED: bool>(
    c: f64,
    s: f64,
    m: [f64; 4],
    u: [f64; 2],
    sum: [f64; 2],
) -> [f64; 2] {
    let mu = fma::<FUSED>(m[0], u[0], m[1] * u[1]);
    let mv = fma::<FUSED>(m[2], u[0], m[3] * u[1]);
    [
        fma::<FUSED>(c, u[0], fma::<FUSED>(s, mu, sum[0])),
        fma::<FUSED>(c, u[1], fma::<FUSED>(s, mv, sum[1])),
    ]
}

#[inline(always)]
fn cut_body<const FUSED: bool>(
    blocks: &[BlockChunk],
    exponentials: &[ExponentialChunk],
    tau: f64,
    moments: Option<&[f64; TERMS]>,
    with_static: bool,
    x: &mut [f64],
) {
    let (x1, x2) = x.split_at_mut(blocks.len() * LANES);
    let states = x1.chunks_exact_mut(LANES).zip(x2.chunks_exact_mut(LANES));
    for ((block, exponential), (a, b)) in blocks.iter().zip(exponentials).zip(states) {
        let m = &block.traceless;
        let (mut cosine, mut sine) = ([0.0; LANES], [0.0; LANES]);
        if let Some(moments) = moments {
            for n in 0..TERMS {
                for l in 0..LANES {
                    cosine[l] = fma::<FUSED>(exponential.cosine[n][l], moments[n], cosine[l]);
                    sine[l] = fma::<FUSED>(exponential.sine[n][l], moments[n], sine[l]);
                }
            }
        }
        let still = if with_static { tau } else { 0.0 };
        for l in 0..LANES {
            let m = [m[0][l], m[1][l], m[2][l], m[3][l]];
            let g = [block.mesh_input[0][l], block.mesh_input[1][l]];
            let t = [block.static_input[0][l], block.static_input[1][l]];
            let mut sum = add_applied::<FUSED>(-cosine[l], -sine[l], m, g, [0.0; 2]);
            let (c0, s0) = (exponential.cosine[0][l], exponential.sine[0][l]);
            sum = add_applied::<FUSED>(still * c0, still * s0, m, t, sum);
            sum = add_applied::<FUSED>(
                exponential.end[0][l],
                exponential.end[1][l],
                m,
                [a[l], b[l]],
                sum,
            );
            a[l] = sum[0];
            b[l] = sum[1];
        }
    }
}

#[cfg(test)]
mod tests;
