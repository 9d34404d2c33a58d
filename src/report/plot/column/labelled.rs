//! Curves on a canvas: lines, markers, error bars and what they are called.

use super::Source;
use super::clip::clipped;
use super::plan::{Axes, Curve, Key, Plan};
use super::series::Series;
use super::style::Style;
use crate::report::plot::axis::Axis;
use crate::report::plot::canvas::{Anchor, Canvas, INK, Place, SOFT};
use crate::report::plot::lettering::{fitted, text_width};
use crate::report::plot::over_axis::LEFT;
use crate::report::plot::panel::{Panel, TICK_SIZE};

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

/// A picture with what its curves are called by.
pub(super) struct Labelled<'a> {
    pub sources: &'a [Source<'a>],
    pub group: &'a [Vec<Series>],
    pub axes: &'a Axes,
    pub plan: &'a Plan,
    pub names: &'a [&'a str],
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

    pub fn draw(&self, canvas: &mut Canvas, across: &Axis, up: &Axis) {
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
                let (label, size) = fitted(label, TICK_SIZE, 8.0, EDGE - right - 49.0);
                canvas.text([right + 47.0, y + 4.5], &label, size, INK, Anchor::Start);
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
