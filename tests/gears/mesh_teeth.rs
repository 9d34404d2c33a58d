//! The mesh table of the default drive from its drawing.

#![allow(clippy::unwrap_used)]

use crate::default_drive;
use gearatlas::gear::{
    BasicRack, Contact, Face, FaceLaw, FlankLaw, Flanks, GearPair, LoadSharing, MeshTable,
    MeshTableCycle, MeshTableInputs, Relief, pairs_at,
};

/// The default drive's gears on its shafts.
fn gears() -> GearPair {
    default_drive::gears().on_shafts([22e-3, 26e-3])
}

fn table(gears: &GearPair, change: impl Fn(&mut MeshTableInputs)) -> MeshTable {
    let mut inputs = MeshTableInputs::of_gears(gears);
    inputs.slices = 8;
    change(&mut inputs);
    MeshTable::build(&Flanks::new(gears).unwrap(), &inputs, &|_, _| {}).unwrap()
}

fn rated(gears: &GearPair) -> MeshTableCycle {
    table(gears, |_| {}).cycle(0, 0)
}

#[test]
fn stiffness_is_that_of_the_teeth_in_contact() {
    let gears = gears();
    let flanks = Flanks::new(&gears).unwrap();
    let cycle = rated(&gears);
    let transition = flanks.contact_ratio().fract();
    let position = |phase: f64| flanks.path().start + phase * flanks.path().base_pitch;
    for step in 0..40 {
        let phase = (f64::from(step) + 0.5) / 40.0;
        // Skip phases with possible contact of tips off the path: another pair may carry load.
        let [first, last] = flanks.reach().map(|s| flanks.path().phase(s));
        if phase > first || (transition..last).contains(&phase) {
            continue;
        }
        let a = flanks.compliance(position(phase)).total();
        let mut compliance = a;
        if phase < transition {
            let d = flanks.compliance(position(phase + 1.0)).total();
            let c: f64 = flanks
                .body_coupling(position(phase), 1)
                .unwrap()
                .iter()
                .sum();
            compliance = (a * d - c * c) / (a + d - 2.0 * c);
        }
        let exact = gears.face_width / compliance;
        let found = cycle.value(&cycle.stiffness, phase);
        assert!(
            (found / exact - 1.0).abs() < 1e-9,
            "{phase}: {found}, {exact}"
        );
    }
}

/// Compliance is smooth along the path: without relief a table is cut where pairs come and go, pass the pitch point and
/// at the longest piece, and hardly anywhere for its tolerance.
#[test]
fn smooth_teeth_take_no_pieces_of_their_own() {
    for teeth in [[20, 30], [17, 103], [62, 62]] {
        let mut gears = gears();
        gears.teeth = teeth;
        gears.form.profile_shift = [0.1, 0.0];
        gears.form.bore = teeth.map(|z| Some(gears.module * (f64::from(z) - 2.5) / 2.0));
        let flanks = Flanks::new(&gears).unwrap();
        let path = flanks.path();
        let cycle = table(&gears, |inputs| {
            inputs.tolerance = 1e-9;
            inputs.longest_piece = 1.0 / 12.0;
        })
        .cycle(0, 0);
        let [before, after] = flanks.reach();
        let mut cuts = [0.0, before, path.end, after, 0.0, 1.0];
        for place in &mut cuts[1..5] {
            *place = path.phase(*place);
        }
        cuts.sort_unstable_by(f64::total_cmp);
        let pieces: f64 = (cuts.windows(2))
            .map(|ends| (12.0 * (ends[1] - ends[0]) - 1e-9).ceil().max(0.0))
            .sum();
        // Contact of tip edges cuts the table, and the variation of their gap takes a few pieces.
        assert!(
            cycle.breaks.len() - 1 <= pieces as usize + 5,
            "{teeth:?}: {} {pieces}",
            cycle.breaks.len()
        );
    }
}

/// ISO 6336-1:2006, method B, at the rated load, with the linear contact. One pair is 5 % stiffer, the mean 17 %
/// softer, because the bodies twist on bores as small as their shafts. Pairs share this twist: two have 1.26 times the
/// stiffness of one; for the calibrated drive it is 1.333.
#[test]
fn levels_are_near_the_standard_s() {
    let gears = gears();
    let flanks = Flanks::new(&gears).unwrap();
    let cycle = rated(&gears);
    let q = 0.04723 + 0.15551 / 20.0 + 0.25791 / 30.0;
    let rack = 1.0 + 0.5 * (1.2 - 1.25);
    let specific_load = gears.rated_torque / 0.04 / 20.0;
    let single = 20e6 / q * 0.8 * rack * (specific_load / 100.0).powf(0.25);
    let mean = single * (0.75 * flanks.contact_ratio() + 0.25);
    let transition = flanks.contact_ratio().fract();
    let [double, alone] = [0.5 * transition, 0.5 * (transition + 1.0)]
        .map(|phase| cycle.value(&cycle.stiffness, phase));
    assert!((alone / single - 1.0).abs() < 0.06);
    assert!((cycle.mean_stiffness() / mean - 1.0).abs() < 0.2);
    assert!((double / alone - 1.333).abs() < 0.1);
}

