//! Compares every loop on every instruction set with its definition, block after block, for sizes around a
//! chunk's edge. Outputs are NaN before a call.

use super::*;
use crate::model::{ActiveSet, Block, Contact, DRIVE_FLANK, MeshGain, Release, STIFFNESS_TERMS};
use crate::numerics::legendre::{evaluate, polynomials, transforms24};
use crate::numerics::random::Stream;
use crate::propagate::events::Margin;
use crate::propagate::saltation;
use crate::propagate::volterra::feedback::Feedback;
use crate::propagate::volterra::shapes::{LANES, interpolation};
use crate::propagate::volterra::varying::{Factors, Maps, Nodal};

/// Numbers of modes around the edges of one chunk and of five.
const MODES: [usize; 6] = [1, 7, 8, 9, 40, 41];

/// Round-off of sums of some twenty terms of size one.
const TOLERANCE: f64 = 64.0 * f64::EPSILON;

fn chunks(modes: usize) -> usize {
    modes.div_ceil(LANES)
}

fn deviates(length: usize, stream: &mut Stream) -> Vec<f64> {
    (0..length).map(|_| stream.normal()).collect()
}

/// Normal deviates for the components of `modes` blocks; zeros in the padding.
fn state(modes: usize, stream: &mut Stream) -> Vec<f64> {
    let padded = chunks(modes) * LANES;
    let mut x = vec![0.0; 2 * padded];
    for i in 0..modes {
        x[i] = stream.normal();
        x[padded + i] = stream.normal();
    }
    x
}

fn series(stream: &mut Stream) -> Series {
    std::array::from_fn(|_| stream.normal())
}

fn rows(count: usize, stream: &mut Stream) -> Vec<Row> {
    (0..count).map(|_| Row(series(stream))).collect()
}

fn lanes(used: usize, stream: &mut Stream) -> Lanes {
    Lanes(std::array::from_fn(|l| {
        if l < used { stream.normal() } else { 0.0 }
    }))
}

fn close(found: f64, exact: f64, size: f64, what: &str) {
    // Written so that NaN fails.
    let near = (found - exact).abs() <= TOLERANCE * size.max(1.0);
    assert!(near, "{what}: {found} instead of {exact}");
}

fn feedback(stream: &mut Stream) -> Feedback {
    Feedback {
        force: std::array::from_fn(|_| Row(series(stream))),
        deflection: std::array::from_fn(|_| Row(series(stream))),
        gap: [Row(series(stream)), Row(series(stream))],
    }
}

/// `Σ rows[i] weights[i]` and the sum of its terms' sizes, entry by entry.
fn combined(rows: &[Row], weights: &[f64]) -> [(f64, f64); TERMS] {
    std::array::from_fn(|j| {
        let terms = rows.iter().zip(weights).map(|(row, w)| row.0[j] * w);
        (terms.clone().sum(), terms.map(f64::abs).sum())
    })
}

/// Numbers of columns that need batches of every size.
const COLUMNS: [usize; 6] = [1, 2, 3, 4, 6, 9];

#[test]
fn a_window_in_free_flight_is_a_sum_of_rows() {
    let mut stream = Stream::new(1, 0, 0);
    for set in InstructionSet::available() {
        for (length, inputs) in [(16, 4), (80, 4), (80, 12)] {
            let rows = rows(length + inputs, &mut stream);
            let x = deviates(length + inputs, &mut stream);
            let mut found = Solution::ZERO;
            found.deflection = [f64::NAN; TERMS];
            // A tangent after the trajectory is not read.
            let columns = [&x[..length], &vec![f64::NAN; length]].concat();
            let mut forces = [Row::ZERO; 2];
            let inputs = &x[length..];
            solve(set, &rows, inputs, &columns, None, &mut forces, &mut found);
            let exact = combined(&rows, &x);
            let what = format!("{} of {length}", set.name());
            for j in 0..TERMS {
                close(found.deflection[j], exact[j].0, exact[j].1, &what);
            }
            let size: f64 = exact.iter().map(|e| e.0.abs()).sum();
            let terms: f64 = exact.iter().map(|e| e.1).sum();
            close(found.size, size, terms, &what);
            close(found.variation, size - exact[0].0.abs(), terms, &what);
        }
    }
}

