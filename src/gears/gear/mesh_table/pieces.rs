//! Cuts a stretch of the mesh cycle into pieces on which polynomials follow the law.
//!
//! A relieved pair takes up load where the approach of the gears reaches its gap, at a phase that depends on
//! load and misalignment. A wedge of contact reaches the end of the face at another phase. At such phases
//! stiffness steps or bends, and a margin of the load sharing changes its sign
//! ([`LoadSharing::distribute_with_margins`](crate::gear::LoadSharing::distribute_with_margins)). Two samples
//! of the margin then have different signs, or its polynomial changes sign between two samples.
//!
//! A piece is accepted if its polynomials are within the tolerance of the law at phases that are not nodes,
//! even if a margin changes its sign inside. Other pieces are cut where the sign changes, found to round-off,
//! or in halves. A piece always ends where a pair takes up load. If slices of a face are coupled, their
//! borders bend the law only a little, and all other pieces are halved. This module returns accepted pieces
//! only.
//!
//! Pairs of helical gears come into contact gradually all along the face, with many small bends. Their pieces are
//! only halved, until their error is that of the division of the face. Short pieces have polynomials of low degree,
//! which are as good as others there, and a larger tolerance. If slices of a spur face are coupled, a pair may first
//! touch inside the face. The stiffness of the pair then begins as a square root: the shorter a piece, the larger its
//! tolerance. If the middle of the flanks is almost parallel, such a pair takes up or loses its stiffness within 1e-5
//! cycles or less, nearly in a step. No polynomial of high degree that ends at the root stays physical behind its
//! piece, however short. A piece too short to be cut therefore has means.

use super::breaks::SAME;
use super::law::{Column, PhaseLaw, Quantity};
use super::{MeshTableError, NODES};
use crate::gear::FlankLaw;
use crate::numerics::legendre::{evaluate, transforms8};
use crate::numerics::roots::sign_changes;

/// Largest number of pieces of a stretch: enough for a few pairs on a face of 64 slices with different gaps.
const MOST_PIECES: usize = 1024;

/// Mesh phases closer than this coincide.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

/// Rounding error of a margin's polynomial, relative to its largest value.
const NOISE: f64 = 1e-12;

/// Positions at which the stiffness of a piece, extrapolated from −1 … 1, must stay physical. A window of propagation
/// that starts inside a piece may extend beyond the end of the piece by less than the length of the piece, and is
/// solved as a whole.
pub(in crate::gear) const EXTRAPOLATED_AT: [f64; 2] = [2.0, 3.0];

/// Smallest and largest stiffness at [`EXTRAPOLATED_AT`], relative to that at the end of the piece.
pub(in crate::gear) const EXTRAPOLATION_LIMITS: [f64; 2] = [0.1, 10.0];

/// Largest error of the pieces of helical gears, unless a larger one is requested: about the error of spans of
/// a 64th of the face.
const HELICAL: f64 = 1e-5;

/// Pieces of helical gears shorter than twice this, in cycles, have few terms and the tolerance [`SHORT`].
const SHORTEST: f64 = 1.0 / 256.0;

/// Largest error of short pieces of helical gears: they may contain a bend, or a border of contact that reaches an
/// end of the face.
const SHORT: f64 = 1e-2;

/// Terms of the polynomials of short pieces of helical gears.
const SHORT_TERMS: usize = 3;

/// Terms of the polynomials of pieces of a coupled spur face that are too short to be cut: the mean.
const UNCUT_TERMS: usize = 1;

/// A piece that is within the tolerance of its law.
pub(super) struct Piece {
    /// Mesh phase at its end.
    pub end: f64,
    /// The law at its nodes.
    pub nodes: Vec<Column>,
}

/// Verdict on a piece.
enum Verdict {
    Accepted(Vec<Column>),
    /// Cut it at this phase, where the law has a kink.
    Kink(f64),
    /// Halve it: a polynomial is too far from the law.
    Inaccurate(FitError),
}

/// Difference between a polynomial and the law.
#[derive(Debug, Clone, Copy)]
struct FitError {
    quantity: &'static str,
    error: f64,
    phase: f64,
}

