//! Solver scaling: teams that integrate the default drive with one table for all, a table a node, or
//! the tables of eight operating points.
//!
//! Every member advances the same trajectories over the same cycles in every repetition, so that all
//! have the same work and must end in the same bits.

use super::drive::{self, DefaultDrive, EVENT_LIMIT};
use super::plan::{Mesh, Seat, Sharing, Solver};
use super::tables::{BuiltTables, LocalTables};
use super::team::{self, Pace};
use super::trouble::Trouble;
use crate::model::{Model, OperatingPoint, TrajectoryState};
use crate::propagate::{Counters, Fused, Kernel, Spectral, Stop, Tangents, Volterra};
use crate::topology::Topology;

/// Unit steps of the dense tables, as published.
const CELLS: u32 = 60;

/// Mesh cycles of a repetition at every operating point: cycles differ in their events, so that a
/// repetition must hold several, and always the same ones; a short one is less often disturbed.
const STAY: usize = 16;

/// How often all teams are gone through: a table that lies in a shared cache is read a fifth
/// faster once it has been read some fifty times, and else the first team, the single thread,
/// would pay for the others.
const PASSES: usize = 2;

/// Where the drive runs: near resonance, light load first.
const SPEED: f64 = 1200.0;
const LOADS: [f64; 8] = [0.05, 0.08, 0.12, 0.15, 0.19, 0.22, 0.26, 0.30];

/// Work of a mesh cycle, counted.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// Numbers of tables read, each for one multiply-add.
    pub numbers: f64,
    /// Bytes of different numbers among them.
    pub distinct: f64,
}

/// What integrating gave.
#[derive(Debug)]
pub struct Integrated {
    /// Time of a cycle on every team: of a repetition, over the cycles of all members \[s\].
    pub times: Vec<Vec<f64>>,
    /// Bytes of the tables of one operating point.
    pub bytes: usize,
    /// Work of a cycle.
    pub work: Work,
    /// Why members could not be bound, where they could not.
    pub unbound: Option<String>,
}

/// A kernel that can say what it reads.
trait Tabled: Kernel {
    /// Bytes of its tables.
    fn table_bytes(&self) -> usize;
    /// Work of a cycle.
    fn work(&self, counted: &Counters) -> Work;
}

impl Tabled for Volterra<'_> {
    fn table_bytes(&self) -> usize {
        self.bytes()
    }

    fn work(&self, counted: &Counters) -> Work {
        let windows = counted.windows as f64 / counted.cycles as f64;
        let numbers = windows * self.numbers_per_window() as f64;
        Work {
            numbers,
            distinct: (self.bytes() as f64).min(8.0 * numbers),
        }
    }
}

/// Work of a kernel with dense operators, all of the same size but few.
fn of_operators(size: crate::propagate::TableSize, counted: &Counters) -> Work {
    let products = counted.matvecs as f64 / counted.cycles as f64;
    let operator = size.bytes as f64 / size.operators.max(1) as f64;
    Work {
        numbers: products * operator / 8.0,
        distinct: (size.bytes as f64).min(products * operator),
    }
}

impl Tabled for Spectral<'_> {
    fn table_bytes(&self) -> usize {
        self.bytes().bytes
    }

    fn work(&self, counted: &Counters) -> Work {
        of_operators(self.bytes(), counted)
    }
}

impl Tabled for Fused<'_> {
    fn table_bytes(&self) -> usize {
        self.bytes().bytes
    }

    fn work(&self, counted: &Counters) -> Work {
        of_operators(self.bytes(), counted)
    }
}

