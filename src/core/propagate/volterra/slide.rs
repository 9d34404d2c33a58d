//! When does a dry slider begin to slip, and when does it stick again?
//!
//! The deflection on the line of a slider is `u = δ − s`, the stretch of its spring. A sticking slider begins to slip
//! when u rises to F/k or falls to −F/k. A slipping one sticks again when u' = δ' changes its sign; until then s
//! keeps its old value. The force is continuous at both events, so tangents pass them without a jump. A slip moves
//! the slider and its tangents: `ds = w·dq` ([`Volterra::let_slide`]).
//!
//! Right after a slip, u is at its limit and u' is zero, a double root. u can only return to the limit after the next
//! zero of u'. That zero is therefore sought first, with the known root divided out.

use super::Volterra;
use super::position::{SAME_TIME, WindowSource};
use super::release::ContactCondition;
use super::shapes::{Series, TERMS};
use super::workspace::Workspace;
use crate::model::ActiveSet;
use crate::numerics::legendre::{self, transforms24};
use crate::propagate::Counters;
use crate::propagate::events::{Crossing, ROUND_OFF};

/// The stretch of a slider's spring over a window.
struct Stretch {
    /// Its series \[m\].
    series: Series,
    /// Series of its derivative with respect to the position in the window \[m\].
    slope: Series,
    /// Round-off of `series` \[m\].
    noise: f64,
}

impl Stretch {
    /// Round-off of the derivative \[m\].
    fn noise_of_slope(&self) -> f64 {
        TERMS as f64 * self.noise
    }
}

impl Volterra<'_> {
    /// The first event on a window up to `limit`, including sliders; `first` is the first event of all other
    /// contacts.
    pub(super) fn first_with_sliders(
        &self,
        track: WindowSource<'_>,
        active: ActiveSet,
        (limit, mut first): (f64, Option<(Crossing, ContactCondition)>),
        workspace: &Workspace,
        counters: &mut Counters,
    ) -> Option<(Crossing, ContactCondition)> {
        for &slider in &self.model.sliders {
            let solution = &workspace.solutions[track.place_of(slider.spring())];
            let stretch = Stretch {
                slope: legendre::derivative(&solution.deflection),
                series: solution.deflection,
                noise: ROUND_OFF * (solution.size + self.model.contacts[slider.forwards].half_gap),
            };
            for contact in slider.slips() {
                let until = first.map_or(limit, |(crossing, _)| crossing.x);
                let crossing = if active.holds(contact) {
                    self.sticks(contact, &stretch, until, counters)
                } else if active.holds(slider.spring()) {
                    self.slips(contact, &stretch, until, counters)
                } else {
                    None
                };
                if let Some(x) = crossing.filter(|x| *x < until || first.is_none()) {
                    first = Some((Crossing { x, contact }, ContactCondition::Elsewhere));
                }
            }
        }
        first
    }

    /// The position where a slip ends.
    fn sticks(
        &self,
        slip: usize,
        stretch: &Stretch,
        limit: f64,
        counters: &mut Counters,
    ) -> Option<f64> {
        let side = self.model.contacts[slip].side;
        let noise = stretch.noise_of_slope();
        // A slip may begin at rest.
        let known = legendre::at_start(&stretch.slope).abs() <= noise;
        self.exit(&stretch.slope, side, noise, known, limit, counters)
    }

    /// The position where a slip begins.
    fn slips(
        &self,
        slip: usize,
        stretch: &Stretch,
        limit: f64,
        counters: &mut Counters,
    ) -> Option<f64> {
        let contact = &self.model.contacts[slip];
        let Stretch {
            series,
            slope,
            noise,
        } = stretch;
        let mut room = series.map(|a| -contact.side * a);
        room[0] += contact.half_gap;
        if legendre::at_start(&room) > *noise {
            return self.exit(&room, 1.0, *noise, false, limit, counters);
        }
        let noise_of_slope = stretch.noise_of_slope();
        let known = legendre::at_start(slope).abs() <= noise_of_slope;
        let turn = self.exit(slope, -contact.side, noise_of_slope, known, limit, counters)?;
        if turn >= limit {
            return None;
        }
        let rest = transforms24().restrict(&room, turn, limit);
        let x = self.exit(&rest, 1.0, *noise, false, 1.0, counters)?;
        Some(turn + 0.5 * (limit - turn) * (x + 1.0))
    }

    /// Moves every slider whose slip contact is in `slips` to the end of its slip, at a time \[s\] of a mesh cycle,
    /// for trajectory and tangents.
    pub(super) fn let_slide(
        &self,
        slips: ActiveSet,
        cycle: u64,
        time: f64,
        workspace: &mut Workspace,
    ) {
        let model = &self.model;
        for slider in &model.sliders {
            for slip in slider.slips().into_iter().filter(|slip| slips.holds(*slip)) {
                let mesh_cycle = model.contacts[slip].cycle(cycle);
                let segment = mesh_cycle.segment_at(time + SAME_TIME * mesh_cycle.period);
                let line = &model.lines[model.line(segment)];
                let (error, _) = line.transmission_error_at(cycle, time);
                let offset = error - model.slid_to(slip, 0.0);
                workspace.follow(slider.block, model.gains(segment), offset);
            }
        }
    }
}
