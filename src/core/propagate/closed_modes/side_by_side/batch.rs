//! Mesh cycles of up to eight points, each in a lane: when does each begin, meet an event or a breakpoint, and end?

use super::passes::{self, LaneNumbers};
use super::tables::{MOST_CONTACTS, PointTables, Shape};
use crate::model::{ActiveSet, TrajectoryState};
use crate::propagate::vectors::{InstructionSet, LANES};
use crate::propagate::{Event, Tangents};
use std::sync::Arc;

/// Round-off of the time that is left, as a part of a step.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A mesh cycle of a point.
#[derive(Debug)]
pub struct CycleTask {
    /// The point.
    pub tables: Arc<PointTables>,
    /// Its state.
    pub trajectory: TrajectoryState,
    /// Its tangents.
    pub tangents: Tangents,
    /// The events of the cycle.
    pub events: Vec<Event>,
    /// Whether the cycle has been integrated. If not, trajectory and tangents are those at its start.
    pub done: bool,
}

impl CycleTask {
    /// A task of a point.
    pub fn new(tables: Arc<PointTables>) -> Self {
        Self {
            tables,
            trajectory: TrajectoryState {
                state: Vec::new(),
                contact: ActiveSet::FREE,
                cycle: 0,
            },
            tangents: Tangents::none(),
            events: Vec::new(),
            done: false,
        }
    }

    /// Exchanges its trajectory and tangents with those of a caller.
    pub fn exchange(&mut self, trajectory: &mut TrajectoryState, tangents: &mut Tangents) {
        std::mem::swap(&mut self.trajectory, trajectory);
        std::mem::swap(&mut self.tangents, tangents);
    }
}

/// A point in a lane.
#[derive(Debug)]
struct Lane {
    /// The member of the group that asked for the cycle.
    member: usize,
    task: Box<CycleTask>,
    set: usize,
    active: ActiveSet,
    /// State that each contact has if it is closed.
    closed: [usize; MOST_CONTACTS],
    next_breakpoint: usize,
    /// Time of the cycle up to which the system is valid \[s\].
    limit: f64,
}

/// Eight lanes of points with tables of the same shape.
#[derive(Debug)]
pub struct Batch {
    instructions: InstructionSet,
    numbers: LaneNumbers,
    lanes: [Option<Lane>; LANES],
    /// The last point of each lane, whose step and turns are loaded.
    points: [Option<Arc<PointTables>>; LANES],
    /// Lanes whose states have changed since their margins were computed.
    changed: u32,
}

impl Batch {
    /// Lanes without points.
    pub fn new(shape: Shape, instructions: InstructionSet) -> Self {
        Self {
            instructions,
            numbers: LaneNumbers::new(shape),
            lanes: [const { None }; LANES],
            points: [const { None }; LANES],
            changed: 0,
        }
    }

    /// Sizes of the tables of its points.
    pub fn shape(&self) -> Shape {
        self.numbers.shape
    }

    fn running(&self) -> u32 {
        (self.lanes.iter().enumerate())
            .fold(0, |mask, (i, lane)| mask | u32::from(lane.is_some()) << i)
    }

    /// A free lane for a point: its last lane if that is free, because its tables are loaded there.
    fn free(&self, tables: &Arc<PointTables>) -> Option<usize> {
        let is_last = |lane: &usize| is_of(&self.points[*lane], tables);
        let mut free = (0..LANES).filter(|lane| self.lanes[*lane].is_none());
        free.clone().find(is_last).or_else(|| free.next())
    }

    /// Begins a cycle in a free lane. Returns the task if no lane is free.
    pub fn begin(&mut self, member: usize, mut task: Box<CycleTask>) -> Option<Box<CycleTask>> {
        let Some(index) = self.free(&task.tables) else {
            return Some(task);
        };
        task.events.clear();
        task.done = false;
        let (tables, cycle) = (&task.tables, task.trajectory.cycle);
        let starts = &tables.starts[(cycle % tables.starts.len() as u64) as usize];
        let mut closed = [0; MOST_CONTACTS];
        closed[..starts.len()].copy_from_slice(starts);
        let numbers = &mut self.numbers;
        let state = numbers.shape.state();
        let mut inputs = [0.0; 2 * LANES];
        let inputs = &mut inputs[..numbers.shape.length() - state];
        tables.frequencies.write(cycle, 0.0, inputs);
        for (to, from) in (numbers.z.iter_mut()).zip(task.trajectory.state.iter().chain(&*inputs)) {
            to.0[index] = *from;
        }
        let count = task.tangents.count();
        numbers.tangent_count = numbers.tangent_count.max(count);
        for (i, tangent) in numbers.tangents.chunks_exact_mut(state).enumerate() {
            for (j, to) in tangent.iter_mut().enumerate() {
                to.0[index] = if i < count { task.tangents.vector(i)[j] } else { 0.0 };
            }
        }
        if !is_of(&self.points[index], tables) {
            numbers.load(index, tables);
            self.points[index] = Some(tables.clone());
        }
        let active = task.trajectory.contact;
        let mut lane = Lane {
            member,
            set: tables.sets.of(active, &closed),
            active,
            closed,
            next_breakpoint: 0,
            limit: 0.0,
            task,
        };
        lane.plan(0.0);
        lane.enter(&mut self.numbers, index, None);
        self.numbers.left.0[index] = lane.limit;
        self.lanes[index] = Some(lane);
        self.changed |= 1 << index;
        None
    }

