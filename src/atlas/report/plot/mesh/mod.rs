//! Pictures of a mesh table over the mesh phase.

mod curves;
mod data;
mod labels;
mod pattern;
mod sharing;

use super::error::PlotError;
use super::picture::Drawn;
use super::picture_kind::PictureKind;

pub(super) use data::MeshCurves;

/// Draws one kind of picture.
pub(super) fn draw(what: PictureKind, mesh: &MeshCurves) -> Result<Drawn, PlotError> {
    match what {
        PictureKind::Mesh => Ok(curves::draw(mesh)),
        PictureKind::Sharing => Ok(sharing::draw(mesh)),
        PictureKind::Contact => pattern::draw(mesh),
        _ => Err(what.unfit("give a folder that `atlas run` or `atlas trace` wrote")),
    }
}

/// At most `most` of `count` indices, evenly spread, including the first and the last.
fn spread(count: usize, most: usize) -> Vec<usize> {
    let shown = count.min(most);
    (0..shown)
        .map(|i| i * (count - 1) / (shown - 1).max(1))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_places_keep_both_ends() {
        assert_eq!(spread(1, 5), [0]);
        assert_eq!(spread(3, 5), [0, 1, 2]);
        assert_eq!(spread(9, 5), [0, 2, 4, 6, 8]);
        assert_eq!(spread(12, 3), [0, 5, 11]);
    }
}
