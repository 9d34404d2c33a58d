//! Result files: the one place where results meet columns.
