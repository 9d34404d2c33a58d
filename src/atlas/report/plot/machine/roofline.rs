//! The roofline (Williams, Waterman and Patterson 2009): the limits of one thread by arithmetic and by each
//! level of memory. Dots show the kernels, with their counted operations and bytes.

use super::super::axis::{Axis, range};
use super::super::canvas::{Anchor, INK, SOFT};
use super::super::categories::colour;
use super::super::panel::{Panel, TICK_SIZE};
use super::solver::kernel_colour;
use super::{levels, name_ends, titled};
use crate::report::plot::picture::Picture;
use crate::store::Characteristics;

pub(super) fn draw(machine: &Characteristics) -> Option<Picture> {
    let peaks: Vec<(String, f64)> = (machine.arithmetic.iter())
        .filter(|row| row.key.threads == 1)
        .map(|row| (row.key.isa.clone(), row.figure.value))
        .collect();
    let levels = levels(machine);
    let peak = peaks.iter().map(|(_, rate)| *rate).fold(0.0, f64::max);
    if peaks.is_empty() || levels.is_empty() || machine.roofline.is_empty() {
        return None;
    }
    let intensities = machine.roofline.iter().map(|row| row.intensity);
    let [low, high] = range(intensities.chain(levels.iter().map(|(_, b)| peak / b)));
    let rates = machine.roofline.iter().map(|row| row.rate);
    let floor = range(rates)[0];
    let mut canvas = titled("Roofline of one thread, with the kernels on it", machine);
    let panel = Panel::new(
        [92.0, 800.0],
        [80.0, 536.0],
        Axis::logarithmic(
            "operations per byte of different table entries in a mesh cycle",
            "op/B",
            [low / 1.6, high * 1.6],
        ),
        Axis::logarithmic("rate", "op/s", [floor / 2.0, peak * 1.6]),
    );
    panel.frame(&mut canvas, true);
    let mut names: Vec<(f64, &str, _)> = Vec::new();
    for (name, rate) in &peaks {
        let from = [panel.left, panel.y(*rate)];
        canvas.line(&[from, [panel.right, panel.y(*rate)]], SOFT, 1.4);
        names.push((panel.y(*rate), name, SOFT));
    }
    let (start, floor) = (low / 1.6, floor / 2.0);
    for (name, bandwidth) in &levels {
        // The line of a level goes from the left or the lower edge of the panel to the peak of arithmetic.
        let begin = start.max(floor / bandwidth);
        let end = peak / bandwidth;
        canvas.line(
            &[panel.at(begin, begin * bandwidth), panel.at(end, peak)],
            INK,
            1.4,
        );
        let middle = (begin * end).sqrt();
        let [x, y] = panel.at(middle, middle * bandwidth);
        // The line of the memory may be just below that of the last cache, so that its name is on the other
        // side.
        let (at, anchor) = match name.as_str() {
            "memory" => ([x + 8.0, y + 12.0], Anchor::Start),
            _ => ([x - 6.0, y - 4.0], Anchor::End),
        };
        canvas.text(at, name, TICK_SIZE, INK, anchor);
    }
    for row in &machine.roofline {
        let number = kernel_colour(&row.kernel);
        let at = panel.at(row.intensity, row.rate);
        canvas.disc(at, 4.0, colour(number));
        // Write the kernel's name once, at its largest number of modes.
        let others = machine.roofline.iter().filter(|r| r.kernel == row.kernel);
        let name = match others.map(|other| other.modes).max() {
            Some(most) if most > row.modes => row.modes.to_string(),
            _ => format!("{} {}", row.kernel, row.modes),
        };
        let y = at[1] + 0.35 * TICK_SIZE;
        canvas.label([at[0] + 8.0, y], &name, colour(number));
    }
    name_ends(&mut canvas, &panel, names);
    Some(Picture::new("machine-roofline".into(), canvas))
}
