//! Which displacements deflect no contact and cause no force?

use super::Model;

/// A component below this fraction of the largest one is round-off.
const NEGLIGIBLE: f64 = 1e-12;

/// A block is at rest if the rates of its state are below this fraction of their upper bound.
const AT_REST: f64 = 1e-9;

impl Model {
    /// States with a displacement that deflects no contact and causes no force, such as a rotation of the
    /// whole drive under drag. Neutral blocks are excluded. Dry sliders move with the displacement, because a
    /// body that only sliders restrain has no fixed position.
    pub fn unrestrained_displacements(&self) -> Vec<Vec<f64>> {
        let n = self.modes();
        let is_deflected = |contact: usize| {
            let cycles = self.contacts[contact].cycles.iter();
            let segments = cycles.flat_map(|cycle| &cycle.segments);
            segments.map(|segment| self.participations(segment.direction)[0].clone())
        };
        let sliders: Vec<(usize, Vec<f64>)> = (self.sliders.iter())
            .filter_map(|slider| Some((slider.block, is_deflected(slider.spring()).next()?)))
            .collect();
        let is_restrained = |mode: usize| {
            let others = (0..self.contacts.len()).filter(|&other| !self.is_of_slider(other));
            others.flat_map(is_deflected).any(|along| {
                let largest = along.iter().fold(0.0_f64, |most, w| most.max(w.abs()));
                along[mode].abs() > NEGLIGIBLE * largest
            })
        };
        let (alone, rest) = self
            .basis
            .rigid()
            .split_at(self.basis.without_contact().len());
        let with_sliders = rest
            .iter()
            .filter(|&&mode| !sliders.is_empty() && !is_restrained(mode));
        (alone.iter().chain(with_sliders))
            .filter(|mode| !self.neutral.contains(mode))
            .map(|&mode| {
                let mut modes = vec![0.0; 2 * n];
                modes[mode] = 1.0;
                for (block, along) in &sliders {
                    modes[*block] = along[mode];
                }
                let mut state = self.basis.state_of_turned(&modes);
                let largest = state.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                for x in &mut state {
                    if x.abs() <= NEGLIGIBLE * largest {
                        *x = 0.0;
                    }
                }
                state
            })
            .filter(|state| self.is_at_rest(state))
            .collect()
    }

    /// Whether all blocks are at rest, up to round-off, in a state without loads and contact forces.
    pub(super) fn is_at_rest(&self, state: &[f64]) -> bool {
        let n = self.modes();
        let largest = state.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        self.blocks.iter().enumerate().all(|(i, block)| {
            let (x, y) = (state[i], state[n + i]);
            let rests = |row: [f64; 2]| {
                let rate = (row[0] * x + row[1] * y).abs();
                rate <= AT_REST * (row[0].abs() + row[1].abs()) * largest
            };
            block.generator.into_iter().all(rests)
        })
    }
}
