//! Which instructions does this process use: all those of its processor, or only those that every
//! processor has, so that equal jobs give equal bits everywhere?
//!
//! A fused multiply-add rounds once, a product and a sum round twice. Wider vectors add in another order.
//! Loops in several versions read the choice here. The choice applies to the whole process, as that of the
//! system's mathematical library does.

use std::sync::atomic::{AtomicBool, Ordering};

static PORTABLE: AtomicBool = AtomicBool::new(false);

/// From now on this process uses only instructions of every processor.
pub fn keep_portable() {
    PORTABLE.store(true, Ordering::Relaxed);
}

/// Whether this process uses only instructions of every processor.
#[inline]
pub fn portable() -> bool {
    PORTABLE.load(Ordering::Relaxed)
}
