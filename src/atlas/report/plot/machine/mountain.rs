//! The memory mountain over the size of the buffer: read bandwidth for each stride above, latency below.

use super::super::canvas::{BLUE, INK, RED};
use super::super::panel::Panel;
use super::super::ramp::viridis;
use super::{Curve, draw_curves, logarithmic, mark_caches, sizes, titled};
use crate::report::plot::picture::Picture;
use crate::report::size_text;
use crate::store::Characteristics;

pub(super) fn draw(machine: &Characteristics) -> Option<Picture> {
    let mut strides: Vec<u64> = machine.mountain.iter().map(|row| row.key.stride).collect();
    strides.sort_unstable();
    strides.dedup();
    let last = strides.len().saturating_sub(1).max(1) as f64;
    let curves: Vec<Curve> = (strides.iter().enumerate())
        .map(|(i, &stride)| Curve {
            name: match stride {
                64 => "every line".to_owned(),
                _ => format!("every {}", size_text(stride).replacen(".0 ", " ", 1)),
            },
            // The yellow end of the ramp is invisible on white.
            colour: viridis(0.82 * i as f64 / last),
            places: (machine.mountain.iter())
                .filter(|row| row.key.stride == stride)
                .map(|row| [row.key.size as f64, row.figure.value])
                .collect(),
        })
        .collect();
    if curves.is_empty() {
        return None;
    }
    let mut canvas = titled("Memory: bandwidth and latency of one thread", machine);
    let across = sizes("size of the buffer", curves.iter());
    let panel = Panel::new(
        [92.0, 790.0],
        [86.0, 336.0],
        across.clone(),
        logarithmic("read bandwidth", "B/s", curves.iter()),
    );
    panel.frame(&mut canvas, false);
    mark_caches(&mut canvas, &panel, machine);
    draw_curves(&mut canvas, &panel, &curves);

    let first = machine.latency.first().map(|row| row.key.cpu_node);
    let rows: Vec<_> = (machine.latency.iter())
        .filter(|row| row.key.cpu_node == row.key.memory_node && Some(row.key.cpu_node) == first)
        .collect();
    let kinds = [
        ("page by page", "pages", false, BLUE),
        ("page to page", "hops", false, RED),
        ("on huge pages", "hops", true, INK),
    ];
    let all: Vec<Curve> = (kinds.into_iter())
        .map(|(name, order, huge_pages, colour)| Curve {
            name: name.to_owned(),
            colour,
            places: (rows.iter())
                .filter(|row| row.key.order == order && row.key.huge_pages == huge_pages)
                .map(|row| [row.key.size as f64, row.figure.value])
                .collect(),
        })
        .filter(|curve| !curve.places.is_empty())
        .collect();
    let panel = Panel {
        top: 362.0,
        bottom: 536.0,
        up: logarithmic("time of a load", "s", all.iter()),
        across,
        ..panel
    };
    if all.is_empty() {
        canvas.label([panel.left, panel.bottom], "latency was not measured", RED);
        return Some(Picture::new("machine-mountain".into(), canvas));
    }
    panel.frame(&mut canvas, true);
    draw_curves(&mut canvas, &panel, &all);
    Some(Picture::new("machine-mountain".into(), canvas))
}
