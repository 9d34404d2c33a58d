//! Order cuts: amplitudes of chosen mesh orders over an axis.

use super::series::{Sample, Samples, Series};
use super::{Source, draw_series};
use crate::report::numbers::number;
use crate::report::plot::error::PlotError;
use crate::report::plot::picture::Drawn;
use crate::report::plot::picture_kind::PictureKind;
use crate::report::plot::request::{DEFAULT_ORDERS, PlotRequest};
use crate::report::plot::spectral::SpectralLines;

/// Draws the amplitudes of the requested orders, or of the [`DEFAULT_ORDERS`].
///
/// # Errors
/// The signal has no spectral lines, or none as high as an order.
pub(in crate::report::plot) fn draw(
    sources: &[Source<'_>],
    request: &PlotRequest,
) -> Result<Drawn, PlotError> {
    let orders = match &request.orders[..] {
        [] => &DEFAULT_ORDERS[..],
        orders => orders,
    };
    let mut all = Vec::new();
    for source in sources {
        let spectral_lines =
            SpectralLines::read(source.results, PictureKind::Orders, request.signal())?;
        let mut series = Vec::new();
        for &order in orders {
            if !spectral_lines.reach(order) {
                return Err(PictureKind::Orders.unfit(format!(
                    "the spectra do not reach mesh order {}",
                    number(order)
                )));
            }
            let sample = |value: f64| Sample { value, error: 0.0 };
            let places = 0..spectral_lines.lines.len();
            series.push(Series {
                name: spectral_lines.name.clone(),
                part: format!("mesh order {}", number(order)),
                unit: spectral_lines.unit.clone(),
                scattered: false,
                samples: Samples::new(
                    (places.clone())
                        .filter_map(|place| Some((place, sample(spectral_lines.at(place, order)?))))
                        .collect(),
                    places.len(),
                ),
            });
        }
        all.push(series);
    }
    draw_series(sources, all, request)
}
