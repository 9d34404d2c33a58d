//! Tooth geometry and path of contact compared with closed forms and a brute-force rack.

#![allow(clippy::unwrap_used)]

use gearatlas::gear::{
    Flanks, GearError, GearPair, ProfilePoint, Relief, Tooth, ToothForm, involute,
};
use std::f64::consts::{FRAC_PI_2, PI};

fn pair(teeth: [u32; 2], module: f64) -> GearPair {
    GearPair {
        teeth,
        module,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        face_width: 20e-3,
        body_length: [20e-3; 2],
        rated_torque: 50.0,
        form: ToothForm {
            bore: teeth.map(|z| Some(0.4 * module * f64::from(z))),
            ..ToothForm::default()
        },
    }
}

fn flanks(pair: &GearPair) -> Flanks {
    Flanks::new(pair).unwrap_or_else(|error| panic!("{error}"))
}

fn shifted(teeth: [u32; 2], shift: [f64; 2]) -> GearPair {
    let mut pair = pair(teeth, 3e-3);
    pair.form.profile_shift = shift;
    pair
}

fn close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} {expected}");
}

/// Signed distance \[m\] of a point of the tooth from the neighbouring tooth of the rack, with the gear rolled by an
/// angle: the rounded tooth is a sharp-cornered core expanded by the tip radius.
fn rack_distance(pair: &GearPair, tooth: &Tooth, (x, y): (f64, f64), rolled: f64) -> f64 {
    let (module, rack) = (pair.module, pair.form.rack);
    let (sin, cos) = pair.pressure_angle.sin_cos();
    let (s, c) = rolled.sin_cos();
    let across = x * c + y * s - tooth.reference_radius * rolled;
    let height = y * c - x * s;
    let depth = tooth.reference_radius + tooth.generating_shift * module - height;
    let beside = FRAC_PI_2 * module - across;
    let radius = rack.tip_radius * module;
    let flank = (beside - (0.25 * PI * module - depth * sin / cos)) * cos + radius;
    let corner_depth = rack.dedendum * module - radius;
    let tip = depth - corner_depth;
    let corner = 0.25 * PI * module - corner_depth * sin / cos - radius / cos;
    let (dx, dy) = (beside - corner, tip);
    let on_flank = -dx * sin + dy * cos < 0.0;
    let on_tip = dx < 0.0;
    let core = match (on_flank, on_tip) {
        (false, false) => dx.hypot(dy),
        (true, false) => flank,
        (false, true) => tip,
        (true, true) => flank.max(tip),
    };
    core - radius
}

/// Material that the rolling rack leaves at a point of the tooth \[modules\]; negative if it cuts the point off.
fn material_left_by_rack(pair: &GearPair, tooth: &Tooth, point: ProfilePoint) -> f64 {
    let at = |rolled: f64| rack_distance(pair, tooth, (point.x, point.y), rolled);
    let steps = 4000;
    let angle = |i: f64| (2.0 * i / f64::from(steps) - 1.0) * 1.2;
    let nearest = (0..=steps)
        .min_by(|&a, &b| at(angle(a.into())).total_cmp(&at(angle(b.into()))))
        .unwrap();
    let nearest = f64::from(nearest);
    let (mut low, mut high) = (angle(nearest - 1.0), angle(nearest + 1.0));
    for _ in 0..80 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(a) < at(b) { high = b } else { low = a }
    }
    at(0.5 * (low + high)) / pair.module
}

/// A standard pinion of 17 teeth, thinned.
fn undercut_a_little() -> GearPair {
    let mut gears = pair([17, 38], 3e-3);
    gears.form.thinning = [60e-6; 2];
    gears
}

