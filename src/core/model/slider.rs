//! What are the dry sliders of a model?
//!
//! The position s of a slider is the first component of an additional block, whose second component stays 0.
//! The deflection along the line of the slider is δ − s, so that its spring is a contact without a gap.

use crate::structure::{ModalStructure, SliderPart};

/// A dry slider of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slider {
    /// Index of the block with its position.
    pub block: usize,
    /// Index of its forward slip among the contacts. The backward slip and the spring follow.
    pub forwards: usize,
}

impl Slider {
    /// The sliders of a structure. `before` is the number of contacts before those of the structure. The
    /// blocks of the sliders follow those of the modes.
    pub(super) fn of_structure(structure: &ModalStructure, before: usize) -> Vec<Self> {
        let parts = structure.contacts.iter().zip(before..);
        let starts = parts.filter(|(contact, _)| contact.law.slider == Some(SliderPart::Forwards));
        (starts.zip(structure.modes()..))
            .map(|((_, forwards), block)| Self { block, forwards })
            .collect()
    }

    /// Indices of its two slips among the contacts: forwards, backwards.
    pub fn slips(self) -> [usize; 2] {
        [self.forwards, self.forwards + 1]
    }

    /// Whether a contact is one of its states.
    pub fn has(self, contact: usize) -> bool {
        (self.forwards..=self.spring()).contains(&contact)
    }

    /// Index of its spring among the contacts.
    pub fn spring(self) -> usize {
        self.forwards + 2
    }
}
