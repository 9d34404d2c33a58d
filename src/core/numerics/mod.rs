//! Numerical tools independent of gears: quadrature, Legendre series and their
//! roots, exponentials as Legendre series, functions through points, convolution, small dense algebra, statistics
//! of series, chains and rare events, weighted Birkhoff averages, random streams, integers, nested grids.

pub mod arithmetic;
pub mod bessel;
pub mod birkhoff;
pub mod chains;
pub mod convolution;
pub mod decoupling;
pub mod exponential;
pub mod fourier;
pub mod instructions;
pub mod integers;
pub mod legendre;
pub mod linalg;
pub mod nested_grid;
pub mod pair_response;
pub mod plain;
pub mod point_course;
pub mod poisson;
pub mod product_moduli;
pub mod proportion;
pub mod quadrature;
pub mod random;
pub mod roots;
pub mod statistics;
