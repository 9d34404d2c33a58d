//! Whose work is it? Chains read tables of kernels; a worker takes those first whose tables its
//! own NUMA node has, then those whose tables are to be kept there, and others' last.
//!
//! Pure bookkeeping. Which worker computes a chain moves no number of its results.

use std::collections::VecDeque;

/// Tables that a node has at hand at most; of more the one not used for longest is let go.
pub const TABLES_AT_HAND: usize = 4;

/// How near a table is to a worker, nearest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Nearness {
    /// Its node has it at hand, or none is read.
    AtHand,
    /// Its node is the one to keep it.
    Home,
    /// Another node is to keep it: taking it is a steal.
    Elsewhere,
}

/// Which tables lie on which node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shelves {
    /// Tables at hand of every node, the one last used first.
    at_hand: Vec<VecDeque<u64>>,
    steals: u64,
}

impl Shelves {
    /// Empty ones of so many nodes.
    pub fn new(nodes: usize) -> Self {
        Self {
            at_hand: vec![VecDeque::new(); nodes],
            steals: 0,
        }
    }

    /// How many nodes.
    pub fn nodes(&self) -> usize {
        self.at_hand.len()
    }

    /// How near a table is to the workers of a node. Homes are dealt by the tables' own numbers,
    /// so that nothing is kept of tables that are not at hand.
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

    /// Tables that were taken to a node other than their own.
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
