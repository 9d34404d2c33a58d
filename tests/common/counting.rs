//! A counting allocator, and the allocations of a kernel during integration.

// An allocator cannot be replaced without unsafe code.
#![allow(unsafe_code)]
// Every test program uses a part of it.
#![allow(dead_code, clippy::unwrap_used)]

use gearatlas::model::{InitialState, Model};
use gearatlas::propagate::{Counters, Event, Kernel, Observer, Tangents, Window};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Allocations of this thread only, because the test harness allocates on others.
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is handed to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of this thread so far.
pub fn count() -> u64 {
    COUNT.with(Cell::get)
}

/// Sums all windows, so that the compiler cannot remove them.
#[derive(Default)]
struct Sum(f64);

impl Observer for Sum {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        self.0 += window.deflection[0] * window.duration;
    }

    fn event(&mut self, event: &Event) {
        self.0 += event.rate;
    }
}

/// Advances a rattling drive, observed and with tangents, and a second one without, like a twin. Counts allocations
/// after the first cycle, which allocates for the tangents.
pub fn allocations<K: Kernel>(kernel: &K, model: &Model) -> u64 {
    let mut trajectory = model.start(&InitialState::Static);
    let mut twin = trajectory.clone();
    let mut tangents = Tangents::zeros(model.modes(), 2);
    tangents.vector_mut(0)[0] = 1e-9;
    tangents.vector_mut(1)[model.modes()] = 1e-5;
    let mut workspace = kernel.workspace();
    let mut sum = Sum::default();
    let mut counters = Counters::default();
    let mut before = 0;
    for cycle in 0..31 {
        if cycle == 1 {
            before = count();
        }
        let mut none = Tangents::none();
        for (trajectory, tangents) in [(&mut trajectory, &mut tangents), (&mut twin, &mut none)] {
            kernel
                .advance_cycle(
                    trajectory,
                    tangents,
                    &mut workspace,
                    &mut sum,
                    &mut counters,
                )
                .unwrap();
        }
    }
    let count = count() - before;
    assert_eq!(trajectory, twin, "tangents change the trajectory");
    assert!(counters.events > 20, "the drive does not rattle");
    assert!(sum.0.is_finite());
    count
}
