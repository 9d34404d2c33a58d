//! When does a contact that never pulls open, and when does it take load again?
//!
//! Its push is `s F = k (s δ − b) + c (s δ' − b')`. A closed contact opens when its push falls to zero, while it is
//! still compressed. δ cannot return to the gap before, because only the damper would act there, and pull. An open
//! and compressed contact is *unladen*. It takes load again when the push that it would have rises to zero. Once δ is
//! back at the gap, the contact is free and closes like any other when δ rises to the gap. No force changes when a
//! contact becomes free, and no window is cut there.
//!
//! The push of a closed contact is its force from the solution of its window. The push of an unladen contact is
//! formed segment by segment, because free flight passes the ends of segments, where k steps.

use super::Volterra;
use super::lanes;
use super::position::{Position, SAME_TIME, WindowSource};
use super::shapes::{Series, TERMS};
use super::workspace::Workspace;
use crate::model::{ActiveSet, Segment};
use crate::numerics::legendre::{self, transforms24};
use crate::propagate::Counters;
use crate::propagate::events::{Crossing, Guard, ROUND_OFF};

/// Condition of a contact when it opens or closes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ContactCondition {
    /// At its surface.
    Surface,
    /// Where its push vanishes.
    NoForce,
    /// Neither: its push, gap or line has jumped, the motion started in this state, or the contact is a part of a dry
    /// slider, of a rigid stop or of dry friction.
    Elsewhere,
}

/// A contact's indentation over a window.
struct Indentation {
    /// Series of `s δ − b` \[m\].
    series: Series,
    /// Series of its time derivative \[m/s\].
    rate: Series,
    /// Round-off of `series` \[m\].
    noise: f64,
    /// Length of the window \[s\].
    delta: f64,
}

impl Indentation {
    /// Round-off of the push \[N\] of a segment's spring and damper.
    fn noise_of_push(&self, segment: &Segment) -> f64 {
        let rate = 2.0 / self.delta * TERMS as f64;
        (segment.stiffness.bound() + segment.damping * rate) * self.noise
    }

    /// Series of the push between two positions in one segment, for a window that starts at a time \[s\] of a cycle
    /// with a period \[s\].
    fn push(&self, segment: &Segment, [from, to]: [f64; 2], time: f64, period: f64) -> Series {
        let transforms = transforms24();
        let part = transforms.restrict(&self.series, from, to);
        let rate = transforms.restrict(&self.rate, from, to);
        let sprung: Series = if segment.stiffness.is_constant() {
            part.map(|a| segment.stiffness.mean() * a)
        } else {
            let values = transforms.nodes().map(|x| {
                let place = 0.5 * ((to - from) * x + (to + from));
                let phase = (time + 0.5 * (place + 1.0) * self.delta) / period;
                segment.stiffness_at(phase) * legendre::evaluate(&part, x)
            });
            transforms.interpolate(&values)
        };
        std::array::from_fn(|n| sprung[n] + segment.damping * rate[n])
    }
}

