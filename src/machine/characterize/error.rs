//! Why a measurement gives no figure.

use crate::model::ModelError;
use crate::propagate::Stop;
use crate::shaft::ShaftError;
use std::io;
use thiserror::Error;

/// Why a measurement gives no figure.
#[derive(Debug, Error)]
pub enum MeasurementError {
    /// The system does not grant the memory.
    #[error("the system did not grant {} MiB of memory: {source}", .bytes >> 20)]
    Memory {
        /// Requested size.
        bytes: usize,
        /// The system's message.
        source: io::Error,
    },
    /// The system has no huge pages.
    #[error("the system did not grant huge pages: {source}")]
    HugePages {
        /// The system's message.
        source: io::Error,
    },
    /// Memory of a node is not available.
    #[error("memory of node {node} is not available: {detail}")]
    Node {
        /// The node.
        node: u32,
        /// The reason.
        detail: String,
    },
    /// A computation whose time was measured gave a wrong result.
    #[error("{what} gave a wrong result, so its times are not shown")]
    Wrong {
        /// Name of the measurement.
        what: &'static str,
    },
    /// The built-in drive cannot be read.
    #[error("the built-in drive lacks {what}")]
    Drive {
        /// The missing part.
        what: &'static str,
    },
    /// The built-in drive cannot be assembled.
    #[error("the built-in drive cannot be assembled: {0}")]
    Shaft(#[from] ShaftError),
    /// The built-in drive has no model.
    #[error("the built-in drive has no model: {0}")]
    Model(#[from] ModelError),
    /// The tables of a kernel cannot be built for the built-in drive.
    #[error("the built-in drive has no tables: {0}")]
    Tables(Box<dyn std::error::Error + Send + Sync>),
    /// A trajectory stopped.
    #[error("the trajectory stopped: {0}")]
    Stopped(#[from] Stop),
}
