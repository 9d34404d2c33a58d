//! The energy that impacts on rigid stops take from the structure.
//!
//! An impulse J along g changes the state by −g J. The window that starts at the impacts has the state after
//! them. The energy before them follows from this state with the impulses reversed.

use super::balance::Balance;
use crate::propagate::Event;

impl Balance<'_> {
    /// Records an event.
    pub fn event(&mut self, event: &Event) {
        let stop = self.model().stop_of(event.contact);
        let struck = stop.filter(|stop| stop.impact == event.contact && event.closes());
        if let Some(stop) = struck {
            let (rests, push) = self.model().impulses_at_rests(stop, event.from);
            let impulse = (1.0 + stop.restitution) * event.rate / push;
            self.given_by_stops -= impulse * self.rate_of_stop(event);
            let rests = rests.into_iter().chain([(stop.constraint(), 1.0)]);
            self.struck
                .extend(rests.map(|(constraint, share)| (constraint.direction, share * impulse)));
        }
    }

    /// Rate of the stop that is hit, along its line \[m/s\].
    fn rate_of_stop(&self, event: &Event) -> f64 {
        let contact = &self.model().contacts[event.contact];
        let segment = contact.cycle(event.cycle).segment_at(event.time);
        let [_, opening] = contact.gap(segment, event.time);
        let line = &self.model().lines[self.model().line(segment)];
        line.transmission_error_at(event.cycle, event.time).1 + contact.side * opening
    }

    /// Energy \[J\] that the structure has gained by the impacts since the last window. `first` and `second`
    /// are its state after them.
    pub fn gained_by_impacts(&self, first: &[f64], second: &[f64]) -> f64 {
        if self.struck.is_empty() {
            return 0.0;
        }
        let (mut before, mut rates) = (first.to_vec(), second.to_vec());
        for &(direction, impulse) in &self.struck {
            let parts = [&mut before[..], &mut rates[..]];
            self.model().push_along(direction, -impulse, parts);
        }
        self.structure(first, second) - self.structure(&before, &rates)
    }
}