/// Checks the first terms of the deflection, and the bounds of the others by their tails, in free flight and under a
/// force.
#[test]
fn a_truncated_deflection_bounds_what_it_leaves_out() {
    let mut stream = Stream::new(11, 0, 0);
    for set in InstructionSet::available() {
        for (length, inputs) in [(16, 4), (80, 12)] {
            let count = length + inputs;
            let (rows, x) = (rows(count, &mut stream), deviates(count, &mut stream));
            let tails: Vec<f64> = rows.iter().map(tail).collect();
            let response: [Row; TERMS] = std::array::from_fn(|_| Row(series(&mut stream)));
            let beyond = Row(response.each_ref().map(tail));
            let force = Row(series(&mut stream));
            for felt in [None, Some((&response, &beyond, &force))] {
                let mut found = Solution::ZERO;
                found.deflection = [f64::NAN; TERMS];
                truncated(
                    set,
                    &rows,
                    &tails,
                    &x[length..],
                    &x[..length],
                    felt,
                    &mut found,
                );
                let free = combined(&rows, &x);
                let yielded = combined(&response, &force.0);
                let part = f64::from(u8::from(felt.is_some()));
                let head: Vec<f64> = (0..LANES)
                    .map(|j| free[j].0 - part * yielded[j].0)
                    .collect();
                let size = |weights: &[f64], tails: &[f64]| -> f64 {
                    weights.iter().zip(tails).map(|(w, t)| w.abs() * t).sum()
                };
                let rest = size(&x, &tails);
                let left = rest + part * size(&force.0, &beyond.0);
                let sizes = |values: &[f64]| values.iter().map(|a| a.abs()).sum::<f64>();
                let terms: f64 = free.iter().chain(&yielded).map(|e| e.1).sum::<f64>() + left;
                for j in 0..TERMS {
                    let exact = head.get(j).copied().unwrap_or(0.0);
                    close(found.deflection[j], exact, terms, set.name());
                }
                let free: f64 = free[..LANES].iter().map(|e| e.0.abs()).sum();
                close(found.size, free + rest, terms, set.name());
                close(found.variation, sizes(&head[1..]) + left, terms, set.name());
            }
        }
    }
}

#[test]
fn a_window_in_contact_feeds_the_mesh_back() {
    let mut stream = Stream::new(2, 0, 0);
    let (length, gap) = (80, 0.7);
    for set in InstructionSet::available() {
        let (rows, mesh) = (rows(length + 4, &mut stream), feedback(&mut stream));
        let all = deviates(9 * length, &mut stream);
        let inputs = deviates(4, &mut stream);
        let mut alone = None;
        for count in COLUMNS {
            let mut found = Solution::ZERO;
            found.deflection = [f64::NAN; TERMS];
            let mut forces = vec![Row([f64::NAN; TERMS]); count];
            let contact = Some((ContactSolve::Table(&mesh), gap, None));
            let columns = &all[..count * length];
            solve(
                set,
                &rows,
                &inputs,
                columns,
                contact,
                &mut forces,
                &mut found,
            );
            for (c, (force, x)) in forces.iter().zip(columns.chunks(length)).enumerate() {
                let inputs = if c == 0 { &inputs[..] } else { &[0.0; 4] };
                let free = combined(&rows, &[x, inputs].concat());
                let d = free.map(|f| f.0);
                let size: f64 = 3.0 * free.iter().map(|f| f.1).sum::<f64>();
                let gap = if c == 0 { gap } else { 0.0 };
                let exact = combined(&mesh.force, &d);
                for j in 0..TERMS {
                    let constant = gap * mesh.gap[0].0[j];
                    close(force.0[j], exact[j].0 + constant, size, set.name());
                }
                if c == 0 {
                    let exact = combined(&mesh.deflection, &d);
                    for j in 0..TERMS {
                        let constant = gap * mesh.gap[1].0[j];
                        close(found.deflection[j], exact[j].0 + constant, size, set.name());
                    }
                }
            }
            let variation: f64 = found.deflection[1..].iter().map(|a| a.abs()).sum();
            close(found.variation, variation, 24.0 * variation, set.name());
            // The bits of the trajectory do not depend on other columns.
            let own = (found.deflection, forces[0].0);
            assert_eq!(*alone.get_or_insert(own), own, "{}, {count}", set.name());
        }
    }
}

