//! What must balance over many cycles: energy, and the free rotation of the whole drive.

use super::drives;
use super::{Line, Subjects, Trouble};

/// Residual of the energy balance through rattle.
pub fn energy(subjects: &Subjects) -> Result<Vec<Line>, Trouble> {
    let cycles = subjects.extent.pick(1000, 10_000);
    let mut lines = Vec::new();
    for case in &subjects.cases {
        let model = case.model()?;
        let start = drives::rattling(&model)?;
        for kernel in &subjects.kernels {
            let residual = (kernel.on(&model)).energy_residual(&model, &start, cycles)?;
            lines.push(Line::at_most(
                format!("{}: {cycles} cycles, {}", kernel.name, case.name),
                "works of all forces, added up",
                residual.unwrap_or(f64::NAN),
                1e-10,
                "of all work",
            ));
        }
    }
    Ok(lines)
}

/// The neutral pair moves as its start and its torques say, whatever the rest does.
pub fn neutral(subjects: &Subjects) -> Result<Vec<Line>, Trouble> {
    let cycles: u64 = subjects.extent.pick(10_000, 100_000);
    let (place, speed) = (1e-6, 1e-4);
    let mut lines = Vec::new();
    for case in &subjects.cases {
        let model = case.model()?;
        let [neutral] = model.neutral[..] else {
            continue;
        };
        // Ripple would move it too.
        if !model.ripple.is_empty() {
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
        for kernel in &subjects.kernels {
            let end = kernel.on(&model).course(&start, cycles)?.end;
            let found = [end.state[neutral], end.state[n + neutral]];
            let errors = (found.iter().zip(&exact)).map(|(a, b)| (a / b - 1.0).abs());
            // Round-off of one rounding a cycle, as it adds up all one way.
            let bound = cycles as f64 * f64::EPSILON;
            lines.push(Line::at_most(
                format!("{}: {cycles} cycles, {}", kernel.name, case.name),
                "free rotation",
                errors.fold(0.0, |worst, e| if e <= worst { worst } else { e }),
                bound,
                "relative",
            ));
        }
    }
    Ok(lines)
}
