//! Which vector instructions does this process use, and how is a loop written once for all of them?
//!
//! Every loop is generic over a [`Vector`] of eight lanes. Its operations are intrinsics for AVX2 and AVX-512, and
//! loops over arrays otherwise. No vector operation is in a closure or in the `map` of an array: the compiler may
//! call both instead of inlining them, and a called closure does not inherit the target features. Results differ
//! between instruction sets within rounding (fused or separate multiply-add). Runs with one instruction set give
//! the same bits.

mod aligned;
#[cfg(target_arch = "x86_64")]
mod halves;
mod shapes;
mod vector;
#[cfg(target_arch = "x86_64")]
mod wide;

pub use aligned::Aligned;
#[cfg(target_arch = "x86_64")]
pub use halves::Halves;
pub use shapes::{LANES, Lanes, Row, Series, TERMS, interpolation};
pub use vector::{Packed, Vector};
#[cfg(target_arch = "x86_64")]
pub use wide::Wide;

use crate::numerics::instructions::portable;

/// Instruction set of the inner loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InstructionSet(Level);

/// The instruction sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Instructions that every machine has.
    Portable,
    /// AVX2 with fused multiply-adds.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// The instructions that every machine has.
    pub const PORTABLE: Self = Self(Level::Portable);

    /// All sets of this machine, slowest first.
    pub fn available() -> Vec<Self> {
        #[allow(unused_mut)]
        let mut sets = vec![Self::PORTABLE];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                sets.push(Self(Level::Avx2));
                if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                    sets.push(Self(Level::Avx512));
                }
            }
        }
        sets
    }

    /// The fastest set of this machine that the process may use.
    pub fn best() -> Self {
        if portable() {
            return Self::PORTABLE;
        }
        Self::available().last().copied().unwrap_or(Self::PORTABLE)
    }

    /// The instruction set, for [`for_each_set`].
    pub(crate) fn level(self) -> Level {
        self.0
    }

    /// Its usual name.
    pub fn name(self) -> &'static str {
        match self.0 {
            Level::Portable => "baseline",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => "avx512",
        }
    }
}

/// Defines a function for every instruction set from one body that is generic over its
/// vectors.
macro_rules! for_each_set {
    ($(#[$doc:meta])* fn $name:ident($($arg:ident: $type:ty),* $(,)?) $(-> $ret:ty)? = $body:ident) => {
        $(#[$doc])*
        #[inline]
        #[allow(unsafe_code)]
        pub fn $name(set: InstructionSet, $($arg: $type),*) $(-> $ret)? {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma")]
            fn avx2($($arg: $type),*) $(-> $ret)? { $body::<$crate::propagate::vectors::Halves>($($arg),*) }
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
            fn avx512($($arg: $type),*) $(-> $ret)? { $body::<$crate::propagate::vectors::Wide>($($arg),*) }
            match set.level() {
                $crate::propagate::vectors::Level::Portable => $body::<$crate::propagate::vectors::Packed>($($arg),*),
                // SAFETY: only `InstructionSet::available` makes a set beyond the portable one, after it has
                // checked the processor.
                #[cfg(target_arch = "x86_64")]
                $crate::propagate::vectors::Level::Avx2 => unsafe { avx2($($arg),*) },
                // SAFETY: as above.
                #[cfg(target_arch = "x86_64")]
                $crate::propagate::vectors::Level::Avx512 => unsafe { avx512($($arg),*) },
            }
        }
    };
}
pub(crate) use for_each_set;