/// Advances on every team.
pub fn measure(
    topology: &Topology,
    default: &DefaultDrive,
    built_tables: &mut BuiltTables,
    solver: Solver,
    sharing: Sharing,
    modes: usize,
    teams: &[Vec<Seat>],
    pace: Pace,
) -> Result<Integrated, Trouble> {
    let structure = default.structure(modes)?;
    let loads = match sharing {
        Sharing::Eight => &LOADS[..],
        Sharing::Shared | Sharing::Node => &LOADS[..1],
    };
    let model = |&load: &f64| {
        let speed = SPEED;
        default.model(
            &structure,
            Mesh::SixtyLevels,
            OperatingPoint { load, speed },
        )
    };
    let models = loads.iter().map(model).collect::<Result<Vec<_>, _>>()?;
    let nodes = nodes(sharing, teams);
    let casts = |mould| {
        on_each(topology, &nodes, |_| {
            models.iter().map(|_| LocalTables::new(mould)).collect()
        })
    };
    match solver {
        Solver::Volterra => {
            let build = |_| Ok(models.iter().map(drive::volterra).collect());
            let shelves = on_each(topology, &nodes, build)?;
            advance(topology, &models, &nodes, &shelves, teams, pace)
        }
        Solver::Spectral => {
            let built = || Ok(Spectral::new(&models[0], CELLS, EVENT_LIMIT, None)?.arrays());
            let casts: Vec<Vec<LocalTables>> = casts(built_tables.of(solver, modes, built)?)?;
            let shelves = on_each(topology, &nodes, |node| {
                let pairs = models.iter().zip(&casts[node]);
                pairs
                    .map(|(model, cast)| {
                        Ok(Spectral::of_kept(model, CELLS, EVENT_LIMIT, None, cast)?)
                    })
                    .collect()
            })?;
            advance(topology, &models, &nodes, &shelves, teams, pace)
        }
        Solver::Fused => {
            let built = || Ok(Fused::new(&models[0], CELLS, EVENT_LIMIT)?.arrays());
            let casts: Vec<Vec<LocalTables>> = casts(built_tables.of(solver, modes, built)?)?;
            let shelves = on_each(topology, &nodes, |node| {
                let pairs = models.iter().zip(&casts[node]);
                pairs
                    .map(|(model, cast)| Ok(Fused::of_kept(model, CELLS, EVENT_LIMIT, cast)?))
                    .collect()
            })?;
            advance(topology, &models, &nodes, &shelves, teams, pace)
        }
    }
}

