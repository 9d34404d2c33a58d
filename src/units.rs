//! SI quantities and their text form; the one place where units are converted.