/// The pieces of a stretch of the mesh cycle, in order.
pub(super) fn pieces<L: FlankLaw>(
    law: &PhaseLaw<'_, L>,
    stretch: [f64; 2],
) -> Result<Vec<Piece>, MeshTableError> {
    let mut pieces = Vec::new();
    let mut left = vec![stretch];
    while let Some([from, to]) = left.pop() {
        let middle = 0.5 * (from + to);
        let (at, fit_error) = match check_piece(law, [from, to])? {
            Verdict::Accepted(nodes) => {
                pieces.push(Piece { end: to, nodes });
                continue;
            }
            Verdict::Kink(at) => (at, None),
            Verdict::Inaccurate(fit_error) => (middle, Some(fit_error)),
        };
        if at - from < SAME || to - at < SAME || pieces.len() + left.len() + 2 > MOST_PIECES {
            let fit_error = fit_error.unwrap_or(FitError {
                quantity: "stiffness",
                error: f64::INFINITY,
                phase: at,
            });
            return Err(MeshTableError::Unresolved {
                quantity: fit_error.quantity,
                phase: fit_error.phase,
                error: fit_error.error,
                tolerance: tolerance(law, [from, to]),
            });
        }
        left.extend([[at, to], [from, at]]);
    }
    Ok(pieces)
}

/// Decides whether a piece is accepted.
fn check_piece<L: FlankLaw>(
    law: &PhaseLaw<'_, L>,
    [from, to]: [f64; 2],
) -> Result<Verdict, MeshTableError> {
    let nodes = transforms8().nodes();
    let phase = |x: f64| 0.5 * ((to - from) * x + (to + from));
    // The ends are within round-off of a kink, so check just inside.
    let inset = SAME.min(0.125 * (to - from));
    let (first, last) = (from + inset, to - inset);
    let between = nodes
        .windows(2)
        .map(|pair| phase(0.5 * (pair[0] + pair[1])));
    let places = [first].into_iter().chain(between).chain([last]);
    let mut columns = law.columns(nodes.iter().map(|&x| phase(x)))?;
    if is_short(law, [from, to]) {
        smooth(&mut columns, SHORT_TERMS);
    } else if is_uncut(law, [from, to]) {
        smooth(&mut columns, UNCUT_TERMS);
    }
    if law.flanks.helix() != 0.0 {
        return check_helical(law, columns, places, [from, to]);
    }
    let mut checks = law.columns(places)?;
    for x in hidden_sign_changes(&columns) {
        checks.push(law.column(phase(x).clamp(first, last), None)?);
    }
    let fit_error = largest_fit_error(law, &columns, &checks, [from, to]);
    let is_accurate = fit_error.error <= tolerance(law, [from, to]);
    let mut samples: Vec<&Column> = checks.iter().chain(&columns).collect();
    samples.sort_by(|a, b| a.phase.total_cmp(&b.phase));
    let takes_hold = (samples.windows(2)).find(|two| !two[0].loads_as(two[1]));
    // Two kinks of a near-step may be closer than pieces can be cut.
    let can_cut = |at: &f64| at - from >= SAME && to - at >= SAME;
    let at = match takes_hold {
        Some(two) => kink(law, &two[..1], two[1])?.filter(can_cut),
        None => None,
    };
    let at = match at {
        // Borders of slices bend the law of a coupled face only a little.
        None if !is_accurate && !law.is_coupled() => first_kink(law, &samples)?.filter(can_cut),
        at => at,
    };
    Ok(match at {
        Some(at) => Verdict::Kink(at),
        None if is_accurate => Verdict::Accepted(columns),
        None => Verdict::Inaccurate(fit_error),
    })
}

/// Decides whether a piece of helical gears is accepted. It has no known kinks, so the first failed check decides.
fn check_helical<L: FlankLaw>(
    law: &PhaseLaw<'_, L>,
    columns: Vec<Column>,
    places: impl Iterator<Item = f64>,
    piece: [f64; 2],
) -> Result<Verdict, MeshTableError> {
    for place in places {
        let check = law.column(place, None)?;
        let fit_error = largest_fit_error(law, &columns, &[check], piece);
        if fit_error.error > tolerance(law, piece) {
            return Ok(Verdict::Inaccurate(fit_error));
        }
    }
    Ok(Verdict::Accepted(columns))
}

