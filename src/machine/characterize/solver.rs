//! Solver scaling: teams integrate the default drive near resonance, each thread at its operating points. There is one
//! copy of the tables for all threads, one per node or one per thread.
//!
//! Every member of a team advances the same trajectories over the same cycles in every repetition. All
//! members therefore have the same work, and their results must have the same bits.

use super::drive::{self, DefaultDrive, EVENT_LIMIT, Mesh};
use super::error::MeasurementError;
use super::figure::median;
use super::measured::{Measured, Work};
use super::plan::{Campaign, Sharing, Solver};
use super::team::{self, HardwareThread, RepetitionTime};
use crate::model::{OperatingPoint, TrajectoryState};
use crate::propagate::{ClosedModes, Counters, InstructionSet, Kernel, Stop, TableArray, Volterra};
use crate::topology::Topology;

/// Mesh cycles of a repetition at every operating point. Cycles differ in their events. A repetition must
/// therefore contain several cycles, and always the same ones. A short repetition is disturbed less often.
const CYCLES_PER_POINT: u64 = 16;

/// Number of passes over all teams. One thread is measured before each team. A change of the machine's speed
/// then affects both, but not their ratio. A table in a shared cache is read a fifth faster after about fifty
/// reads. In a single pass the first team would therefore be at a disadvantage.
const PASSES: usize = 3;

/// Speed \[rad/s\] and loads of the operating points: near resonance, the lightest load first. For more
/// points the loads repeat.
const SPEED: f64 = 1200.0;
const LOADS: [f64; 8] = [0.05, 0.08, 0.12, 0.15, 0.19, 0.22, 0.26, 0.30];

/// Integrates on every team.
pub fn measure(
    topology: &Topology,
    default: &DefaultDrive,
    campaign: &Campaign,
    teams: &[Vec<HardwareThread>],
    pace: RepetitionTime,
) -> Result<Measured, MeasurementError> {
    let structure = default.structure(campaign.modes)?;
    let mesh = match campaign.solver {
        Solver::Volterra => Mesh::SixtyLevels,
        Solver::ClosedModes => Mesh::TwoLevels,
    };
    let loads = LOADS.iter().take(campaign.points);
    let models = loads.map(|&load| {
        let speed = SPEED;
        default.model(&structure, mesh, OperatingPoint { load, speed })
    });
    let models = models.collect::<Result<Vec<_>, _>>()?;
    let starts = models.iter().map(drive::settled);
    let starts = starts.collect::<Result<Vec<_>, _>>()?;
    let points = || models.iter().cycle().take(campaign.points);
    let starts: Vec<_> = (starts.iter().cycle().take(campaign.points)).collect();
    match campaign.solver {
        Solver::Volterra => {
            let build = |_| Ok(points().map(drive::volterra).collect());
            let work = |kernel: &Volterra<'_>, counted: &Counters| {
                let windows = counted.windows as f64 / counted.cycles as f64;
                let numbers = windows * kernel.numbers_per_window() as f64;
                let distinct = (kernel.bytes() as f64).min(8.0 * numbers);
                (kernel.bytes(), Work { numbers, distinct })
            };
            advance(topology, &starts, teams, pace, build, work)
        }
        Solver::ClosedModes => {
            let built = ClosedModes::arrays(&models[0]).map_err(tables)?;
            let team = teams.last().map_or(&[][..], Vec::as_slice);
            let copy_of = copy_of(campaign.sharing, team);
            let copies = copies(topology, team, &copy_of, &built);
            let set = InstructionSet::best();
            let build = |member: usize| {
                let kept = &copies[copy_of[member]];
                points()
                    .map(|model| ClosedModes::from_kept(model, EVENT_LIMIT, kept, set))
                    .collect::<Result<_, _>>()
                    .map_err(tables)
            };
            let bytes = size_of::<f64>() * built.iter().map(|a| a.values.len()).sum::<usize>();
            let work = |_: &ClosedModes<'_>, counted: &Counters| {
                (bytes, work_of_closed_modes(campaign.modes, counted, bytes))
            };
            advance(topology, &starts, teams, pace, build, work)
        }
    }
}

/// Converts a kernel's error to one of the measurement.
fn tables(error: impl std::error::Error + Send + Sync + 'static) -> MeasurementError {
    MeasurementError::Tables(Box::new(error))
}

