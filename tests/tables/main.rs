//! Tables on disk through the library and the real program: concurrent builds by several processes, folders and disks
//! that refuse, `atlas table`, `atlas show` of a table, and pictures.

#![allow(clippy::unwrap_used)]

mod command;
mod made;
mod pictures;
mod processes;
#[path = "../common/program.rs"]
mod program;
mod refusals;
#[path = "../common/skipped.rs"]
mod skipped;
