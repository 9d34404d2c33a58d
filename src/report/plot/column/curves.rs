//! Columns over one axis: a curve a column, a value of a second axis and a results folder.

use std::collections::BTreeMap;

use super::Source;
use super::map::file_part;
use super::series::Series;
use super::style::Style;
use crate::report::plot::axis::{Axis, range};
use crate::report::plot::canvas::{Anchor, Canvas, INK, Place, SOFT};
use crate::report::plot::display::{Log, Scale};
use crate::report::plot::draw::text_width;
use crate::report::plot::error::PlotError;
use crate::report::plot::over_axis::LEFT;
use crate::report::plot::panel::{Panel, TICK_SIZE};
use crate::report::plot::picture::{Drawn, Picture};
use crate::report::plot::results::Slice;
use crate::report::plot::what::PlotRequest;

const TOP: f64 = 72.0;
const BOTTOM: f64 = 526.0;
/// Right end of the canvas \[px\].
const EDGE: f64 = 952.0;
/// Widest and narrowest legend \[px\].
const LEGEND: [f64; 2] = [120.0, 330.0];
/// Most entries of a legend.
const MOST_ENTRIES: usize = 21;
/// Most markers of a curve: more would hide its line.
const MOST_MARKERS: usize = 60;
/// Markers left of a denser curve, so that it is still told by them.
const FEW_MARKERS: usize = 8;
/// Half the height of the ends of an error bar's whiskers \[px\].
const WHISKER: f64 = 3.0;

/// A place of a curve, shown values.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Dot {
    x: f64,
    low: f64,
    value: f64,
    high: f64,
}

/// What tells the curves of a picture apart: the series, the value of the second axis (its place among
/// them), the source and the direction of a sweep.
type Key = [usize; 4];

/// A curve.
#[derive(Debug, Default)]
struct Curve {
    dots: Vec<Dot>,
    scattered: bool,
    /// Some values have error bars.
    barred: bool,
}

/// A picture before it is drawn.
#[derive(Default)]
struct Plan {
    words: Vec<Vec<String>>,
    points: usize,
    curves: BTreeMap<Key, Curve>,
}

/// Axes of the curves: places in each source.
struct Axes {
    over: Vec<usize>,
    by: Vec<Option<usize>>,
    /// Values of the second axis in all sources, ascending.
    values: Vec<f64>,
}

