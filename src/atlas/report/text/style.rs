//! How may the text look?

/// How the text may look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Characters only.
    Plain,
    /// With ANSI escapes of the 256-colour palette.
    Colour,
}
