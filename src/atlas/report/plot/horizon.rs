//! Predictability of one chaotic point: separation of twin trajectories (left), and standard errors of
//! averages (right).

use super::axis::{Axis, range};
use super::canvas::{Anchor, BLUE, Canvas, Colour, INK, Place, RED, SOFT};
use super::error::PlotError;
use super::panel::{BOTTOM, Panel, TICK_SIZE};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::request::PlotRequest;
use super::results::Results;
use crate::report::PointSummary;
use crate::report::numbers::number;
use crate::store::{ResultTable, StoreError, TableKind};

const TOP: f64 = 84.0;
/// Smallest number of averaged cycles for the power law of standard errors; shorter averages are correlated.
const POWER_LAW_FROM: f64 = 10.0;
/// Colour of the band of the separations of single twins.
const BAND: Colour = Colour(0xd6, 0xe4, 0xf2);

/// Columns of points.parquet.
const OF_POINT: [&str; 4] = [
    "horizon",
    "horizon_stderr",
    "saturation",
    "averaging_exponent",
];

/// A quantity over time: mesh cycles, value, spread.
type Curve = Vec<[f64; 3]>;

pub(super) fn draw(results: &Results, request: &PlotRequest) -> Result<Drawn, PlotError> {
    let table = results.needed(TableKind::Horizon, PictureKind::Horizon)?;
    let ids = table.u64("point_id")?;
    let known = |point: &PointSummary| ids.binary_search(&Some(point.point_id)).is_ok();
    let point = match request.point {
        Some(id) => results.point(id)?,
        None => (results.summary.chaotic.iter().find(|p| known(p)))
            .ok_or_else(|| PictureKind::Horizon.unfit("horizon.parquet has no chaotic point"))?,
    };
    if !known(point) {
        let reason = format!("point {} is not chaotic or has no horizon", point.point_id);
        return Err(PictureKind::Horizon.unfit(reason));
    }
    let data = PointData::read(results, &table, point)?;

    let several = results.summary.chaotic.len() > 1;
    let chosen = if request.point.is_none() && several { "the most chaotic point" } else { "" };
    let words = results.point_words(point);
    let mut canvas = results.canvas("from trajectories to averages", &[&words, chosen]);
    separations(&mut canvas, &data);
    averages(&mut canvas, &data);
    let name = format!("horizon-point{}", point.point_id);
    Ok(Drawn::one(name, canvas))
}