pub(super) fn draw(
    sources: &[Source<'_>],
    group: &[Vec<Series>],
    request: &PlotRequest,
) -> Result<Drawn, PlotError> {
    let axes = axes(sources, request)?;
    let mut names: Vec<&str> = Vec::new();
    for series in group.iter().flatten() {
        if !names.contains(&&*series.name) {
            names.push(&series.name);
        }
    }
    let unit = group
        .iter()
        .flatten()
        .next()
        .map_or("", |series| &series.unit);
    let parts: Vec<&str> = group[0].iter().map(|series| &*series.part).collect();
    let label = match (&names[..], &parts[..]) {
        ([name], [part]) if !part.is_empty() => format!("{name}, {part}"),
        ([name], _) => (*name).to_owned(),
        _ => common(&names),
    };
    let scale = Scale::new(&label, unit, &request.display)?;
    // Pictures by what is held, in the order met.
    let mut order: Vec<String> = Vec::new();
    let mut plans: BTreeMap<String, Plan> = BTreeMap::new();
    let mut dropped = 0;
    for (place, source) in sources.iter().enumerate() {
        let mut free = vec![axes.over[place]];
        free.extend(axes.by[place]);
        let (slices, all) = source.results.slices_of_both(&free);
        dropped += all - slices.len();
        for slice in &slices {
            if !plans.contains_key(&slice.suffix) {
                order.push(slice.suffix.clone());
            }
            let plan = plans.entry(slice.suffix.clone()).or_default();
            plan.take(place, source, slice, &group[place], &axes, &scale);
        }
    }
    let first = &sources[0].results;
    let over = &first.summary.axes[axes.over[0]];
    let mut ends: Vec<f64> = Vec::new();
    let mut across: Vec<f64> = Vec::new();
    for dot in plans.values().flat_map(Plan::dots) {
        across.push(dot.x);
        ends.extend(
            [dot.low, dot.high, dot.value]
                .into_iter()
                .filter(|v| v.is_finite()),
        );
    }
    across.sort_by(f64::total_cmp);
    across.dedup();
    let across = first.axis(over, |name, unit| match request.display.log {
        Some(Log::X | Log::Xy) => {
            let [first, last] = range(across.iter().copied());
            let margin = (last / first).max(1.0).powf(0.02);
            Axis::logarithmic(name, unit, [first / margin, last * margin])
        }
        Some(Log::Y) | None => Axis::for_grid(name, unit, &across),
    });
    let up = scale.axis(range(ends.into_iter()));
    let mut drawn = Drawn::sliced(&label, order.len(), order.len() + dropped);
    let jobs: Vec<&str> = sources.iter().map(|source| &*source.name).collect();
    let by = axes
        .by
        .iter()
        .flatten()
        .next()
        .map(|&by| first.summary.axes.get(by));
    let by = by.flatten().map(|axis| axis.name.as_str());
    let mut file: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    if let ([_], [part]) = (&names[..], &parts[..]) {
        file[0] += &file_part(part);
    }
    let mut file = file.join("+").replace(' ', "-");
    if request.over.is_some() || by.is_some() {
        file += &format!("-over-{}", over.name);
    }
    if let Some(by) = by {
        file += &format!("-by-{by}");
    }
    if jobs.len() > 1 {
        file += &format!("-with-{}", jobs[1..].join("+"));
    }
    for suffix in &order {
        let plan = &plans[suffix];
        let title = format!(
            "{}: {} over {}",
            jobs.join(", "),
            names.join(", "),
            over.name
        );
        let points = match plan.points {
            1 => "1 point".to_owned(),
            points => format!("{points} points"),
        };
        let held = plan.held().join(", ");
        let mut canvas = Canvas::titled(&title, &first.subtitle(&[&held, &points]));
        let picture = Labelled {
            sources,
            group,
            axes: &axes,
            plan,
            names: &names,
        };
        picture.draw(&mut canvas, &across, &up);
        drawn
            .pictures
            .push(Picture::new(format!("{file}{suffix}"), canvas));
    }
    Ok(drawn)
}

/// What some columns of one unit are called together: what their names have in common.
fn common(names: &[&str]) -> String {
    let first = names.first().copied().unwrap_or_default();
    let parts = first.split('_').take_while(|part| {
        let begins = |name: &&str| name.split('_').any(|own| own == *part);
        names.iter().all(begins)
    });
    let shared: Vec<&str> = parts.collect();
    match shared.is_empty() {
        true => names.join(", "),
        false => shared.join("_"),
    }
}

/// Which axes the curves go along and differ by.
fn axes(sources: &[Source<'_>], request: &PlotRequest) -> Result<Axes, PlotError> {
    let first = sources[0].results;
    let own = |name: Option<&str>, except: Option<&str>| first.along_any(name, except);
    let over = own(request.over.as_deref(), request.by.as_deref())?;
    let over_name = &first.summary.axes[over].name;
    if request.by.as_ref() == Some(over_name) {
        return Err(PlotError::SameAxis {
            name: over_name.clone(),
        });
    }
    let mut axes = Axes {
        over: Vec::new(),
        by: Vec::new(),
        values: Vec::new(),
    };
    for source in sources {
        let results = source.results;
        axes.over.push(results.along_any(Some(over_name), None)?);
        let by = request
            .by
            .as_deref()
            .map(|name| results.along_any(Some(name), None));
        let by = by.transpose()?;
        axes.by.push(by);
        axes.values
            .extend(by.iter().flat_map(|&by| &results.summary.axes[by].values));
    }
    axes.values.sort_by(f64::total_cmp);
    axes.values.dedup();
    Ok(axes)
}

impl Plan {
    fn dots(&self) -> impl Iterator<Item = &Dot> {
        self.curves.values().flat_map(|curve| &curve.dots)
    }

    /// Takes up the points of a slice of a source.
    fn take(
        &mut self,
        place: usize,
        source: &Source<'_>,
        slice: &Slice<'_>,
        series: &[Series],
        axes: &Axes,
        scale: &Scale,
    ) {
        let results = source.results;
        let held = slice
            .held
            .iter()
            .map(|&(axis, value)| results.held_words(&results.summary.axes[axis], value));
        self.words.resize(place + 1, Vec::new());
        self.words[place] = held.collect();
        self.points += slice.points.len();
        let over = axes.over[place];
        let ranks = &results.summary.axes[over].values;
        for (which, series) in series.iter().enumerate() {
            let mut last: BTreeMap<Key, usize> = BTreeMap::new();
            let mut points = slice.points.clone();
            points.sort_by(|a, b| a.axis_values[over].total_cmp(&b.axis_values[over]));
            for point in points {
                let by = axes.by[place].map_or(0, |by| {
                    axes.values
                        .partition_point(|value| *value < point.axis_values[by])
                });
                let direction = usize::from(point.direction.as_deref() == Some("down"));
                let key = [which, by, place, direction];
                let curve = self.curves.entry(key).or_default();
                curve.scattered = series.scattered;
                let x = point.axis_values[over];
                let rank = ranks.partition_point(|value| *value < x);
                // A point that was not computed breaks the line; of a refined grid most are not.
                let whole = results.summary.refined.is_some();
                let gap = last.insert(key, rank).is_some_and(|last| rank > last + 1) && !whole;
                let nowhere = Dot {
                    x,
                    low: f64::NAN,
                    value: f64::NAN,
                    high: f64::NAN,
                };
                if gap {
                    curve.dots.push(nowhere);
                }
                let samples = results
                    .place(point.point_id)
                    .map(|place| &series.samples[place]);
                let before = curve.dots.len();
                for sample in samples.into_iter().flatten() {
                    let Some(value) = scale.shown(sample.value) else {
                        continue;
                    };
                    let end = |end: f64| scale.shown(end).unwrap_or(f64::NAN);
                    let [low, high] =
                        [sample.value - sample.error, sample.value + sample.error].map(end);
                    curve.barred |= sample.error > 0.0;
                    curve.dots.push(Dot {
                        x,
                        low,
                        value,
                        high,
                    });
                }
                if curve.dots.len() == before {
                    curve.dots.push(nowhere);
                }
            }
        }
    }

    /// What all sources hold alike.
    fn held(&self) -> Vec<String> {
        let Some((first, others)) = self.words.split_first() else {
            return Vec::new();
        };
        let alike = |word: &&String| others.iter().all(|words| words.contains(word));
        first.iter().filter(alike).cloned().collect()
    }

    /// What a source holds that others do not.
    fn own(&self, source: usize) -> Vec<String> {
        let held = self.held();
        let words = self.words.get(source).into_iter().flatten();
        words.filter(|word| !held.contains(word)).cloned().collect()
    }
}

/// A picture with what its curves are called by.
struct Labelled<'a> {
    sources: &'a [Source<'a>],
    group: &'a [Vec<Series>],
    axes: &'a Axes,
    plan: &'a Plan,
    names: &'a [&'a str],
}

