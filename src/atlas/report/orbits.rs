//! Periodic orbits of a results folder: every orbit, counts by period and stability, and the given states
//! from which no orbit was found.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::Serialize;

use super::numbers::number;
use crate::input::printable;
use crate::store::{ResultTable, StoreError, TableKind};

/// Contents of `orbits.parquet`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Orbits {
    /// Number of points with at least one orbit.
    pub points: usize,
    /// The orbits of all points together, by period and stability.
    pub periods: Vec<OrbitCount>,
    /// Every orbit, by point and period.
    pub orbits: Vec<Orbit>,
    /// Searches from given states that led to no orbit.
    pub missed: Vec<MissedSearch>,
}

/// The stable or the unstable orbits of one period.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrbitCount {
    /// The period \[mesh cycles\].
    pub period: u64,
    /// Whether they are stable.
    pub stable: bool,
    /// Orbits.
    pub orbits: usize,
    /// Points that have one.
    pub points: usize,
    /// Smallest and largest modulus of their leading multipliers.
    pub modulus: [f64; 2],
    /// Smallest grazing margin of the orbits \[half gaps\]; `None` if no deflection has an extreme.
    pub grazing_margin: Option<f64>,
    /// Largest ratio of the growth of a kick to the prediction of the monodromy matrix.
    pub kick_over_linear: Option<f64>,
}

/// A periodic orbit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Orbit {
    /// The point.
    pub point_id: u64,
    /// Period of the orbit \[mesh cycles\].
    pub period: u64,
    /// Number of the given state from which the search found it, from 1; `None` if the search began where a trajectory
    /// nearly repeated.
    pub state: Option<u64>,
    /// Whether all multipliers lie inside the unit circle.
    pub stable: bool,
    /// Largest modulus of its multipliers.
    pub modulus: f64,
    /// The leading multiplier, real and imaginary part; `None` if the table has no multipliers.
    pub leading: Option<[f64; 2]>,
    /// Kind of bifurcation that occurs if the leading multiplier crosses the unit circle; `None` if it lies
    /// well inside.
    pub bifurcation: Option<String>,
    /// Smallest distance of an extreme of δ from a contact surface \[half gaps\].
    pub grazing_margin: Option<f64>,
    /// Growth of a small kick over one period, from the full (nonlinear) integration.
    pub kick_growth: Option<f64>,
    /// Growth of the same kick that the monodromy matrix predicts.
    pub kick_growth_linear: Option<f64>,
    /// All multipliers, real and imaginary parts.
    #[serde(skip)]
    pub multipliers: Vec<[f64; 2]>,
    /// Distance from the orbit 0, 1, 2, … returns after a kick, nonlinear and linear \[half gaps\].
    #[serde(skip)]
    pub kick: [Vec<f64>; 2],
}

/// A search from a given state that led to no orbit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MissedSearch {
    /// The point.
    pub point_id: u64,
    /// The given state, counted from 1.
    pub state: u64,
    /// The period sought \[mesh cycles\].
    pub period: u64,
    /// Why there is no orbit.
    pub reason: String,
}

impl Orbit {
    /// The leading multiplier as text: `−2.962`, `0.173 ± 0.982i`; only its modulus if the table has no
    /// multipliers.
    pub(super) fn leading_words(&self) -> String {
        let shown = |value: f64| number(value).replace('-', "−");
        match self.leading {
            None => format!("modulus {}", shown(self.modulus)),
            Some([re, 0.0]) => shown(re),
            Some([re, im]) => format!("{} ± {}i", shown(re), shown(im.abs())),
        }
    }

    /// The kind of bifurcation if the leading multiplier crosses the unit circle, as text.
    pub(super) fn crossing_words(&self) -> &str {
        match self.bifurcation.as_deref() {
            Some("neimark_sacker") => "torus (Neimark–Sacker)",
            Some("flip") => "period doubling (flip)",
            Some(other) => other,
            None => "well inside",
        }
    }
}

