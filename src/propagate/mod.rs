//! Kernels that march the piecewise-linear system, and what they share: events, saltation, counters.
