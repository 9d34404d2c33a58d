//! Which refined changes of motion of a sweep does a bifurcation of a followed orbit explain?
//!
//! A bifurcation on the transition's line that lies within its bracket does. One beside it, within a
//! thousandth of the followed interval, is counted apart. Of many bifurcations some lie there by chance:
//! of n that fall evenly on an interval of length L, one or more lies in a window w with probability
//! 1 − (1 − w/L)ⁿ, and the sum over all transitions is said with the counts.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::Serialize;

use super::{Bifurcation, Followed};
use crate::input::printable;
use crate::report::error::ReportError;
use crate::report::transitions::TransitionSummary;
use crate::store::{ResultTable, TableKind};

/// Distance from a bracket, as a part of the followed interval, at which a bifurcation is near it.
const NEAR: f64 = 1e-3;

/// How a transition relates to the bifurcations on its line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Explaining {
    /// A bifurcation lies within its bracket.
    Within,
    /// One lies beside it.
    Near,
    /// None does.
    None,
    /// No orbit was followed there.
    NotFollowed,
}

/// A transition, and the bifurcations that explain it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explained {
    /// The transition.
    #[serde(flatten)]
    pub transition: TransitionSummary,
    /// Whether bifurcations lie in its bracket.
    pub explained: Explaining,
    /// Their kinds, each once.
    pub by: Vec<String>,
    /// Whether one of them is of a branch that is stable before or behind it.
    pub of_stable: bool,
}

/// The transitions of a sweep held against bifurcations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    /// How far from a bracket is near, in the unit of the axis.
    pub tolerance: f64,
    /// Transitions.
    pub count: usize,
    /// Those with a bifurcation within their bracket.
    pub within: usize,
    /// Those of them with one of a branch that is stable before or behind it.
    pub within_of_stable: usize,
    /// As many as had one within if bifurcations lay anywhere.
    pub within_by_chance: f64,
    /// Those with none within, and one beside.
    pub near: usize,
    /// As many as had one within or beside if bifurcations lay anywhere.
    pub near_by_chance: f64,
    /// Those where no orbit was followed.
    pub not_followed: usize,
    /// For each kind, the transitions with such a bifurcation within their bracket.
    pub kinds: BTreeMap<String, usize>,
    /// Every transition.
    pub all: Vec<Explained>,
}

impl Explanation {
    /// Of the transitions along the followed axis; none where there are none.
    pub(super) fn of(
        folder: &Path,
        followed: &Followed,
        transitions: &[TransitionSummary],
    ) -> Result<Option<Self>, ReportError> {
        let own = |transition: &&TransitionSummary| transition.axis == followed.axis().name;
        let own: Vec<&TransitionSummary> = transitions.iter().filter(own).collect();
        if own.is_empty() {
            return Ok(None);
        }
        let (names, places) = places(folder, &own)?;
        let length = match followed.axis().values[..] {
            [low, .., high] => high - low,
            _ => 0.0,
        };
        let tolerance = NEAR * length;
        let lines = followed.lines();
        let (mut all, mut by_chance) = (Vec::new(), [0.0; 2]);
        for transition in own {
            let place = places.get(&transition.point_id);
            let line = place.and_then(|at| lines.iter().find(|line| line.holds_named(&names, at)));
            let orbits = followed.branches.values().flatten();
            let values = orbits.filter(|orbit| line.is_some_and(|line| line.holds(&orbit.at)));
            let values = values.map(|orbit| orbit.at[followed.over]);
            let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], value| {
                [a.min(value), b.max(value)]
            });
            let [lower, upper] = transition.bracket;
            let Some(line) = line.filter(|_| low <= upper && lower <= high) else {
                all.push(Explained {
                    transition: transition.clone(),
                    explained: Explaining::NotFollowed,
                    by: Vec::new(),
                    of_stable: false,
                });
                continue;
            };
            let on_line = || {
                let found = followed.bifurcations.iter();
                found.filter(|found| !found.is_end() && line.holds(&found.at))
            };
            for (sum, aside) in by_chance.iter_mut().zip([0.0, tolerance]) {
                let window = (upper - lower + 2.0 * aside) / length;
                *sum += 1.0 - (1.0 - window.clamp(0.0, 1.0)).powi(on_line().count() as i32);
            }
            let within = |aside: f64| -> Vec<&Bifurcation> {
                let place = |found: &Bifurcation| found.at[followed.over];
                let range = lower - aside..=upper + aside;
                on_line().filter(|b| range.contains(&place(b))).collect()
            };
            let (explained, found) = match (within(0.0), within(tolerance)) {
                (found, _) if !found.is_empty() => (Explaining::Within, found),
                (_, found) if !found.is_empty() => (Explaining::Near, found),
                _ => (Explaining::None, Vec::new()),
            };
            let mut by: Vec<String> = found.iter().map(|found| found.kind.clone()).collect();
            by.sort();
            by.dedup();
            all.push(Explained {
                transition: transition.clone(),
                explained,
                by,
                of_stable: found.iter().any(|found| stable(followed, found)),
            });
        }
        let count = |explained: Explaining| all.iter().filter(|e| e.explained == explained).count();
        let within = || all.iter().filter(|e| e.explained == Explaining::Within);
        let mut kinds = BTreeMap::new();
        for kind in within().flat_map(|explained| &explained.by) {
            *kinds.entry(kind.clone()).or_insert(0) += 1;
        }
        Ok(Some(Self {
            tolerance,
            count: all.len(),
            within: count(Explaining::Within),
            within_of_stable: within().filter(|explained| explained.of_stable).count(),
            within_by_chance: by_chance[0],
            near: count(Explaining::Near),
            near_by_chance: by_chance[1],
            not_followed: count(Explaining::NotFollowed),
            kinds,
            all,
        }))
    }
}

/// Whether the orbit before or behind a bifurcation is stable.
fn stable(followed: &Followed, found: &Bifurcation) -> bool {
    let orbits = followed
        .branches
        .get(&found.branch)
        .map_or(&[][..], |all| all);
    let near = orbits.iter().skip(found.after).take(2);
    near.into_iter().any(|orbit| orbit.stable)
}

/// The names of the axes of the points, and where those of some transitions lie on them.
fn places(
    folder: &Path,
    transitions: &[&TransitionSummary],
) -> Result<(Vec<String>, BTreeMap<u64, Vec<f64>>), ReportError> {
    let names = ResultTable::head(folder, TableKind::Points)?.axes()?;
    let columns = names.iter().map(String::as_str).chain(["point_id"]);
    let columns: Vec<&str> = columns.collect();
    let wanted: BTreeSet<u64> = transitions.iter().map(|own| own.point_id).collect();
    let mut places = BTreeMap::new();
    ResultTable::scan(folder, TableKind::Points, &columns, |part| {
        let values = names.iter().map(|name| part.f64(name));
        let values: Vec<Vec<Option<f64>>> = values.collect::<Result<_, _>>()?;
        for (row, id) in part.u64("point_id")?.into_iter().enumerate() {
            let at: Option<Vec<f64>> = values.iter().map(|column| column[row]).collect();
            if let (Some(id), Some(at)) = (id.filter(|id| wanted.contains(id)), at) {
                places.insert(id, at);
            }
        }
        Ok::<_, ReportError>(())
    })?;
    let shown = names.iter().map(|name| printable(name).into_owned());
    Ok((shown.collect(), places))
}
