//! Measured points in a picture of columns.

use super::plan::{Curve, Dot};
use super::request::{ColumnName, PictureRequest};
use crate::manifest::{Measured, MeasuredColumn};
use crate::report::Axis;
use crate::report::plot::display::Scale;
use crate::report::plot::error::PlotError;
use crate::report::plot::request::PlotRequest;

/// Completes a request from the measured points: with their column if the request names no picture or column, and
/// with their axis if the request names no axis.
///
/// # Errors
/// The requested columns do not include the column of the measured points.
pub(in crate::report::plot) fn completed(request: &PlotRequest) -> Result<PlotRequest, PlotError> {
    let mut request = request.clone();
    let Some(measured) = &request.measured else {
        return Ok(request);
    };
    let column = named(measured)?;
    if request.what.is_empty() {
        request.what.push(PictureRequest::Column(column.clone()));
    }
    let drawn = |asked: &PictureRequest| matches!(asked, PictureRequest::Column(col) if col.whole() == column.whole());
    if !request.what.iter().any(drawn) {
        return Err(unnamed(measured));
    }
    request.over.get_or_insert(measured.axis.name.clone());
    Ok(request)
}

/// The measured points of a picture, as marks; `None` if they belong to another column.
///
/// # Errors
/// The points are over another axis, or their unit does not fit.
pub(super) fn marks(
    measured: &Measured,
    names: &[&str],
    si: &str,
    over: &Axis,
    scale: &Scale,
) -> Result<Option<Curve>, PlotError> {
    if !names.contains(&&*named(measured)?.whole().to_string()) {
        return Ok(None);
    }
    if measured.axis.name != over.name {
        return Err(PlotError::MeasuredAxis {
            file: measured.path.clone(),
            column: measured.axis.name.clone(),
            over: over.name.clone(),
        });
    }
    let in_si = |column: &MeasuredColumn, si: &str| {
        column.in_si(si).ok_or_else(|| PlotError::MeasuredUnit {
            file: measured.path.clone(),
            column: column.name.clone(),
            unit: column.unit.clone().unwrap_or_default(),
            si: si.to_owned(),
        })
    };
    let values = in_si(&measured.value, si)?;
    let errors = match &measured.stderr {
        Some(stderr) => in_si(stderr, si)?,
        None => vec![0.0; values.len()],
    };
    let mut curve = Curve {
        scattered: true,
        barred: errors.iter().any(|error| *error > 0.0),
        ..Curve::default()
    };
    for ((x, value), error) in in_si(&measured.axis, &over.unit)?
        .into_iter()
        .zip(values)
        .zip(errors)
    {
        if let Some(shown) = scale.shown(value) {
            let [low, high] = scale.bar(value, error);
            curve.dots.push(Dot {
                x,
                low,
                value: shown,
                high,
                marked: None,
            });
        }
    }
    Ok(Some(curve))
}

/// The column to which the measured points belong.
fn named(measured: &Measured) -> Result<ColumnName, PlotError> {
    match measured.value.name.parse() {
        Ok(PictureRequest::Column(column)) => Ok(column),
        _ => Err(unnamed(measured)),
    }
}

fn unnamed(measured: &Measured) -> PlotError {
    PlotError::MeasuredValue {
        file: measured.path.clone(),
        column: measured.value.name.clone(),
    }
}
