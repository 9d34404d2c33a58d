//! What can be measured: the items of a plan, and the words that they are made of.

use crate::characterize::settings::Part;
use crate::characterize::team::HardwareThread;
use crate::characterize::vectors::{NON_TEMPORAL, Set};
use strum::{IntoStaticStr, VariantArray};

/// How threads are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Placement {
    /// The cores of a node before those of the next.
    Compact,
    /// The nodes in turn.
    Scattered,
}

impl Placement {
    /// Its name in the record.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// The order in which a chain of loads goes through a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Walk {
    /// Page after page, at random within each.
    Pages,
    /// To another page with every load.
    Hops,
    /// The same on huge pages.
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
    /// Tables of each operating point, made by the worker that computes it.
    Volterra,
    /// Tables of the structure, which serve all operating points.
    ClosedModes,
}

impl Solver {
    /// Its name.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// The sharing of a campaign on one node.
    pub fn usual_sharing(self) -> Sharing {
        match self {
            Self::Volterra => Sharing::Private,
            Self::ClosedModes => Sharing::Shared,
        }
    }
}

/// Which tables threads read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Sharing {
    /// All threads read one copy.
    Shared,
    /// Each thread reads the copy of its node.
    Node,
    /// Each thread has its own copy.
    Private,
}

impl Sharing {
    /// Its name in the record.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// What the threads of a team integrate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Campaign {
    /// The kernel.
    pub solver: Solver,
    /// Its tables.
    pub sharing: Sharing,
    /// Modes of the structure.
    pub modes: usize,
    /// Operating points that every thread goes round.
    pub points: usize,
}

/// One thing to measure; some give several figures.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// Multiply-adds of every member: one figure.
    Arithmetic {
        /// Instruction set.
        set: Set,
        /// Members.
        team: Vec<HardwareThread>,
    },
    /// Read, copy, triad: a figure per kernel of [`StreamKernel::available`].
    Streams {
        /// How the members are placed.
        placement: Placement,
        /// Members.
        team: Vec<HardwareThread>,
        /// Lines of each of a member's arrays.
        lines: usize,
    },
    /// Reading memory of one node from the cores of another: one figure.
    Nodes {
        /// Members, all of one node.
        team: Vec<HardwareThread>,
        /// Node of the memory.
        memory: u32,
        /// Lines of a member's array.
        lines: usize,
    },
    /// Integrating on teams of growing size: a figure per team.
    Solver {
        /// What they integrate.
        campaign: Campaign,
        /// The teams; the first is one thread.
        teams: Vec<Vec<HardwareThread>>,
    },
    /// Reading a buffer: a figure per stride.
    Mountain {
        /// Where.
        thread: HardwareThread,
        /// Lines of the buffer.
        lines: usize,
        /// Strides in lines.
        strides: Vec<usize>,
    },
    /// A chain of loads: a figure per size.
    Latency {
        /// Where.
        thread: HardwareThread,
        /// Node of the memory.
        memory: u32,
        /// Lines of the buffer that the chain goes through.
        sizes: Vec<usize>,
        /// Their order.
        walk: Walk,
    },
}

impl Item {
    /// The part that it belongs to.
    pub fn part(&self) -> Part {
        match self {
            Self::Arithmetic { .. } => Part::Arithmetic,
            Self::Streams { .. } | Self::Nodes { .. } => Part::Bandwidth,
            Self::Solver { .. } => Part::Solver,
            Self::Mountain { .. } => Part::Mountain,
            Self::Latency { .. } => Part::Latency,
        }
    }

    /// What it measures, in a word or two.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Arithmetic { .. } => "arithmetic",
            Self::Streams { .. } => "bandwidth",
            Self::Nodes { .. } => "bandwidth between nodes",
            Self::Solver { .. } => "solver scaling",
            Self::Mountain { .. } => "memory mountain",
            Self::Latency { .. } => "latency",
        }
    }
}

/// What streams through memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamKernel {
    /// Sums an array.
    Read,
    /// `a = b`, past the caches or not.
    Copy(bool),
    /// `a = b + q c`, past the caches or not.
    Triad(bool),
}

impl StreamKernel {
    /// Those of this architecture.
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

    /// Arrays that it reads or writes.
    pub fn arrays(self) -> usize {
        match self {
            Self::Read => 1,
            Self::Copy(_) => 2,
            Self::Triad(_) => 3,
        }
    }
}
