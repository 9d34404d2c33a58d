//! Compares blocks with the matrices from which they are computed.

use super::components::turn_columns;
use super::*;
use faer::prelude::*;

/// Uniform numbers between -1 and 1 from a 64-bit xorshift generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn matrix(&mut self, n: usize, size: f64) -> Vec<f64> {
        (0..n * n).map(|_| size * self.next()).collect()
    }
}

fn square(values: &[f64], n: usize) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| values[i * n + j])
}

fn system(w: &[f64], d: &[f64], s: &[f64]) -> Mat<f64> {
    let n = w.len();
    Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, _) => f64::from(u8::from(j == n + i)),
        (false, true) => -s[(i - n) * n + j] - if i - n == j { w[j] * w[j] } else { 0.0 },
        (false, false) => -d[(i - n) * n + j - n],
    })
}

fn block_matrix(blocks: &[[[f64; 2]; 2]]) -> Mat<f64> {
    let n = blocks.len();
    Mat::from_fn(2 * n, 2 * n, |i, j| {
        if i % n == j % n { blocks[i % n][i / n][j / n] } else { 0.0 }
    })
}

/// Decouples, and checks `A T = T B` and the inverse of T. Displacements are multiplied by `unit`.
fn checked(w: &[f64], d: &[f64], s: &[f64], name: &str) -> Decoupled {
    let result = decouple(w, d, s).unwrap();
    let n = w.len();
    let unit = |k: usize| if k < n && w[k] > 0.0 { w[k] } else { 1.0 };
    let scaled = |m: &Mat<f64>| Mat::from_fn(2 * n, 2 * n, |i, j| m[(i, j)] * unit(i) / unit(j));
    let rows = |m: &Mat<f64>| Mat::from_fn(2 * n, 2 * n, |i, j| m[(i, j)] * unit(i));
    let (t, inverse) = (
        square(&result.to_structure, 2 * n),
        square(&result.from_structure, 2 * n),
    );
    let (a, b) = (system(w, d, s), block_matrix(&result.generators));
    let residual =
        rows(&(&a * &t - &t * &b)).norm_l2() / (scaled(&a).norm_l2() * rows(&t).norm_l2());
    let defect = (&inverse * &t - Mat::<f64>::identity(2 * n, 2 * n)).norm_max();
    assert!(residual < 2e-15, "{name}: residual {residual:e}");
    assert!(
        defect < 1e-12 * (result.condition / 1e4).max(1.0),
        "{name}: inverse {defect:e}"
    );
    result
}

fn exponential(a: &Mat<f64>, time: f64) -> Mat<f64> {
    let n = a.nrows();
    let halvings = (a.norm_l2() * time).log2().ceil().max(0.0) as i32 + 4;
    let step = a * Scale(time / 2.0_f64.powi(halvings));
    let (mut sum, mut term) = (Mat::<f64>::identity(n, n), Mat::<f64>::identity(n, n));
    for k in 1..16 {
        term = &term * &step * Scale(1.0 / f64::from(k));
        sum += &term;
    }
    (0..halvings).for_each(|_| sum = &sum * &sum);
    sum
}

fn determinant(b: &[[f64; 2]; 2]) -> f64 {
    b[0][0] * b[1][1] - b[0][1] * b[1][0]
}

#[test]
fn random_systems_are_decoupled_exactly_and_move_alike() {
    let mut random = Random(7);
    for n in 3..=12 {
        for _ in 0..5 {
            let w: Vec<f64> = (0..n).map(|_| 10.0_f64.powf(1.0 + random.next())).collect();
            let mut d = random.matrix(n, 1.0);
            (0..n).for_each(|i| d[i * n + i] += 1.5 * n as f64);
            let s = random.matrix(n, 0.3);
            let result = checked(&w, &d, &s, "random");
            assert!(
                result
                    .generators
                    .windows(2)
                    .all(|b| determinant(&b[0]).abs() <= determinant(&b[1]).abs() * (1.0 + 1e-12))
            );
            let (t, inverse) = (
                square(&result.to_structure, 2 * n),
                square(&result.from_structure, 2 * n),
            );
            let direct = exponential(&system(&w, &d, &s), 0.05);
            let moved = t * exponential(&block_matrix(&result.generators), 0.05) * inverse;
            let difference = (&moved - &direct).norm_l2() / direct.norm_l2();
            assert!(difference < 1e-11, "exponential {difference:e}");
        }
    }
}

