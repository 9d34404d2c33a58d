//! The common parts of pictures of periodic orbits: the selection of points, and the key.

use super::canvas::{Anchor, Canvas, Colour, INK, Place, SOFT, WHITE};
use super::categories::colour;
use super::error::PlotError;
use super::picture::{Drawn, Picture};
use super::picture_kind::PictureKind;
use super::request::PlotRequest;
use super::results::{MOST_SLICES, Results};
use crate::report::orbits::Orbit;

/// Largest number of entries in a key, and the height of one entry \[px\].
const MOST_ENTRIES: usize = 11;
const ENTRY: f64 = 42.0;

/// Draws one picture per point with orbits that are `drawable`, or only that of the requested point.
pub(super) fn pictures(
    results: &Results,
    request: &PlotRequest,
    what: PictureKind,
    title: &str,
    drawable: impl Fn(&Orbit) -> bool,
    draw: impl Fn(&mut Canvas, &[&Orbit]),
) -> Result<Drawn, PlotError> {
    let orbits = results.summary.orbits.as_ref().ok_or_else(|| {
        what.unfit("there is no orbits.parquet; add `orbits = {}` to [analyses] of the manifest")
    })?;
    let mut ids: Vec<u64> = (orbits.orbits.iter())
        .filter(|orbit| drawable(orbit))
        .map(|orbit| orbit.point_id)
        .collect();
    ids.dedup();
    if let Some(id) = request.point {
        results.point(id)?;
        ids.retain(|known| *known == id);
    }
    if ids.is_empty() {
        return Err(what.unfit(match what {
            PictureKind::Multipliers => {
                "no orbit with multipliers was found; set analyses.orbits.floquet = true to keep them"
            }
            _ => "no orbit was found",
        }));
    }
    let mut drawn = Drawn::sliced(what.name(), ids.len().min(MOST_SLICES), ids.len());
    for &id in ids.iter().take(MOST_SLICES) {
        let of_point: Vec<&Orbit> = (orbits.orbits.iter())
            .filter(|orbit| orbit.point_id == id && drawable(orbit))
            .collect();
        let words = results.point_words(results.point(id)?);
        let mut canvas = results.canvas(title, &[&words]);
        draw(&mut canvas, &of_point);
        let name = match results.summary.all.len() {
            1 => what.name().to_owned(),
            _ => format!("{}-point={id}", what.name()),
        };
        drawn.pictures.push(Picture::new(name, canvas));
    }
    Ok(drawn)
}

/// Draws the key: the orbits with their numbers, from a place down. `second` gives the second line of an
/// entry.
pub(super) fn key(
    canvas: &mut Canvas,
    at: Place,
    orbits: &[&Orbit],
    second: impl Fn(&Orbit) -> String,
) {
    let mut y = at[1];
    for (place, orbit) in orbits.iter().enumerate().take(MOST_ENTRIES) {
        numbered(canvas, [at[0] + 9.0, y + 9.0], place);
        let stable = if orbit.stable { "stable" } else { "unstable" };
        let name = format!("period {}, {stable}", orbit.period);
        let text = [at[0] + 26.0, y + 8.0];
        canvas.label(text, &name, INK);
        let below = [text[0], y + 25.0];
        canvas.label(below, &second(orbit), SOFT);
        y += ENTRY;
    }
    if orbits.len() > MOST_ENTRIES {
        let text = format!("… and {} more", orbits.len() - MOST_ENTRIES);
        canvas.label([at[0], y + 8.0], &text, SOFT);
    }
}

/// Distance between the centres of two numbers \[px\].
const NUMBER_DISTANCE: f64 = 20.0;

/// Writes the numbers of orbits at their places. A number whose place is taken moves up or down, and a line
/// connects it to its place. Entries at the beginning of the list move least.
pub(super) fn numbers(canvas: &mut Canvas, wanted: &[(usize, Place)]) {
    let mut taken: Vec<Place> = Vec::new();
    for (_, wanted) in wanted {
        let free = |at: &Place| {
            let is_distinct =
                |other: &Place| (at[0] - other[0]).hypot(at[1] - other[1]) >= NUMBER_DISTANCE;
            taken.iter().all(is_distinct)
        };
        let steps =
            (0..=2 * taken.len()).flat_map(|step| [-0.5, 0.5].map(|side| side * step as f64));
        let places = steps.map(|step| [wanted[0], wanted[1] + NUMBER_DISTANCE * step]);
        let place = { places }.find(free).unwrap_or(*wanted);
        canvas.line(&[*wanted, place], SOFT, 1.0);
        taken.push(place);
    }
    for ((number, _), at) in wanted.iter().zip(&taken) {
        numbered(canvas, *at, *number);
    }
}

/// Draws a disc in the colour of an orbit, with the number of the orbit, from 1.
fn numbered(canvas: &mut Canvas, centre: Place, place: usize) {
    canvas.disc(centre, 9.5, WHITE);
    canvas.disc(centre, 8.5, colour(place));
    let Colour(red, green, blue) = colour(place);
    // The luminance of the colour decides between dark and white text.
    let light = 0.3 * f64::from(red) + 0.6 * f64::from(green) + 0.1 * f64::from(blue) > 130.0;
    let ink = if light { INK } else { WHITE };
    let text = (place + 1).to_string();
    let size = if text.len() > 1 { 9.0 } else { 11.0 };
    let at = [centre[0], centre[1] + 0.36 * size];
    canvas.text(at, &text, size, ink, Anchor::Middle);
}
