//! At which speeds do flanks impact, and how long do contacts and flights last?

use super::sample::Sample;
use super::sums::Sums;
use crate::model::{FlankState, Model, Release};
use crate::numerics::statistics::quantile;
use crate::propagate::Event;

/// Number of flanks of the first mesh: drive and coast. The number of springs per flank does not matter.
pub(super) const FLANKS: usize = 2;

/// An instant: mesh cycle and time within it \[s\].
type Instant = (u64, f64);

/// Changes of contact during the measurement.
#[derive(Debug, Clone)]
pub(super) struct Contacts {
    period: f64,
    /// Release of every contact. `None` for every spring of a flank except the first one, so that an impact
    /// counts once.
    releases: Vec<Option<Release>>,
    first: Option<Instant>,
    last: Option<(Instant, bool)>,
    speeds: Sample<f64>,
    flights: Sample<f64>,
    touches: Sample<f64>,
    fastest: f64,
}

impl Contacts {
    pub(super) fn new(model: &Model) -> Self {
        let behind = |contact: usize| model.of_mesh(contact) && contact >= FLANKS;
        Self {
            period: model.period(),
            releases: (model.contacts.iter().enumerate())
                .map(|(contact, contact_data)| (!behind(contact)).then_some(contact_data.release))
                .collect(),
            first: None,
            last: None,
            speeds: Sample::new(),
            flights: Sample::new(),
            touches: Sample::new(),
            fastest: 0.0,
        }
    }

    pub(super) fn restart(&mut self) {
        self.first = None;
        self.last = None;
        self.speeds.restart();
        self.flights.restart();
        self.touches.restart();
        self.fastest = 0.0;
    }

    /// Appends the record of another trajectory. The last contact or flight of this record and the first one
    /// of the other record do not belong together. Both are omitted.
    pub(super) fn append(&mut self, other: &Self) {
        self.first = None;
        self.last = None;
        self.speeds.append(&other.speeds);
        self.flights.append(&other.flights);
        self.touches.append(&other.touches);
        self.fastest = self.fastest.max(other.fastest);
    }

    /// Records a change of a contact. `place` is the contact's index in the statistics, with its side. `sums`
    /// are those of the present stretch.
    pub(super) fn event(&mut self, event: &Event, (place, side): (usize, f64), sums: &mut Sums) {
        let now = (event.cycle, event.time);
        let touching = event.to.flanks() != FlankState::Free;
        if touching != (event.from.flanks() != FlankState::Free) {
            if let Some((then, touched)) = self.last {
                self.stay(touched, self.between(then, now), sums);
            }
            self.first.get_or_insert(now);
            self.last = Some((now, touching));
        }
        let struck = |release: Release| event.closes() && release.is_struck(side * event.rate);
        if !self.releases[event.contact].is_some_and(struck) {
            return;
        }
        let speed = event.rate.abs();
        let contact = &mut sums.contacts[place];
        contact.impacts += 1.0;
        contact.speed += speed;
        if place < FLANKS {
            sums.impact_square += speed * speed;
            self.fastest = self.fastest.max(speed);
            self.speeds.push(speed);
        }
    }

    fn stay(&mut self, touching: bool, duration: f64, sums: &mut Sums) {
        let (sum, sample) = if touching {
            (&mut sums.touches, &mut self.touches)
        } else {
            (&mut sums.flights, &mut self.flights)
        };
        sum[0] += 1.0;
        sum[1] += duration;
        sample.push(duration);
    }

    fn between(&self, then: Instant, now: Instant) -> f64 {
        (now.0 - then.0) as f64 * self.period + (now.1 - then.1)
    }

    /// Closes the record of a periodic motion, from cycle `begin` to the start of cycle `end`. The last
    /// contact or flight continues into the first one, so both together count as one.
    pub(super) fn close_circle(&mut self, begin: u64, end: u64, sums: &mut Sums) {
        if let (Some(first), Some((last, state))) = (self.first, self.last) {
            let duration = self.between((begin, 0.0), first) + self.between(last, (end, 0.0));
            self.stay(state, duration, sums);
        }
    }

    /// Largest speed of an impact on the flanks of the first mesh \[m/s\]; `None` without impacts.
    pub(super) fn fastest(&self) -> Option<f64> {
        (!self.speeds.values().is_empty()).then_some(self.fastest)
    }

    /// Quantile of the speeds of impacts on these flanks \[m/s\], at the probability `share`, with its standard error.
    pub(super) fn speed(&self, share: f64) -> Option<(f64, f64)> {
        quantile(self.speeds.values(), share)
    }

    /// Medians of the durations of flights and of contacts \[s\], each with its standard error.
    pub(super) fn medians(&self) -> [Option<(f64, f64)>; 2] {
        [&self.flights, &self.touches].map(|sample| quantile(sample.values(), 0.5))
    }
}