#[test]
fn uncoupled_modes_keep_their_bits() {
    let w = [0.0, 100.1, 203.3, 317.7, 1e4];
    let mut d = vec![0.0; 25];
    (0..5).for_each(|i| d[6 * i] = 0.1 * (i as f64 + 1.0));
    let mut s = vec![0.0; 25];
    s[6] = 3.3;
    let alone = decouple(&w, &d, &s).unwrap();
    assert!(alone.is_identity && alone.condition == 1.0);
    d[7] = 5.0;
    d[11] = -3.0;
    d[1] = 1e-18;
    let result = checked(&w, &d, &s, "two of five coupled");
    for i in [0, 3, 4] {
        assert_eq!(
            result.generators[i],
            [[0.0, 1.0], [0.0 - w[i] * w[i], -d[6 * i]]]
        );
        assert_eq!(alone.generators[i], result.generators[i]);
        for k in 0..10 {
            for c in [i, 5 + i] {
                assert_eq!(result.to_structure[10 * k + c], f64::from(u8::from(k == c)));
                assert_eq!(
                    result.from_structure[10 * c + k],
                    f64::from(u8::from(k == c))
                );
            }
        }
    }
    assert!(!result.is_identity);
}

#[test]
fn gyroscopic_structures_neither_grow_nor_decay() {
    let mut random = Random(11);
    for n in [2, 6, 40] {
        let w: Vec<f64> = (0..n).map(|i| 100.0 * (1.0 + (i / 2) as f64)).collect();
        let g = random.matrix(n, 30.0);
        let d: Vec<f64> = (0..n * n).map(|k| g[k] - g[k % n * n + k / n]).collect();
        let result = checked(&w, &d, &vec![0.0; n * n], "gyroscopic");
        assert!(result.condition < 1.0 + 1e-10, "{}", result.condition);
        for [[mu, nu], [back, other]] in result.generators {
            assert!(
                mu.abs() <= 1e-13 * nu && mu == other && nu == -back,
                "{mu:e} {nu:e}"
            );
        }
    }
}

#[test]
fn overdamped_mode_beside_light_ones() {
    let w = [50.0, 900.0, 2000.0, 8000.0];
    let c = [4.0, 3.0, 70.0, 5.0];
    let d: Vec<f64> = (0..16)
        .map(|k| 2.0 * c[k / 4] * c[k % 4] + if k % 5 == 0 { 1.0 } else { 0.0 })
        .collect();
    let result = checked(&w, &d, &[0.0; 16], "overdamped");
    let real = result
        .generators
        .iter()
        .filter(|b| (b[0][0] - b[1][1]).powi(2) + 4.0 * b[0][1] * b[1][0] > 0.0);
    assert_eq!(real.count(), 1);
    assert!(result.condition < 20.0);
}

#[test]
fn critical_pairs_stay_well_conditioned() {
    // A rotation of two modes of one frequency couples a critical mode with a light one.
    let (cosine, sine) = (0.6, 0.8);
    for critical in [
        20.0,
        20.0 * (1.0 + 1e-14),
        20.0 * (1.0 - 1e-9),
        20.0 * (1.0 + 1e-7),
    ] {
        let (p, q) = (critical, 0.3);
        let d = [
            cosine * cosine * p + sine * sine * q,
            cosine * sine * (p - q),
            cosine * sine * (p - q),
            sine * sine * p + cosine * cosine * q,
        ];
        let result = checked(&[10.0, 10.0], &d, &[0.0; 4], "critical");
        assert!(result.condition < 10.0, "{}", result.condition);
    }
}

