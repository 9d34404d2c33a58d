//! Where do dry sliders stand, and do they slip?
//!
//! While a slider slips its block keeps the place where the slip began. [`Model::slid_to`] says where the slip has led.

use super::{ActiveSet, Model, Release, Segment, Slider};

/// Round-off of a deflection, in units of the places that it is the difference of.
const ROUND_OFF: f64 = 1e-13;

impl Model {
    /// Number of modes of the structure alone.
    pub fn modes_of_structure(&self) -> usize {
        self.blocks.len() - self.sliders.len()
    }

    /// Whether flanks or other contacts that can part are closed, the states of dry sliders not counted.
    pub fn touches(&self, active: ActiveSet) -> bool {
        active.iter().any(|contact| !self.is_of_slider(contact))
    }

    /// The closed contacts after a contact has opened or closed: where a slip begins the spring of its slider lets go.
    pub fn toggled(&self, active: ActiveSet, contact: usize) -> ActiveSet {
        let to = active.toggled(contact);
        let own = |slider: &&Slider| slider.slips().contains(&contact);
        match self.sliders.iter().find(own) {
            Some(slider) => to.toggled(slider.spring()),
            None => to,
        }
    }

    /// Where the slider stands in a state without its own block \[m\], whose deflection along its line is `deflection`: it
    /// has slipped up to there.
    pub fn slid_to(&self, slip: usize, deflection: f64) -> f64 {
        let own = &self.contacts[slip];
        deflection - own.side * own.half_gap
    }

    /// Moves every slider that slips to where its slip has led, at a time \[s\] within a mesh cycle.
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

    /// Moves every slider to where its spring has no force, at the start of mesh cycle 0.
    pub(super) fn relax_sliders(&self, state: &mut [f64]) {
        let segments = self.segments_at(0, 0.0);
        for slider in &self.sliders {
            let (stretch, _) = self.deflection_on(&segments[slider.spring()], 0, state, 0.0);
            state[slider.block] += stretch;
        }
    }

    /// Moves sliders whose springs are stretched beyond their limits by as much as that, at the start of a mesh cycle.
    pub(super) fn seat_sliders(&self, segments: &[Segment], cycle: u64, state: &mut [f64]) {
        for slider in &self.sliders {
            let segment = &segments[slider.spring()];
            let (stretch, _) = self.deflection_on(segment, cycle, state, 0.0);
            let most = self.contacts[slider.forwards].half_gap;
            state[slider.block] += stretch - stretch.clamp(-most, most);
        }
    }

    /// Which state of a slider a trajectory is in: the place of its closed contact. It slips where its spring is stretched to
    /// the limit within round-off, and stretches further.
    pub(super) fn state_of_slider(
        &self,
        slider: Slider,
        segments: &[Segment],
        (cycle, time): (u64, f64),
        state: &[f64],
    ) -> usize {
        let segment = &segments[slider.spring()];
        let (stretch, rate) = self.deflection_on(segment, cycle, state, time);
        let slips = |slip: &usize| {
            let Self { contacts, .. } = self;
            let (side, most) = (contacts[*slip].side, contacts[*slip].half_gap);
            let noise = ROUND_OFF * (most + state[slider.block].abs());
            side * stretch >= most - noise && side * rate > 0.0
        };
        (slider.slips().into_iter().find(slips)).unwrap_or(slider.spring())
    }

    /// Whether a contact is a state of a dry slider.
    pub fn is_of_slider(&self, contact: usize) -> bool {
        self.contacts[contact].release.of_slider()
    }

    /// Whether a contact is a slip of a dry slider.
    pub fn is_slip(&self, contact: usize) -> bool {
        self.contacts[contact].release == Release::Slip
    }
}
