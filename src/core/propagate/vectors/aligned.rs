//! Numbers that start on a cache line, so that a vector load never spans two lines.

use super::shapes::LANES;
use std::ops::{Deref, DerefMut};

/// A cache line \[bytes\].
const LINE: usize = LANES * size_of::<f64>();

/// Numbers that start on a cache line.
#[derive(Debug, Default)]
pub struct Aligned {
    /// Memory with space for alignment.
    room: Vec<f64>,
    first: usize,
    length: usize,
}

impl Aligned {
    /// `length` zeros.
    pub fn zeros(length: usize) -> Self {
        let room = vec![0.0; length + LANES - 1];
        // If the address is unknown, as in Miri, alignment does not matter.
        let first = room.as_ptr().align_offset(LINE).min(LANES - 1);
        Self {
            room,
            first,
            length,
        }
    }

    /// Sets the length to `length`, with arbitrary values. Allocates if the memory is too small.
    pub fn set_length(&mut self, length: usize) {
        if self.first + length <= self.room.len() {
            self.length = length
        } else {
            *self = Self::zeros(length)
        }
    }
}

impl From<&[f64]> for Aligned {
    fn from(values: &[f64]) -> Self {
        let mut aligned = Self::zeros(values.len());
        aligned.copy_from_slice(values);
        aligned
    }
}

impl Clone for Aligned {
    fn clone(&self) -> Self {
        (&self[..]).into()
    }
}

impl PartialEq for Aligned {
    fn eq(&self, other: &Self) -> bool {
        self[..] == other[..]
    }
}

impl Deref for Aligned {
    type Target = [f64];

    #[inline(always)]
    fn deref(&self) -> &[f64] {
        &self.room[self.first..][..self.length]
    }
}

impl DerefMut for Aligned {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.room[self.first..][..self.length]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_start_on_a_line_and_are_kept() {
        for length in [0, 1, 7, 8, 83, 1000] {
            let values: Vec<f64> = (0..length).map(f64::from).collect();
            let own = Aligned::from(&values[..]);
            assert_eq!(own[..], values[..]);
            let copy = own.clone();
            assert_eq!(copy, own);
            let mut held = Aligned::from(&[1.0; 100][..]);
            held.set_length(length as usize);
            assert_eq!(held.len(), length as usize);
            if cfg!(not(miri)) {
                assert!(
                    own.as_ptr().align_offset(LINE) == 0 && copy.as_ptr().align_offset(LINE) == 0
                );
            }
        }
    }
}
