//! Basin shares over one axis: a colour a branch, with 95 % intervals.

use std::collections::BTreeMap;

use super::axis::{Axis, range};
use super::canvas::{Anchor, Canvas, INK, SOFT};
use super::categories::colour;
use super::error::PlotError;
use super::over_axis::across;
use super::panel::{Panel, TICK_SIZE};
use super::picture::{Drawn, Picture};
use super::results::Results;
use super::what::What;
use crate::report::PointSummary;
use crate::report::branches::{Attractor, branches, read_attractors};

const LEFT: f64 = 92.0;
const RIGHT: f64 = 690.0;
const MARGIN: f64 = RIGHT + 24.0;
/// Half the width of the ends of whiskers \[px\].
const WHISKER: f64 = 3.0;
/// Sideways distance of branches at one point \[px\]: whiskers must not cover each other.
const APART: f64 = 7.0;
/// Most entries of the key.
const MOST_ENTRIES: usize = 10;

/// Draws the shares of every slice of the grid.
pub(super) fn draw(results: &Results, along: usize) -> Result<Drawn, PlotError> {
    let attractors = read_attractors(&results.folder)?;
    if attractors.is_empty() {
        return Err(PlotError::Unfit {
            what: What::Shares,
            reason: "there is no attractor; ask for `multistability` in the manifest's [analyses]"
                .into(),
        });
    }
    let summary = &results.summary;
    let followed = branches(&attractors, &summary.all, &summary.axes, along);
    let name = &summary.axes[along].name;
    let (slices, all) = results.slices(&[along]);
    let mut drawn = Drawn::of_slices(What::Shares, slices.len(), all);
    for slice in slices {
        let title = format!("{}: basin shares over {name}", results.job);
        let mut canvas = Canvas::titled(&title, &results.subtitle(&[&slice.words]));
        // A slice counts its own branches from 0, for the colours.
        let mut own: BTreeMap<usize, Vec<(&PointSummary, &Attractor)>> = BTreeMap::new();
        for (attractor, branch) in attractors.iter().zip(&followed) {
            let point = slice
                .points
                .iter()
                .find(|p| p.point_id == attractor.point_id);
            if let Some(point) = point {
                own.entry(*branch).or_default().push((point, attractor));
            }
        }
        let panel = Panel {
            left: LEFT,
            right: RIGHT,
            top: 72.0,
            bottom: 526.0,
            across: across(results, along),
            up: Axis::linear("share of probes", "1", [-0.03, 1.03]),
        };
        panel.frame(&mut canvas, true);
        for (place, line) in own.values().enumerate() {
            draw_branch(&mut canvas, &panel, along, place, own.len(), line);
        }
        key(&mut canvas, along, &own);
        let name = format!("shares{}", slice.suffix);
        drawn.pictures.push(Picture::new(name, canvas));
    }
    Ok(drawn)
}

fn draw_branch(
    canvas: &mut Canvas,
    panel: &Panel,
    along: usize,
    place: usize,
    count: usize,
    line: &[(&PointSummary, &Attractor)],
) {
    // Branches that are far apart in number seldom meet at one point: a few lanes do.
    let lanes = count.min(4);
    let aside = APART * ((place % 4) as f64 - 0.5 * (lanes - 1) as f64);
    let x = |point: &PointSummary| panel.x(point.axis_values[along]) + aside;
    let dots: Vec<_> = line
        .iter()
        .map(|(point, attractor)| [x(point), panel.y(attractor.share)])
        .collect();
    canvas.line(&dots, colour(place), 1.6);
    for ((point, attractor), dot) in line.iter().zip(dots) {
        let x = x(point);
        let [low, high] = attractor.interval.map(|share| panel.y(share));
        canvas.line(&[[x, low], [x, high]], SOFT, 1.0);
        for y in [low, high] {
            canvas.line(&[[x - WHISKER, y], [x + WHISKER, y]], SOFT, 1.0);
        }
        canvas.disc(dot, 5.0, INK);
        canvas.disc(dot, 4.0, colour(place));
    }
}

/// Names of the branches: their kinds of motion, in the order met.
fn key(canvas: &mut Canvas, along: usize, own: &BTreeMap<usize, Vec<(&PointSummary, &Attractor)>>) {
    let at = [MARGIN, 84.0];
    canvas.text(
        at,
        "branches; bars: 95 % interval",
        TICK_SIZE,
        SOFT,
        Anchor::Start,
    );
    let mut y = 98.0;
    for (place, line) in own.values().take(MOST_ENTRIES).enumerate() {
        let mut line = line.clone();
        line.sort_by(|a, b| a.0.axis_values[along].total_cmp(&b.0.axis_values[along]));
        let mut kinds: Vec<String> = line.iter().map(|(_, attractor)| attractor.kind()).collect();
        kinds.dedup();
        let mut words = kinds.join(" → ");
        if kinds.len() > 3 {
            let [first, last] = [&kinds[0], &kinds[kinds.len() - 1]];
            words = format!("{first} → … → {last}");
        }
        let rms = range(
            line.iter()
                .filter_map(|(_, attractor)| attractor.deflection_rms),
        );
        let [low, high] = rms.map(|rms| format!("{:.1}", 1e6 * rms));
        let span = if low == high {
            low
        } else {
            format!("{low} … {high}")
        };
        let points = match line.len() {
            1 => "1 point".to_owned(),
            count => format!("{count} points"),
        };
        let numbers = format!("{points}, RMS {span} µm");
        canvas.disc([MARGIN + 7.0, y + 7.0], 6.0, INK);
        canvas.disc([MARGIN + 7.0, y + 7.0], 5.0, colour(place));
        let texts = [(words, 12.0, INK), (numbers, 28.0, SOFT)];
        for (text, down, ink) in texts {
            let at = [MARGIN + 21.0, y + down];
            canvas.text(at, &text, TICK_SIZE, ink, Anchor::Start);
        }
        y += 40.0;
    }
    if own.len() > MOST_ENTRIES {
        let text = format!("… and {} more", own.len() - MOST_ENTRIES);
        canvas.text([MARGIN, y + 12.0], &text, TICK_SIZE, SOFT, Anchor::Start);
    }
}
