//! A modal file that was read, as a tree and as a structure.

use super::tree::Node;
use crate::structure::ModalStructure;
use std::sync::Arc;

/// A modal file that was read.
#[derive(Debug)]
pub(super) struct ModalFile {
    /// The text of the file as a tree, with the places of values.
    pub tree: Node,
    /// The structure that the file describes.
    pub structure: Arc<ModalStructure>,
}
