//! Cuts a stretch of the mesh cycle into pieces on which polynomials follow the law.
//!
//! A relieved pair takes up load where the approach of the gears reaches its gap, at a phase that
//! depends on load and misalignment; a wedge of contact reaches the end of the face at another.
//! Stiffness steps or bends there, and a margin of the load sharing changes its sign
//! ([`LoadSharing::bear_with_margins`](crate::gear::LoadSharing::bear_with_margins)): between two samples of a piece, or
//! where the margin's own polynomial says so though no sample lies there. Such a phase is bisected
//! to round-off and ends a piece. A piece without one is halved until its polynomials are within the
//! tolerance of the law at places that took no part in the fit. No other piece leaves this file.
//!
//! Of helical gears pairs come into contact little by little all along the face, with many small bends:
//! their pieces are only halved, until they are within what the division of the face is worth, and
//! no further than a shortest length, on which polynomials of low degree are as good as others. Where slices of
//! a spur face support each other a pair may touch inside the face first, its stiffness beginning with a
//! root: the shorter a piece, the less it is held to.

use super::breaks::SAME;
use super::law::{Column, MeshLaw, Quantity};
use super::{MeshTableError, NODES};
use crate::gear::FlankLaw;
use crate::numerics::legendre::{evaluate, transforms8};
use crate::numerics::roots::sign_changes;

/// Most pieces of a stretch: what a few pairs need on a face of 64 slices with a gap each.
const MOST: usize = 1024;

/// Places in the mesh phase this close are one.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

/// What rounding leaves of a margin's polynomial, relative to its largest value.
const NOISE: f64 = 1e-12;

/// A window of propagation that starts inside a piece may run on behind its end by less than the
/// piece is long, and is solved as a whole: the stiffness carried on to these places, the piece
/// ending at 1, has to stay one.
pub(in crate::gear) const BEHIND: [f64; 2] = [2.0, 3.0];

/// Smallest and largest stiffness there, in parts of that at the end.
pub(in crate::gear) const CARRIED_ON: [f64; 2] = [0.1, 10.0];

/// Largest error of the pieces of helical gears, where no larger one is asked for: about what spans of
/// a 64th of the face are worth.
const HELICAL: f64 = 1e-5;

/// Pieces of helical gears shorter than twice this, in cycles, are not halved.
const SHORTEST: f64 = 1.0 / 256.0;

/// Their largest error: a single bend inside of them, or a border of contact that reaches its end.
const SHORT: f64 = 1e-2;

/// Largest error, times the length of the piece in cycles, of faces whose slices support each other and bear
/// unevenly, where no larger one is asked for and up to [`SHORT`]: a pair may touch inside the face first, and
/// stiffness then begins with a root of the phase, on a piece however short.
const COUPLED: f64 = 1e-9;

/// Terms of the polynomials of short pieces of helical gears.
const SHORT_TERMS: usize = 3;

/// A piece that is within the tolerance of its law.
pub(super) struct Piece {
    /// Mesh phase at its end.
    pub end: f64,
    /// The law at its nodes.
    pub nodes: Vec<Column>,
}

/// What is to be done about a piece.
enum Verdict {
    Accepted(Vec<Column>),
    /// Cut it at this phase, where the law has a kink.
    Kink(f64),
    /// Halve it: a polynomial is too far from the law.
    Misfit(Misfit),
}

/// How far a polynomial is from its law.
#[derive(Debug, Clone, Copy)]
struct Misfit {
    quantity: &'static str,
    error: f64,
    phase: f64,
}

/// The pieces of a stretch of the mesh cycle, in order.
pub(super) fn pieces<L: FlankLaw>(
    law: &MeshLaw<'_, L>,
    stretch: [f64; 2],
) -> Result<Vec<Piece>, MeshTableError> {
    let mut pieces = Vec::new();
    let mut left = vec![stretch];
    while let Some([from, to]) = left.pop() {
        let middle = 0.5 * (from + to);
        let (at, misfit) = match examine(law, [from, to])? {
            Verdict::Accepted(nodes) => {
                pieces.push(Piece { end: to, nodes });
                continue;
            }
            Verdict::Kink(at) => (at, None),
            Verdict::Misfit(misfit) => (middle, Some(misfit)),
        };
        if at - from < SAME || to - at < SAME || pieces.len() + left.len() + 2 > MOST {
            let found = misfit.unwrap_or(Misfit {
                quantity: "stiffness",
                error: f64::INFINITY,
                phase: at,
            });
            return Err(MeshTableError::Unresolved {
                quantity: found.quantity,
                phase: found.phase,
                error: found.error,
                tolerance: tolerance(law, [from, to]),
            });
        }
        left.extend([[at, to], [from, at]]);
    }
    Ok(pieces)
}

