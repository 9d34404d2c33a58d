//! How does a motion advance from window to window?

use super::motion_observer::{MotionObserver, MovingEvent, VaryingSpeedWindow};
use super::powers::{
    Course, Sum, composed, length as terms_of, place_of, second_derivative, value, value_and_slope,
};
use super::search::{EventCause, WindowEvent};
use super::speed_interval::SpeedInterval;
use super::window::{self, Closed, ContactCourse, WindowCourse, WindowSeries};
use super::{Motion, VaryingSpeed};
use crate::model::{ActiveSet, Segment};
use crate::propagate::vectors::{Aligned, TERMS};
use crate::propagate::{Counters, Stop};
use std::f64::consts::TAU;

/// Largest phase change of the fastest wave on a window \[rad\]. Omitted terms are 3²⁴/24! = 5e-13 of its
/// amplitude.
const LARGEST_PHASE: f64 = 3.0;

/// Round-off of sums, relative to a mesh cycle or a window.
const ROUNDING: f64 = 1e-14;

/// Largest sum of the sizes of the last two terms of a series, relative to the sum of the sizes of all terms.
const TAIL: f64 = 4.0 * f64::EPSILON;

/// Largest number of times that a window is halved because its series do not converge.
const HALVINGS: u32 = 40;

/// Scratch memory of the kernel.
#[derive(Debug, Clone)]
pub struct Workspace {
    motions: WindowSeries,
    segments: Vec<Segment>,
    /// Mesh phase at which the segments end.
    end: f64,
}

impl Workspace {
    pub(super) fn new(kernel: &VaryingSpeed) -> Self {
        let (system, model) = (&kernel.system, &kernel.model);
        let (lines, contacts) = (model.lines.len(), model.contacts.len());
        let nothing = [0.0; TERMS];
        Self {
            motions: WindowSeries {
                components: [0, 1].map(|_| Aligned::zeros(TERMS * system.padded)),
                end: [0, 1].map(|_| Aligned::zeros(system.padded)),
                deflections: vec![nothing; lines],
                sizes: vec![0.0; lines],
                errors: vec![nothing; lines],
                waves: vec![[nothing; 2]; system.turns.len()],
                ripples: vec![nothing; system.ripples.len()],
                lines: Vec::with_capacity(lines),
                line_of: vec![0; contacts],
                seen: vec![nothing; lines],
                answers: vec![[0.0; 2 * TERMS]; lines * contacts],
                closed: Vec::with_capacity(contacts),
                forces: Vec::with_capacity(contacts),
                laws: vec![ContactCourse::ZERO; contacts],
            },
            segments: model.segments_at(0, 0.0),
            end: 0.0,
        }
    }
}

impl VaryingSpeed {
    /// Advances a motion to the end of a speed interval, passes windows and events to `watch`, and adds the
    /// work to `counters`. Allocates nothing.
    ///
    /// # Errors
    /// [`Stop`] if the motion diverges, has too many events in a mesh cycle, or the drive does not run forwards. The
    /// motion is then unspecified.
    pub fn advance<W: MotionObserver>(
        &self,
        motion: &mut Motion,
        stretch: &SpeedInterval,
        workspace: &mut Workspace,
        watch: &mut W,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        if !stretch.runs_forwards() {
            return Err(Stop::Backwards {
                cycle: motion.cycle,
            });
        }
        let begin = motion.time;
        let cycles = self.cycles_per_radian * stretch.fastest();
        let longest = LARGEST_PHASE / self.system.fastest_at(cycles);
        self.load(motion, workspace);
        let mut phase = Sum::of(motion.phase);
        let mut start = Sum::of(0.0);
        while start.value < stretch.duration {
            let left = stretch.duration - start.value;
            let reach = self.solve(motion, stretch, (start.value, longest.min(left)), workspace);
            counters.windows += 1;
            self.check_range(motion, &workspace.motions)?;
            let event = self.first_event(
                (motion.contact, motion.standing),
                reach.length,
                (&workspace.motions, &workspace.segments),
                counters,
            );
            let part = event.map_or(1.0, |event| event.place);
            if part > 0.0 {
                window::move_blocks(
                    self.instructions,
                    &self.system,
                    &reach,
                    part,
                    &mut workspace.motions,
                );
                watch.window(&VaryingSpeedWindow {
                    kernel: self,
                    motions: &workspace.motions,
                    time: motion.time,
                    duration: part * reach.length,
                    part,
                    cycle: motion.cycle,
                    phase: motion.phase,
                    cycles: reach.cycles,
                    loads: reach.loads,
                    contact: motion.contact,
                });
                let WindowSeries {
                    components, end, ..
                } = &mut workspace.motions;
                for (component, end) in components.iter_mut().zip(end) {
                    component[..self.system.padded].copy_from_slice(end);
                }
                match event {
                    None if reach.length == left => start = Sum::of(stretch.duration),
                    _ => start.add(part * reach.length),
                }
                motion.time = begin + start.value;
                motion.standing = [ActiveSet::FREE; 2];
                phase.add(value(&reach.cycles, part));
                motion.phase = phase.value;
            }
            match event {
                Some(event) => {
                    self.meet(event, motion, &reach, workspace, watch, counters)?;
                    // The next window would have no length.
                    if workspace.end - motion.phase <= ROUNDING {
                        let standing = motion.standing;
                        self.pass_end(motion, workspace, counters);
                        motion.standing = self.standing_after_jumps(motion, standing);
                        phase = Sum::of(motion.phase);
                    }
                }
                None if reach.at_end => {
                    self.pass_end(motion, workspace, counters);
                    phase = Sum::of(motion.phase);
                }
                None => {}
            }
        }
        self.store(motion, workspace);
        Ok(())
    }

