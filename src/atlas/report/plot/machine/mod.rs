//! Pictures of the measurements of a machine: the memory mountain, the bandwidth over threads, the scaling of the
//! integration, and the roofline.

mod bandwidth;
mod mountain;
mod roofline;
mod solver;

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Colour, SOFT};
use super::lettering::spread_out;
use super::panel::{Panel, TICK_SIZE};
use super::picture::Picture;
use crate::report::size_text;
use crate::store::Characteristics;

/// Pictures of all measurements.
pub fn pictures(machine: &Characteristics) -> Vec<Picture> {
    let draw = [
        mountain::draw,
        bandwidth::draw,
        solver::draw,
        roofline::draw,
    ];
    draw.iter().filter_map(|draw| draw(machine)).collect()
}

/// Smallest distance of two labels \[px\].
const LABEL_STEP: f64 = 16.0;

/// A curve with its name.
struct Curve {
    name: String,
    colour: Colour,
    places: Vec<[f64; 2]>,
}

/// A canvas with a title. The line below it has the machine, the day, and a note if the machine was not quiet.
fn titled(title: &str, machine: &Characteristics) -> Canvas {
    let mut parts = vec![machine.host.clone(), machine.description.cpu.clone()];
    parts.push(machine.started.chars().take(10).collect());
    if !machine.noise.quiet {
        parts.push("machine not quiet".to_owned());
    }
    Canvas::titled(title, &parts.join("  ·  "))
}

/// Draws curves with a disc at each place, and their names to the right of the panel.
fn draw_curves(canvas: &mut Canvas, panel: &Panel, curves: &[Curve]) {
    for curve in curves {
        let path: Vec<_> = curve.places.iter().map(|p| panel.at(p[0], p[1])).collect();
        canvas.line(&path, curve.colour, 1.8);
        path.iter()
            .for_each(|&at| canvas.disc(at, 2.6, curve.colour));
    }
    let ends = curves.iter().filter_map(|curve| {
        let last = curve.places.last()?;
        Some((panel.y(last[1]), curve.name.as_str(), curve.colour))
    });
    name_ends(canvas, panel, ends.collect());
}

/// Writes names to the right of a panel, near their heights and without overlap. A line connects each name to
/// its height.
fn name_ends(canvas: &mut Canvas, panel: &Panel, mut ends: Vec<(f64, &str, Colour)>) {
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted: Vec<f64> = ends.iter().map(|(y, ..)| *y).collect();
    let places = spread_out(&wanted, LABEL_STEP, [panel.top, panel.bottom]);
    for ((y, name, colour), place) in ends.into_iter().zip(places) {
        let from = [panel.right + 3.0, y];
        let to = [panel.right + 14.0, place];
        canvas.line(&[from, to], colour, 1.0);
        canvas.label([panel.right + 18.0, place + 0.35 * TICK_SIZE], name, colour);
    }
}

/// Draws dashed lines at the sizes of the caches that lie in a panel, with the names of the caches above it.
fn mark_caches(canvas: &mut Canvas, panel: &Panel, machine: &Characteristics) {
    for cache in &machine.description.caches {
        let size = cache.size as f64;
        if !(0.0..=1.0).contains(&panel.across.fraction(size)) {
            continue;
        }
        let x = panel.x(size);
        canvas.dashes([x, panel.top], [x, panel.bottom], SOFT, 1.2);
        let text = format!(
            "L{} {}",
            cache.level,
            size_text(cache.size).replacen(".0 ", " ", 1)
        );
        canvas.text([x, panel.top - 6.0], &text, TICK_SIZE, SOFT, Anchor::Middle);
    }
}

/// A logarithmic axis over the second coordinates of all curves, with a margin.
fn logarithmic<'c>(name: &str, unit: &str, curves: impl Iterator<Item = &'c Curve>) -> Axis {
    let values = curves.flat_map(|curve| curve.places.iter().map(|p| p[1]));
    let [low, high] = super::axis::range(values);
    Axis::logarithmic(name, unit, [low / 1.3, high * 1.3])
}

/// An axis of bytes over the first coordinates of all curves, with a margin.
fn sizes<'c>(name: &str, curves: impl Iterator<Item = &'c Curve>) -> Axis {
    let values = curves.flat_map(|curve| curve.places.iter().map(|p| p[0]));
    let [low, high] = super::axis::range(values);
    Axis::bytes(name, [low / 1.2, high * 1.2])
}

/// Names of the levels of memory, with the bandwidth of one thread that reads consecutive cache lines
/// \[B/s\].
fn levels(machine: &Characteristics) -> Vec<(String, f64)> {
    let near = |size: u64| {
        let rows = machine.mountain.iter().filter(|row| row.key.stride == 64);
        rows.min_by(|a, b| {
            let far = |bytes: u64| (bytes as f64 / size as f64).ln().abs();
            far(a.key.size).total_cmp(&far(b.key.size))
        })
    };
    let places = crate::report::machine_page::levels(machine);
    (places.into_iter())
        .filter_map(|(name, size)| Some((name, near(size)?.figure.value)))
        .collect()
}

#[cfg(test)]
mod tests;
