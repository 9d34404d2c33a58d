//! Phase portraits. From a trace: the trajectory in the plane of deflection and its rate, with the states at
//! mesh phase 0. From results: the Poincaré samples of one point.

use super::axis::{Axis, padded, range};
use super::canvas::{Anchor, BLUE, Canvas, Colour, INK, Place, RED, SOFT};
use super::error::PlotError;
use super::motion::Motion;
use super::panel::{Panel, TICK_SIZE};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::recording::Recording;
use super::request::PlotRequest;
use super::results::Results;
use super::section::{Quantity, Section};
use crate::report::PointSummary;
use crate::report::numbers::plural;
use crate::store::TableKind;

/// Largest number of mesh cycles of a trace that are drawn.
const MOST_CYCLES: u64 = 400;
/// Colour of the trajectory below the states at mesh phase 0.
const ORBIT: Colour = Colour(0x7f, 0xb2, 0xd9);

fn panel(across: Axis, up: Axis) -> Panel {
    Panel::new([92.0, 820.0], [72.0, 526.0], across, up)
}

/// Draws the Poincaré samples of one point, in the plane of two quantities that vary on the section. The
/// point is the requested one, else the most chaotic, else the one with the largest RMS.
pub(super) fn of_results(results: &Results, request: &PlotRequest) -> Result<Drawn, PlotError> {
    let table = results.needed(TableKind::Poincare, PictureKind::Phase)?;
    let ids = table.u64("point_id")?;
    let sampled = |point: &&PointSummary| ids.binary_search(&Some(point.point_id)).is_ok();
    let liveliness = |point: &PointSummary| match Motion::of(point) {
        motion if motion.is_chaos() => point.lambda.unwrap_or(0.0),
        _ => f64::NEG_INFINITY,
    };
    let (point, why) = match request.point {
        Some(id) => (results.point(id)?, ""),
        None => {
            let known = results.summary.all.iter().zip(&results.deflection_rms);
            let best = known.filter(|(point, _)| sampled(point)).max_by(|a, b| {
                let chaos = liveliness(a.0).total_cmp(&liveliness(b.0));
                chaos.then(a.1.unwrap_or(0.0).total_cmp(&b.1.unwrap_or(0.0)))
            });
            let (point, _) =
                best.ok_or_else(|| PictureKind::Phase.unfit("poincare.parquet has no samples"))?;
            let why = match Motion::of(point) {
                _ if results.summary.all.len() == 1 => "",
                motion if motion.is_chaos() => "the point with the largest λ",
                _ => "the point with the largest deflection_rms",
            };
            (point, why)
        }
    };
    let section = Section::of(&table)?;
    // The phase plane of a strobe has the deflection on the horizontal axis.
    let [up, across] = match section.plane {
        [first, second] if first.column == "phase" => [second, first],
        [rate, deflection] => [rate, deflection],
    };
    let (first, second) = (table.f64(across.column)?, table.f64(up.column)?);
    let samples: Vec<[f64; 2]> = ids
        .iter()
        .zip(first.iter().zip(&second))
        .filter(|(id, _)| **id == Some(point.point_id))
        .filter_map(|(_, (first, second))| Some([(*first)?, (*second)?]))
        .collect();
    if samples.is_empty() {
        return Err(PictureKind::Phase.unfit(format!("point {} has no sample", point.point_id)));
    }
    let units = table.units()?;
    let title = format!("Poincaré samples {}", section.words);
    let words = results.point_words(point);
    let mut canvas = results.canvas(&title, &[&words, why]);
    let axis = |quantity: Quantity, index: usize| {
        let unit = units.get(quantity.column).map_or("", String::as_str);
        let met = range(samples.iter().map(|sample| sample[index]));
        Axis::linear(quantity.name, unit, padded(met, 0.05))
    };
    let panel = panel(axis(across, 0), axis(up, 1));
    panel.frame(&mut canvas, true);
    for [across, up] in &samples {
        canvas.disc(panel.at(*across, *up), 2.6, BLUE);
    }
    let count = plural(samples.len(), "sample");
    canvas.label([panel.right + 14.0, panel.top + TICK_SIZE], &count, SOFT);
    let name = format!("phase-point{}", point.point_id);
    Ok(Drawn::one(name, canvas))
}

/// Draws the trajectory of a trace, with a dot at the start of each mesh cycle.
pub(super) fn of_trace(recording: &Recording) -> Drawn {
    let rows = recording.first_cycles(MOST_CYCLES);
    let (deflection, rate) = (&recording.deflection[..rows], &recording.velocity[..rows]);
    let gap = recording.half_gap;
    let edges = gap.into_iter().flat_map(|gap| [-gap, gap]);
    let across = range(deflection.iter().copied().chain(edges));
    let up = range(rate.iter().copied());
    let axis = |name: &str, column: &str, met: [f64; 2]| {
        Axis::linear(name, recording.unit(column), padded(met, 0.05))
    };
    let panel = panel(
        axis("deflection", "deflection", across),
        axis("rate of the deflection", "velocity", up),
    );
    let title = format!("{}: phase portrait", recording.job);
    let mut canvas = Canvas::titled(&title, &recording.subtitle(rows));
    panel.frame(&mut canvas, true);
    for (edge, name) in gap
        .into_iter()
        .flat_map(|gap| [(-gap, "coast"), (gap, "drive")])
    {
        let x = panel.x(edge);
        canvas.dashes([x, panel.top], [x, panel.bottom], RED, 1.2);
        let (at, anchor) = match name {
            "coast" => ([x - 5.0, panel.bottom - 8.0], Anchor::End),
            _ => ([x + 5.0, panel.bottom - 8.0], Anchor::Start),
        };
        canvas.text(at, &format!("{name} contact"), TICK_SIZE, RED, anchor);
    }
    let orbit: Vec<Place> = (deflection.iter().zip(rate))
        .map(|(deflection, rate)| panel.at(*deflection, *rate))
        .collect();
    canvas.line(&orbit, ORBIT, 1.0);
    for row in (0..rows).filter(|&row| recording.starts_cycle(row)) {
        canvas.disc(orbit[row], 3.2, INK);
    }
    let [x, y] = [panel.right + 14.0, panel.top + TICK_SIZE];
    canvas.line(&[[x, y - 4.0], [x + 16.0, y - 4.0]], ORBIT, 2.0);
    canvas.label([x + 22.0, y], "orbit", INK);
    canvas.disc([x + 8.0, y + 18.0], 3.2, INK);
    canvas.label([x + 22.0, y + 22.0], "mesh phase 0", INK);
    Drawn::one("phase", canvas)
}
