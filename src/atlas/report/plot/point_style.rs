//! The style of a point in a cell of a map.

use super::canvas::Colour;

/// The style of a point in its cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PointStyle {
    pub colour: Colour,
    pub text: String,
    /// Whether diagonal lines cover the colour: transient chaos.
    pub hatched: bool,
    /// Whether the corner has a dot: the standard errors are not verified.
    pub dotted: bool,
}

impl PointStyle {
    /// A style with a colour and a text only.
    pub fn plain(colour: Colour, text: &str) -> Self {
        Self {
            colour,
            text: text.to_owned(),
            hatched: false,
            dotted: false,
        }
    }
}
