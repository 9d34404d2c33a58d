//! Colours that distinguish attractors and branches.

use super::canvas::Colour;
use super::motion::Motion;

/// Okabe and Ito's palette without black. Colour-blind readers can distinguish its colours, and neighbouring
/// colours also differ in brightness.
const COLOURS: [Colour; 7] = [
    Colour(0x00, 0x72, 0xb2),
    Colour(0xe6, 0x9f, 0x00),
    Colour(0x56, 0xb4, 0xe9),
    Colour(0xd5, 0x5e, 0x00),
    Colour(0x00, 0x9e, 0x73),
    Colour(0xf0, 0xe4, 0x42),
    Colour(0xcc, 0x79, 0xa7),
];

/// The colour of the attractor or branch with a number; colours repeat after seven.
pub(in crate::report) fn colour(number: usize) -> Colour {
    COLOURS[number % COLOURS.len()]
}

/// The colour of a motion with this status that did not settle on an attractor.
pub(super) fn lost(status: &str) -> Colour {
    match status {
        "not_converged" => Motion::NotConverged.colour(),
        _ => Motion::Failed.colour(),
    }
}
