//! Which worker should take which work? Chains read tables of kernels. A worker prefers tables that its NUMA node has
//! at hand, then tables whose home is this node, then others.
//!
//! Pure bookkeeping. The choice of a worker does not change results.

use std::collections::VecDeque;

/// Most tables that a node keeps at hand; the least recently used one is dropped.
pub const TABLES_AT_HAND: usize = 4;

/// Nearness of a table to a worker, nearest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Nearness {
    /// The node has the table at hand, or the work reads no table.
    AtHand,
    /// The node is the table's home.
    Home,
    /// Another node is the table's home: taking the work is a steal.
    Elsewhere,
}

/// Which tables lie on which node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shelves {
    /// Tables at hand of every node, most recently used first.
    at_hand: Vec<VecDeque<u64>>,
    steals: u64,
}

impl Shelves {
    /// Empty shelves of `nodes` nodes.
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

    /// Nearness of a table to the workers of a node. The table's number determines its home, so that tables need no
    /// record while they are not at hand.
    pub fn nearness(&self, table: Option<u64>, node: usize) -> Nearness {
        let Some(table) = table else {
            return Nearness::AtHand;
        };
        if self.at_hand[node].contains(&table) {
            Nearness::AtHand
        } else if table % self.at_hand.len() as u64 == node as u64 {
            Nearness::Home
        } else {
            Nearness::Elsewhere
        }
    }

    /// A worker of a node takes work that reads a table.
    pub fn take(&mut self, table: Option<u64>, node: usize) {
        let Some(table) = table else {
            return;
        };
        if self.nearness(Some(table), node) == Nearness::Elsewhere {
            self.steals += 1;
        }
        let shelf = &mut self.at_hand[node];
        shelf.retain(|known| *known != table);
        shelf.push_front(table);
        shelf.truncate(TABLES_AT_HAND);
    }

    /// Number of tables that another node than their home took.
    pub fn steals(&self) -> u64 {
        self.steals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_tables_are_nearer_than_those_of_others() {
        let mut shelves = Shelves::new(2);
        assert_eq!(shelves.nearness(None, 1), Nearness::AtHand);
        assert_eq!(shelves.nearness(Some(4), 0), Nearness::Home);
        assert_eq!(shelves.nearness(Some(4), 1), Nearness::Elsewhere);
        shelves.take(Some(4), 1);
        assert_eq!(shelves.nearness(Some(4), 1), Nearness::AtHand);
        assert_eq!((shelves.steals(), shelves.nodes()), (1, 2));
        shelves.take(Some(4), 1);
        shelves.take(None, 0);
        shelves.take(Some(2), 0);
        assert_eq!(shelves.steals(), 1, "at hand, none, at home");
        assert!(Nearness::AtHand < Nearness::Home && Nearness::Home < Nearness::Elsewhere);
    }

    #[test]
    fn what_was_not_used_for_longest_is_let_go() {
        let mut shelves = Shelves::new(1);
        for table in 0..TABLES_AT_HAND as u64 {
            shelves.take(Some(table), 0);
        }
        shelves.take(Some(0), 0);
        shelves.take(Some(99), 0);
        assert_eq!(shelves.nearness(Some(0), 0), Nearness::AtHand);
        assert_eq!(shelves.nearness(Some(1), 0), Nearness::Home);
    }
}
