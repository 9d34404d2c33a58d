//! Loads a second of several chains at once, a curve a level of memory.

use super::super::axis::{Axis, range};
use super::super::categories::colour;
use super::super::panel::Panel;
use super::{Curve, draw_curves, logarithmic, titled};
use crate::report::plot::picture::Picture;
use crate::report::size_text;
use crate::store::Characteristics;

pub(super) fn draw(machine: &Characteristics) -> Option<Picture> {
    let mut sizes: Vec<u64> = machine.parallel.iter().map(|row| row.key.size).collect();
    sizes.dedup();
    let curves: Vec<Curve> = (sizes.iter().enumerate())
        .map(|(i, &size)| Curve {
            name: size_text(size),
            // The palette's yellow is too pale for a thin curve.
            colour: colour([0, 3, 4, 2, 6][i % 5]),
            places: (machine.parallel.iter())
                .filter(|row| row.key.size == size)
                .map(|row| [row.key.chains as f64, row.figure.value])
                .collect(),
        })
        .collect();
    let most = range((machine.parallel.iter()).map(|row| row.key.chains as f64))[1];
    if curves.is_empty() {
        return None;
    }
    let mut canvas = titled("Chains of loads that one core follows at once", machine);
    let panel = Panel {
        left: 92.0,
        right: 770.0,
        top: 86.0,
        bottom: 536.0,
        across: Axis::logarithmic("chains", "1", [0.9, 1.1 * most.max(2.0)]),
        up: logarithmic("loads", "1/s", curves.iter()),
    };
    panel.frame(&mut canvas, true);
    draw_curves(&mut canvas, &panel, &curves);
    Some(Picture::new("machine-parallel".into(), canvas))
}
