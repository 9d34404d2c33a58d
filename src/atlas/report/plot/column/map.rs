//! A column over two axes, in colour.

use super::series::Series;
use crate::report::numbers::plural;
use crate::report::plot::axis::range;
use crate::report::plot::canvas::{Colour, INK};
use crate::report::plot::cells::{Cells, HEIGHT, MARGIN, notes};
use crate::report::plot::display::Scale;
use crate::report::plot::error::PlotError;
use crate::report::plot::motion::{Motion, cell_key, counts};
use crate::report::plot::picture::{Drawn, Picture};
use crate::report::plot::point_style::PointStyle;
use crate::report::plot::ramp::{bar, viridis};
use crate::report::plot::request::PlotRequest;
use crate::report::plot::results::Results;

/// Colour of cells without a value.
const NONE: Colour = Colour(0xee, 0xee, 0xee);

/// Draws a map of every slice, all with one scale, so that they can be compared.
pub(super) fn draw(
    results: &Results,
    cells: &Cells<'_>,
    series: &Series,
    request: &PlotRequest,
) -> Result<Drawn, PlotError> {
    let name = match series.part.as_str() {
        "" => series.name.clone(),
        part => format!("{}, {part}", series.name),
    };
    let scale = Scale::new(&name, &series.unit, &request.display)?;
    let known = |point_id: u64| Some(series.one(results.place(point_id)?)?.value);
    let value = |point_id: u64| scale.shown(known(point_id)?);
    let ids = || results.summary.all.iter().map(|point| point.point_id);
    let [_, largest] = range(ids().filter_map(value));
    let floor = scale.floor(largest).unwrap_or(f64::NEG_INFINITY);
    let ends = range(ids().filter_map(value).filter(|value| *value >= floor));
    let axis = scale.axis_over(ends);
    let (slices, all) = results.slices(&cells.free());
    let mut drawn = Drawn::sliced(&series.name, slices.len(), all);
    for slice in slices {
        let title = format!("{name} over {}", cells.words());
        let values = slice
            .points
            .iter()
            .filter_map(|point| value(point.point_id));
        let below = match values.filter(|value| *value < floor).count() {
            0 => String::new(),
            count => format!("{} of round-off below the scale", plural(count, "value")),
        };
        let mut canvas = results.canvas(&title, &[&slice.words, &below]);
        let found = cells.draw(&mut canvas, &slice, |point| {
            let motion = Motion::of(point);
            let (colour, mut text) = match value(point.point_id) {
                Some(value) => (viridis(axis.fraction(value)), axis.briefly(value)),
                None => (NONE, "–".to_owned()),
            };
            if motion == Motion::NotConverged {
                text.push('?');
            }
            PointStyle {
                hatched: motion.is_hatched(),
                ..PointStyle::plain(colour, &text)
            }
        });
        let blank = || {
            let ids = slice.points.iter().map(|point| point.point_id);
            ids.filter(|&id| value(id).is_none())
        };
        let (empty, off) = (
            blank().count(),
            blank().filter(|&id| known(id).is_some()).count(),
        );
        let mut y = HEIGHT[0];
        if empty < slice.points.len() {
            let bottom = HEIGHT[0] + 300.0;
            bar(&mut canvas, MARGIN, [HEIGHT[0], bottom], &axis);
            y = bottom + 26.0;
        }
        if empty > 0 {
            canvas.rectangle([MARGIN, y], [MARGIN + 14.0, y + 14.0], NONE);
            let text = match off {
                0 => format!("– no value ({empty})"),
                _ => format!("– no value ({}), none on this scale ({off})", empty - off),
            };
            canvas.label([MARGIN + 21.0, y + 12.0], &text, INK);
            y += 22.0;
        }
        let mut marked = counts(slice.points.iter().copied());
        marked.retain(|motion, _| motion.is_marked());
        let bottom = HEIGHT[1] - 50.0;
        y += cell_key(&mut canvas, [MARGIN, y], bottom, &marked, |motion| {
            let hatched = motion.is_hatched();
            let plain = PointStyle::plain(NONE, if hatched { "" } else { "?" });
            PointStyle { hatched, ..plain }
        });
        notes(&mut canvas, y, found);
        let name = format!(
            "{}{}{}",
            series.name.replace(' ', "-"),
            file_part(&series.part),
            slice.suffix
        );
        drawn.pictures.push(Picture::new(name, canvas));
    }
    Ok(drawn)
}

/// The part of a series in the name of a file: `-mesh-order-3`.
pub(super) fn file_part(part: &str) -> String {
    match part {
        "" => String::new(),
        part => format!("-{}", part.replace([' ', '/'], "-")),
    }
}
