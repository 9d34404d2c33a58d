use crate::gear::{EvenSharing, Flanks, GearPair, Tooth, ToothForm, fixtures, standard_symmetry};

fn pair(teeth: [u32; 2], shift: [f64; 2], thinning: [f64; 2], more: f64) -> GearPair {
    let form = ToothForm {
        profile_shift: shift,
        thinning,
        bore: teeth.map(|z| Some(1.6e-3 * f64::from(z))),
        ..ToothForm::default()
    };
    let mut pair = fixtures::pair(teeth, form);
    if more > 0.0 {
        pair.form.centre_distance = Some(pair.tight_centre_distance().unwrap() + more);
    }
    pair
}

fn pairs() -> Vec<GearPair> {
    vec![
        pair([20, 30], [0.0; 2], [0.0; 2], 0.0),
        pair([24, 24], [0.0; 2], [0.0; 2], 0.0),
        pair([20, 30], [0.3, -0.1], [0.0; 2], 0.0),
        pair([23, 57], [0.2, 0.4], [60e-6, 20e-6], 50e-6),
        recess_action(),
    ]
}

/// The wheel's tip circle is inside its pitch circle, so that contact begins after the pitch point.
fn recess_action() -> GearPair {
    let mut pair = pair([30, 50], [1.0, -1.0], [0.0; 2], 0.0);
    pair.form.tip_diameter[1] = Some(199.2e-3);
    pair
}

/// Intersection of the flank of a pinion's tooth with the line `(lean sin α_w, cos α_w)` through the pitch
/// point, as a distance from that point \[m\]. `side` is +1 for the leading flank, −1 for the trailing one.
/// The tooth's centre line is turned by `angle` \[rad\] past the line of centres.
fn place_on_line(pair: &GearPair, side: f64, lean: f64, angle: f64) -> f64 {
    let tooth = Tooth::new(pair, 0).unwrap();
    let (sin, cos) = pair.operating_pressure_angle().unwrap().sin_cos();
    let pitch_radius = pair.operating_pitch_radii().unwrap()[0];
    let point = |roll: f64| {
        let flank = tooth.flank(roll);
        // x along the line of centres, y across it; the tooth points along x at angle 0.
        let (along, across) = (flank.y, side * flank.x);
        let (s, c) = angle.sin_cos();
        [along * c - across * s, along * s + across * c]
    };
    // Distance from the line, which is tangent to the base circle.
    let flank_position = |roll: f64| {
        let [x, y] = point(roll);
        (x - pitch_radius) * cos - lean * y * sin
    };
    let (mut low, mut high) = (tooth.form_roll, tooth.tip_roll);
    let rises = flank_position(high) > flank_position(low);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if (flank_position(middle) > 0.0) == rises {
            high = middle
        } else {
            low = middle
        }
    }
    let [x, y] = point(low);
    assert!(flank_position(low).abs() < 1e-15, "not on the line");
    (x - pitch_radius) * lean * sin + y * cos
}

#[test]
fn flanks_of_a_tooth_meet_both_lines_at_mirror_images() {
    for pair in pairs() {
        let path = Flanks::new(&pair).unwrap().path();
        let symmetry = pair.symmetry().unwrap();
        let cycle = std::f64::consts::TAU / f64::from(pair.teeth[0]);
        for turned in [-0.2, -0.05, 0.0, 0.1, 0.25] {
            let at = |cycles: f64| place_on_line(&pair, 1.0, 1.0, cycles * cycle);
            // The tooth is on the line of centres at this phase of the drive flanks.
            let phase = path.phase(at(turned)) - turned - symmetry;
            let off = (phase + 0.25).rem_euclid(0.5) - 0.25;
            assert!(off.abs() < 1e-12, "{:?}: {off}", pair.teeth);
            let coast = place_on_line(&pair, -1.0, -1.0, turned * cycle);
            let image = -at(-turned);
            assert!((coast - image).abs() < 1e-14, "{coast} {image}");
        }
    }
}

#[test]
fn the_path_begins_at_the_wheel_s_tip() {
    for pair in pairs() {
        let flanks = Flanks::new(&pair).unwrap();
        let start = flanks.path().start;
        assert!((pair.approach().unwrap() + start).abs() < 1e-16);
        let (sin, cos) = flanks.pressure_angle.sin_cos();
        let [pinion, _] = flanks.operating_pitch_radii;
        let from_wheel = (pinion + start * sin - flanks.centre_distance).hypot(start * cos);
        assert!((from_wheel - flanks.teeth[1].tip_radius).abs() < 1e-15);
    }
}

#[test]
fn coast_flanks_of_a_standard_pair_follow_half_a_cycle_later() {
    // Equal gears: approach equals recess, tooth equals space.
    let pair = pair([24, 24], [0.0; 2], [0.0; 2], 0.0);
    let ratio = Flanks::new(&pair).unwrap().contact_ratio();
    let symmetry = pair.symmetry().unwrap();
    assert!((symmetry - standard_symmetry(ratio)).abs() < 1e-14);
    // Two pairs from 0 to ε − 1; their mirror image ends at 2 symmetry.
    let off = 2.0 * symmetry - (ratio - 1.0) - 0.5;
    assert!((off - off.round()).abs() < 1e-14, "{off}");
}

/// Pairs of a full recess action slide in one direction only.
#[test]
fn the_path_may_begin_after_the_pitch_point() {
    let pair = recess_action();
    let path = Flanks::new(&pair).unwrap().path();
    assert!(path.start > 0.0);
    let even = EvenSharing::new(&pair).unwrap();
    assert!((even.contact_ratio - path.contact_ratio()).abs() < 1e-14);
    assert!((even.pitch_phase * even.base_pitch + path.start).abs() < 1e-16);
    for step in 0..20 {
        let direction = even.at(f64::from(step) / 20.0).direction;
        assert!((direction + 1.0).abs() < 1e-14, "{direction}");
    }
}
