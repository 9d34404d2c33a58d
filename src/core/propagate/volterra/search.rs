//! At which position in a window does an event happen, and which parts of the window do observers see?

use super::Volterra;
use super::lanes::{self, Solution};
use super::partial::Cut;
use super::position::{Position, WindowSource};
use super::shapes::{GapError, Row, Series, TERMS};
use super::tables::gap_error;
use super::window_table::WindowTable;
use super::workspace::Workspace;
use crate::model::{ActiveSet, DRIVE_FLANK, MOST_CONTACTS, SEVERAL_CONTACTS};
use crate::numerics::legendre;
use crate::propagate::events::{Crossing, Guard, Margin, ROUND_OFF};
use crate::propagate::{ClosedContact, Counters, Observer, Window};

/// Largest number of contacts on one line that are checked together.
const MOST_GUARDS: usize = 4;

/// How a contact meets its surface.
pub(super) struct SurfaceContact {
    /// Rate of its deflection against the surface \[m/s\].
    pub rate: f64,
    /// Whether it is on the surface. A start beyond the surface (a trajectory given with the wrong contacts closed, or
    /// a step of the gap) is no root that may be divided out.
    pub on_surface: bool,
}

/// The part of a window that observers see.
#[derive(Clone, Copy)]
pub(super) struct VisiblePart<'a> {
    pub position: &'a Position,
    pub track: WindowSource<'a>,
    pub active: ActiveSet,
    /// Length \[s\].
    pub duration: f64,
    /// Its end within the window; `None` for a full window.
    pub cut: Option<&'a Cut>,
    /// Deflection along the line of every contact, if observers read it.
    pub along: &'a [&'a [f64]],
}

impl<'a> VisiblePart<'a> {
    /// The window without its series.
    fn window(&self, modes: usize, workspace: &'a Workspace) -> Window<'a> {
        let [first, second] = workspace.components(modes);
        Window {
            cycle: self.position.cycle,
            start: self.position.time,
            duration: self.duration,
            segments: &workspace.segments,
            contact: self.active,
            along: self.along,
            first,
            second,
            ..Window::default()
        }
    }
}

impl Volterra<'_> {
    /// The motion along all lines except that of the force. Computes only the first terms of a line if they prove that
    /// no contact is in reach, and if observers need no more. They may need the line of the drive flank, or all lines
    /// (`observed`).
    pub(super) fn see_other_lines(
        &self,
        position: &Position,
        track: WindowSource<'_>,
        table: &WindowTable,
        active: ActiveSet,
        observed: [bool; 2],
        workspace: &mut Workspace,
    ) {
        let instructions = self.instructions;
        for (index, view) in track.views().iter().enumerate().skip(1) {
            let window = &self.tables.windows[view.window];
            let response = (active.touching())
                .then(|| table.contact(instructions).response_on(view.line))
                .flatten();
            let (inputs, trajectory, force, solutions) = workspace.trajectory();
            let [mesh, all] = observed;
            let shown = all || mesh && view.contacts.contains(&DRIVE_FLANK);
            let known = |contact: &usize| {
                !position.crossed.holds(*contact) && !self.tables.gap_errors[*contact]
            };
            if !shown && view.contacts.iter().all(known) {
                let response =
                    response.map(|response| (&response.deflection, &response.tails, force));
                let (rows, tails, seen) = (&window.rows, &window.tails, &mut solutions[index]);
                lanes::truncated(
                    instructions,
                    rows,
                    tails,
                    inputs,
                    trajectory,
                    response,
                    seen,
                );
                let mut contacts = view.contacts.iter();
                if contacts.all(|&contact| self.stays(contact, false, seen)) {
                    continue;
                }
            }
            let mut deflection = [Row::ZERO];
            lanes::free(
                instructions,
                &window.rows,
                inputs,
                trajectory,
                &mut deflection,
            );
            let size = lanes::size(&deflection[0].0);
            if let Some(response) = response {
                lanes::yielded(
                    instructions,
                    &response.deflection,
                    &[*force],
                    &mut deflection,
                );
            }
            solutions[index] = Solution::of(&deflection[0], size);
        }
    }

