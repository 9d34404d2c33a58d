//! Branches: chains of attractors of neighbouring points.
//!
//! Every point numbers its attractors independently. Two attractors of neighbouring points on an axis belong to one
//! branch if each is the nearest to the other, and their distance is at most [`FARTHEST`]. The distance is
//!
//! ```text
//! |ln(RMS/RMS')| + |ln(peak/peak')| + |e − e'| / max(1, e, e') + penalty
//! ```
//!
//! with the events per cycle e, and a penalty if the kinds of motion differ. The penalty for a period
//! doubling is small, so that it continues its branch. An attractor without a match begins a new branch, and
//! so does every attractor after a missing point. Branches are computed from the whole table and are not
//! stored in it, because the neighbours of a point can be in another shard of the job.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::point::{Axis, PointSummary, TRANSIENT_CHAOS};
use crate::store::{ResultTable, StoreError, TableKind};

/// Largest distance between two attractors of one branch.
const FARTHEST: f64 = 1.0;
/// Penalty if one period is twice the other.
const PERIOD_DOUBLING_PENALTY: f64 = 0.2;
/// Penalty for any other change of the kind of motion.
const CLASS_CHANGE_PENALTY: f64 = 0.5;

/// An attractor of a point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Attractor {
    /// The point.
    pub point_id: u64,
    /// Number of the attractor at that point.
    pub attractor_id: u64,
    /// Kind of motion.
    pub class: String,
    /// Period of the motion, if it has one.
    pub period: Option<u64>,
    /// Largest exponent \[1/cycle\].
    pub lambda: Option<f64>,
    /// Standard error of the exponent.
    pub lambda_stderr: Option<f64>,
    /// RMS of the deflection about its mean \[m\].
    pub deflection_rms: Option<f64>,
    /// Largest |mesh force| \[N\].
    pub force_peak: Option<f64>,
    /// Contact-state changes per cycle.
    pub events_per_cycle: Option<f64>,
    /// Probes that settled on it.
    pub probes: u64,
    /// Share of the point's probes that settled on it.
    pub share: f64,
    /// The 95 % interval of the share.
    pub interval: [f64; 2],
    /// Number of cells of the slice from which the motion settled on it.
    pub cells: Option<u64>,
    /// States at mesh phase 0, projected on the slice \[m; in a phase plane, the second in m/s\].
    #[serde(skip)]
    pub strobe: Vec<[f64; 2]>,
}

impl Attractor {
    /// The kind of motion as text: `period 2`, `chaotic`.
    pub fn kind(&self) -> String {
        match (self.class.as_str(), self.period) {
            ("periodic", Some(period)) => format!("period {period}"),
            (TRANSIENT_CHAOS, _) => "transient chaos".into(),
            (class, _) => class.replace('_', "-"),
        }
    }
}

/// The attractors of a results folder, by point and number; empty if the folder has no such table.
///
/// # Errors
/// The table cannot be read.
pub fn read_attractors(folder: &Path) -> Result<Vec<Attractor>, StoreError> {
    let Some(table) = ResultTable::read_if_there(folder, TableKind::Attractors)? else {
        return Ok(Vec::new());
    };
    let whole = |name: &str| table.u64(name);
    let (ids, numbers, periods) = (whole("point_id")?, whole("attractor_id")?, whole("period")?);
    let (probes, cells) = (whole("probes")?, whole("cells")?);
    let classes = table.text("class")?;
    let column = |name: &str| table.f64(name);
    let (lambda, stderr) = (column("lambda")?, column("lambda_stderr")?);
    let (rms, peak) = (column("deflection_rms")?, column("force_peak")?);
    let events = column("events_per_cycle")?;
    let (share, low) = (column("basin_share")?, column("basin_low")?);
    let high = column("basin_high")?;
    let (x, y) = (table.lists("slice_x")?, table.lists("slice_y")?);
    let strobe = |row: usize| {
        let [x, y] = [&x[row], &y[row]].map(|list| list.iter().flatten().flatten());
        x.zip(y).map(|(x, y)| [*x, *y]).collect()
    };
    let attractor = |row: usize| Attractor {
        point_id: ids[row].unwrap_or_default(),
        attractor_id: numbers[row].unwrap_or_default(),
        class: classes[row].clone().unwrap_or_default(),
        period: periods[row],
        lambda: lambda[row],
        lambda_stderr: stderr[row],
        deflection_rms: rms[row],
        force_peak: peak[row],
        events_per_cycle: events[row],
        probes: probes[row].unwrap_or_default(),
        share: share[row].unwrap_or_default(),
        interval: [low[row], high[row]].map(Option::unwrap_or_default),
        cells: cells[row],
        strobe: strobe(row),
    };
    Ok((0..table.rows()).map(attractor).collect())
}

