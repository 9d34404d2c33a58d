//! Does the kernel with small fixed steps converge with its order? The order is 2 without changes of the
//! contact state, and 1 with such changes.

use super::candidate::Propagator;
use super::drives;
use super::{CheckError, Line, Subjects};
use crate::analysis::EnergyNorm;
use crate::model::{InitialState, Model, TrajectoryState};
use crate::propagate::Stepping;
use crate::reference::Reference;

/// Number of neighbouring step counts whose errors are averaged. A single error depends on the positions of the
/// events between two steps; a geometric mean over neighbours does not.
const NEIGHBOURS: u32 = 8;

/// Slope of the logarithm of the error over the logarithm of the step, by least squares.
fn observed_order(ladder: &[(u32, f64)]) -> f64 {
    let n = ladder.len() as f64;
    let points = ladder
        .iter()
        .map(|&(steps, log)| (-f64::from(steps).ln(), log));
    let (x, y) = (points.clone()).fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (top, bottom) = points.fold((0.0, 0.0), |(a, b), (u, v)| {
        (a + (u - x) * (v - y), b + (u - x) * (u - x))
    });
    top / bottom
}

/// Distance of the end by small steps from the exact end \[half gaps\].
fn error(
    model: &Model,
    steps: u32,
    start: &TrajectoryState,
    end: &TrajectoryState,
) -> Result<f64, CheckError> {
    let cycles = end.cycle - start.cycle;
    let passage = Stepping::new(model, steps, 10_000).passage(start, cycles)?;
    let norm = EnergyNorm::new(model);
    Ok(norm.distance(&passage.end.state, &end.state) / norm.unit())
}

fn order_in_contact(model: &Model) -> Result<f64, CheckError> {
    let start = model.start(&InitialState::Static);
    let exact = Reference::new(model).advance(&start, 3)?.end;
    let mut ladder = [480, 960, 1920, 3840].map(|steps| (steps, 0.0));
    for (steps, log) in &mut ladder {
        *log = error(model, *steps, &start, &exact)?.ln();
    }
    Ok(observed_order(&ladder))
}

fn order_through_events(model: &Model, cycles: u32) -> Result<f64, CheckError> {
    let reference = Reference::new(model);
    let mut start = drives::rattling(model)?;
    let mut ladder = [480, 960, 1920, 3840, 7680].map(|steps| (steps, 0.0));
    let mut passed = 0;
    while passed < cycles {
        let exact = reference.advance(&start, 1)?;
        // Without an event the order is higher, and in free flight there is no error.
        if !exact.crossings.is_empty() {
            passed += 1;
            for (steps, log) in &mut ladder {
                for neighbour in 0..NEIGHBOURS {
                    let steps = *steps + *steps * neighbour / 48;
                    *log += error(model, steps, &start, &exact.end)?.ln();
                }
            }
        }
        start = exact.end;
    }
    let samples = f64::from(cycles * NEIGHBOURS);
    Ok(observed_order(&ladder.map(|(n, log)| (n, log / samples))))
}

/// Observed orders on the smallest and the largest drive.
pub fn order(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let cycles = subjects.extent.pick(8, 40);
    let mut ends = vec![subjects.default_drive()?];
    if let [first, _, ..] = &subjects.cases[..] {
        ends.insert(0, first);
    }
    let mut lines = Vec::new();
    for case in ends {
        lines.push(Line::between(
            format!("stepping: order in contact, {}", case.name),
            "reference integrator",
            order_in_contact(&case.in_constant_contact().model()?)?,
            [1.9, 2.1],
            "1",
        ));
        lines.push(Line::between(
            format!("stepping: order through events, {}", case.name),
            "reference integrator",
            order_through_events(&case.model()?, cycles)?,
            [0.85, 1.25],
            "1",
        ));
    }
    Ok(lines)
}