    /// Advances all lanes until some have met an event or the end of a cycle. Passes finished tasks to `finished`,
    /// with the members that asked for them.
    pub fn advance(&mut self, finished: &mut dyn FnMut(usize, Box<CycleTask>)) {
        let running = self.running();
        if running == 0 {
            return;
        }
        passes::margins(self.instructions, &mut self.numbers, self.changed);
        let stops = passes::advance(self.instructions, &mut self.numbers, running);
        let (mut changed, mut ended) = (0, stops.lost);
        for index in lanes_of(stops.moved) {
            let bit = 1 << index;
            let Some(lane) = &mut self.lanes[index] else {
                continue;
            };
            let numbers = &mut self.numbers;
            let fallen = stops.fallen.iter().position(|lanes| lanes & bit != 0);
            let goes_on = match fallen {
                Some(watched) => lane.meet(numbers, index, watched),
                None => lane.arrive(numbers, index),
            };
            *if goes_on { &mut changed } else { &mut ended } |= bit;
        }
        for index in lanes_of(ended) {
            if let Some(lane) = self.lanes[index].take() {
                finished(lane.member, lane.task);
            }
        }
        if ended != 0 {
            let counts = self.lanes.iter().flatten();
            self.numbers.tangent_count = (counts.map(|lane| lane.task.tangents.count()))
                .max()
                .unwrap_or(0);
        }
        self.changed = changed;
    }
}

/// Whether the last point of a lane has these tables.
fn is_of(last: &Option<Arc<PointTables>>, tables: &Arc<PointTables>) -> bool {
    (last.as_ref()).is_some_and(|last| Arc::ptr_eq(last, tables))
}

