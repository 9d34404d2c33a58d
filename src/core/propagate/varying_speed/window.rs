//! The motion on one window as power series.
//!
//! Between breakpoints and events `z' = A z + s(t) − Σ g F`, with forces `F = k (δ − s b) + c (δ' − s b')` of the
//! closed contacts and deflections `δ = w·z − e`. Stiffness, gaps, errors and loads are power series of `u = t/h` for
//! any course of the speed, and so is the motion: coefficient j + 1 of z follows from those up to j. Deflections and
//! forces come first, from the responses of the structure, then the blocks. Windows are so short that the terms
//! beyond 24 are within round-off.

use super::powers::{COURSE_TERMS, Course, Powers};
use super::responses::{Delayed, FACTORIALS, INVERSE_FACTORIALS, answer, delayed};
use super::rows::Rows;
use super::system::{System, Wave};
use crate::model::LOAD_TERMS;
use crate::propagate::vectors::{Aligned, InstructionSet, LANES, TERMS, Vector, for_each_set};

/// A closed contact on a window.
#[derive(Debug, Clone, Copy)]
pub struct Closed {
    /// Its index among the contacts.
    pub contact: usize,
    /// Its line.
    pub line: usize,
    /// Index of its line in [`WindowSeries::lines`].
    pub place: usize,
    /// Its direction.
    pub direction: usize,
    /// +1 or −1.
    pub side: f64,
    /// c \[N s/m\].
    pub damping: f64,
}

/// Stiffness and gap of a contact on a window.
#[derive(Debug, Clone, Copy)]
pub struct ContactCourse {
    /// k \[N/m\].
    pub stiffness: Powers,
    /// Number of its terms.
    pub stiffness_terms: usize,
    /// b \[m\].
    pub gap: Powers,
}

impl ContactCourse {
    /// All zero.
    pub const ZERO: Self = Self {
        stiffness: [0.0; TERMS],
        stiffness_terms: 1,
        gap: [0.0; TERMS],
    };
}

/// Length of a window, and the course of rotation and loads on it.
pub struct WindowCourse {
    /// Its length \[s\].
    pub length: f64,
    /// Mesh cycles that pass, by powers of u.
    pub cycles: Course,
    /// Course of each load term, by powers of u.
    pub loads: [Course; LOAD_TERMS],
    /// Whether it ends at the end of the segments.
    pub at_end: bool,
}

/// The series of a window, and the data for computing them.
#[derive(Debug, Clone)]
pub struct WindowSeries {
    /// First and second components of the blocks: padded rows, one per power of u.
    pub components: [Aligned; 2],
    /// The components at the end of the window.
    pub end: [Aligned; 2],
    /// Deflection of every line of the model \[m\]; unused for lines without a contact.
    pub deflections: Vec<Powers>,
    /// Sum of the absolute contributions to a deflection at the start of the window \[m\].
    pub sizes: Vec<f64>,
    /// Errors of the lines \[m\].
    pub errors: Vec<Powers>,
    /// Cosine and sine of every wave.
    pub waves: Vec<[Powers; 2]>,
    /// Series of the ripples, which multiply their inputs.
    pub ripples: Vec<Powers>,
    /// The lines with a contact. Each entry is a line and the direction of a force along it.
    pub lines: Vec<[usize; 2]>,
    /// Line of every contact.
    pub line_of: Vec<usize>,
    /// Deflections of `lines` without their transmission errors: `j!` times the coefficient of the j-th power.
    pub seen: Vec<Powers>,
    /// Responses of `lines` to forces of the closed contacts; one entry per contact and line.
    pub answers: Vec<Delayed>,
    /// The closed contacts.
    pub closed: Vec<Closed>,
    /// Force of each closed contact \[N\].
    pub forces: Vec<Powers>,
    /// Laws of all contacts.
    pub laws: Vec<ContactCourse>,
}

