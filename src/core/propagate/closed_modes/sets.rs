//! Which linear systems does a drive have? One for each set of closed contacts and each combination of their classes.

use crate::model::{ActiveSet, Contact, Model, Release};
use crate::propagate::TableError;

/// Largest number of contacts of a drive.
pub const MOST_CONTACTS: usize = 24;

/// A time is on a breakpoint if their distance, relative to the mesh period, is at most this.
pub const SAME_TIME: f64 = 1e-13;

/// Properties of a closed contact on a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactClass {
    /// Stiffness k \[N/m\].
    pub stiffness: f64,
    /// Damping c \[N s/m\].
    pub damping: f64,
    /// Index among the directions of the model.
    pub direction: usize,
}

/// The numbered systems of a drive. Each contact has a state: 0 if it is open, else its class plus 1. A `set` is the
/// number of a system.
#[derive(Debug, Clone)]
pub struct Sets {
    /// Classes of each contact.
    classes: Vec<Vec<ContactClass>>,
    /// State that each contact has if it is closed, on each segment of each of its mesh cycles.
    segment_states: Vec<Vec<Vec<usize>>>,
    /// Weight of each contact's state in the number of a system.
    weights: Vec<usize>,
    count: usize,
}

impl Sets {
    /// The systems of a model.
    ///
    /// # Errors
    /// Stiffness that is negative or varies within a segment, flanks with errors, contacts that do not open at the
    /// gap, too many contacts or systems.
    pub fn new(model: &Model) -> Result<Self, TableError> {
        let mut sets = Self {
            classes: Vec::new(),
            segment_states: Vec::new(),
            weights: Vec::new(),
            count: 1,
        };
        if model.has_negative_stiffness() {
            return Err(TableError::Softening);
        }
        for contact in &model.contacts {
            match contact.release {
                Release::Deflection => {}
                Release::Force => return Err(TableError::Release),
                Release::Film => return Err(TableError::Film),
                Release::Slip | Release::Stick => return Err(TableError::Slider),
                Release::Impact | Release::Rest => return Err(TableError::RigidStop),
                Release::Rub | Release::Grip => return Err(TableError::DryFriction),
            }
            let mut classes: Vec<ContactClass> = Vec::new();
            let mut segment_states = Vec::new();
            for cycle in &contact.cycles {
                let mut states = Vec::new();
                for segment in &cycle.segments {
                    if !segment.stiffness.is_constant() {
                        return Err(TableError::VaryingStiffness);
                    }
                    if !segment.error.is_none() {
                        return Err(TableError::FlankError);
                    }
                    let class = ContactClass {
                        stiffness: segment.stiffness.mean(),
                        damping: segment.damping,
                        direction: segment.direction,
                    };
                    let index = classes.iter().position(|other| *other == class);
                    states.push(1 + index.unwrap_or(classes.len()));
                    if index.is_none() {
                        classes.push(class);
                    }
                }
                segment_states.push(states);
            }
            sets.weights.push(sets.count);
            sets.count = sets.count.saturating_mul(1 + classes.len());
            sets.classes.push(classes);
            sets.segment_states.push(segment_states);
        }
        let contacts = model.contacts.len();
        if contacts > MOST_CONTACTS || sets.count == usize::MAX {
            return Err(TableError::TooManySets {
                contacts,
                most: MOST_CONTACTS,
            });
        }
        Ok(sets)
    }

    /// Largest number of systems for which all tables are computed.
    pub const MOST_PRECOMPUTED: usize = 256;

    /// Free flight: no contact is closed.
    pub const FREE: usize = 0;

    /// Number of systems.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether tables of all systems are computed.
    pub fn are_few(&self) -> bool {
        self.count <= Self::MOST_PRECOMPUTED
    }

    /// The set in which every contact is closed at its stiffest.
    pub fn stiffest(&self) -> usize {
        let stiffness = |contact: usize, state: usize| self.class(contact, state).stiffness;
        (0..self.classes.len()).fold(Self::FREE, |set, contact| {
            let states = 1..=self.classes[contact].len();
            let state =
                states.max_by(|&a, &b| stiffness(contact, a).total_cmp(&stiffness(contact, b)));
            self.with(set, contact, state.unwrap_or(0))
        })
    }

    /// State of a contact in a set.
    pub fn state(&self, set: usize, contact: usize) -> usize {
        set / self.weights[contact] % (1 + self.classes[contact].len())
    }

    /// The set with a contact in another state.
    #[inline]
    pub fn with(&self, set: usize, contact: usize, state: usize) -> usize {
        set + self.weights[contact] * state - self.weights[contact] * self.state(set, contact)
    }

    /// Class of a closed contact in a state.
    #[inline]
    pub fn class(&self, contact: usize, state: usize) -> ContactClass {
        self.classes[contact][state - 1]
    }

    /// The closed contacts of a set, each with its class.
    pub fn closed(&self, set: usize) -> impl Iterator<Item = (usize, ContactClass)> {
        (0..self.classes.len()).filter_map(move |contact| {
            let state = self.state(set, contact);
            (state > 0).then(|| (contact, self.class(contact, state)))
        })
    }

