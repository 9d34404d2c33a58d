//! Terminal features of the text.

/// Terminal features that the text may use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Characters only.
    Plain,
    /// With ANSI escapes of the 256-colour palette.
    Colour,
}
