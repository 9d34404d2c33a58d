//! What are the deflections and gaps of all contacts at a half step?

use super::Stepping;
use super::mesh_state::MeshState;
use super::tables::dot;

impl Stepping {
    /// Transmission error of a line and its rate at half step `index` of a mesh cycle.
    pub(super) fn error_at(&self, line: usize, cycle: u64, index: usize) -> [f64; 2] {
        let at = self.cycle_in_base_period(cycle) * (2 * self.steps + 1) + index;
        match self.transmission_error[line].get(at) {
            Some(known) => *known,
            None => {
                let time = 0.5 * self.step * index as f64;
                self.lines[line].transmission_error_at(cycle, time).into()
            }
        }
    }

    /// All contacts at half step `index` of a mesh cycle, with the segments of step `j`.
    pub(super) fn mesh_states<const M: usize>(
        &self,
        state: &[f64],
        cycle: u64,
        j: usize,
        index: usize,
    ) -> [MeshState; M] {
        let mut out = [MeshState::default(); M];
        let phase = index as f64 / (2 * self.steps) as f64;
        let mut known: Option<(usize, usize)> = None;
        for contact in 0..self.contacts.len() {
            let direction = self.direction(contact, cycle, j);
            let [gap_error, slope] = self.segment(contact, cycle, j).error_at(phase);
            let half_gap = self.contacts[contact].contact.half_gap;
            // Contacts on one line share their deflection.
            let [deflection, rate] = match known.filter(|(line, _)| *line == direction.line) {
                Some((_, other)) => [out[other].deflection, out[other].rate],
                None => {
                    let [error, error_rate] = self.error_at(direction.line, cycle, index);
                    [
                        dot(&direction.deflection, state) - error,
                        dot(&direction.rate, state) - error_rate,
                    ]
                }
            };
            known = Some((direction.line, contact));
            out[contact] = MeshState {
                time: 0.5 * self.step * index as f64,
                deflection,
                rate,
                gap: [half_gap + gap_error, slope / self.period],
            };
        }
        out
    }
}
