#![allow(clippy::unwrap_used)]
use super::*;
use crate::gear::{
    Contact, FaceLaw, FlankLaw, Flanks, MeshTable, MeshTableCycle, MeshTableInputs, PairCompliance,
    PathOfContact, ToothForm, fixtures,
};

/// Minimum length of divisions.
const APART: f64 = 1e-9;

fn drawn(teeth: [u32; 2], shift: [f64; 2], helix_degrees: f64) -> GearPair {
    let form = ToothForm {
        profile_shift: shift,
        bore: [Some(30e-3), Some(40e-3)],
        ..ToothForm::default()
    };
    GearPair {
        helix_angle: helix_degrees.to_radians(),
        ..fixtures::pair(teeth, form)
    }
}

fn spur_pairs() -> [GearPair; 3] {
    [
        drawn([20, 30], [0.0; 2], 0.0),
        drawn([20, 30], [0.4, -0.1], 0.0),
        drawn([30, 71], [0.2, 0.1], 0.0),
    ]
}

/// One pair passes the pitch point while two are in contact.
fn late() -> GearPair {
    drawn([30, 71], [-0.1, 0.3], 0.0)
}

/// Teeth of constant stiffness along the path of a drawing, on rigid bodies: they share the load evenly.
struct Even {
    path: PathOfContact,
    helix: f64,
}

impl FlankLaw for Even {
    fn path(&self) -> PathOfContact {
        self.path
    }

    fn helix(&self) -> f64 {
        self.helix
    }

    fn compliance(&self, _: f64) -> PairCompliance {
        PairCompliance {
            tooth: [3e-11; 2],
            hertz: 1e-11,
            foundation: [0.0; 2],
        }
    }

    fn relief(&self, _: f64) -> f64 {
        0.0
    }
}

/// The mesh table of a drawing with teeth of constant stiffness.
fn table(pair: &GearPair) -> MeshTableCycle {
    let law = Even {
        path: Flanks::new(pair).unwrap().path(),
        helix: pair.base_helix_angle().tan(),
    };
    let inputs = MeshTableInputs {
        contact: Contact::Linear,
        face: FaceLaw::Independent,
        misalignment: vec![0.0],
        torque: vec![50.0],
        ..MeshTableInputs::of_gears(pair)
    };
    MeshTable::build(&law, &inputs, &|_, _| ())
        .unwrap()
        .cycle(0, 0)
}

/// Phases, sharing, signs and levers agree with the mesh table of evenly shared load, and so do the
/// phases at which they change.
#[test]
fn spur_pairs_slide_as_their_mesh_table_has_it() {
    for pair in spur_pairs().into_iter().chain([late()]) {
        let (even, cycle) = (EvenSharing::new(&pair).unwrap(), table(&pair));
        for place in 0..997 {
            let phase = (f64::from(place) + 0.5) / 997.0;
            let found = even.at(phase);
            let direction = cycle.value(&cycle.friction, phase);
            let lever = cycle.value(&cycle.friction_lever, phase);
            assert!((found.direction - direction).abs() < 1e-12, "{phase}");
            assert!(
                (found.lever - lever).abs() < 1e-12 * even.base_pitch,
                "{phase}"
            );
        }
        let ends = even.direction_breaks(APART);
        assert_eq!(ends.len(), 3, "a pair leaves, one passes the pitch point");
        for end in ends {
            assert!(
                cycle.breaks.iter().any(|own| (own - end).abs() < 1e-12),
                "{end}"
            );
        }
    }
}

/// The sign changes where a pair passes the pitch point. Before it the pinion slides along +t.
#[test]
fn friction_turns_at_the_pitch_point() {
    for pair in spur_pairs() {
        let even = EvenSharing::new(&pair).unwrap();
        let pitch = even.pitch_phase;
        // One pair is in contact at the pitch point of all of these.
        assert!(even.contact_ratio - 1.0 < pitch && pitch < 1.0);
        assert_eq!(even.at(pitch - 1e-12).direction, 1.0);
        assert_eq!(even.at(pitch + 1e-12).direction, -1.0);
        // Two pairs, one before the pitch point and one after it, carry half each.
        let two = even.at(0.5 * (even.contact_ratio - 1.0));
        assert_eq!(two.direction, 0.0);
        assert!((two.lever / (-0.5 * even.base_pitch) - 1.0).abs() < 1e-14);
    }
}

