use super::*;
use crate::numerics::legendre::transforms24;

/// Series of a polynomial of degree < 24 given as a function.
fn series(f: impl Fn(f64) -> f64) -> [f64; 24] {
    let t = transforms24();
    let nodes = *t.nodes();
    t.interpolate(&std::array::from_fn(|j| f(nodes[j])))
}

fn find(f: impl Fn(f64) -> f64) -> Search {
    earliest_exit::<_, Portable>(transforms24(), &series(f), 1.0, 1e-14)
}

#[test]
fn no_root_is_certified_at_once() {
    let s = find(|x| 2.0 + x);
    assert!(s.certified && s.exit.is_none());
}

#[test]
fn the_earliest_of_many_is_found() {
    // The slopes at the roots alternate. The first falling root is −0.9.
    let roots = [-0.9, -0.5, -0.1, 0.2, 0.6, 0.95];
    let s = find(|x| roots.iter().map(|r| r - x).product());
    assert!((s.exit.unwrap() + 0.9).abs() < 1e-15);
}

#[test]
fn two_roots_closer_than_any_grid_are_not_skipped() {
    for gap in [1e-3, 1e-5, 1e-6] {
        // Negative only on (0.3, 0.3 + gap).
        let s = find(|x| (x - 0.3) * (x - 0.3 - gap));
        let root = s.exit.expect("the dip is found");
        // A double root amplifies round-off by 1/gap.
        assert!((root - 0.3).abs() < 4e-15 / gap, "gap {gap}: {root}");
    }
    // A dip shallower than round-off is a tangency.
    let s = find(|x| (x - 0.3) * (x - 0.3 - 1e-8));
    assert!(s.exit.is_none() && s.grazings >= 1);
}

#[test]
fn a_tangency_from_above_is_counted_and_not_an_exit() {
    let s = find(|x| (x - 0.3) * (x - 0.3));
    assert_eq!(s.exit, None);
    assert!(s.grazings >= 1);
    let near = find(|x| (x - 0.3) * (x - 0.3) + 1e-12);
    assert_eq!((near.exit, near.grazings), (None, 0));
}

#[test]
fn a_start_outside_exits_at_once_and_a_start_on_the_surface_by_its_slope() {
    assert_eq!(find(|x| -1.0 + 0.1 * x).exit, Some(-1.0));
    assert!((find(|x| -(x + 1.0)).exit.unwrap() + 1.0).abs() < 1e-14);
    assert_eq!(find(|x| x + 1.0).exit, None);
}

#[test]
fn roots_beyond_the_limit_are_not_reported() {
    let f = series(|x| 0.5 - x);
    let t = transforms24();
    assert_eq!(
        earliest_exit::<_, Portable>(t, &f, 0.4999, 1e-16).exit,
        None
    );
    assert!(
        (earliest_exit::<_, Portable>(t, &f, 0.5001, 1e-16)
            .exit
            .unwrap()
            - 0.5)
            .abs()
            < 1e-15
    );
    assert!(
        earliest_exit::<_, Portable>(t, &f, 1.0, 1e-16)
            .exit
            .is_some()
    );
}

#[test]
fn a_root_at_the_very_end_is_found_here_or_at_the_next_start() {
    let s = find(|x| 1.0 - x);
    // Zero at the end is not negative yet, so the next window starts on the surface.
    let next = find(|x| -(x + 1.0));
    assert!(s.exit.is_some() || next.exit.is_some_and(|x| x + 1.0 < 1e-14));
}

fn changes(f: impl Fn(f64) -> f64, positive: &mut Option<bool>) -> Vec<(f64, bool)> {
    let mut found = Vec::new();
    sign_changes(transforms24(), &series(f), 1e-14, positive, |x, rises| {
        found.push((x, rises));
    });
    found
}

#[test]
fn every_change_of_sign_is_found_in_order() {
    let roots = [-0.9, -0.5, -0.1, 0.2, 0.6, 0.95];
    let found = changes(|x| roots.iter().map(|r| r - x).product(), &mut None);
    assert_eq!(found.len(), roots.len());
    for (i, ((x, rises), root)) in found.iter().zip(roots).enumerate() {
        assert!((x - root).abs() < 1e-14, "{x} {root}");
        assert_eq!(*rises, i % 2 == 1);
    }
    // Closer than any grid, and no change if the series only touches zero.
    let close = changes(|x| (x - 0.3) * (x - 0.3 - 1e-6), &mut None);
    assert_eq!(close.len(), 2);
    assert!(changes(|x| (x - 0.3) * (x - 0.3), &mut None).is_empty());
    assert!(changes(|_| 0.0, &mut None).is_empty());
}

#[test]
fn a_change_on_a_joint_is_found_once() {
    // The root is at the joint of two windows, with round-off on either side, or the series jumps across zero
    // there.
    for shift in [0.0, 1e-16, -1e-16, 1e-13] {
        let mut positive = None;
        let left = changes(|x| 0.5 * (x - 1.0) - shift, &mut positive);
        let right = changes(|x| 0.5 * (x + 1.0) + shift, &mut positive);
        assert_eq!(left.len() + right.len(), 1, "{shift}: {left:?} {right:?}");
        assert!(left.iter().chain(&right).all(|(_, rises)| *rises));
    }
}

/// The estimate from samples leaves at most two steps to Halley's iteration.
#[test]
fn a_smooth_root_takes_two_steps_at_most() {
    for root in [-0.9, -0.3, 0.0, 0.55, 0.98] {
        let s = find(|x| (root - x) * (3.0 + x) + 0.1 * ((2.0 * root).sin() - (2.0 * x).sin()));
        assert!(
            (s.exit.unwrap() - root).abs() < 1e-14,
            "{root} {:?}",
            s.exit
        );
        assert!((1..=2).contains(&s.newton_steps), "{root}");
    }
}
