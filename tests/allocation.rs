//! Does an integrated cycle allocate? Every kernel is integrated under a counting allocator.

// The one place where unsafe code is needed: an allocator cannot be replaced without.
#![allow(unsafe_code)]
#![allow(clippy::unwrap_used)]

mod common;

use gearatlas::model::{InitialState, Model};
use gearatlas::propagate::{
    Counters, DenseError, Event, Kernel, KernelChoice, KernelTable, KernelUse, Observer, Tangents,
    Window,
};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Allocations of this thread, so that the test harness does not count.
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

/// Adds up what it is shown, so that nothing can be left out.
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

/// Advances a rattling drive, watched and with tangents, and beside it one without, as a twin
/// would be; counts allocations after the first cycle, which makes room for the tangents.
fn allocations<K: Kernel>(kernel: &K, model: &Model) -> u64 {
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
            before = COUNT.with(Cell::get);
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
    let count = COUNT.with(Cell::get) - before;
    assert_eq!(trajectory, twin, "tangents change the trajectory");
    assert!(counters.events > 20, "the drive does not rattle");
    assert!(sum.0.is_finite());
    count
}

/// Most events in a mesh cycle.
const EVENT_LIMIT: u32 = 1000;

/// Fewest unit steps a mesh cycle of the kernels with tables.
const CELLS: u32 = 60;

/// Every kernel there is, with settings for the drives here.
fn kernels() -> Vec<KernelChoice> {
    let choice = |name| match name {
        "volterra" => KernelChoice::Volterra,
        "closed_modes" => KernelChoice::ClosedModes,
        "stepping" => KernelChoice::Stepping { steps: 1000 },
        "dyadic" => KernelChoice::Dyadic { cells: CELLS },
        "hermite" => KernelChoice::Hermite { cells: CELLS },
        "spectral" => KernelChoice::Spectral {
            cells: CELLS,
            event_grid: None,
        },
        "fused" => KernelChoice::Fused { cells: CELLS },
        _ => panic!("no settings for `{name}`, which is to be integrated here too"),
    };
    let names = KernelChoice::SETTINGS.iter().map(|(name, _)| *name);
    let on_a_grid = KernelChoice::Spectral {
        cells: CELLS,
        event_grid: Some(240),
    };
    names.map(choice).chain([on_a_grid]).collect()
}

/// Counts the allocations of a kernel that advances a model.
struct Count<'m>(&'m Model);

impl KernelUse for Count<'_> {
    type Output = u64;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> u64 {
        allocations(kernel, self.0)
    }
}

fn count(kernel: KernelChoice, model: &Model) -> Result<u64, DenseError> {
    let kept = |table: KernelTable| Ok(Box::new(table.arrays(model)?));
    kernel.apply(model, EVENT_LIMIT, kept, Count(model))
}

#[test]
fn integrating_allocates_nothing() {
    for (drive, case) in common::drives() {
        let model = common::model(&case);
        for kernel in kernels() {
            let counted = count(kernel, &model).unwrap_or_else(|refused| {
                panic!("{kernel:?} on {drive}: {refused}");
            });
            assert_eq!(counted, 0, "{kernel:?} on {drive}");
        }
    }
}

#[test]
fn allocator_counts() {
    let before = COUNT.with(Cell::get);
    let boxed = std::hint::black_box(Box::new(1));
    assert!(COUNT.with(Cell::get) > before, "{boxed}");
}