/// Work of `closed_modes` per cycle. In every block (window) it reads for each pair of coordinates four numbers that
/// advance the pair, and its part of the deflection at eight nodes. Each event takes a dense product, and the change
/// from modes to eigenvectors and back takes two per cycle. Changes of stiffness in a closed contact are not counted.
fn work_of_closed_modes(modes: usize, counted: &Counters, bytes: usize) -> Work {
    const NODES: usize = 8;
    /// Linear systems of the default drive: each of two contacts is open or has one of two stiffnesses. A block reads
    /// the numbers of one system.
    const SETS: f64 = 9.0;
    let block = (8 * (4 + 2 * NODES) * modes) as f64;
    let product = (8 * 4 * modes * modes.next_multiple_of(8)) as f64;
    let cycles = counted.cycles as f64;
    let blocks = counted.windows as f64 / cycles;
    let products = 2.0 + counted.events as f64 / cycles;
    Work {
        numbers: (blocks * block + products * product) / 8.0,
        distinct: blocks.min(SETS) * block + (products * product).min(bytes as f64),
    }
}

/// Index of the copy that each member of a team reads.
fn copy_of(sharing: Sharing, team: &[HardwareThread]) -> Vec<usize> {
    let mut nodes: Vec<u32> = Vec::new();
    let members = team.iter().enumerate();
    let copies = members.map(|(index, thread)| match sharing {
        Sharing::Shared => 0,
        Sharing::Private => index,
        Sharing::Node => match nodes.iter().position(|node| *node == thread.node) {
            Some(place) => place,
            None => {
                nodes.push(thread.node);
                nodes.len() - 1
            }
        },
    });
    copies.collect()
}

/// Copies of tables. A thread that is bound to the hardware thread of a copy's first reader makes the copy,
/// so that it is on the node of this reader.
fn copies(
    topology: &Topology,
    team: &[HardwareThread],
    copy_of: &[usize],
    built: &[TableArray],
) -> Vec<Vec<TableArray>> {
    let count = copy_of.iter().max().map_or(0, |last| last + 1);
    let first_reader = |copy| copy_of.iter().position(|known| *known == copy);
    let readers = (0..count)
        .filter_map(first_reader)
        .map(|member| team[member]);
    let copy = |reader: HardwareThread| {
        std::thread::scope(|scope| {
            let maker = scope.spawn(|| {
                // If the thread cannot be bound, the system chooses the node of the memory.
                _ = topology.bind_current_thread(&[reader.index]);
                built.to_vec()
            });
            (maker.join()).unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    };
    readers.map(copy).collect()
}

/// Integrates on every team. Each member builds its kernels, one per operating point.
fn advance<K: Kernel>(
    topology: &Topology,
    starts: &[&TrajectoryState],
    teams: &[Vec<HardwareThread>],
    pace: RepetitionTime,
    build: impl Fn(usize) -> Result<Vec<K>, MeasurementError> + Sync,
    work: impl Fn(&K, &Counters) -> (usize, Work),
) -> Result<Measured, MeasurementError> {
    let mut alone = Trajectories::new(build(0)?, starts, 0);
    alone.repeat();
    let (bytes, work) = work(&alone.kernels[0], &alone.counters);
    alone.end()?;
    let mut measured = Measured {
        times: vec![Vec::new(); teams.len()],
        gains: vec![Vec::new(); teams.len().saturating_sub(1)],
        bytes,
        work,
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
            |member| Ok(Trajectories::new(build(member)?, starts, member)),
            |trajectories: &mut Trajectories<'_, K>, _| trajectories.repeat(),
            |trajectories: &mut Trajectories<'_, K>, _| trajectories.repeat(),
            Trajectories::end,
        )?;
        let ends = worked.results.into_iter().collect::<Result<Vec<_>, _>>()?;
        if ends.windows(2).any(|pair| pair[0] != pair[1]) {
            return Err(MeasurementError::Wrong {
                what: "integrating on several threads",
            });
        }
        let cycles = CYCLES_PER_POINT as f64 * (team.len() * starts.len()) as f64;
        let times = worked.times.into_iter().flatten();
        let mut times: Vec<f64> = times.map(|time| time / cycles).collect();
        measured.times[index].extend(&times);
        let middle = median(&mut times);
        match index {
            0 => alone = middle,
            _ => measured.gains[index - 1].push(alone / middle),
        }
        measured.unbound = measured.unbound.or(worked.unbound);
    }
    Ok(measured)
}

/// Order of the measurements of `count` teams: the first team before each of the others. A single team is
/// measured once.
fn in_turn(count: usize) -> Vec<usize> {
    match count {
        0 | 1 => (0..count).collect(),
        _ => (1..count).flat_map(|index| [0, index]).collect(),
    }
}

/// A member's trajectories, one per operating point.
struct Trajectories<'s, K: Kernel> {
    kernels: Vec<K>,
    starts: &'s [&'s TrajectoryState],
    states: Vec<TrajectoryState>,
    /// One per operating point, because kernels keep prepared data in them.
    workspaces: Vec<K::Workspace>,
    counters: Counters,
    /// The operating point at which the member begins. Members begin at different points.
    first: usize,
    stopped: Option<Stop>,
}

