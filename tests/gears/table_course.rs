//! The stiffness of a run over the mesh cycle, in joined pieces, compared with its table: there are few
//! pieces, with the reported accuracy.

#![allow(clippy::unwrap_used)]

use crate::fixtures;
use gearatlas::gear::{
    Contact, Flanks, JoinedPieces, JoiningAccuracy, MeshTable, MeshTableCycle, MeshTableInputs,
    MeshTablePiece, Modification, ToothForm,
};
use gearatlas::numerics::legendre::evaluate;

/// Largest length of a window \[cycles\].
const LONGEST_WINDOW: f64 = 0.25;

/// A cycle of the 20/30 pair under a torque \[N m\], with crowning of the pinion's lead \[m\].
fn cycle(crowning: f64, misalignment: f64) -> (MeshTableCycle, JoiningAccuracy) {
    let crowned = Modification {
        crowning,
        ..Modification::default()
    };
    let form = ToothForm {
        bore: [Some(48e-3), Some(76e-3)],
        lead: [crowned, Modification::default()],
        ..ToothForm::default()
    };
    let pair = fixtures::pair([20, 30], form);
    let inputs = MeshTableInputs {
        misalignment: vec![misalignment],
        longest_piece: 0.25,
        tolerance: 1e-6,
        slices: 16,
        contact: Contact::Secant,
        ..MeshTableInputs::of_gears(&pair)
    };
    let table = MeshTable::build(&Flanks::new(&pair).unwrap(), &inputs, &|_, _| ()).unwrap();
    let accuracy = JoiningAccuracy {
        stiffness: 1e-5,
        turning: 2.5e-4,
        shortest: 1.0 / 96.0,
        friction: 0.05,
        base_radius: inputs.base_radius,
        face_width: inputs.face_width,
    };
    (table.cycle(0, 0), accuracy)
}

/// Largest error of stiffness and largest deviation from the means, each times the length of its piece, at positions
/// that the fit of the pieces did not use.
fn off(cycle: &MeshTableCycle, joined_pieces: &JoinedPieces, of: &JoiningAccuracy) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for step in 0..5003 {
        let phase = (f64::from(step) + 0.37) / 5003.0;
        let piece = &joined_pieces.pieces[joined_pieces
            .pieces
            .partition_point(|piece| piece.end <= phase)];
        let length = piece.end - piece.start;
        let x = (2.0 * phase - piece.start - piece.end) / length;
        let k = cycle.value(&cycle.stiffness, phase);
        let stiffness = (evaluate(&piece.stiffness, x) / k - 1.0).abs();
        worst[0] = worst[0].max(stiffness * length);
        let turning = [
            (cycle.value(&cycle.centre, phase) - piece.centre) / of.face_width,
            of.friction * (cycle.value(&cycle.friction, phase) - piece.friction),
            of.friction * (cycle.value(&cycle.friction_lever, phase) - piece.friction_lever)
                / of.base_radius,
        ];
        for departure in turning {
            worst[1] = worst[1].max(departure.abs() * length);
        }
    }
    worst
}

/// Joined pieces report their error and keep the requested accuracy, and there are fewer than in the table.
#[test]
fn joined_pieces_are_as_far_off_as_they_say() {
    for (crowning, misalignment) in [(0.0, 0.0), (5e-6, 2e-4)] {
        let (cycle, accuracy) = cycle(crowning, misalignment);
        let joined_pieces = cycle.joined_pieces(accuracy);
        let found = off(&cycle, &joined_pieces, &accuracy);
        let reported_errors = [joined_pieces.stiffness_error, joined_pieces.turning_error];
        for (found, reported_errors) in found.into_iter().zip(reported_errors) {
            assert!(
                found <= 1.2 * reported_errors + 1e-12,
                "{found:e} {reported_errors:e}"
            );
            assert!(
                found >= 0.5 * reported_errors - 1e-12,
                "{found:e} {reported_errors:e}"
            );
        }
        assert!(
            reported_errors[0] <= accuracy.stiffness,
            "{reported_errors:?}"
        );
        let frictionless = cycle.joined_pieces(JoiningAccuracy {
            friction: 0.0,
            turning: f64::INFINITY,
            ..accuracy
        });
        let counts = [&frictionless.pieces, &joined_pieces.pieces].map(Vec::len);
        assert!(
            counts[0] < cycle.stiffness.len() && counts[0] <= counts[1],
            "{counts:?}"
        );
        // The impulse of friction and load is that of the table, for any length of the pieces.
        let mean = |of: fn(&MeshTablePiece) -> f64| -> f64 {
            joined_pieces
                .pieces
                .iter()
                .map(|piece| (piece.end - piece.start) * of(piece))
                .sum()
        };
        assert!((mean(|piece| piece.friction) - cycle.mean(&cycle.friction)).abs() < 1e-12);
        assert!((mean(|piece| piece.centre) - cycle.mean_centre()).abs() < 1e-14);
    }
}

/// Friction of aligned gears varies smoothly: a piece of half the length deviates from its mean by half as much, so
/// that the error decreases with the square of the number of pieces.
#[test]
fn friction_is_met_with_second_order() {
    let (cycle, accuracy) = cycle(0.0, 0.0);
    let [rough, fine] = [4e-4, 2.5e-5].map(|turning| {
        let joined_pieces = cycle.joined_pieces(JoiningAccuracy {
            turning,
            shortest: 1e-3,
            ..accuracy
        });
        let double = joined_pieces.pieces.iter().filter(|piece| piece.end < 0.6);
        (
            off(&cycle, &joined_pieces, &accuracy)[1],
            double.count() as f64,
        )
    });
    let order = (rough.0 / fine.0).ln() / (fine.1 / rough.1).ln();
    assert!((1.6..2.4).contains(&order), "{order} {rough:?} {fine:?}");
}

/// A window may start anywhere in a piece and extend beyond it by a quarter of the cycle, or the length of the piece.
#[test]
fn pieces_can_be_carried_on() {
    let (cycle, accuracy) = cycle(0.0, 0.0);
    for piece in cycle
        .joined_pieces(JoiningAccuracy {
            friction: 0.0,
            ..accuracy
        })
        .pieces
    {
        let length = piece.end - piece.start;
        let end = evaluate(&piece.stiffness, 1.0);
        for step in 0..=10 {
            let behind = 0.1 * f64::from(step) * length.min(LONGEST_WINDOW);
            let k = evaluate(&piece.stiffness, 1.0 + 2.0 * behind / length);
            assert!((0.1..10.0).contains(&(k / end)), "{} {k:e}", piece.end);
        }
    }
}
