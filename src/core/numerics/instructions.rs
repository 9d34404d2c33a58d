//! Does this process use all instructions of its processor, or only those that every processor has? With the
//! latter, equal jobs give equal bits on every machine.
//!
//! A fused multiply-add rounds once, a product and a sum round twice. Wider vectors add in another order.
//! Loops that exist in several versions read the choice here. It applies to the whole process.

use std::sync::atomic::{AtomicBool, Ordering};

static PORTABLE: AtomicBool = AtomicBool::new(false);

/// From now on this process uses only instructions that every processor has.
pub fn keep_portable() {
    PORTABLE.store(true, Ordering::Relaxed);
}

/// Whether this process uses only instructions that every processor has.
#[inline]
pub fn portable() -> bool {
    PORTABLE.load(Ordering::Relaxed)
}