#[test]
fn rigid_rotations_under_drag() {
    let alone = decouple(&[0.0, 5.0], &[0.4, 0.0, 0.0, 0.1], &[0.0; 4]).unwrap();
    assert_eq!(
        alone.generators,
        [[[0.0, 1.0], [0.0, -0.4]], [[0.0, 1.0], [-25.0, -0.1]]]
    );
    // Drag acts on 0.6 a - 0.8 b only. It does not restrain the other combination of the rotations.
    let result = checked(
        &[0.0, 0.0],
        &[0.36, -0.48, -0.48, 0.64],
        &[0.0; 4],
        "drag of rank one",
    );
    assert_eq!(result.generators[0], [[0.0, 1.0], [0.0, 0.0]]);
    assert_eq!(
        [result.generators[1][0], [result.generators[1][1][0], 0.0]],
        [[0.0, 1.0], [0.0, 0.0]]
    );
    assert!((result.generators[1][1][1] + 1.0).abs() < 1e-15);
    for drag in [1.0, 1e-6, 1e4] {
        let c = [[0.5, -0.3, 0.1, 0.2, -0.4], [0.2, 0.7, -0.6, 0.3, 0.1]];
        let mut d: Vec<f64> = (0..25)
            .map(|k| drag * (c[0][k / 5] * c[0][k % 5] + c[1][k / 5] * c[1][k % 5]))
            .collect();
        let free = [0.0, 0.0, 0.0, 300.0, 700.0];
        let result = checked(&free, &d, &[0.0; 25], "three rigid, drag of rank two");
        assert_eq!(result.generators[0], [[0.0, 1.0], [0.0, 0.0]]);
        for b in &result.generators[1..3] {
            assert_eq!([b[0][0], b[1][0]], [0.0, 0.0]);
            assert!(b[1][1] < 0.0);
        }
        assert!(result.condition < 1e4, "{}", result.condition);
        // A gyroscopic couple between two of the rigid rotations leaves no real partners.
        d = vec![0.0; 25];
        (d[1], d[5], d[3], d[15]) = (drag, -drag, 0.1 * drag, -0.1 * drag);
        let result = checked(&free, &d, &[0.0; 25], "rigid gyroscopic");
        assert_eq!(
            result
                .generators
                .iter()
                .filter(|b| **b == [[0.0; 2]; 2])
                .count(),
            1
        );
    }
}

#[test]
fn friction_may_push_a_free_direction() {
    // The elastic modes exert a force on the rigid mode, without a reaction.
    let mut s = vec![0.0; 9];
    (s[1], s[2], s[5], s[7]) = (40.0, -30.0, 5.0, 9.0);
    let mut d = vec![0.0; 9];
    (d[4], d[8], d[2]) = (1.0, 2.0, 0.5);
    let result = checked(&[0.0, 20.0, 31.0], &d, &s, "pushed rigid mode");
    assert_eq!(result.generators[0], [[0.0, 1.0], [0.0, 0.0]]);
}

/// The scale of a mode is its frequency. A coupling k to another mode of frequency ω raises it to `√k`, or to
/// `k/ω` if ω is larger than `√k`.
#[test]
fn a_mode_has_the_scale_of_what_couples_it() {
    let zero = square(&[0.0; 4], 2);
    let coupled = square(&[0.0, 404.0, 404.0, 0.0], 2);
    for (frequency, expected) in [
        ([1.0, 100.0], [4.04, 100.0]),
        ([1.0, 3.0], [404_f64.sqrt(); 2]),
        ([0.0, 100.0], [4.04, 100.0]),
    ] {
        let found = scales(&[0, 1], &frequency, &[zero.clone(), coupled.clone()]);
        assert_eq!(found, expected);
    }
    // Drag is the scale of a rigid mode only.
    let dragged = square(&[0.0, 500.0, 500.0, 0.0], 2);
    for (frequency, expected) in [([1.0, 100.0], [1.0, 100.0]), ([0.0, 100.0], [500.0, 100.0])] {
        let found = scales(&[0, 1], &frequency, &[dragged.clone(), zero.clone()]);
        assert_eq!(found, expected);
    }
}

#[test]
fn clusters_of_more_than_two_are_refused() {
    // q1'' + q1' = 0 drives q2'' + q2' = q1'' through drag, so -1 is a defective double value,
    // and a third mode makes it triple.
    let mut d = vec![0.0; 9];
    (d[0], d[4], d[8], d[3], d[7]) = (1.0, 1.0, 1.0, -1.0, -1.0);
    let refused = decouple(&[0.0; 3], &d, &[0.0; 9]).unwrap_err();
    let DecouplingError::NearlyDefective { modes, condition } = &refused else {
        panic!("{refused}")
    };
    assert!(
        !modes.is_empty()
            && modes.iter().all(|m| (1..=3).contains(m))
            && *condition > CONDITION_BOUND
    );
    // Circulatory stiffness at the onset of flutter: two coinciding complex pairs.
    for size in [1.0, 17.3, 1e3, 1e5] {
        let w = [size, size * 1.1_f64.sqrt(), 3.0 * size];
        let k = 0.05 * size * size;
        let s = [0.0, k, 0.0, -k, 0.0, 0.01 * k, 0.0, 0.01 * k, 0.0];
        let s_exact = [0.0, k, 0.0, -k, 0.0, 0.0, 0.0, 0.0, 0.0];
        let flutter = decouple(&w, &[0.0; 9], &s_exact);
        assert!(
            matches!(&flutter, Err(DecouplingError::NearlyDefective { modes, .. }) if modes.iter().all(|m| *m <= 2)),
            "{flutter:?}"
        );
        checked(&w, &[0.0; 9], &s, "near flutter");
    }
    // A third mode with almost no part in the flutter is not named.
    let s = [0.0, 0.05, 1e-7, -0.05, 0.0, 0.0, 1e-7, 0.0, 0.0];
    let flutter = decouple(&[1.0, 1.1_f64.sqrt(), 3.0], &[0.0; 9], &s);
    let Err(DecouplingError::NearlyDefective { modes, .. }) = &flutter else {
        panic!("{flutter:?}")
    };
    assert!(!modes.contains(&3), "{modes:?}");
    assert!(refused.to_string().contains("modes"), "{refused}");
    assert_eq!(
        decouple(&[1.0], &[0.0; 2], &[0.0]),
        Err(DecouplingError::Size(1))
    );
    assert_eq!(
        decouple(&[-1.0], &[0.0], &[0.0]),
        Err(DecouplingError::Value)
    );
    assert!(decouple(&[], &[], &[]).unwrap().is_identity);
}