    /// Solves a window that starts at `start` \[s\] of a speed interval. The window is at most `longest`
    /// \[s\] long. It is halved until its series converge, at most [`HALVINGS`] times.
    fn solve(
        &self,
        motion: &Motion,
        stretch: &SpeedInterval,
        (start, longest): (f64, f64),
        workspace: &mut Workspace,
    ) -> WindowCourse {
        let mut reach = self.reach(motion, stretch, (start, longest), workspace);
        self.expand(motion, &reach, workspace);
        for _ in 0..HALVINGS {
            if has_converged(&workspace.motions) {
                break;
            }
            reach = self.reach(motion, stretch, (start, 0.5 * reach.length), workspace);
            self.expand(motion, &reach, workspace);
        }
        reach
    }

    /// Limits a window of a given length to the end of the segments.
    fn reach(
        &self,
        motion: &Motion,
        stretch: &SpeedInterval,
        (start, length): (f64, f64),
        workspace: &Workspace,
    ) -> WindowCourse {
        let (mut cycles, mut loads) = stretch.on_window(self, start, length);
        let left = workspace.end - motion.phase;
        if value(&cycles, 1.0) < left - ROUNDING {
            return WindowCourse {
                length,
                cycles,
                loads,
                at_end: false,
            };
        }
        let part = place_of(&cycles, left).min(1.0);
        let length = part * length;
        let shorter = |course: &mut Course| {
            let mut scale = 1.0;
            for a in course {
                *a *= scale;
                scale *= part;
            }
        };
        shorter(&mut cycles);
        loads.iter_mut().for_each(shorter);
        WindowCourse {
            length,
            cycles,
            loads,
            at_end: true,
        }
    }

    /// Expands waves, errors, ripples, stiffness and gaps of a window by powers of u, then solves its
    /// deflections and forces.
    fn expand(&self, motion: &Motion, reach: &WindowCourse, workspace: &mut Workspace) {
        let Workspace {
            motions, segments, ..
        } = workspace;
        for (wave, turns) in motions.waves.iter_mut().zip(&self.system.turns) {
            let whole = (motion.cycle as f64 * turns).fract();
            let angle = reach.cycles.map(|a| TAU * turns * a);
            *wave = window::wave(TAU * (whole + turns * motion.phase), &angle);
        }
        for &[line, _] in &motions.lines {
            motions.errors[line] =
                window::sum_of_waves(&self.system.error_waves[line], &motions.waves);
        }
        let ripples = motions.ripples.iter_mut().zip(&self.system.ripple_waves);
        for ((ripple, part), excitation) in ripples.zip(&self.model.ripple) {
            *ripple = window::sum_of_waves(std::slice::from_ref(part), &motions.waves);
            if excitation.of_motion {
                *ripple = second_derivative(ripple, excitation.angular_frequency * reach.length);
            }
        }
        let laws = motions.laws.iter_mut().zip(segments.iter());
        for ((law, segment), contact) in laws.zip(&self.model.contacts) {
            if is_constant(segment) {
                continue;
            }
            let mut at = (reach.cycles).map(|a| 2.0 / (segment.end - segment.start) * a);
            at[0] = segment.place(motion.phase);
            composed(segment.stiffness.coefficients(), &at, &mut law.stiffness);
            composed(segment.error.coefficients(), &at, &mut law.gap);
            law.stiffness_terms = terms_of(&law.stiffness);
            law.gap[0] += contact.half_gap;
        }
        window::meet(self.instructions, &self.system, reach, motions);
    }

    /// Rejects diverged deflections.
    fn check_range(&self, motion: &Motion, motions: &WindowSeries) -> Result<(), Stop> {
        for &[line, _] in &motions.lines {
            // Written so that NaN is rejected.
            let within = motions.deflections[line][0].abs() <= self.farthest[line];
            if !within {
                return Err(Stop::Diverged {
                    cycle: motion.cycle,
                });
            }
        }
        Ok(())
    }