/// The first phase between columns at which the law changes its formula; `None` if all have the same formula.
fn first_kink<L: FlankLaw>(
    law: &PhaseLaw<'_, L>,
    samples: &[&Column],
) -> Result<Option<f64>, MeshTableError> {
    for (number, after) in samples.iter().enumerate() {
        if let Some(at) = kink(law, &samples[..number], after)? {
            return Ok(Some(at));
        }
    }
    Ok(None)
}

/// Whether a piece belongs to helical gears and is short, see [`SHORTEST`].
fn is_short<L: FlankLaw>(law: &PhaseLaw<'_, L>, [from, to]: [f64; 2]) -> bool {
    law.flanks.helix() != 0.0 && to - from < 2.0 * SHORTEST
}

/// Whether a piece belongs to a coupled face of spur gears and is too short to be cut.
fn is_uncut<L: FlankLaw>(law: &PhaseLaw<'_, L>, [from, to]: [f64; 2]) -> bool {
    law.flanks.helix() == 0.0 && law.is_coupled() && to - from < 2.0 * SAME
}

/// Largest accepted error of a piece.
fn tolerance<L: FlankLaw>(law: &PhaseLaw<'_, L>, piece: [f64; 2]) -> f64 {
    let requested = law.inputs.tolerance;
    let [from, to] = piece;
    match (law.flanks.helix() == 0.0, law.is_coupled()) {
        (true, false) => requested,
        // A pair may touch inside the face first. Stiffness then begins as a square root of the phase, on a
        // piece of any length. The error times the length is the error of means over the cycle.
        (true, true) if is_uncut(law, piece) => requested / (to - from),
        (true, true) => requested.max((requested / (to - from)).min(SHORT)),
        (false, _) => requested.max(if is_short(law, piece) { SHORT } else { HELICAL }),
    }
}

/// Replaces the values at the nodes by those of polynomials of low degree: with bends between the nodes
/// polynomials of high degree would oscillate beyond the piece.
fn smooth(columns: &mut [Column], terms: usize) {
    let transforms = transforms8();
    for case in 0..columns[0].cells.len() {
        for quantity in 0..columns[0].cells[case].values_mut().len() {
            let values: [f64; NODES] =
                std::array::from_fn(|node| *columns[node].cells[case].values_mut()[quantity]);
            let series = transforms.interpolate(&values);
            for (column, &x) in columns.iter_mut().zip(transforms.nodes()) {
                *column.cells[case].values_mut()[quantity] = evaluate(&series[..terms], x);
            }
        }
    }
}

/// The phase at which the law changes its formula between `after` and the last of `columns` whose formula differs from
/// that of `after`. `None` if no column differs.
fn kink<L: FlankLaw>(
    law: &PhaseLaw<'_, L>,
    columns: &[&Column],
    after: &Column,
) -> Result<Option<f64>, MeshTableError> {
    let mut kinks = (columns.iter().rev()).map(|before| (before, before.kinks_before(after)));
    let Some((before, kinks)) = kinks.find(|(_, kinks)| !kinks.is_empty()) else {
        return Ok(None);
    };
    let margins_of = |column: &Column| -> Vec<f64> {
        let margins: Vec<f64> = column.margins().collect();
        kinks.iter().map(|&kink| margins[kink]).collect()
    };
    let positive = |margins: &[f64]| -> Vec<bool> { margins.iter().map(|m| *m >= 0.0).collect() };
    let (mut low, mut high) = (before.phase, after.phase);
    let [mut at_low, mut at_high] = [before, &after].map(|column| margins_of(column));
    let sign_at_low = positive(&at_low);
    let (width, mut round) = (high - low, 0);
    while high - low > ROUND_OFF {
        // Zero of the first of these margins, by linear interpolation between the ends.
        let crossings = at_low
            .iter()
            .zip(&at_high)
            .filter(|(a, b)| (**a >= 0.0) != (**b >= 0.0));
        let part = crossings.map(|(a, b)| a / (a - b)).fold(1.0, f64::min);
        let at = between([low, high], part, (width, round));
        let margins = margins_of(&law.column(at, Some(*before))?);
        if positive(&margins) == sign_at_low {
            (low, at_low) = (at, margins)
        } else {
            (high, at_high) = (at, margins)
        }
        round += 1;
    }
    Ok(Some(0.5 * (low + high)))
}

