//! Time of one cycle of the first mesh over the number of meshes: a gearbox of two flexible shafts with one to six
//! pairs, whose second gears are loose and braked. Two kernels, in rattle with and without torque ripple.
//!
//! ```text
//! cargo bench --bench meshes
//! ```

// Criterion's macros generate undocumented items; a bench may unwrap, like a test.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;

use common::advance::{advance, volterra};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, criterion_group, criterion_main};
use gearatlas::manifest;
use gearatlas::model::{InitialState, Model};
use gearatlas::propagate::{ClosedModes, Counters, InstructionSet, Kernel, Tangents};
use std::hint::black_box;
use std::path::Path;

/// Teeth of each pair, with sum 60.
const PAIRS: [[u32; 2]; 6] = [[20, 40], [25, 35], [30, 30], [35, 25], [40, 20], [24, 36]];

fn gearbox(meshes: usize, ripple: f64) -> Model {
    let bearings = "[{ at = 0, x = 1.5e8, y = 1.2e8, axial = 1e8, tilt = 1e4 }, \
                    { at = 0.18, x = 1.5e8, y = 1.2e8 }]";
    let pairs = PAIRS[..meshes].iter().enumerate();
    let gear = |name: &str, index: usize, teeth: u32, rest: &str| {
        let at = 0.02 + 0.025 * index as f64;
        format!(
            "{{ name = \"{name}{index}\", at = {at}, teeth = {teeth}, module = 2.5e-3, width = 0.02{rest} }}"
        )
    };
    let loose =
        ", loose = { x = 2e8, y = 2e8, axial = 1e8, tilt = 1e4, drag = 1e-3, drag_torque = 0.3 }";
    let [fixed, free] = [("a", ""), ("b", loose)].map(|(name, rest)| {
        let gears = pairs.clone().map(|(index, teeth)| {
            let of = usize::from(name == "b");
            gear(name, index, teeth[of], rest)
        });
        gears.collect::<Vec<_>>().join(", ")
    });
    let further: String = (1..meshes)
        .map(|index| {
            format!(
                "[[train.mesh]]\ngears = [\"a{index}\", \"b{index}\"]\nhalf_gap = 2e-5\n\
                 levels = [3e8, 2.4e8]\ndamping = 800\ncoast_symmetry = 0.3\n"
            )
        })
        .collect();
    let text = format!(
        "[job]\nname = \"gearbox\"\n[model]\nkind = \"train\"\nmodes = 24\n\
         [train]\ngears = [\"a0\", \"b0\"]\nrated_torque = 50\n\
         [[train.shaft]]\nname = \"input\"\nsections = [{{ length = 0.18, outer = 0.03 }}]\n\
         discs = [{{ at = 0, polar_inertia = 0.02 }}]\nbearings = {bearings}\ngears = [{fixed}]\n\
         [[train.shaft]]\nname = \"output\"\norigin = [0.075, 0, 0]\nmotion = \"lateral\"\n\
         sections = [{{ length = 0.18, outer = 0.03 }}]\nbearings = {bearings}\ngears = [{free}]\n\
         {further}\
         [mesh]\nhalf_gap = 2e-5\nstiffness = \"piecewise\"\nvalues = [3e8, 2.4e8]\n\
         contact_damping = \"800 N*s/m\"\ncoast_symmetry = 0.3\n\
         [excitation]\ntransmission_error = [{{ harmonic = 1, amplitude = 3e-6 }}]\n\
         torque_ripple = [{{ shaft = \"pinion\", order = 2, amplitude = {ripple} }}]\n\
         [grid]\nload = 0\nspeed = 300\n"
    );
    let job =
        manifest::parse(&text, "gearbox.toml", Path::new("")).unwrap_or_else(|e| panic!("{e}"));
    common::parts().model(&job.points.at(0)).unwrap()
}

fn meshes(criterion: &mut Criterion) {
    for (name, ripple) in [("ripple", 20.0), ("no ripple", 0.0)] {
        for count in 1..=PAIRS.len() {
            let model = gearbox(count, ripple);
            let scene = format!("{name}, {count} meshes");
            let mut group = criterion.benchmark_group(&scene);
            cycles(&mut group, &scene, "volterra", &model, &volterra(&model));
            let closed_modes = ClosedModes::new(&model, 1000, InstructionSet::best()).unwrap();
            cycles(&mut group, &scene, "closed_modes", &model, &closed_modes);
            group.finish();
        }
    }
}

/// Times the cycles of a kernel and prints their work.
fn cycles<K: Kernel>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    scene: &str,
    name: &str,
    model: &Model,
    kernel: &K,
) {
    let mut trajectory = advance(kernel, &model.start(&InitialState::Static), 200);
    let mut tangents = Tangents::zeros(model.modes(), 0);
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    group.bench_function(name, |bench| {
        bench.iter(|| {
            let trajectory = black_box(&mut trajectory);
            let (tangents, workspace) = (&mut tangents, &mut workspace);
            kernel
                .advance_cycle(trajectory, tangents, workspace, &mut (), &mut counters)
                .unwrap();
        });
    });
    let cycles = counters.cycles as f64;
    println!(
        "{scene}, {name}: {:.1} windows and {:.2} events a cycle",
        counters.windows as f64 / cycles,
        counters.events as f64 / cycles
    );
}

criterion_group!(benches, meshes);
criterion_main!(benches);
