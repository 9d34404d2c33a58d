//! Input from outside: opens only regular files of limited size, makes texts printable for a terminal, and writes
//! errors with their causes.

mod causes;
mod file;
mod printable;

pub use causes::with_causes;
pub use file::{open, read, read_stream};
pub use printable::{clipped, printable, printable_but_colours};