/// `Σ factor · wave`.
pub fn sum_of_waves(parts: &[Wave], waves: &[[Powers; 2]]) -> Powers {
    let mut out = [0.0; TERMS];
    for part in parts {
        let [cos, sin] = &waves[part.wave];
        for (j, sum) in out.iter_mut().enumerate() {
            *sum += part.cos * cos[j] + part.sin * sin[j];
        }
    }
    out
}

/// Cosine and sine of `start + Σ angle u^k` \[rad\], without the constant term of `angle`.
pub fn wave(start: f64, angle: &Course) -> [Powers; 2] {
    let (mut cos, mut sin) = ([0.0; TERMS], [0.0; TERMS]);
    (sin[0], cos[0]) = start.sin_cos();
    let slopes: [f64; COURSE_TERMS - 1] = std::array::from_fn(|m| (m + 1) as f64 * angle[m + 1]);
    for j in 0..TERMS - 1 {
        let [mut c, mut s] = [0.0; 2];
        for (m, slope) in slopes.iter().enumerate().take(j + 1) {
            c -= slope * sin[j - m];
            s += slope * cos[j - m];
        }
        let share = 1.0 / (j + 1) as f64;
        (cos[j + 1], sin[j + 1]) = (share * c, share * s);
    }
    [cos, sin]
}

/// `Σ |row · component|`.
#[inline(always)]
fn size_along<V: Vector>(rows: &Rows, components: [&[f64]; 2]) -> f64 {
    let mut sum = V::zero();
    for part in 0..2 {
        for at in (0..rows[part].len()).step_by(LANES) {
            let component = V::read(&components[part][at..]);
            sum = sum.plus(V::read(&rows[part][at..]).times(component).size());
        }
    }
    sum.sum()
}

for_each_set! {
    /// Computes the deflections and forces of a window. The first row of `motions.components` is the state at
    /// its start.
    fn meet(system: &System, task: &WindowCourse, motions: &mut WindowSeries) = meet_body
}

#[inline(always)]
fn meet_body<V: Vector>(system: &System, task: &WindowCourse, motions: &mut WindowSeries) {
    let (n, length) = (system.padded, task.length);
    let mut scales = [1.0; TERMS];
    for j in 1..TERMS {
        scales[j] = scales[j - 1] * system.fastest * length;
    }
    let now = [&motions.components[0][..n], &motions.components[1][..n]];
    for (place, &[line, direction]) in motions.lines.iter().enumerate() {
        let answers = &system.answers[direction];
        motions.sizes[line] = size_along::<V>(&system.directions[direction].deflection, now)
            + motions.errors[line][0].abs();
        let mut seen = answers.to_state::<V>(now, &scales);
        for k in 0..LOAD_TERMS {
            if let Some(load) = &answers.loads[k] {
                let load = delayed(load, &scales, length);
                for j in 0..COURSE_TERMS {
                    answer::<V>(&mut seen, &load, FACTORIALS[j] * task.loads[k][j], j);
                }
            }
        }
        for (ripple, series) in answers.ripples.iter().zip(&motions.ripples) {
            let ripple = delayed(ripple, &scales, length);
            for j in 0..TERMS {
                answer::<V>(&mut seen, &ripple, FACTORIALS[j] * series[j], j);
            }
        }
        motions.seen[place] = seen;
        for k in 0..motions.closed.len() {
            let force = &answers.forces[motions.closed[k].direction];
            motions.answers[place * motions.laws.len() + k] = delayed(force, &scales, length);
        }
    }
    for j in 0..TERMS {
        for (place, &[line, _]) in motions.lines.iter().enumerate() {
            motions.deflections[line][j] =
                motions.seen[place][j] * INVERSE_FACTORIALS[j] - motions.errors[line][j];
        }
        for k in 0..motions.closed.len() {
            let Closed {
                contact,
                line,
                place,
                side,
                damping,
                ..
            } = motions.closed[k];
            let law = &motions.laws[contact];
            let mut sum = 0.0;
            // Forces up to j − 1 determine deflections up to j + 1.
            if damping != 0.0 && j + 1 < TERMS {
                let next = motions.seen[place][j + 1] * INVERSE_FACTORIALS[j + 1];
                let rate = next - motions.errors[line][j + 1] - side * law.gap[j + 1];
                sum = damping * (j + 1) as f64 / length * rate;
            }
            for m in 0..law.stiffness_terms.min(j + 1) {
                sum +=
                    law.stiffness[m] * (motions.deflections[line][j - m] - side * law.gap[j - m]);
            }
            motions.forces[k][j] = sum;
            for place in 0..motions.lines.len() {
                let to = &motions.answers[place * motions.laws.len() + k];
                answer::<V>(&mut motions.seen[place], to, -FACTORIALS[j] * sum, j);
            }
        }
    }
}

