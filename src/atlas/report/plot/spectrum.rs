//! Spectra of one point over mesh orders: deflection above, mesh force below.

use super::axis::{Axis, range};
use super::canvas::{Anchor, BLUE, Canvas, INK, Place};
use super::error::PlotError;
use super::lettering::fitted;
use super::panel::{Panel, TICK_SIZE};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::request::PlotRequest;
use super::results::Results;
use crate::report::numbers::to_digits;
use crate::store::TableKind;

/// Decades shown below the largest line; smaller values are round-off.
const DECADES: f64 = 6.0;
/// Largest number of shown orders.
const MOST_ORDERS: f64 = 16.0;
/// Largest number of orders labelled with number and amplitude above their line.
const MOST_NAMED: usize = 5;
/// Width of a name, and height of one of its two lines \[px\].
const NAME: [f64; 2] = [76.0, 15.0];
/// Distance between a name and the frame \[px\].
const CLEAR: f64 = 4.0;

pub(super) fn draw(results: &Results, request: &PlotRequest) -> Result<Drawn, PlotError> {
    let table = results.needed(TableKind::Spectra, PictureKind::Spectrum)?;
    let ids = table.u64("point_id")?;
    let (signals, orders) = (table.text("signal")?, table.f64("order")?);
    let (amplitudes, methods) = (table.f64("amplitude")?, table.text("method")?);
    let has_lines = |id: u64| ids.binary_search(&Some(id)).is_ok();
    let point = match request.point {
        Some(id) => results.point(id)?,
        None => results
            .summary
            .all
            .iter()
            .zip(&results.deflection_rms)
            .filter(|(point, _)| has_lines(point.point_id))
            .max_by(|a, b| a.1.unwrap_or(0.0).total_cmp(&b.1.unwrap_or(0.0)))
            .map(|(point, _)| point)
            .ok_or_else(|| PictureKind::Spectrum.unfit("spectra.parquet has no lines"))?,
    };
    if !has_lines(point.point_id) {
        let reason = format!("point {} has no spectrum", point.point_id);
        return Err(PictureKind::Spectrum.unfit(reason));
    }
    let start = ids.partition_point(|id| *id < Some(point.point_id));
    // Exact lines are drawn as separate bars, averaged power as a continuous curve.
    let is_exact = methods[start].as_deref() == Some("fourier");
    let lines = |signal: &str| -> Vec<[f64; 2]> {
        let end = ids.partition_point(|id| *id <= Some(point.point_id));
        (start..end)
            .filter(|&row| signals[row].as_deref() == Some(signal))
            .filter_map(|row| Some([orders[row]?, amplitudes[row]?]))
            .collect()
    };
    // The unit of the column names the unit of each signal: `m (deflection) or N (force)`.
    let units = table.units()?.remove("amplitude").unwrap_or_default();

    let chosen = request.point.is_none() && results.summary.all.len() > 1;
    let loudest = if chosen { "the point with the largest deflection_rms" } else { "" };
    let words = results.point_words(point);
    let mut canvas = results.canvas("spectra over mesh orders", &[&words, loudest]);
    let signals = [("deflection", [72.0, 288.0]), ("force", [310.0, 526.0])];
    for (signal, area) in signals {
        let name = format!("{signal} amplitude");
        let is_last = signal == "force";
        panel(
            &mut canvas,
            area,
            &name,
            unit_of(&units, signal),
            &lines(signal),
            is_exact,
            is_last,
        );
    }
    let name = format!("spectrum-point{}", point.point_id);
    Ok(Drawn::one(name, canvas))
}

/// The unit of a signal, from a text such as `m (deflection) or N m (torque)`. The signal `torque pinion` is
/// a torque.
pub(super) fn unit_of<'u>(units: &'u str, signal: &str) -> &'u str {
    let of = |part: &'u str| {
        let (unit, kind) = part.strip_suffix(')')?.split_once(" (")?;
        let place = signal.strip_prefix(kind)?;
        (place.is_empty() || place.starts_with(' ')).then_some(unit)
    };
    units.split(" or ").find_map(of).unwrap_or("")
}

