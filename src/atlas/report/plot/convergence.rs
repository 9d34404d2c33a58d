//! Convergence of the Lyapunov exponents of a point over the measured cycles. Each has a band of one standard
//! error.

use super::axis::{Axis, range};
use super::canvas::{Canvas, Colour, Place, SOFT};
use super::categories::colour;
use super::error::PlotError;
use super::evidence::Evidence;
use super::panel::Panel;
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::request::PlotRequest;
use super::results::Results;
use crate::report::numbers::number;
use crate::store::{ResultTable, StoreError, TableKind};
use std::collections::HashSet;

/// Largest number of exponents drawn; more would overlap.
const MOST_EXPONENTS: usize = 8;
/// Half width of a band, in standard errors.
const BAND: f64 = 1.0;

/// Whether any point has a history of its exponents.
pub(super) fn has_history(results: &Results) -> bool {
    points_with_history(results).is_ok_and(|points| !points.is_empty())
}

/// Numbers of the points with a history of their exponents.
fn points_with_history(results: &Results) -> Result<HashSet<u64>, StoreError> {
    let mut found = HashSet::new();
    let columns = ["point_id", "course_cycles"];
    ResultTable::scan(&results.folder, TableKind::Points, &columns, |part| {
        let courses = part.lists("course_cycles")?;
        for (id, course) in part.u64("point_id")?.into_iter().zip(courses) {
            found.extend(id.filter(|_| course.is_some_and(|course| !course.is_empty())));
        }
        Ok::<_, StoreError>(())
    })?;
    Ok(found)
}

pub(super) fn draw(results: &Results, request: &PlotRequest) -> Result<Drawn, PlotError> {
    let known = points_with_history(results)?;
    let ask = "add `lyapunov.course` to [analyses] of the manifest";
    let point = match request.point {
        Some(id) => results.point(id)?,
        None => {
            let mut all = results.summary.chaotic.iter().chain(&results.summary.all);
            all.find(|point| known.contains(&point.point_id))
                .ok_or_else(|| {
                    PictureKind::Convergence.unfit(format!(
                        "no point has running estimates of its exponents; {ask}"
                    ))
                })?
        }
    };
    let id = point.point_id;
    if !known.contains(&id) {
        return Err(PictureKind::Convergence.unfit(format!(
            "point {id} has no running estimates of its exponents; {ask}"
        )));
    }
    let course = Course::read(results, id)?;

    let words = results.point_words(point);
    let errors = Evidence::of([point]).words();
    let mut canvas = results.canvas("convergence of the exponents", &[&words, &errors]);
    course.draw(&mut canvas);
    let name = format!("convergence-point{}", point.point_id);
    Ok(Drawn::one(name, canvas))
}

/// A colour, mixed with three parts of white.
fn pale(Colour(red, green, blue): Colour) -> Colour {
    let [red, green, blue] = [red, green, blue].map(|part| 255 - (255 - part) / 4);
    Colour(red, green, blue)
}

/// Histories of the exponents of a point. `values` and `errors` have the largest exponent at all `cycles`,
/// then the next exponent at all `cycles`, and so on.
struct Course {
    cycles: Vec<f64>,
    values: Vec<f64>,
    errors: Vec<f64>,
}

impl Course {
    /// The history of a point; empty if it has none.
    fn read(results: &Results, id: u64) -> Result<Self, StoreError> {
        let columns = [
            "point_id",
            "course_cycles",
            "course_exponents",
            "course_stderr",
        ];
        let mut found: [Vec<f64>; 3] = Default::default();
        ResultTable::scan(&results.folder, TableKind::Points, &columns, |part| {
            let ids = part.u64("point_id")?;
            let Some(row) = ids.iter().position(|known| *known == Some(id)) else {
                return Ok(());
            };
            for (name, series) in columns[1..].iter().zip(&mut found) {
                let list = part.lists(name)?.swap_remove(row).unwrap_or_default();
                *series = (list.into_iter())
                    .map(|value| value.unwrap_or(f64::NAN))
                    .collect();
            }
            Ok::<_, StoreError>(())
        })?;
        let [cycles, values, errors] = found;
        Ok(Self {
            cycles,
            values,
            errors,
        })
    }

    fn draw(&self, canvas: &mut Canvas) {
        let places = self.cycles.len().max(1);
        let curves: Vec<(&[f64], &[f64])> = (self.values.chunks(places))
            .zip(self.errors.chunks(places))
            .take(MOST_EXPONENTS)
            .collect();
        let edges = (curves.iter())
            .flat_map(|(values, errors)| values.iter().zip(*errors))
            .flat_map(|(value, error)| [value - BAND * error, value + BAND * error]);
        let [low, high] = range(edges.chain([0.0]));
        let margin = 0.06 * (high - low).max(f64::MIN_POSITIVE);
        let last = self.cycles.last().copied().unwrap_or(1.0);
        let panel = Panel::new(
            [92.0, 700.0],
            [84.0, 526.0],
            Axis::linear("measured", "mesh cycles", [0.0, last]),
            Axis::linear(
                "Lyapunov exponents",
                "1/cycle",
                [low - margin, high + margin],
            ),
        );
        panel.frame(canvas, true);
        let zero = panel.y(0.0);
        canvas.dashes([panel.left, zero], [panel.right, zero], SOFT, 1.2);
        for (place, (values, errors)) in curves.iter().enumerate() {
            let edge = |sign: f64| -> Vec<Place> {
                let both = values.iter().zip(*errors).zip(&self.cycles);
                both.map(|((value, error), n)| panel.at(*n, value + sign * BAND * error))
                    .collect()
            };
            let mut band = edge(1.0);
            band.extend(edge(-1.0).into_iter().rev());
            canvas.polygon(&band, pale(colour(place)));
        }
        let mut line = panel.top + 12.0;
        for (place, (values, errors)) in curves.iter().enumerate() {
            let path: Vec<Place> = (values.iter().zip(&self.cycles))
                .map(|(value, n)| panel.at(*n, *value))
                .collect();
            canvas.line(&path, colour(place), 1.8);
            if let (Some(value), Some(error)) = (values.last(), errors.last()) {
                let text = format!("λ{} = {} ± {}", place + 1, number(*value), number(*error));
                canvas.label([panel.right + 14.0, line], &text, colour(place));
                line += 20.0;
            }
        }
        let left_out = (self.values.len() / places).saturating_sub(MOST_EXPONENTS);
        let note = match left_out {
            0 => "line: running mean; band: one standard error on each side".to_owned(),
            more => format!(
                "line: running mean; band: one standard error on each side; the {more} smallest are omitted"
            ),
        };
        canvas.label([panel.left, panel.top - 8.0], &note, SOFT);
    }
}