/// Whether a piece may stay as it is.
fn examine<L: FlankLaw>(
    law: &MeshLaw<'_, L>,
    [from, to]: [f64; 2],
) -> Result<Verdict, MeshTableError> {
    let nodes = transforms8().nodes();
    let phase = |x: f64| 0.5 * ((to - from) * x + (to + from));
    // The ends are within round-off of a kink, and looked at just inside.
    let inset = SAME.min(0.125 * (to - from));
    let (first, last) = (from + inset, to - inset);
    let between = nodes
        .windows(2)
        .map(|pair| phase(0.5 * (pair[0] + pair[1])));
    let places = [first].into_iter().chain(between).chain([last]);
    let checks: Vec<Column> = places.map(|at| law.column(at)).collect::<Result<_, _>>()?;
    let mut columns: Vec<Column> = (nodes.iter())
        .map(|&x| law.column(phase(x)))
        .collect::<Result<_, _>>()?;
    if is_short(law, [from, to]) {
        smooth(&mut columns);
    }
    let mut seen: Vec<&Column> = checks.iter().chain(&columns).collect();
    seen.sort_by(|a, b| a.phase.total_cmp(&b.phase));
    for (number, after) in seen.iter().enumerate() {
        if let Some(at) = kink(law, &seen[..number], after)? {
            return Ok(Verdict::Kink(at));
        }
    }
    for x in unseen(&columns) {
        let found = law.column(phase(x).clamp(first, last))?;
        let before = seen.partition_point(|column| column.phase < found.phase);
        if let Some(at) = kink(law, &seen[..before], &found)? {
            return Ok(Verdict::Kink(at));
        }
    }
    let misfit = worst(law, &columns, &checks, [from, to]);
    Ok(match misfit.error <= tolerance(law, [from, to]) {
        true => Verdict::Accepted(columns),
        false => Verdict::Misfit(misfit),
    })
}

/// Whether a piece is one of helical gears that is not to be halved.
fn is_short<L: FlankLaw>(law: &MeshLaw<'_, L>, [from, to]: [f64; 2]) -> bool {
    law.flanks.helix() != 0.0 && to - from < 2.0 * SHORTEST
}

/// Largest error of a piece.
fn tolerance<L: FlankLaw>(law: &MeshLaw<'_, L>, piece: [f64; 2]) -> f64 {
    let asked = law.inputs.tolerance;
    let [from, to] = piece;
    match (law.flanks.helix() == 0.0, law.is_coupled()) {
        (true, false) => asked,
        (true, true) => asked.max((COUPLED / (to - from)).min(SHORT)),
        (false, _) => asked.max(if is_short(law, piece) { SHORT } else { HELICAL }),
    }
}

/// Replaces the values at the nodes by those of polynomials of low degree: bends between the nodes
/// would swing high ones up behind the piece.
fn smooth(columns: &mut [Column]) {
    let transforms = transforms8();
    for case in 0..columns[0].cells.len() {
        for quantity in 0..columns[0].cells[case].values_mut().len() {
            let values: [f64; NODES] =
                std::array::from_fn(|node| *columns[node].cells[case].values_mut()[quantity]);
            let series = transforms.interpolate(&values);
            for (column, &x) in columns.iter_mut().zip(transforms.nodes()) {
                *column.cells[case].values_mut()[quantity] = evaluate(&series[..SHORT_TERMS], x);
            }
        }
    }
}

/// Where the law changes its formula between the last of some columns that has another than the one `after` them, and
/// that one; none where none has.
fn kink<L: FlankLaw>(
    law: &MeshLaw<'_, L>,
    columns: &[&Column],
    after: &Column,
) -> Result<Option<f64>, MeshTableError> {
    let mut kinks = (columns.iter().rev()).map(|before| (before, before.kinks_before(after)));
    let Some((before, kinks)) = kinks.find(|(_, kinks)| !kinks.is_empty()) else {
        return Ok(None);
    };
    let signs = |column: &Column| -> Vec<bool> {
        let margins: Vec<f64> = column.margins().collect();
        kinks.iter().map(|&kink| margins[kink] >= 0.0).collect()
    };
    let (mut low, mut high) = (before.phase, after.phase);
    while high - low > ROUND_OFF {
        let middle = 0.5 * (low + high);
        match signs(&law.column(middle)?) == signs(before) {
            true => low = middle,
            false => high = middle,
        }
    }
    Ok(Some(0.5 * (low + high)))
}

/// Places of a piece where a margin has another sign than at the nodes by the polynomial through
/// its values there: one in each part that is cut off.
fn unseen(columns: &[Column]) -> Vec<f64> {
    let mut places = Vec::new();
    for (case, cell) in columns[0].cells.iter().enumerate() {
        for margin in 0..cell.margins.len() {
            let values: [f64; NODES] =
                std::array::from_fn(|node| columns[node].cells[case].margins[margin]);
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

/// The largest distance of the polynomials of a piece from the law at the checks.
fn worst<L: FlankLaw>(
    law: &MeshLaw<'_, L>,
    columns: &[Column],
    checks: &[Column],
    [from, to]: [f64; 2],
) -> Misfit {
    let mut worst = Misfit {
        quantity: "stiffness",
        error: 0.0,
        phase: from,
    };
    // An error that is no number is the largest of all.
    let mut meet = |quantity, error: f64, phase| {
        if error > worst.error || error.is_nan() {
            worst = Misfit {
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
                meet(
                    name,
                    (evaluate(series, x) - value).abs() / scale,
                    check.phase,
                );
            }
        }
        let end = evaluate(&series[0], 1.0);
        let [least, most] = CARRIED_ON.map(|part| part * end);
        for x in BEHIND {
            if !(least..=most).contains(&evaluate(&series[0], x)) {
                meet("stiffness behind its piece", f64::INFINITY, to);
            }
        }
    }
    worst
}
