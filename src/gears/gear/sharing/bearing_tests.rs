//! Common properties of loads on a face, with coupled and with independent slices.

#![allow(clippy::unwrap_used)]
use super::*;
use crate::gear::{Flanks, Relief, ToothForm, fixtures};

const WIDTH: f64 = 20e-3;

fn face(slices: usize) -> Face {
    Face {
        width: WIDTH,
        slices,
    }
}

fn flanks(helix_angle: f64) -> Flanks {
    let form = ToothForm {
        bore: [Some(30e-3), Some(40e-3)],
        ..ToothForm::default()
    };
    let pair = fixtures::pair([20, 30], form);
    let pair = crate::gear::GearPair {
        helix_angle,
        ..pair
    };
    Flanks::new(&pair).unwrap()
}

/// Spur pairs with coupled slices, the same with independent slices, and a helical face, all misaligned.
fn askew(angle: f64) -> [LoadSharing; 3] {
    let spur = flanks(0.0);
    let pairs = pairs_at(&spur, 0.1, face(16)).unwrap();
    assert_eq!(pairs.len(), 2);
    let helical = HelicalFace::new(&flanks(0.25), 0.1, face(16)).unwrap();
    let all = [
        LoadSharing::new(&pairs, face(16), angle).unwrap(),
        LoadSharing::of_slices(&pairs, face(16), angle).unwrap(),
        helical.sharing(angle).unwrap(),
    ];
    // An even load needs no coupling of slices.
    assert_eq!(all[0].coupled.is_some(), angle != 0.0);
    assert!(all[1].coupled.is_none());
    all
}

/// The pattern balances the force, pair by pair, and its moment about mid-face. The stiffness is the slope of the
/// force, and a load computed with its margins is the same load.
#[test]
fn a_load_is_the_sum_of_its_pattern() {
    for (number, sharing) in askew(4e-4).iter().enumerate() {
        let helical = number == 2;
        for force in [300.0, 2e3, 9e3] {
            let load = sharing.distribute(force);
            assert_eq!(load, sharing.distribute_with_margins(force).0);
            let pattern = sharing.pattern(force);
            let slice = WIDTH / 16.0;
            let (mut sum, mut moment) = (0.0, 0.0);
            for (pair, lines) in pattern.chunks(16).enumerate() {
                let own: f64 = lines.iter().map(|line| line * slice).sum();
                if !helical {
                    let share = load.share[pair];
                    assert!((own / force - share).abs() < 1e-9, "{number} {own} {share}");
                }
                sum += own;
                moment += (lines.iter().enumerate())
                    .map(|(i, line)| line * slice * (i as f64 + 0.5) * slice)
                    .sum::<f64>();
            }
            assert!((sum / force - 1.0).abs() < 1e-9, "{number} {sum} {force}");
            assert!((load.share.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            // The load on a slice acts within it.
            let centre = moment / force - 0.5 * WIDTH;
            assert!(
                (load.centre - centre).abs() < 0.5 * slice,
                "{number} {centre}"
            );
            assert!(load.centre < 0.0, "{number}: {}", load.centre);
            let step = 1e-4 * force;
            let approach = |force: f64| sharing.distribute(force).deflection;
            let slope = 2.0 * step / (approach(force + step) - approach(force - step));
            assert!(
                (load.stiffness / slope - 1.0).abs() < 1e-3,
                "{number} {slope}"
            );
        }
    }
}

/// Loaded lengths are those of the parts of the face with a nonzero pattern: the whole face under a high
/// load, half of it and less if flanks are strongly misaligned.
#[test]
fn loaded_lengths_are_those_of_the_pattern() {
    for (angle, force, full) in [(1e-5, 5e3, true), (3e-3, 5e2, false)] {
        for (number, sharing) in askew(angle).iter().take(2).enumerate() {
            let (load, lengths) = sharing.distribute_with_lengths(force);
            let pattern = sharing.pattern(force);
            let all: f64 = lengths.iter().sum();
            assert!((load.contact_fraction - all / (2.0 * WIDTH)).abs() < 1e-12);
            for (lines, length) in pattern.chunks(16).zip(lengths) {
                let touched = lines.iter().filter(|line| **line > 0.0).count() as f64;
                let most = touched * WIDTH / 16.0;
                assert!(length <= most + 1e-9, "{number} {length} {most}");
                assert!(
                    length > most - 0.999 * WIDTH / 16.0 - 1e-9,
                    "{number} {length} {most}"
                );
                assert_eq!(full, (length - WIDTH).abs() < 1e-12, "{number} {length}");
            }
        }
    }
}

/// Without a force, the flanks of spur gears touch where the gap is smallest, with coupled and with independent slices.
#[test]
fn without_a_force_flanks_touch_at_an_end_of_the_face() {
    for sharing in &askew(4e-4)[..2] {
        let load = sharing.distribute(0.0);
        assert!((load.deflection + 4e-4 * 0.5 * WIDTH).abs() < 1e-15);
        assert_eq!(load.share, [0.0; MOST_PAIRS]);
        assert!(sharing.pattern(0.0).iter().all(|line| *line == 0.0));
    }
}

/// Teeth supported by the unloaded rest of the face are stiffer at its loaded end and draw load there. With
/// load all along the face the approach is the same as with independent slices. An even load is shared in the
/// same way.
#[test]
fn support_between_slices_draws_load_to_the_end() {
    for angle in [1e-4, 3e-3] {
        let [coupled, slices, _] = askew(angle);
        let [with, without] = [&coupled, &slices].map(|sharing| sharing.distribute(3e3));
        assert!(
            with.centre < without.centre && without.centre < 0.0,
            "{angle}"
        );
        if angle == 1e-4 {
            assert!((with.deflection / without.deflection - 1.0).abs() < 1e-6);
        }
    }
    let [coupled, slices, _] = askew(0.0);
    let [with, without] = [&coupled, &slices].map(|sharing| sharing.distribute(2e3));
    assert!((with.deflection / without.deflection - 1.0).abs() < 1e-9);
    assert!((with.stiffness / without.stiffness - 1.0).abs() < 1e-9);
    for (a, b) in with.share.iter().zip(without.share) {
        assert!((a - b).abs() < 1e-9);
    }
}

/// A cut of a helical face may be the end of a relief. Rounding decides there which of two gaps is smaller.
#[test]
fn the_end_of_a_relief_moves_no_load_between_neighbouring_phases() {
    let relief = Relief {
        amount: 20e-6,
        length: 4e-3,
        ..Relief::default()
    };
    let form = ToothForm {
        bore: [Some(30e-3), Some(40e-3)],
        tip_relief: [relief; 2],
        ..ToothForm::default()
    };
    let pair = crate::gear::GearPair {
        helix_angle: 0.25,
        ..fixtures::pair([20, 30], form)
    };
    let flanks = Flanks::new(&pair).unwrap();
    for step in 0..100 {
        let phase = f64::from(step) / 100.0;
        let [one, other] = [phase, phase + 1e-9].map(|phase| {
            let lines = HelicalFace::new(&flanks, phase, face(16)).unwrap();
            lines.sharing(0.0).unwrap().distribute(300.0).stiffness
        });
        assert!((one / other - 1.0).abs() < 1e-6, "{phase}: {one} {other}");
    }
}
