//! Solver scaling: teams that integrate the default drive with one table for all, a table a node, or
//! the tables of eight operating points.
//!
//! Every member advances the same trajectories over the same cycles in every repetition, so that all
//! have the same work and must end in the same bits.

use super::drive::{self, DefaultDrive, EVENT_LIMIT};
use super::error::MeasurementError;
use super::figure::median;
use super::measured::{Measured, Work};
use super::plan::{Mesh, Sharing, Solver};
use super::tables::{BuiltTables, LocalTables};
use super::team::{self, HardwareThread, Pace};
use crate::model::{Model, OperatingPoint, TrajectoryState};
use crate::propagate::{Counters, KeptTables, Kernel, Stop, Volterra};
use crate::topology::Topology;
use gearatlas_paper::kernels::{Fused, Spectral, TableSize};

/// Unit steps of the dense tables, as published.
const CELLS: u32 = 60;

/// Mesh cycles of a repetition at every operating point: cycles differ in their events, so that a
/// repetition must hold several, and always the same ones; a short one is less often disturbed.
const STAY: u64 = 16;

/// How often all teams are gone through, the single thread, which is the first team, before each
/// of the others: a machine that changes its speed meanwhile then changes both, and not their
/// ratio. A table that lies in a shared cache is read a fifth faster once it has been read some
/// fifty times, and else the first team would pay for the others.
const PASSES: usize = 3;

/// Where the drive runs: near resonance, light load first.
const SPEED: f64 = 1200.0;
const LOADS: [f64; 8] = [0.05, 0.08, 0.12, 0.15, 0.19, 0.22, 0.26, 0.30];

/// A kernel that can say what it reads.
trait TableKernel: Kernel {
    /// Bytes of its tables.
    fn table_bytes(&self) -> usize;
    /// Work of a cycle.
    fn work(&self, counted: &Counters) -> Work;
}

impl TableKernel for Volterra<'_> {
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
fn of_operators(size: TableSize, counted: &Counters) -> Work {
    let products = counted.matvecs as f64 / counted.cycles as f64;
    let operator = size.bytes as f64 / size.operators.max(1) as f64;
    Work {
        numbers: products * operator / 8.0,
        distinct: (size.bytes as f64).min(products * operator),
    }
}

impl TableKernel for Spectral<'_> {
    fn table_bytes(&self) -> usize {
        self.bytes().bytes
    }

    fn work(&self, counted: &Counters) -> Work {
        of_operators(self.bytes(), counted)
    }
}

impl TableKernel for Fused<'_> {
    fn table_bytes(&self) -> usize {
        self.bytes().bytes
    }

    fn work(&self, counted: &Counters) -> Work {
        of_operators(self.bytes(), counted)
    }
}

/// Integrates on every team.
pub fn measure(
    topology: &Topology,
    default: &DefaultDrive,
    built_tables: &mut BuiltTables,
    solver: Solver,
    sharing: Sharing,
    modes: usize,
    teams: &[Vec<HardwareThread>],
    pace: Pace,
) -> Result<Measured, MeasurementError> {
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
    let copies = |built| {
        on_each(topology, &nodes, |_| {
            models.iter().map(|_| LocalTables::new(built)).collect()
        })
    };
    match solver {
        Solver::Volterra => {
            let build = |_| Ok(models.iter().map(drive::volterra).collect());
            let kernels = on_each(topology, &nodes, build)?;
            advance(topology, &models, &nodes, &kernels, teams, pace)
        }
        Solver::Spectral => {
            let built = || Spectral::arrays(&models[0]);
            let copies: Vec<Vec<LocalTables>> = copies(built_tables.of(solver, modes, built)?)?;
            let kernels = on_each(topology, &nodes, |node| {
                let pairs = models.iter().zip(&copies[node]);
                pairs
                    .map(|(model, copy)| {
                        Ok(Spectral::of_kept(model, CELLS, EVENT_LIMIT, None, copy)?)
                    })
                    .collect()
            })?;
            advance(topology, &models, &nodes, &kernels, teams, pace)
        }
        Solver::Fused => {
            let built = || {
                let mut arrays = Spectral::arrays(&models[0])?;
                arrays.extend(Fused::arrays(&models[0], CELLS)?);
                Ok(arrays)
            };
            let copies: Vec<Vec<LocalTables>> = copies(built_tables.of(solver, modes, built)?)?;
            let kernels = on_each(topology, &nodes, |node| {
                let pairs = models.iter().zip(&copies[node]);
                pairs
                    .map(|(model, copy)| {
                        let kept: [&dyn KeptTables; 2] = [copy, copy];
                        Ok(Fused::of_kept(model, CELLS, EVENT_LIMIT, kept)?)
                    })
                    .collect()
            })?;
            advance(topology, &models, &nodes, &kernels, teams, pace)
        }
    }
}