/// The next phase of a search for a sign change between two phases. Linear interpolation gives the zero at `part` of
/// their distance. This phase is moved a little towards the middle, so that the other end also advances. The distance
/// from the middle is limited such that the search takes at most one step more than bisection (Oliveira & Takahashi
/// 2020). `width` is the initial interval, `round` the number of steps done.
fn between([low, high]: [f64; 2], part: f64, (width, round): (f64, i32)) -> f64 {
    let (length, middle) = (high - low, 0.5 * (low + high));
    let line = low + part * length;
    let shift = (0.2 * length * length / width).max(0.5 * ROUND_OFF);
    let nearer = if shift < (middle - line).abs() {
        line + shift.copysign(middle - line)
    } else {
        middle
    };
    let room = (width * 0.5_f64.powi(round) - 0.5 * length).max(0.0);
    nearer.clamp(middle - room, middle + room)
}

/// Positions in a piece at which a margin may have changed its sign between the nodes. The margin has one
/// sign at all nodes, but its polynomial has the opposite sign in parts between them. The result has one
/// position per such part.
fn hidden_sign_changes(columns: &[Column]) -> Vec<f64> {
    let mut places = Vec::new();
    for (case, cell) in columns[0].cells.iter().enumerate() {
        for margin in 0..cell.margins.len() {
            let values: [f64; NODES] =
                std::array::from_fn(|node| columns[node].cells[case].margins[margin]);
            if values.iter().any(|v| (*v >= 0.0) != (values[0] >= 0.0)) {
                continue;
            }
            let noise = NOISE * values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            let series = transforms8().interpolate(&values);
            let mut sign = Some(values[0] >= 0.0);
            let mut changes = Vec::new();
            sign_changes(transforms8(), &series, noise, &mut sign, |x, _| {
                changes.push(x)
            });
            let cut_off = changes
                .chunks(2)
                .map(|ends| [ends[0], *ends.get(1).unwrap_or(&1.0)]);
            places.extend(cut_off.map(|[from, to]| 0.5 * (from + to)));
        }
    }
    places
}

/// The largest relative distance of the polynomials of a piece from the law at the checks; infinite if the extrapolated
/// stiffness is beyond [`EXTRAPOLATION_LIMITS`].
fn largest_fit_error<L: FlankLaw>(
    law: &PhaseLaw<'_, L>,
    columns: &[Column],
    checks: &[Column],
    [from, to]: [f64; 2],
) -> FitError {
    let mut worst = FitError {
        quantity: "stiffness",
        error: 0.0,
        phase: from,
    };
    // NaN counts as the largest error.
    let mut raise = |quantity, error: f64, phase| {
        if error > worst.error || error.is_nan() {
            worst = FitError {
                quantity,
                error: if error.is_nan() { f64::INFINITY } else { error },
                phase,
            };
        }
    };
    for case in 0..columns[0].cells.len() {
        let at_nodes: Vec<_> = (columns.iter())
            .map(|column| law.quantities(&column.cells[case]))
            .collect();
        let series: Vec<[f64; NODES]> = (0..at_nodes[0].len())
            .map(|q| {
                transforms8().interpolate(&std::array::from_fn(|node| at_nodes[node][q].value))
            })
            .collect();
        for check in checks {
            let x = (2.0 * check.phase - (from + to)) / (to - from);
            let exact = law.quantities(&check.cells[case]);
            for (Quantity { name, value, scale }, series) in exact.into_iter().zip(&series) {
                raise(
                    name,
                    (evaluate(series, x) - value).abs() / scale,
                    check.phase,
                );
            }
        }
        let end = evaluate(&series[0], 1.0);
        let [least, most] = EXTRAPOLATION_LIMITS.map(|part| part * end);
        for x in EXTRAPOLATED_AT {
            if !(least..=most).contains(&evaluate(&series[0], x)) {
                raise("stiffness behind its piece", f64::INFINITY, to);
            }
        }
    }
    worst
}

#[cfg(test)]
#[path = "pieces_tests.rs"]
mod tests;