/// The involute of an undercut tooth begins above the base circle, where the rolling rack no longer cuts it, and the
/// fillet ends there.
#[test]
fn an_undercut_flank_begins_where_the_rack_leaves_it() {
    for gears in [pair([12, 30], 4e-3), undercut_a_little()] {
        let tooth = Tooth::new(&gears, 0).unwrap();
        assert!(tooth.undercut.is_some() && tooth.form_roll > 0.0);
        let left =
            |part: f64| material_left_by_rack(&gears, &tooth, tooth.flank(part * tooth.form_roll));
        assert!(left(0.9) < -1e-8, "{}", left(0.9));
        close(left(1.01), 0.0, 1e-11);
        let (fillet, flank) = (
            tooth.fillet(tooth.fillet_range()[0]),
            tooth.flank(tooth.form_roll),
        );
        close(fillet.x, flank.x, 1e-12);
        close(fillet.y, flank.y, 1e-12);
    }
    // Without undercut the flank begins where the straight flank of the rack ends.
    assert_eq!(Tooth::new(&pair([20, 30], 4e-3), 0).unwrap().undercut, None);
}

/// A pair with contact above the undercut has the path of contact of its tip circles.
#[test]
fn undercut_below_the_contact_changes_no_path() {
    let gears = undercut_a_little();
    let flanks = flanks(&gears);
    let [base, tip]: [f64; 2] = [57e-3 * 20f64.to_radians().cos(), 60e-3];
    let approach = (tip * tip - base * base).sqrt() - 57e-3 * 20f64.to_radians().sin();
    close(flanks.path().start, -approach, 1e-15);
    assert!(flanks.roll(flanks.path().start)[0] > flanks.teeth[0].form_roll);
    assert!(flanks.reach()[0] < flanks.path().start);
}

/// The rolling rack touches every point of flank and fillet and never cuts it.
#[test]
fn the_profile_is_the_envelope_of_the_rack() {
    let mut cases = vec![pair([20, 30], 4e-3), shifted([12, 25], [0.5, -0.2])];
    cases.push({
        let mut sharp = shifted([40, 90], [0.0, 0.3]);
        sharp.form.rack.tip_radius = 0.0;
        sharp.form.thinning = [60e-6, 20e-6];
        sharp
    });
    // The centre of the rack's rounded corner is above the rolling line.
    cases.push(shifted([15, 60], [0.9, -0.9]));
    // Pinions with large and with small undercut.
    cases.push(pair([12, 30], 4e-3));
    cases.push(undercut_a_little());
    for pair in &cases {
        for index in [0, 1] {
            let tooth = Tooth::new(pair, index).unwrap();
            let [from, to] = tooth.fillet_range();
            let fillet = (0..=40).map(|i| tooth.fillet(from + (to - from) * f64::from(i) / 40.0));
            let rolls = tooth.tip_roll - tooth.form_roll;
            let flank =
                (0..=40).map(|i| tooth.flank(tooth.form_roll + rolls * f64::from(i) / 40.0));
            for point in fillet.chain(flank) {
                close(material_left_by_rack(pair, &tooth, point), 0.0, 1e-9);
            }
        }
    }
}

#[test]
fn flank_and_fillet_meet_smoothly_and_end_on_their_circles() {
    for pair in [pair([20, 30], 4e-3), shifted([12, 25], [0.5, -0.2])] {
        for index in [0, 1] {
            let tooth = Tooth::new(&pair, index).unwrap();
            let [joint, root] = tooth.fillet_range();
            let (fillet, flank) = (tooth.fillet(joint), tooth.flank(tooth.form_roll));
            close(fillet.x, flank.x, 1e-15);
            close(fillet.y, flank.y, 1e-15);
            close(fillet.dx / fillet.dy, flank.dx / flank.dy, 1e-9);
            close(flank.x.hypot(flank.y), tooth.form_radius, 1e-15);
            let foot = tooth.fillet(root);
            close(foot.x.hypot(foot.y), tooth.root_radius, 1e-15);
            close(foot.x.atan2(foot.y), tooth.root_half_angle, 1e-14);
            let tip = tooth.flank(tooth.tip_roll);
            close(tip.x.hypot(tip.y), tooth.tip_radius, 1e-15);
            // Derivatives are those of the curve.
            for at in [joint + 0.3, joint + 0.8] {
                let step = 1e-6;
                let (before, after) = (tooth.fillet(at - step), tooth.fillet(at + step));
                let point = tooth.fillet(at);
                close((after.x - before.x) / (2.0 * step), point.dx, 1e-11);
                close((after.y - before.y) / (2.0 * step), point.dy, 1e-11);
            }
        }
    }
}

