//! Kernels, and maps over items, that integrate several points at once if they can.

use super::batch::CycleTask;
use super::group::{Seat, work_side_by_side};
use super::tables::PointTables;
use crate::model::TrajectoryState;
use crate::propagate::{Counters, Kernel, Observer, Stop, Tangents};
use rayon::prelude::*;
use std::cell::{Cell, RefCell};
use std::sync::Arc;

/// A kernel that integrates a point's cycles together with those of other points, if it can.
pub struct SideBySide<'a, K> {
    kernel: &'a K,
    seat: Option<&'a Seat<'a>>,
}

/// Scratch memory of a kernel, and a cycle in a lane.
#[derive(Debug)]
pub struct Workspace<W> {
    alone: W,
    task: Option<Box<CycleTask>>,
}

impl<'a, K: Kernel> SideBySide<'a, K> {
    /// A kernel for work on one of the stacks of [`work_side_by_side`]. Without a seat, it integrates every
    /// cycle alone.
    pub fn new(kernel: &'a K, seat: Option<&'a Seat<'a>>) -> Self {
        Self { kernel, seat }
    }
}

impl<K: Kernel> Kernel for SideBySide<'_, K> {
    const FARTHEST: f64 = K::FARTHEST;

    type Workspace = Workspace<K::Workspace>;

    fn workspace(&self) -> Self::Workspace {
        Workspace {
            alone: self.kernel.workspace(),
            task: None,
        }
    }

    fn exact(&self) -> bool {
        self.kernel.exact()
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Self::Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let Workspace { alone, task } = workspace;
        let fits = |tables: &&Arc<PointTables>| tangents.count() <= tables.most_tangents();
        let asks = !O::WINDOWS && !observer.is_interrupted();
        if let Some(seat) = self.seat.filter(|_| asks)
            && let Some(tables) = self.kernel.point_tables().filter(fits)
        {
            let new = || Box::new(CycleTask::new(tables.clone()));
            let mut asked = task.take().unwrap_or_else(new);
            asked.exchange(trajectory, tangents);
            let answer = task.insert(seat.integrate(asked));
            answer.exchange(trajectory, tangents);
            if answer.done {
                counters.cycles += 1;
                counters.events += answer.events.len() as u64;
                for event in &answer.events {
                    observer.event(event);
                }
                return Ok(());
            }
        }
        (self.kernel).advance_cycle(trajectory, tangents, alone, observer, counters)
    }
}

/// Smallest number of items in a group, which one call of [`work_side_by_side`] processes.
const FEWEST_ITEMS: usize = 16;

/// Groups per thread, so that threads end at about the same time.
const GROUPS_PER_THREAD: usize = 4;

/// Maps items with a kernel on all threads of the present pool. Trajectories of few modes advance side by side.
pub fn map_side_by_side<K: Kernel + Sync, T: Sync, R: Send>(
    kernel: &K,
    items: &[T],
    map: impl Fn(&SideBySide<'_, K>, &T) -> R + Sync,
) -> Vec<R> {
    let alone = |item: &T| map(&SideBySide::new(kernel, None), item);
    if kernel.point_tables().is_none() {
        return items.par_iter().map(alone).collect();
    }
    let groups = GROUPS_PER_THREAD * rayon::current_num_threads();
    let map_group = |group: &[T]| -> Vec<R> {
        let next = Cell::new(0);
        let results = RefCell::new(group.iter().map(|_| None).collect::<Vec<Option<R>>>());
        let work = |seat: &Seat<'_>| {
            while let Some(item) = group.get(next.get()) {
                let place = next.replace(next.get() + 1);
                let result = map(&SideBySide::new(kernel, Some(seat)), item);
                results.borrow_mut()[place] = Some(result);
            }
        };
        if work_side_by_side(&work, &|| ()) {
            results.into_inner().into_iter().flatten().collect()
        } else {
            group.iter().map(alone).collect()
        }
    };
    let size = items.len().div_ceil(groups).max(FEWEST_ITEMS);
    (items.par_chunks(size).map(map_group))
        .collect::<Vec<_>>()
        .into_iter()
        .flatten()
        .collect()
}
