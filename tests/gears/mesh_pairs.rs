//! Pairs of teeth as separate springs: motions compared with thirty digits, and the difference from the tangent at the
//! mean load.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common;
use common::advance::{Events, advance, advance_with, volterra};
use common::relative_difference;
use gearatlas::analysis::{EnergyAudit, Nvh};
use gearatlas::manifest;
use gearatlas::model::{InitialState, Model};
use gearatlas::reference::Extended;
use gearatlas::store::{ResultTable, TableKind};
use std::path::Path;
use std::process::Command;

/// The torsional tier, in which only the mesh is elastic; both gears have tip relief.
const MANIFEST: &str = include_str!("../../manifests/tiers/torsional.toml");

fn manifest(stiffness: &str, rest: &str) -> String {
    let law = [
        "mean_stiffness",
        "contact_ratio",
        "single_pair_drop",
        "segments",
    ];
    let kept = |line: &&str| !law.iter().any(|key| line.starts_with(&format!("{key} =")));
    let lines: Vec<&str> = MANIFEST.lines().filter(kept).collect();
    (lines.join("\n"))
        .replace("rated_torque =", "bore = [\"48 mm\", \"76 mm\"]\ntip_relief = { amount = \"8 um\", length = \"2.5 mm\" }\nrated_torque =")
        .replace(
            "stiffness = \"piecewise\"",
            &format!("contact = \"linear\"\n{stiffness}\n#"),
        )
        + rest
}

fn model(text: &str, speed: f64, load: f64) -> Model {
    let job = manifest::parse(text, "m.toml", Path::new("")).unwrap();
    let mut point = job.points.at(0);
    (point.speed, point.load) = (speed, load);
    common::parts().model(&point).unwrap()
}

/// Pairs enter and leave contact within the cycle. Single cycles agree with thirty digits, including every event and
/// the energy.
#[test]
fn springs_of_pairs_keep_to_thirty_digits() {
    let pairs = "stiffness = \"continuous\"\nresolution = \"pairs\"";
    let askew = format!("{pairs}\nslices = 3\nmisalignment = \"0.3 mrad\"");
    let same_line = format!("{pairs}\ncoast_flank = \"same_line\"");
    let halves = format!("{pairs}\nslices = 2");
    // At the start of a parabola, gaps of pairs are equal within rounding, which must not cut the cycle there.
    let lead = |of: &str| {
        let relief = "length = \"2.5 mm\", course = \"parabolic\" }";
        (manifest(&halves, "").replace("length = \"2.5 mm\" }", relief))
            .replace("\nrated_torque", &format!("\n{of}\nrated_torque"))
    };
    for (text, speed, load) in [
        (manifest(pairs, ""), 1200.0, 0.05),
        (manifest(pairs, ""), 1400.0, 0.3),
        (manifest(pairs, ""), 1000.0, 0.0),
        (manifest(&askew, ""), 1200.0, 0.1),
        (manifest(&same_line, ""), 1200.0, 0.05),
        (lead("lead_slope = \"0.4 um\""), 1000.0, 0.2),
        (
            lead("lead_slope = \"1 um\"\nlead_crowning = \"2 um\""),
            1200.0,
            0.1,
        ),
    ] {
        let model = model(&text, speed, load);
        assert_eq!(model.flank_springs, model.contacts.len());
        assert!(model.flank_springs >= 4);
        let (kernel, exact) = (volterra(&model), Extended::new(&model));
        let mut start = advance(&kernel, &model.start(&InitialState::Static), 20);
        let [mut apart, mut late, mut several] = [0.0_f64, 0.0_f64, 0.0];
        for _ in 0..5 {
            let mut seen = Events::default();
            let (end, _) = advance_with(&kernel, &start, 1, &mut seen);
            let passage = exact.advance(&start, 1).unwrap();
            apart = apart.max(relative_difference(&end.state, &passage.end().state));
            assert_eq!(seen.0.len(), passage.crossings.len());
            for (event, crossing) in seen.0.iter().zip(&passage.crossings) {
                // With slices several contacts close at the same time, when a pair is added.
                let slices = model.flank_springs > 4;
                assert!(slices || (event.from, event.to) == (crossing.from, crossing.to));
                let off = (event.time - crossing.time.value()).abs();
                late = late.max(off / model.period());
                several += f64::from(u8::from(crossing.to.count() > 1));
            }
            start = end;
        }
        let mut audit = EnergyAudit::new(&model);
        let (end, _) = advance_with(&kernel, &start, 50, &mut audit);
        let residual = audit.residual(&end).unwrap();
        println!(
            "{} springs at {speed} rad/s, load {load}: states {apart:.1e}, times {late:.1e}, \
             {several} events with several closed, energy {residual:.1e}",
            model.flank_springs
        );
        assert!(apart < 1e-12 && late < 1e-12, "{apart} {late}");
        assert!(residual < 1e-11, "{residual}");
    }
}

