//! Which open contacts are compressed, although no force closes them?

use crate::model::{ActiveSet, Model, Segment};

/// Compressed open contacts, among those that open when their force vanishes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Compressed {
    /// Contacts whose force vanished and that are not yet free.
    pub unladen: ActiveSet,
    /// Layers of films that have been passed: the film is thinner than the layer.
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

    /// Updates the sets for the layers of films after a contact has opened or closed. If a layer, or the flank behind
    /// it, is closed, all layers before it count as passed. Layers out of reach on the other side are free.
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