#[test]
fn thickness_is_that_of_the_drawing() {
    let mut pair = shifted([17, 43], [0.4, -0.3]);
    pair.form.thinning = [50e-6, 30e-6];
    for index in [0, 1] {
        let tooth = Tooth::new(&pair, index).unwrap();
        let arc = pair.module
            * (FRAC_PI_2 + 2.0 * pair.form.profile_shift[index] * pair.pressure_angle.tan())
            - pair.form.thinning[index];
        close(tooth.thickness(tooth.reference_radius), arc, 1e-16);
        // The thickness of the profile is the same at any height.
        let point = tooth.flank(0.3);
        let radius = point.x.hypot(point.y);
        close(
            2.0 * radius * (point.x / point.y).atan(),
            tooth.thickness(radius),
            1e-15,
        );
    }
}

#[test]
fn contact_ratios_in_closed_form() {
    // Another program gives 1.78978.
    close(flanks(&pair([62, 62], 2e-3)).contact_ratio(), 1.78978, 1e-5);
    let flanks = flanks(&pair([20, 30], 4e-3));
    let path = flanks.path();
    let length = |radius: f64, base: f64| (radius * radius - base * base).sqrt();
    let cos = 20f64.to_radians().cos();
    let recess = length(44e-3, 40e-3 * cos) - 40e-3 * 20f64.to_radians().sin();
    let approach = length(64e-3, 60e-3 * cos) - 60e-3 * 20f64.to_radians().sin();
    close(path.end, recess, 1e-15);
    close(path.start, -approach, 1e-15);
    close(path.base_pitch, 4e-3 * PI * cos, 1e-17);
    close(
        flanks.contact_ratio(),
        (approach + recess) / path.base_pitch,
        1e-13,
    );
    // Only one pair is in contact from the phase ε − 1 on.
    let [lowest, highest] = path.single_pair().unwrap();
    close(path.phase(lowest), flanks.contact_ratio() - 1.0, 1e-12);
    close(path.phase(highest - 1e-12), 1.0, 1e-9);
    close(path.position(path.phase(0.0)), path.pitch_point, 1e-17);
}

/// Tips are followed beyond both ends of the path, up to the phase with at most three pairs in contact.
#[test]
fn fewer_than_three_pairs_are_within_reach() {
    for addendum in [1.0, 1.2, 1.35] {
        let mut pair = pair([80, 80], 2e-3);
        pair.form.rack.addendum = addendum;
        (pair.form.rack.dedendum, pair.form.rack.tip_radius) = (addendum + 0.25, 0.2);
        let flanks = flanks(&pair);
        let (path, reach) = (flanks.path(), flanks.reach());
        let [before, after] = [path.start - reach[0], reach[1] - path.end];
        close(before, after, 1e-9 * path.base_pitch);
        assert!(before > 0.01 * path.base_pitch, "{addendum}: {before}");
        let pairs = (reach[1] - reach[0]) / path.base_pitch;
        assert!(
            pairs < 2.99 + 1e-9 && pairs > flanks.contact_ratio(),
            "{addendum}: {pairs}"
        );
    }
}

/// Both flanks pass through any point on the line of action.
#[test]
fn flanks_touch_on_the_line_of_action() {
    for pair in [pair([20, 30], 4e-3), shifted([17, 43], [0.4, 0.3])] {
        let flanks = flanks(&pair);
        let (sin, cos) = flanks.pressure_angle.sin_cos();
        let [own, mate] = flanks.operating_pitch_radii;
        close(own + mate, flanks.centre_distance, 1e-16);
        close(
            own / mate,
            f64::from(pair.teeth[0]) / f64::from(pair.teeth[1]),
            1e-14,
        );
        let path = flanks.path();
        for i in 0..=10 {
            let s = path.start + (path.end - path.start) * f64::from(i) / 10.0;
            // The pinion is below and the wheel above the pitch point; the line of action rises with s.
            let (x, y) = (s * cos, s * sin);
            let [t1, t2] = flanks.roll(s);
            close(
                x.hypot(own + y),
                flanks.teeth[0].base_radius * t1.hypot(1.0),
                1e-15,
            );
            close(
                x.hypot(mate - y),
                flanks.teeth[1].base_radius * t2.hypot(1.0),
                1e-15,
            );
            // Compare surface velocities across the line of action at a pinion speed of 1 rad/s.
            let ratio = own / mate;
            let velocity = [own + y, ratio * (mate - y)];
            let along = |horizontal: f64, vertical: f64| horizontal * sin - vertical * cos;
            let slide = along(velocity[0], -x) - along(velocity[1], ratio * x);
            close(slide, flanks.sliding(s), 1e-15);
        }
    }
}