/// The lanes of a mask.
fn lanes_of(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

impl Lane {
    /// Loads the tables of the lane's system. The contact `crossed` has just opened or closed.
    fn enter(&self, numbers: &mut LaneNumbers, index: usize, crossed: Option<usize>) {
        let system = &self.task.tables.systems[self.set];
        if numbers.sets[index] != Some(self.set) {
            numbers.sets[index] = Some(self.set);
            for (to, from) in numbers.columns.iter_mut().zip(&system.columns) {
                to.0[index] = *from;
            }
        }
        for (w, to) in numbers.crossed.iter_mut().enumerate() {
            let watched = system.watched.get(w).map(|watched| watched.contact);
            *to = *to & !(1 << index) | u32::from(crossed.is_some() && watched == crossed) << index;
        }
    }

    /// Continues after a move to the end of a step, to a breakpoint or to the end of the cycle. Returns
    /// whether the cycle goes on.
    fn arrive(&mut self, numbers: &mut LaneNumbers, index: usize) -> bool {
        if numbers.left.0[index] > ROUNDING * numbers.step.0[index] {
            for crossed in &mut numbers.crossed {
                *crossed &= !(1 << index);
            }
            return true;
        }
        if self.limit >= self.task.tables.period {
            self.end(numbers, index);
            return false;
        }
        let limit = self.limit;
        self.pass_breakpoints(limit);
        self.plan(limit);
        numbers.left.0[index] = self.limit - limit;
        self.enter(numbers, index, None);
        true
    }

    /// Writes the results of a finished cycle, if they are in range.
    fn end(&mut self, numbers: &LaneNumbers, index: usize) {
        let task = &mut *self.task;
        let is_near = |(row, most): &(Vec<f64>, f64)| {
            let products = row.iter().zip(&numbers.z).map(|(w, z)| w * z.0[index]);
            products.sum::<f64>().abs() <= *most
        };
        if !task.tables.ranges.iter().all(is_near) {
            return;
        }
        let state = numbers.shape.state();
        for (to, from) in task.trajectory.state.iter_mut().zip(&numbers.z) {
            *to = from.0[index];
        }
        let count = task.tangents.count();
        for (i, tangent) in (numbers.tangents.chunks_exact(state).take(count)).enumerate() {
            for (to, from) in task.tangents.vector_mut(i).iter_mut().zip(tangent) {
                *to = from.0[index];
            }
        }
        task.trajectory.contact = self.active;
        task.trajectory.cycle += 1;
        task.done = true;
    }

    /// Applies an event: a contact opens or closes. Returns whether the cycle goes on.
    fn meet(&mut self, numbers: &mut LaneNumbers, index: usize, watched: usize) -> bool {
        let tables = &*self.task.tables;
        let of = tables.systems[self.set].watched[watched];
        let time = self.limit - numbers.left.0[index];
        let closes = !self.active.holds(of.contact);
        let to = self.active.toggled(of.contact);
        let rate = of.scale * rate(numbers, index, watched);
        self.pass_earlier_breakpoints(time);
        let state = self.closed[of.contact];
        let tables = &*self.task.tables;
        apply_saltation(numbers, index, tables, [of.contact, state], closes);
        self.set = tables
            .sets
            .with(self.set, of.contact, if closes { state } else { 0 });
        self.task.events.push(Event {
            cycle: self.task.trajectory.cycle,
            time,
            from: self.active,
            to,
            contact: of.contact,
            rate,
        });
        self.active = to;
        self.plan(time);
        numbers.left.0[index] = self.limit - time;
        self.enter(numbers, index, Some(of.contact));
        self.task.events.len() <= self.task.tables.event_limit as usize
    }

    /// Passes the breakpoints before `time` \[s\], none of which changes the present system.
    fn pass_earlier_breakpoints(&mut self, time: f64) {
        let breakpoints = self.task.tables.breakpoints_of(self.task.trajectory.cycle);
        while let Some(breakpoint) =
            (breakpoints.get(self.next_breakpoint)).filter(|breakpoint| breakpoint.time < time)
        {
            self.closed[breakpoint.contact] = breakpoint.state;
            self.next_breakpoint += 1;
        }
    }

    /// Finds the limit of the present system at a time \[s\].
    fn plan(&mut self, time: f64) {
        self.pass_earlier_breakpoints(time);
        let tables = &self.task.tables;
        let breakpoints = tables.breakpoints_of(self.task.trajectory.cycle);
        self.limit = (breakpoints[self.next_breakpoint..].iter())
            .find(|breakpoint| {
                let now = tables.sets.state(self.set, breakpoint.contact);
                now > 0 && now != breakpoint.state
            })
            .map_or(tables.period, |breakpoint| breakpoint.time);
    }

    /// Gives contacts the classes that they have after the breakpoints up to a time \[s\].
    fn pass_breakpoints(&mut self, time: f64) {
        let tables = self.task.tables.clone();
        let breakpoints = tables.breakpoints_of(self.task.trajectory.cycle);
        while let Some(breakpoint) =
            (breakpoints.get(self.next_breakpoint)).filter(|breakpoint| breakpoint.time <= time)
        {
            self.closed[breakpoint.contact] = breakpoint.state;
            if tables.sets.state(self.set, breakpoint.contact) > 0 {
                self.set = tables
                    .sets
                    .with(self.set, breakpoint.contact, breakpoint.state);
            }
            self.next_breakpoint += 1;
        }
    }
}

/// Rate of a watched margin of a lane \[m/s\].
fn rate(numbers: &LaneNumbers, index: usize, watched: usize) -> f64 {
    let shape = numbers.shape;
    let row = &numbers.columns[shape.rows(watched) + shape.length()..][..shape.length()];
    (row.iter().zip(&numbers.z))
        .map(|(weight, z)| weight.0[index] * z.0[index])
        .sum()
}

/// Applies the saltation matrix of an event to the tangents of a lane.
fn apply_saltation(
    numbers: &mut LaneNumbers,
    index: usize,
    tables: &PointTables,
    [contact, state]: [usize; 2],
    closes: bool,
) {
    let class = tables.sets.class(contact, state);
    if class.damping == 0.0 {
        return;
    }
    let direction = &tables.directions[class.direction];
    let damping = if closes { -class.damping } else { class.damping };
    let (count, state) = (numbers.tangent_count, numbers.shape.state());
    for tangent in numbers.tangents.chunks_exact_mut(state).take(count) {
        let along: f64 = (direction.row.iter().zip(&*tangent))
            .map(|(w, x)| w * x.0[index])
            .sum();
        for (x, g) in tangent.iter_mut().zip(&direction.pull) {
            x.0[index] += damping * along * g;
        }
    }
}