    /// The first event on a window up to `limit` at a surface, without the contacts `excluded`. If two events
    /// are at the same time, the first in the order of contacts counts.
    pub(super) fn first_crossing(
        &self,
        position: &Position,
        track: WindowSource<'_>,
        [active, excluded]: [ActiveSet; 2],
        limit: f64,
        workspace: &Workspace,
        counters: &mut Counters,
    ) -> Option<Crossing> {
        let mut first: Option<Crossing> = None;
        for (view, solution) in track.views().iter().zip(&workspace.solutions) {
            let noise = ROUND_OFF * (solution.size + self.model.half_gap);
            let has_film = self.model.film_layers > 0;
            let start = if has_film { legendre::at_start(&solution.deflection) } else { 0.0 };
            for group in view.contacts.chunks(MOST_GUARDS) {
                let with_errors = group.iter().any(|&contact| self.tables.gap_errors[contact]);
                let gap_errors =
                    with_errors.then(|| self.gap_errors(position, group, track, workspace));
                let blank = Guard {
                    margin: Margin::new(&self.model.contacts[group[0]], group[0], false),
                    crossed: false,
                    gap_error: None,
                };
                let mut guards = [blank; MOST_GUARDS];
                let mut count = 0;
                let mut settled = true;
                for (place, &contact) in group.iter().enumerate() {
                    let gap_error = gap_errors.as_ref().and_then(|all| all[place].as_ref());
                    if excluded.holds(contact)
                        || self.is_out_of_reach(contact, &view.contacts, active)
                        || (has_film && self.is_shielded(contact, active, start))
                    {
                        continue;
                    }
                    let closed = active.holds(contact);
                    let margin = Margin::new(&self.model.contacts[contact], contact, closed);
                    let crossed = position.crossed.holds(contact);
                    let mut middle = margin.scale * solution.deflection[0] + margin.shift;
                    let mut bound = solution.variation + noise;
                    if let Some(gap_error) = gap_error {
                        middle += if closed { -gap_error[0] } else { gap_error[0] };
                        bound += legendre::variation(gap_error);
                    }
                    let stays = !crossed && middle > bound;
                    if stays && self.model.is_of_film(contact) {
                        continue;
                    }
                    settled &= stays;
                    guards[count] = Guard {
                        margin,
                        crossed,
                        gap_error,
                    };
                    count += 1;
                }
                if settled {
                    counters.certified += u64::from(count > 0);
                    continue;
                }
                let crossing = lanes::first_crossing(
                    self.instructions,
                    &solution.deflection,
                    noise,
                    &guards[..count],
                    first.map_or(limit, |crossing| crossing.x),
                    counters,
                );
                let earlier = |crossing: &Crossing| {
                    first.is_none_or(|first| {
                        crossing.x < first.x
                            || (crossing.x == first.x && crossing.contact < first.contact)
                    })
                };
                first = crossing.filter(earlier).or(first);
            }
        }
        first
    }

    /// Whether the bounds of the deflection prove that a contact keeps its state on a window. The contact has no gap
    /// errors and starts off its surface.
    pub(super) fn stays(&self, contact: usize, closed: bool, solution: &Solution) -> bool {
        let noise = ROUND_OFF * (solution.size + self.model.half_gap);
        let margin = Margin::new(&self.model.contacts[contact], contact, closed);
        margin.scale * solution.deflection[0] + margin.shift > solution.variation + noise
    }

    /// Whether an open contact is out of reach because a contact on the other side of its line, or a thinner layer of
    /// its film, is closed.
    fn is_out_of_reach(&self, contact: usize, others: &[usize], active: ActiveSet) -> bool {
        let contacts = &self.model.contacts;
        let opposite = |other: &usize| {
            active.holds(*other)
                && contacts[*other].side == -contacts[contact].side
                && contacts[*other].release.has_surface()
        };
        !active.holds(contact)
            && (others.iter().any(opposite) || self.model.is_passed(contact, active))
    }

    /// Whether an open contact is out of reach behind an open layer of its film, which acts first, for the deflection
    /// at the start of the window.
    fn is_shielded(&self, contact: usize, active: ActiveSet, start: f64) -> bool {
        let Some(before) = self.model.layer_before(contact) else {
            return false;
        };
        let layer = &self.model.contacts[before];
        let closed = active.holds(contact) || active.holds(before);
        let passed = layer.side * start - layer.half_gap >= layer.band;
        !closed && !passed && !self.tables.gap_errors[contact]
    }