#[test]
fn advance_is_propagator_response_and_inputs() {
    let mut stream = Stream::new(3, 0, 0);
    let pair = |stream: &mut Stream| [stream.normal(), stream.normal()];
    for set in InstructionSet::available() {
        for (modes, count) in MODES.into_iter().zip(COLUMNS) {
            let padded = chunks(modes) * LANES;
            let from: Vec<_> = (0..count).flat_map(|_| state(modes, &mut stream)).collect();
            let forces = rows(count, &mut stream);
            let inputs = deviates(3, &mut stream);
            // Every chunk except the first omits the last terms.
            let kept = |chunk: usize| if chunk == 0 { TERMS } else { TERMS - 2 * chunk };
            let kept: Vec<_> = (0..chunks(modes)).map(kept).collect();
            let mut windows = Windows::new(&kept, 3);
            let mut tables = Vec::new();
            for i in 0..modes {
                let d = [pair(&mut stream), pair(&mut stream)];
                let e: Vec<_> = (0..TERMS + 3).map(|_| pair(&mut stream)).collect();
                windows.set_propagator(i, d);
                for (term, e) in e[..TERMS].iter().enumerate() {
                    windows.set_response(i, term, *e);
                }
                for (input, e) in e[TERMS..].iter().enumerate() {
                    windows.set_input(i, input, *e);
                }
                tables.push((d, e));
            }
            for (forces, inputs) in [
                (&[][..], &[][..]),
                (&[], &inputs),
                (&forces, &[]),
                (&forces, &inputs),
            ] {
                let mut out = from.clone();
                advance(set, &windows, forces, inputs, &mut out);
                let columns = out.chunks(2 * padded).zip(from.chunks(2 * padded));
                for (c, (out, x)) in columns.enumerate() {
                    let inputs = if c == 0 { inputs } else { &[] };
                    for (i, (d, e)) in tables.iter().enumerate() {
                        for j in 0..2 {
                            let mut terms = vec![d[j][0] * x[i], d[j][1] * x[padded + i]];
                            if let Some(force) = forces.get(c) {
                                let kept = e[..kept[i / LANES]].iter();
                                terms.extend(kept.zip(&force.0).map(|(e, f)| e[j] * f));
                            }
                            terms.extend(e[TERMS..].iter().zip(inputs).map(|(e, f)| e[j] * f));
                            let size: f64 = terms.iter().map(|t| t.abs()).sum();
                            let what = format!("{}, {modes} modes, block {i}", set.name());
                            close(out[j * padded + i], terms.iter().sum(), size, &what);
                        }
                    }
                    for i in modes..padded {
                        assert_eq!((out[i], out[padded + i]), (0.0, 0.0), "padding moved");
                    }
                }
            }
        }
    }
}

fn part(set: InstructionSet, end: f64, delta: f64) -> Basis {
    let rule = transforms24();
    let mut out = Basis::ZERO;
    basis(
        set,
        Some([rule.nodes(), rule.weights()]),
        end,
        delta,
        &mut out,
    );
    // Without a rule, `end` and `constant` are the same.
    let mut bare = Basis::ZERO;
    basis(set, None, end, delta, &mut bare);
    assert_eq!((bare.end.0, bare.constant.0), (out.end.0, out.constant.0));
    out
}

#[test]
fn a_part_has_the_window_s_polynomials() {
    let delta = 0.3;
    for set in InstructionSet::available() {
        for end in [-1.0 + 1e-12, -0.9, 0.1, 0.77, 1.0] {
            let (found, share) = (part(set, end, delta), 0.5 * (end + 1.0));
            let mut p = [f64::NAN; TERMS];
            for (j, node) in transforms24().nodes().iter().enumerate() {
                polynomials(share * (1.0 + node) - 1.0, &mut p);
                for n in 0..TERMS {
                    close(found.values[n].0[j], p[n], 1.0, set.name());
                }
            }
            polynomials(end, &mut p);
            for n in 0..TERMS {
                close(found.end.0[n], p[n], 1.0, set.name());
            }
            // The weights of the part integrate the polynomials exactly.
            for n in 0..TERMS {
                let sum: f64 = (0..TERMS)
                    .map(|j| found.weights[j] * found.values[n].0[j])
                    .sum();
                close(found.constant.0[n] / delta, sum / delta, 1.0, set.name());
            }
        }
    }
}

