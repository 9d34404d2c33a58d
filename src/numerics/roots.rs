//! The earliest moment at which a margin, given as a Legendre series, becomes negative, and
//! all places at which a series changes its sign.
//!
//! Certificates make it safe: where `|a[0]| > Σ_{n≥1}|a[n]|` there is no root; where the
//! derivative's series satisfies the same there is at most one. Anything else is halved,
//! left half first, so that neither of two close roots can be skipped. What stays
//! undecided when the whole sub-series has sunk into round-off is a tangency.

use super::legendre::{self, Transforms};

/// What a search found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Where the margin becomes negative, in \[−1, limit\], if it does.
    pub exit: Option<f64>,
    /// Tangencies met before that.
    pub grazings: u32,
    /// Whether the first certificate settled it.
    pub certified: bool,
    /// Bisections spent.
    pub bisections: u32,
    /// Newton steps spent.
    pub newton_steps: u32,
}

/// Deepest halving: a sub-interval of 2⁻⁵⁰ windows is below the resolution of time itself.
const DEEPEST: u32 = 50;

/// Finds the earliest x in \[−1, `limit`\] at which `margin` passes from non-negative to
/// negative. Values within `noise` of zero are round-off.
///
/// A margin that is negative at the very start (beyond `noise`, or within it and falling)
/// exits at x = −1.
pub fn earliest_exit<const P: usize>(
    transforms: &Transforms<P>,
    margin: &[f64; P],
    limit: f64,
    noise: f64,
) -> Search {
    let mut search = Search {
        exit: None,
        grazings: 0,
        certified: false,
        bisections: 0,
        newton_steps: 0,
    };
    if margin[0] > legendre::variation(margin) + noise {
        search.certified = true;
        return search;
    }
    if legendre::at_start(margin) < -noise {
        search.exit = Some(-1.0);
        return search;
    }
    let mut pending = Stack::new();
    pending.push(*margin, -1.0, 1.0, 0);
    while let Some((series, lo, hi, depth)) = pending.pop() {
        if lo >= limit {
            break;
        }
        let variation = legendre::variation(&series);
        if series[0] > variation + noise {
            continue;
        }
        let slope = legendre::derivative(&series);
        if slope[0].abs() > legendre::variation(&slope) {
            if slope[0] < 0.0 && legendre::at_end(&series) < 0.0 {
                let x = bracketed_root(&series, &slope, &mut search.newton_steps);
                let root = lo + 0.5 * (hi - lo) * (x + 1.0);
                if root <= limit {
                    search.exit = Some(root);
                }
                return search;
            }
            continue;
        }
        if series[0].abs() + variation <= noise || depth == DEEPEST {
            search.grazings += 1;
            continue;
        }
        search.bisections += 1;
        let middle = 0.5 * (lo + hi);
        pending.push(transforms.half(&series, 1), middle, hi, depth + 1);
        pending.push(transforms.half(&series, 0), lo, middle, depth + 1);
    }
    search
}

/// Every place in \[−1, 1\] where a series changes its sign, in ascending order, handed to
/// `found` with whether the series rises there.
///
/// `positive` is the sign before, kept from one series to the next, so that a change on
/// the joint of two is seen once; none at the very start. Values within `noise` of zero have
/// no sign: a touch without a crossing is not a change.
pub fn sign_changes<const P: usize>(
    transforms: &Transforms<P>,
    series: &[f64; P],
    noise: f64,
    positive: &mut Option<bool>,
    mut found: impl FnMut(f64, bool),
) {
    let mut meet = |value: f64, x: f64| {
        if value.abs() > noise {
            let sign = value > 0.0;
            if positive.replace(sign).is_some_and(|before| before != sign) {
                found(x, sign);
            }
        }
    };
    let mut pending = Stack::new();
    pending.push(*series, -1.0, 1.0, 0);
    while let Some((series, lo, hi, depth)) = pending.pop() {
        let variation = legendre::variation(&series);
        if series[0].abs() > variation + noise {
            meet(series[0], lo);
            continue;
        }
        let slope = legendre::derivative(&series);
        if slope[0].abs() > legendre::variation(&slope) {
            let (start, end) = (legendre::at_start(&series), legendre::at_end(&series));
            meet(start, lo);
            let x = if start * end < 0.0 {
                let falling = if slope[0] < 0.0 { 1.0 } else { -1.0 };
                let [series, slope] = [series, slope].map(|s| s.map(|a| falling * a));
                bracketed_root(&series, &slope, &mut 0)
            } else {
                -1.0
            };
            meet(end, lo + 0.5 * (hi - lo) * (x + 1.0));
            continue;
        }
        if series[0].abs() + variation <= noise || depth == DEEPEST {
            continue;
        }
        let middle = 0.5 * (lo + hi);
        pending.push(transforms.half(&series, 1), middle, hi, depth + 1);
        pending.push(transforms.half(&series, 0), lo, middle, depth + 1);
    }
}

/// The root of a falling series with a non-positive value at its end; −1 where it is
/// already negative at its start (by round-off).
fn bracketed_root<const P: usize>(series: &[f64; P], slope: &[f64; P], steps: &mut u32) -> f64 {
    let (start, end) = (legendre::at_start(series), legendre::at_end(series));
    if start <= 0.0 {
        return -1.0;
    }
    let (mut lo, mut hi) = (-1.0, 1.0);
    let mut x = -1.0 + 2.0 * start / (start - end);
    for _ in 0..60 {
        *steps += 1;
        let value = legendre::evaluate(series, x);
        if value > 0.0 {
            lo = x;
        } else {
            hi = x;
        }
        let mut next = x - value / legendre::evaluate(slope, x);
        if !(next >= lo && next <= hi) {
            next = 0.5 * (lo + hi);
        }
        if (next - x).abs() <= f64::EPSILON {
            return next;
        }
        x = next;
    }
    x
}

/// Pending sub-intervals; halving keeps at most one per level.
struct Stack<const P: usize> {
    items: [([f64; P], f64, f64, u32); DEEPEST as usize + 2],
    len: usize,
}

impl<const P: usize> Stack<P> {
    fn new() -> Self {
        Self {
            items: [([0.0; P], 0.0, 0.0, 0); DEEPEST as usize + 2],
            len: 0,
        }
    }

    fn push(&mut self, series: [f64; P], lo: f64, hi: f64, depth: u32) {
        self.items[self.len] = (series, lo, hi, depth);
        self.len += 1;
    }

    fn pop(&mut self) -> Option<([f64; P], f64, f64, u32)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.items[self.len])
    }
}

#[cfg(test)]
mod tests;