/// The data of a point from the tables.
struct PointData {
    separation: Curve,
    /// Averages of the contact force and of the mesh force: name, curve, and the power p of the expected
    /// decay n⁻ᵖ of the standard error with the number n of cycles.
    averages: [(&'static str, Curve, f64); 2],
    lambda: Option<f64>,
    horizon: Option<f64>,
    stderr: Option<f64>,
    saturation: Option<f64>,
    exponent: Option<f64>,
}

impl PointData {
    fn read(
        results: &Results,
        table: &ResultTable,
        point: &PointSummary,
    ) -> Result<Self, PlotError> {
        let ids = table.u64("point_id")?;
        let (quantities, cycles) = (table.text("quantity")?, table.u64("cycles")?);
        let (values, spreads) = (table.f64("value")?, table.f64("spread")?);
        let curve = |quantity: &str| -> Curve {
            (0..table.rows())
                .filter(|&row| ids[row] == Some(point.point_id))
                .filter(|&row| quantities[row].as_deref() == Some(quantity))
                .filter_map(|row| Some([cycles[row]? as f64, values[row]?, spreads[row]?]))
                .collect()
        };
        let mut numbers = [None; OF_POINT.len()];
        let columns = [&["point_id"][..], &OF_POINT].concat();
        ResultTable::scan(&results.folder, TableKind::Points, &columns, |part| {
            let row = part
                .u64("point_id")?
                .into_iter()
                .position(|id| id == Some(point.point_id));
            if let Some(row) = row {
                for (number, column) in numbers.iter_mut().zip(OF_POINT) {
                    *number = part.f64(column)?[row];
                }
            }
            Ok::<_, StoreError>(())
        })?;
        let [horizon, stderr, saturation, exponent] = numbers;
        Ok(Self {
            separation: curve("separation"),
            averages: [
                ("contact force", curve("contact_force"), 0.5),
                ("mesh force", curve("force"), 1.0),
            ],
            lambda: point.lambda,
            horizon,
            stderr,
            saturation,
            exponent,
        })
    }
}

/// Draws the separation of twins over time, a line with the slope of the exponent, and the horizon.
fn separations(canvas: &mut Canvas, data: &PointData) {
    let curve = &data.separation;
    let [low, high] = range(
        curve
            .iter()
            .flat_map(|[_, value, spread]| [value * (-spread).exp(), value * spread.exp()]),
    );
    let last = curve.last().map_or(1.0, |[cycles, ..]| *cycles).max(1.0);
    let panel = Panel::new(
        [92.0, 478.0],
        [TOP, BOTTOM],
        Axis::linear("time", "mesh cycles", [0.0, last]),
        Axis::logarithmic("separation of twins", "half gaps", [0.5 * low, 12.0 * high]),
    );
    let edge = |sign: f64| -> Vec<Place> {
        let edge = curve.iter();
        edge.map(|[n, value, spread]| panel.at(*n, value * (sign * spread).exp()))
            .collect()
    };
    let mut band = edge(1.0);
    band.extend(edge(-1.0).into_iter().rev());
    panel.frame(canvas, true);
    canvas.polygon(&band, BAND);
    let path: Vec<Place> = curve
        .iter()
        .map(|[n, value, _]| panel.at(*n, *value))
        .collect();
    canvas.line(&path, BLUE, 2.0);

    if let Some(level) = data.saturation {
        let y = panel.y(level);
        canvas.dashes([panel.left, y], [panel.right, y], SOFT, 1.2);
        let text = format!("unrelated states: {} half gaps", number(level));
        let at = [panel.right - 8.0, y - 22.0];
        canvas.text(at, &text, TICK_SIZE, SOFT, Anchor::End);
    }
    // The lower right corner is empty: separations grow.
    let mut corner = BOTTOM - 14.0;
    let mut say = |canvas: &mut Canvas, text: String, colour: Colour| {
        let at = [panel.right - 10.0, corner];
        canvas.text(at, &text, TICK_SIZE, colour, Anchor::End);
        corner -= 20.0;
    };
    if let Some(horizon) = data.horizon {
        let x = panel.x(horizon);
        canvas.dashes([x, panel.top], [x, panel.bottom], RED, 1.4);
        let doubt = (data.stderr).map_or(String::new(), |e| format!(" ± {e:.1}"));
        say(canvas, format!("horizon {horizon:.1}{doubt} cycles"), RED);
    }
    if let (Some(lambda), Some(horizon)) = (data.lambda, data.horizon) {
        // The line with the slope of λ goes through the separation at half the horizon.
        if let Some([n, value, _]) = curve.get((0.5 * horizon) as usize) {
            let at = |cycles: f64| value * (lambda * (cycles - n)).exp();
            let start = (n + (low / value).ln() / lambda).max(0.0);
            let end = n + (3.0 * high / value).ln() / lambda;
            let [from, to] = [start, end.min(last)].map(|x| panel.at(x, at(x)));
            canvas.dashes(from, to, INK, 1.4);
            let text = format!("dashes: λ = {} per cycle", number(lambda));
            say(canvas, text, INK);
        }
    }
    let note = "blue: geometric mean, band: one standard deviation of a twin";
    canvas.label([panel.left, TOP - 8.0], note, SOFT);
}

/// Draws the standard errors of mean forces over the number of averaged cycles.
fn averages(canvas: &mut Canvas, data: &PointData) {
    let all = || data.averages.iter().flat_map(|(_, curve, _)| curve);
    let [low, high] = range(all().map(|p| p[2]).filter(|spread| *spread > 0.0));
    let last = all().map(|p| p[0]).fold(2.0, f64::max);
    let panel = Panel::new(
        [582.0, 926.0],
        [TOP, BOTTOM],
        Axis::logarithmic("cycles averaged", "mesh cycles", [0.8, 1.25 * last]),
        Axis::logarithmic(
            "standard error of a mean force",
            "N",
            [0.5 * low, 4.0 * high],
        ),
    );
    panel.frame(canvas, true);
    let mut line = TOP + 20.0;
    for ((name, curve, power), colour) in data.averages.iter().zip([BLUE, RED]) {
        let points: Vec<&[f64; 3]> = curve.iter().filter(|p| p[2] > 0.0).collect();
        let long: Vec<f64> = (points.iter().filter(|p| p[0] >= POWER_LAW_FROM))
            .map(|p| (p[2] * p[0].powf(*power)).ln())
            .collect();
        if !long.is_empty() {
            let level = (long.iter().sum::<f64>() / long.len() as f64).exp();
            let [a, b] = [POWER_LAW_FROM, last].map(|n| panel.at(n, level * n.powf(-power)));
            canvas.dashes(a, b, colour, 1.4);
        }
        for [n, _, spread] in &points {
            canvas.disc(panel.at(*n, *spread), 4.0, colour);
        }
        let Some([n, mean, spread]) = points.last() else {
            continue;
        };
        let share = 100.0 * spread / mean.abs();
        let text = format!(
            "{name}: {share:.1} % of {} N over {n} cycles",
            number(*mean)
        );
        let at = [panel.right - 10.0, line];
        canvas.text(at, &text, TICK_SIZE, colour, Anchor::End);
        line += 18.0;
    }
    let fitted = data.exponent.map_or(String::new(), |exponent| {
        format!(" (fitted {})", format!("{exponent:.2}").replace('-', "−"))
    });
    let note = format!("dashes: powers −1/2{fitted} and −1");
    canvas.label([panel.left, TOP - 8.0], &note, SOFT);
}
