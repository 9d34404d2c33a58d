//! Summaries and figures from result files; knows nothing of how results came to be.
