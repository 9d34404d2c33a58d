//! A modal file that was read: its text as a tree, and what it says.

use super::tree::Node;
use crate::structure::ModalStructure;
use std::sync::Arc;

/// A modal file that was read.
#[derive(Debug)]
pub(super) struct ModalFile {
    /// Its text with the places of its values.
    pub tree: Node,
    /// What it says.
    pub structure: Arc<ModalStructure>,
}
