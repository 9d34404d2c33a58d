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
use crate::numerics::legendre::{self, transforms24};

/// Matrices of windows of one length, by columns.
#[derive(Debug)]
pub struct Nodal {
    /// B, from values at the nodes to values at the nodes.
    pub response: [Row; TERMS],
    /// B', likewise.
    pub response_rate: [Row; TERMS],
    /// B, from series to series.
    pub series_response: [Row; TERMS],
    /// From a series to its values at the nodes.
    pub values: [Row; TERMS],
    /// From a series to the values of its derivative by time \[1/s\].
    pub slopes: [Row; TERMS],
    /// From values at the nodes to the series.
    pub series: [Row; TERMS],
}

impl Nodal {
    /// The matrices for windows of length `delta` \[s\], given the columns of B and B'.
    pub fn new(
        response: &[Series; TERMS],
        response_rate: &[Series; TERMS],
        delta: f64,
    ) -> Box<Self> {
        let transforms = transforms24();
        let unit = |n: usize| -> Series { std::array::from_fn(|i| f64::from(u8::from(i == n))) };
        let at_nodes =
            |series: &Series| Row(transforms.nodes().map(|x| legendre::evaluate(series, x)));
        let apply = |columns: &[Series; TERMS], series: &Series| {
            let mut out = [0.0; TERMS];
            for (column, weight) in columns.iter().zip(series) {
                for (o, c) in out.iter_mut().zip(column) {
                    *o += c * weight;
                }
            }
            out
        };
        let series: [Row; TERMS] = std::array::from_fn(|j| Row(transforms.interpolate(&unit(j))));
        Box::new(Self {
            response: std::array::from_fn(|j| at_nodes(&apply(response, &series[j].0))),
            response_rate: std::array::from_fn(|j| at_nodes(&apply(response_rate, &series[j].0))),
            series_response: response.map(Row),
            values: std::array::from_fn(|n| at_nodes(&unit(n))),
            slopes: std::array::from_fn(|n| {
                let slope = legendre::derivative(&unit(n)).map(|a| 2.0 / delta * a);
                at_nodes(&slope)
            }),
            series,
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
