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
        Ok(Some(Self::held_against(followed, &own, &names, &places)))
    }

    /// Of some transitions, on axes of these names, each with its place on them.
    fn held_against(
        followed: &Followed,
        transitions: &[&TransitionSummary],
        names: &[String],
        places: &Places,
    ) -> Self {
        let length = match followed.axis().values[..] {
            [low, .., high] => high - low,
            _ => 0.0,
        };
        let tolerance = NEAR * length;
        let lines = followed.lines();
        let (mut all, mut by_chance) = (Vec::new(), [0.0; 2]);
        for &transition in transitions {
            let place = places.get(&transition.point_id);
            let line = place.and_then(|at| lines.iter().find(|line| line.holds_named(names, at)));
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
        Self {
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
        }
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

/// Values of the axes, by `point_id`.
type Places = BTreeMap<u64, Vec<f64>>;

/// The names of the axes of the points, and where those of some transitions lie on them.
fn places(
    folder: &Path,
    transitions: &[&TransitionSummary],
) -> Result<(Vec<String>, Places), ReportError> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::followed::Orbit;
    use crate::report::point::Axis;

    fn orbit(speed: f64, stable: bool) -> Orbit {
        Orbit {
            at: vec![0.1, speed],
            period: 1,
            stable,
            sequence: String::new(),
            rms: 1e-6,
        }
    }

    fn found(kind: &str, load: f64, speed: f64, after: usize) -> Bifurcation {
        Bifurcation {
            at: vec![load, speed],
            branch: 0,
            after,
            kind: kind.into(),
            detail: "the interval ends".into(),
            rms: 1e-6,
        }
    }

    fn followed() -> Followed {
        let axis = |name: &str, values: &[f64]| Axis {
            name: name.into(),
            unit: "1".into(),
            values: values.into(),
        };
        let orbits = [
            (1000.0, true),
            (1250.0, true),
            (1500.0, false),
            (2000.0, false),
        ];
        Followed {
            job: None,
            axes: vec![
                axis("load", &[0.1]),
                axis("speed", &orbits.map(|(speed, _)| speed)),
            ],
            units: BTreeMap::new(),
            over: 1,
            second: None,
            branches: BTreeMap::from([(0, orbits.map(|(v, s)| orbit(v, s)).to_vec())]),
            bifurcations: vec![
                found("period_doubling", 0.1, 1400.0, 1),
                found("graze", 0.1, 1700.0, 2),
                // Not on the line, and no bifurcation.
                found("fold", 0.2, 1200.0, 0),
                found("end", 0.1, 1200.0, 3),
            ],
            curves: BTreeMap::new(),
        }
    }

    fn transition(point_id: u64, bracket: [f64; 2]) -> TransitionSummary {
        TransitionSummary {
            point_id,
            axis: "speed".into(),
            direction: "up".into(),
            classes: ["periodic".into(), "chaotic".into()],
            periods: [Some(1), None],
            what: "class".into(),
            deflection_rms: [None; 2],
            deflection_mean: [None; 2],
            bracket,
        }
    }

    #[test]
    fn a_bifurcation_explains_what_it_lies_in_or_near_on_its_own_line() {
        let transitions = [
            transition(0, [1399.0, 1401.0]),
            transition(1, [1700.5, 1701.0]),
            transition(2, [1199.0, 1201.0]),
            transition(3, [1399.0, 1401.0]),
            transition(4, [2500.0, 2501.0]),
            transition(5, [1650.0, 1750.0]),
        ];
        let transitions: Vec<&TransitionSummary> = transitions.iter().collect();
        // The axes of the points have another order.
        let names = ["speed".to_owned(), "load".to_owned()];
        let load = |id: u64| if id == 3 { 0.2 } else { 0.1 };
        let places = (0..6).map(|id| (id, vec![1400.0, load(id)])).collect();
        let held = Explanation::held_against(&followed(), &transitions, &names, &places);
        let found: Vec<_> = held
            .all
            .iter()
            .map(|own| (own.explained, own.of_stable))
            .collect();
        assert_eq!(
            found,
            [
                (Explaining::Within, true),
                (Explaining::Near, false),
                (Explaining::None, false),
                (Explaining::NotFollowed, false),
                (Explaining::NotFollowed, false),
                (Explaining::Within, false),
            ]
        );
        assert_eq!((held.count, held.within, held.within_of_stable), (6, 2, 1));
        assert_eq!((held.near, held.not_followed, held.tolerance), (1, 2, 1.0));
        let kinds = [("graze".to_owned(), 1), ("period_doubling".to_owned(), 1)];
        assert_eq!(held.kinds, BTreeMap::from(kinds));
        let chance = |windows: [f64; 4]| -> f64 {
            windows
                .iter()
                .map(|w| 1.0 - (1.0 - w / 1000.0).powi(2))
                .sum()
        };
        let [within, near] = [[2.0, 0.5, 2.0, 100.0], [4.0, 2.5, 4.0, 102.0]].map(chance);
        assert!((held.within_by_chance - within).abs() < 1e-12);
        assert!((held.near_by_chance - near).abs() < 1e-12);
    }
}
