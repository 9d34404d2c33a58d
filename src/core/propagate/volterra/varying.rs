//! How is a window in contact solved if its stiffness varies?
//!
//! With a varying k, `f = k (δ − s b) + c δ'` is required at the P Gauss nodes of the window (collocation). B and B'
//! map values at the nodes to values at the nodes, and
//!
//! ```text
//! (I + diag(k) B + c B') f = diag(k) (d − s b) + c 𝒟 d,      δ = d − B f
//! ```
//!
//! A window on the grid has the same k in every cycle, so its system is solved once for all d
//! ([`super::feedback::Feedback`]). A window that starts elsewhere is factorised when it occurs, `L U` by columns;
//! its tangents share the factors. The operator is causal: with nodes in the order of time, the matrix is nearly
//! lower triangular with a unit diagonal. It is eliminated in that order without row exchanges.

use super::shapes::{Row, Series, TERMS};
use crate::numerics::convolution::product;
use crate::numerics::legendre::transforms24;
use std::sync::LazyLock;

/// Matrices of windows of one length, by columns.
#[derive(Debug)]
pub struct Nodal {
    /// B, from values at the nodes to values at the nodes.
    pub response: [Row; TERMS],
    /// B', from values at the nodes to values at the nodes.
    pub response_rate: [Row; TERMS],
    /// B, from series to series.
    pub series_response: [Row; TERMS],
    /// 2/Δ: the ratio of a derivative with respect to time to the one with respect to position \[1/s\].
    pub pace: f64,
    /// Maps that all windows share.
    pub maps: &'static Maps,
}

/// Maps between series and values at the nodes, by columns.
#[derive(Debug)]
pub struct Maps {
    /// From a series to its values at the nodes.
    pub values: [Row; TERMS],
    /// From a series to the values of its derivative with respect to position.
    pub slopes: [Row; TERMS],
    /// From values at the nodes to the series.
    pub series: [Row; TERMS],
}

static MAPS: LazyLock<Maps> = LazyLock::new(|| {
    let transforms = transforms24();
    let values = &transforms.to_nodes().0;
    Maps {
        values: values.map(Row),
        slopes: product(values, &transforms.to_derivative().0).map(Row),
        series: transforms.to_series().map(Row),
    }
});

impl Nodal {
    /// The matrices for windows of length `delta` \[s\], given the columns of B and B'.
    pub fn new(
        response: &[Series; TERMS],
        response_rate: &[Series; TERMS],
        delta: f64,
    ) -> Box<Self> {
        let transforms = transforms24();
        let at_nodes = |operator: &[Series; TERMS]| {
            let values = product(&transforms.to_nodes().0, operator);
            product(&values, transforms.to_series()).map(Row)
        };
        Box::new(Self {
            response: at_nodes(response),
            response_rate: at_nodes(response_rate),
            series_response: response.map(Row),
            pace: 2.0 / delta,
            maps: &MAPS,
        })
    }
}

/// The factors of one window's system.
#[derive(Debug, Clone)]
pub struct Factors {
    /// Columns of −L below its unit diagonal.
    pub lower: [Row; TERMS],
    /// Columns of −D⁻¹U above the diagonal D of U.
    pub upper: [Row; TERMS],
    /// One over the diagonal of U.
    pub pivots: Row,
    /// k at the nodes \[N/m\].
    pub stiffness: Row,
    /// c \[N s/m\].
    pub damping: f64,
}

impl Factors {
    /// Zeros, before the first window.
    pub const NONE: Self = Self {
        lower: [Row::ZERO; TERMS],
        upper: [Row::ZERO; TERMS],
        pivots: Row::ZERO,
        stiffness: Row::ZERO,
        damping: 0.0,
    };
}