    /// Gap errors of contacts over a window; `None` for contacts that never have one.
    pub(super) fn gap_errors(
        &self,
        position: &Position,
        contacts: &[usize],
        track: WindowSource<'_>,
        workspace: &Workspace,
    ) -> [Option<Series>; MOST_GUARDS] {
        let mut out = [None; MOST_GUARDS];
        for (out, &contact) in out.iter_mut().zip(contacts) {
            if self.tables.gap_errors[contact] {
                *out = Some(padded(&self.gap_error(position, contact, track, workspace)));
            }
        }
        out
    }

    /// Gap error of a contact over a window, from the schedule's table on its grid.
    pub(super) fn gap_error(
        &self,
        position: &Position,
        contact: usize,
        track: WindowSource<'_>,
        workspace: &Workspace,
    ) -> GapError {
        let known = match (track, position.aligned) {
            (WindowSource::Schedule(schedule, _), Some(cell)) => {
                schedule.gap_error(cell, contact, self.model.contacts.len())
            }
            _ => None,
        };
        known.unwrap_or_else(|| {
            let delta = self.tables.windows[track.views()[0].window].delta;
            let segment = &workspace.segments[contact];
            gap_error(&self.model, segment, position.time, delta)
        })
    }

    /// How a contact meets its surface.
    pub(super) fn contact_at(
        &self,
        crossing: &Crossing,
        position: &Position,
        track: WindowSource<'_>,
        active: ActiveSet,
        workspace: &Workspace,
    ) -> SurfaceContact {
        let contact = &self.model.contacts[crossing.contact];
        let solution = &workspace.solutions[track.place_of(crossing.contact)];
        // Relative to the surface, which moves if the gap varies.
        let mut series = solution.deflection;
        if self.tables.gap_errors[crossing.contact] {
            let [gap_error, ..] = self.gap_errors(position, &[crossing.contact], track, workspace);
            for (term, a) in series.iter_mut().zip(gap_error.iter().flatten()) {
                *term -= contact.side * a;
            }
        }
        let [deflection, slope, _] =
            legendre::evaluate_with_derivatives::<_, false>(&series, crossing.x);
        let closed = active.holds(crossing.contact);
        let beyond = contact.margin(closed, deflection, contact.half_gap);
        let noise = ROUND_OFF * (solution.size + self.model.half_gap);
        let delta = self.tables.windows[track.views()[0].window].delta;
        SurfaceContact {
            rate: 2.0 / delta * slope,
            on_surface: crossing.x > -1.0 || beyond.abs() <= noise,
        }
    }

    /// Shows a window, or its part up to the cut.
    pub(super) fn show<O: Observer>(
        &self,
        view: VisiblePart<'_>,
        workspace: &Workspace,
        observer: &mut O,
    ) {
        let mut along: [&[f64]; MOST_CONTACTS] = [&[]; MOST_CONTACTS];
        let mut lines = 0;
        if O::LINES && view.cut.is_none() {
            lines = self.model.contacts.len();
            for (contact, along) in along[..lines].iter_mut().enumerate() {
                *along = &workspace.solutions[view.track.place_of(contact)].deflection;
            }
        }
        let view = VisiblePart {
            along: &along[..lines],
            ..view
        };
        let place = view.track.place_of(DRIVE_FLANK);
        let contact = view.active.only();
        let along = |contact| view.track.place_of(contact) == place && self.model.of_mesh(contact);
        // Avoids memory for many contacts if it is not needed.
        match view.active.count() {
            0 => self.show_one(view, place, None, workspace, observer),
            1 if contact.is_some_and(along) => {
                self.show_one(view, place, contact, workspace, observer);
            }
            1 | 2 => self.show_few::<O, 2>(view, workspace, observer),
            3..=SEVERAL_CONTACTS => {
                self.show_few::<O, SEVERAL_CONTACTS>(view, workspace, observer);
            }
            _ => self.show_many(view, workspace, observer),
        }
    }

    /// As [`Self::show`], with any number of contacts closed. If it were inlined, its stack frame would be probed in
    /// every window.
    #[inline(never)]
    fn show_many<O: Observer>(
        &self,
        view: VisiblePart<'_>,
        workspace: &Workspace,
        observer: &mut O,
    ) {
        self.show_few::<O, MOST_CONTACTS>(view, workspace, observer);
    }