/// If the load hardly varies, pairs act like the tangent at that load.
#[test]
fn pairs_and_tangent_agree_where_the_load_hardly_swings() {
    let rms = |rest: &str| {
        let text = manifest(rest, "").replace("amplitude = \"5 um\"", "amplitude = \"1 nm\"");
        let model = model(&text, 180.0, 1.0);
        let kernel = volterra(&model);
        let start = advance(&kernel, &model.start(&InitialState::Static), 300);
        let mut nvh = Nvh::new(&model, 0);
        advance_with(&kernel, &start, 50, &mut nvh);
        nvh.outcome().unwrap().values.deflection_rms
    };
    let [tangent, pairs] = ["mean_load", "pairs"].map(|law| {
        rms(&format!(
            "stiffness = \"continuous\"\nresolution = \"{law}\""
        ))
    });
    println!("RMS {tangent:e} of the tangent, {pairs:e} of pairs");
    assert!((pairs / tangent - 1.0).abs() < 0.05, "{tangent} {pairs}");
}

/// If rattle covers all loads from zero to the full load, pairs and tangent differ; the test prints the difference.
#[test]
fn pairs_change_what_rattles() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, rest: &str| {
        let text = manifest(&format!("stiffness = \"continuous\"{rest}"), "");
        std::fs::write(folder.path().join(name), text).unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
            .args(["run", name, "--out", &format!("{name}.d"), "--quiet"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 3)), "{said}");
        let out = folder.path().join(format!("{name}.d"));
        let table = ResultTable::read(&out, TableKind::Points).unwrap();
        ["deflection_rms", "force_peak", "lambda_max"].map(|column| table.f64(column).unwrap())
    };
    let tangent = run("tangent.toml", "\nresolution = \"mean_load\"");
    let pairs = run("pairs.toml", "\nresolution = \"pairs\"");
    for (column, (a, b)) in ["RMS", "force", "lambda"]
        .iter()
        .zip(tangent.iter().zip(&pairs))
    {
        println!("{column}: tangent {a:?}, pairs {b:?}");
    }
    assert!(pairs[0].iter().all(|rms| rms.unwrap() > 0.0));
    assert_ne!(tangent[0], pairs[0]);
}

/// Every key that is incompatible with pairs is named with a remedy.
#[test]
fn what_pairs_do_not_take_is_said() {
    let pairs = "stiffness = \"continuous\"\nresolution = \"pairs\"";
    for (stiffness, key) in [
        (
            format!("{pairs}\nmisalignment = \"0.3 mrad\""),
            "mesh.misalignment",
        ),
        (format!("{pairs}\nshaft_tilt = true"), "mesh.shaft_tilt"),
        (
            "stiffness = \"continuous\"\nslices = 3".to_owned(),
            "mesh.slices",
        ),
        (
            "stiffness = \"constant\"\nmean_stiffness = 4e8\nresolution = \"pairs\"".to_owned(),
            "mesh.resolution",
        ),
    ] {
        let said = match manifest::parse(&manifest(&stiffness, ""), "m.toml", Path::new("")) {
            Ok(job) => format!("{:?}", job.warnings),
            Err(errors) => format!("{errors:?}"),
        };
        assert!(said.contains(key), "{key}: {said}");
    }
    // A misalignment of 0 counts as none.
    let straight = manifest(&format!("{pairs}\nmisalignment = 0"), "");
    assert!(manifest::parse(&straight, "m.toml", Path::new("")).is_ok());
}

