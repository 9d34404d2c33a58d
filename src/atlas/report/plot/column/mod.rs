//! Pictures of any column of numbers: curves over one axis, or a map over two axes. A picture with curves can
//! compare several columns, several values of a second axis and several results folders.

mod curves;
mod labelled;
mod map;
mod measured;
mod orders;
mod plan;
mod request;
mod series;
mod style;

use super::display::Unit;
use super::error::PlotError;
use super::picture::Drawn;
use super::request::PlotRequest;
use super::results::Results;
use crate::store::TableKind;

pub(super) use measured::completed;
pub(super) use orders::draw as draw_orders;
pub(super) use request::nearest;
pub use request::{ColumnName, NoColumn, PictureRequest};
pub(super) use series::{SUBORDERS, Series, listed};

/// A results folder with its name in a picture.
pub(super) struct Source<'a> {
    pub name: String,
    pub results: &'a Results,
}

/// Gives results folders names that differ: their jobs or, if some of these are equal, the last parts of
/// their paths, else their whole paths.
pub(super) fn named<'a>(all: &[&'a Results]) -> Vec<Source<'a>> {
    let last = |results: &Results| match results.folder.file_name() {
        Some(name) => name.to_string_lossy().into_owned(),
        None => results.folder.display().to_string(),
    };
    let namings: [&dyn Fn(&Results) -> String; 3] =
        [&|results| results.job.clone(), &last, &|results| {
            results.folder.display().to_string()
        }];
    let names = namings
        .iter()
        .map(|naming| -> Vec<String> { all.iter().map(|results| naming(results)).collect() });
    let mut names: Vec<Vec<String>> = names.collect();
    let distinct = |names: &Vec<String>| {
        (names.iter().enumerate()).all(|(i, name)| !name.is_empty() && !names[..i].contains(name))
    };
    let place = names.iter().position(distinct).unwrap_or(names.len() - 1);
    let chosen = names.swap_remove(place);
    (chosen.into_iter().zip(all.iter().copied()))
        .map(|(name, results)| Source { name, results })
        .collect()
}

/// Draws columns, as [`draw_series`] does.
///
/// # Errors
/// A column, an axis or an element does not exist, or a requested unit does not fit.
pub(super) fn draw(
    sources: &[Source<'_>],
    columns: &[ColumnName],
    request: &PlotRequest,
) -> Result<Drawn, PlotError> {
    let mut read = Vec::new();
    for column in columns {
        let mut of_source = Vec::new();
        for source in sources {
            of_source.push(series::read(source.results, column)?);
        }
        read.push(of_source);
    }
    // `all` has the series of all columns for each source.
    let all: Vec<Vec<Series>> = (0..sources.len())
        .map(|source| {
            read.iter_mut()
                .flat_map(|column| std::mem::take(&mut column[source]))
                .collect()
        })
        .collect();
    draw_series(sources, all, request)
}

/// Draws the RMS of the deflection. Draws nothing if no axis varies, if no point has a value, or if a
/// requested unit belongs to another quantity.
///
/// # Errors
/// The table cannot be read, or an axis does not exist.
pub(super) fn draw_deflection_rms(
    results: &Results,
    request: &PlotRequest,
) -> Result<Drawn, PlotError> {
    let column = ColumnName {
        table: TableKind::Points,
        name: "deflection_rms".to_owned(),
        element: None,
    };
    if results.varied().is_empty() || !results.units.contains_key(&column.name) {
        return Ok(Drawn::default());
    }
    let series = series::read(results, &column)?;
    let mut points = 0..results.summary.all.len();
    if !points.any(|point| series.iter().any(|shown| shown.one(point).is_some())) {
        return Ok(Drawn::default());
    }
    match draw_series(&named(&[results]), vec![series], request) {
        Err(PlotError::OtherUnit { .. } | PlotError::UnusedUnit { .. }) => Ok(Drawn::default()),
        drawn => drawn,
    }
}

/// Draws series; `all` has a list per source. One source with two varying axes and one value per point gets maps, one
/// per series and slice, unless the request names an axis. All else gets curves, in one picture per unit and slice.
pub(super) fn draw_series(
    sources: &[Source<'_>],
    mut all: Vec<Vec<Series>>,
    request: &PlotRequest,
) -> Result<Drawn, PlotError> {
    for unit in &request.display.units {
        let axes = sources
            .iter()
            .flat_map(|source| &source.results.summary.axes);
        let values = all.iter().flatten().map(|series| &series.unit);
        let mut known: Vec<&String> = axes.map(|axis| &axis.unit).chain(values).collect();
        known.sort();
        known.dedup();
        if known.iter().all(|si| Unit::of(unit, si).is_none()) {
            let known: Vec<&str> = known.iter().map(|si| si.as_str()).collect();
            return Err(PlotError::UnusedUnit {
                unit: unit.clone(),
                drawn: known.join(", "),
            });
        }
    }
    let mut drawn = Drawn::default();
    if let ([source], [series]) = (sources, &all[..])
        && request.over.is_none()
        && request.by.is_none()
        && let Some(cells) = super::cells::Cells::new(source.results)
        && series.iter().all(|series| !series.scattered)
    {
        for series in series {
            drawn.append(map::draw(source.results, &cells, series, request)?);
        }
        return Ok(drawn);
    }
    while let Some(unit) = all
        .iter()
        .flatten()
        .map(|series| series.unit.clone())
        .next()
    {
        let group: Vec<Vec<Series>> = (all.iter_mut())
            .map(|series| {
                series
                    .extract_if(.., |series| series.unit == unit)
                    .collect()
            })
            .collect();
        drawn.append(curves::draw(sources, &group, request)?);
    }
    Ok(drawn)
}
