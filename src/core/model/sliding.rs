//! What are the positions of dry sliders, and do they slip?
//!
//! While a slider slips, its block keeps the position at the start of the slip. [`Model::slid_to`] gives the
//! position at the end of the slip.

use super::{ActiveSet, Model, Release, Segment, Slider};

/// Round-off of a deflection, relative to the moduli of its terms.
const ROUND_OFF: f64 = 1e-13;

impl Model {
    /// Number of modes of the structure without sliders.
    pub fn modes_of_structure(&self) -> usize {
        self.blocks.len() - self.sliders.len()
    }

    /// Whether a contact that can separate is closed. States of dry sliders and of dry friction do not count.
    pub fn touches(&self, active: ActiveSet) -> bool {
        let parts = |contact: usize| {
            let release = self.contacts[contact].release;
            !(release.of_slider() || release.of_friction())
        };
        active.iter().any(parts)
    }

    /// The closed contacts after a contact has opened or closed. A dry slider or dry friction changes by a slip: if
    /// the slip closes, its spring or its stick opens, and vice versa. If a layer of a film or the flank closes, the
    /// other contacts of the film open.
    pub fn toggled(&self, active: ActiveSet, contact: usize) -> ActiveSet {
        let mut to = active.toggled(contact);
        if to.holds(contact) && self.film_layers > 0 {
            to = to.without(self.others_of_film(contact));
        }
        let has_contact = |slider: &&Slider| slider.slips().contains(&contact);
        let slider = self
            .sliders
            .iter()
            .find(has_contact)
            .map(|slider| slider.spring());
        let stick = || self.friction_of(contact).map(|friction| friction.stick());
        match slider.or_else(stick) {
            Some(other) => to.toggled(other),
            None => to,
        }
    }

    /// The position of a slipping slider \[m\], from the deflection along its line in a state with 0 in its
    /// block.
    pub fn slid_to(&self, slip: usize, deflection: f64) -> f64 {
        let contact = &self.contacts[slip];
        deflection - contact.side * contact.half_gap
    }

    /// Moves every slipping slider to its present position, at a time \[s\] within a mesh cycle.
    pub fn let_slide(
        &self,
        (active, segments): (ActiveSet, &[Segment]),
        (cycle, time): (u64, f64),
        state: &mut [f64],
    ) {
        for slider in &self.sliders {
            for slip in slider
                .slips()
                .into_iter()
                .filter(|slip| active.holds(*slip))
            {
                state[slider.block] = 0.0;
                let (deflection, _) = self.deflection_on(&segments[slip], cycle, state, time);
                state[slider.block] = self.slid_to(slip, deflection);
            }
        }
    }

    /// Moves every slider to the position at which its spring has no force, at the start of mesh cycle 0.
    pub(super) fn relax_sliders(&self, state: &mut [f64]) {
        let segments = self.segments_at(0, 0.0);
        for slider in &self.sliders {
            let (stretch, _) = self.deflection_on(&segments[slider.spring()], 0, state, 0.0);
            state[slider.block] += stretch;
        }
    }

    /// Moves every slider whose spring is stretched beyond its limit to that limit, at the start of a mesh
    /// cycle.
    pub(super) fn clamp_sliders(&self, segments: &[Segment], cycle: u64, state: &mut [f64]) {
        for slider in &self.sliders {
            let segment = &segments[slider.spring()];
            let (stretch, _) = self.deflection_on(segment, cycle, state, 0.0);
            let most = self.contacts[slider.forwards].half_gap;
            state[slider.block] += stretch - stretch.clamp(-most, most);
        }
    }

    /// The state of a slider in a trajectory, as the index of its closed contact. It slips if its spring is stretched
    /// to the limit within round-off, and is being stretched further.
    pub(super) fn state_of_slider(
        &self,
        slider: Slider,
        segments: &[Segment],
        (cycle, time): (u64, f64),
        state: &[f64],
    ) -> usize {
        let segment = &segments[slider.spring()];
        let (stretch, rate) = self.deflection_on(segment, cycle, state, time);
        let n = self.blocks.len();
        let gains = self.directions[segment.direction].gains.iter().enumerate();
        let size: f64 = gains
            .map(|(i, gain)| {
                let [x, y] = gain.deflection;
                (x * state[i]).abs() + (y * state[n + i]).abs()
            })
            .sum();
        let slips = |slip: &usize| {
            let Self { contacts, .. } = self;
            let (side, most) = (contacts[*slip].side, contacts[*slip].half_gap);
            let noise = ROUND_OFF * (most + size);
            side * stretch >= most - noise && side * rate > 0.0
        };
        (slider.slips().into_iter().find(slips)).unwrap_or(slider.spring())
    }

    /// Whether a contact is a state of a dry slider.
    pub fn is_of_slider(&self, contact: usize) -> bool {
        self.contacts[contact].release.of_slider()
    }

    /// Whether a contact is a slip of a dry slider or of dry friction.
    pub fn is_slip(&self, contact: usize) -> bool {
        matches!(self.contacts[contact].release, Release::Slip | Release::Rub)
    }
}

#[cfg(test)]
mod tests {
    use crate::model::{Model, OperatingPoint, fixtures};
    use crate::structure::{ModalStructure, StructureContact};

    /// A stretch counts as at its limit if the difference is round-off of two large displacements.
    #[test]
    fn round_off_of_large_displacements_hides_no_slip() {
        let mut structure = ModalStructure::of_modes(&[1.0; 2], 0.0, &[1.0, 0.0], &[1.0, 0.0]);
        structure.contacts = StructureContact::slider("element", &[1.0, -1.0], 1.0, 1e-3).into();
        let point = OperatingPoint {
            load: 0.0,
            speed: 1.0,
        };
        let model = Model::new(&structure, &fixtures::constant_mesh(1e4, 1.0), point).unwrap();
        let [forwards, _] = model.sliders[0].slips();
        let segments = model.segments_at(0, 0.0);
        for (first, slips) in [(1000.001, true), (1000.0005, false)] {
            let short = 1e-3 - (first - 1000.0);
            assert!(short > 1e-16, "{short}");
            let state = [first, 1000.0, 0.0, 1.0, 0.0, 0.0];
            let active = model.active_set(&segments, 0, &state, 0.0);
            assert_eq!(active.holds(forwards), slips, "{first}");
        }
    }
}
