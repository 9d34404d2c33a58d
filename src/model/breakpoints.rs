//! Where in a mesh cycle do contacts change what they are, and which of them can change there?

use super::{ActiveSet, Contact, Model, SAME_PHASE, Segment};

impl Model {
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
    /// a prescribed time: where its line or its gap change.
    pub fn turns(&self, contact: &Contact, cycle: u64, segment: usize) -> bool {
        let count = contact.cycles.len() as u64;
        let own = contact.cycle(cycle);
        let before = match segment.checked_sub(1) {
            Some(before) => &own.segments[before],
            None => {
                let earlier = contact.cycle(cycle % count + count - 1);
                &earlier.segments[earlier.segments.len() - 1]
            }
        };
        let after = &own.segments[segment];
        self.line(before) != self.line(after) || !(before.error.is_none() && after.error.is_none())
    }

    /// The contacts that may do so at a phase of a mesh cycle, in order.
    pub fn turning(&self, cycle: u64, phase: f64) -> impl Iterator<Item = usize> {
        (0..self.contacts.len()).filter(move |&index| {
            let contact = &self.contacts[index];
            let mut segments = contact.cycle(cycle).segments.iter();
            let starts = |segment: &Segment| (segment.start - phase).abs() < SAME_PHASE;
            (segments.position(starts)).is_some_and(|own| self.turns(contact, cycle, own))
        })
    }

    /// Whether a contact is open, and cannot close before another one opens: one on the other side
    /// of its line. Every contact is on its segment.
    pub fn is_out_of_reach(&self, contact: usize, segments: &[Segment], active: ActiveSet) -> bool {
        let line = |contact: usize| self.line(&segments[contact]);
        let opposite = |other: usize| {
            let sides = [contact, other].map(|contact| self.contacts[contact].side);
            sides[0] == -sides[1] && line(contact) == line(other)
        };
        !active.holds(contact) && active.iter().any(opposite)
    }

    /// Whether such a change is anywhere in a contact's cycles.
    pub fn ever_turns(&self, contact: &Contact) -> bool {
        (0..contact.cycles.len() as u64).any(|cycle| {
            let segments = contact.cycle(cycle).segments.len();
            (0..segments).any(|segment| self.turns(contact, cycle, segment))
        })
    }
}
