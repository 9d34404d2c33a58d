//! What should be measured on a machine? The decision depends only on the topology and on limits, and is
//! tested on synthetic machines.

mod item;
mod places;

pub use item::{Campaign, Item, Placement, Sharing, Solver, StreamKernel, Walk};

use super::buffer::{LINE, PAGE};
use super::settings::{Extent, Part};
use super::team::HardwareThread;
use super::vectors::Set;
use crate::topology::Topology;
use places::{caches_spanned, order, pairs, same_places, teams};
use strum::VariantArray;

/// Limits of resources.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Memory \[bytes\].
    pub memory: u64,
    /// Processor time that the system grants this process, in processors.
    pub processors: usize,
    /// Whether the system grants huge pages on request.
    pub huge_pages: bool,
}

/// The measurements in the order of execution, and those that are impossible.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The items.
    pub items: Vec<Item>,
    /// Measurements that are impossible here.
    pub missing: Vec<Missing>,
}

impl Plan {
    /// The requested parts of the plan; all if none is named.
    pub fn only(self, parts: &[Part]) -> (Vec<Item>, Vec<String>) {
        let is_requested = |part: &Part| parts.is_empty() || parts.contains(part);
        let items = self
            .items
            .into_iter()
            .filter(|item| is_requested(&item.part()));
        let missing = self
            .missing
            .into_iter()
            .filter(|missing| missing.of.iter().any(is_requested));
        (
            items.collect(),
            missing.map(|missing| missing.said).collect(),
        )
    }
}

/// An impossible measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Missing {
    /// The affected parts.
    pub of: &'static [Part],
    /// The reason, in a sentence.
    pub said: String,
}

/// Size of the last-level cache if the system reports none \[bytes\].
const USUAL_CACHE: u64 = 32 << 20;

/// Ratio of the size of an array to that of the last-level caches through which it passes, as STREAM's rules
/// require.
const OUTGROWN: u64 = 4;

/// Number of operating points per thread, except in the measurements that vary this number.
pub const POINTS: usize = 8;

/// Number of modes at which the number of operating points is varied.
const BREADTH_MODES: usize = 40;

/// Approximate memory of an operating point per thread at [`BREADTH_MODES`] modes \[bytes\]. It only limits
/// the number of points.
const POINT_BYTES: u64 = 610 << 10;

/// Number of maps of the kernel `closed_modes` for the default drive, each with 4 N² numbers.
const MAPS: u64 = 44;

/// Parameters of an extent.
struct Scale {
    /// Largest buffer of a single thread \[bytes\].
    largest: u64,
    /// Number of sizes per factor of two.
    steps: u32,
    strides: &'static [usize],
    modes: &'static [usize],
    /// Numbers of operating points per thread, besides [`POINTS`].
    points: &'static [usize],
    /// Largest array of a stream over all threads \[bytes\].
    array: u64,
}

impl Scale {
    fn of(extent: Extent) -> Self {
        match extent {
            Extent::Quick => Self {
                largest: 512 << 20,
                steps: 1,
                strides: &[1, 4, 16, 64],
                modes: &[10, 20, 40],
                points: &[1, 64],
                array: 512 << 20,
            },
            Extent::Default => Self {
                largest: 1 << 30,
                steps: 2,
                strides: &[1, 2, 4, 8, 16, 32, 64],
                modes: &[10, 20, 40, 80],
                points: &[1, 64, 512],
                array: 4 << 30,
            },
            Extent::Full => Self {
                largest: 4 << 30,
                steps: 3,
                strides: &[1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128],
                modes: &[5, 10, 20, 40, 80, 160],
                points: &[1, 2, 4, 16, 64, 512, 4096],
                array: 64 << 30,
            },
        }
    }
}

/// Plans the measurements of a machine.
pub fn plan(topology: &Topology, extent: Extent, limits: Limits) -> Plan {
    let mut planner = Planner {
        topology,
        scale: Scale::of(extent),
        limits,
        items: Vec::new(),
        missing: Vec::new(),
    };
    planner.all();
    Plan {
        items: planner.items,
        missing: planner.missing,
    }
}

/// A plan under construction.
struct Planner<'a> {
    topology: &'a Topology,
    scale: Scale,
    limits: Limits,
    items: Vec<Item>,
    missing: Vec<Missing>,
}

