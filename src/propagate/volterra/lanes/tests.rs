//! Every loop on every instruction set against its definition, one block after the other, on
//! sizes that straddle a chunk's edge; outputs hold NaN beforehand.

use super::*;
use crate::model::Block;
use crate::numerics::exponential::{Complex, legendre_series, multiply};
use crate::numerics::random::Stream;

/// Numbers of modes about the edges of one chunk and of five.
const MODES: [usize; 6] = [1, 7, 8, 9, 40, 41];

/// Round-off of sums of some twenty terms of size one.
const TOLERANCE: f64 = 64.0 * f64::EPSILON;

fn chunks(modes: usize) -> usize {
    modes.div_ceil(LANES)
}

/// Deviates for the components of `modes` blocks, zero in the lanes beyond.
fn state(modes: usize, stream: &mut Stream) -> Vec<f64> {
    let padded = chunks(modes) * LANES;
    let mut x = vec![0.0; 2 * padded];
    for i in 0..modes {
        x[i] = stream.normal();
        x[padded + i] = stream.normal();
    }
    x
}

fn series(stream: &mut Stream) -> [f64; TERMS] {
    std::array::from_fn(|_| stream.normal())
}

/// Blocks of growth and frequency about one, a rigid rotation first.
fn blocks(modes: usize, stream: &mut Stream) -> Vec<Block> {
    (0..modes)
        .map(|i| {
            let (frequency, damping) = match i {
                0 => (0.0, 0.0),
                _ => (0.2 + 1.5 * stream.uniform(), 0.9 * stream.uniform()),
            };
            let mut block = Block::mode(frequency, damping, 1.0, stream.normal(), stream.normal());
            // Not a companion block: the loops may not assume one.
            if i % 3 == 2 {
                block.generator[0][0] = -0.1;
                block.mesh_input[0] = stream.normal();
                block.static_input[0] = stream.normal();
            }
            block
        })
        .collect()
}

fn eigenvalue(block: &Block) -> Complex {
    (block.growth(), block.damped_frequency().unwrap().max(1e-9))
}

fn block_chunks(blocks: &[Block]) -> Vec<BlockChunk> {
    let zero = [0.0; LANES];
    let mut out = vec![
        BlockChunk {
            growth: zero,
            frequency: [1e-9; LANES],
            inverse_frequency: zero,
            traceless: [zero; 4],
            mesh_input: [zero; 2],
            static_input: [zero; 2],
        };
        chunks(blocks.len())
    ];
    for (i, block) in blocks.iter().enumerate() {
        let (chunk, l) = (&mut out[i / LANES], i % LANES);
        let (mu, nu) = eigenvalue(block);
        chunk.growth[l] = mu;
        chunk.frequency[l] = nu;
        chunk.inverse_frequency[l] = 1.0 / nu;
        for (k, value) in block.traceless().as_flattened().iter().enumerate() {
            chunk.traceless[k][l] = *value;
        }
        for j in 0..2 {
            chunk.mesh_input[j][l] = block.mesh_input[j];
            chunk.static_input[j][l] = block.static_input[j];
        }
    }
    out
}

fn not_a_number(chunks: usize) -> Vec<ExponentialChunk> {
    let nan = [f64::NAN; LANES];
    vec![
        ExponentialChunk {
            cosine: [nan; TERMS],
            sine: [nan; TERMS],
            end: [nan; 2],
        };
        chunks
    ]
}

fn close(found: f64, exact: f64, size: f64, what: &str) {
    // Written so that NaN fails.
    let near = (found - exact).abs() <= TOLERANCE * size.max(1.0);
    assert!(near, "{what}: {found} instead of {exact}");
}

#[test]
fn combine_is_a_sum_of_rows() {
    let mut stream = Stream::new(1, 0, 0);
    for set in InstructionSet::available() {
        for length in [0, 4, 8, 12, 16, 80, 96] {
            let rows: Vec<_> = (0..length).map(|_| series(&mut stream)).collect();
            let weights: Vec<_> = (0..length).map(|_| stream.normal()).collect();
            let found = combine(set, &rows, &weights);
            for j in 0..TERMS {
                let terms = rows.iter().zip(&weights).map(|(row, w)| row[j] * w);
                let size: f64 = terms.clone().map(f64::abs).sum();
                let what = format!("{} of {length}", set.name());
                close(found[j], terms.sum(), size, &what);
            }
        }
    }
}