/// On independent slices the loaded length of a misaligned face is proportional to the square root of the compliance.
/// The loss is smaller than that of the calibrated drive, whose mesh is stiffer. With weaker elastic coupling of the
/// slices, a shorter part of the face carries load.
#[test]
fn misalignment_costs_what_a_wedge_costs() {
    let gears = gears();
    let on = |face: FaceLaw| {
        let table = table(&gears, |inputs| {
            inputs.misalignment = vec![0.0, 1e-3];
            inputs.face = face;
        });
        [0, 1].map(|i| table.cycle(i, 0))
    };
    let [aligned, tilted] = on(FaceLaw::Independent);
    let length = |phase: f64| {
        let line_stiffness = aligned.value(&aligned.stiffness, phase) / gears.face_width;
        (2.0 * tilted.force / (line_stiffness * 1e-3)).sqrt() / gears.face_width
    };
    for phase in [0.1, 0.3, 0.8] {
        let ratio =
            tilted.value(&tilted.stiffness, phase) / aligned.value(&aligned.stiffness, phase);
        assert!(
            (ratio / length(phase) - 1.0).abs() < 1e-9,
            "{phase}: {ratio}"
        );
    }
    let drop = 1.0 - tilted.mean_stiffness() / aligned.mean_stiffness();
    assert!(drop > 0.2 && drop < 0.42, "{drop}");
    let [level, supported] = on(FaceLaw::Coupled);
    assert!((level.mean_stiffness() / aligned.mean_stiffness() - 1.0).abs() < 1e-9);
    let coupled = 1.0 - supported.mean_stiffness() / level.mean_stiffness();
    assert!(coupled > 1.2 * drop && coupled < 0.6, "{coupled} {drop}");
    assert!(supported.mean_centre() < 1.1 * tilted.mean_centre());
}

/// A contact that stiffens makes the mesh softer at small loads and stiffer at large ones.
#[test]
fn flattening_flanks_stiffen() {
    let gears = gears();
    let table = table(&gears, |inputs| {
        inputs.torque = vec![5.0, 50.0, 500.0];
        inputs.contact = Contact::LoadDependent;
    });
    let means = [0, 1, 2].map(|i| table.cycle(0, i).mean_stiffness());
    assert!(means[0] < means[1] && means[1] < means[2]);
    assert!(means[2] / means[0] < 1.3, "{means:?}");
    // The derivative of the contact agrees with a difference quotient.
    let flanks = Flanks::new(&gears).unwrap();
    for (s, load) in [(-3e-3, 2e4), (4e-3, 2e5)] {
        let step = 1e-4 * load;
        let [up, down] = [load + step, load - step].map(|w| FlankLaw::contact(&flanks, s, w)[0]);
        let slope = FlankLaw::contact(&flanks, s, load)[1];
        assert!((slope * 2.0 * step / (up - down) - 1.0).abs() < 1e-7);
    }
}

/// Tip relief with the length of the double-pair contact removes the jumps from the transmission error at its design
/// load.
#[test]
fn relief_is_cut_where_it_begins_and_smooths_the_transition() {
    let plain = gears();
    let jump = rated(&plain).peak_to_peak();
    let flanks = Flanks::new(&plain).unwrap();
    let length = (flanks.contact_ratio() - 1.0) * flanks.path().base_pitch;
    // The gap of the entering pair follows from the single pair in contact.
    let coming = flanks.path().start;
    let coupling = flanks.body_coupling(coming, 1).unwrap();
    let own = flanks
        .compliance(coming + flanks.path().base_pitch)
        .uncoupled(coupling);
    let mut relieved = plain.clone();
    relieved.form.tip_relief = [Relief {
        amount: own * plain.rated_force() / plain.face_width,
        length,
        ..Relief::default()
    }; 2];
    let cycle = rated(&relieved);
    assert!(cycle.peak_to_peak() < 0.6 * jump);
    let start = length / flanks.path().base_pitch;
    for phase in [start, flanks.contact_ratio() - start] {
        let cut = phase.fract();
        assert!(cycle.breaks.iter().any(|b| (b - cut).abs() < 1e-9), "{cut}");
    }
    // Halfway into the relief the polynomials still follow the load sharing.
    let face = Face {
        width: relieved.face_width,
        slices: 8,
    };
    let law = Flanks::new(&relieved).unwrap();
    let pairs = pairs_at(&law, 0.31, face).unwrap();
    let sharing = LoadSharing::new(&pairs, face, 0.0).unwrap();
    let load = sharing.distribute(cycle.force);
    let found = cycle.value(&cycle.transmission_error, 0.31);
    assert!((found / load.deflection - 1.0).abs() < 1e-9);
}