    /// The set in which the contacts `active` are closed, each in its state from `closed`.
    #[inline]
    pub fn of(&self, active: ActiveSet, closed: &[usize]) -> usize {
        (active.iter()).fold(Self::FREE, |set, contact| {
            set + self.weights[contact] * closed[contact]
        })
    }

    /// State and line of every contact at the start of each mesh cycle of a base period. The state applies if the contact is
    /// closed.
    pub fn starts(&self, model: &Model) -> Vec<Vec<(usize, usize)>> {
        let of_cycle = |cycle: u64| {
            let of_contact = |(contact, contact_data): (usize, &Contact)| {
                let which = (cycle % contact_data.cycles.len() as u64) as usize;
                let line = model.line(contact_data.cycle(cycle).segment_at(0.0));
                (self.segment_states[contact][which][0], line)
            };
            model.contacts.iter().enumerate().map(of_contact).collect()
        };
        (0..model.base_cycles() as u64).map(of_cycle).collect()
    }

    /// The possible changes out of a set, each as a contact and its new state. The contact opens, closes, or passes to
    /// another segment.
    pub fn changes(&self, set: usize) -> Vec<(usize, usize)> {
        let mut out = Vec::new();
        for (contact, cycles) in self.segment_states.iter().enumerate() {
            let now = self.state(set, contact);
            if now == 0 {
                out.extend((1..=self.classes[contact].len()).map(|state| (contact, state)));
                continue;
            }
            out.push((contact, 0));
            if self.classes[contact].len() == 1 {
                continue;
            }
            let all: Vec<usize> = cycles.iter().flatten().copied().collect();
            let following = all.iter().copied().cycle().skip(1);
            let mut next: Vec<usize> = (all.iter().zip(following))
                .filter(|&(&before, after)| before == now && after != now)
                .map(|(_, after)| after)
                .collect();
            next.sort_unstable();
            next.dedup();
            out.extend(next.into_iter().map(|state| (contact, state)));
        }
        out
    }
}

/// A time of a mesh cycle at which a closed contact changes its class, or any contact its line.
#[derive(Debug, Clone, Copy)]
pub struct CycleBreakpoint {
    /// Time within the cycle \[s\].
    pub time: f64,
    /// The contact.
    pub contact: usize,
    /// Its state after the breakpoint, if it is closed.
    pub state: usize,
    /// Its line after the breakpoint.
    pub line: usize,
    /// Whether the line changes.
    pub turns: bool,
}

impl Sets {
    /// The breakpoints of each mesh cycle of a base period, in order, without the start of a cycle.
    pub fn breakpoints(&self, model: &Model) -> Vec<Vec<CycleBreakpoint>> {
        let of_cycle = |cycle: u64| {
            let mut breakpoints = Vec::new();
            for (contact, contact_data) in model.contacts.iter().enumerate() {
                let which = (cycle % contact_data.cycles.len() as u64) as usize;
                let segments = &contact_data.cycles[which].segments;
                let states = &self.segment_states[contact][which];
                for index in 1..segments.len() {
                    let line = model.line(&segments[index]);
                    let turns = model.line(&segments[index - 1]) != line;
                    if turns || states[index - 1] != states[index] {
                        breakpoints.push(CycleBreakpoint {
                            time: model.period() * segments[index].start,
                            contact,
                            state: states[index],
                            line,
                            turns,
                        });
                    }
                }
            }
            breakpoints.sort_by(|a, b| a.time.total_cmp(&b.time));
            breakpoints
        };
        (0..model.base_cycles() as u64).map(of_cycle).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::fixtures;

    /// Two flanks with two stiffness levels give nine systems. The number of a system yields each contact's state.
    #[test]
    fn systems_are_numbered_by_the_states_of_their_contacts() {
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &[1.0, 0.5], &[1.0, 0.5]);
        let drive = fixtures::two_level_mesh(1e-5);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        let sets = Sets::new(&model).unwrap();
        assert_eq!(sets.count(), 9);
        for set in 0..9 {
            for contact in 0..2 {
                for state in 0..3 {
                    let other = sets.with(set, contact, state);
                    assert_eq!(sets.state(other, contact), state);
                    assert_eq!(sets.state(other, 1 - contact), sets.state(set, 1 - contact));
                }
            }
            let changes = sets.changes(set);
            // An open contact may close on either level; a closed one opens or comes to the other level.
            assert_eq!(changes.len(), 4);
        }
        let breakpoints = sets.breakpoints(&model);
        assert_eq!((breakpoints.len(), breakpoints[0].len()), (1, 2));
        let starts = &sets.starts(&model)[0];
        assert_eq!((starts[0].0, breakpoints[0][0].state), (1, 2));
        let closed: Vec<usize> = starts.iter().map(|(state, _)| *state).collect();
        assert_eq!(sets.of(ActiveSet::FREE, &closed), Sets::FREE);
        assert_eq!(sets.closed(sets.of(ActiveSet::DRIVE, &closed)).count(), 1);
    }
}
