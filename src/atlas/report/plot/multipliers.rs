//! Floquet multipliers of a point's periodic orbits in the complex plane, with the unit circle.

use std::f64::consts::TAU;

use super::axis::Axis;
use super::canvas::{Canvas, FAINT, INK, Place, SOFT};
use super::categories::colour;
use super::error::PlotError;
use super::orbits::{key, numbers, pictures};
use super::panel::{LEFT, Panel, TOP};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::request::PlotRequest;
use super::results::Results;
use crate::report::numbers::number;
use crate::report::orbits::Orbit;

/// Side of the plane \[px\].
const SIDE: f64 = 520.0;
const MARGIN: f64 = LEFT + SIDE + 28.0;

/// Smallest and largest half side of the shown part of the plane. Multipliers farther out are drawn at its
/// edge, so that the unit circle stays visible.
const EXTENT: [f64; 2] = [1.25, 4.0];

/// Half side of the shown part of the plane, divided by the modulus of the outermost multiplier.
const MARGIN_FACTOR: f64 = 1.12;

pub(super) fn draw(results: &Results, request: &PlotRequest) -> Result<Drawn, PlotError> {
    pictures(
        results,
        request,
        PictureKind::Multipliers,
        "multipliers of periodic orbits",
        |orbit| !orbit.multipliers.is_empty(),
        plane,
    )
}

fn plane(canvas: &mut Canvas, orbits: &[&Orbit]) {
    let outermost = orbits
        .iter()
        .fold(0.0_f64, |most, orbit| most.max(orbit.modulus));
    let extent = (MARGIN_FACTOR * outermost).clamp(EXTENT[0], EXTENT[1]);
    let axis = |name: &str| Axis::linear(name, "1", [-extent, extent]);
    let panel = Panel::new(
        [LEFT, LEFT + SIDE],
        [TOP, TOP + SIDE],
        axis("real part"),
        axis("imaginary part"),
    );
    let round = |radius: f64| -> Vec<Place> {
        let angles = (0..=240).map(|step| TAU * f64::from(step) / 240.0);
        let at = |angle: f64| panel.at(radius * angle.cos(), radius * angle.sin());
        angles.map(at).collect()
    };
    panel.frame(canvas, true);
    canvas.polygon(&round(1.0), FAINT);
    for [from, to] in [
        [[-extent, 0.0], [extent, 0.0]],
        [[0.0, -extent], [0.0, extent]],
    ] {
        let ends = [from, to].map(|[x, y]| panel.at(x, y));
        canvas.line(&ends, super::canvas::Colour(0xc4, 0xc4, 0xc4), 1.0);
    }
    canvas.line(&round(1.0), INK, 1.6);
    let beyond = |[re, im]: [f64; 2]| (re.abs().max(im.abs()) / extent).max(1.0);
    let inside = |multiplier: [f64; 2]| {
        let [re, im] = multiplier.map(|part| part / beyond(multiplier));
        panel.at(re, im)
    };
    for (place, orbit) in orbits.iter().enumerate() {
        for multiplier in &orbit.multipliers {
            canvas.disc(inside(*multiplier), 3.4, colour(place));
        }
    }
    let leading = (orbits.iter().enumerate()).flat_map(|(place, orbit)| {
        let places = leading(orbit).into_iter();
        places.map(move |multiplier| (place, inside(multiplier)))
    });
    numbers(canvas, &leading.collect::<Vec<_>>());
    canvas.height = TOP + SIDE + 66.0;
    key(canvas, [MARGIN, TOP + 2.0], orbits, |orbit| {
        let leading = orbit.leading_words();
        match orbit.leading {
            Some([_, im]) if im != 0.0 => format!("{leading}, modulus {}", number(orbit.modulus)),
            _ => format!("leading {leading}"),
        }
    });
    let mut notes = vec![
        "grey: inside the unit circle, stable",
        "numbers: leading multipliers",
    ];
    let mut multipliers = orbits.iter().flat_map(|orbit| &orbit.multipliers);
    if multipliers.any(|multiplier| beyond(*multiplier) > 1.0) {
        notes.push("at the edge: farther out");
    }
    for (line, note) in notes.iter().rev().enumerate() {
        canvas.label([MARGIN, TOP + SIDE - 2.0 - 18.0 * line as f64], note, SOFT);
    }
}

/// The leading multiplier, and its conjugate if it is complex.
fn leading(orbit: &Orbit) -> Vec<[f64; 2]> {
    match orbit.leading {
        None => Vec::new(),
        Some([re, 0.0]) => vec![[re, 0.0]],
        Some([re, im]) => vec![[re, im], [re, -im]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_names_multipliers_beyond_the_edge() {
        let is_noted = |multiplier: f64| {
            let orbit = Orbit {
                point_id: 0,
                period: 1,
                state: None,
                stable: false,
                modulus: multiplier,
                leading: Some([multiplier, 0.0]),
                bifurcation: None,
                grazing_margin: None,
                kick_growth: None,
                kick_growth_linear: None,
                multipliers: vec![[multiplier, 0.0]],
                kick: [Vec::new(), Vec::new()],
            };
            let mut canvas = Canvas::titled("", "");
            plane(&mut canvas, &[&orbit]);
            canvas.texts().any(|text| text.contains("farther out"))
        };
        assert_eq!([1.1, 3.8, 4.2].map(is_noted), [false, false, true]);
    }
}
