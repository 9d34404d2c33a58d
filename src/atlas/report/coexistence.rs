//! Points whose probes settled on several attractors: the ways in which probes ended, with their shares.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Serialize;

use super::point::PointSummary;
use crate::store::{ResultTable, StoreError, TableKind};

/// The ways in which the probes of a point ended, if they found several attractors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coexistence {
    /// The point.
    pub point_id: u64,
    /// Attractors by number, then the probes that settled on none, by status.
    pub endings: Vec<Ending>,
}

/// One way in which probes of a point ended.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ending {
    /// Number of the attractor; `None` for probes that settled on none.
    pub attractor: Option<u64>,
    /// Status of the first probe with this ending.
    pub status: String,
    /// Kind of motion of this probe.
    pub class: Option<String>,
    /// Period of the motion, if it has one.
    pub period: Option<u64>,
    /// RMS of the deflection about its mean \[m\], of the first probe with this ending.
    pub deflection_rms: Option<f64>,
    /// Probes with this ending.
    pub probes: usize,
    /// Share of the point's probes with this ending.
    pub share: f64,
    /// The 95 % interval of the share.
    pub interval: [f64; 2],
}

/// The endings of points with more than one attractor, in `point_id` order.
pub(super) fn read(folder: &Path, points: &[PointSummary]) -> Result<Vec<Coexistence>, StoreError> {
    let several: BTreeSet<Option<u64>> = points.iter().map(|p| Some(p.point_id)).collect();
    if several.is_empty() {
        return Ok(Vec::new());
    }
    let table = ResultTable::read(folder, TableKind::Probes)?;
    let (ids, attractors) = (table.u64("point_id")?, table.u64("attractor_id")?);
    let (statuses, classes) = (table.text("status")?, table.text("class")?);
    let (periods, rms) = (table.u64("period")?, table.f64("deflection_rms")?);
    let shares = ["basin_share", "basin_low", "basin_high"].map(|name| table.f64(name));
    let [share, low, high] = shares;
    let (share, low, high) = (share?, low?, high?);
    let mut points: Vec<Coexistence> = Vec::new();
    for row in (0..table.rows()).filter(|&row| several.contains(&ids[row])) {
        let point_id = ids[row].unwrap_or_default();
        let status = statuses[row].clone().unwrap_or_default();
        if points.last().is_none_or(|last| last.point_id != point_id) {
            let endings = Vec::new();
            points.push(Coexistence { point_id, endings });
        }
        let Some(point) = points.last_mut() else {
            continue;
        };
        let attractor = attractors[row];
        let same_ending = |ending: &&mut Ending| {
            ending.attractor == attractor && (attractor.is_some() || ending.status == status)
        };
        if let Some(ending) = point.endings.iter_mut().find(same_ending) {
            ending.probes += 1;
            continue;
        }
        point.endings.push(Ending {
            attractor,
            status,
            class: classes[row].clone(),
            period: periods[row],
            deflection_rms: rms[row],
            probes: 1,
            share: share[row].unwrap_or_default(),
            interval: [low[row], high[row]].map(Option::unwrap_or_default),
        });
    }
    for point in &mut points {
        let order = |e: &Ending| (e.attractor.is_none(), e.attractor, e.status.clone());
        point.endings.sort_by_key(order);
    }
    Ok(points)
}