impl Labelled<'_> {
    /// The words of a curve, of each of its parts that not all curves share.
    fn label(&self, key: &Key) -> String {
        let [series, by, source, direction] = *key;
        let mut parts = Vec::new();
        if self.varies(2) {
            parts.push(self.sources[source].name.clone());
            parts.extend(self.plan.own(source));
        }
        if self.varies(0) {
            let series = &self.group[source][series];
            if self.names.len() > 1 || series.part.is_empty() {
                parts.push(series.name.clone());
            }
            parts.extend(Some(series.part.clone()).filter(|part| !part.is_empty()));
        }
        if let Some(axis) = self.axes.by[source] {
            let results = self.sources[source].results;
            let axis = &results.summary.axes[axis];
            parts.push(results.held_words(axis, self.axes.values[by]));
        }
        if self.varies(3) {
            let words = ["sweep up", "sweep down"];
            parts.push(words[direction].to_owned());
        }
        parts.join(", ")
    }

    /// Whether curves differ in a part of their keys.
    fn varies(&self, part: usize) -> bool {
        self.count(part) > 1
    }

    fn count(&self, part: usize) -> usize {
        let mut met: Vec<usize> = self.plan.curves.keys().map(|key| key[part]).collect();
        met.sort_unstable();
        met.dedup();
        met.len()
    }

    /// Colours tell what has most values apart, dashes the rest.
    fn style(&self, key: &Key) -> Style {
        let counts = [0, 1, 2, 3].map(|part| self.count(part));
        // Of equals the value of the second axis comes first, then the series.
        let lead = [1, 0, 2, 3]
            .into_iter()
            .rev()
            .max_by_key(|&part| counts[part])
            .unwrap_or(0);
        let place = |part: usize| {
            let smaller = self.plan.curves.keys().filter(|own| own[part] < key[part]);
            let mut met: Vec<usize> = smaller.map(|own| own[part]).collect();
            met.sort_unstable();
            met.dedup();
            met.len()
        };
        let dashes = (0..4).filter(|&part| part != lead);
        let dashes = dashes.fold(0, |dashes, part| dashes * counts[part] + place(part));
        Style::new([place(lead), counts[lead]], lead == 1, dashes)
    }

    fn draw(&self, canvas: &mut Canvas, across: &Axis, up: &Axis) {
        let curves: Vec<(String, Style, &Curve)> = (self.plan.curves.iter())
            .map(|(key, curve)| (self.label(key), self.style(key), curve))
            .collect();
        let widths = curves
            .iter()
            .map(|(label, ..)| text_width(label, TICK_SIZE));
        let alone = curves.len() < 2;
        let widest = widths.fold(0.0, f64::max) + 52.0;
        let right = EDGE
            - if alone {
                40.0
            } else {
                widest.clamp(LEGEND[0], LEGEND[1])
            };
        let panel = Panel {
            left: LEFT,
            right,
            top: TOP,
            bottom: BOTTOM,
            across: across.clone(),
            up: up.clone(),
        };
        panel.frame(canvas, true);
        if curves
            .iter()
            .all(|(_, _, curve)| curve.dots.iter().all(|dot| dot.value.is_nan()))
        {
            panel.note(canvas, "no point has a value");
        }
        for (_, style, curve) in &curves {
            curve.bars(canvas, &panel, style);
        }
        for (_, style, curve) in &curves {
            curve.draw(canvas, &panel, style);
        }
        canvas.outline([LEFT, TOP], [right, BOTTOM], INK, 1.0);
        let mut y = TOP + 10.0;
        if !alone {
            let every = curves.len().div_ceil(MOST_ENTRIES);
            for (label, style, curve) in curves.iter().step_by(every) {
                style.sample(canvas, [right + 14.0, y], !curve.scattered);
                canvas.text(
                    [right + 47.0, y + 4.5],
                    label,
                    TICK_SIZE,
                    INK,
                    Anchor::Start,
                );
                y += 20.0;
            }
            if every > 1 {
                let text = format!("{} curves", curves.len());
                canvas.text(
                    [right + 14.0, y + 4.5],
                    &text,
                    TICK_SIZE,
                    SOFT,
                    Anchor::Start,
                );
            }
        }
        if curves.iter().any(|(_, _, curve)| curve.barred) {
            let at = [right, TOP - 7.0];
            canvas.text(at, "bars: ± standard error", TICK_SIZE, SOFT, Anchor::End);
        }
    }
}

