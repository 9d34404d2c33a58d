//! How does a point look in a cell of a map?

use super::canvas::Colour;

/// The look of a point in its cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PointStyle {
    pub colour: Colour,
    pub text: String,
    /// Diagonal lines over the colour: some trajectories left its chaos.
    pub hatched: bool,
    /// A dot in the corner: its standard errors are not verified.
    pub dotted: bool,
}

impl PointStyle {
    /// A colour and a text.
    pub fn plain(colour: Colour, text: &str) -> Self {
        Self {
            colour,
            text: text.to_owned(),
            hatched: false,
            dotted: false,
        }
    }
}
