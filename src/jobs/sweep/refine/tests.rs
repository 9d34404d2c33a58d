//! Does refinement find the boundaries of known planes, from results alone?

use super::*;
use crate::analysis::{LyapunovMethod, LyapunovOutcome, PointOutcome, Status};
use crate::store::Placement;
use proptest::prelude::*;

const NESTED: NestedGrid = NestedGrid {
    coarse: [5, 4],
    levels: 5,
};

fn refine(by: &[Criterion]) -> Refine {
    Refine {
        nested: NESTED,
        by: by.to_vec(),
        tolerance: 0.1,
        longest_period: 64,
    }
}

fn row(point_id: u64, class: Option<Class>, events: f64) -> PointRow {
    let mut outcome = PointOutcome::without_results(Status::Ok, String::new());
    outcome.class = class;
    outcome.events_per_cycle = Some(events);
    PointRow {
        point_id,
        axis_values: Vec::new(),
        outcome,
        multistability: None,
        orbits: None,
        chain: None,
        horizon: None,
        covariant: None,
        mesh: None,
        kernel: String::new(),
        placement: Placement::default(),
    }
}

/// The refined plane of a motion; the points `known` are recorded first.
fn plane(refine: &Refine, known: &[u64], motion: impl Fn([usize; 2]) -> PointRow) -> Refinement {
    let mut plane = Refinement::new(refine);
    let point = |id: u64| PointRow {
        point_id: id,
        ..motion(NESTED.at(id as usize))
    };
    known.iter().for_each(|&id| plane.record_point(&point(id)));
    loop {
        let round = plane.next_round();
        assert!(round.is_sorted());
        if round.is_empty() {
            return plane;
        }
        assert!(round.iter().all(|&id| !known.contains(&(id as u64))));
        round
            .iter()
            .for_each(|&id| plane.record_point(&point(id as u64)));
    }
}

/// Chaotic in a disc, otherwise periodic.
fn disc([row, column]: [usize; 2]) -> Option<Class> {
    let (x, y) = (row as f64 - 61.3, column as f64 - 40.7);
    Some(if x.hypot(y) < 27.2 { Class::Chaotic } else { Class::Periodic(1) })
}

#[test]
fn a_boundary_is_found_within_the_resolution_and_little_else() {
    let both = [Criterion::Class, Criterion::Period];
    let found = plane(&refine(&both), &[], |at| row(0, disc(at), 1.0));
    let leaves = NESTED.leaves(|at| found.requested.contains(&found.id(at)));
    let mut missed = 0;
    for cell in &leaves {
        // Both ends of an edge have one motion, unless they are neighbours on the finest grid.
        for axis in 0..2 {
            let one = cell.edges(axis).iter().all(|[a, b]| disc(*a) == disc(*b));
            assert!(cell.sides[axis] == 1 || one, "{cell:?}");
        }
        // If all corners of a cell have one motion, its places have it too, except beside a boundary that
        // touches an edge.
        let [first, ..] = cell.corners();
        if cell.corners().iter().all(|&at| disc(at) == disc(first)) {
            let places = (0..=cell.sides[0]).flat_map(|r| (0..=cell.sides[1]).map(move |c| [r, c]));
            let other =
                |[r, c]: &[usize; 2]| disc([cell.corner[0] + r, cell.corner[1] + c]) != disc(first);
            missed += places.filter(other).count() as u64;
        }
    }
    let all = NESTED.places(NESTED.levels) as u64;
    assert!(200 * missed < all, "{missed} of {all}");
    assert!(found.points() < all / 12, "{} of {all}", found.points());
    assert!(found.points() > 500);
}

/// A straight boundary along an axis needs no division along it: one point per halving on each line of the
/// undivided grid that crosses it.
#[test]
fn a_boundary_along_an_axis_is_not_divided_along_it() {
    let stripes = |[_, c]: [usize; 2]| if c < 41 { Class::Chaotic } else { Class::Periodic(1) };
    let found = plane(&refine(&[Criterion::Class]), &[], |at| {
        row(0, Some(stripes(at)), 1.0)
    });
    let [rows, columns] = NESTED.coarse;
    let wanted = rows * (columns + NESTED.levels as usize);
    assert_eq!(found.points(), wanted as u64);
}

