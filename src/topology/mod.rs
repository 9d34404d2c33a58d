//! Cores and NUMA nodes of this machine.
