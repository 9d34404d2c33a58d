//! Which event comes first on a window?
//!
//! An open contact closes where s δ rises to its gap. A closed one opens where s δ falls back to the gap or, if
//! it never pulls, where its force vanishes. A contact that opened because its force vanished is still
//! compressed. It closes again where the force that it would have rises to zero. Once s δ is back at the gap,
//! the contact is free.

use super::VaryingSpeed;
use super::powers::{Powers, to_legendre, value, value_and_slope};
use super::window::{ContactCourse, WindowSeries, wave};
use crate::model::{ActiveSet, Release, Segment};
use crate::numerics::legendre;
use crate::propagate::Counters;
use crate::propagate::events::{Guard, ROUND_OFF};
use crate::propagate::vectors::TERMS;
use crate::propagate::volterra::lanes;

/// The condition of a contact at the position of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventCause {
    /// The contact is on its surface.
    Surface,
    /// The force of the contact is zero.
    NoForce,
    /// A compressed open contact is on its surface and becomes free: no force changes.
    Freedom,
    /// The contact is at the thickness from which its film layer may act again: no force changes.
    Band,
}

/// The first event on a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowEvent {
    /// Position, as a fraction of the window.
    pub place: f64,
    /// The contact.
    pub contact: usize,
    /// The condition of the contact.
    pub met: EventCause,
    /// Whether this condition holds at the position within rounding; false if it is exceeded at the window's
    /// start.
    pub stands: bool,
    /// Rate of its deflection relative to its surface \[m/s\].
    pub rate: f64,
}

/// A margin with its round-off. The state of a contact ends where the margin becomes negative.
struct Candidate {
    margin: Powers,
    noise: f64,
    /// Whether the margin is zero at the start of the window because the contact has just opened or closed there.
    known: bool,
    met: EventCause,
}

impl VaryingSpeed {
    /// The first event on a window of a length \[s\].
    pub(super) fn first_event(
        &self,
        (active, standing): (ActiveSet, [ActiveSet; 2]),
        length: f64,
        (motions, segments): (&WindowSeries, &[Segment]),
        counters: &mut Counters,
    ) -> Option<WindowEvent> {
        let mut first: Option<WindowEvent> = None;
        for contact in 0..self.model.contacts.len() {
            if self.model.is_out_of_reach(contact, segments, active) {
                continue;
            }
            for candidate in self
                .candidates(
                    (contact, &segments[contact]),
                    active,
                    standing,
                    length,
                    motions,
                )
                .into_iter()
                .flatten()
            {
                let limit = first.map_or(1.0, |found| found.place);
                let Some(place) = self.exit(&candidate, limit, counters) else {
                    continue;
                };
                if first.is_none_or(|first| place < first.place) {
                    let indentation = self.indentation(contact, motions);
                    let start = value(&candidate.margin, 0.0);
                    first = Some(WindowEvent {
                        place,
                        contact,
                        met: candidate.met,
                        stands: place > 0.0 || start.abs() <= candidate.noise,
                        rate: self.model.contacts[contact].side
                            * value_and_slope(&indentation, place)[1]
                            / length,
                    });
                }
            }
        }
        first
    }

    /// Creates the tables of the search, which exist once per process. Searches then allocate nothing.
    pub(super) fn prepare_search(&self) {
        let [one, several] = [[1.0, 0.0], [0.0, 9.0]].map(|[slope, rate]| {
            let [mut margin, _] = wave(0.0, &[0.0, rate, 0.0, 0.0, 0.0]);
            (margin[0], margin[1]) = (0.7 * margin[0], margin[1] - slope);
            margin
        });
        for margin in [one, several] {
            let candidate = Candidate {
                margin,
                noise: ROUND_OFF,
                known: false,
                met: EventCause::Surface,
            };
            self.exit(&candidate, 1.0, &mut Counters::default());
        }
    }

