//! Processor time of this thread: the cost of a computation, independent of other processes.

use std::ffi::{c_int, c_long};

#[repr(C)]
struct Timespec {
    seconds: i64,
    nanoseconds: c_long,
}

/// `CLOCK_THREAD_CPUTIME_ID` of Linux.
const THREAD: c_int = 3;

unsafe extern "C" {
    fn clock_gettime(clock: c_int, time: *mut Timespec) -> c_int;
}

/// Processor time \[s\] that this thread has used.
pub fn now() -> f64 {
    let mut time = Timespec {
        seconds: 0,
        nanoseconds: 0,
    };
    // SAFETY: the place is valid and laid out as the C library expects.
    let flag = unsafe { clock_gettime(THREAD, &mut time) };
    assert_eq!(flag, 0, "no processor clock");
    time.seconds as f64 + 1e-9 * time.nanoseconds as f64
}