#[test]
fn backlash_is_what_shifts_thinning_and_distance_leave() {
    let tight = shifted([17, 43], [0.4, 0.3]);
    close(flanks(&tight).backlash, 0.0, 1e-15);
    let mut thinned = tight.clone();
    thinned.form.thinning = [40e-6, 25e-6];
    let cos = tight.pressure_angle.cos();
    close(flanks(&thinned).backlash, 65e-6 * cos, 1e-15);
    let mut apart = tight.clone();
    let distance = tight.tight_centre_distance().unwrap() + 0.2e-3;
    apart.form.centre_distance = Some(distance);
    let angle = |pair: &GearPair| pair.operating_pressure_angle().unwrap();
    let base: f64 = tight.base_radii().iter().sum();
    let gap = 2.0 * base * (involute(angle(&apart)) - involute(angle(&tight)));
    close(flanks(&apart).backlash, gap, 1e-15);
    // Tips have the rack's clearance at the centre distance without backlash, and a larger clearance here.
    close(flanks(&tight).clearance[0], 0.25 * tight.module, 1e-15);
    close(
        flanks(&apart).clearance[1],
        0.25 * tight.module + 0.2e-3,
        1e-15,
    );
}

#[test]
fn relief_falls_linearly_from_the_ends_of_contact() {
    let mut pair = pair([20, 30], 4e-3);
    let relief = |amount, length| Relief {
        amount,
        length,
        ..Relief::default()
    };
    pair.form.tip_relief = [relief(12e-6, 3e-3), relief(9e-6, 2e-3)];
    pair.form.root_relief = [relief(4e-6, 1e-3), Relief::default()];
    let flanks = flanks(&pair);
    let path = flanks.path();
    close(flanks.relief(path.end), 12e-6, 1e-20);
    close(flanks.relief(path.end - 1.5e-3), 6e-6, 1e-18);
    assert_eq!(flanks.relief(0.0), 0.0);
    close(flanks.relief(path.start), 13e-6, 1e-20);
    close(
        flanks.relief(path.start + 0.5e-3),
        0.75 * 9e-6 + 2e-6,
        1e-18,
    );
    close(flanks.relief(path.start + 1.5e-3), 0.25 * 9e-6, 1e-18);
}

