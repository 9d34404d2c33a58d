//! Does a cubic near a margin prove that the margin stays positive, or that it falls through zero exactly once?

use crate::propagate::vectors::Vector;

/// Bound of the error of a cubic that starts at zero, divided by the position in the step, as a multiple of the bound of
/// the error: `max s (1 − s)² / 24 · 384`.
pub const FROM_ZERO: f64 = 64.0 / 27.0;

/// Bounds of the errors of a cubic's differences as multiples of the bound of its error: `√3 / 216 · 384 / 3` for first
/// ones, `384 / 12 / 6` for second ones.
const FIRST_DIFFERENCES: f64 = 1.03;
const SECOND_DIFFERENCES: f64 = 5.34;

/// Newton's steps for the root of a cubic.
const CUBIC_STEPS: u32 = 4;

/// Cubics by their Bernstein coefficients.
pub type Cubic<V> = [V; 4];

/// The Bernstein coefficients of cubics on both parts of their intervals.
#[inline(always)]
pub fn parts<V: Vector>([a, b, c, d]: Cubic<V>, at: V) -> [Cubic<V>; 2] {
    let p = b.minus(a).multiply_add(at, a);
    let q = c.minus(b).multiply_add(at, b);
    let r = d.minus(c).multiply_add(at, c);
    let s = q.minus(p).multiply_add(at, p);
    let t = r.minus(q).multiply_add(at, q);
    let u = t.minus(s).multiply_add(at, s);
    [[a, p, s, u], [u, t, r, d]]
}

/// Lanes in which cubics with errors are certain to be positive. Cubics in the lanes `crossed` start at zero.
/// Their error, divided by the position in the step, is at most `scaled`.
#[inline(always)]
pub fn is_clear<V: Vector>(&[a, b, c, d]: &Cubic<V>, crossed: u32, error: V, scaled: V) -> u32 {
    let error = scaled.chosen(crossed, error);
    let b = b.times(V::splat(3.0)).chosen(crossed, b);
    let c = c.times(V::splat(1.5)).chosen(crossed, c);
    let starts = !a.at_most(error) | crossed;
    starts & !(b.at_most(error) | c.at_most(error) | d.at_most(error))
}

/// Lanes in which margins near cubics fall through zero exactly once, and end negative.
#[inline(always)]
pub fn falls<V: Vector>(&[a, b, c, d]: &Cubic<V>, crossed: u32, error: V) -> u32 {
    let (zero, flat) = (V::zero(), error.times(V::splat(FIRST_DIFFERENCES)));
    let straight = error.times(V::splat(SECOND_DIFFERENCES));
    let slopes = [b.minus(a), c.minus(b), d.minus(c)];
    let bends = [slopes[1].minus(slopes[0]), slopes[2].minus(slopes[1])];
    let steep = zero.minus(flat);
    let falling = !(steep.at_most(slopes[0]) | steep.at_most(slopes[1]) | steep.at_most(slopes[2]));
    let bent = zero.minus(straight);
    let rises = !slopes[0].at_most(flat) | !crossed;
    let concave = !(bent.at_most(bends[0]) | bent.at_most(bends[1])) & rises;
    let convex = !(bends[0].at_most(straight) | bends[1].at_most(straight));
    let from_above = (zero.at_most(a) & (falling | convex) & !crossed) | concave;
    let ends_below = !zero.minus(error).at_most(d);
    (zero.at_most(a) | crossed) & from_above & ends_below
}

/// Roots of cubics with a negative end, as parts of their intervals, to a few percent.
#[inline(always)]
pub fn guess<V: Vector>(&[a, b, c, d]: &Cubic<V>, crossed: u32) -> V {
    let (zero, one, three) = (V::zero(), V::splat(1.0), V::splat(3.0));
    // The power basis.
    let rate = b.minus(a).times(three);
    let bend = c.minus(b).minus(b.minus(a)).times(three);
    let last = d.minus(a).minus(c.minus(b).times(three));
    let chord = a.divided_by(a.minus(d));
    let parabola = rate.divided_by(rate.minus(d));
    let mut x = parabola.chosen(crossed, chord);
    for _ in 0..CUBIC_STEPS {
        let slope = last
            .times(three)
            .multiply_add(x, bend.plus(bend))
            .multiply_add(x, rate);
        let value = last
            .multiply_add(x, bend)
            .multiply_add(x, rate)
            .multiply_add(x, a);
        x = x.minus(value.divided_by(slope)).larger(zero).smaller(one);
    }
    x
}
