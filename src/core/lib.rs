//! Piecewise-linear structures with one-sided contacts. Knows no gears: a [`structure::ModalStructure`] and the cycles of
//! its contacts make a [`model::Model`], kernels of [`propagate`] advance it, [`analysis`] answers questions of it.

pub mod analysis;
pub mod model;
pub mod numerics;
pub mod propagate;
pub mod structure;
