//! Gives all contacts of a model one common set of breakpoints.

use super::{Contact, SAME_PHASE};
use std::collections::BTreeSet;

/// The breakpoints of all contacts, as the bits of mesh phases: the bits of non-negative floats sort like their values.
struct Breakpoints(BTreeSet<u64>);

impl Breakpoints {
    /// The nearest known breakpoint within [`SAME_PHASE`] of a phase; otherwise the phase, which becomes a breakpoint.
    fn one_of(&mut self, phase: f64) -> f64 {
        let bits = phase.to_bits();
        let neighbours = [
            self.0.range(..=bits).next_back(),
            self.0.range(bits..).next(),
        ];
        let off = |known: &f64| (known - phase).abs();
        (neighbours.into_iter().flatten())
            .map(|&known| f64::from_bits(known))
            .filter(|known| off(known) <= SAME_PHASE)
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .unwrap_or_else(|| {
                self.0.insert(bits);
                phase
            })
    }
}

/// Moves the ends of all segments onto one set of breakpoints that are more than [`SAME_PHASE`] apart. An end
/// within this distance of 0, 1 or an earlier breakpoint moves there; earlier contacts come first. A segment whose
/// ends coincide is removed. Without this, breakpoints that differ by rounding would require windows as short as
/// the difference.
pub(super) fn merge(contacts: &mut [Contact]) {
    let ends = [0.0_f64, 1.0].map(f64::to_bits);
    let mut breakpoints = Breakpoints(BTreeSet::from(ends));
    for cycle in contacts.iter_mut().flat_map(|contact| &mut contact.cycles) {
        for segment in &mut cycle.segments {
            segment.start = breakpoints.one_of(segment.start);
            segment.end = breakpoints.one_of(segment.end);
        }
        cycle.segments.retain(|segment| segment.start < segment.end);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Division, MeshCycle};

    /// A contact whose cycle has segments with these ends.
    fn contact(ends: &[f64]) -> Contact {
        let divisions: Vec<Division> = (ends.iter().enumerate())
            .map(|(index, &end)| Division::level(end, 1e8 + index as f64))
            .collect();
        Contact {
            side: 1.0,
            half_gap: 1e-5,
            cycles: vec![MeshCycle::new(1.0, &divisions, &vec![0; ends.len()], 0.0)],
            release: crate::model::Release::Deflection,
            band: f64::INFINITY,
        }
    }

    /// Ends within 1e-11 of an end of the first contact move there. Other ends stay.
    #[test]
    fn breakpoints_that_nearly_coincide_are_one() {
        let next = 0.3_f64.next_up();
        let mut contacts = [
            contact(&[1e-12, 0.3, 0.7, 1.0]),
            contact(&[next, 0.3 + 9e-12, 0.5, 0.7 - 6e-12, 1.0 - 4e-12, 1.0]),
            contact(&[0.3 + 1.2e-11, 0.5 - 8e-12, 1.0]),
        ];
        merge(&mut contacts);
        let ends = contacts.each_ref().map(|contact| -> Vec<f64> {
            let segments = &contact.cycles[0].segments;
            assert_eq!(segments[0].start, 0.0);
            for pair in segments.windows(2) {
                assert_eq!(pair[0].end, pair[1].start);
            }
            segments.iter().map(|segment| segment.end).collect()
        });
        assert_eq!(ends[0], [0.3, 0.7, 1.0]);
        assert_eq!(ends[1], [0.3, 0.5, 0.7, 1.0]);
        assert_eq!(ends[2], [0.3 + 1.2e-11, 0.5, 1.0]);
        // The segments that remain are unchanged. The second contact loses its second and sixth level.
        let levels = contacts[1].cycles[0].segments.iter();
        let levels: Vec<f64> = levels.map(|own| own.stiffness.mean() - 1e8).collect();
        assert_eq!(levels, [0.0, 2.0, 3.0, 4.0]);
    }
}
