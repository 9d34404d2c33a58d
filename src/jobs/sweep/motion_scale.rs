//! The length by which orbits of an oscillator are measured: the size of its motion. An oscillator has no
//! half gap as a scale, and distances must not depend on the length in a manifest.

use super::family::PointFamily;
use crate::analysis::continuation::drive::DriveMap;
use crate::analysis::continuation::map::{MapError, MapParameters};
use crate::analysis::continuation::orbit::length;
use crate::model::InitialState;

/// Cycles before the measurement of the motion, and cycles of the measurement.
const CYCLES: [u64; 2] = [100, 64];

/// The family, with the size of its motion at `at` as the scale of lengths. The scale is rounded to a power
/// of two, so that round-off in the motion does not change it. A family with flanks keeps its half gap. A family
/// without motion, or whose integration stops, keeps its scale.
///
/// # Errors
/// [`MapError`] if the model cannot be built.
pub(super) fn measured<'a>(
    mut family: PointFamily<'a>,
    at: MapParameters,
    initial: &InitialState,
) -> Result<PointFamily<'a>, MapError> {
    let Some(given) = family.point.mesh.length else {
        return Ok(family);
    };
    let mut map = DriveMap::new(&family, at)?;
    let mut state = map.model(at)?.start(initial);
    let mut largest = 0.0_f64;
    let [before, over] = CYCLES;
    let mut failed = map.advance(at, before, &mut state, &mut ()).is_err();
    for _ in 0..over {
        failed = failed || map.advance(at, 1, &mut state, &mut ()).is_err();
        largest = largest.max(length(&map.coordinates(&state.state)));
    }
    let scale = (given * largest).log2().round().exp2();
    if !failed && scale.is_normal() {
        family.point.mesh = family.point.mesh.measured_by(scale);
    }
    Ok(family)
}