for_each_set! {
    /// Computes the components of a window with known forces, and their values at the position `place` in it.
    fn move_blocks(system: &System, task: &WindowCourse, place: f64, motions: &mut WindowSeries) = move_blocks_body
}

#[inline(always)]
fn move_blocks_body<V: Vector>(
    system: &System,
    task: &WindowCourse,
    place: f64,
    motions: &mut WindowSeries,
) {
    let mut powers = [1.0; TERMS];
    for j in 1..TERMS {
        powers[j] = powers[j - 1] * place;
    }
    let groups = system.padded / LANES;
    let mut first = 0;
    while first < groups {
        let (at, course) = (first * LANES, (task, &powers));
        first += match (groups - first, system.modal) {
            (1, true) => move_groups::<V, 1, true>(system, course, at, motions),
            (2, true) => move_groups::<V, 2, true>(system, course, at, motions),
            (3, true) => move_groups::<V, 3, true>(system, course, at, motions),
            (5, true) => move_groups::<V, 5, true>(system, course, at, motions),
            (_, true) => move_groups::<V, 4, true>(system, course, at, motions),
            (1, false) => move_groups::<V, 1, false>(system, course, at, motions),
            (_, false) => move_groups::<V, 2, false>(system, course, at, motions),
        };
    }
}

/// Moves several lane groups at once, to hide latencies. Returns their number.
#[inline(always)]
fn move_groups<V: Vector, const GROUPS: usize, const MODAL: bool>(
    system: &System,
    (task, powers): (&WindowCourse, &Powers),
    at: usize,
    motions: &mut WindowSeries,
) -> usize {
    let n = system.padded;
    let group = |k: usize| at + k * LANES;
    let [a, b, c, d] = &system.generator;
    let (mut now, mut end) = ([[V::zero(); GROUPS]; 2], [[V::zero(); GROUPS]; 2]);
    for part in 0..2 {
        for k in 0..GROUPS {
            now[part][k] = V::read(&motions.components[part][group(k)..]);
            end[part][k] = now[part][k];
        }
    }
    for j in 0..TERMS - 1 {
        let mut rates = [[V::zero(); GROUPS]; 2];
        for k in 0..GROUPS {
            let [x, y] = [now[0][k], now[1][k]];
            let row = group(k);
            rates[0][k] = y;
            if !MODAL {
                let first = V::read(&b[row..]).times(y);
                rates[0][k] = V::read(&a[row..]).multiply_add(x, first);
            }
            let second = V::read(&c[row..]).times(x);
            rates[1][k] = V::read(&d[row..]).multiply_add(y, second);
        }
        for (closed, force) in motions.closed.iter().zip(&motions.forces) {
            let input = &system.directions[closed.direction].input;
            add::<V, GROUPS, MODAL>(input, -force[j], at, &mut rates);
        }
        if j < COURSE_TERMS {
            for (input, course) in system.loads.iter().zip(&task.loads) {
                if let (Some(input), true) = (input, course[j] != 0.0) {
                    add::<V, GROUPS, MODAL>(input, course[j], at, &mut rates);
                }
            }
        }
        for (input, ripple) in system.ripples.iter().zip(&motions.ripples) {
            add::<V, GROUPS, MODAL>(input, ripple[j], at, &mut rates);
        }
        let share = V::splat(task.length / (j + 1) as f64);
        let power = V::splat(powers[j + 1]);
        for part in 0..2 {
            let next = &mut motions.components[part][(j + 1) * n + at..][..GROUPS * LANES];
            for k in 0..GROUPS {
                now[part][k] = rates[part][k].times(share);
                end[part][k] = now[part][k].multiply_add(power, end[part][k]);
                now[part][k].write(&mut next[k * LANES..]);
            }
        }
    }
    for part in 0..2 {
        for k in 0..GROUPS {
            end[part][k].write(&mut motions.end[part][group(k)..]);
        }
    }
    GROUPS
}