    /// The margins that may end the state of a contact.
    fn candidates(
        &self,
        (contact, segment): (usize, &Segment),
        active: ActiveSet,
        [crossed, forceless]: [ActiveSet; 2],
        length: f64,
        motions: &WindowSeries,
    ) -> [Option<Candidate>; 2] {
        let contact_data = &self.model.contacts[contact];
        let closed = active.holds(contact);
        let line = motions.line_of[contact];
        let noise = ROUND_OFF * (motions.sizes[line] + self.model.half_gap);
        let known = crossed.holds(contact);
        let inside = if closed { 1.0 } else { -1.0 };
        // Most contacts are so far from their surfaces that nothing can happen on the window.
        let law = &motions.laws[contact];
        let reach: f64 = (motions.deflections[line][1..].iter().zip(&law.gap[1..]))
            .map(|(d, b)| d.abs() + b.abs())
            .sum();
        let middle = contact_data.side * motions.deflections[line][0] - law.gap[0];
        let pushed = contact_data.release == Release::Force
            || (closed && contact_data.release.is_by_force());
        if !pushed && !known && inside * middle > reach + noise {
            return [None, None];
        }
        let indentation = self.indentation(contact, motions);
        let signed = |series: &Powers, sign: f64| series.map(|a| sign * a);
        let surface = |sign: f64, known: bool, met: EventCause| Candidate {
            margin: signed(&indentation, sign),
            noise,
            known,
            met,
        };
        let compressed = !known && indentation[0] > 0.0;
        if !contact_data.release.is_by_force() || !(closed || compressed) {
            return [Some(surface(inside, known, EventCause::Surface)), None];
        }
        if !closed && indentation[0] > contact_data.band + noise {
            let mut beyond = surface(1.0, false, EventCause::Band);
            beyond.margin[0] -= contact_data.band;
            return [Some(beyond), None];
        }
        let damping = segment.damping;
        let push = push(&indentation, law, damping, length);
        let noise_of_push = noise * (bound(&law.stiffness) + damping * TERMS as f64 / length);
        let by_force = Candidate {
            margin: signed(&push, inside),
            noise: noise_of_push,
            known: forceless.holds(contact),
            met: EventCause::NoForce,
        };
        let other = match closed {
            false => Some(surface(1.0, false, EventCause::Freedom)),
            // A jump of line or gap has moved the closed contact off its surface.
            true if !known && indentation[0] < -noise => {
                Some(surface(1.0, false, EventCause::Surface))
            }
            true => None,
        };
        [Some(by_force), other]
    }

    /// `s δ − b` of a contact \[m\].
    fn indentation(&self, contact: usize, motions: &WindowSeries) -> Powers {
        let side = self.model.contacts[contact].side;
        let deflection = &motions.deflections[motions.line_of[contact]];
        let gap = &motions.laws[contact].gap;
        std::array::from_fn(|j| side * deflection[j] - gap[j])
    }

    /// The position where a margin becomes negative, up to a limit.
    fn exit(&self, candidate: &Candidate, limit: f64, counters: &mut Counters) -> Option<f64> {
        let margin = to_legendre(&candidate.margin);
        if !candidate.known && margin[0] > legendre::variation(&margin) + candidate.noise {
            counters.certified += 1;
            return None;
        }
        let guard = Guard::of_sign(1.0, candidate.known);
        let crossing = lanes::first_crossing(
            self.instructions,
            &margin,
            candidate.noise,
            &[guard],
            2.0 * limit - 1.0,
            counters,
        );
        crossing.map(|crossing| 0.5 * (crossing.x + 1.0))
    }
}

/// `k (s δ − b) + c (s δ' − b')` \[N\].
fn push(indentation: &Powers, law: &ContactCourse, damping: f64, length: f64) -> Powers {
    std::array::from_fn(|j| {
        let next = indentation.get(j + 1).copied().unwrap_or(0.0);
        let spring: f64 = (0..law.stiffness_terms.min(j + 1))
            .map(|m| law.stiffness[m] * indentation[j - m])
            .sum();
        spring + damping * (j + 1) as f64 / length * next
    })
}

/// An upper bound of the size of a series on its window.
fn bound(series: &Powers) -> f64 {
    series.iter().map(|a| a.abs()).sum()
}
