//! The text of a job: parsed, validated (all errors at once) and resolved into a specification.

mod spec;

pub use spec::*;