impl Curve {
    fn bars(&self, canvas: &mut Canvas, panel: &Panel, style: &Style) {
        if !self.barred {
            return;
        }
        let wide = (panel.right - panel.left) / self.dots.len().max(1) as f64 > 3.0 * WHISKER;
        for dot in self.dots.iter().filter(|dot| dot.value.is_finite()) {
            let inside = |y: f64| y.clamp(panel.top, panel.bottom);
            let low = if dot.low.is_nan() {
                panel.bottom
            } else {
                inside(panel.y(dot.low))
            };
            let (x, high) = (panel.x(dot.x), inside(panel.y(dot.high)));
            canvas.line(&[[x, low], [x, high]], style.tint(), 1.4);
            if wide && low - high > 2.0 * WHISKER {
                for y in [low, high] {
                    canvas.line(&[[x - WHISKER, y], [x + WHISKER, y]], style.tint(), 1.4);
                }
            }
        }
    }

    fn draw(&self, canvas: &mut Canvas, panel: &Panel, style: &Style) {
        let places: Vec<Place> = self
            .dots
            .iter()
            .map(|dot| panel.at(dot.x, dot.value))
            .collect();
        let within = |place: &Place| {
            (panel.left - 1.0..=panel.right + 1.0).contains(&place[0])
                && (panel.top - 1.0..=panel.bottom + 1.0).contains(&place[1])
        };
        if !self.scattered {
            style.line(canvas, &clipped(&places, panel), 1.8);
        }
        let known: Vec<usize> = (0..places.len()).filter(|&i| within(&places[i])).collect();
        let dense = known.len() > MOST_MARKERS;
        let every = if dense {
            known.len().div_ceil(FEW_MARKERS)
        } else {
            1
        };
        for (count, &i) in known.iter().enumerate() {
            let joined = |other: Option<usize>| {
                other
                    .and_then(|other| places.get(other))
                    .is_some_and(|place| !place[1].is_nan())
            };
            // A value without neighbours is on no line.
            let lonely = !joined(i.checked_sub(1)) && !joined(Some(i + 1));
            let small = dense && (self.scattered || count % every != every / 2);
            if !small || lonely || self.scattered {
                style.mark(canvas, places[i], small);
            }
        }
    }
}