/// The branch of every attractor, in the order of `attractors`, along the axis with index `along`. Points with one
/// sweep direction and equal values on the axes `fixed_axes` (indices) form a line. Branches are numbered from 0, line
/// by line, and on a line in ascending order of the axis. `attractors` and `points` are in `point_id` order.
pub fn branches(
    attractors: &[Attractor],
    points: &[PointSummary],
    axes: &[Axis],
    along: usize,
    fixed_axes: &[usize],
) -> Vec<usize> {
    let mut branch = vec![0; attractors.len()];
    let mut next = 0;
    let mut lines: BTreeMap<(Vec<u64>, Option<&str>), Vec<&PointSummary>> = BTreeMap::new();
    for point in points {
        let values = fixed_axes
            .iter()
            .map(|&axis| point.axis_values[axis].to_bits());
        let line = (values.collect(), point.direction.as_deref());
        lines.entry(line).or_default().push(point);
    }
    let mut lines: Vec<Vec<&PointSummary>> = lines.into_values().collect();
    lines.sort_by_key(|line| line[0].point_id);
    for mut line in lines {
        // The points of a downward sweep are in descending order.
        line.sort_by(|a, b| a.axis_values[along].total_cmp(&b.axis_values[along]));
        let mut previous: Option<(usize, std::ops::Range<usize>)> = None;
        for point in line {
            let value = point.axis_values[along];
            let place = axes[along].place(value);
            let first = attractors.partition_point(|a| a.point_id < point.point_id);
            let last = attractors.partition_point(|a| a.point_id <= point.point_id);
            let before = previous
                .filter(|(neighbour, _)| neighbour + 1 == place)
                .map_or(0..0, |(_, range)| range);
            let matched = matches(&attractors[before.clone()], &attractors[first..last]);
            for (row, partner) in (first..last).zip(matched) {
                branch[row] = match partner {
                    Some(partner) => branch[before.start + partner],
                    None => {
                        next += 1;
                        next - 1
                    }
                };
            }
            previous = Some((place, first..last));
        }
    }
    branch
}

/// For each attractor of `new`, the index in `old` of the attractor that it continues; `None` if it begins a branch.
fn matches(old: &[Attractor], new: &[Attractor]) -> Vec<Option<usize>> {
    let nearest = |from: &Attractor, to: &[Attractor]| -> Option<usize> {
        let distances = to.iter().map(|other| distance(from, other)).enumerate();
        let near = distances.filter(|(_, distance)| *distance <= FARTHEST);
        near.min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(index, _)| index)
    };
    let back: Vec<Option<usize>> = old.iter().map(|old| nearest(old, new)).collect();
    let forth = new.iter().enumerate().map(|(index, attractor)| {
        let partner = nearest(attractor, old)?;
        (back[partner] == Some(index)).then_some(partner)
    });
    forth.collect()
}

