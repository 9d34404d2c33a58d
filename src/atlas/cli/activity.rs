//! Work done by the workers of each NUMA node.

use crate::store::PointRow;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Finished points and busy time of a run, by NUMA node.
#[derive(Debug, Default)]
pub struct Activity {
    nodes: BTreeMap<Option<u32>, Node>,
}

#[derive(Debug, Default)]
struct Node {
    workers: BTreeSet<u32>,
    points: u64,
    seconds: f64,
}

/// Finished points and busy workers of one node.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NodeActivity {
    /// Number of the node in the system; absent if unknown.
    pub numa_node: Option<u32>,
    /// Workers that have finished at least one point on the node.
    pub workers: usize,
    /// Points finished on the node.
    pub points: u64,
    /// Busy workers, averaged over the run so far. Unfinished points do not count yet.
    pub busy: f64,
}

impl Activity {
    /// Counts a point that this run computed.
    pub fn count(&mut self, row: &PointRow) {
        let placement = &row.placement;
        let node = self.nodes.entry(placement.numa_node).or_default();
        node.workers.insert(placement.worker);
        node.points += 1;
        node.seconds += placement.wall_time;
    }

    /// Work done in the first `elapsed` \[s\] of the run, by node.
    pub fn over(&self, elapsed: f64) -> Vec<NodeActivity> {
        let of = |(numa_node, node): (&Option<u32>, &Node)| NodeActivity {
            numa_node: *numa_node,
            workers: node.workers.len(),
            points: node.points,
            busy: if elapsed > 0.0 { node.seconds / elapsed } else { 0.0 },
        };
        self.nodes.iter().map(of).collect()
    }

    /// Work of each node in words, `node 0: 3.9 of 4 workers busy, …`; empty for fewer than two nodes.
    pub fn words(&self, elapsed: f64) -> String {
        if self.nodes.len() < 2 {
            return String::new();
        }
        let mut text = String::new();
        for node in self.over(elapsed) {
            let name = node.numa_node.map_or("?".to_owned(), |n| n.to_string());
            let separator = if text.is_empty() { "" } else { ", " };
            // Writing to a string cannot fail.
            _ = write!(
                text,
                "{separator}node {name}: {:.1} of {} workers busy",
                node.busy, node.workers
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{PointOutcome, Status};
    use crate::store::Placement;

    fn row(worker: u32, numa_node: Option<u32>, wall_time: f64) -> PointRow {
        PointRow {
            point_id: 0,
            axis_values: Vec::new(),
            outcome: PointOutcome::without_results(Status::Ok, String::new()),
            multistability: None,
            orbits: None,
            chain: None,
            horizon: None,
            covariant: None,
            mesh: None,
            kernel: "volterra".into(),
            placement: Placement {
                worker,
                numa_node,
                wall_time,
            },
        }
    }

    #[test]
    fn nodes_are_told_apart() {
        let mut activity = Activity::default();
        for (worker, node, seconds) in [(0, 0, 2.0), (1, 1, 1.0), (0, 0, 1.5), (3, 1, 1.0)] {
            activity.count(&row(worker, Some(node), seconds));
        }
        let found = activity.over(4.0);
        let short: Vec<_> = (found.iter())
            .map(|n| (n.numa_node, n.workers, n.points, n.busy))
            .collect();
        assert_eq!(short, [(Some(0), 1, 2, 0.875), (Some(1), 2, 2, 0.5)]);
        assert_eq!(
            activity.words(4.0),
            "node 0: 0.9 of 1 workers busy, node 1: 0.5 of 2 workers busy"
        );
        assert_eq!(activity.over(0.0)[0].busy, 0.0);
    }

    #[test]
    fn one_node_needs_no_words() {
        let mut activity = Activity::default();
        activity.count(&row(0, None, 1.0));
        assert_eq!(activity.words(1.0), "");
    }
}
