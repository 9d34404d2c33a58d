//! Rattle by every kernel: Tables 2 to 4 and Figure 3 of the paper.

use super::rounds::{Contender, race};
use super::scenes::{self, Case, drive, model_of, settled};
use gearatlas_core::analysis::{EnergyNorm, Nvh};
use gearatlas_core::model::{Division, Model, TrajectoryState};
use gearatlas_core::propagate::{Counters, Kernel, Observer, Stepping, Volterra};
use gearatlas_paper::attachment::with_attachment_modes;
use gearatlas_paper::kernels::{Dyadic, Fused, Hermite, Spectral, TableSize};
use gearatlas_verify::reference::Reference;
use serde_json::{Map, Value, json};
use std::f64::consts::TAU;
use std::hint::black_box;

/// Unit steps per mesh cycle, as published.
pub const CELLS: u32 = 60;

/// Largest number of events in a mesh cycle.
pub const LIMIT: u32 = 1000;

/// Cycles over which the RMS deflection is averaged; the work of kernels is counted over a sixth of them (20
/// for `stepping`).
const COUNTED_CYCLES: u64 = 3000;

/// Number of cycles in which `Spectral` is compared with the other integrators.
const COMPARED_CYCLES: usize = 12;

/// Sixty different levels of stiffness, so that no two segments share a table.
pub fn sixty_levels(mut case: Case) -> Case {
    let levels: Vec<f64> = (0..60)
        .map(|i| {
            let phase = (f64::from(i) + 0.5) / 60.0;
            // The slope makes the levels of the falling half differ from those of the rising half.
            4e8 * (1.0 + 0.14 * (TAU * phase).sin() + 0.01 * phase)
        })
        .collect();
    case.1.mesh = Division::levels(&levels, &[]);
    case
}

/// Twenty modes, and attachment modes with the flexibility and a part of the inertia of the others.
fn attached(count: usize) -> Case {
    let mut case = sixty_levels(drive(40, 0.05, 1200.0));
    case.0 = with_attachment_modes(&case.0, 20, count).expect("20 of 40 modes");
    case
}

fn twenty(residual: bool) -> Case {
    let mut case = sixty_levels(drive(40, 0.05, 1200.0));
    case.0 = case.0.truncated(20, residual).expect("20 of 40 modes");
    case
}

/// A kernel of any type.
pub trait AnyKernel {
    /// A function that advances a separate trajectory by one mesh cycle per call.
    fn cycle<'a>(&'a self, start: &TrajectoryState) -> Box<dyn FnMut() + 'a>;
    /// Advances some cycles; returns the final state and the counted work.
    fn go(&self, start: &TrajectoryState, cycles: u64) -> (TrajectoryState, Counters);
    /// RMS of the deflection over some cycles \[m\].
    fn deflection_rms(&self, model: &Model, start: &TrajectoryState, cycles: u64) -> f64;
}

fn advance<K: Kernel>(
    kernel: &K,
    trajectory: &mut TrajectoryState,
    workspace: &mut K::Workspace,
    observer: &mut impl Observer,
    counters: &mut Counters,
) {
    kernel
        .advance(1, trajectory, workspace, observer, counters)
        .expect("the default drive does not diverge");
}

impl<K: Kernel> AnyKernel for K {
    fn cycle<'a>(&'a self, start: &TrajectoryState) -> Box<dyn FnMut() + 'a> {
        let (mut trajectory, mut workspace) = (start.clone(), self.workspace());
        let mut counters = Counters::default();
        Box::new(move || {
            let trajectory = black_box(&mut trajectory);
            advance(self, trajectory, &mut workspace, &mut (), &mut counters);
        })
    }

    fn go(&self, start: &TrajectoryState, cycles: u64) -> (TrajectoryState, Counters) {
        let (mut trajectory, mut workspace) = (start.clone(), self.workspace());
        let mut counters = Counters::default();
        for _ in 0..cycles {
            advance(
                self,
                &mut trajectory,
                &mut workspace,
                &mut (),
                &mut counters,
            );
        }
        (trajectory, counters)
    }

    fn deflection_rms(&self, model: &Model, start: &TrajectoryState, cycles: u64) -> f64 {
        let (mut trajectory, mut workspace) = (start.clone(), self.workspace());
        let (mut nvh, mut counters) = (Nvh::new(model, 0), Counters::default());
        for _ in 0..cycles {
            advance(
                self,
                &mut trajectory,
                &mut workspace,
                &mut nvh,
                &mut counters,
            );
        }
        nvh.outcome()
            .map_or(f64::NAN, |nvh| nvh.values.deflection_rms)
    }
}