/// Distance between two attractors.
fn distance(a: &Attractor, b: &Attractor) -> f64 {
    let ratio = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) if a > 0.0 && b > 0.0 => (a / b).ln().abs(),
        // One motion has no vibration, or no contact force, and the other has.
        (Some(a), Some(b)) if a != b => f64::INFINITY,
        _ => 0.0,
    };
    let events = [a, b].map(|one| one.events_per_cycle.unwrap_or(0.0));
    let penalty = match (a.period, b.period) {
        _ if a.class == b.class && a.period == b.period => 0.0,
        (Some(a), Some(b)) if a == 2 * b || b == 2 * a => PERIOD_DOUBLING_PENALTY,
        _ => CLASS_CHANGE_PENALTY,
    };
    ratio(a.deflection_rms, b.deflection_rms)
        + ratio(a.force_peak, b.force_peak)
        + (events[0] - events[1]).abs() / events[0].max(events[1]).max(1.0)
        + penalty
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attractor(point_id: u64, period: u64, rms: f64, peak: f64, events: f64) -> Attractor {
        Attractor {
            point_id,
            attractor_id: 0,
            class: if period > 0 { "periodic" } else { "chaotic" }.into(),
            period: (period > 0).then_some(period),
            lambda: None,
            lambda_stderr: None,
            deflection_rms: Some(rms),
            force_peak: Some(peak),
            events_per_cycle: Some(events),
            probes: 1,
            share: 0.5,
            interval: [0.1, 0.9],
            cells: None,
            strobe: Vec::new(),
        }
    }

    fn followed(lengths: [usize; 2], along: usize, attractors: &[Attractor]) -> Vec<usize> {
        let axis = |name: &str, length: usize| Axis {
            name: name.into(),
            unit: "1".into(),
            values: (0..length).map(|i| i as f64).collect(),
        };
        let axes = [axis("a", lengths[0]), axis("b", lengths[1])];
        let points: Vec<PointSummary> = (0..lengths[0] * lengths[1])
            // Point 6 is missing.
            .filter(|id| *id != 6)
            .map(|id| PointSummary {
                point_id: id as u64,
                axis_values: vec![(id / lengths[1]) as f64, (id % lengths[1]) as f64],
                ..PointSummary::default()
            })
            .collect();
        let fixed_axes: Vec<usize> = (0..axes.len()).filter(|axis| *axis != along).collect();
        branches(attractors, &points, &axes, along, &fixed_axes)
    }

    #[test]
    fn a_branch_keeps_its_number_whatever_its_attractor_is_called() {
        let quiet = |id| attractor(id, 1, 1e-6 * (1.0 + 0.1 * id as f64), 1e3, 0.0);
        let loud = |id| attractor(id, 1, 30e-6, 2e4, 4.0);
        // The second point numbers its attractors in reverse; the third point has only one of them.
        let all = [
            quiet(0),
            loud(0),
            loud(1),
            quiet(1),
            loud(2),
            loud(3),
            quiet(3),
        ];
        assert_eq!(followed([1, 4], 1, &all), [0, 1, 1, 0, 1, 1, 2]);
    }

    #[test]
    fn a_period_doubling_continues_and_a_jump_does_not() {
        let all = [
            attractor(0, 1, 1e-6, 1e3, 2.0),
            attractor(1, 2, 1.1e-6, 1.1e3, 2.0),
            attractor(2, 4, 1.2e-6, 1.1e3, 2.0),
            attractor(3, 0, 1.3e-6, 1.2e3, 2.1),
            attractor(4, 0, 9e-6, 8e3, 3.0),
        ];
        assert_eq!(followed([1, 5], 1, &all), [0, 0, 0, 0, 1]);
    }

    #[test]
    fn lines_are_separate_and_holes_end_branches() {
        let same = |id| attractor(id, 1, 1e-6, 1e3, 2.0);
        let all: Vec<Attractor> = (0..8).filter(|id| *id != 6).map(same).collect();
        // Along the second axis: two lines of four points; the third point of the second line is missing.
        assert_eq!(followed([2, 4], 1, &all), [0, 0, 0, 0, 1, 1, 2]);
        // Along the first axis: four lines of two points; the end of the third line is missing.
        assert_eq!(followed([2, 4], 0, &all), [0, 1, 2, 3, 0, 1, 3]);
    }

    /// The nearest of two candidates is matched; the other begins a new branch.
    #[test]
    fn nobody_is_matched_twice() {
        let all = [
            attractor(0, 1, 1e-6, 1e3, 2.0),
            attractor(1, 1, 1.3e-6, 1.2e3, 2.0),
            attractor(1, 1, 1.1e-6, 1.1e3, 2.0),
        ];
        assert_eq!(followed([1, 2], 1, &all), [0, 1, 0]);
    }
}
