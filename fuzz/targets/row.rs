//! Analyses of random drives, and rules for any row with status `ok`, for any drive.
//!
//! | rule | check |
//! |---|---|
//! | `finite` | every number of a row is finite |
//! | `shares` | shares of drive contact, flight and coast contact are in [0, 1] and their sum is 1 |
//! | `energy` | the energy balance closes to 1e-9, if forces act |
//! | `kind` | steady contact has no event and touches; chaos and flights have events |

use gearatlas::analysis::{
    Class, Effort, LyapunovConfig, NvhConfig, PointConfig, PointOutcome, Section, Signals,
};
use gearatlas::numerics::random::PointSeed;

/// Whether a drive rests on a surface without a force: contact and flight are then the same.
fn lies_on_a_surface(row: &PointOutcome, half_gap: f64) -> bool {
    row.nvh.as_ref().is_some_and(|nvh| {
        nvh.deflection_pp <= 1e-9 * half_gap
            && (nvh.values.deflection_mean.abs() - half_gap).abs() <= 1e-9 * half_gap
    })
}

/// Analyses for a row, over `cycles` mesh cycles after `transient` skipped ones: all that [`broken`] and [`differs`]
/// need.
pub fn questions(transient: u64, cycles: u64) -> PointConfig {
    PointConfig {
        point: PointSeed {
            seed: 1,
            point_id: 0,
        },
        transient,
        cycles,
        settle: true,
        audit_cycles: 20,
        lyapunov: Some(LyapunovConfig {
            align: 50,
            twin: false,
            effort: Effort::Survey,
            ..LyapunovConfig::default()
        }),
        poincare_samples: 0,
        section: Section::default(),
        nvh: Some(NvhConfig {
            harmonics: 3,
            outputs: Signals::NONE,
            power: false,
            spectrum: None,
            orders: None,
            stop_at_stderr: None,
        }),
    }
}

/// The violated rules of a row, each with details.
pub fn broken(row: &PointOutcome, half_gap: f64) -> Vec<(&'static str, String)> {
    let mut broken = Vec::new();
    let Some(nvh) = &row.nvh else {
        return broken;
    };
    let values = &nvh.values;
    let lambda = row.lyapunov.as_ref();
    let numbers = [
        values.deflection_mean,
        values.deflection_rms,
        nvh.deflection_pp,
        values.force_mean,
        values.force_std,
        nvh.force_peak,
        values.impact_rate,
        values.impact_velocity,
        row.energy_residual.unwrap_or(0.0),
        row.events_per_cycle.unwrap_or(0.0),
    ];
    let all = (numbers.iter())
        .chain(&values.fractions)
        .chain(&values.harmonics)
        .chain(lambda.iter().flat_map(|l| &l.exponents))
        .chain(lambda.iter().flat_map(|l| &l.errors));
    if let Some(bad) = all.into_iter().find(|x| !x.is_finite()) {
        broken.push(("finite", format!("{bad} in {row:?}")));
    }
    let shares = values.fractions;
    let sum: f64 = shares.iter().sum();
    let inside = shares.iter().all(|s| (-1e-9..=1.0 + 1e-9).contains(s));
    if (sum - 1.0).abs() > 1e-9 || !inside {
        broken.push(("shares", format!("{shares:?}")));
    }
    // Motion at rest exchanges no energy.
    let acts = nvh.force_peak > 0.0 && values.deflection_rms > 1e-3 * half_gap;
    if let Some(residual) = row.energy_residual.filter(|r| acts && *r > 1e-9) {
        let how = format!("{residual:e}, {:?}, {shares:?}", row.class);
        broken.push(("energy", how));
    }
    let events = row.events_per_cycle.unwrap_or(0.0);
    let [drive, free, coast, _] = shares;
    let strange = match row.class {
        Some(Class::SteadyContact(_)) => events > 0.0 || free > 1e-9 || drive * coast > 1e-9,
        Some(Class::Chaotic | Class::TransientChaos) => events == 0.0,
        _ => free > 1e-9 && free < 1.0 - 1e-9 && events == 0.0,
    };
    if strange {
        let how = format!("{:?}, {events} events a cycle, {shares:?}", row.class);
        broken.push(("kind", how));
    }
    broken
}

/// How another result, from the state at the end of a row of periodic motion, differs from the row: in class, or by
/// more than 1e-6 in RMS deflection.
pub fn differs(row: &PointOutcome, again: &PointOutcome, half_gap: f64) -> Option<String> {
    let still = [row, again].map(|row| lies_on_a_surface(row, half_gap));
    if again.status != row.status || (again.class != row.class && still != [true; 2]) {
        return Some(format!(
            "{:?} ({}), then {:?} ({})",
            row.class, row.reason, again.class, again.reason
        ));
    }
    let rms = [row, again].map(|row| {
        row.nvh
            .as_ref()
            .map_or(0.0, |nvh| nvh.values.deflection_rms)
    });
    let off = (rms[0] - rms[1]).abs() > 1e-6 * (rms[0] + half_gap);
    off.then(|| format!("RMS deflections {rms:?} m"))
}