#[test]
fn a_large_component_with_rigid_modes() {
    let mut random = Random(3);
    let n = 60;
    let w: Vec<f64> = (0..n)
        .map(
            |i| {
                if i < 6 { 0.0 } else { 300.0 * f64::from(i as u32).powf(1.2) }
            },
        )
        .collect();
    let c = random.matrix(n, 1.0);
    let product = |b: usize, other: usize, k: usize| c[b * n + k / n] * c[other * n + k % n];
    let mut d: Vec<f64> = (0..n * n)
        .map(|k| (0..8).map(|b| 50.0 * product(b, b, k)).sum())
        .collect();
    (6..n).for_each(|i| d[i * n + i] += 0.02 * w[i]);
    let s: Vec<f64> = (0..n * n)
        .map(|k| (8..12).map(|b| 1e4 * product(b, b + 4, k)).sum())
        .collect();
    assert!(checked(&w, &d, &s, "large").condition < 100.0);
    let result = checked(&w, &d, &vec![0.0; n * n], "large without stiffness");
    assert!(result.condition < 10.0);
    let zeros = result
        .generators
        .iter()
        .filter(|b| [b[0][0], b[1][0]] == [0.0; 2]);
    assert_eq!(zeros.count(), 6);
}

#[test]
fn axisymmetric_structures_with_repeated_eigenvalues() {
    let mut random = Random(99);
    for trial in 0..300 {
        // Every mode occurs in two planes with equal drag and stiffness. Each pair is
        // rotated, the rigid ones all together.
        let (pairs, rigid) = (2 + trial % 4, 1 + trial % 2);
        let n = 2 * pairs;
        let level = |i: usize| 10.0_f64.powi((i / 2) as i32) * (1.0 + 0.1 * (trial % 10) as f64);
        let w: Vec<f64> = (0..n)
            .map(|i| if i / 2 < rigid { 0.0 } else { level(i) })
            .collect();
        let drag = 10.0_f64.powf(6.0 * random.next() - 2.0);
        let gyro = if trial % 3 == 0 { 0.3 * drag } else { 0.0 };
        let cross = if trial % 5 == 0 { 3.0 } else { 0.0 };
        let c: Vec<f64> = (0..pairs).map(|_| random.next()).collect();
        let e: Vec<f64> = (0..pairs)
            .map(|k| if k < rigid { 0.0 } else { random.next() })
            .collect();
        let fill = |c: &[f64], same: f64, skew: f64| {
            Mat::from_fn(n, n, |i, j| {
                let part = [[same, -skew], [skew, same]][i % 2][j % 2];
                c[i / 2] * c[j / 2] * part
            })
        };
        let mut turn = Mat::<f64>::identity(n, n);
        for p in (0..2 * n).map(|k| k % n) {
            let q = if w[p] == 0.0 { (p + 1) % (2 * rigid) } else { p ^ 1 };
            let (sine, cosine) = (3.0 * random.next()).sin_cos();
            let places = Mat::from_fn(2, 2, |i, j| [[cosine, sine], [-sine, cosine]][i][j]);
            turn_columns(&mut turn, &[p, q], &places);
        }
        let flat = |m: Mat<f64>| {
            let m = turn.transpose() * m * &turn;
            (0..n * n).map(|k| m[(k / n, k % n)]).collect::<Vec<f64>>()
        };
        let (d, s) = (flat(fill(&c, drag, gyro)), flat(fill(&e, 20.0, cross)));
        let result = decouple(&w, &d, &s).unwrap();
        let (t, b) = (
            square(&result.to_structure, 2 * n),
            block_matrix(&result.generators),
        );
        let a = system(&w, &d, &s);
        let unit = |k: usize| if k < n && w[k] > 0.0 { w[k] } else { 1.0 };
        let rows = |m: &Mat<f64>| Mat::from_fn(2 * n, 2 * n, |i, j| m[(i, j)] * unit(i));
        let scaled = Mat::from_fn(2 * n, 2 * n, |i, j| a[(i, j)] * unit(i) / unit(j));
        let residual = rows(&(&a * &t - &t * &b)).norm_l2();
        let relative = residual / (scaled.norm_l2() * rows(&t).norm_l2());
        assert!(relative < 1e-14, "trial {trial}: residual {relative:e}");
        let zeros: usize = result
            .generators
            .iter()
            .filter(|b| [b[0][0], b[1][0]] == [0.0; 2])
            .map(|b| if b[1][1] == 0.0 { 2 } else { 1 })
            .sum();
        assert_eq!(zeros, if rigid == 2 { 6 } else { 2 }, "trial {trial}");
    }
}

