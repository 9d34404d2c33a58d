//! Where in a mesh cycle do contacts change their laws, and which of them can open or close there?

use super::{ActiveSet, Contact, DRIVE_FLANK, Model, SAME_PHASE, Segment};

/// Smallest gap of a flank that does not exist, in units of the model's half gap. A motion counts as diverged
/// before it reaches such a gap.
pub const OUT_OF_REACH: f64 = 1e12;

impl Model {
    /// Whether motion can reach the flanks. A plain oscillator has no flanks.
    pub fn has_flanks(&self) -> bool {
        self.contacts[DRIVE_FLANK].half_gap < OUT_OF_REACH * self.half_gap
    }

    /// Scale of deflections along a line \[m\]: the largest gap of the contacts on the line, but at least the
    /// half gap of the model. Contacts out of reach do not count. Motion may be much larger than a small gap.
    pub fn gap_on(&self, line: usize) -> f64 {
        let on_line = |contact: &&Contact| {
            let mut segments = contact.cycles.iter().flat_map(|cycle| &cycle.segments);
            segments.any(|segment| self.line(segment) == line)
        };
        let there = |contact: &&Contact| contact.half_gap < OUT_OF_REACH * self.half_gap;
        let gaps = self.contacts.iter().filter(on_line).filter(there);
        gaps.fold(self.half_gap, |most, contact| {
            most.max(contact.half_gap.abs())
        })
    }

    /// The segment of every contact at a time \[s\] within a mesh cycle.
    pub fn segments_at(&self, cycle: u64, time: f64) -> Vec<Segment> {
        let at = |contact: &Contact| *contact.cycle(cycle).segment_at(time);
        self.contacts.iter().map(at).collect()
    }

