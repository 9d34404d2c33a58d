//! Balances over many cycles: energy, and the free rotation of the whole drive.

use super::report::{drives_of, worse};
use super::{CheckError, Line, Subjects, drives};

/// Residual of the energy balance over many cycles of rattle.
pub fn energy(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let mut lines = Vec::new();
    for kernel in &subjects.kernels {
        let cycles = subjects.extent.pick(1000, 10_000) / kernel.one_of;
        let (mut worst, mut checked) = (0.0, 0);
        for case in &subjects.cases {
            let model = case.model()?;
            if !kernel.supports(&model) {
                continue;
            }
            checked += 1;
            let start = drives::rattling(&model)?;
            let residual = kernel.on(&model)?.energy_residual(&model, &start, cycles)?;
            worst = worse(worst, residual.unwrap_or(f64::NAN));
        }
        let drives = drives_of(checked, subjects.cases.len());
        lines.push(Line::at_most(
            format!("{}: energy over {cycles} cycles, {drives}", kernel.name),
            "sum of the work of all forces",
            worst,
            1e-12,
            "of all work",
        ));
    }
    Ok(lines)
}

/// The neutral rotation moves according to its start and its torque, independently of the other modes.
/// Friction and torque ripple also act on it, and are left out.
pub fn neutral(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let (place, speed) = (1e-6, 1e-4);
    let mut lines = Vec::new();
    for kernel in &subjects.kernels {
        let cycles: u64 = subjects.extent.pick(10_000, 100_000) / kernel.one_of;
        let (mut worst, mut checked, mut applicable, mut windows) = (0.0, 0, 0, 0);
        for case in &subjects.cases {
            let mut case = case.clone();
            case.drive.friction = 0.0;
            case.drive.torque_ripple.clear();
            let model = case.model()?;
            let [neutral] = model.neutral[..] else {
                continue;
            };
            applicable += 1;
            if !kernel.supports(&model) {
                continue;
            }
            let n = model.modes();
            let mut start = drives::rattling(&model)?;
            start.state[neutral] = place;
            start.state[n + neutral] = speed;
            let time = cycles as f64 * model.period();
            let pull = model.blocks[neutral].static_input[1];
            let exact = [
                place + time * (speed + 0.5 * time * pull),
                speed + time * pull,
            ];
            let passage = kernel.on(&model)?.passage(&start, cycles)?;
            let state = &passage.end.state;
            for (found, exact) in [state[neutral], state[n + neutral]].iter().zip(&exact) {
                worst = worse(worst, (found / exact - 1.0).abs());
            }
            checked += 1;
            windows = windows.max(passage.counters.windows);
        }
        lines.push(Line::at_most(
            format!(
                "{}: drift over {cycles} cycles, {}",
                kernel.name,
                drives_of(checked, applicable)
            ),
            "free rotation",
            worst,
            // Allow one rounding error per window, all with the same sign.
            windows as f64 * f64::EPSILON,
            "relative",
        ));
    }
    Ok(lines)
}