fn panel(
    canvas: &mut Canvas,
    [top, bottom]: [f64; 2],
    name: &str,
    unit: &str,
    lines: &[[f64; 2]],
    is_exact: bool,
    is_last: bool,
) {
    let orders = range(lines.iter().map(|[order, _]| *order))[1].min(MOST_ORDERS);
    let shown: Vec<[f64; 2]> = lines.iter().copied().filter(|l| l[0] <= orders).collect();
    let largest = shown.iter().map(|l| l[1]).fold(0.0, f64::max);
    let empty = largest <= 0.0;
    let largest = if empty { 1.0 } else { largest };
    let floor = largest * 10f64.powf(-DECADES);
    let smallest = shown.iter().map(|l| l[1]).fold(largest, f64::min);
    let low = smallest.clamp(floor, 0.1 * largest);
    // Leave room for the name of the highest peak below the upper edge.
    let part = (2.0 * NAME[1] + 8.0) / (bottom - top);
    let room = (largest / low).powf(part / (1.0 - part));
    let panel = Panel::new(
        [92.0, 920.0],
        [top, bottom],
        Axis::linear("mesh order", "1", [0.0, orders.max(1.0)]),
        Axis::logarithmic(name, unit, [low, room * largest]),
    );
    panel.frame(canvas, is_last);
    if empty {
        panel.note(canvas, "no lines above zero");
        return;
    }
    let path: Vec<Place> = shown
        .iter()
        .map(|[order, amplitude]| panel.at(*order, amplitude.max(low)))
        .collect();
    let mut peaks: Vec<[f64; 2]> = if is_exact {
        for [across, up] in &path {
            canvas.line(&[[*across, bottom], [*across, *up]], BLUE, 1.2);
        }
        shown.into_iter().filter(|line| line[1] > low).collect()
    } else {
        canvas.line(&path, BLUE, 1.2);
        tones(&shown).collect()
    };
    peaks.sort_by(|a, b| b[1].total_cmp(&a[1]));
    let mut named: Vec<f64> = Vec::new();
    for [order, amplitude] in peaks {
        let at = panel.at(order, amplitude);
        let half = 0.5 * NAME[0];
        let middle = at[0].clamp(panel.left + half + CLEAR, panel.right - half - CLEAR);
        let free = |other: &f64| (other - middle).abs() > NAME[0];
        // A name must not cover another line.
        let covers = |place: &Place| {
            (place[0] - at[0]).abs() > 1.0
                && (place[0] - middle).abs() < half
                && place[1] < at[1] - 5.0
        };
        if named.len() < MOST_NAMED && named.iter().all(free) && !path.iter().any(covers) {
            // All amplitudes are in the unit of the axis, so that peaks can be compared.
            let words = [
                format!("order {}", to_digits(order, 3)),
                panel.up.with_unit(amplitude),
            ];
            for (above, words) in words.iter().rev().enumerate() {
                let (words, size) = fitted(words, TICK_SIZE, 8.0, NAME[0] - 4.0);
                let place = [middle, at[1] - 5.0 - NAME[1] * above as f64];
                canvas.text(place, &words, size, INK, Anchor::Middle);
            }
            named.push(middle);
        }
    }
}

/// The tones: local maxima that exceed the third line on each side by a factor of two. Broad-band humps do not.
fn tones(lines: &[[f64; 2]]) -> impl Iterator<Item = [f64; 2]> {
    // The Hann window spreads a tone over two lines on each side of its peak. The third line is free of it.
    const REACH: usize = 3;
    lines.windows(2 * REACH + 1).filter_map(|around| {
        let line = around[REACH];
        let higher = |other: &[f64; 2]| line[1] >= other[1];
        let lonely = [around[0], around[2 * REACH]].map(|far| line[1] > 2.0 * far[1]);
        (around.iter().all(higher) && lonely == [true; 2]).then_some(line)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tones_are_told_from_humps() {
        let hump = |order: f64| 1.0 / (1.0 + (order - 2.0).powi(2));
        let mut lines: Vec<[f64; 2]> = (0..200)
            .map(|i| f64::from(i) / 50.0)
            .map(|order| [order, hump(order)])
            .collect();
        assert_eq!(tones(&lines).count(), 0);
        lines[50][1] = 5.0;
        let found: Vec<[f64; 2]> = tones(&lines).collect();
        assert_eq!(found, [[1.0, 5.0]]);
    }

    #[test]
    fn each_signal_finds_its_unit() {
        let units = "m (deflection) or N (force)";
        assert_eq!(unit_of(units, "deflection"), "m");
        assert_eq!(unit_of(units, "force"), "N");
        assert_eq!(unit_of(units, "sound"), "");
        let units = "N (bearing) or m/s^2 (acceleration) or rad/s^2 (angular acceleration)";
        assert_eq!(unit_of(units, "bearing pinion 1 x"), "N");
        assert_eq!(unit_of(units, "angular acceleration wheel"), "rad/s^2");
    }
}
