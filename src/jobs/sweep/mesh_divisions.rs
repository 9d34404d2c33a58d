//! How does a computed mesh become divisions of the model's mesh cycle?

use crate::gear::{
    CycleDivision, JoinedPieces, JoiningAccuracy, MeshSprings, MeshTableCycle, MeshTablePiece,
    MeshTableSpec, NODES,
};
use crate::model::{Division, FlankError, STIFFNESS_TERMS, Stiffness};
use crate::numerics::legendre::transforms8;

/// A break of a table does not divide a segment if it is closer than this to an end of equal segments \[cycles\].
const SAME_END: f64 = 1e-9;

/// Largest relative error of the stiffness of a joined piece, times the length of a piece.
const STIFFNESS_TOLERANCE: f64 = 1e-5;

/// Largest relative deviation of load centroid and friction from the means of a piece, times its length.
const TURNING_TOLERANCE: f64 = 2.5e-4;

/// Joined pieces up to this length \[cycles\] use means, whatever the deviation.
const SHORTEST_TURNING_PIECE: f64 = 1.0 / 24.0;

// A piece of a table becomes the stiffness of a segment term by term.
const _: () = assert!(NODES == STIFFNESS_TERMS);

/// The divisions of every spring of a mesh. The first spring touches first: it is the pair with the smallest gap, at
/// the end of the face that a misalignment brings closer. Every slice has `most` springs, some of which may be absent.
pub(super) fn spring_divisions(
    springs: &MeshSprings,
    misalignment: f64,
    stiffness: f64,
    most: usize,
) -> Vec<Vec<Division>> {
    let slices = springs.centres.len();
    let order: Vec<usize> = if misalignment < 0.0 {
        (0..slices).rev().collect()
    } else {
        (0..slices).collect()
    };
    let divisions_of_pair = |slice: usize, number: usize| -> Vec<Division> {
        (springs.stretches.iter())
            .map(|stretch| Division {
                load_centre: springs.centres[slice],
                ..match stretch.springs[slice].get(number) {
                    None => Division::absent(stretch.end, stiffness),
                    Some(spring) => Division {
                        stiffness: Stiffness::series(spring.stiffness),
                        error: FlankError::series(spring.gap),
                        friction: spring.friction,
                        ..Division::level(stretch.end, stiffness)
                    },
                }
            })
            .collect()
    };
    (0..most)
        .flat_map(|number| order.iter().map(move |&slice| (slice, number)))
        .map(|(slice, number)| divisions_of_pair(slice, number))
        .collect()
}

/// Means of the tangent stiffness over equal segments. With `with_error`, segments have the exact error of loaded
/// flanks and are divided at its kinks and steps.
pub(super) fn segments(cycle: &MeshTableCycle, count: u32, with_error: bool) -> Vec<Division> {
    let pieces = cycle.pieces();
    (segment_ends(cycle, count, with_error).windows(2))
        .map(|ends| {
            let [start, end] = [ends[0], ends[1]];
            let means = cycle.means([start, end]);
            Division {
                end,
                stiffness: Stiffness::constant(means.stiffness),
                error: if with_error {
                    FlankError::series(part(&pieces, [start, end], |p| p.tangent_error))
                } else {
                    FlankError::NONE
                },
                load_centre: means.centre,
                friction: [means.friction, means.friction_lever],
            }
        })
        .collect()
}

/// The joined pieces for integrating a mesh, unless it uses means of the tangent stiffness over segments. Pieces up to
/// the length of a segment use means of friction and load centroid, whatever the deviation.
pub(super) fn joined_pieces(
    friction: f64,
    spec: &MeshTableSpec,
    cycle: &MeshTableCycle,
) -> JoinedPieces {
    cycle.joined_pieces(JoiningAccuracy {
        stiffness: STIFFNESS_TOLERANCE,
        turning: TURNING_TOLERANCE,
        shortest: match spec.division {
            CycleDivision::Segments(count) => 1.0 / f64::from(count),
            CycleDivision::Continuous | CycleDivision::Pairs { .. } => SHORTEST_TURNING_PIECE,
        },
        friction,
        base_radius: spec.gears.base_radii()[0],
        face_width: spec.gears.face_width,
    })
}

/// The divisions of joined pieces; with the error of loaded flanks if `with_error`.
pub(super) fn divisions_of_pieces(joined_pieces: &JoinedPieces, with_error: bool) -> Vec<Division> {
    let error = |flank_error| if with_error { flank_error } else { FlankError::NONE };
    (joined_pieces.pieces.iter().map(MeshTablePiece::division))
        .map(|division| Division {
            error: error(division.error),
            ..division
        })
        .collect()
}

/// Ends of equal segments, 0 first; if `cut`, also the ends of the cycle's pieces.
fn segment_ends(cycle: &MeshTableCycle, count: u32, cut: bool) -> Vec<f64> {
    let mut ends: Vec<f64> = (0..=count)
        .map(|number| f64::from(number) / f64::from(count))
        .collect();
    if cut {
        let equal = ends.clone();
        let is_distinct = |end: &&f64| equal.iter().all(|other| (*end - other).abs() > SAME_END);
        ends.extend(cycle.breaks.iter().filter(is_distinct));
        ends.sort_by(f64::total_cmp);
    }
    ends
}

/// The series of a piece, restricted to the interval between two phases inside it.
fn part(
    pieces: &[MeshTablePiece],
    [start, end]: [f64; 2],
    series_of: impl Fn(&MeshTablePiece) -> [f64; NODES],
) -> [f64; NODES] {
    let middle = 0.5 * (start + end);
    let after = pieces.partition_point(|piece| piece.end <= middle);
    let piece = &pieces[after.min(pieces.len() - 1)];
    let place = |phase: f64| (2.0 * phase - piece.start - piece.end) / (piece.end - piece.start);
    transforms8().restrict(&series_of(piece), place(start), place(end))
}
