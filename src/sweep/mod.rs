//! A grid of operating points over the cores of this machine.