/// Places with those of lines that leave a panel moved to its edge, and nothing between what lies
/// beyond.
fn clipped(places: &[Place], panel: &Panel) -> Vec<Place> {
    let [top, bottom] = [panel.top, panel.bottom];
    let [left, right] = [panel.left, panel.right];
    let nowhere = [f64::NAN, f64::NAN];
    let mut out = Vec::with_capacity(places.len());
    for (i, &place) in places.iter().enumerate() {
        if i > 0 {
            match crossing(places[i - 1], place, [left, right], [top, bottom]) {
                Some([from, to]) => {
                    if out.last() != Some(&from) {
                        out.extend([nowhere, from]);
                    }
                    out.push(to);
                }
                None => out.push(nowhere),
            }
        }
    }
    out
}

/// The part of a straight line that lies within a rectangle (Liang and Barsky 1984); none where no part
/// does.
fn crossing(from: Place, to: Place, across: [f64; 2], down: [f64; 2]) -> Option<[Place; 2]> {
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for (axis, [low, high]) in [across, down].into_iter().enumerate() {
        let length = to[axis] - from[axis];
        if length.is_nan() {
            return None;
        }
        if length == 0.0 {
            if from[axis] < low || from[axis] > high {
                return None;
            }
            continue;
        }
        let [a, b] = [(low - from[axis]) / length, (high - from[axis]) / length];
        start = start.max(a.min(b));
        end = end.min(a.max(b));
    }
    let at = |t: f64| [0, 1].map(|axis| from[axis] + t * (to[axis] - from[axis]));
    let ends = [
        if start <= 0.0 { from } else { at(start) },
        if end >= 1.0 { to } else { at(end) },
    ];
    (start <= end).then_some(ends)
}
