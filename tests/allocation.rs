//! Does an integrated cycle allocate? The test integrates every kernel under a counting allocator.

#![allow(clippy::unwrap_used)]

mod common;
#[path = "common/counting.rs"]
mod counting;

use counting::allocations;
use gearatlas::model::Model;
use gearatlas::propagate::{ClosedModes, Kernel, KernelChoice, KernelUse, TableError};

/// Largest number of events in a mesh cycle.
const EVENT_LIMIT: u32 = 1000;

/// All kernels, with settings for these drives.
fn kernels() -> Vec<KernelChoice> {
    let choice = |name| match name {
        "volterra" => KernelChoice::Volterra,
        "closed_modes" => KernelChoice::ClosedModes,
        "stepping" => KernelChoice::Stepping { steps: 1000 },
        _ => panic!("no settings for `{name}`, which is to be integrated here too"),
    };
    let names = KernelChoice::SETTINGS.iter().map(|(name, _)| *name);
    names.map(choice).collect()
}

/// Counts the allocations of a kernel that advances a model.
struct Count<'m>(&'m Model);

impl KernelUse for Count<'_> {
    type Output = u64;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> u64 {
        allocations(kernel, self.0)
    }
}

fn count(kernel: KernelChoice, model: &Model) -> Result<u64, TableError> {
    let kept = || Ok(Box::new(ClosedModes::arrays(model)?));
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
    let before = counting::count();
    let boxed = std::hint::black_box(Box::new(1));
    assert!(counting::count() > before, "{boxed}");
}
