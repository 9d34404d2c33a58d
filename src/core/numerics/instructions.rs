//! Which instructions results are computed with: those of this processor, or only such as every
//! processor has, so that equal jobs have equal bits everywhere.
//!
//! A fused multiply-add rounds once where a product and a sum round twice, and wider vectors add
//! in another order. Who has a choice of such loops asks here. It is a choice of the process: the
//! mathematical library of the system chooses for a process, too.

use std::sync::atomic::{AtomicBool, Ordering};

static PORTABLE: AtomicBool = AtomicBool::new(false);

/// From now on this process computes as every processor can.
pub fn keep_portable() {
    PORTABLE.store(true, Ordering::Relaxed);
}

/// Whether this process computes as every processor can.
#[inline]
pub fn portable() -> bool {
    PORTABLE.load(Ordering::Relaxed)
}