/// Nodes that get tables of their own.
fn nodes(sharing: Sharing, teams: &[Vec<HardwareThread>]) -> Vec<u32> {
    let mut nodes: Vec<u32> = teams.iter().flatten().map(|thread| thread.node).collect();
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
    make: impl Fn(usize) -> Result<Vec<T>, MeasurementError> + Sync,
) -> Result<Vec<Vec<T>>, MeasurementError> {
    let of_node = |(index, &node): (usize, &u32)| {
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
    nodes.iter().enumerate().map(of_node).collect()
}

/// Integrates on every team with the kernels of each node, one an operating point.
fn advance<K: TableKernel + Sync>(
    topology: &Topology,
    models: &[Model],
    nodes: &[u32],
    kernels: &[Vec<K>],
    teams: &[Vec<HardwareThread>],
    pace: Pace,
) -> Result<Measured, MeasurementError> {
    let starts = (models.iter().map(drive::settled)).collect::<Result<Vec<_>, _>>()?;
    let counted = counted(&kernels[0], &starts)?;
    let mut measured = Measured {
        // Rates of the teams, then gains of all but the first.
        times: vec![Vec::new(); (2 * teams.len()).saturating_sub(1)],
        bytes: kernels[0][0].table_bytes(),
        work: kernels[0][0].work(&counted),
        unbound: None,
    };
    let mut alone = f64::NAN;
    for index in (0..PASSES).flat_map(|_| in_turn(teams.len())) {
        let team = &teams[index];
        let worked = team::work(
            topology,
            team,
            1,
            pace,
            |member| {
                let own = nodes.iter().position(|&node| node == team[member].node);
                Ok(Trajectories::new(
                    &kernels[own.unwrap_or(0)],
                    &starts,
                    member,
                ))
            },
            |trajectories: &mut Trajectories<'_, K>, _| trajectories.repeat(),
            |trajectories: &mut Trajectories<'_, K>, _| trajectories.repeat(),
            Trajectories::end,
        )?;
        let mut ends = Vec::new();
        for end in worked.results {
            ends.push(end?);
        }
        if ends.windows(2).any(|pair| pair[0] != pair[1]) {
            return Err(MeasurementError::Wrong {
                what: "integrating on several threads",
            });
        }
        let cycles = STAY as f64 * (team.len() * models.len()) as f64;
        let times = worked.times.into_iter().flatten();
        let mut times: Vec<f64> = times.map(|time| time / cycles).collect();
        measured.times[index].extend(&times);
        let middle = median(&mut times);
        match index {
            0 => alone = middle,
            _ => measured.times[teams.len() + index - 1].push(alone / middle),
        }
        measured.unbound = measured.unbound.or(worked.unbound);
    }
    Ok(measured)
}

/// The first of so many before each of the others; alone where there is no other.
fn in_turn(count: usize) -> Vec<usize> {
    match count {
        0 | 1 => (0..count).collect(),
        _ => (1..count).flat_map(|index| [0, index]).collect(),
    }
}

/// The work of a repetition.
fn counted<K: TableKernel>(
    kernels: &[K],
    starts: &[TrajectoryState],
) -> Result<Counters, MeasurementError> {
    let mut trajectories = Trajectories::new(kernels, starts, 0);
    trajectories.repeat();
    let counters = trajectories.counters;
    trajectories.end()?;
    Ok(counters)
}

/// A member's trajectories.
struct Trajectories<'k, K: Kernel> {
    kernels: &'k [K],
    starts: &'k [TrajectoryState],
    states: Vec<TrajectoryState>,
    /// One an operating point: kernels keep in them what they have prepared.
    workspaces: Vec<K::Workspace>,
    counters: Counters,
    /// The operating point where it begins: members begin at different ones.
    first: usize,
    stopped: Option<Stop>,
}

impl<'k, K: Kernel> Trajectories<'k, K> {
    fn new(kernels: &'k [K], starts: &'k [TrajectoryState], index: usize) -> Self {
        Self {
            kernels,
            starts,
            states: starts.to_vec(),
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
            self.states[point].clone_from(&self.starts[point]);
            let ended = self.kernels[point].advance(
                STAY,
                &mut self.states[point],
                &mut self.workspaces[point],
                &mut (),
                &mut self.counters,
            );
            self.stopped = self.stopped.or(ended.err());
        }
    }

    /// Where it ended, bit by bit.
    fn end(self) -> Result<Vec<u64>, Stop> {
        match self.stopped {
            Some(stop) => Err(stop),
            None => Ok(self
                .states
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
        let index = topology.cores[0].threads[0];
        let thread = HardwareThread { index, node: 0 };
        let teams = [vec![thread], vec![thread; 2]];
        let mut built_tables = BuiltTables::default();
        for sharing in [Sharing::Shared, Sharing::Eight] {
            let mut on_teams = |solver| {
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
                let measured = on_teams(solver);
                // Two rates, and what the second team gains.
                assert_eq!(measured.times.len(), 3);
                assert_eq!(measured.times[2].len(), PASSES);
                assert!(measured.times.iter().flatten().all(|time| *time > 0.0));
                assert!(measured.work.numbers > 0.0);
                assert!(measured.work.distinct <= measured.bytes as f64);
            }
            // A dense table is read once a cycle, a structured one more often.
            let dense = on_teams(Solver::Spectral).work;
            assert!(dense.distinct > 0.5 * 8.0 * dense.numbers);
            let structured = on_teams(Solver::Volterra).work;
            assert!(structured.distinct < 0.9 * 8.0 * structured.numbers);
        }
    }

    #[test]
    fn one_thread_is_measured_before_every_other_team() {
        assert_eq!(in_turn(3), [0, 1, 0, 2]);
        assert_eq!((in_turn(1), in_turn(0)), (vec![0], vec![]));
    }

    #[test]
    fn tables_a_node_only_where_asked_for() {
        let thread = |index, node| HardwareThread { index, node };
        let teams = [vec![thread(0, 1)], vec![thread(0, 1), thread(1, 0)]];
        assert_eq!(nodes(Sharing::Node, &teams), [0, 1]);
        assert_eq!(nodes(Sharing::Shared, &teams), [1]);
        assert_eq!(nodes(Sharing::Eight, &teams), [1]);
    }
}