/// Both ways of restricting series to a part give that part of the polynomial.
#[test]
fn a_restricted_series_is_the_same_polynomial() {
    let mut stream = Stream::new(5, 0, 0);
    for set in InstructionSet::available() {
        let whole = [Row(series(&mut stream)), Row(series(&mut stream))];
        for end in [-0.999, -0.2, 0.6, 1.0] {
            let mut both = whole;
            restrict(set, &part(set, end, 0.3), interpolation(), &mut both);
            let mut alone = whole[0];
            let nodes = transforms24().nodes();
            restrict_to(set, nodes, interpolation(), end, &mut alone);
            for (found, whole) in [(both[0], whole[0]), (both[1], whole[1]), (alone, whole[0])] {
                for x in [-1.0, -0.7, 0.1, 1.0] {
                    let exact = evaluate(&whole.0, 0.5 * (end + 1.0) * (x + 1.0) - 1.0);
                    close(evaluate(&found.0, x), exact, 240.0, set.name());
                }
            }
        }
    }
}

/// Moments agree with convolutions with the window's polynomials by a finer rule.
#[test]
fn moments_are_convolutions() {
    let mut stream = Stream::new(4, 0, 0);
    let rule = crate::numerics::quadrature::GaussLegendre::new(40);
    let delta = 0.3;
    for set in InstructionSet::available() {
        let force = series(&mut stream);
        for end in [-0.999, -0.2, 0.6, 1.0] {
            let basis = part(set, end, delta);
            let mut found = [Row(force); 7];
            node_values(set, &basis, &mut found);
            let values = found[0].0;
            moments(set, &basis, &mut found);
            assert!(found.iter().all(|f| f.0 == found[0].0), "{}", set.name());
            let found = found[0].0;
            let tau = 0.5 * (end + 1.0) * delta;
            let place = |t: f64| 2.0 * t / delta - 1.0;
            for (j, node) in transforms24().nodes().iter().enumerate() {
                let exact = evaluate(&force, place(0.5 * tau * (1.0 + node)));
                close(values[j], exact, 24.0, set.name());
            }
            for k in 0..TERMS {
                let mut unit = [0.0; TERMS];
                unit[k] = 1.0;
                let exact: f64 = (rule.nodes.iter().zip(&rule.weights))
                    .map(|(x, w)| {
                        let s = 0.5 * tau * (1.0 + x);
                        let kernel = evaluate(&unit, place(tau - s));
                        0.5 * tau * w * kernel * evaluate(&force, place(s))
                    })
                    .sum();
                close(found[k] / delta, exact / delta, 24.0, set.name());
            }
        }
    }
}

/// `(c I + s M) u` of one lane.
fn applied(c: f64, s: f64, m: &[Lanes; 4], u: [f64; 2], l: usize) -> [f64; 2] {
    [0, 1].map(|j| c * u[j] + s * (m[2 * j].0[l] * u[0] + m[2 * j + 1].0[l] * u[1]))
}

