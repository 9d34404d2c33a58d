//! The piecewise-linear system. The only description of the dynamics; knows nothing of how it is solved.
