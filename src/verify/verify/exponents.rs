//! Tangents and Lyapunov exponents, each computed by two independent methods.

use super::candidate::Candidate;
use super::report::{drives_of, worse};
use super::{CheckError, Line, Subjects, drives};
use crate::model::Model;
use crate::propagate::Tangents;
use crate::reference::Reference;

/// Steps of the differences: for modal displacements, for modal velocities.
const STEP: [f64; 2] = [1e-11, 1e-7];

/// Largest difference of two vectors. Each half is relative to its largest entry in `b`.
fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let n = b.len() / 2;
    let mut worst = 0.0f64;
    for part in [0..n, n..2 * n] {
        let scale = b[part.clone()].iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for i in part {
            // Skip equal entries, because the scale may be 0: a displacement of the neutral rotation changes
            // nothing else.
            if a[i] != b[i] {
                worst = worse(worst, (a[i] - b[i]).abs() / scale);
            }
        }
    }
    worst
}

/// Compares columns of the tangent map of a cycle with events with central differences of the reference.
pub fn tangents(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let columns = subjects.extent.pick(4, 80);
    let mut lines = Vec::new();
    let mut found = vec![(0.0f64, 0); subjects.kernels.len()];
    for case in &subjects.cases {
        let model = case.model()?;
        let n = model.modes();
        let reference = Reference::new(&model);
        let mut start = drives::rattling(&model)?;
        loop {
            let passage = reference.advance(&start, 1)?;
            if passage.crossings.len() >= 2 {
                break;
            }
            start = passage.end;
        }
        let mut carried = Vec::new();
        for kernel in &subjects.kernels {
            if !kernel.supports(&model) {
                carried.push(None);
                continue;
            }
            let mut tangents = Tangents::zeros(n, 2 * n);
            for i in 0..2 * n {
                tangents.vector_mut(i)[i] = STEP[i / n];
            }
            kernel.on(&model)?.carry(&start, &mut tangents)?;
            carried.push(Some(tangents));
        }
        for (found, tangents) in found.iter_mut().zip(&carried) {
            found.1 += usize::from(tangents.is_some());
        }
        for i in (0..2 * n).step_by((2 * n).div_ceil(columns)) {
            let end = |side: f64| {
                let mut moved = start.clone();
                moved.state[i] += side * STEP[i / n];
                reference
                    .advance(&moved, 1)
                    .map(|passage| passage.end.state)
            };
            let (above, below) = (end(1.0)?, end(-1.0)?);
            let half = above.iter().zip(&below).map(|(a, b)| 0.5 * (a - b));
            let difference: Vec<f64> = half.collect();
            for ((worst, _), tangents) in found.iter_mut().zip(&carried) {
                let Some(tangents) = tangents else { continue };
                *worst = worse(*worst, relative_difference(tangents.vector(i), &difference));
            }
        }
    }
    for (kernel, (worst, checked)) in subjects.kernels.iter().zip(found) {
        lines.push(Line::at_most(
            format!(
                "{}: tangents through events, {}",
                kernel.name,
                drives_of(checked, subjects.cases.len())
            ),
            "central differences of the reference",
            worst,
            1e-6,
            "relative",
        ));
    }
    Ok(lines)
}

/// The sum of all exponents per cycle, for a fraction `contact` of the time in contact. It is the mean trace
/// of the flow: twice the growth of every mode, and `−c Σ w·A·g` in contact. Saltation matrices have the
/// determinant 1.
///
/// It is valid if the direction of the mesh force is constant.
fn exact_sum(model: &Model, contact: f64) -> f64 {
    let components = (0..model.modes()).filter(|i| !model.neutral.contains(i));
    let flow: f64 = components.map(|i| 2.0 * model.blocks[i].growth()).sum();
    let coupling: f64 = (model.first_gains().iter())
        .map(|gain| {
            let (rate, g) = (gain.rate, gain.mesh_input);
            rate[0] * g[0] + rate[1] * g[1]
        })
        .sum();
    let damping = model.first_cycle().segments[0].damping;
    model.period() * (flow - damping * coupling * contact)
}

/// Number of cycles for the growth of a volume, a multiple of ten.
fn volume_cycles(subjects: &Subjects, kernel: &Candidate) -> u64 {
    subjects.extent.pick(200, 5000) / kernel.one_of
}

/// Compares the sum of all exponents of a rattling motion with the mean trace of the flow.
pub fn trace(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let mut found = vec![(0.0f64, 0); subjects.kernels.len()];
    let mut applicable = 0;
    for case in &subjects.cases {
        let model = case.model()?;
        if model.directions.len() > 1 {
            continue;
        }
        applicable += 1;
        let start = drives::rattling(&model)?;
        for ((worst, checked), kernel) in found.iter_mut().zip(&subjects.kernels) {
            if !kernel.supports(&model) {
                continue;
            }
            *checked += 1;
            let cycles = volume_cycles(subjects, kernel);
            let growth = kernel.on(&model)?.volume_growth(&model, &start, cycles)?;
            let growth = growth.ok_or(CheckError::Missing { what: "exponents" })?;
            let deviation =
                (growth.exponent_sum / exact_sum(&model, growth.contact_fraction) - 1.0).abs();
            *worst = worse(*worst, deviation);
        }
    }
    let line = |(kernel, (worst, checked)): (&Candidate, (f64, usize))| {
        Line::at_most(
            format!(
                "{}: sum of all exponents, {} cycles, {}",
                kernel.name,
                volume_cycles(subjects, kernel),
                drives_of(checked, applicable)
            ),
            "mean trace + ln det of saltations",
            worst,
            1e-12,
            "relative",
        )
    };
    Ok(subjects.kernels.iter().zip(found).map(line).collect())
}

/// Smallest exponent per mesh cycle that counts as chaos in the check of twins.
const CHAOTIC: f64 = 0.1;

/// Compares the largest exponent from tangents with that from a twin trajectory, in chaotic motion. In other
/// motion neither the tangents nor the twin align within this number of cycles.
pub fn twin(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let kernel = subjects.kernel()?;
    // The largest number of cycles for which an integration follows a twin.
    let cycles = 320;
    let mut lines = Vec::new();
    for case in &subjects.cases {
        let model = case.model()?;
        let start = drives::rattling(&model)?;
        let found = kernel.on(&model)?.lyapunov(&model, &start, cycles)?;
        let Some((found, twin)) = found.and_then(|l| l.twin.map(|twin| (l, twin))) else {
            return Err(CheckError::Missing { what: "a twin" });
        };
        let exponent = found.exponents[0];
        if exponent < CHAOTIC {
            continue;
        }
        lines.push(Line::at_most(
            format!(
                "{}: exponent {exponent:+.3} by {}, {}",
                kernel.name,
                found.method.name(),
                case.name
            ),
            "twin trajectory",
            (twin - exponent).abs(),
            1e-4,
            "1/cycle",
        ));
    }
    if lines.is_empty() {
        Err(CheckError::Missing {
            what: "a drive in chaos",
        })
    } else {
        Ok(lines)
    }
}
