//! The mesh closed on itself where its stiffness varies over a window.
//!
//! With k no constant, `f = k (δ − s b) + c δ'` is asked for at the P Gauss nodes of the
//! window (collocation): B and B' take values at the nodes to values at the nodes, and
//!
//! ```text
//! (I + diag(k) B + c B') f = diag(k) (d − s b) + c 𝒟 d,      δ = d − B f
//! ```
//!
//! A window on the grid meets the same k in every cycle: its system is solved once, for all d
//! ([`super::feedback::Feedback`]). One that starts elsewhere is factorised where it is met,
//! `L U` by columns; its tangents share the factors. The matrix is that of a causal operator,
//! nearly lower triangular with a unit diagonal when the nodes are taken in order of time, and
//! is eliminated in that order without exchanging rows.

use super::shapes::{Row, Series, TERMS};
use crate::numerics::convolution::product;
use crate::numerics::legendre::transforms24;
use std::sync::LazyLock;

/// Matrices of windows of one length, by columns.
#[derive(Debug)]
pub struct Nodal {
    /// B, from values at the nodes to values at the nodes.
    pub response: [Row; TERMS],
    /// B', likewise.
    pub response_rate: [Row; TERMS],
    /// B, from series to series.
    pub series_response: [Row; TERMS],
    /// 2/Δ: a derivative by time over that by place \[1/s\].
    pub pace: f64,
    /// What is the same for all windows.
    pub maps: &'static Maps,
}

/// Maps between series and values at the nodes, by columns.
#[derive(Debug)]
pub struct Maps {
    /// From a series to its values at the nodes.
    pub values: [Row; TERMS],
    /// From a series to the values of its derivative by place.
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
    /// Columns of −D⁻¹U above its diagonal, D being that diagonal.
    pub upper: [Row; TERMS],
    /// One over the diagonal of U.
    pub pivots: Row,
    /// k at the nodes \[N/m\].
    pub stiffness: Row,
    /// c \[N s/m\].
    pub damping: f64,
}

impl Factors {
    /// Of no window yet.
    pub const NONE: Self = Self {
        lower: [Row::ZERO; TERMS],
        upper: [Row::ZERO; TERMS],
        pivots: Row::ZERO,
        stiffness: Row::ZERO,
        damping: 0.0,
    };
}
