//! Work on several stacks in one thread: while one waits for a cycle in a lane, the others go on. The work on one
//! stack is a member of the group.

use super::batch::{Batch, CycleTask};
use crate::propagate::InstructionSet;
use crate::propagate::vectors::LANES;
use corosensei::stack::DefaultStack;
use corosensei::{CoroutineResult, ScopedCoroutine, ScopedCoroutineRef, Yielder};

/// Size of a stack \[bytes\]; memory is taken as it is used.
const STACK: usize = 2 << 20;

/// The request of a member: a cycle, or `None` for a pause.
type Question = Option<Box<CycleTask>>;

/// The answer to a member: its integrated cycle, or `None` after a pause.
type Answer = Option<Box<CycleTask>>;

type Member<'a> = ScopedCoroutine<'a, Answer, Question, ()>;

type MemberRef<'a> = ScopedCoroutineRef<'a, Answer, Question, (), DefaultStack>;

/// The place of a member of a group, from which it asks for cycles.
pub struct Seat<'a>(&'a Yielder<Answer, Question>);

impl Seat<'_> {
    /// Lets a lane integrate a cycle. Other members work meanwhile.
    pub(super) fn integrate(&self, task: Box<CycleTask>) -> Box<CycleTask> {
        let mut question = Some(task);
        loop {
            if let Some(task) = self.0.suspend(question.take()) {
                return task;
            }
        }
    }

    /// Lets other members work, or waits if none can.
    pub fn pause(&self) {
        self.0.suspend(None);
    }
}

/// The state of a member.
enum State {
    /// May go on with this answer.
    Ready(Answer),
    /// Waits for its cycle.
    Waiting,
    /// Pauses.
    Paused,
    /// Has finished.
    Ended,
}

/// Number of rounds of the lanes after which paused members are resumed.
const PATIENCE: u32 = 1000;

/// Does the same work on up to eight stacks in this thread, each with a [`Seat`]. `pause` is called when every member
/// pauses or has ended.
///
/// Work may wait for another member only by [`Seat::pause`]; any other wait blocks the thread forever.
///
/// Returns whether the system has memory for a stack. Otherwise no work has been done.
pub fn work_side_by_side(work: &dyn Fn(&Seat<'_>), pause: &dyn Fn()) -> bool {
    let member = |stack| ScopedCoroutine::with_stack(stack, |yielder, _| work(&Seat(yielder)));
    let members: Vec<Member<'_>> = (0..LANES)
        .map_while(|_| DefaultStack::new(STACK).ok().map(member))
        .collect();
    let works = !members.is_empty();
    open(members, Vec::new(), pause);
    works
}

/// Opens the scopes of all members and lets them work.
fn open(mut closed: Vec<Member<'_>>, opened: Vec<MemberRef<'_>>, pause: &dyn Fn()) {
    match closed.pop() {
        Some(member) => member.scope(|member| {
            let opened = opened.into_iter().chain([member]).collect();
            open(closed, opened, pause);
        }),
        None => schedule(opened, pause),
    }
}

fn schedule(mut members: Vec<MemberRef<'_>>, pause: &dyn Fn()) {
    let mut states: Vec<State> = members.iter().map(|_| State::Ready(None)).collect();
    let mut batches: Vec<Batch> = Vec::new();
    let mut rounds: u32 = 0;
    loop {
        for (index, member) in members.iter_mut().enumerate() {
            while let State::Ready(answer) = &mut states[index] {
                let answer = answer.take();
                states[index] = match member.resume(answer) {
                    CoroutineResult::Return(()) => State::Ended,
                    CoroutineResult::Yield(None) => State::Paused,
                    CoroutineResult::Yield(Some(task)) => begin(&mut batches, index, task),
                };
            }
        }
        rounds = rounds.wrapping_add(1);
        for batch in &mut batches {
            batch.advance(&mut |member, task| states[member] = State::Ready(Some(task)));
        }
        if states.iter().all(|state| matches!(state, State::Ended)) {
            return;
        }
        let works = |state: &State| matches!(state, State::Waiting | State::Ready(_));
        let waits = states.iter().any(works);
        if !waits {
            pause();
        }
        if !waits || rounds.is_multiple_of(PATIENCE) {
            for state in &mut states {
                if matches!(state, State::Paused) {
                    *state = State::Ready(None);
                }
            }
        }
    }
}

/// Begins a cycle in a lane of points of its shape. A lane is free, because each member has at most one cycle.
fn begin(batches: &mut Vec<Batch>, member: usize, task: Box<CycleTask>) -> State {
    let shape = task.tables.shape;
    let at = batches.iter().position(|batch| batch.shape() == shape);
    let at = at.unwrap_or_else(|| {
        batches.push(Batch::new(shape, InstructionSet::best()));
        batches.len() - 1
    });
    match batches[at].begin(member, task) {
        None => State::Waiting,
        Some(task) => State::Ready(Some(task)),
    }
}