/// Adds an input to the rates of lane groups. If blocks are modes, it acts on velocities alone.
#[inline(always)]
fn add<V: Vector, const GROUPS: usize, const MODAL: bool>(
    input: &Rows,
    factor: f64,
    at: usize,
    rates: &mut [[V; GROUPS]; 2],
) {
    let factor = V::splat(factor);
    for part in usize::from(MODAL)..2 {
        let rows = &input[part][at..][..GROUPS * LANES];
        for k in 0..GROUPS {
            rates[part][k] = V::read(&rows[k * LANES..]).multiply_add(factor, rates[part][k]);
        }
    }
}

for_each_set! {
    /// `Σ row · state` over the blocks.
    fn along(rows: &Rows, states: &[Aligned; 2]) -> f64 = along_body
}

#[inline(always)]
fn along_body<V: Vector>(rows: &Rows, states: &[Aligned; 2]) -> f64 {
    let mut sums = [V::zero(); 2];
    for part in 0..2 {
        let rows = rows[part].as_chunks::<LANES>().0;
        for (row, state) in rows.iter().zip(states[part].as_chunks::<LANES>().0) {
            sums[part] = V::read(row).multiply_add(V::read(state), sums[part]);
        }
    }
    sums[0].plus(sums[1]).sum()
}

for_each_set! {
    /// The components at a position, and their derivatives with respect to it.
    fn states_at(
        place: f64,
        padded: usize,
        components: &[Aligned; 2],
        states: &mut [Aligned; 2],
        rates: &mut [Aligned; 2],
    ) = states_at_body
}

#[inline(always)]
fn states_at_body<V: Vector>(
    place: f64,
    padded: usize,
    components: &[Aligned; 2],
    states: &mut [Aligned; 2],
    rates: &mut [Aligned; 2],
) {
    let place = V::splat(place);
    for part in 0..2 {
        for at in (0..padded).step_by(LANES) {
            let [mut sum, mut slope] = [V::zero(); 2];
            for j in (0..TERMS).rev() {
                slope = slope.multiply_add(place, sum);
                sum = sum.multiply_add(place, V::read(&components[part][j * padded + at..]));
            }
            sum.write(&mut states[part][at..]);
            slope.write(&mut rates[part][at..]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::propagate::varying_speed::powers::value;

    #[test]
    fn waves_of_chirps_are_their_closed_forms() {
        let angle = [0.0, 0.9, -0.03, 0.01, 0.005];
        let [cos, sin] = wave(0.4, &angle);
        for u in [0.0, 0.3, 0.7, 1.0] {
            let exact = (0.4 + value(&angle, u)).sin_cos();
            assert!((value(&cos, u) - exact.1).abs() < 1e-14);
            assert!((value(&sin, u) - exact.0).abs() < 1e-14);
        }
        let parts = [Wave {
            wave: 0,
            cos: 2.0,
            sin: -1.0,
        }];
        let sum = sum_of_waves(&parts, &[[cos, sin]]);
        assert_eq!(sum[3], 2.0 * cos[3] - sin[3]);
    }
}
