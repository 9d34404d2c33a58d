//! Bandwidth over threads, with one panel per placement of the threads.

use super::super::axis::{Axis, range};
use super::super::canvas::{Anchor, Canvas, INK};
use super::super::categories::colour;
use super::super::panel::{LABEL_SIZE, Panel};
use super::{Curve, draw_curves, titled};
use crate::report::plot::picture::Picture;
use crate::store::Characteristics;

const KERNELS: [(&str, &str); 5] = [
    ("read", "read"),
    ("copy", "copy"),
    ("triad", "triad"),
    ("copy_nt", "copy, non-temporal"),
    ("triad_nt", "triad, non-temporal"),
];

pub(super) fn draw(machine: &Characteristics) -> Option<Picture> {
    let of = |placement: &str| -> Vec<Curve> {
        (KERNELS.iter().enumerate())
            .map(|(i, (kernel, name))| Curve {
                name: (*name).to_owned(),
                // The palette's yellow is too pale for a thin curve.
                colour: colour([0, 3, 4, 2, 6][i]),
                places: (machine.bandwidth.iter())
                    .filter(|row| row.key.placement == placement && row.key.kernel == *kernel)
                    .map(|row| [row.key.threads as f64, row.figure.value])
                    .collect(),
            })
            .filter(|curve| !curve.places.is_empty())
            .collect()
    };
    let (compact, scattered) = (of("compact"), of("scattered"));
    if compact.is_empty() {
        return None;
    }
    let places = || {
        compact
            .iter()
            .chain(&scattered)
            .flat_map(|curve| &curve.places)
    };
    let most = range(places().map(|place| place[0]))[1];
    let highest = range(places().map(|place| place[1]))[1];
    let mut canvas = titled("Bandwidth of large arrays over threads", machine);
    let panel = |left: f64, right: f64, curves: &[Curve], canvas: &mut Canvas, name: &str| {
        let panel = Panel::new(
            [left, right],
            [86.0, 536.0],
            threads(most),
            Axis::linear("bandwidth", "B/s", [0.0, 1.08 * highest]),
        );
        panel.frame(canvas, true);
        canvas.text([left, 78.0], name, LABEL_SIZE, INK, Anchor::Start);
        draw_curves(canvas, &panel, curves);
    };
    if scattered.is_empty() {
        panel(
            92.0,
            770.0,
            &compact,
            &mut canvas,
            "cores of a node before the next",
        );
    } else {
        panel(
            92.0,
            330.0,
            &compact,
            &mut canvas,
            "cores of a node before the next",
        );
        panel(572.0, 800.0, &scattered, &mut canvas, "nodes in turn");
    }
    Some(Picture::new("machine-bandwidth".into(), canvas))
}

/// A logarithmic axis of numbers of threads.
pub(super) fn threads(most: f64) -> Axis {
    Axis::logarithmic("threads", "1", [0.9, 1.1 * most.max(2.0)])
}
