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

/// What two hardware threads share, the nearest thing first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Relation {
    /// A core.
    Core,
    /// The last-level cache.
    Cache,
    /// The processor package.
    Package,
    /// Nothing but the machine.
    Machine,
}

impl Relation {
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
    /// Reads and writes in other proportions: a figure a kernel of [`StreamKernel::mixes`].
    Mixes {
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
    /// Several chains of loads at once: a figure a number of chains of every size.
    Parallel {
        /// Where.
        thread: HardwareThread,
        /// Lines of the buffer.
        sizes: Vec<usize>,
        /// Their order.
        walk: Walk,
    },
    /// How the times of batches of loads are spread: a figure a percentile of every size, and one
    /// of the clock.
    Percentiles {
        /// Where.
        thread: HardwareThread,
        /// Lines of the buffer.
        sizes: Vec<usize>,
        /// Their order.
        walk: Walk,
    },
    /// A chain of loads beside readers: two figures a pause.
    Loaded {
        /// The thread of the chain, then those that read.
        team: Vec<HardwareThread>,
        /// Lines that the chain goes through.
        lines: usize,
        /// Lines of each reader's array.
        array: usize,
        /// Order of the chain.
        walk: Walk,
        /// Pauses of the readers in turns of an empty loop; none: they do not read.
        pauses: Vec<Option<u32>>,
    },
    /// Handing a line of memory back and forth: one figure.
    Transfer {
        /// Between these.
        pair: [HardwareThread; 2],
        /// What they share.
        relation: Relation,
    },
}

impl Item {
    /// Where it is measured; where on teams, on the largest of them.
    pub fn threads(&self) -> &[HardwareThread] {
        match self {
            Self::Arithmetic { team, .. }
            | Self::Streams { team, .. }
            | Self::Mixes { team, .. }
            | Self::Loaded { team, .. }
            | Self::Nodes { team, .. } => team,
            Self::Transfer { pair, .. } => pair,
            Self::Operators { thread, .. }
            | Self::Points { thread, .. }
            | Self::Mountain { thread, .. }
            | Self::Parallel { thread, .. }
            | Self::Percentiles { thread, .. }
            | Self::Latency { thread, .. } => std::slice::from_ref(thread),
            Self::Solver { teams, .. } => teams.last().map_or(&[], Vec::as_slice),
        }
    }

    /// The part that it belongs to.
    pub fn part(&self) -> Part {
        match self {
            Self::Arithmetic { .. } => Part::Arithmetic,
            Self::Streams { .. } | Self::Mixes { .. } | Self::Nodes { .. } => Part::Bandwidth,
            Self::Operators { .. } | Self::Points { .. } => Part::Operators,
            Self::Solver { .. } => Part::Solver,
            Self::Mountain { .. } => Part::Mountain,
            Self::Latency { .. } => Part::Latency,
            Self::Parallel { .. } | Self::Percentiles { .. } => Part::Chases,
            Self::Loaded { .. } => Part::Loaded,
            Self::Transfer { .. } => Part::Transfer,
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
            Self::Mixes { .. } => "mixes of reads and writes",
            Self::Parallel { .. } => "chains at once",
            Self::Percentiles { .. } => "percentiles of latency",
            Self::Loaded { .. } => "latency under load",
            Self::Transfer { .. } => "from core to core",
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
    /// Reads so many arrays (1 to 3) and writes one of them in its place: no line is fetched that
    /// is not counted.
    Update {
        /// Lines read for one that is written.
        reads: usize,
    },
    /// Writes an array past the caches, and reads nothing.
    Fill,
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

    /// Those of which each has another part of reads and writes, where nothing is fetched that
    /// is not counted; with those of [`Self::available`] that read only, or write past the caches,
    /// they make all mixes.
    pub fn mixes() -> Vec<Self> {
        let mut kernels: Vec<Self> = [3, 2, 1].map(|reads| Self::Update { reads }).to_vec();
        if NON_TEMPORAL {
            kernels.push(Self::Fill);
        }
        kernels
    }

    /// Its name in the record.
    pub fn name(self) -> &'static str {
        match self {
            Self::Update { reads: 1 } => "update_1_1",
            Self::Update { reads: 2 } => "update_2_1",
            Self::Update { .. } => "update_3_1",
            Self::Fill => "fill_nt",
            Self::Read => "read",
            Self::Copy(false) => "copy",
            Self::Copy(true) => "copy_nt",
            Self::Triad(false) => "triad",
            Self::Triad(true) => "triad_nt",
        }
    }

    /// Arrays that it reads or writes, one that it does both to counted twice.
    pub fn arrays(self) -> usize {
        match self {
            Self::Read => 1,
            Self::Copy(_) => 2,
            Self::Triad(_) => 3,
            Self::Update { reads } => reads + 1,
            Self::Fill => 1,
        }
    }
}
