//! Dynamics of a linear structure with one-sided contacts, independent of gears.
//!
//! * [`structure`]: a structure in modal coordinates, [`structure::ModalStructure`].
//! * [`model`]: structure, contacts and excitation at an operating point, [`model::Model`].
//! * [`propagate`]: kernels that advance a state exactly between events, such as [`propagate::Volterra`].
//! * [`analysis`]: exponents, orbits, bifurcations, statistics.
//! * [`numerics`]: numerical methods that the other modules use.
//!
//! An oscillator between two elastic walls keeps its energy:
//!
//! ```
//! use gearatlas_core::model::{Drive, InitialState, Model, OperatingPoint};
//! use gearatlas_core::propagate::{Counters, Kernel, Volterra};
//! use gearatlas_core::structure::ModalStructure;
//! use std::f64::consts::TAU;
//!
//! // q'' + q = 0 with walls of 50 N/m at q = ±1 m. A cycle lasts 2π / speed = 1 s.
//! let structure = ModalStructure::of_modes(&[1.0], 0.0, &[1.0], &[1.0]);
//! let point = OperatingPoint { load: 0.0, speed: TAU };
//! let model = Model::new(&structure, &Drive::constant(1.0, 50.0), point)?;
//! let kernel = Volterra::new(&model, f64::EPSILON, 100);
//!
//! let start = InitialState::Modal { displacement: vec![0.0], velocity: vec![3.0] };
//! let mut trajectory = model.start(&start);
//! let mut counters = Counters::default();
//! kernel.advance(1000, &mut trajectory, &mut kernel.workspace(), &mut (), &mut counters)?;
//!
//! let [q, v] = model.basis.modes(&trajectory.state);
//! let wall = (q[0].abs() - 1.0).max(0.0);
//! let energy = 0.5 * (v[0] * v[0] + q[0] * q[0] + 50.0 * wall * wall);
//! assert!((energy / 4.5 - 1.0).abs() < 1e-11);
//! // A period is shorter than 2π s and has four events: each wall is reached once and left once.
//! assert!(counters.events > 600);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod analysis;
pub mod model;
pub mod numerics;
pub mod propagate;
pub mod structure;