/// A tongue between the corners of coarse cells is followed from its root at the disc.
#[test]
fn what_leaves_a_divided_cell_is_followed() {
    let tongue = |[r, c]: [usize; 2]| {
        if c > 40 && r.abs_diff(52) <= 1 { Some(Class::Chaotic) } else { disc([r, c]) }
    };
    let found = plane(&refine(&[Criterion::Class]), &[], |at| {
        row(0, tongue(at), 1.0)
    });
    let tip = [52, 96];
    assert_eq!(tongue(tip), Some(Class::Chaotic));
    assert!(found.requested.contains(&found.id(tip)));
}

#[test]
fn a_class_that_does_not_hold_is_no_boundary() {
    let by = [Criterion::Class, Criterion::Period];
    let speckled = |[r, c]: [usize; 2]| match (r * 31 + c * 17) % 5 {
        0 => Some(Class::NotConverged),
        1 => None,
        2 => Some(Class::TransientChaos),
        _ => Some(Class::Periodic(2)),
    };
    let coarse = NESTED.places(0) as u64;
    let found = plane(&refine(&by), &[], |at| row(0, speckled(at), 1.0));
    assert_eq!(found.points(), coarse);
    // Locked on a torus, with a different long period at each point.
    let locked = |[r, c]: [usize; 2]| match (r + c) % 3 {
        0 => Class::QuasiPeriodic,
        _ => Class::Periodic(65 + (r * 7 + c * 13) as u32),
    };
    let found = plane(&refine(&by), &[], |at| row(0, Some(locked(at)), 1.0));
    assert_eq!(found.points(), coarse);
    // Chaos differs from a torus if its exponent differs from 0.
    let half = |exponent: f64| {
        plane(&refine(&by), &[], |at| {
            let class = if at[0] < 40 { Class::Chaotic } else { Class::QuasiPeriodic };
            let mut row = row(0, Some(class), 1.0);
            row.outcome.lyapunov = Some(LyapunovOutcome {
                exponents: vec![exponent],
                errors: vec![0.01],
                dimension: None,
                twin: None,
                twin_stderr: None,
                twin_agrees: None,
                method: LyapunovMethod::Tangent,
                convergence: None,
            });
            row
        })
    };
    assert_eq!(half(0.049).points(), coarse);
    assert!(half(0.051).points() > coarse);
}

#[test]
fn numbers_are_held_against_what_the_coarse_grid_spans() {
    let by = [Criterion::EventsPerCycle];
    let coarse = NESTED.places(0) as u64;
    let slope = |steep: f64| {
        let column = move |[_, c]: [usize; 2]| row(0, Some(Class::Chaotic), steep * c as f64);
        plane(&refine(&by), &[], column).points()
    };
    // The span from corner to corner is divided until a difference is less than a tenth of it, along the columns only.
    assert_eq!(slope(1.0), 5 * 13);
    assert_eq!(slope(1.0), slope(1e-9));
    assert_eq!(slope(0.0), coarse);
}

proptest! {
    /// Points in a journal do not change the set of requested points.
    #[test]
    fn what_is_asked_for_follows_from_results_alone(seed in any::<u64>(), part in 1..9_u64) {
        let by = refine(&[Criterion::Class, Criterion::Period]);
        let motion = |at| row(0, disc(at), 1.0);
        let whole = plane(&by, &[], motion);
        let keep = |id: &&u64| blake3::hash(&(*id ^ seed).to_le_bytes()).as_bytes()[0] % 10 < part as u8;
        let known: Vec<u64> = whole.requested.iter().filter(keep).copied().collect();
        prop_assert_eq!(&plane(&by, &known, motion).requested, &whole.requested);
    }
}