    /// Applies an event.
    fn meet<W: MotionObserver>(
        &self,
        event: WindowEvent,
        motion: &mut Motion,
        reach: &WindowCourse,
        workspace: &mut Workspace,
        watch: &mut W,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let place = match event.met {
            EventCause::Surface | EventCause::Freedom => 0,
            EventCause::NoForce => 1,
            EventCause::Band => return Ok(()),
        };
        if motion.standing[place].holds(event.contact) != event.stands {
            motion.standing[place] = motion.standing[place].toggled(event.contact);
        }
        if event.met == EventCause::Freedom {
            return Ok(());
        }
        let from = motion.contact;
        motion.contact = self.model.toggled(from, event.contact);
        motion.events += 1;
        if motion.events > self.event_limit {
            return Err(Stop::EventStorm {
                cycle: motion.cycle,
                limit: self.event_limit,
            });
        }
        counters.events += 1;
        watch.event(&MovingEvent {
            time: motion.time,
            cycle: motion.cycle,
            phase: motion.phase,
            speed: value_and_slope(&reach.cycles, event.place)[1] / reach.length,
            from,
            to: motion.contact,
            contact: event.contact,
            rate: event.rate,
        });
        self.set_closed(motion.contact, workspace);
        Ok(())
    }

    /// Moves to the next segments.
    fn pass_end(&self, motion: &mut Motion, workspace: &mut Workspace, counters: &mut Counters) {
        motion.phase = workspace.end;
        if motion.phase >= 1.0 {
            motion.phase = 0.0;
            motion.cycle += 1;
            motion.events = 0;
            counters.cycles += 1;
        }
        // Stiffness, gaps and lines may jump here, so no margin is known to be zero.
        motion.standing = [ActiveSet::FREE; 2];
        self.set_segments(motion, workspace);
    }

    /// The sets `standing` without the contacts whose gap or line jumps at the phase of a motion.
    fn standing_after_jumps(
        &self,
        motion: &Motion,
        mut standing: [ActiveSet; 2],
    ) -> [ActiveSet; 2] {
        for contact in self.model.turning(motion.cycle, motion.phase) {
            let jumping = ActiveSet::FREE.toggled(contact);
            standing = standing.map(|set| set.without(jumping));
        }
        standing
    }

    /// Sets the segments at the phase of a motion.
    fn set_segments(&self, motion: &Motion, workspace: &mut Workspace) {
        let ends = &self.ends[(motion.cycle % self.ends.len() as u64) as usize];
        let next = ends
            .iter()
            .copied()
            .find(|end| *end > motion.phase + ROUNDING);
        workspace.end = next.unwrap_or(1.0);
        let inside = 0.5 * (motion.phase + workspace.end);
        let motions = &mut workspace.motions;
        motions.lines.clear();
        for (index, contact) in self.model.contacts.iter().enumerate() {
            let cycle = contact.cycle(motion.cycle);
            let segment = cycle.segment_at(inside * cycle.period);
            workspace.segments[index] = *segment;
            let line = self.model.line(segment);
            motions.line_of[index] = line;
            if is_constant(segment) {
                let law = &mut motions.laws[index];
                *law = ContactCourse::ZERO;
                law.stiffness[0] = segment.stiffness.mean();
                law.gap[0] = contact.half_gap;
            }
            if motions.lines.iter().all(|[known, _]| *known != line) {
                motions.lines.push([line, segment.direction]);
            }
        }
        self.set_closed(motion.contact, workspace);
    }

    /// Sets the closed contacts.
    fn set_closed(&self, active: ActiveSet, workspace: &mut Workspace) {
        let Workspace {
            motions, segments, ..
        } = workspace;
        motions.closed.clear();
        motions.forces.clear();
        for contact in active.iter() {
            let segment = &segments[contact];
            let line = motions.line_of[contact];
            let place = motions.lines.iter().position(|[known, _]| *known == line);
            motions.closed.push(Closed {
                contact,
                line,
                place: place.unwrap_or_default(),
                direction: segment.direction,
                side: self.model.contacts[contact].side,
                damping: segment.damping,
            });
            motions.forces.push([0.0; TERMS]);
        }
    }

    /// Loads the state of a motion into the workspace.
    fn load(&self, motion: &Motion, workspace: &mut Workspace) {
        let n = self.model.modes();
        let (first, second) = motion.state.split_at(n);
        for (component, state) in workspace.motions.components.iter_mut().zip([first, second]) {
            component[..n].copy_from_slice(state);
            component[n..self.system.padded].fill(0.0);
        }
        self.set_segments(motion, workspace);
    }

    /// Stores the state in the motion.
    fn store(&self, motion: &mut Motion, workspace: &Workspace) {
        let n = self.model.modes();
        let (first, second) = motion.state.split_at_mut(n);
        for (component, state) in workspace.motions.components.iter().zip([first, second]) {
            state.copy_from_slice(&component[..n]);
        }
    }
}

/// Whether stiffness and gap of a contact are constant over a segment.
fn is_constant(segment: &Segment) -> bool {
    segment.stiffness.is_constant() && segment.error.is_none()
}

/// Whether the series of a window have converged.
fn has_converged(motions: &WindowSeries) -> bool {
    let short = |series: &[f64; TERMS]| {
        let sum: f64 = series.iter().map(|a| a.abs()).sum();
        let tail = series[TERMS - 1].abs() + series[TERMS - 2].abs();
        // Halving does not remove NaN.
        tail <= TAIL * sum || tail.is_nan()
    };
    motions
        .lines
        .iter()
        .all(|[line, _]| short(&motions.deflections[*line]))
        && motions.forces.iter().all(short)
}