#[test]
fn advance_is_propagator_and_response() {
    let mut stream = Stream::new(2, 0, 0);
    for set in InstructionSet::available() {
        for modes in MODES {
            let padded = chunks(modes) * LANES;
            let x = state(modes, &mut stream);
            let force = series(&mut stream);
            let lanes = |stream: &mut Stream| -> Lanes { std::array::from_fn(|_| stream.normal()) };
            let windows: Vec<_> = (0..chunks(modes))
                .map(|_| WindowChunk {
                    propagator: std::array::from_fn(|_| lanes(&mut stream)),
                    response: std::array::from_fn(|_| [lanes(&mut stream), lanes(&mut stream)]),
                })
                .collect();
            for force in [None, Some(&force)] {
                let mut out = vec![f64::NAN; 2 * padded];
                advance(set, &windows, force, &x, &mut out);
                for i in 0..padded {
                    let (w, l) = (&windows[i / LANES], i % LANES);
                    for j in 0..2 {
                        let mut terms = vec![
                            w.propagator[2 * j][l] * x[i],
                            w.propagator[2 * j + 1][l] * x[padded + i],
                        ];
                        for (e, f) in w.response.iter().zip(force.unwrap_or(&[0.0; TERMS])) {
                            terms.push(e[j][l] * f);
                        }
                        let size: f64 = terms.iter().map(|t| t.abs()).sum();
                        let what = format!("{}, {modes} modes, block {i}", set.name());
                        close(out[j * padded + i], terms.iter().sum(), size, &what);
                    }
                }
            }
        }
    }
}

#[test]
fn exponentials_are_those_of_one_block() {
    let mut stream = Stream::new(3, 0, 0);
    for set in InstructionSet::available() {
        for modes in MODES {
            let blocks = blocks(modes, &mut stream);
            let chunked = block_chunks(&blocks);
            for tau in [1e-12, 0.03, 1.0, 1.9] {
                let mut found = not_a_number(chunked.len());
                exponentials(set, &chunked, tau, &mut found);
                for (i, block) in blocks.iter().enumerate() {
                    let (chunk, l) = (&found[i / LANES], i % LANES);
                    let (mu, nu) = eigenvalue(block);
                    let mut exact = [(f64::NAN, f64::NAN); TERMS];
                    let end = legendre_series((mu, nu), tau, &mut exact);
                    let what = format!("{}, block {i} of {modes}, τ = {tau}", set.name());
                    for n in 0..TERMS {
                        close(chunk.cosine[n][l], exact[n].0, 1.0, &what);
                        // Relative to the window: sin νt / ν is of the size of t.
                        close(chunk.sine[n][l] / tau, exact[n].1 / nu / tau, 1.0, &what);
                    }
                    close(chunk.end[0][l], end.0, 1.0, &what);
                    close(chunk.end[1][l] / tau, end.1 / nu / tau, 1.0, &what);
                }
                // Lanes without a block must not hold NaN: they would come back as 0 · NaN.
                for chunk in &found {
                    assert!(chunk.cosine.as_flattened().iter().all(|v| v.is_finite()));
                    assert!(chunk.sine.as_flattened().iter().all(|v| v.is_finite()));
                }
            }
        }
    }
}

/// `(c I + s M) u`.
fn applied(c: f64, s: f64, m: [[f64; 2]; 2], u: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|j| c * u[j] + s * (m[j][0] * u[0] + m[j][1] * u[1]))
}

#[test]
fn cut_is_propagation_response_and_torque() {
    let mut stream = Stream::new(4, 0, 0);
    for set in InstructionSet::available() {
        for modes in MODES {
            let padded = chunks(modes) * LANES;
            let blocks = blocks(modes, &mut stream);
            let chunked = block_chunks(&blocks);
            let from = state(modes, &mut stream);
            let moments = series(&mut stream);
            let tau = 0.7;
            let mut exponential = not_a_number(chunked.len());
            exponentials(set, &chunked, tau, &mut exponential);
            for (moments, with_static) in [
                (None, false),
                (None, true),
                (Some(&moments), false),
                (Some(&moments), true),
            ] {
                let mut x = from.clone();
                cut(
                    set,
                    &chunked,
                    &exponential,
                    tau,
                    moments,
                    with_static,
                    &mut x,
                );
                for (i, block) in blocks.iter().enumerate() {
                    let (mu, nu) = eigenvalue(block);
                    let mut e = [(0.0, 0.0); TERMS];
                    let end = legendre_series((mu, nu), tau, &mut e);
                    let m = block.traceless();
                    let mut exact = applied(end.0, end.1 / nu, m, [from[i], from[padded + i]]);
                    for (n, e) in e.iter().enumerate() {
                        let f = moments.map_or(0.0, |m| m[n]);
                        let push = applied(e.0, e.1 / nu, m, block.mesh_input);
                        for j in 0..2 {
                            exact[j] -= f * push[j];
                        }
                    }
                    if with_static {
                        let torque = applied(e[0].0, e[0].1 / nu, m, block.static_input);
                        for j in 0..2 {
                            exact[j] += tau * torque[j];
                        }
                    }
                    let what = format!("{}, block {i} of {modes}", set.name());
                    for j in 0..2 {
                        close(x[j * padded + i], exact[j], 16.0, &what);
                    }
                }
                for i in modes..padded {
                    assert_eq!((x[i], x[padded + i]), (0.0, 0.0), "padding moved");
                }
            }
        }
    }
}

/// What the loops are compared with is itself an exponential.
#[test]
fn exponential_of_a_sum_is_the_product() {
    let end = |tau: f64| legendre_series((-0.3, 1.1), tau, &mut [(0.0, 0.0); TERMS]);
    let product = multiply(end(0.4), end(0.7));
    let whole = end(1.1);
    assert!((product.0 - whole.0).abs() < TOLERANCE && (product.1 - whole.1).abs() < TOLERANCE);
}
