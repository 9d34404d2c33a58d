//! Input from outside: opens only regular files, reads at most a given number of bytes, makes texts printable for a
//! terminal, and writes errors with their causes.

mod causes;
mod file;
mod printable;

pub use causes::with_causes;
pub use file::{open, read, read_stream};
pub use printable::{clipped, printable, printable_but_colours};
