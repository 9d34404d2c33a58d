//! What others wrote: read only where it is a file and of a size that can be judged, and made fit
//! for a terminal before it is repeated there; and what errors say of it.

mod causes;
mod file;
mod printable;

pub use causes::with_causes;
pub use file::{open, read, read_stream};
pub use printable::{clipped, printable, printable_but_colours};
