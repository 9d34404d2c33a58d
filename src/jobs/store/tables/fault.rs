//! Why a table file is not trusted, in words that go on from "it".

use std::io;

use thiserror::Error;

/// What is wrong with a table file.
#[derive(Debug, Error)]
pub enum CacheFault {
    /// There is none.
    #[error("does not exist")]
    Missing,
    /// A folder, a device, a pipe.
    #[error("is not a regular file")]
    NotAFile,
    /// The system refuses.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// No byte.
    #[error("is empty")]
    Empty,
    /// Shorter than it has to be.
    #[error("is cut off: it has {found} of at least {needed} bytes")]
    CutOff {
        /// Length \[bytes\].
        found: usize,
        /// Least length that what is there allows \[bytes\].
        needed: usize,
    },
    /// Longer than its header says.
    #[error("has {found} bytes where its header says {expected}")]
    TooLong {
        /// Length \[bytes\].
        found: usize,
        /// Length that the header gives \[bytes\].
        expected: usize,
    },
    /// Other first bytes.
    #[error("is not a table file of atlas")]
    Magic,
    /// Written on a machine of the other byte order.
    #[error("was written on a machine of the other byte order")]
    ByteOrder,
    /// Another version of the format.
    #[error("has format version {found}; this program reads version {known}")]
    Version {
        /// Version of the file.
        found: u32,
        /// Version of this program.
        known: u32,
    },
    /// A table that earlier versions of this program kept.
    #[error(
        "holds tables of the kernel `{kind}` at one speed, as earlier versions kept them; this program keeps one for all speeds; `atlas table clean` removes the file"
    )]
    Earlier {
        /// What it holds.
        kind: &'static str,
    },
    /// Bytes in front of the data are not those that were written.
    #[error("has a damaged header: its checksum does not match")]
    HeaderChecksum,
    /// Bytes of the data are not those that were written.
    #[error("has damaged data: their checksum does not match")]
    DataChecksum,
    /// The header is whole but says nothing that this program understands.
    #[error("has a header that cannot be understood: {detail}")]
    Header {
        /// What is wrong with it.
        detail: String,
    },
    /// An array lies where it cannot be.
    #[error("has an impossible array `{array}`: {detail}")]
    Layout {
        /// Its name.
        array: String,
        /// What is wrong with it.
        detail: &'static str,
    },
    /// Its key is not that of its kind and inputs.
    #[error("has a key that is not the hash of its inputs")]
    Key,
    /// A table of another kind.
    #[error("holds a {found} table where a {wanted} table is wanted")]
    Kind {
        /// Kind of the file.
        found: &'static str,
        /// Kind asked for.
        wanted: &'static str,
    },
    /// A table of something else.
    #[error("was computed from other inputs")]
    Inputs,
}
