//! Which worker should compute which chain? Chains read kernel tables. A worker prefers tables that its NUMA
//! node used most recently ("at hand"), then tables whose home is this node, then others.
//!
//! Pure bookkeeping. The choice of a worker does not change results.

use std::collections::VecDeque;

/// Largest number of tables that a node keeps at hand; the least recently used one is dropped.
pub const TABLES_AT_HAND: usize = 4;

/// Distance of a table to a worker, nearest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TableDistance {
    /// The node has the table at hand, or the work reads no table.
    AtHand,
    /// The node is the table's home.
    Home,
    /// Another node is the table's home: taking the work is a steal.
    Elsewhere,
}

/// The tables that each NUMA node has at hand: those that it used most recently.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeTables {
    /// Tables at hand of every node, most recently used first.
    at_hand: Vec<VecDeque<u64>>,
    steals: u64,
}

impl NodeTables {
    /// `nodes` nodes without tables at hand.
    pub fn new(nodes: usize) -> Self {
        Self {
            at_hand: vec![VecDeque::new(); nodes],
            steals: 0,
        }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.at_hand.len()
    }

    /// Distance of a table to the workers of a node. The home is the number of the table modulo the number of
    /// nodes.
    pub fn distance(&self, table: Option<u64>, node: usize) -> TableDistance {
        let Some(table) = table else {
            return TableDistance::AtHand;
        };
        if self.at_hand[node].contains(&table) {
            TableDistance::AtHand
        } else if table % self.at_hand.len() as u64 == node as u64 {
            TableDistance::Home
        } else {
            TableDistance::Elsewhere
        }
    }

    /// Records that a worker of a node takes work that reads a table.
    pub fn take(&mut self, table: Option<u64>, node: usize) {
        let Some(table) = table else {
            return;
        };
        if self.distance(Some(table), node) == TableDistance::Elsewhere {
            self.steals += 1;
        }
        let tables = &mut self.at_hand[node];
        tables.retain(|known| *known != table);
        tables.push_front(table);
        tables.truncate(TABLES_AT_HAND);
    }

    /// Number of times that a node took a table from another node: the table was not at hand, and its home is
    /// elsewhere.
    pub fn steals(&self) -> u64 {
        self.steals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_tables_are_nearer_than_those_of_others() {
        let mut node_tables = NodeTables::new(2);
        assert_eq!(node_tables.distance(None, 1), TableDistance::AtHand);
        assert_eq!(node_tables.distance(Some(4), 0), TableDistance::Home);
        assert_eq!(node_tables.distance(Some(4), 1), TableDistance::Elsewhere);
        node_tables.take(Some(4), 1);
        assert_eq!(node_tables.distance(Some(4), 1), TableDistance::AtHand);
        assert_eq!((node_tables.steals(), node_tables.nodes()), (1, 2));
        node_tables.take(Some(4), 1);
        node_tables.take(None, 0);
        node_tables.take(Some(2), 0);
        assert_eq!(node_tables.steals(), 1, "at hand, none, at home");
        assert!(
            TableDistance::AtHand < TableDistance::Home
                && TableDistance::Home < TableDistance::Elsewhere
        );
    }

    #[test]
    fn what_was_not_used_for_longest_is_let_go() {
        let mut node_tables = NodeTables::new(1);
        for table in 0..TABLES_AT_HAND as u64 {
            node_tables.take(Some(table), 0);
        }
        node_tables.take(Some(0), 0);
        node_tables.take(Some(99), 0);
        assert_eq!(node_tables.distance(Some(0), 0), TableDistance::AtHand);
        assert_eq!(node_tables.distance(Some(1), 0), TableDistance::Home);
    }
}