/// No pair of a real body gets a negative load: small pinions, large wheels, thin and solid bodies, three pairs at
/// once.
#[test]
fn bodies_of_many_shapes_share_their_load() {
    for teeth in [[18, 18], [19, 48], [25, 120], [62, 62]] {
        for bore in [1.5, 3.0, 6.5] {
            for (addendum, dedendum, tip_radius) in [(1.0, 1.25, 0.38), (1.3, 1.5, 0.2)] {
                let mut gears = gears();
                gears.teeth = teeth;
                gears.form.rack = BasicRack {
                    addendum,
                    dedendum,
                    tip_radius,
                };
                let root = |z: u32| gears.module * (f64::from(z) - 2.0 * dedendum);
                gears.form.bore = teeth.map(|z| Some(root(z) / bore));
                // Long teeth of small pinions are undercut, which other tests cover.
                let Ok(flanks) = Flanks::new(&gears) else {
                    assert!(addendum > 1.0, "{teeth:?}");
                    continue;
                };
                let table = table(&gears, |inputs| inputs.misalignment = vec![0.0, 5e-4]);
                let three = table.share.chunks(3).any(|p| p[2] > 0.0);
                // Tips touch before and after the path of contact.
                assert!(three || flanks.contact_ratio() < 2.0, "{teeth:?}");
                for share in table.share.chunks(3) {
                    assert!((share.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                    assert!(share.iter().all(|p| *p >= 0.0));
                }
            }
        }
    }
}

/// Uniform numbers in [0, 1), always the same ones.
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, [from, to]: [f64; 2]) -> f64 {
        from + (to - from) * self.next()
    }

    fn decades(&mut self, [from, to]: [f64; 2]) -> f64 {
        10f64.powf(self.between([from, to]))
    }
}

/// Random drawings have short and long relief from a tenth of a micrometre to fifty, and loads and misalignments over
/// decades. Every table is within its tolerance of the law at random positions. The tolerance is wider if slices of an
/// unevenly loaded face are elastically coupled.
#[test]
fn relieved_drawings_follow_their_law() {
    let mut random = Uniform(0x9E37_79B9_7F4A_7C15);
    let (mut built, mut worst) = (0, [0.0f64; 2]);
    while built < 60 {
        let mut gears = gears();
        gears.teeth = [17.0, 20.0].map(|least| (least + random.between([0.0, 40.0])) as u32);
        gears.form.profile_shift = [random.between([-0.1, 0.3]), random.between([-0.2, 0.2])];
        let relief = |random: &mut Uniform| Relief {
            amount: random.decades([-7.0, -4.3]),
            length: gears.module * random.between([0.2, 2.7]),
            ..Relief::default()
        };
        gears.form.tip_relief = [relief(&mut random), relief(&mut random)];
        gears.form.root_relief[0] = relief(&mut random);
        gears.form.bore = gears
            .teeth
            .map(|z| Some(gears.module * (f64::from(z) - 2.5) / 3.0));
        let misalignment = if random.next() < 0.4 {
            0.0
        } else {
            (random.next() - 0.5).signum() * random.decades([-8.0, -2.7])
        };
        let torque = random.decades([-1.0, 3.0]);
        let Ok(flanks) = Flanks::new(&gears) else {
            continue;
        };
        built += 1;
        let cycle = table(&gears, |inputs| {
            inputs.misalignment = vec![misalignment];
            inputs.torque = vec![torque];
            inputs.longest_piece = 0.25;
        })
        .cycle(0, 0);
        assert!(cycle.breaks.len() < 100, "{} pieces", cycle.breaks.len());
        let face = Face {
            width: gears.face_width,
            slices: 8,
        };
        let tangent_error = cycle.tangent_error();
        for _ in 0..100 {
            let phase = random.next();
            let pairs = pairs_at(&flanks, phase, face).unwrap();
            let load = LoadSharing::new(&pairs, face, misalignment)
                .unwrap()
                .distribute(cycle.force);
            let deflection = cycle.force / load.stiffness;
            let stiffness = cycle.value(&cycle.stiffness, phase) / load.stiffness - 1.0;
            let error = cycle.value(&tangent_error, phase) - (load.deflection - deflection);
            let centre = cycle.value(&cycle.centre, phase) - load.centre;
            let share = cycle.value(&cycle.share[0], phase) - load.share[0];
            for off in [
                stiffness,
                error / deflection,
                centre / gears.face_width,
                share,
            ] {
                let worst = &mut worst[usize::from(misalignment != 0.0)];
                *worst = worst.max(off.abs());
            }
        }
    }
    println!("{built} drawings, largest errors {worst:?}");
    assert!(worst[0] < 2e-9 && worst[1] < 1e-6, "{worst:?}");
}
