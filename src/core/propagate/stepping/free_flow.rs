//! The exact flow of the free structure over one fixed time.

use crate::model::Block;

/// `x ↦ exp(A t) x + ∫₀ᵗ exp(A s) ds · input` for every block, with the constant torques as input. One array
/// holds one matrix entry of all blocks, so that the compiler can vectorise the loop over blocks.
///
/// ```text
/// exp(A t) = e^{μt} (cos νt I + sin νt/ν M),   M = A − μ I
/// ∫₀ᵗ exp(A s) ds = C I + S M,   C = ∫ e^{μs} cos νs ds,   S = ∫ e^{μs} sin νs/ν ds
/// ```
#[derive(Debug, Clone)]
pub(super) struct FreeFlow {
    /// Entries of exp(A t), row by row, each of length N.
    entries: [Vec<f64>; 4],
    /// Response to the constant torques, first and second components.
    load: [Vec<f64>; 2],
}

impl FreeFlow {
    /// The flow over a time \[s\].
    pub fn new(blocks: &[Block], time: f64) -> Self {
        let mut free_flow = Self {
            entries: Default::default(),
            load: Default::default(),
        };
        for block in blocks {
            let (flow, response) = exact(block, time);
            for (column, value) in free_flow.entries.iter_mut().zip(flow.as_flattened()) {
                column.push(*value);
            }
            for (column, value) in free_flow.load.iter_mut().zip(response) {
                column.push(value);
            }
        }
        free_flow
    }

    /// Advances a state of length 2N.
    pub fn advance(&self, state: &mut [f64]) {
        self.apply::<true>(state);
    }

    /// Advances a tangent of length 2N, without the torques.
    pub fn advance_tangent(&self, tangent: &mut [f64]) {
        self.apply::<false>(tangent);
    }

    #[inline(always)]
    fn apply<const LOADED: bool>(&self, state: &mut [f64]) {
        let n = self.load[0].len();
        let (first, second) = state.split_at_mut(n);
        let second = &mut second[..n];
        let [a, b, c, d] = self.entries.each_ref().map(|column| &column[..n]);
        let [p, q] = self.load.each_ref().map(|column| &column[..n]);
        for i in 0..n {
            let (x, y) = (first[i], second[i]);
            let mut to = (a[i] * x + b[i] * y, c[i] * x + d[i] * y);
            if LOADED {
                to.0 += p[i];
                to.1 += q[i];
            }
            (first[i], second[i]) = to;
        }
    }
}

/// `exp(A t)` and the response to the block's constant input.
fn exact(block: &Block, t: f64) -> ([[f64; 2]; 2], [f64; 2]) {
    let mu = block.growth();
    let m = block.traceless();
    // M² = −ν² I, or σ² I for an overdamped block.
    let (cos, sinc, square_of_m) = match block.spread() {
        Some(sigma) => {
            let (sinh, cosh) = ((sigma * t).sinh(), (sigma * t).cosh());
            (cosh, sinh / sigma, sigma * sigma)
        }
        None => {
            let nu = block.damped_frequency().unwrap_or(0.0);
            let (sin, cos) = (nu * t).sin_cos();
            (cos, if nu == 0.0 { t } else { sin / nu }, -nu * nu)
        }
    };
    let grown = (mu * t).exp();
    let flow = [
        [grown * (cos + sinc * m[0][0]), grown * sinc * m[0][1]],
        [grown * sinc * m[1][0], grown * (cos + sinc * m[1][1])],
    ];

    let square = mu * mu - square_of_m;
    let size = mu * mu + square_of_m.abs();
    let (even, odd) = if size * t * t < 1.0 {
        integrals_by_series(mu, square_of_m, t)
    } else if square.abs() * t * t < 1.0 {
        // One of two real eigenvalues is near zero.
        let sigma = square_of_m.max(0.0).sqrt();
        let integral = |rate: f64| {
            if rate == 0.0 { t } else { (rate * t).exp_m1() / rate }
        };
        let [fast, slow] = [integral(mu + sigma), integral(mu - sigma)];
        (0.5 * (fast + slow), 0.5 * (fast - slow) / sigma)
    } else {
        let fall = 1.0 - grown * cos;
        (
            (-grown * square_of_m * sinc - mu * fall) / square,
            (fall + mu * grown * sinc) / square,
        )
    };
    let s = block.static_input;
    let traceless_input = [
        m[0][0] * s[0] + m[0][1] * s[1],
        m[1][0] * s[0] + m[1][1] * s[1],
    ];
    let response = [
        even * s[0] + odd * traceless_input[0],
        even * s[1] + odd * traceless_input[1],
    ];
    (flow, response)
}

