//! What can be measured? The items of a plan, and their types.

use crate::characterize::settings::Part;
use crate::characterize::team::HardwareThread;
use crate::characterize::vectors::{NON_TEMPORAL, Set};
use strum::{IntoStaticStr, VariantArray};

/// Order in which the threads of a team are placed on cores.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Placement {
    /// The cores of a node before those of the next.
    Compact,
    /// One core of each node in turn.
    Scattered,
}

impl Placement {
    /// Its name in the record.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// The order in which a chain of loads visits a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Walk {
    /// Page by page, in random order within each page.
    Pages,
    /// Another page with every load.
    Hops,
    /// Another page with every load, on huge pages.
    #[strum(to_string = "hops")]
    HopsHuge,
}

impl Walk {
    /// Its name in the record.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A kernel that integrates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Solver {
    /// Its tables are per operating point. The worker that computes the point makes them.
    Volterra,
    /// Its tables belong to the structure and are common to all operating points.
    ClosedModes,
}

impl Solver {
    /// Its name.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// How threads share the tables in campaigns on one node.
    pub fn usual_sharing(self) -> Sharing {
        match self {
            Self::Volterra => Sharing::Private,
            Self::ClosedModes => Sharing::Shared,
        }
    }
}

/// Which copy of the tables a thread reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Sharing {
    /// All threads read one copy.
    Shared,
    /// Each thread reads the copy of its node.
    Node,
    /// Each thread has a separate copy.
    Private,
}

impl Sharing {
    /// Its name in the record.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// The task of a team that integrates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Campaign {
    /// The kernel.
    pub solver: Solver,
    /// How threads share the tables of the kernel.
    pub sharing: Sharing,
    /// Number of modes of the structure.
    pub modes: usize,
    /// Number of operating points that every thread cycles through.
    pub points: usize,
}

/// One measurement, which gives one or several figures.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// Multiply-adds in registers of every member: one figure.
    Arithmetic {
        /// Instruction set.
        set: Set,
        /// Members.
        team: Vec<HardwareThread>,
    },
    /// Read, copy, triad: one figure per kernel of [`StreamKernel::available`].
    Streams {
        /// Placement of the members.
        placement: Placement,
        /// Members.
        team: Vec<HardwareThread>,
        /// Lines of each of a member's arrays.
        lines: usize,
    },
    /// Reading memory of one node from the cores of the same or another node: one figure.
    Nodes {
        /// Members, all of one node.
        team: Vec<HardwareThread>,
        /// Node of the memory.
        memory: u32,
        /// Lines of a member's array.
        lines: usize,
    },
    /// Integration by teams of growing size: one figure per team.
    Solver {
        /// Task of the teams.
        campaign: Campaign,
        /// The teams; the first is one thread.
        teams: Vec<Vec<HardwareThread>>,
    },
    /// Reading a buffer (memory mountain): one figure per stride.
    MemoryMountain {
        /// Thread of the reader.
        thread: HardwareThread,
        /// Lines of the buffer.
        lines: usize,
        /// Strides in lines.
        strides: Vec<usize>,
    },
    /// A chain of loads: one figure per size.
    Latency {
        /// Thread of the loads.
        thread: HardwareThread,
        /// Node of the memory.
        memory: u32,
        /// Numbers of lines in the buffer.
        sizes: Vec<usize>,
        /// Order of the lines.
        walk: Walk,
    },
}

impl Item {
    /// Part of the measurements to which the item belongs.
    pub fn part(&self) -> Part {
        match self {
            Self::Arithmetic { .. } => Part::Arithmetic,
            Self::Streams { .. } | Self::Nodes { .. } => Part::Bandwidth,
            Self::Solver { .. } => Part::Solver,
            Self::MemoryMountain { .. } => Part::Mountain,
            Self::Latency { .. } => Part::Latency,
        }
    }

    /// Its name in messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Arithmetic { .. } => "arithmetic",
            Self::Streams { .. } => "bandwidth",
            Self::Nodes { .. } => "bandwidth between nodes",
            Self::Solver { .. } => "solver scaling",
            Self::MemoryMountain { .. } => "memory mountain",
            Self::Latency { .. } => "latency",
        }
    }
}

/// A loop that streams through memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamKernel {
    /// Sums an array.
    Read,
    /// `a = b`; true bypasses the caches.
    Copy(bool),
    /// `a = b + q c`; true bypasses the caches.
    Triad(bool),
}

impl StreamKernel {
    /// The kernels of this architecture.
    pub fn available() -> Vec<Self> {
        let mut kernels = vec![Self::Read, Self::Copy(false), Self::Triad(false)];
        if NON_TEMPORAL {
            kernels.extend([Self::Copy(true), Self::Triad(true)]);
        }
        kernels
    }

    /// Its name in the record.
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Copy(false) => "copy",
            Self::Copy(true) => "copy_nt",
            Self::Triad(false) => "triad",
            Self::Triad(true) => "triad_nt",
        }
    }

    /// Number of arrays that it reads or writes.
    pub fn arrays(self) -> usize {
        match self {
            Self::Read => 1,
            Self::Copy(_) => 2,
            Self::Triad(_) => 3,
        }
    }
}