#[test]
fn drawings_that_do_not_run_say_why() {
    let refuse = |pair: &GearPair| Flanks::new(pair).unwrap_err();
    // The limit of undercut: z/2 sin² α = h_f − ρ (1 − sin α) − x.
    let GearError::Undercut {
        gear: 1,
        shift,
        limit,
        form_diameter,
        active_diameter,
    } = refuse(&pair([12, 30], 4e-3))
    else {
        panic!("not undercut")
    };
    let sin = 20f64.to_radians().sin();
    close(shift, 0.0, 0.0);
    close(limit, 1.25 - 0.38 * (1.0 - sin) - 6.0 * sin * sin, 1e-12);
    let free = Tooth::new(&shifted([12, 30], [limit + 1e-6, 0.0]), 0).unwrap();
    assert_eq!(free.undercut, None);
    // The mate's tip would reach beyond the base circle.
    close(active_diameter, 48e-3 * 20f64.to_radians().cos(), 1e-15);
    assert!(form_diameter > active_diameter);

    let GearError::PointedTip {
        gear: 1,
        tip_diameter,
        limit,
    } = refuse(&shifted([12, 40], [0.9, -0.9]))
    else {
        panic!("not pointed")
    };
    // The tip has the rack's addendum, because the shifts sum to zero.
    close(tip_diameter, 3e-3 * (12.0 + 2.0 + 1.8), 1e-12);
    assert!(limit < tip_diameter);
    let tooth = {
        let mut cut = shifted([12, 40], [0.9, -0.9]);
        cut.form.tip_diameter[0] = Some(limit * (1.0 - 1e-9));
        Tooth::new(&cut, 0).unwrap()
    };
    assert!(tooth.thickness(tooth.tip_radius) < 1e-9);

    let mut long = pair([18, 40], 4e-3);
    long.form.tip_diameter[1] = Some(0.172);
    assert!(matches!(
        refuse(&long),
        GearError::TipInRoot { gear: 2, .. }
    ));
    long.form.tip_diameter[1] = Some(0.1695);
    let GearError::Interference {
        gear: 1,
        active_roll,
        form_roll,
    } = refuse(&long)
    else {
        panic!("no interference")
    };
    assert!(active_roll < form_roll);

    let mut short = pair([20, 30], 4e-3);
    short.form.tip_diameter = [Some(83e-3), Some(123e-3)];
    let GearError::ContactRatio { contact_ratio } = refuse(&short) else {
        panic!("enough contact")
    };
    assert!(contact_ratio < 1.0);

    let mut near = pair([20, 30], 4e-3);
    near.form.centre_distance = Some(99.9e-3);
    let GearError::NegativeBacklash { backlash, .. } = refuse(&near) else {
        panic!("no overlap")
    };
    close(backlash, -2.0 * 0.1e-3 * sin, 1e-6);

    let mut rack = pair([20, 30], 4e-3);
    rack.form.rack.tip_radius = 0.5;
    let GearError::RackTip { tip_radius, limit } = refuse(&rack) else {
        panic!("a tip that is too round")
    };
    close(tip_radius, 0.5, 0.0);
    for (part, runs) in [(1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
        rack.form.rack.tip_radius = limit * part;
        assert_eq!(Tooth::new(&rack, 0).is_ok(), runs);
    }
    let mut tip = pair([20, 30], 4e-3);
    tip.form.tip_diameter[0] = Some(75e-3);
    let GearError::TipBelowForm {
        gear: 1,
        tip_diameter,
        form_diameter,
    } = refuse(&tip)
    else {
        panic!("above the form circle")
    };
    close(tip_diameter, 75e-3, 1e-15);
    for (part, runs) in [(1.0 + 1e-9, true), (1.0 - 1e-9, false)] {
        tip.form.tip_diameter[0] = Some(form_diameter * part);
        assert_eq!(Tooth::new(&tip, 0).is_ok(), runs);
    }
    let mut solid = pair([20, 30], 4e-3);
    solid.form.bore = [Some(30e-3), None];
    assert_eq!(refuse(&solid), GearError::NoBore { gear: 2 });
    // The rim is 2.5 mm thick on a root circle of 110 mm.
    solid.form.bore = [Some(30e-3), Some(105e-3)];
    assert!(matches!(
        refuse(&solid),
        GearError::BodyRatio { gear: 2, .. }
    ));
    let mut soft = pair([20, 30], 4e-3);
    soft.form.material[1].young_modulus = 0.0;
    assert!(matches!(refuse(&soft), GearError::NotPositive { .. }));
    soft.form.material[1].young_modulus = 1e9;
    soft.form.material[1].poisson_ratio = 0.5;
    assert!(matches!(refuse(&soft), GearError::TooLarge { .. }));
    soft.form.material[1].poisson_ratio = 0.3;
    soft.pressure_angle = FRAC_PI_2;
    assert!(matches!(refuse(&soft), GearError::TooLarge { .. }));
    soft.pressure_angle = 20f64.to_radians();
    soft.form.thinning[1] = f64::NAN;
    assert!(matches!(refuse(&soft), GearError::Negative { .. }));
    soft.form.thinning[1] = 0.0;
    soft.form.tip_diameter[1] = Some(f64::NAN);
    assert!(matches!(refuse(&soft), GearError::NotPositive { .. }));
}
