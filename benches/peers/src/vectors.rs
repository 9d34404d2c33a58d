//! Vector operations for CVODE, compiled for this processor.
//!
//! Debian's library is built for any processor, and with forty modes CVODE spends most of its time on sums of short
//! vectors (its predictor alone makes about q²/2 of them per step at order q). This module replaces the three relevant
//! operations, so that the comparison concerns the method rather than the package.

use crate::sundials::{self as c, Opaque};
use std::ffi::c_void;

/// `struct _generic_N_Vector`.
#[repr(C)]
struct Vector {
    content: *mut c_void,
    operations: *mut Operations,
    context: Opaque,
}

/// The head of `struct _generic_N_Vector_Ops`, up to the last replaced entry.
#[repr(C)]
struct Operations {
    constructors: [*const c_void; 10],
    linear_sum: unsafe extern "C" fn(f64, Opaque, f64, Opaque, Opaque),
    constant_product_quotient: [*const c_void; 3],
    scale: unsafe extern "C" fn(f64, Opaque, Opaque),
    absolute_to_max_norm: [*const c_void; 5],
    weighted_norm: unsafe extern "C" fn(Opaque, Opaque) -> f64,
}

/// Replaces the operations of a vector and of all vectors cloned from it.
///
/// # Safety
/// `vector` is a serial vector of SUNDIALS 6 that is not in use.
pub unsafe fn accelerate(vector: Opaque) {
    // SAFETY: the layout is that of the library's public header.
    unsafe {
        let operations = (*vector.cast::<Vector>()).operations;
        (*operations).linear_sum = linear_sum;
        (*operations).scale = scale;
        (*operations).weighted_norm = weighted_norm;
    }
}

/// Calls `each(x, y)` entry by entry and stores what it gives in z, which may be x or y itself.
///
/// # Safety
/// All three are vectors of one length; z is x, y, or apart from both.
unsafe fn combine(x: Opaque, y: Opaque, z: Opaque, each: impl Fn(f64, f64) -> f64) {
    const LANES: usize = 8;
    // SAFETY: the places lie within the vectors; eight are read before any is written, and
    // vectors overlap entirely or not at all.
    unsafe {
        let n = c::N_VGetLength(x) as usize;
        let [x, y, z] = [x, y, z].map(|v| c::N_VGetArrayPointer(v));
        let mut i = 0;
        while i + LANES <= n {
            let a = x.add(i).cast::<[f64; LANES]>().read();
            let b = y.add(i).cast::<[f64; LANES]>().read();
            let sum: [f64; LANES] = std::array::from_fn(|lane| each(a[lane], b[lane]));
            z.add(i).cast::<[f64; LANES]>().write(sum);
            i += LANES;
        }
        for i in i..n {
            *z.add(i) = each(*x.add(i), *y.add(i));
        }
    }
}

unsafe extern "C" fn linear_sum(a: f64, x: Opaque, b: f64, y: Opaque, z: Opaque) {
    // SAFETY: the library passes vectors of one length.
    unsafe { combine(x, y, z, |x, y| a * x + b * y) }
}

unsafe extern "C" fn scale(factor: f64, x: Opaque, z: Opaque) {
    // SAFETY: as above.
    unsafe { combine(x, x, z, |x, _| factor * x) }
}

unsafe extern "C" fn weighted_norm(x: Opaque, weights: Opaque) -> f64 {
    // SAFETY: as above; both are only read.
    let (x, weights) = unsafe {
        let n = c::N_VGetLength(x) as usize;
        let [x, w] = [x, weights].map(|v| c::N_VGetArrayPointer(v).cast_const());
        (
            std::slice::from_raw_parts(x, n),
            std::slice::from_raw_parts(w, n),
        )
    };
    let mut sums = [0.0; 8];
    let (x_chunks, x_rest) = x.as_chunks::<8>();
    let (w_chunks, w_rest) = weights.as_chunks::<8>();
    for (x, w) in x_chunks.iter().zip(w_chunks) {
        for lane in 0..8 {
            sums[lane] += (x[lane] * w[lane]).powi(2);
        }
    }
    let rest: f64 = x_rest
        .iter()
        .zip(w_rest)
        .map(|(x, w)| (x * w).powi(2))
        .sum();
    ((sums.iter().sum::<f64>() + rest) / x.len() as f64).sqrt()
}
