//! Where the bytes of a table file are.
//!
//! ```text
//!   0  magic "atlastbl"
//!   8  order mark  u32   0x01020304 in the byte order of the writer, as all that follows
//!  12  version     u32
//!  16  length of the header [bytes]  u64
//!  24  length of the inputs [bytes]  u64
//!  32  BLAKE3 of bytes 0 to 32 and of those from 64 to the data
//!  64  header, JSON: kind, key, program, BLAKE3 of the data, arrays
//!      inputs, JSON in canonical form: what the table was computed from
//!      zeros up to a multiple of 64
//!      data: arrays of f64, each at a multiple of 64, zeros between them
//! ```
//!
//! 64 bytes are a cache line and the widest vector register. A mapping starts at a page, so
//! multiples hold in memory as well.

use std::ops::Range;

/// Says what the file is.
pub(super) const MAGIC: &[u8; 8] = b"atlastbl";
/// Changes whenever a file of before is read otherwise; part of every key.
pub(super) const VERSION: u32 = 1;
/// Read with its bytes reversed on a machine of the other byte order.
pub(super) const ORDER_MARK: u32 = 0x0102_0304;
/// Length of what comes before the header \[bytes\].
pub(super) const PRELUDE: usize = 64;
/// Arrays start at multiples of this \[bytes\].
pub(super) const ALIGNMENT: usize = 64;
/// Where the checksum of the header is.
pub(super) const CHECKSUM: Range<usize> = 32..64;
/// Bytes of a number.
pub(super) const NUMBER: usize = size_of::<f64>();

/// The next multiple of [`ALIGNMENT`].
pub(super) fn aligned(length: usize) -> Option<usize> {
    length.checked_next_multiple_of(ALIGNMENT)
}