/// A kernel with its name and the size of its tables.
pub type Named<'m> = (String, Option<TableSize>, Box<dyn AnyKernel + 'm>);

/// Kernels of a model by name.
pub fn kernels<'m>(model: &'m Model, names: &[&str]) -> Vec<Named<'m>> {
    let named = |name: &&str| -> Named<'m> {
        let (size, kernel): (Option<TableSize>, Box<dyn AnyKernel + 'm>) = match *name {
            "dyadic" => {
                let kernel = Dyadic::new(model, CELLS, LIMIT).expect("tables");
                (Some(kernel.bytes()), Box::new(kernel))
            }
            "hermite" => {
                let kernel = Hermite::new(model, CELLS, LIMIT).expect("tables");
                (Some(kernel.bytes()), Box::new(kernel))
            }
            "spectral" => {
                let kernel = Spectral::new(model, CELLS, LIMIT, None).expect("tables");
                (Some(kernel.bytes()), Box::new(kernel))
            }
            "spectral, longest cells" => {
                let kernel = Spectral::new(model, 1, LIMIT, None).expect("tables");
                (Some(kernel.bytes()), Box::new(kernel))
            }
            "spectral, single precision" => {
                let kernel = Spectral::in_single_precision(model, CELLS, LIMIT).expect("tables");
                (None, Box::new(kernel))
            }
            "fused" => {
                let kernel = Fused::new(model, CELLS, LIMIT).expect("tables");
                (Some(kernel.bytes()), Box::new(kernel))
            }
            "stepping" => {
                let steps = (model.period() / 1e-7).round() as u32;
                (None, Box::new(Stepping::new(model, steps, LIMIT)))
            }
            _ => (None, Box::new(Volterra::new(model, f64::EPSILON, LIMIT))),
        };
        ((*name).to_owned(), size, kernel)
    };
    names.iter().map(named).collect()
}