/// Sixteen springs are the maximum, which four slices of two pairs need.
#[test]
fn slices_have_room_beside_each_other() {
    let pairs = "stiffness = \"continuous\"\nresolution = \"pairs\"";
    let text = |slices: u32| manifest(&format!("{pairs}\nslices = {slices}"), "");
    // With more and longer teeth three pairs are in contact at once.
    let many = |slices: u32| {
        (text(slices).replace("teeth = [20, 30]", "teeth = [62, 62]"))
            .replace("module = \"4 mm\"", "module = \"2 mm\"")
    };
    let parse = |text: &str| manifest::parse(text, "m.toml", Path::new(""));
    model(&text(4), 1200.0, 0.3);
    model(&many(2), 1200.0, 0.3);
    for (text, words) in [(text(5), "from 1 to 4"), (many(3), "18 springs")] {
        let said = format!("{}", parse(&text).unwrap_err());
        assert!(said.contains(words), "{said}");
    }
}

/// Springs on several lines cannot share a residual flexibility; on one slice they can.
#[test]
fn slices_and_residual_flexibility_do_not_go_together() {
    let text = |slices: u32, reduction: &str| {
        include_str!("../../manifests/flex80-table.toml")
            .replace("resolution = \"mean_load\"", "resolution = \"pairs\"")
            .replace("stiffness = \"table\"", "stiffness = \"continuous\"")
            .replace("segments = 60", &format!("slices = {slices} #"))
            .replace("retained = 40", &format!("{reduction} #"))
    };
    let parse = |text: &str| manifest::parse(text, "m.toml", Path::new(""));
    let said = format!(
        "{:?}",
        parse(&text(3, "retained = 12\nmta = true")).unwrap_err()
    );
    assert!(said.contains("model.mta"), "{said}");
    for text in [
        text(1, "retained = 12\nmta = true"),
        text(3, "retained = 12"),
        text(3, "mta = true"),
    ] {
        assert!(parse(&text).is_ok());
    }
}

/// On equal gears breakpoints of the coast flanks fall on borders of windows within round-off, which leaves windows of
/// 1e-20 s. These change neither the motion, compared with thirty digits, nor the balance of energy.
#[test]
fn windows_of_no_length_do_no_work() {
    for speed in [540.0, 562.8358768273444] {
        let job = manifest::parse(UNITY, "m.toml", Path::new("")).unwrap();
        let mut point = job.points.at(0);
        point.speed = speed;
        let model = common::parts().model(&point).unwrap();
        let kernel = volterra(&model);
        let start = advance(&kernel, &model.start(&InitialState::Static), 150);
        let passage = Extended::new(&model).advance(&start, 1).unwrap();
        let mut audit = EnergyAudit::new(&model);
        let (end, _) = advance_with(&kernel, &start, 1, &mut audit);
        let apart = relative_difference(&end.state, &passage.end().state);
        let residual = audit.residual(&end).unwrap();
        println!("{speed} rad/s: states {apart:.1e}, energy {residual:.1e}");
        assert!(apart < 1e-12, "{apart}");
        assert!(residual < 1e-13, "{residual}");
    }
}

/// Spur gears of 50 teeth each on a torsional drive.
const UNITY: &str = r#"
[job]
name = "unity"
[model]
kind = "torsional"
[gear]
teeth = [50, 50]
module = "3 mm"
face_width = "20 mm"
body_length = ["20 mm", "20 mm"]
bore = "60 mm"
rated_torque = "340 N*m"
centre_distance = "150 mm"
thinning = "72 um"
[shafts]
density = "7850 kg/m^3"
span = "120 mm"
overhang = "40 mm"
[shafts.pinion]
diameter = "30 mm"
end_inertia = 0
[shafts.wheel]
diameter = "30 mm"
end_inertia = 0
[mesh]
stiffness = "table"
resolution = "pairs"
contact_damping = 0.03
[grid]
torque = "85 N*m"
speed = 562.8358768273444
[run]
transient = 200
cycles = 600
"#;