    /// Mesh phases of a mesh cycle at which the segment of some contact ends, in order.
    pub fn segment_ends(&self, cycle: u64) -> Vec<f64> {
        let cycles = self.contacts.iter().map(|contact| contact.cycle(cycle));
        let mut ends: Vec<f64> = (cycles.flat_map(|cycle| &cycle.segments))
            .map(|segment| segment.end)
            .collect();
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|a, b| *a - *b < SAME_PHASE);
        ends
    }

    /// Whether a contact may open or close at the start of a segment of its mesh cycle `cycle`, at
    /// a prescribed time: its line or its gap changes there.
    pub fn changes_direction(&self, contact: &Contact, cycle: u64, segment: usize) -> bool {
        let count = contact.cycles.len() as u64;
        let mesh_cycle = contact.cycle(cycle);
        let before = match segment.checked_sub(1) {
            Some(before) => &mesh_cycle.segments[before],
            None => {
                let earlier = contact.cycle(cycle % count + count - 1);
                &earlier.segments[earlier.segments.len() - 1]
            }
        };
        let after = &mesh_cycle.segments[segment];
        self.line(before) != self.line(after) || !(before.error.is_none() && after.error.is_none())
    }

    /// The contacts that may open or close at a phase of a mesh cycle because their line or gap changes
    /// there, in order.
    pub fn turning(&self, cycle: u64, phase: f64) -> impl Iterator<Item = usize> {
        (0..self.contacts.len()).filter(move |&index| {
            let contact = &self.contacts[index];
            let mut segments = contact.cycle(cycle).segments.iter();
            let starts = |segment: &Segment| (segment.start - phase).abs() < SAME_PHASE;
            (segments.position(starts))
                .is_some_and(|segment| self.changes_direction(contact, cycle, segment))
        })
    }

    /// Whether a contact is open, and cannot close before another contact opens: a closed contact faces it on its
    /// line, or it is a film layer that has been passed ([`Self::is_passed`]). `segments` has the segment of every
    /// contact.
    pub fn is_out_of_reach(&self, contact: usize, segments: &[Segment], active: ActiveSet) -> bool {
        let line = |contact: usize| self.line(&segments[contact]);
        let opposite = |other: usize| {
            let sides = [contact, other].map(|contact| self.contacts[contact].side);
            sides[0] == -sides[1]
                && self.contacts[other].release.has_surface()
                && line(contact) == line(other)
        };
        !active.holds(contact) && (active.iter().any(opposite) || self.is_passed(contact, active))
    }

    /// Whether the line or the gap of a contact changes at the start of any segment of its cycles.
    pub fn ever_turns(&self, contact: &Contact) -> bool {
        (0..contact.cycles.len() as u64).any(|cycle| {
            let segments = contact.cycle(cycle).segments.len();
            (0..segments).any(|segment| self.changes_direction(contact, cycle, segment))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{COAST_FLANK, Division, Drive, FlankError, MeshCycle, fixtures};

    /// Two flanks on one line. Both lack material from phase 0.3 to 0.7 of the mesh cycle.
    fn model() -> Model {
        let structure = fixtures::structure(&[0.0, 3000.0], 0.01, &[1.0, 0.3], &[1.0, 0.3]);
        let mut drive = fixtures::constant_mesh(1e-5, 4e8);
        drive.mesh = Division::levels(&[4e8, 3e8, 4e8], &[0.3, 0.7]);
        drive.mesh[1].error = FlankError::series([2e-6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap()
    }

    #[test]
    fn the_flank_behind_is_out_of_reach() {
        let model = model();
        let segments = model.segments_at(0, 0.0);
        let both = ActiveSet::DRIVE.toggled(COAST_FLANK);
        for (active, out) in [
            (ActiveSet::FREE, [false, false]),
            (ActiveSet::DRIVE, [false, true]),
            (ActiveSet::COAST, [true, false]),
            (both, [false, false]),
        ] {
            let found = [0, 1].map(|flank| model.is_out_of_reach(flank, &segments, active));
            assert_eq!(found, out, "{active:?}");
        }
    }

    #[test]
    fn contacts_turn_where_their_gap_changes() {
        let model = model();
        assert_eq!(model.segment_ends(0), [0.3, 0.7, 1.0]);
        let flank = &model.contacts[0];
        let turns = [0, 1, 2].map(|segment| model.changes_direction(flank, 5, segment));
        assert_eq!(turns, [false, true, true]);
        for (phase, turning) in [
            (0.0, vec![]),
            (0.3, vec![0, 1]),
            (0.5, vec![]),
            (0.7, vec![0, 1]),
        ] {
            assert_eq!(
                model.turning(0, phase).collect::<Vec<_>>(),
                turning,
                "{phase}"
            );
        }
        assert!(model.ever_turns(flank));
        let phases = [0.1, 0.3, 0.69, 0.7].map(|phase| {
            let segments = model.segments_at(0, phase * model.period());
            assert_eq!(segments[0], segments[1]);
            segments[0].start
        });
        assert_eq!(phases, [0.0, 0.3, 0.3, 0.7]);
        let level = Drive {
            mesh: Division::levels(&[4e8, 3e8], &[]),
            ..fixtures::constant_mesh(1e-5, 4e8)
        };
        let structure = fixtures::one_mode(3000.0);
        let level = Model::new(&structure, &level, fixtures::strong_rattle()).unwrap();
        assert!(!level.ever_turns(&level.contacts[0]));
    }

    /// The segment before the first one is the last one of the previous mesh cycle, also if mesh cycles
    /// differ.
    #[test]
    fn what_was_before_is_of_the_cycle_before() {
        let mut model = model();
        let with_gap_error = Segment {
            start: 0.0,
            ..model.first_cycle().segments[1]
        };
        let plain = Segment {
            error: FlankError::NONE,
            ..with_gap_error
        };
        let period = model.period();
        let whole = |segment: Segment| MeshCycle {
            period,
            segments: vec![Segment {
                end: 1.0,
                ..segment
            }],
        };
        // Only the second of three cycles has missing material.
        model.contacts[0].cycles = [plain, with_gap_error, plain].map(whole).to_vec();
        let turns =
            [0, 1, 2, 3, 4, 5].map(|cycle| model.changes_direction(&model.contacts[0], cycle, 0));
        assert_eq!(turns, [false, true, true, false, true, true]);
        assert!(model.ever_turns(&model.contacts[0]));
    }
}
