//! Analyses of motions with the paper's kernels.

use crate::common::advance::{advance, cut_short, volterra};
use crate::common::{self, relative_difference};
use crate::leaps::{agrees, loaded};
use gearatlas::manifest;
use gearatlas::model::{InitialState, TrajectoryState};
use gearatlas::propagate::Kernel;
use gearatlas::reference::Extended;
use gearatlas_paper::kernels::{Dyadic, Fused, Hermite, Spectral};
use std::path::Path;

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

#[test]
fn an_integration_ends_within_the_cycle_in_which_it_is_called_off() {
    for (name, case) in common::drives() {
        let model = common::model(&case);
        let spectral = Spectral::new(&model, 64, 1000, None).unwrap();
        let [shown, whole] = cut_short(&model, &spectral);
        assert!(shown == 3 && whole > 3, "{name}: {shown} of {whole}");
    }
}

/// Errors with a fractional number of periods per mesh cycle, through rattle, compared with thirty digits.
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