/// Sizes from `smallest`, a power of two, to `largest` \[bytes\], with `steps` sizes per factor of two, in
/// whole lines.
fn sizes(smallest: u64, largest: u64, steps: u32) -> impl Iterator<Item = u64> {
    let size = move |i: u32| {
        let grown = smallest as f64 * (f64::from(i) / f64::from(steps)).exp2();
        (grown as u64).next_multiple_of(LINE as u64)
    };
    (0..).map(size).take_while(move |size| *size <= largest)
}

impl Planner<'_> {
    fn miss(&mut self, of: &'static [Part], said: impl Into<String>) {
        let said = said.into();
        self.missing.push(Missing { of, said });
    }

    fn all(&mut self) {
        let (topology, limits) = (self.topology, self.limits);
        let compact = teams(topology, Placement::Compact, limits.processors);
        let Some(first) = compact.first().and_then(|team| team.first()).copied() else {
            let none = "this process may not use any core, so nothing was measured";
            return self.miss(Part::VARIANTS, none);
        };
        if limits.processors < topology.threads() {
            let said = format!(
                "more than {} of {} threads: the system limits the processor time of this process",
                limits.processors,
                topology.threads()
            );
            self.miss(&[Part::Arithmetic, Part::Bandwidth, Part::Solver], said);
        }
        self.arithmetic(&compact);
        self.streams(&compact);
        self.nodes();
        let llc = topology.caches.last().map_or(USUAL_CACHE, |c| c.size);
        let wanted = (OUTGROWN * llc).max(64 << 20);
        let largest = wanted.min(self.scale.largest).min(limits.memory);
        if largest < 2 * llc {
            let said = format!(
                "one thread's working sets beyond the last-level cache of {} MiB: buffers end at \
                 {} MiB (--memory, --full)",
                llc >> 20,
                largest >> 20
            );
            self.miss(&[Part::Mountain, Part::Latency], said);
        }
        for size in sizes(8 << 10, largest, self.scale.steps) {
            let lines = size as usize / LINE;
            // A sweep over few lines would mainly measure the overhead of the loop.
            let strides = self.scale.strides.iter().copied();
            self.items.push(Item::MemoryMountain {
                thread: first,
                lines,
                strides: strides.filter(|s| 32 * s <= lines || *s == 1).collect(),
            });
        }
        self.latencies(first, largest);
        // The solvers are last: they take longest, and must not take time from the other measurements.
        self.solvers(&compact);
    }

    fn arithmetic(&mut self, teams: &[Vec<HardwareThread>]) {
        for set in Set::available() {
            let mut ends = vec![teams[0].clone(), teams[teams.len() - 1].clone()];
            ends.dedup();
            let items = ends.into_iter().map(|team| Item::Arithmetic { set, team });
            self.items.extend(items);
        }
    }

    /// Number of lines in each of the `arrays` arrays of a member, and whether the arrays of the team are as large as
    /// STREAM's rules require.
    fn array_lines(&self, team: &[HardwareThread], arrays: u64) -> (usize, bool) {
        let caches = match self.topology.caches.last() {
            Some(cache) => cache.size * caches_spanned(self.topology, team, cache) as u64,
            None => USUAL_CACHE,
        };
        let wanted = (OUTGROWN * caches).max(16 << 20);
        let granted = wanted
            .min(self.scale.array)
            .min(self.limits.memory / arrays);
        let lines = granted as usize / LINE / team.len();
        (lines.max(64), granted >= wanted)
    }

    fn streams(&mut self, compact: &[Vec<HardwareThread>]) {
        let mut outgrown = true;
        let scattered = teams(self.topology, Placement::Scattered, self.limits.processors);
        for (placement, teams) in [
            (Placement::Compact, compact),
            (Placement::Scattered, &scattered),
        ] {
            for team in teams {
                // Skip a team whose threads are also a compact team.
                if placement == Placement::Scattered && same_places(team, compact) {
                    continue;
                }
                let (lines, enough) = self.array_lines(team, 3);
                outgrown &= enough;
                self.items.push(Item::Streams {
                    placement,
                    team: team.clone(),
                    lines,
                });
            }
        }
        if !outgrown {
            let said = "streams through arrays of four times the last-level caches: memory or time is too short \
                        (--memory, --full), so part of these arrays stays in the cache";
            self.miss(&[Part::Bandwidth], said);
        }
    }

    /// Adds the measurements between nodes: the cores of each node read the memory of each node.
    fn nodes(&mut self) {
        let topology = self.topology;
        if topology.numa_nodes.len() < 2 {
            return;
        }
        for (node, memory) in pairs(topology) {
            let mut team = order(topology, Placement::Compact);
            let cores = (topology.cores.iter()).filter(|core| core.numa_node == node);
            let cores = cores.count();
            team.retain(|thread| thread.node == node);
            team.truncate(cores.min(self.limits.processors));
            let (lines, _) = self.array_lines(&team, 1);
            self.items.push(Item::Nodes {
                team,
                memory,
                lines,
            });
        }
        for node in topology
            .numa_nodes
            .iter()
            .filter(|node| node.threads.is_empty())
        {
            let index = node.index;
            let said =
                format!("node {index} from its own cores: this process may use none of them");
            self.miss(&[Part::Bandwidth, Part::Latency], said);
        }
    }

    fn solver(&mut self, campaign: Campaign, teams: &[Vec<HardwareThread>], most: u64) {
        let copies = match campaign.sharing {
            Sharing::Shared => 1,
            Sharing::Node => self.topology.numa_nodes.len() as u64,
            Sharing::Private => most,
        };
        let table_bytes = match campaign.solver {
            Solver::Volterra => 0,
            Solver::ClosedModes => copies * MAPS * 32 * (campaign.modes as u64).pow(2),
        };
        // The usual number of points is always measured.
        let point_bytes = campaign.points.saturating_sub(POINTS) as u64 * most * POINT_BYTES;
        if table_bytes + point_bytes > self.limits.memory {
            let said = format!(
                "{} with {} modes, {} operating points per thread, tables {}: {} MiB (--memory)",
                campaign.solver.name(),
                campaign.modes,
                campaign.points,
                campaign.sharing.name(),
                (table_bytes + point_bytes) >> 20
            );
            return self.miss(&[Part::Solver], said);
        }
        let teams = teams.to_vec();
        self.items.push(Item::Solver { campaign, teams });
    }

    fn solvers(&mut self, teams: &[Vec<HardwareThread>]) {
        let several = self.topology.numa_nodes.len() > 1;
        let most = teams.last().map_or(1, Vec::len) as u64;
        for &modes in self.scale.modes {
            for &solver in Solver::VARIANTS {
                let sharings: &[Sharing] = match solver {
                    Solver::Volterra => &[Sharing::Private],
                    Solver::ClosedModes if several => {
                        &[Sharing::Shared, Sharing::Node, Sharing::Private]
                    }
                    Solver::ClosedModes if most > 1 => &[Sharing::Shared, Sharing::Private],
                    Solver::ClosedModes => &[Sharing::Shared],
                };
                for &sharing in sharings {
                    let campaign = Campaign {
                        solver,
                        sharing,
                        modes,
                        points: POINTS,
                    };
                    self.solver(campaign, teams, most);
                }
            }
        }
        let ends = teams.first().into_iter().chain(teams.last());
        let mut ends: Vec<_> = ends.cloned().collect();
        ends.dedup();
        for &points in self.scale.points {
            for &solver in Solver::VARIANTS {
                let campaign = Campaign {
                    solver,
                    sharing: solver.usual_sharing(),
                    modes: BREADTH_MODES,
                    points,
                };
                self.solver(campaign, &ends, most);
            }
        }
        if !several {
            let none = "a table per node: there is only one node";
            self.miss(&[Part::Solver], none);
        }
    }

    fn latencies(&mut self, first: HardwareThread, largest: u64) {
        let whole = |size: u64| (size as usize / LINE).next_multiple_of(PAGE);
        let sizes = sizes(8 << 10, largest, self.scale.steps);
        let mut all: Vec<usize> = sizes.map(whole).collect();
        all.dedup();
        let last = all[all.len().saturating_sub(1)..].to_vec();
        let mut item = |thread: HardwareThread, memory, sizes: &[usize], walk| {
            self.items.push(Item::Latency {
                thread,
                memory,
                sizes: sizes.to_vec(),
                walk,
            });
        };
        item(first, first.node, &all, Walk::Pages);
        item(first, first.node, &all, Walk::Hops);
        if self.limits.huge_pages {
            item(first, first.node, &last, Walk::HopsHuge);
        }
        for (node, memory) in pairs(self.topology) {
            let mut threads = order(self.topology, Placement::Compact).into_iter();
            if let Some(thread) = threads.find(|thread| thread.node == node)
                && (node, memory) != (first.node, first.node)
            {
                item(thread, memory, &last, Walk::Hops);
            }
        }
        if !self.limits.huge_pages {
            let none = "loads on huge pages: the system provides none (transparent_hugepage)";
            self.miss(&[Part::Latency], none);
        }
    }
}

#[cfg(test)]
#[cfg(feature = "hwloc")]
mod tests;
