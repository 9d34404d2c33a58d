//! A geared pair with backlash on damped bearings, from a manifest, compared with the reference means in the test of
//! another program: ROSS (petrobras/ross, `test_mesh_with_backlash`), five revolutions from rest in steps of 1e-5 s by
//! Newmark's method. Its angles and centre distance are those of the displaced shafts; here they are the nominal ones,
//! which changes the deflection by 1e-3.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance_with, volterra};
use gearatlas::manifest;
use gearatlas::propagate::{Observer, Window};
use std::path::Path;

/// Mean transmission error as the other program defines it, without the error \[m\].
const DEFLECTION: f64 = 7.152756140961932e-05;
/// Mean half gap \[m\], which grows as the shafts separate.
const HALF_GAP: f64 = 6.497875817066328e-05;
/// Mean mesh force \[N\].
const FORCE: f64 = 3191.99620748778;
/// Mean distance of the shafts \[m\].
const CENTRE_DISTANCE: f64 = 0.20004375431223567;

/// Integrals over time.
#[derive(Default)]
struct Means {
    /// Integral of the mesh deflection \[m s\].
    deflection: f64,
    /// Integrals of the forces of drive and coast flanks (negative) \[N s\].
    force: [f64; 2],
}

impl Observer for Means {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        // The first coefficient of a Legendre series is its mean.
        self.deflection += window.duration * window.deflection[0];
        for closed in window.closed {
            self.force[closed.contact] += window.duration * closed.force[0];
        }
    }
}

#[test]
fn means_of_a_geared_pair_from_rest() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/manifests");
    let job = manifest::load(&folder.join("geared-pair.toml")).unwrap();
    let point = job.points.first().unwrap();
    let model = common::parts().model(&point).unwrap();
    let cycles = 100u32;
    let time = f64::from(cycles) * model.period();
    assert!((time - 0.3).abs() < 1e-12);
    let mut means = Means::default();
    let start = model.start(&point.run.initial);
    let (end, counters) = advance_with(&volterra(&model), &start, cycles.into(), &mut means);
    assert!(counters.events > 2, "{} events", counters.events);

    // Take the mean of q'' + 2 zeta omega q' + omega^2 q = -sum of g F from rest, for x of both gears.
    let [position, velocity] = model.basis.modes(&end.state);
    let inverse_root_mass = 6.57f64.sqrt().recip();
    let [pinion, wheel] = [2, 4].map(|mode| {
        let (omega, ratio) = (3901.3715732, 0.00999999561644);
        let pushed: f64 = (model.contacts.iter().zip(means.force))
            .map(|(contact, force)| {
                let segment = &contact.cycles[0].segments[0];
                model.gains(segment)[mode].mesh_input[1] * force
            })
            .sum();
        let left = velocity[mode] + 2.0 * ratio * omega * position[mode];
        -inverse_root_mass * (pushed + left) / (omega * omega) / time
    });
    let sin = 20f64.to_radians().sin();
    let apart = wheel - pinion;
    // The deflection of this program contains an additional sin(alpha) (x_pinion - x_wheel).
    let deflection = means.deflection / time + sin * apart;
    let found = [
        ("deflection", deflection, DEFLECTION, 2e-3),
        ("half gap", model.half_gap + sin * apart, HALF_GAP, 2e-3),
        (
            "force",
            (means.force[0] + means.force[1]) / time,
            FORCE,
            1e-3,
        ),
        ("centre distance", 0.2 + apart, CENTRE_DISTANCE, 1e-6),
    ];
    for (name, found, published, tolerance) in found {
        let error = found / published - 1.0;
        println!("{name}: {found:e}, {error:.1e} off");
        assert!(error.abs() < tolerance, "{name}: {found:e} {error:e}");
    }
}
