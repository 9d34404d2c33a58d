//! How large are the errors of a reduction to fewer modes, or of small fixed steps, in physical quantities of
//! the default drive? The bounds are engineering tolerances, not bounds of round-off.

use super::candidate::Propagator;
use super::drives::{self, Case};
use super::{CheckError, Line, Subjects};
use crate::model::Model;
use crate::propagate::Stepping;

/// Number of mesh cycles before a statistic.
const TRANSIENT: u64 = 300;

/// Compares the ratio of the residual flexibility of modes 21 to 40 and the flexibility of the mesh with a
/// published value.
pub fn residual(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let drive = subjects.default_drive()?;
    let flexibility = drive.structure.truncated(20, true)?.residual_flexibility;
    let stiffness = drive.model()?.first_cycle().mean_stiffness();
    Ok(vec![Line::between(
        "c_res k of modes 21-40, default drive",
        "0.19 % (published)",
        100.0 * flexibility * stiffness,
        [0.185, 0.195],
        "%",
    )])
}

/// RMS of the mesh deflection \[m\] after a transient.
fn rms(kernel: &dyn Propagator, model: &Model, cycles: u64) -> Result<f64, CheckError> {
    let settled = kernel.passage(&drives::rattling(model)?, TRANSIENT)?.end;
    let nvh = kernel.nvh(model, &settled, cycles)?;
    Ok(nvh.map_or(f64::NAN, |nvh| nvh.values.deflection_rms))
}

/// Compares the RMS of the mesh deflection with twenty modes, without and with residual flexibility, to that
/// with all modes.
pub fn truncation(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let cycles = subjects.extent.pick(4000, 100_000);
    let drive = subjects.default_drive()?;
    let kernel = subjects.kernel()?;
    let measure = |case: &Case| {
        let model = case.model()?;
        rms(&*kernel.on(&model)?, &model, cycles)
    };
    let full = measure(drive)?;
    let mut lines = Vec::new();
    for (name, augmented) in [("20 modes", false), ("20 modes + MTA", true)] {
        let mut case = drive.clone();
        case.structure = drive.structure.truncated(20, augmented)?;
        let measured = measure(&case)?;
        lines.push(Line::between(
            format!("deflection RMS, {name}, {:.2} um", 1e6 * measured),
            "all 40 modes",
            100.0 * (measured / full - 1.0),
            [-5.0, 5.0],
            "%",
        ));
    }
    Ok(lines)
}

/// Compares the RMS of the mesh deflection by the event-driven kernel with that by small steps.
pub fn small_step(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let cycles = subjects.extent.pick(2000, 100_000);
    let kernel = subjects.kernel()?;
    let model = subjects.default_drive()?.model()?;
    let exact = rms(&*kernel.on(&model)?, &model, cycles)?;
    let stepped = rms(&Stepping::new(&model, 2400, 10_000), &model, cycles)?;
    Ok(vec![Line::between(
        format!("{}: deflection RMS, {:.2} um", kernel.name, 1e6 * exact),
        "small steps of T/2400",
        100.0 * (exact / stepped - 1.0),
        [-5.0, 5.0],
        "%",
    )])
}