/// The integrals C and S for `|A| t < 1`, where the closed form cancels: the terms of
/// `Σ Aᵏ tᵏ⁺¹/(k+1)!` with `Aᵏ = α I + β M`, M² = `square` I.
fn integrals_by_series(mu: f64, square: f64, t: f64) -> (f64, f64) {
    let (mut alpha, mut beta) = (t, 0.0);
    let (mut even, mut odd) = (alpha, beta);
    // 1/20! is far below round-off.
    for k in 1..20 {
        let scale = t / f64::from(k + 1);
        (alpha, beta) = (
            scale * (mu * alpha + square * beta),
            scale * (alpha + mu * beta),
        );
        even += alpha;
        odd += beta;
    }
    (even, odd)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x' = A x + s` by its Taylor series.
    fn taylor(block: &Block, x: [f64; 2], t: f64) -> [f64; 2] {
        let [a, b] = block.generator;
        let s = block.static_input;
        let mut term = x;
        let mut sum = x;
        for k in 1..60 {
            let scale = t / f64::from(k);
            let load = if k == 1 { s } else { [0.0, 0.0] };
            term = [
                scale * (a[0] * term[0] + a[1] * term[1] + load[0]),
                scale * (b[0] * term[0] + b[1] * term[1] + load[1]),
            ];
            sum = [sum[0] + term[0], sum[1] + term[1]];
        }
        sum
    }

    #[test]
    fn flow_solves_the_block_exactly() {
        let general = Block {
            generator: [[-0.3, 1.7], [-2.1, 0.1]],
            static_input: [0.4, -0.9],
        };
        let blocks = [
            Block::mode(0.0, 0.0, 0.7),
            Block::mode(3.0, 0.0, 0.7),
            Block::mode(3.0, 0.2, -2.0),
            Block::mode(1e-6, 0.1, 1.0),
            Block::mode(2.0, 1.0, 1.0),
            Block::mode(1.0, 1.4, 1.0),
            Block {
                generator: [[0.0, 1.0], [0.0, -2.0]],
                ..Block::mode(0.0, 0.0, -0.6)
            },
            general,
        ];
        let n = blocks.len();
        for t in [1e-3, 0.1, 1.3] {
            let mut state = vec![f64::NAN; 2 * n];
            state[..n].fill(0.3);
            state[n..].fill(-1.1);
            FreeFlow::new(&blocks, t).advance(&mut state);
            for (i, block) in blocks.iter().enumerate() {
                let exact = taylor(block, [0.3, -1.1], t);
                assert!((state[i] - exact[0]).abs() < 1e-14, "block {i}, t = {t}");
                assert!(
                    (state[n + i] - exact[1]).abs() < 1e-14,
                    "block {i}, t = {t}"
                );
            }
        }
    }

    #[test]
    fn tangents_do_not_feel_the_torques() {
        let blocks = [Block::mode(3.0, 0.2, -2.0)];
        let free_flow = FreeFlow::new(&blocks, 0.4);
        let mut tangent = [0.0, 0.0];
        free_flow.advance_tangent(&mut tangent);
        assert_eq!(tangent, [0.0, 0.0]);
    }
}