#[test]
fn a_cut_moves_the_state_by_all_inputs() {
    let mut stream = Stream::new(5, 0, 0);
    for set in InstructionSet::available() {
        let basis = part(set, 0.3, 1.0);
        for (modes, count) in MODES.into_iter().zip(COLUMNS) {
            let padded = chunks(modes) * LANES;
            let used = |chunk: usize| (modes - chunk * LANES).min(LANES);
            let (mut blocks, mut exponentials, mut own) = (Vec::new(), Vec::new(), Vec::new());
            for c in 0..chunks(modes) {
                let mut pair = || [lanes(used(c), &mut stream), lanes(used(c), &mut stream)];
                let ([a, b], [d, e]) = (pair(), pair());
                blocks.push(BlockChunk {
                    traceless: [a, b, d, e],
                    deflection: pair(),
                    mesh_pull: pair(),
                    static_input: pair(),
                    rest: pair(),
                    drifts: c % 2 == 0,
                });
                exponentials.push(ExponentialChunk {
                    series: std::array::from_fn(|_| pair()),
                    terms: TERMS - 2 * c,
                });
                own.push(pair());
            }
            let from: Vec<_> = (0..count).flat_map(|_| state(modes, &mut stream)).collect();
            let moments = rows(count, &mut stream);
            let mut end = vec![[Lanes([f64::NAN; LANES]); 2]; chunks(modes)];
            for (moments, ripple) in [(&[][..], None), (&moments, Some(&moments[0]))] {
                let mut x = from.clone();
                cut(
                    set,
                    &blocks,
                    &exponentials,
                    &basis,
                    moments,
                    &mut end,
                    &mut x,
                );
                if let Some(weights) = ripple {
                    push(
                        set,
                        &blocks,
                        &exponentials,
                        &own,
                        weights,
                        &mut x[..2 * padded],
                    );
                }
                let columns = x.chunks(2 * padded).zip(from.chunks(2 * padded));
                for (column, (x, from)) in columns.enumerate() {
                    for i in 0..modes {
                        let (c, l) = (i / LANES, i % LANES);
                        let (block, m) = (&blocks[c], &blocks[c].traceless);
                        let mut exact = [0.0; 2];
                        let mut add = |weights: &Row, u: [f64; 2]| {
                            let kept = &exponentials[c];
                            for (e, w) in kept.series[..kept.terms].iter().zip(&weights.0) {
                                let term = applied(w * e[0].0[l], w * e[1].0[l], m, u, l);
                                exact[0] += term[0];
                                exact[1] += term[1];
                            }
                        };
                        let first = column == 0;
                        let rest = [0, 1].map(|j| if first { block.rest[j].0[l] } else { 0.0 });
                        add(&basis.end, [from[i] - rest[0], from[padded + i] - rest[1]]);
                        for (weights, input) in [
                            (moments.get(column), &block.mesh_pull),
                            (
                                (first && block.drifts).then_some(&basis.constant),
                                &block.static_input,
                            ),
                            (ripple.filter(|_| first), &own[c]),
                        ] {
                            if let Some(weights) = weights {
                                add(weights, [input[0].0[l], input[1].0[l]]);
                            }
                        }
                        let what = format!("{}, block {i} of {modes}", set.name());
                        for j in 0..2 {
                            close(x[j * padded + i], exact[j] + rest[j], 200.0, &what);
                        }
                    }
                    for i in modes..padded {
                        assert_eq!((x[i], x[padded + i]), (0.0, 0.0), "padding moved");
                    }
                }
            }
        }
    }
}

/// Agrees with the kernels' common saltation, block after block.
#[test]
fn an_event_salts_every_column() {
    let mut stream = Stream::new(6, 0, 0);
    for set in InstructionSet::available() {
        for modes in MODES {
            let padded = chunks(modes) * LANES;
            let mut blocks = vec![
                BlockChunk {
                    traceless: [Lanes::ZERO; 4],
                    deflection: [Lanes::ZERO; 2],
                    mesh_pull: [Lanes::ZERO; 2],
                    static_input: [Lanes::ZERO; 2],
                    rest: [Lanes::ZERO; 2],
                    drifts: false,
                };
                chunks(modes)
            ];
            let mut gains = Vec::new();
            for i in 0..modes {
                let (w, g) = (stream.normal(), stream.normal());
                let gain = MeshGain::mode(&Block::mode(1.0, 0.1, 0.0), w, g);
                for j in 0..2 {
                    let block = &mut blocks[i / LANES];
                    block.deflection[j].0[i % LANES] = gain.deflection[j];
                    block.mesh_pull[j].0[i % LANES] = -gain.mesh_input[j];
                }
                gains.push(gain);
            }
            let from: Vec<_> = (0..3).flat_map(|_| state(modes, &mut stream)).collect();
            for (entering, damping) in [(true, 0.4), (false, -0.4)] {
                let (mut found, mut exact) = (from.clone(), from.clone());
                apply_saltation(set, &blocks, damping, &mut found);
                for x in exact.chunks_mut(2 * padded) {
                    let (first, second) = x.split_at_mut(padded);
                    saltation::apply(&gains, 0.4, entering, first, second);
                }
                for (found, exact) in found.iter().zip(&exact) {
                    close(*found, *exact, 100.0, set.name());
                }
            }
        }
    }
}

