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

/// A mesh of the default drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mesh {
    /// Two levels of stiffness, as in the default manifest.
    TwoLevels,
    /// A level of its own for each of sixty segments, as a computed mesh has.
    SixtyLevels,
}

/// A kernel that integrates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Solver {
    /// The structured kernel.
    Volterra,
    /// Dense tables, spectral form.
    Spectral,
    /// The same with certified runs.
    Fused,
}

impl Solver {
    /// Its name.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Which tables threads read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Sharing {
    /// All the same one.
    Shared,
    /// The one of their node.
    Node,
    /// Those of eight operating points.
    Eight,
}

impl Sharing {
    /// Its name in the record.
    pub fn name(self) -> &'static str {
        self.into()
    }
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
    /// Read, copy, triad: a figure a kernel of [`StreamKernel::available`].
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
    /// Dense products over rotating operators: a figure a count.
    Operators {
        /// Where.
        thread: HardwareThread,
        /// Rows and columns.
        dimension: usize,
        /// How many operators rotate.
        counts: Vec<usize>,
    },
    /// Integrating rotating operating points with the structured kernel: a figure a count.
    Points {
        /// Where.
        thread: HardwareThread,
        /// The mesh.
        mesh: Mesh,
        /// How many points rotate.
        counts: Vec<usize>,
    },
    /// Integrating on teams of growing size: a figure a team.
    Solver {
        /// The kernel.
        solver: Solver,
        /// Its tables.
        sharing: Sharing,
        /// Modes.
        modes: usize,
        /// The teams.
        teams: Vec<Vec<HardwareThread>>,
    },
    /// Reading a buffer: a figure a stride.
    Mountain {
        /// Where.
        thread: HardwareThread,
        /// Lines of the buffer.
        lines: usize,
        /// Strides in lines.
        strides: Vec<usize>,
    },
    /// A chain of loads: a figure a size.
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
    /// Where it is measured; where on teams, on the largest of them.
    pub fn threads(&self) -> &[HardwareThread] {
        match self {
            Self::Arithmetic { team, .. }
            | Self::Streams { team, .. }
            | Self::Nodes { team, .. } => team,
            Self::Operators { thread, .. }
            | Self::Points { thread, .. }
            | Self::Mountain { thread, .. }
            | Self::Latency { thread, .. } => std::slice::from_ref(thread),
            Self::Solver { teams, .. } => teams.last().map_or(&[], Vec::as_slice),
        }
    }

    /// The part that it belongs to.
    pub fn part(&self) -> Part {
        match self {
            Self::Arithmetic { .. } => Part::Arithmetic,
            Self::Streams { .. } | Self::Nodes { .. } => Part::Bandwidth,
            Self::Operators { .. } | Self::Points { .. } => Part::Operators,
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
            Self::Operators { .. } => "rotating operators",
            Self::Points { .. } => "rotating points",
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
