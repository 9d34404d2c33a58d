//! The meshes of a train, ranked by their rattle.

use super::error::ReportError;
use crate::store::{ResultTable, TableKind};
use crate::structure::SliderPart;
use crate::sweep::NO_FLANKS;
use serde::Serialize;
use std::path::Path;

/// The column with the rattle index of every contact: the sum of |δ'| at its impacts, divided by time.
const COLUMN: &str = "contact_rattle_index";

/// Rattle of a mesh, or of another pair of contacts, over the points of a results folder.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rattle {
    /// Common name of its contacts: the names of its gears, or `stage 1 of engine and input`.
    pub name: String,
    /// Mean over the points of the sum of its contacts' rattle indices \[m/s², of stages rad/s²\].
    pub mean: f64,
    /// Largest sum among the points.
    pub largest: f64,
    /// The point with the largest sum.
    pub point_id: u64,
}

/// The rattle of all meshes, stages and stops, the largest mean first; empty if contacts have no names, or if there
/// is only one entry.
///
/// # Errors
/// A table cannot be read.
pub(super) fn ranked(folder: &Path, head: &ResultTable) -> Result<Vec<Rattle>, ReportError> {
    let columns = head.columns()?;
    let Some(column) = columns.iter().find(|column| column.name == COLUMN) else {
        return Ok(Vec::new());
    };
    let mut ranking: Vec<Rattle> = Vec::new();
    // For each contact, the index of its mesh in `ranking`. `None` for the states of a dry slider and for
    // flanks that do not exist: they do not rattle.
    let places: Vec<Option<usize>> = (column.elements.iter())
        .map(|contact| {
            if is_of_slider(contact) || NO_FLANKS.contains(&contact.as_str()) {
                return None;
            }
            let name = common(contact);
            let known = ranking.iter().position(|entry| entry.name == name);
            known.or_else(|| {
                ranking.push(Rattle {
                    name: name.to_owned(),
                    mean: 0.0,
                    largest: 0.0,
                    point_id: 0,
                });
                Some(ranking.len() - 1)
            })
        })
        .collect();
    if ranking.len() < 2 {
        return Ok(Vec::new());
    }
    let mut points = 0_usize;
    ResultTable::scan(folder, TableKind::Points, &["point_id", COLUMN], |part| {
        let rows = part.u64("point_id")?.into_iter().zip(part.lists(COLUMN)?);
        for (point_id, indices) in rows {
            let Some(indices) = indices else { continue };
            points += 1;
            let mut together = vec![0.0; ranking.len()];
            for (&place, index) in places.iter().zip(indices) {
                if let Some(place) = place {
                    together[place] += index.unwrap_or(0.0);
                }
            }
            for (entry, index) in ranking.iter_mut().zip(together) {
                entry.mean += index;
                if index > entry.largest {
                    entry.largest = index;
                    entry.point_id = point_id.unwrap_or_default();
                }
            }
        }
        Ok::<_, ReportError>(())
    })?;
    ranking
        .iter_mut()
        .for_each(|entry| entry.mean /= points.max(1) as f64);
    ranking.sort_by(|a, b| b.mean.total_cmp(&a.mean));
    Ok(ranking)
}

fn is_of_slider(contact: &str) -> bool {
    let state = contact.rsplit_once(", ").map(|(_, state)| state);
    SliderPart::ALL
        .iter()
        .any(|(_, suffix)| Some(*suffix) == state)
}

/// The common name of both contacts of a mesh, of a stage or of a rigid stop.
fn common(contact: &str) -> &str {
    let flank = ["drive flank of ", "coast flank of "];
    let mesh = flank.iter().find_map(|side| contact.strip_prefix(side));
    let way = [", forward", ", backward", ", rest"];
    let stage = || way.iter().find_map(|way| contact.strip_suffix(way));
    mesh.or_else(stage).unwrap_or(contact)
}

#[cfg(test)]
mod tests {
    use super::{common, is_of_slider};

    #[test]
    fn contacts_of_a_mesh_and_of_a_stage_have_one_name() {
        for (contact, name) in [
            ("drive flank of z20 and z50", "z20 and z50"),
            ("coast flank of z20 and z50", "z20 and z50"),
            ("buffer, rest", "buffer"),
            (
                "stage 1 of engine and input, backward",
                "stage 1 of engine and input",
            ),
            ("stop of output", "stop of output"),
        ] {
            assert_eq!(common(contact), name);
            assert!(!is_of_slider(contact));
        }
        assert!(is_of_slider("friction 1 of engine and input, stick"));
    }
}