/// `H_v = π (u + 1)/(z₁ u) (1 − ε + ε₁² + ε₂²)` (Ohlendorf 1958) is the mean sliding of evenly loaded pairs.
#[test]
fn evenly_shared_load_has_ohlendorf_s_loss_factor() {
    for pair in spur_pairs() {
        let even = EvenSharing::new(&pair).unwrap();
        let ends = [0.0]
            .into_iter()
            .chain(even.direction_breaks(APART))
            .collect::<Vec<_>>();
        let lever: f64 = (ends.windows(2))
            .map(|ends| (ends[1] - ends[0]) * even.mean([ends[0], ends[1]]).lever)
            .sum();
        let [one, two] = pair.base_radii();
        let [before, behind] = [even.pitch_phase, even.contact_ratio - even.pitch_phase];
        let ohlendorf = std::f64::consts::PI / f64::from(pair.teeth[0])
            * (1.0 + one / two)
            * (1.0 - even.contact_ratio + before * before + behind * behind);
        let found = -lever * (1.0 / one + 1.0 / two);
        assert!(
            (found / ohlendorf - 1.0).abs() < 1e-12,
            "{found} {ohlendorf}"
        );
    }
}

/// Lines of contact with the same load per length: Λ agrees with the mesh table, whose spans across the face give an
/// error of 1e-5. The means of Λ agree with those over many phases.
#[test]
fn helical_lines_slide_as_their_mesh_table_has_it() {
    for degrees in [-8.0, 12.0, 30.0] {
        let pair = drawn([20, 30], [0.2, 0.0], degrees);
        let (even, cycle) = (EvenSharing::new(&pair).unwrap(), table(&pair));
        for place in 0..97 {
            let phase = (f64::from(place) + 0.5) / 97.0;
            let found = even.at(phase);
            let direction = cycle.value(&cycle.friction, phase);
            let lever = cycle.value(&cycle.friction_lever, phase);
            assert!(
                (found.direction - direction).abs() < 1e-4,
                "{phase}: {direction}"
            );
            assert!(
                (found.lever - lever).abs() < 1e-4 * even.base_pitch,
                "{phase}"
            );
        }
        let mut from = 0.0;
        for to in even.direction_breaks(APART) {
            assert!(to - from < LONGEST_STRETCH + 1e-12);
            let parts = 400;
            let at = |part: u32| from + (to - from) * (f64::from(part) + 0.5) / f64::from(parts);
            let sum: f64 = (0..parts).map(|part| even.at(at(part)).direction).sum();
            let mean = even.mean([from, to]).direction;
            assert!((sum / f64::from(parts) - mean).abs() < 1e-5, "{from} {to}");
            from = to;
        }
    }
}

/// A face of nearly no overlap behaves like that of spur gears.
#[test]
fn a_narrow_helical_face_slides_as_a_spur_one() {
    let pair = drawn([20, 30], [0.0; 2], 0.0);
    let spur = EvenSharing::new(&pair).unwrap();
    let narrow = EvenSharing {
        overlap_ratio: 1e-5,
        ..spur
    };
    for phase in [0.05, 0.3, spur.contact_ratio - 1.01, 0.75, 0.95] {
        let [one, two] = [spur, narrow].map(|pairs| pairs.at(phase));
        assert!((one.direction - two.direction).abs() < 1e-8, "{phase}");
        assert!((one.lever - two.lever).abs() < 1e-10, "{phase}");
    }
}

#[test]
fn pairs_that_come_too_late_are_refused() {
    let mut pair = drawn([20, 30], [0.0; 2], 0.0);
    pair.form.tip_diameter = [Some(82e-3), Some(122e-3)];
    assert!(matches!(
        EvenSharing::new(&pair),
        Err(GearError::ContactRatio { contact_ratio }) if contact_ratio < 1.0
    ));
}

/// A line of contact that ends just before the path begins, by rounding, has no part in it.
#[test]
fn a_line_may_end_where_the_path_begins() {
    let spur = EvenSharing::new(&drawn([20, 30], [0.0; 2], 0.0)).unwrap();
    let helical = EvenSharing {
        overlap_ratio: 0.6,
        ..spur
    };
    let [at, near] = [0.7, 0.7 + 1e-9].map(|phase| helical.at(phase));
    assert!((at.direction - near.direction).abs() < 1e-6);
}
