//! Latency of one core's loads over what the others read meanwhile.

use super::super::axis::{Axis, range};
use super::super::canvas::{Anchor, SOFT};
use super::super::categories::colour;
use super::super::panel::{Panel, TICK_SIZE};
use super::{Curve, draw_curves, titled};
use crate::report::numbers::plural;
use crate::report::plot::picture::Picture;
use crate::report::size_text;
use crate::store::Characteristics;

pub(super) fn draw(machine: &Characteristics) -> Option<Picture> {
    let first = machine.loaded.first()?;
    let places: Vec<[f64; 2]> = (machine.loaded.iter())
        .map(|row| [row.key.bandwidth, row.figure.value])
        .collect();
    let most = range(places.iter().map(|place| place[0]))[1];
    let highest = range(places.iter().map(|place| place[1]))[1];
    if most <= 0.0 {
        return None;
    }
    let mut canvas = titled("Latency under load", machine);
    let panel = Panel {
        left: 92.0,
        right: 770.0,
        top: 86.0,
        bottom: 536.0,
        across: Axis::linear("read by the other threads", "B/s", [0.0, 1.05 * most]),
        up: Axis::linear("a load", "s", [0.0, 1.08 * highest]),
    };
    panel.frame(&mut canvas, true);
    let threads = plural(first.key.threads as usize, "thread");
    let curve = Curve {
        name: format!("{threads} reading"),
        colour: colour(0),
        places,
    };
    draw_curves(&mut canvas, &panel, &[curve]);
    let pages = match first.key.huge_pages {
        true => ", huge pages",
        false => "",
    };
    let text = format!(
        "a chain of loads through {}{pages}",
        size_text(first.key.size)
    );
    let at = [panel.left + 12.0, panel.top + 20.0];
    canvas.text(at, &text, TICK_SIZE, SOFT, Anchor::Start);
    Some(Picture::new("machine-loaded".into(), canvas))
}
