//! The checks of the verification: does this build compute correctly on this machine?
//!
//! Each check compares a part of the program with an independent result: a closed form, a published value,
//! another integrator, the same part on other threads. Its lines contain the compared quantities, their
//! difference, and the bound of the difference. The checks read no file of the user. The drives are built in
//! ([`drives`]).
//!
//! Checks that integrate use every kernel in [`candidate::kernels`]; a few use only the last one.

mod balances;

mod bits;
pub mod candidate;
mod closed_forms;
pub mod drives;
mod exponents;
mod flank;
mod gears;
mod impacts;
mod kernels;
mod reduction;
mod report;
mod small_steps;
mod structure;
mod subjects;
mod text;
mod trains;
mod trouble;
mod varying_speed;

pub use closed_forms::constant_contact_exponents;
pub use report::{Bound, Finding, Group, Line, Report};
pub use subjects::{Extent, Subjects};
pub use trouble::CheckError;

use std::time::Instant;

/// A check, which gives one or more lines of the report.
#[derive(Debug, Clone, Copy)]
pub struct Check {
    /// Its name.
    pub name: &'static str,
    /// Group of its lines.
    pub group: Group,
    run: fn(&Subjects) -> Result<Vec<Line>, CheckError>,
}

/// All checks, in the order of the report.
pub const CHECKS: &[Check] = &[
    check("multipliers", Group::ClosedForms, closed_forms::multipliers),
    check("grazing", Group::ClosedForms, closed_forms::grazing),
    check("bouncing", Group::ClosedForms, closed_forms::bouncing),
    check("impacts", Group::ClosedForms, impacts::impacts),
    check("rigid-pair", Group::ClosedForms, closed_forms::rigid_pair),
    check("shafts", Group::Structure, structure::shafts),
    check(
        "geared-torsion",
        Group::Structure,
        structure::geared_torsion,
    ),
    check("planetary", Group::Structure, trains::planetary),
    check("assembly", Group::Structure, structure::assembly),
    check("geometry", Group::Gears, gears::geometry),
    check("wedge", Group::Gears, gears::wedge),
    check("mesh-table", Group::Gears, gears::mesh_table),
    check("cycle", Group::Kernels, kernels::cycle),
    check("contact", Group::Kernels, kernels::constant_contact),
    check("trains", Group::Kernels, trains::trains),
    check("run-up", Group::Kernels, varying_speed::run_up),
    check(
        "fmu",
        Group::Kernels,
        varying_speed::functional_mock_up_unit,
    ),
    check("stepping", Group::Kernels, small_steps::order),
    check("energy", Group::Balances, balances::energy),
    check("neutral", Group::Balances, balances::neutral),
    check("tangents", Group::Exponents, exponents::tangents),
    check("trace", Group::Exponents, exponents::trace),
    check("twin", Group::Exponents, exponents::twin),
    check("resumed", Group::Bits, bits::resumed),
    check("threads", Group::Bits, bits::threads),
    check("residual", Group::Fidelity, reduction::residual),
    check("reduction", Group::Fidelity, reduction::truncation),
    check("small-step", Group::Fidelity, reduction::small_step),
    check("stiffness", Group::Fidelity, gears::stiffness),
];

const fn check(
    name: &'static str,
    group: Group,
    run: fn(&Subjects) -> Result<Vec<Line>, CheckError>,
) -> Check {
    Check { name, group, run }
}

/// Runs checks one after the other. Calls `watch` with every check before it starts. A check that cannot run becomes a
/// failed line with the reason.
pub fn run(subjects: &Subjects, checks: &[Check], watch: &mut dyn FnMut(&Check)) -> Report {
    let started = Instant::now();
    let mut findings = Vec::new();
    for check in checks {
        watch(check);
        let begun = Instant::now();
        let lines = (check.run)(subjects).unwrap_or_else(|trouble| vec![Line::failed(&trouble)]);
        findings.push(Finding {
            check: check.name,
            group: check.group,
            seconds: begun.elapsed().as_secs_f64(),
            lines,
        });
    }
    Report {
        extent: subjects.extent,
        seconds: started.elapsed().as_secs_f64(),
        findings,
    }
}

#[cfg(test)]
mod tests;