/// The orbits of a results folder; `None` if the job did not search for orbits.
pub(super) fn read(folder: &Path) -> Result<Option<Orbits>, StoreError> {
    let Some(table) = ResultTable::read_if_there(folder, TableKind::Orbits)? else {
        return Ok(None);
    };
    let (ids, periods, states) = (
        table.u64("point_id")?,
        table.u64("period")?,
        table.u64("state")?,
    );
    let (found, stable) = (table.bool("found")?, table.bool("stable")?);
    let (reasons, bifurcations) = (table.text("reason")?, table.text("bifurcation")?);
    let column = |name: &str| table.f64(name);
    let (lambda, margin) = (column("lambda")?, column("grazing_margin")?);
    let (growth, linear) = (column("kick_growth")?, column("kick_growth_linear")?);
    let list = |name: &str| table.lists(name);
    let (re, im) = (list("multipliers_re")?, list("multipliers_im")?);
    let (full, predicted) = (list("kick_distance")?, list("kick_distance_linear")?);
    let values = |lists: &[Option<Vec<Option<f64>>>], row: usize| -> Vec<f64> {
        lists[row]
            .iter()
            .flatten()
            .map_while(|value| *value)
            .collect()
    };
    let orbit = |row: usize| {
        let (period, [re, im]) = (periods[row]?, [values(&re, row), values(&im, row)]);
        let multipliers: Vec<[f64; 2]> = re.into_iter().zip(im).map(Into::into).collect();
        Some(Orbit {
            point_id: ids[row]?,
            period,
            state: states[row],
            stable: stable[row]?,
            // If all multipliers are 0, the exponent is not finite.
            modulus: lambda[row].map_or(0.0, |lambda| (lambda * period as f64).exp()),
            leading: multipliers.first().copied(),
            bifurcation: bifurcations[row].clone(),
            grazing_margin: margin[row],
            kick_growth: growth[row],
            kick_growth_linear: linear[row],
            multipliers,
            kick: [values(&full, row), values(&predicted, row)],
        })
    };
    let missed = |row: usize| {
        Some(MissedSearch {
            point_id: ids[row]?,
            state: states[row]?,
            period: periods[row]?,
            reason: printable(reasons[row].as_deref()?).into_owned(),
        })
    };
    let rows = |found_ones: bool| {
        let found = &found;
        (0..table.rows()).filter(move |&row| found[row] == Some(found_ones))
    };
    let mut orbits: Vec<Orbit> = rows(true).filter_map(orbit).collect();
    orbits.sort_by_key(|orbit| (orbit.point_id, orbit.period));
    Ok(Some(Orbits {
        points: distinct_points(orbits.iter()),
        periods: counts(&orbits),
        missed: rows(false).filter_map(missed).collect(),
        orbits,
    }))
}

fn distinct_points<'o>(orbits: impl Iterator<Item = &'o Orbit>) -> usize {
    orbits
        .map(|orbit| orbit.point_id)
        .collect::<BTreeSet<_>>()
        .len()
}

fn counts(orbits: &[Orbit]) -> Vec<OrbitCount> {
    let mut groups: BTreeMap<(u64, bool), Vec<&Orbit>> = BTreeMap::new();
    for orbit in orbits {
        groups
            .entry((orbit.period, !orbit.stable))
            .or_default()
            .push(orbit);
    }
    let count = |((period, unstable), orbits): ((u64, bool), Vec<&Orbit>)| {
        let moduli = || orbits.iter().map(|orbit| orbit.modulus);
        let ratio = |orbit: &&Orbit| Some(orbit.kick_growth? / orbit.kick_growth_linear?);
        OrbitCount {
            period,
            stable: !unstable,
            orbits: orbits.len(),
            points: distinct_points(orbits.iter().copied()),
            modulus: [
                moduli().fold(f64::INFINITY, f64::min),
                moduli().fold(0.0, f64::max),
            ],
            grazing_margin: orbits
                .iter()
                .filter_map(|orbit| orbit.grazing_margin)
                .reduce(f64::min),
            kick_over_linear: orbits.iter().filter_map(ratio).reduce(f64::max),
        }
    };
    groups.into_iter().map(count).collect()
}
