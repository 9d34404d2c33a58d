//! Where the data lies: working sets of operators and tables on the levels of this machine's
//! memory.

use super::super::axis::Axis;
use super::super::canvas::{Anchor, Canvas, Colour, INK, SOFT};
use super::super::categories::colour;
use super::super::panel::{LABEL_SIZE, Panel, TICK_SIZE};
use super::super::ramp::viridis;
use super::{levels, titled};
use crate::report::plot::picture::Picture;
use crate::report::size_text;
use crate::store::Characteristics;

/// Smallest and largest size shown \[bytes\].
const SHOWN: [f64; 2] = [2048.0, 17_179_869_184.0];

/// Most working sets shown.
const MOST: usize = 20;

pub(super) fn draw(machine: &Characteristics) -> Option<Picture> {
    let sets = working_sets(machine);
    if sets.is_empty() {
        return None;
    }
    let mut canvas = titled("Where the data lies", machine);
    let panel = Panel {
        left: 250.0,
        right: 920.0,
        top: 120.0,
        bottom: 536.0,
        across: Axis::bytes("size", SHOWN),
        up: Axis::linear("", "1", [0.0, 1.0]),
    };
    bands(&mut canvas, &panel, machine);
    panel.ticks_across(&mut canvas, true);
    canvas.outline(
        [panel.left, panel.top],
        [panel.right, panel.bottom],
        INK,
        1.0,
    );
    let step = (panel.bottom - panel.top) / sets.len() as f64;
    for (i, (name, bytes, colour)) in sets.iter().enumerate() {
        let y = panel.top + step * (i as f64 + 0.5);
        let x = panel.x((*bytes as f64).clamp(SHOWN[0], SHOWN[1]));
        canvas.line(&[[panel.left, y], [x, y]], *colour, 1.2);
        canvas.disc([x, y], 4.5, *colour);
        let at = [panel.left - 10.0, y + 0.35 * TICK_SIZE];
        canvas.text(at, name, TICK_SIZE, INK, Anchor::End);
        let size = size_text(*bytes).replacen(".0 ", " ", 1);
        // Left of the disc where there is no room right of it.
        let (at, anchor) = match x > panel.right - 80.0 {
            true => ([x - 9.0, y - 5.0], Anchor::End),
            false => ([x + 9.0, y + 0.35 * TICK_SIZE], Anchor::Start),
        };
        canvas.text(at, &size, TICK_SIZE, INK, anchor);
    }
    Some(Picture::new("machine-map".into(), canvas))
}

/// Name, bytes and colour of every working set, smallest first.
fn working_sets(machine: &Characteristics) -> Vec<(String, u64, Colour)> {
    let mut sets: Vec<(String, u64, Colour)> = Vec::new();
    for row in machine
        .operators
        .iter()
        .filter(|row| row.key.kernel == "matvec")
    {
        let name = format!("operator of dimension {}", row.key.dimension);
        if !sets.iter().any(|(known, ..)| *known == name) {
            sets.push((name, row.key.working_set / row.key.count.max(1), SOFT));
        }
    }
    for row in machine.solver.iter().filter(|row| row.key.threads == 1) {
        let (number, wanted) = match row.key.kernel.as_str() {
            "volterra" => (3, true),
            "spectral" => (0, true),
            _ => (4, row.key.modes >= 40),
        };
        let tables = match row.key.tables.as_str() {
            "shared" => 1,
            "eight" if row.key.modes == 40 => 8,
            _ => continue,
        };
        let name = match tables {
            1 => format!("{}, {} modes", row.key.kernel, row.key.modes),
            _ => format!("eight of {}, {} modes", row.key.kernel, row.key.modes),
        };
        if wanted {
            sets.push((name, tables * row.key.table_bytes, colour(number)));
        }
    }
    sets.sort_by_key(|(_, bytes, _)| *bytes);
    sets.truncate(MOST);
    sets
}

/// A band a level of memory, with its name and what one thread reads from it.
fn bands(canvas: &mut Canvas, panel: &Panel, machine: &Characteristics) {
    let levels = levels(machine);
    let bandwidth = |name: &str| levels.iter().find(|(known, _)| known == name).map(|l| l.1);
    let mut edges: Vec<(String, f64)> = (machine.description.caches.iter())
        .map(|cache| (format!("L{}", cache.level), cache.size as f64))
        .collect();
    edges.push(("memory".to_owned(), SHOWN[1]));
    let mut from = SHOWN[0];
    let count = edges.len();
    for (i, (name, to)) in edges.into_iter().enumerate() {
        let to = to.clamp(SHOWN[0], SHOWN[1]);
        let pale = |Colour(r, g, b): Colour| {
            let pale = |channel: u8| (0.2 * f64::from(channel) + 0.8 * 255.0) as u8;
            Colour(pale(r), pale(g), pale(b))
        };
        let shade = pale(viridis(1.0 - i as f64 / count as f64));
        let (left, right) = (panel.x(from), panel.x(to));
        canvas.rectangle([left, panel.top], [right, panel.bottom], shade);
        let middle = 0.5 * (left + right);
        canvas.text(
            [middle, panel.top - 24.0],
            &name,
            LABEL_SIZE,
            INK,
            Anchor::Middle,
        );
        if let Some(rate) = bandwidth(&name) {
            let text = format!("{:.0} GB/s", 1e-9 * rate);
            canvas.text(
                [middle, panel.top - 7.0],
                &text,
                TICK_SIZE,
                SOFT,
                Anchor::Middle,
            );
        }
        from = to;
    }
}