impl Volterra<'_> {
    /// The first event on a window up to `limit`, and the condition of its contact. If two events are at the
    /// same time, the first in the order of contacts counts.
    pub(super) fn first_event(
        &self,
        position: &Position,
        track: WindowSource<'_>,
        active: ActiveSet,
        limit: f64,
        workspace: &Workspace,
        counters: &mut Counters,
    ) -> Option<(Crossing, ContactCondition)> {
        let sets = [active, self.of_parts];
        let first = self.first_of_contacts(position, track, sets, limit, workspace, counters);
        if !self.of_parts.touching() {
            return first;
        }
        let first = self.first_with_sliders(track, active, (limit, first), workspace, counters);
        let first = self.first_with_stops(
            (position, track),
            active,
            (limit, first),
            workspace,
            counters,
        );
        self.first_with_frictions(track, active, (limit, first), workspace, counters)
    }

    /// As [`Self::first_event`], without the contacts `excluded`.
    pub(super) fn first_of_contacts(
        &self,
        position: &Position,
        track: WindowSource<'_>,
        [active, excluded]: [ActiveSet; 2],
        limit: f64,
        workspace: &Workspace,
        counters: &mut Counters,
    ) -> Option<(Crossing, ContactCondition)> {
        let at_surface = |crossing| (crossing, ContactCondition::Surface);
        if !self.never_pull.touching() {
            return self
                .first_crossing(
                    position,
                    track,
                    [active, excluded],
                    limit,
                    workspace,
                    counters,
                )
                .map(at_surface);
        }
        let pushed = self.watched_by_push(position, track, active, workspace);
        let mut first = self
            .first_crossing(
                position,
                track,
                [active, pushed.union(excluded)],
                limit,
                workspace,
                counters,
            )
            .map(at_surface);
        for contact in pushed.iter() {
            let limit = first.map_or(limit, |(crossing, _)| crossing.x);
            let indentation = self.indentation(contact, position, track, workspace);
            let crossing = if active.holds(contact) {
                self.opening(
                    (contact, active),
                    &indentation,
                    position,
                    limit,
                    workspace,
                    counters,
                )
            } else {
                self.reloading(contact, &indentation, position, limit, counters)
            };
            let earlier = |(x, _): &(f64, ContactCondition)| {
                first.is_none_or(|(first, _)| {
                    *x < first.x || (*x == first.x && contact < first.contact)
                })
            };
            first = crossing
                .filter(earlier)
                .map(|(x, place)| (Crossing { x, contact }, place))
                .or(first);
        }
        first
    }

    /// The contacts whose push is monitored: of those that never pull, the closed ones, and the open ones that are
    /// compressed at the start of the window.
    fn watched_by_push(
        &self,
        position: &Position,
        track: WindowSource<'_>,
        active: ActiveSet,
        workspace: &Workspace,
    ) -> ActiveSet {
        let mut watched = ActiveSet::FREE;
        for (view, solution) in track.views().iter().zip(&workspace.solutions) {
            let start = legendre::at_start(&solution.deflection);
            let never_pull = |contact: &&usize| self.never_pull.holds(**contact);
            for &contact in view.contacts.iter().filter(never_pull) {
                if self.model.is_passed(contact, active) {
                    continue;
                }
                let unladen = || {
                    let contact_data = &self.model.contacts[contact];
                    let gap_error = if self.tables.gap_errors[contact] {
                        let [gap_error, ..] =
                            self.gap_errors(position, &[contact], track, workspace);
                        gap_error.map_or(0.0, |series| legendre::at_start(&series))
                    } else {
                        0.0
                    };
                    contact_data.side * start - contact_data.half_gap - gap_error > 0.0
                };
                if active.holds(contact) || (!position.crossed.holds(contact) && unladen()) {
                    watched = watched.toggled(contact);
                }
            }
        }
        watched
    }

    /// Indentation of a contact over a window.
    fn indentation(
        &self,
        contact: usize,
        position: &Position,
        track: WindowSource<'_>,
        workspace: &Workspace,
    ) -> Indentation {
        let solution = &workspace.solutions[track.place_of(contact)];
        let contact_data = &self.model.contacts[contact];
        let mut series = solution.deflection.map(|a| contact_data.side * a);
        series[0] -= contact_data.half_gap;
        let [gap_error, ..] = self.gap_errors(position, &[contact], track, workspace);
        for (term, a) in series.iter_mut().zip(gap_error.iter().flatten()) {
            *term -= a;
        }
        let delta = self.tables.windows[track.views()[0].window].delta;
        Indentation {
            rate: legendre::derivative(&series).map(|a| 2.0 / delta * a),
            series,
            noise: ROUND_OFF * (solution.size + self.model.half_gap),
            delta,
        }
    }

    /// The position where a closed contact opens.
    fn opening(
        &self,
        (contact, active): (usize, ActiveSet),
        indentation: &Indentation,
        position: &Position,
        limit: f64,
        workspace: &Workspace,
        counters: &mut Counters,
    ) -> Option<(f64, ContactCondition)> {
        let beyond = legendre::at_start(&indentation.series) < -indentation.noise;
        if beyond && !position.crossed.holds(contact) {
            // A jump of the line or of the gap has freed the contact.
            return Some((-1.0, ContactCondition::Elsewhere));
        }
        let contact_data = &self.model.contacts[contact];
        let force = match active.only() {
            Some(_) => &workspace.forces[0].0,
            None => {
                let index = active.iter().position(|closed| closed == contact);
                let columns = workspace.tangents() + 1;
                &workspace.joint.forces[index.unwrap_or(0) * columns].0
            }
        };
        let noise = indentation.noise_of_push(&workspace.segments[contact]);
        let known = position.forceless.holds(contact);
        let x = self.exit(force, contact_data.side, noise, known, limit, counters)?;
        let vanished = x > -1.0 || legendre::at_start(force).abs() <= noise;
        Some((
            x,
            if vanished { ContactCondition::NoForce } else { ContactCondition::Elsewhere },
        ))
    }

    /// The position where an unladen contact takes load again.
    fn reloading(
        &self,
        contact: usize,
        indentation: &Indentation,
        position: &Position,
        limit: f64,
        counters: &mut Counters,
    ) -> Option<(f64, ContactCondition)> {
        let Indentation {
            series,
            noise,
            delta,
            ..
        } = indentation;
        let band = self.model.contacts[contact].band;
        let recedes = indentation.rate[0] + legendre::variation(&indentation.rate) < 0.0;
        if band.is_finite() && recedes {
            return None;
        }
        let entered = self.enters_band(series, *noise, band, limit, counters)?;
        let free = self.exit(series, 1.0, *noise, false, limit, counters);
        let until = free.unwrap_or(limit);
        let cycle = self.model.contacts[contact].cycle(position.cycle);
        let period = cycle.period;
        let begin = position.time + SAME_TIME * period;
        let ahead = |segment: &&Segment| segment.end * period > begin;
        let mut from = entered;
        for segment in cycle.segments.iter().filter(ahead) {
            let end = 2.0 * (segment.end * period - position.time) / delta - 1.0;
            let to = end.min(until);
            if to <= from {
                continue;
            }
            let push = indentation.push(segment, [from, to], position.time, period);
            let noise = indentation.noise_of_push(segment);
            let known = position.forceless.holds(contact) && from == -1.0;
            if let Some(x) = self.exit(&push, -1.0, noise, known, 1.0, counters) {
                let vanished = x > -1.0 || legendre::at_start(&push).abs() <= noise;
                let place =
                    if vanished { ContactCondition::NoForce } else { ContactCondition::Elsewhere };
                return Some((from + 0.5 * (to - from) * (x + 1.0), place));
            }
            from = to;
        }
        let free = free.filter(|free| *free < limit)?;
        let rest = transforms24().restrict(series, free, limit);
        let x = self.exit(&rest, -1.0, *noise, true, 1.0, counters)?;
        Some((
            free + 0.5 * (limit - free) * (x + 1.0),
            ContactCondition::Surface,
        ))
    }

    /// The position, up to `limit`, from which an unladen contact is shallow enough to act. This is the start of the
    /// window, except for a film layer that is squeezed thinner.
    fn enters_band(
        &self,
        depth: &Series,
        noise: f64,
        band: f64,
        limit: f64,
        counters: &mut Counters,
    ) -> Option<f64> {
        if band.is_infinite() {
            return Some(-1.0);
        }
        let mut beyond = *depth;
        beyond[0] -= band;
        if beyond[0] > legendre::variation(&beyond) + noise {
            return None;
        }
        if legendre::at_start(&beyond) < 0.0 {
            return Some(-1.0);
        }
        self.exit(&beyond, 1.0, noise, false, limit, counters)
    }

    /// The position, up to `limit`, where `sign` times a series with the round-off `noise` becomes negative. `known`
    /// means that the series is zero at its start.
    pub(super) fn exit(
        &self,
        series: &Series,
        sign: f64,
        noise: f64,
        known: bool,
        limit: f64,
        counters: &mut Counters,
    ) -> Option<f64> {
        let guard = Guard::of_sign(sign, known);
        let set = self.instructions;
        lanes::first_crossing(set, series, noise, &[guard], limit, counters).map(|found| found.x)
    }
}