/// Times and work of kernels on one scene, side by side.
pub fn side_by_side(model: &Model, start: &TrajectoryState, kernels: &[Named<'_>]) -> Value {
    let mut contenders: Vec<Contender<'_>> = (kernels.iter())
        .map(|(.., kernel)| Contender::new(kernel.cycle(start)))
        .collect();
    let spells = race(&mut contenders);
    let mut found = Map::new();
    for ((name, size, kernel), spell) in kernels.iter().zip(spells) {
        let counted = if name == "stepping" { 20 } else { COUNTED_CYCLES / 6 };
        let (_, work) = kernel.go(start, counted);
        let mean = |count: u64| count as f64 / work.cycles as f64;
        found.insert(
            name.clone(),
            json!({
                "ns": spell.median,
                "range": spell.range,
                "real_time": 1e9 * model.period() / spell.median,
                "matvecs": mean(work.matvecs),
                "guard_evaluations": mean(work.guard_evaluations),
                "events": mean(work.events),
                "windows": mean(work.windows),
                "table_bytes": size.map(|size| size.bytes),
                "cells": size.map(|size| size.cells),
            }),
        );
    }
    Value::Object(found)
}

/// Table 2: six degrees of freedom in strong and sparse rattle.
pub fn events() -> Value {
    let names = ["dyadic", "hermite", "spectral", "fused", "volterra"];
    let mut found = Map::new();
    for (scene, speed) in [("strong", 1200.0), ("sparse", 1400.0)] {
        let model = model_of(&drive(6, 0.05, speed));
        let start = settled(&model);
        let mut kernels = kernels(&model, &names);
        kernels.extend(self::kernels(&model, &["spectral, longest cells"]));
        found.insert(scene.to_owned(), side_by_side(&model, &start, &kernels));
    }
    Value::Object(found)
}

/// Table 3 and Figure 3: forty modes; twenty modes; twenty modes with the others as residual flexibility or as
/// attachment modes; and fused runs.
pub fn reduction() -> Value {
    let variants: [(&str, Case, &[&str]); 6] = [
        (
            "40 modes",
            sixty_levels(drive(40, 0.05, 1200.0)),
            &["dyadic", "hermite", "spectral", "fused", "volterra"],
        ),
        (
            "40 modes, two levels",
            drive(40, 0.05, 1200.0),
            &[
                "dyadic",
                "hermite",
                "spectral",
                "spectral, longest cells",
                "fused",
                "volterra",
            ],
        ),
        (
            "20 modes",
            twenty(false),
            &["spectral", "fused", "volterra"],
        ),
        (
            "20 modes + MTA",
            twenty(true),
            &["spectral", "fused", "volterra"],
        ),
        (
            "20 modes + 1 attachment mode",
            attached(1),
            &["spectral", "fused", "volterra"],
        ),
        (
            "20 modes + 2 attachment modes",
            attached(2),
            &["spectral", "fused", "volterra"],
        ),
    ];
    let mut found = Map::new();
    for (name, case, kernels) in variants {
        let model = model_of(&case);
        let start = settled(&model);
        let kernels = self::kernels(&model, kernels);
        let mut value = side_by_side(&model, &start, &kernels);
        for (kernel, _, any) in &kernels {
            let rms = any.deflection_rms(&model, &start, COUNTED_CYCLES);
            value[kernel]["deflection_rms"] = json!(rms);
        }
        found.insert(name.to_owned(), value);
    }
    Value::Object(found)
}

/// Table 4: accuracy in the hardest case.
pub fn conditioning() -> Value {
    let model = model_of(&sixty_levels(drive(40, 0.05, 1200.0)));
    let spectral = Spectral::new(&model, CELLS, LIMIT, None).expect("tables");
    let most = |touching: bool, of: fn(&gearatlas_paper::kernels::Conditioning) -> f64| {
        let bases = spectral.conditioning();
        let of_state = bases.iter().filter(|basis| basis.touching == touching);
        of_state.map(of).fold(0.0, f64::max)
    };
    let volterra = scenes::volterra(&model);
    let dyadic = Dyadic::size(&model, CELLS).expect("tables");
    // Compare `spectral` with the other integrators, cycle by cycle, each time from a common start.
    let norm = EnergyNorm::new(&model);
    let steps = (model.period() / 1e-7).round() as u32;
    let brute = Stepping::new(&model, steps, LIMIT);
    let finer = Stepping::new(&model, 4 * steps, LIMIT);
    let gridded = Spectral::new(&model, CELLS, LIMIT, Some(CELLS * 20)).expect("tables");
    let fused = Fused::new(&model, CELLS, LIMIT).expect("tables");
    let mut worst = [0.0f64; 5];
    let mut start = settled(&model);
    for _ in 0..COMPARED_CYCLES {
        let (end, _) = spectral.go(&start, 1);
        let exact = Reference::new(&model)
            .advance(&start, 1)
            .expect("a cycle")
            .end;
        let others = [
            exact,
            fused.go(&start, 1).0,
            brute.go(&start, 1).0,
            finer.go(&start, 1).0,
            gridded.go(&start, 1).0,
        ];
        for (worst, other) in worst.iter_mut().zip(&others) {
            *worst = worst.max(norm.distance(&end.state, &other.state) / norm.unit());
        }
        start = end;
    }
    json!({
        "dimension": 2 * model.modes(),
        "condition": [most(true, |b| b.condition), most(false, |b| b.condition)],
        "reconstruction": [most(true, |b| b.reconstruction), most(false, |b| b.reconstruction)],
        "spectral_bytes": spectral.bytes().bytes,
        "fused_bytes": fused.bytes().bytes,
        "dyadic_bytes": dyadic.bytes,
        "volterra_bytes": 8 * volterra_numbers(&volterra, &model),
        "against": {
            "reference integrator": worst[0],
            "fused": worst[1],
            "small steps, 100 ns": worst[2],
            "small steps, 25 ns": worst[3],
            "event grid T/1200": worst[4],
        },
        "compared_cycles": COMPARED_CYCLES,
    })
}

/// Count of numbers in the tables of `volterra`: those of one window, and the solution for each further stiffness (two
/// lists of nine groups of eight).
fn volterra_numbers(kernel: &Volterra<'_>, model: &Model) -> usize {
    let mut levels: Vec<u64> = (model.first_cycle().segments.iter())
        .map(|segment| segment.stiffness.mean().to_bits())
        .collect();
    levels.sort_unstable();
    levels.dedup();
    kernel.numbers_per_window() + (levels.len() - 1) * 2 * 9 * 8
}