    /// As [`Self::show`], with no contact closed, or with one contact of the mesh on the line of the drive flank.
    fn show_one<O: Observer>(
        &self,
        view: VisiblePart<'_>,
        place: usize,
        contact: Option<usize>,
        workspace: &Workspace,
        observer: &mut O,
    ) {
        let whole = &workspace.solutions[place].deflection;
        let force = match (contact, view.track) {
            (None, _) => &[0.0; TERMS],
            (_, WindowSource::Schedule(..)) => &workspace.forces[0].0,
            (_, WindowSource::Joint(_)) => &workspace.joint.forces[0].0,
        };
        let parts = match (view.cut, contact) {
            (None, _) => None,
            (Some(cut), None) => {
                let [deflection] = self.cut_series(cut, [whole]);
                Some([deflection, *force])
            }
            (Some(cut), _) => Some(self.cut_series(cut, [whole, force])),
        };
        let [deflection, force] = match &parts {
            Some([deflection, force]) => [deflection, force],
            None => [whole, force],
        };
        let closed = contact.map(|contact| ClosedContact {
            contact,
            deflection,
            force,
        });
        observer.window(&Window {
            deflection,
            force,
            closed: closed.as_slice(),
            ..view.window(self.model.modes(), workspace)
        });
    }

    /// As [`Self::show`], with at most M contacts closed.
    fn show_few<O: Observer, const M: usize>(
        &self,
        view: VisiblePart<'_>,
        workspace: &Workspace,
        observer: &mut O,
    ) {
        let VisiblePart {
            track, active, cut, ..
        } = view;
        let seen = |series: &Series| match cut {
            Some(cut) => self.cut_series(cut, [series])[0],
            None => *series,
        };
        let place = track.place_of(DRIVE_FLANK);
        let mesh = seen(&workspace.solutions[place].deflection);
        let along = |contact: usize| match track.place_of(contact) {
            other if other == place => mesh,
            other => seen(&workspace.solutions[other].deflection),
        };
        let (mut contacts, mut series) = ([0; M], [[[0.0; TERMS]; 2]; M]);
        let columns = workspace.tangents() + 1;
        for (index, contact) in active.iter().enumerate() {
            let force = match track {
                WindowSource::Schedule(..) => &workspace.forces[0].0,
                WindowSource::Joint(_) => &workspace.joint.forces[index * columns].0,
            };
            contacts[index] = contact;
            series[index] = [along(contact), seen(force)];
        }
        let window = Window {
            deflection: &mesh,
            closed: &ClosedContact::each(&contacts, &series)[..active.count()],
            ..view.window(self.model.modes(), workspace)
        };
        window.show::<TERMS, O>(self.model.flank_springs, observer);
    }
}

/// Pads a short series to the length of a series on a window.
fn padded(gap_error: &GapError) -> Series {
    let mut out = [0.0; TERMS];
    out[..gap_error.len()].copy_from_slice(gap_error);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{COAST_FLANK, DRIVE_FLANK, Model, fixtures};

    /// In half gaps: the drive flank is at 1, the coast flank at −1.
    #[test]
    fn a_contact_stays_where_the_deflection_cannot_reach_it() {
        let half_gap = 1e-5;
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &[1.0, 0.5], &[1.0, 0.5]);
        let drive = fixtures::two_level_mesh(half_gap);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        let kernel = Volterra::new(&model, f64::EPSILON, 100);
        for (contact, closed, middle, variation, stays) in [
            (DRIVE_FLANK, false, 0.5, 0.4, true),
            (DRIVE_FLANK, false, 0.5, 0.6, false),
            (DRIVE_FLANK, false, -3.0, 2.0, true),
            (DRIVE_FLANK, false, 1.2, 0.1, false),
            (DRIVE_FLANK, true, 1.2, 0.1, true),
            (DRIVE_FLANK, true, 1.2, 0.3, false),
            (COAST_FLANK, false, -0.5, 0.4, true),
            (COAST_FLANK, false, 0.5, 1.6, false),
            (COAST_FLANK, true, -1.2, 0.1, true),
        ] {
            let mut solution = Solution::ZERO;
            solution.deflection[0] = middle * half_gap;
            (solution.variation, solution.size) = (variation * half_gap, half_gap);
            assert_eq!(
                kernel.stays(contact, closed, &solution),
                stays,
                "{contact} {closed} {middle}"
            );
        }
    }
}
