//! Orbits near a period doubling, which attract more and more slowly: an oscillator in a gap under a torque ripple
//! whose period doubles at an amplitude of 19.732 05 (where the exponent of the orbit of one cycle is 0).

#![allow(clippy::unwrap_used)]

use crate::place;
use gearatlas::store::{ResultTable, TableKind};
use place::{Place, status, stderr};
use std::fs;

const DOUBLING: f64 = 19.732_05;

const MANIFEST: &str = r#"
[job]
name = "doubling"

[model]
kind = "modal"
file = "one.modal.toml"

[mesh]
half_gap = 0.6
stiffness = "constant"
mean_stiffness = 200
contact_damping = 0

[excitation]
torque_ripple = [{ shaft = "pinion", order = 1, amplitude = 19.7, phase = 3.0463883736829134 }]

[grid]
load = 7.5398223686155035
speed = 6.283185307179586
"excitation.torque_ripple.0.amplitude" = { from = 19.726, to = 19.744, count = 19 }

[run]
transient = 300
cycles = 2000

[analyses]
lyapunov = { exponents = 2, twin = false }
poincare = { samples = 2 }
"#;

const STRUCTURE: &str = "teeth = 1\nrated_force = 1.0\nfrequency = [0.0]\ndamping = [0.0]\n\
                         damping_matrix = [[0.6]]\nmesh = [1.0]\ntorque = [1.0]\ntorque_pinion = [1.0]\n";

/// Every point is on the attracting orbit, with the exponent of that orbit: that of one cycle rises linearly through 0,
/// and that of two falls twice as steeply.
fn holds(order: &str) {
    let manifest = match order {
        "independent" => MANIFEST.to_owned(),
        order => MANIFEST.replace("[run]", &format!("order = \"{order}\"\n\n[run]")),
    };
    let place = Place::new(&manifest);
    fs::write(place.path("one.modal.toml"), STRUCTURE).unwrap();
    let output = place.run("r", &["--quiet"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let table = ResultTable::read(&place.path("r"), TableKind::Points).unwrap();
    let amplitudes = table.f64("excitation.torque_ripple.0.amplitude").unwrap();
    let (classes, periods) = (table.text("class").unwrap(), table.u64("period").unwrap());
    let (exponents, reasons) = (
        table.f64("lambda_max").unwrap(),
        table.text("reason").unwrap(),
    );
    assert!(table.rows() >= 19);
    for row in 0..table.rows() {
        let amplitude = amplitudes[row].unwrap();
        let reason = reasons[row].as_deref().unwrap();
        let past = amplitude - DOUBLING;
        let (period, slope) = if past > 0.0 { (2, -2.0) } else { (1, 1.0) };
        assert_eq!(
            classes[row].as_deref(),
            Some("periodic"),
            "{amplitude}: {reason}"
        );
        assert_eq!(periods[row], Some(period), "{amplitude}: {reason}");
        let expected = slope * 0.0466 * past;
        let found = exponents[row].unwrap();
        assert!(
            (found - expected).abs() < 0.05 * expected.abs() + 2e-7,
            "{amplitude}: {found} instead of {expected}: {reason}"
        );
    }
}

#[test]
fn points_are_on_the_orbit_that_attracts_them() {
    holds("independent");
}

#[test]
fn chains_are_on_the_orbit_that_attracts_them_from_either_side() {
    holds("both");
}
