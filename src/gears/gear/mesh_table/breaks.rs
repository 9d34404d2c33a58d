//! Where do the flanks cut the mesh cycle? Between these cuts gaps and compliances of the pairs change smoothly with
//! the mesh phase. Loads cut the cycle further ([`super::pieces`]).

use super::error::MeshTableError;
use crate::gear::FlankLaw;

/// Cuts closer than this, in cycles, coincide: only rounding separates them.
pub(super) const SAME: f64 = 1e-9;

/// Ends of the stretches of the mesh cycle, 0 first and 1 last.
///
/// The cycle is cut at the phases at which a pair comes within reach, leaves it, passes the pitch point or passes a
/// kink of the law. On a helical face of the given width \[m\] the cuts are the phases at which either end of the face
/// does so. Stretches between the cuts are divided equally, into the smallest number of parts not longer than
/// `longest`.
///
/// # Errors
/// A path that is not finite, has no direction, or is shorter than a base pitch.
pub(in crate::gear) fn breaks(
    law: &impl FlankLaw,
    width: f64,
    longest: f64,
) -> Result<Vec<f64>, MeshTableError> {
    let path = law.path();
    let contact_ratio = (path.end - path.start) / path.base_pitch;
    let valid = contact_ratio >= 1.0 - SAME && contact_ratio.is_finite() && path.base_pitch > 0.0;
    if !valid {
        return Err(MeshTableError::Path {
            start: path.start,
            end: path.end,
            base_pitch: path.base_pitch,
            contact_ratio,
        });
    }
    let (kinks, [first, last]) = (law.kinks(), law.reach());
    let inside = |s: &f64| *s > first && *s < last;
    let ahead = 0.5 * width * law.helix();
    let ends = if ahead == 0.0 { vec![0.0] } else { vec![-ahead, ahead] };
    let marks = [first, last]
        .into_iter()
        .chain([path.pitch_point].into_iter().chain(kinks).filter(inside));
    let mut cuts: Vec<f64> = marks
        .flat_map(|s| ends.iter().map(move |end| s - end))
        .map(|s| ((s - path.start) / path.base_pitch).rem_euclid(1.0))
        .chain([0.0, 1.0])
        .collect();
    cuts.sort_by(f64::total_cmp);
    // The ends 0 and 1 stay: drop cuts within rounding of them.
    cuts.retain(|&cut| cut == 0.0 || cut == 1.0 || (cut > SAME && cut < 1.0 - SAME));
    cuts.dedup_by(|later, earlier| *later - *earlier < SAME);
    let mut breaks = vec![0.0];
    for stretch in cuts.windows(2) {
        let [from, to] = [stretch[0], stretch[1]];
        // A length that is a multiple of the longest up to rounding counts as that multiple.
        let parts = ((to - from) / longest - SAME).ceil().max(1.0);
        for part in 1..parts as usize {
            breaks.push(from + (to - from) * part as f64 / parts);
        }
        breaks.push(to);
    }
    Ok(breaks)
}