/// The solution of a window's system satisfies its equation at the nodes, for every number of columns.
#[test]
fn factors_solve_a_window_whose_stiffness_varies() {
    let mut stream = Stream::new(7, 0, 0);
    let unit: [Row; TERMS] = std::array::from_fn(|j| {
        let mut row = Row::ZERO;
        row.0[j] = 1.0;
        row
    });
    let mut small = || -> [Row; TERMS] {
        std::array::from_fn(|_| Row(series(&mut stream).map(|value| 0.02 * value)))
    };
    // The maps are unit matrices: a series equals its values at the nodes.
    let nodal = Nodal {
        response: small(),
        response_rate: small(),
        series_response: small(),
        pace: 1.5,
        maps: Box::leak(Box::new(Maps {
            values: unit,
            slopes: small(),
            series: unit,
        })),
    };
    let (stiffness, damping, gap) = ([2.0, 0.3, -0.2, 0.1, 0.05, 0.0], 0.6, 0.7);
    let stiffness: [f64; STIFFNESS_TERMS] =
        std::array::from_fn(|n| stiffness.get(n).copied().unwrap_or(0.0));
    let places = transforms24().nodes().map(|x| 0.4 * x - 0.1);
    let (length, rows) = (80, rows(84, &mut stream));
    let columns = deviates(9 * length, &mut stream);
    for set in InstructionSet::available() {
        let mut factors = Factors::NONE;
        factorise(set, &nodal, &stiffness, &places, damping, &mut factors);
        for count in COLUMNS {
            let (mut found, mut forces) = (Solution::ZERO, vec![Row::ZERO; count]);
            let contact = Some((ContactSolve::Factors(&nodal, &factors), gap, None));
            let columns = &columns[..count * length];
            solve(
                set,
                &rows,
                &[0.0; 4],
                columns,
                contact,
                &mut forces,
                &mut found,
            );
            for (c, (f, x)) in forces.iter().zip(columns.chunks(length)).enumerate() {
                let d = combined(&rows[..length], x).map(|d| d.0);
                let gap = if c == 0 { gap } else { 0.0 };
                let slopes = combined(&nodal.maps.slopes, &d);
                let [b, rate] = [&nodal.response, &nodal.response_rate].map(|m| combined(m, &f.0));
                for i in 0..TERMS {
                    let k = evaluate(&stiffness, places[i]);
                    let left = f.0[i] + k * b[i].0 + damping * rate[i].0;
                    let right = k * (d[i] - gap) + damping * nodal.pace * slopes[i].0;
                    close(left, right, 100.0, &format!("{}, column {c}", set.name()));
                }
                if c == 0 {
                    let yielded = combined(&nodal.series_response, &f.0);
                    for i in 0..TERMS {
                        close(found.deflection[i], d[i] - yielded[i].0, 100.0, set.name());
                    }
                }
            }
        }
    }
}

#[test]
fn every_set_finds_the_same_crossing() {
    let rule = transforms24();
    let nodes = *rule.nodes();
    let rise = |x: f64| 1.5 * (0.5 * (x + 1.0)).sin();
    let deflection = rule.interpolate(&std::array::from_fn(|j| rise(nodes[j])));
    let exact = 2.0 * (1.0f64 / 1.5).asin() - 1.0;
    let contacts = [1.0, -1.0].map(|side| Contact {
        band: f64::INFINITY,
        side,
        half_gap: 1.0,
        cycles: Vec::new(),
        release: Release::Deflection,
    });
    let guards: Vec<_> = Margin::of(&contacts, ActiveSet::FREE)
        .map(|margin| Guard {
            margin,
            crossed: false,
            gap_error: None,
        })
        .collect();
    for set in InstructionSet::available() {
        let mut counters = Counters::default();
        let found = first_crossing(set, &deflection, 1e-14, &guards, 1.0, &mut counters);
        let contact = found.map(|c| c.contact);
        assert_eq!(contact, Some(DRIVE_FLANK), "{}", set.name());
        let x = found.map_or(f64::NAN, |c| c.x);
        assert!((x - exact).abs() < 1e-14, "{}: {x} {exact}", set.name());
    }
}

/// A chunk with few force terms is unchanged if a further term is set.
#[test]
fn a_term_that_a_chunk_has_no_room_for_is_left_out() {
    let mut windows = Windows::new(&[2, 4], 1);
    for block in [0, LANES] {
        windows.set_input(block, 0, [5.0, 6.0]);
    }
    let before = format!("{windows:?}");
    windows.set_response(0, 2, [7.0, 8.0]);
    windows.set_response(LANES, 4, [7.0, 8.0]);
    assert_eq!(format!("{windows:?}"), before);
    windows.set_response(LANES, 2, [7.0, 8.0]);
    assert_ne!(format!("{windows:?}"), before);
}
