//! Which open contacts are compressed? Their spring and damper together would pull, so that they stay open.

use crate::model::{ActiveSet, Model, Segment};

/// The compressed open contacts. Only contacts that open when their force vanishes are considered.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Compressed {
    /// Compressed contacts that are open because their force vanished.
    pub unladen: ActiveSet,
    /// Passed layers of films: the film is thinner than at the end of the layer.
    pub passed: ActiveSet,
}

impl Compressed {
    /// The compressed contacts of a state at a time \[s\] within a mesh cycle, with the given closed contacts.
    pub fn of(
        model: &Model,
        (closed, segments): (ActiveSet, &[Segment]),
        (cycle, time): (u64, f64),
        state: &[f64],
    ) -> Self {
        let mut compressed = Self::default();
        for (index, contact) in model.contacts.iter().enumerate() {
            if !contact.release.is_by_force() || closed.holds(index) {
                continue;
            }
            let segment = &segments[index];
            let (deflection, _) = model.deflection_on(segment, cycle, state, time);
            let [gap, _] = contact.gap(segment, time);
            let depth = contact.margin(true, deflection, gap);
            if depth >= contact.band {
                compressed.passed = compressed.passed.toggled(index);
            } else if depth > 0.0 {
                compressed.unladen = compressed.unladen.toggled(index);
            }
        }
        compressed
    }

    /// Updates the sets for the layers of films after a contact has opened or closed. If a layer or the flank
    /// is closed, all layers before it count as passed. Layers out of reach on the other side are not
    /// compressed.
    pub fn take_note(&mut self, model: &Model, closed: ActiveSet, segments: &[Segment]) {
        for layer in (0..model.contacts.len()).filter(|layer| model.is_of_film(*layer)) {
            let layer_set = ActiveSet::FREE.toggled(layer);
            if model.is_passed(layer, closed) {
                (self.unladen, self.passed) = (
                    self.unladen.without(layer_set),
                    self.passed.union(layer_set),
                );
            } else if model.is_out_of_reach(layer, segments, closed) {
                (self.unladen, self.passed) = (
                    self.unladen.without(layer_set),
                    self.passed.without(layer_set),
                );
            }
        }
    }
}
