//! Analyses of motions that the paper's kernels integrate.

use crate::common::advance::{advance, volterra};
use crate::common::{self, relative_difference};
use crate::leaps::{agrees, loaded};
use gearatlas::analysis::{Status, investigate};
use gearatlas::manifest;
use gearatlas::model::{InitialState, TrajectoryState};
use gearatlas::propagate::{Counters, Event, Interruptible, Kernel, Observer, Stop, Window};
use gearatlas::reference::Extended;
use gearatlas_paper::kernels::{Dyadic, Fused, Hermite, Spectral};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

const CELLS: u32 = 60;

#[test]
fn a_jump_is_where_marching_comes_to() {
    for (name, case) in common::drives() {
        let model = common::model(&loaded(case));
        let cycles = 1000 + 50 * model.modes() as u64;
        let spectral = Spectral::new(&model, CELLS, 99, None).unwrap();
        agrees(name, &model, &spectral, cycles);
        agrees(
            name,
            &model,
            &Fused::new(&model, CELLS, 99).unwrap(),
            cycles,
        );
    }
}

/// A start that counts as diverged before anything has moved is told as such; within the bound motion is integrated.
#[test]
fn a_start_out_of_range_is_told_as_such() {
    let model = common::model_at(&common::one_degree(), 0.3, 1200.0);
    let kernel = Spectral::new(&model, CELLS, 1000, None).unwrap();
    let put = |half_gaps: f64| {
        let mut start = model.start(&InitialState::Rest);
        let felt = model.first_gains()[0].deflection[0];
        start.state[0] = half_gaps * model.half_gap / felt;
        let start = TrajectoryState::new(&model, start.state, 0);
        let asked = crate::row::questions(10, 50);
        investigate(&model, &kernel, start, &asked, &AtomicBool::new(false)).unwrap()
    };
    let far = put(-1e10);
    assert_eq!((&far.status, far.cycles), (&Status::Diverged, 0));
    let reason = &far.reason;
    assert!(
        reason.contains("1.0e10") && reason.contains("run.initial"),
        "{reason}"
    );
    let near = put(1e3);
    assert!(
        near.cycles > 0 && !near.reason.contains("run.initial"),
        "{near:?}"
    );
}

/// Raises a flag when it is shown the third window.
struct Raising<'a>(u64, &'a AtomicBool);

impl Observer for Raising<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, _: &Window<'_>) {
        self.0 += 1;
        self.1.store(self.0 == 3, Ordering::Relaxed);
    }

    fn event(&mut self, _: &Event) {}
}

#[test]
fn an_integration_ends_within_the_cycle_in_which_it_is_called_off() {
    for (name, case) in common::drives() {
        let model = common::model(&case);
        let spectral = Spectral::new(&model, 64, 1000, None).unwrap();
        let (flag, never) = (AtomicBool::new(false), AtomicBool::new(false));
        let [shown, whole] = [&flag, &never].map(|watched| {
            let kernel = Interruptible::new(&spectral, watched);
            let mut raising = Raising(0, &flag);
            let ended = kernel.advance(
                1,
                &mut model.start(&InitialState::Static),
                &mut kernel.workspace(),
                &mut raising,
                &mut Counters::default(),
            );
            let off = matches!(ended, Err(Stop::CalledOff { cycle: 0 }));
            assert_eq!(off, std::ptr::eq(watched, &flag));
            raising.0
        });
        assert!(shown == 3 && whole > 3, "{name}: {shown} of {whole}");
    }
}

/// Errors that turn by a fraction a mesh cycle, through rattle, against thirty digits.
#[test]
fn fractional_turns_are_followed() {
    let error = "[excitation]\ngear_error = [{ shaft = \"pinion\", order = 1, amplitude = \"2 um\" }, \
                 { shaft = \"wheel\", order = 7, amplitude = \"1 um\", phase = \"1 rad\" }]";
    let text = include_str!("../../../../manifests/tiers/torsional.toml")
        .replace("[mesh]", "[mesh]\ncoast_flank = \"same_line\"")
        .replace("[excitation]", error);
    let job = manifest::parse(&text, "m.toml", Path::new("")).unwrap();
    let mut point = job.points.at(0);
    (point.speed, point.load) = (1200.0, 0.05);
    let model = common::parts().model(&point).unwrap();
    let start = advance(&volterra(&model), &model.start(&InitialState::Static), 37);
    let exact = Extended::new(&model)
        .advance(&start, 1)
        .unwrap()
        .end()
        .state;
    fn off<K: Kernel>(kernel: &K, start: &TrajectoryState, exact: &[f64]) -> f64 {
        relative_difference(&advance(kernel, start, 1).state, exact)
    }
    for (name, off) in [
        (
            "dyadic",
            off(&Dyadic::new(&model, CELLS, 1000).unwrap(), &start, &exact),
        ),
        (
            "hermite",
            off(&Hermite::new(&model, CELLS, 1000).unwrap(), &start, &exact),
        ),
        (
            "spectral",
            off(
                &Spectral::new(&model, CELLS, 1000, None).unwrap(),
                &start,
                &exact,
            ),
        ),
        (
            "fused",
            off(&Fused::new(&model, CELLS, 1000).unwrap(), &start, &exact),
        ),
    ] {
        assert!(off < 1e-10, "{name}: {off:e}");
    }
}
