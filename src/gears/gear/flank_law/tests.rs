#![allow(clippy::unwrap_used)]
use super::*;
use crate::gear::{ToothForm, fixtures};

/// A law with the required methods only.
struct MinimalLaw;

impl FlankLaw for MinimalLaw {
    fn path(&self) -> PathOfContact {
        PathOfContact {
            base_pitch: 12e-3,
            start: -4e-3,
            end: 15e-3,
            pitch_point: 1e-3,
        }
    }

    fn compliance(&self, s: f64) -> PairCompliance {
        PairCompliance {
            tooth: [1e-11 + 1e-10 * s, 2e-11],
            hertz: 5e-12 + 1e-11 * s,
            foundation: [3e-12, 4e-12],
        }
    }

    fn relief(&self, _: f64) -> f64 {
        1e-6
    }
}

/// The default methods describe a spur pair on a plain path, with separate bodies, no lead and a linear contact.
#[test]
fn a_law_that_says_no_more_is_the_plainest() {
    let law = MinimalLaw;
    assert_eq!(law.reach(), [-4e-3, 15e-3]);
    assert_eq!((law.helix(), law.coupling(2e-3, 1)), (0.0, 0.0));
    assert_eq!(law.deviation(2e-3, 5e-3), 0.0);
    assert!(law.face_coupling().is_none() && law.kinks().is_empty());
    for s in [-3e-3, 2e-3, 9e-3] {
        let hertz = law.compliance(s).hertz;
        assert_eq!(law.contact(s, 3e5), [3e5 * hertz, hertz]);
    }
}

fn drawn(helix_angle: f64) -> Flanks {
    let form = ToothForm {
        bore: [Some(30e-3), Some(40e-3)],
        lead: [1, 2].map(|gear| crate::gear::Modification {
            crowning: 1e-6 * f64::from(gear),
            slope: 2e-6,
        }),
        ..ToothForm::default()
    };
    let pair = crate::gear::GearPair {
        helix_angle,
        ..fixtures::pair([20, 30], form)
    };
    Flanks::new(&pair).unwrap()
}

/// Compares everything except the contact and the coupling of slices.
fn assert_alike(one: &impl FlankLaw, other: &impl FlankLaw) {
    assert_eq!(one.path(), other.path());
    assert_eq!(one.reach(), other.reach());
    assert_eq!(one.helix(), other.helix());
    assert_eq!(one.kinks(), other.kinks());
    for s in [-2e-3, 0.0, 3e-3] {
        assert_eq!(one.coupling(s, 1), other.coupling(s, 1));
        assert_eq!(one.relief(s), other.relief(s));
        assert_eq!(one.deviation(s, 7e-3), other.deviation(s, 7e-3));
        let [a, b] = [one.compliance(s), other.compliance(s)];
        assert_eq!((a.tooth, a.foundation), (b.tooth, b.foundation));
    }
}

#[test]
fn a_law_taken_by_secant_or_slice_keeps_the_rest() {
    for law in [drawn(0.0), drawn(0.2)] {
        assert!(law.deviation(0.0, 7e-3) != 0.0 && law.coupling(0.0, 1) != 0.0);
        let line_load = 2e5;
        let secant = SecantContact {
            law: &law,
            line_load,
        };
        assert_alike(&secant, &law);
        assert_eq!(
            secant.face_coupling().is_some(),
            law.face_coupling().is_some()
        );
        let slices = IndependentSlices(&law);
        assert_alike(&slices, &law);
        assert!(slices.face_coupling().is_none());
        for s in [-2e-3, 3e-3] {
            // At the line load of the secant both laws have the same approach. Elsewhere the secant is proportional to
            // the load.
            let [approach, _] = FlankLaw::contact(&law, s, line_load);
            let [found, slope] = secant.contact(s, line_load);
            assert!((found / approach - 1.0).abs() < 1e-14);
            assert!((slope * line_load / approach - 1.0).abs() < 1e-14);
            assert_eq!(
                slices.contact(s, line_load),
                FlankLaw::contact(&law, s, line_load)
            );
            assert_eq!(slices.compliance(s), FlankLaw::compliance(&law, s));
        }
    }
}

/// The tangent of the contact is the derivative of its approach, and becomes stiffer with the load.
#[test]
fn the_contact_has_its_own_tangent() {
    for law in [drawn(0.0), drawn(0.3)] {
        for s in [-2e-3, 0.0, 3e-3] {
            for line_load in [5e4, 4e5] {
                let step = 1e-4 * line_load;
                let [_, slope] = FlankLaw::contact(&law, s, line_load);
                let [low, high] =
                    [-step, step].map(|more| FlankLaw::contact(&law, s, line_load + more)[0]);
                assert!(
                    (slope * 2.0 * step / (high - low) - 1.0).abs() < 1e-7,
                    "{slope}"
                );
            }
            let [soft, hard] = [5e4, 4e5].map(|load| FlankLaw::contact(&law, s, load)[1]);
            assert!(hard < soft && hard > 0.0);
        }
    }
}

/// Line loads and approaches of helical teeth are those of the pair in the normal section, with approaches times
/// `1/cos β_b`.
#[test]
fn helical_teeth_yield_as_those_of_their_normal_section() {
    let law = drawn(0.3);
    let section = law.normal_section.as_ref().unwrap();
    let cos = law.base_helix_angle.cos();
    for s in [-2e-3, 3e-3] {
        let (own, normal) = (FlankLaw::compliance(&law, s), section.compliance(s / cos));
        for (a, b) in [
            (own.tooth[0], normal.tooth[0]),
            (own.tooth[1], normal.tooth[1]),
            (own.hertz, normal.hertz),
            (own.foundation[0], normal.foundation[0]),
            (own.foundation[1], normal.foundation[1]),
        ] {
            assert!((a * cos / b - 1.0).abs() < 1e-14, "{a} {b}");
        }
        let [approach, _] = FlankLaw::contact(&law, s, 2e5);
        let exact = section.hertz_approach(s / cos, 2e5) / cos;
        assert!((approach / exact - 1.0).abs() < 1e-14);
    }
}

/// Radii of curvature in the normal section are those of the transverse one over cos β_b, for any sum of profile
/// shifts and any centre distance.
#[test]
fn flanks_are_curved_in_their_normal_section_as_euler_says() {
    for shift in [[0.0, 0.0], [0.5, 0.5], [0.1, -0.3]] {
        let form = ToothForm {
            bore: [Some(30e-3), Some(40e-3)],
            profile_shift: shift,
            ..ToothForm::default()
        };
        let pair = crate::gear::GearPair {
            helix_angle: 0.5,
            ..fixtures::pair([20, 30], form)
        };
        let law = Flanks::new(&pair).unwrap();
        let (section, cos) = (
            law.normal_section.as_ref().unwrap(),
            law.base_helix_angle.cos(),
        );
        for s in [-2e-3, 0.0, 3e-3] {
            let found = section.relative_radius(s / cos) * cos / law.relative_radius(s);
            assert!((found - 1.0).abs() < 1e-13, "{shift:?}, {s}: {found}");
        }
    }
}