/// The pushed rigid mode is a free direction at any index.
#[test]
fn a_free_direction_stands_anywhere() {
    let w = [0.0, 20.0, 31.0];
    let d = [[0.0, 0.0, 0.5], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]];
    let s = [[0.0, 40.0, -30.0], [0.0, 0.0, 5.0], [0.0, 9.0, 0.0]];
    for order in [[0, 1, 2], [1, 0, 2], [1, 2, 0], [2, 1, 0]] {
        let moved = |m: &[[f64; 3]; 3]| -> Vec<f64> {
            (0..9).map(|k| m[order[k / 3]][order[k % 3]]).collect()
        };
        let result = checked(&order.map(|i| w[i]), &moved(&d), &moved(&s), "moved");
        let free = |b: &&[[f64; 2]; 2]| **b == [[0.0, 1.0], [0.0, 0.0]];
        assert_eq!(
            result.generators.iter().filter(free).count(),
            1,
            "{order:?}"
        );
    }
}

/// If three real eigenvectors are pairwise nearly parallel, the closest two share a block.
#[test]
fn three_nearly_parallel_eigenvectors_are_paired_once() {
    for coupling in [5.0, 8.0] {
        let mut d = [0.0; 9];
        (d[0], d[4], d[8]) = (10.0, 11.0, 12.0);
        (d[1], d[2], d[5]) = (coupling, coupling, coupling);
        let result = checked(&[1.0, 1.2, 1.5], &d, &[0.0; 9], "three parallel");
        assert!(result.generators.iter().all(|b| determinant(b) > 0.0));
    }
}

/// Equal planets around a centre, each a chain of two bodies, in random modes. The multiplicity of most
/// eigenvalues is the number of planets minus 1. Without separation, round-off would make their eigenvectors
/// nearly parallel.
#[test]
fn equal_bodies_have_independent_eigenvectors() {
    for planets in [3, 4, 5, 7] {
        let n = 2 * planets + 1;
        // From the centre to the first body, and from that to the second: stiffness and damping.
        let chain = [[3e8, 900.0], [7e7, 300.0]];
        let mut of_bodies = [(); 2].map(|()| Mat::<f64>::zeros(n, n));
        let mut join = |i: usize, j: usize, law: [f64; 2]| {
            for (matrix, value) in of_bodies.iter_mut().zip(law) {
                matrix[(i, i)] += value;
                matrix[(j, j)] += value;
                matrix[(i, j)] -= value;
                matrix[(j, i)] -= value;
            }
        };
        for planet in 0..planets {
            join(0, 1 + 2 * planet, chain[0]);
            join(1 + 2 * planet, 2 + 2 * planet, chain[1]);
        }
        for i in 0..n {
            of_bodies[0][(i, i)] += 5e7;
            of_bodies[1][(i, i)] += 20.0;
        }
        let mut random = Random(77);
        let turn = square(&random.matrix(n, 1.0), n).qr().compute_Q();
        let [stiffness, damping] = of_bodies.map(|matrix| turn.transpose() * matrix * &turn);
        let w = vec![5e3; n];
        let rows = |matrix: &Mat<f64>, off: f64| -> Vec<f64> {
            let entry =
                |k: usize| matrix[(k / n, k % n)] - f64::from(u8::from(k / n == k % n)) * off;
            (0..n * n).map(entry).collect()
        };
        let (d, s) = (rows(&damping, 0.0), rows(&stiffness, 2.5e7));
        let found = checked(&w, &d, &s, &format!("{planets} planets"));
        assert!(found.condition < 100.0, "{planets}: {:e}", found.condition);
    }
}