/// Nodes that get tables of their own.
fn nodes(sharing: Sharing, teams: &[Vec<Seat>]) -> Vec<u32> {
    let mut nodes: Vec<u32> = teams.iter().flatten().map(|seat| seat.node).collect();
    if sharing != Sharing::Node {
        nodes.truncate(1);
    }
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Makes what a node needs, for each of them on a thread of its own that is bound there.
fn on_each<T: Send>(
    topology: &Topology,
    nodes: &[u32],
    make: impl Fn(usize) -> Result<Vec<T>, Trouble> + Sync,
) -> Result<Vec<Vec<T>>, Trouble> {
    let shelf = |(index, &node): (usize, &u32)| {
        let cores = topology.cores.iter().filter(|core| core.numa_node == node);
        let threads: Vec<u32> = cores.flat_map(|core| core.threads.clone()).collect();
        std::thread::scope(|scope| {
            let maker = scope.spawn(|| {
                // Where it cannot be bound, memory lies where the system puts it.
                _ = topology.bind_current_thread(&threads);
                make(index)
            });
            (maker.join()).unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    };
    nodes.iter().enumerate().map(shelf).collect()
}

/// Advances on every team; a shelf holds the kernels of a node, one an operating point.
fn advance<K: Tabled + Sync>(
    topology: &Topology,
    models: &[Model],
    nodes: &[u32],
    shelves: &[Vec<K>],
    teams: &[Vec<Seat>],
    pace: Pace,
) -> Result<Integrated, Trouble> {
    let starts = (models.iter().map(drive::settled)).collect::<Result<Vec<_>, _>>()?;
    let counted = counted(&shelves[0], &starts)?;
    let mut integrated = Integrated {
        times: vec![Vec::new(); teams.len()],
        bytes: shelves[0][0].table_bytes(),
        work: shelves[0][0].work(&counted),
        unbound: None,
    };
    for index in (0..PASSES).flat_map(|_| 0..teams.len()) {
        let team = &teams[index];
        let worked = team::work(
            topology,
            team,
            1,
            pace,
            |member| {
                let own = nodes.iter().position(|&node| node == team[member].node);
                Ok(Integrator::new(&shelves[own.unwrap_or(0)], &starts, member))
            },
            |integrator: &mut Integrator<'_, K>, _| integrator.repeat(),
            |integrator: &mut Integrator<'_, K>, _| integrator.repeat(),
            Integrator::end,
        )?;
        let mut ends = Vec::new();
        for end in worked.results {
            ends.push(end?);
        }
        if ends.windows(2).any(|pair| pair[0] != pair[1]) {
            return Err(Trouble::Wrong {
                what: "integrating on several threads",
            });
        }
        let cycles = (team.len() * STAY * models.len()) as f64;
        let times = worked.times.into_iter().flatten();
        integrated.times[index].extend(times.map(|time| time / cycles));
        integrated.unbound = integrated.unbound.or(worked.unbound);
    }
    Ok(integrated)
}

/// The work of a repetition.
fn counted<K: Tabled>(kernels: &[K], starts: &[TrajectoryState]) -> Result<Counters, Trouble> {
    let mut integrator = Integrator::new(kernels, starts, 0);
    integrator.repeat();
    let counters = integrator.counters;
    integrator.end()?;
    Ok(counters)
}

/// A member's trajectories.
struct Integrator<'k, K: Kernel> {
    kernels: &'k [K],
    starts: &'k [TrajectoryState],
    trajectories: Vec<TrajectoryState>,
    /// One an operating point: kernels keep in them what they have prepared.
    workspaces: Vec<K::Workspace>,
    counters: Counters,
    /// The operating point where it begins: members begin at different ones.
    first: usize,
    stopped: Option<Stop>,
}

impl<'k, K: Kernel> Integrator<'k, K> {
    fn new(kernels: &'k [K], starts: &'k [TrajectoryState], index: usize) -> Self {
        Self {
            kernels,
            starts,
            trajectories: starts.to_vec(),
            workspaces: kernels.iter().map(K::workspace).collect(),
            counters: Counters::default(),
            first: index % kernels.len(),
            stopped: None,
        }
    }

    /// Advances [`STAY`] cycles at every point, from its start.
    fn repeat(&mut self) {
        let points = self.kernels.len();
        for point in (self.first..points).chain(0..self.first) {
            self.trajectories[point].clone_from(&self.starts[point]);
            for _ in 0..STAY {
                let ended = self.kernels[point].advance_cycle(
                    &mut self.trajectories[point],
                    &mut Tangents::none(),
                    &mut self.workspaces[point],
                    &mut (),
                    &mut self.counters,
                );
                self.stopped = self.stopped.or(ended.err());
            }
        }
    }

    /// Where it ended, bit by bit.
    fn end(self) -> Result<Vec<u64>, Stop> {
        match self.stopped {
            Some(stop) => Err(stop),
            None => Ok(self
                .trajectories
                .iter()
                .flat_map(|t| t.state.iter().map(|x| x.to_bits()).chain([t.cycle]))
                .collect()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;
    use strum::VariantArray;

    const PACE: Pace = Pace {
        slice: Duration::ZERO,
        least: 2,
        most: 2,
    };

    /// All kernels on two members that share a core: equal ends, times, and work that says what
    /// the tables are.
    #[test]
    fn kernels_advance_on_teams_and_count_their_work() {
        let topology = Topology::current().unwrap();
        let default = DefaultDrive::new().unwrap();
        let thread = topology.cores[0].threads[0];
        let seat = Seat { thread, node: 0 };
        let teams = [vec![seat], vec![seat; 2]];
        let mut built_tables = BuiltTables::default();
        for sharing in [Sharing::Shared, Sharing::Eight] {
            let mut measured = |solver| {
                measure(
                    &topology,
                    &default,
                    &mut built_tables,
                    solver,
                    sharing,
                    4,
                    &teams,
                    PACE,
                )
                .unwrap()
            };
            for &solver in Solver::VARIANTS {
                let integrated = measured(solver);
                assert_eq!(integrated.times.len(), 2);
                assert!(integrated.times.iter().flatten().all(|time| *time > 0.0));
                assert!(integrated.work.numbers > 0.0);
                assert!(integrated.work.distinct <= integrated.bytes as f64);
            }
            // A dense table is read once a cycle, a structured one more often.
            let dense = measured(Solver::Spectral).work;
            assert!(dense.distinct > 0.5 * 8.0 * dense.numbers);
            let structured = measured(Solver::Volterra).work;
            assert!(structured.distinct < 0.9 * 8.0 * structured.numbers);
        }
    }

    #[test]
    fn tables_a_node_only_where_asked_for() {
        let seat = |thread, node| Seat { thread, node };
        let teams = [vec![seat(0, 1)], vec![seat(0, 1), seat(1, 0)]];
        assert_eq!(nodes(Sharing::Node, &teams), [0, 1]);
        assert_eq!(nodes(Sharing::Shared, &teams), [1]);
        assert_eq!(nodes(Sharing::Eight, &teams), [1]);
    }
}
