//! The kind of motion over one axis: a row for each kind that occurs.

use std::collections::BTreeSet;

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, FAINT, INK, SOFT};
use super::motion::{Motion, counts};
use super::over_axis::across;
use super::panel::{LABEL_SIZE, Panel, TICK_SIZE};
use super::picture::{Drawn, Picture};
use super::results::Results;
use super::what::What;

/// Height of a row \[px\].
const ROW: f64 = 40.0;
/// Least height of the panel \[px\]: its label needs as much.
const LEAST: f64 = 116.0;

pub(super) fn draw(results: &Results, along: usize) -> Drawn {
    let name = &results.summary.axes[along].name;
    let (slices, all) = results.slices(&[along]);
    let mut drawn = Drawn::of_slices(What::Classes, slices.len(), all);
    for slice in slices {
        let title = format!("{}: kind of motion over {name}", results.job);
        let mut canvas = Canvas::titled(&title, &results.subtitle(&[&slice.words]));
        let found = counts(slice.points.iter().copied());
        let rows: BTreeSet<Motion> = found.keys().copied().collect();
        let height = (ROW * rows.len() as f64).clamp(LEAST, 454.0);
        let panel = Panel {
            left: 148.0,
            right: 850.0,
            top: 72.0,
            bottom: 72.0 + height,
            across: across(results, along),
            up: Axis::linear("", "", [0.0, rows.len() as f64]),
        };
        panel.ticks_across(&mut canvas, true);
        let half = 0.5 * height / rows.len() as f64;
        for (row, motion) in rows.iter().enumerate() {
            let y = panel.y(row as f64 + 0.5);
            canvas.line(&[[panel.left, y], [panel.right, y]], FAINT, 1.0);
            let baseline = y + 0.35 * TICK_SIZE;
            let at = [panel.left - 9.0, baseline];
            canvas.text(at, &motion.name(), TICK_SIZE, INK, Anchor::End);
            let count = match found[motion] {
                1 => "1 point".to_owned(),
                count => format!("{count} points"),
            };
            let at = [panel.right + 9.0, baseline];
            canvas.text(at, &count, TICK_SIZE, SOFT, Anchor::Start);
            let radius = (0.6 * half).min(6.0);
            for point in slice.points.iter().filter(|p| Motion::of(p) == *motion) {
                let x = panel.x(point.axis_values[along]);
                canvas.disc([x, y], radius, INK);
                canvas.disc([x, y], radius - 0.8, motion.colour());
            }
        }
        let at = [24.0, 0.5 * (panel.top + panel.bottom)];
        canvas.text_upwards(at, "kind of motion", LABEL_SIZE, INK, Anchor::Middle);
        canvas.height = panel.bottom + 74.0;
        canvas.outline(
            [panel.left, panel.top],
            [panel.right, panel.bottom],
            INK,
            1.0,
        );
        let name = format!("classes{}", slice.suffix);
        drawn.pictures.push(Picture::new(name, canvas));
    }
    drawn
}