impl<'s, K: Kernel> Trajectories<'s, K> {
    fn new(kernels: Vec<K>, starts: &'s [&'s TrajectoryState], index: usize) -> Self {
        Self {
            states: starts.iter().copied().cloned().collect(),
            workspaces: kernels.iter().map(K::workspace).collect(),
            counters: Counters::default(),
            first: index % kernels.len(),
            stopped: None,
            kernels,
            starts,
        }
    }

    /// Advances [`CYCLES_PER_POINT`] cycles at every operating point, each time from the same start.
    fn repeat(&mut self) {
        let points = self.kernels.len();
        for point in (self.first..points).chain(0..self.first) {
            self.states[point].clone_from(self.starts[point]);
            let result = self.kernels[point].advance(
                CYCLES_PER_POINT,
                &mut self.states[point],
                &mut self.workspaces[point],
                &mut (),
                &mut self.counters,
            );
            self.stopped = self.stopped.or(result.err());
        }
    }

    /// Final states of the trajectories, in bits.
    fn end(self) -> Result<Vec<u64>, Stop> {
        let bits = |state: &TrajectoryState| -> Vec<u64> {
            let numbers = state.state.iter().map(|x| x.to_bits());
            numbers.chain([state.cycle]).collect()
        };
        match self.stopped {
            Some(stop) => Err(stop),
            None => Ok(self.states.iter().flat_map(bits).collect()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;
    use strum::VariantArray;

    const PACE: RepetitionTime = RepetitionTime {
        slice: Duration::ZERO,
        least: 2,
        most: 2,
    };

    /// Both kernels on two members that share a core: equal ends, times, and work that agrees with the
    /// tables.
    #[test]
    fn kernels_advance_on_teams_and_count_their_work() {
        let topology = Topology::current().unwrap();
        let default = DefaultDrive::new().unwrap();
        let index = topology.cores[0].threads[0];
        let thread = HardwareThread { index, node: 0 };
        let teams = [vec![thread], vec![thread; 2]];
        for (sharing, points) in [(Sharing::Shared, 9), (Sharing::Private, 1)] {
            for &solver in Solver::VARIANTS {
                let modes = 4;
                let campaign = Campaign {
                    solver,
                    sharing,
                    modes,
                    points,
                };
                let measured = measure(&topology, &default, &campaign, &teams, PACE).unwrap();
                assert_eq!((measured.times.len(), measured.gains.len()), (2, 1));
                assert_eq!(measured.gains[0].len(), PASSES);
                let times = measured.times.iter().chain(&measured.gains).flatten();
                assert!(times.copied().all(|value| value > 0.0));
                assert!(measured.work.numbers > 0.0);
                assert!(measured.bytes > 0 && measured.work.distinct > 0.0);
                assert!(measured.work.distinct <= 8.0 * measured.work.numbers);
            }
        }
    }

    #[test]
    fn one_thread_is_measured_before_every_other_team() {
        assert_eq!(in_turn(3), [0, 1, 0, 2]);
        assert_eq!((in_turn(1), in_turn(0)), (vec![0], vec![]));
    }

    #[test]
    fn members_read_the_copy_of_all_of_their_node_or_their_own() {
        let thread = |index, node| HardwareThread { index, node };
        let team = [thread(0, 1), thread(1, 0), thread(2, 1)];
        assert_eq!(copy_of(Sharing::Shared, &team), [0, 0, 0]);
        assert_eq!(copy_of(Sharing::Node, &team), [0, 1, 0]);
        assert_eq!(copy_of(Sharing::Private, &team), [0, 1, 2]);
        let built = [TableArray {
            name: "a",
            unit: "1",
            values: [1.5, 2.5][..].into(),
        }];
        let topology = Topology::current().unwrap();
        let made = copies(&topology, &team, &[0, 1, 0], &built);
        assert_eq!(made, [built.to_vec(), built.to_vec()]);
        assert_ne!(made[0][0].values.as_ptr(), made[1][0].values.as_ptr());
    }
}
