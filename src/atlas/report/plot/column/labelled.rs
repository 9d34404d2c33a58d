//! Drawing of curves: lines, markers, error bars and the legend.

use std::collections::BTreeMap;
use std::slice;

use super::Source;
use super::plan::{Axes, Curve, Key, Plan};
use super::series::Series;
use super::style::Style;
use crate::report::plot::axis::Axis;
use crate::report::plot::canvas::{Anchor, Canvas, INK, Place, SOFT};
use crate::report::plot::clip::clipped;
use crate::report::plot::lettering::{fitted, text_width};
use crate::report::plot::marker::Marker;
use crate::report::plot::panel::{BOTTOM, LEFT, Panel, TICK_SIZE, TOP};

/// Right end of the canvas \[px\].
const CANVAS_RIGHT: f64 = 952.0;
/// Smallest and largest width of a legend \[px\].
const LEGEND: [f64; 2] = [120.0, 330.0];
/// Largest number of entries in a legend.
const MOST_ENTRIES: usize = 21;
/// Largest number of full markers on a curve: more would hide its line.
const MOST_MARKERS: usize = 60;
/// Number of full markers on a curve with more than [`MOST_MARKERS`] points, so that readers recognise its marker.
const FEW_MARKERS: usize = 8;
/// The parts of a [`Key`] in the order in which a label names them: source, series, value of the second axis,
/// direction.
const WORDED: [usize; 4] = [2, 0, 1, 3];
/// Half the width of the whiskers at the ends of an error bar \[px\].
const WHISKER: f64 = 3.0;

/// A picture with everything that its labels need.
pub(super) struct Labelled<'a> {
    pub sources: &'a [Source<'a>],
    pub group: &'a [Vec<Series>],
    pub axes: &'a Axes,
    pub plan: &'a Plan,
    pub names: &'a [&'a str],
    /// Measured points.
    pub measured: Option<&'a Curve>,
}

impl Labelled<'_> {
    /// The label of a curve: the words of each part of its key in which curves differ; `computed` if there are none.
    fn label(&self, key: &Key) -> String {
        let parts = WORDED.iter().flat_map(|&part| self.words(part, key));
        let words = parts.collect::<Vec<_>>().join(", ");
        if words.is_empty() { "computed".to_owned() } else { words }
    }

    /// The words of a part of a curve's key.
    fn words(&self, part: usize, key: &Key) -> Vec<String> {
        let [series, by, source, direction] = *key;
        let mut words = Vec::new();
        match part {
            2 if self.varies(2) => {
                words.push(self.sources[source].name.clone());
                words.extend(self.plan.distinct_values(source));
            }
            0 if self.varies(0) => {
                let series = &self.group[source][series];
                if self.names.len() > 1 || series.part.is_empty() {
                    words.push(series.name.clone());
                }
                words.extend(Some(series.part.clone()).filter(|part| !part.is_empty()));
            }
            1 => words.extend(self.axes.by[source].map(|axis| {
                let results = self.sources[source].results;
                let axis = &results.summary.axes[axis];
                results.axis_value_text(axis, self.axes.values[by])
            })),
            3 if self.varies(3) && direction > 0 => {
                words.push(["sweep up", "sweep down"][direction - 1].to_owned());
            }
            _ => {}
        }
        words
    }

    /// The entries of the legend: one per curve. More than [`MOST_ENTRIES`] curves get one entry per colour and one per
    /// kind of dashes, if these entries are few enough.
    fn entries(&self) -> Vec<Entry> {
        let curves = || self.plan.curves.iter();
        let all = curves().map(|(key, curve)| Entry {
            label: self.label(key),
            style: self.style(key),
            lined: !curve.scattered,
            marked: true,
        });
        let (lead, count) = self.lead();
        let mut dashes: Vec<usize> = curves().map(|(key, _)| self.style(key).dashes).collect();
        dashes.sort_unstable();
        dashes.dedup();
        let few = all.len() <= MOST_ENTRIES;
        if few || dashes.len() < 2 || count + dashes.len() > MOST_ENTRIES {
            return all.collect();
        }
        let others: Vec<usize> = WORDED.into_iter().filter(|part| *part != lead).collect();
        let mut entries: Vec<Entry> = Vec::new();
        for coloured in [true, false] {
            let mut distinct: Vec<usize> = Vec::new();
            for (key, curve) in curves() {
                let style = self.style(key);
                let index = if coloured { key[lead] } else { style.dashes };
                if distinct.contains(&index) {
                    continue;
                }
                distinct.push(index);
                let (dashes, colour) = if coloured { (0, style.colour) } else { (index, INK) };
                let parts = if coloured { slice::from_ref(&lead) } else { &others[..] };
                let words = parts.iter().flat_map(|&part| self.words(part, key));
                entries.push(Entry {
                    label: words.collect::<Vec<_>>().join(", "),
                    style: Style {
                        dashes,
                        colour,
                        ..style
                    },
                    lined: !curve.scattered,
                    marked: coloured,
                });
            }
        }
        entries
    }

    /// The part of the keys that colours distinguish, and the number of its values.
    fn lead(&self) -> (usize, usize) {
        // `max_by_key` takes the last of equal counts. Thus the second axis has priority, then the series.
        let lead = [1, 0, 2, 3].into_iter().rev();
        let lead = lead
            .max_by_key(|&part| self.distinct_count(part))
            .unwrap_or(0);
        (lead, self.distinct_count(lead))
    }

    /// Whether curves differ in a part of their keys.
    fn varies(&self, part: usize) -> bool {
        self.distinct_count(part) > 1
    }

    fn distinct_count(&self, part: usize) -> usize {
        let mut distinct: Vec<usize> = self.plan.curves.keys().map(|key| key[part]).collect();
        distinct.sort_unstable();
        distinct.dedup();
        distinct.len()
    }

    /// The style of a curve: its colour is that of the part with most values, and its dashes distinguish the
    /// other parts.
    fn style(&self, key: &Key) -> Style {
        let counts = [0, 1, 2, 3].map(|part| self.distinct_count(part));
        let (lead, _) = self.lead();
        let place = |part: usize| {
            let smaller = self
                .plan
                .curves
                .keys()
                .filter(|other| other[part] < key[part]);
            let mut distinct: Vec<usize> = smaller.map(|other| other[part]).collect();
            distinct.sort_unstable();
            distinct.dedup();
            distinct.len()
        };
        let dashes = (0..4).filter(|&part| part != lead);
        let dashes = dashes.fold(0, |dashes, part| dashes * counts[part] + place(part));
        Style::new([place(lead), counts[lead]], lead == 1, dashes)
    }

    pub fn draw(&self, canvas: &mut Canvas, across: &Axis, up: &Axis) {
        let mut curves: Vec<(Style, &Curve)> = (self.plan.curves.iter())
            .map(|(key, curve)| (self.style(key), curve))
            .collect();
        let mut entries = self.entries();
        let mut marked = BTreeMap::new();
        for dot in curves.iter().flat_map(|(_, curve)| &curve.dots) {
            if let Some(motion) = dot.marked {
                *marked.entry(motion).or_insert(0) += 1;
            }
        }
        entries.extend(marked.into_iter().map(|(motion, count)| Entry {
            label: format!("{} ({count})", motion.name()),
            style: Style {
                colour: motion.colour(),
                ..Style::MEASURED
            },
            lined: false,
            marked: true,
        }));
        entries.extend(self.measured.map(|_| Entry {
            label: "measured".to_owned(),
            style: Style::MEASURED,
            lined: false,
            marked: true,
        }));
        let widths = entries
            .iter()
            .map(|entry| text_width(&entry.label, TICK_SIZE));
        let alone = entries.len() < 2;
        let widest = widths.fold(0.0, f64::max) + 52.0;
        let right = CANVAS_RIGHT - if alone { 40.0 } else { widest.clamp(LEGEND[0], LEGEND[1]) };
        let panel = Panel::new([LEFT, right], [TOP, BOTTOM], across.clone(), up.clone());
        panel.frame(canvas, true);
        curves.extend(self.measured.map(|curve| (Style::MEASURED, curve)));
        if curves
            .iter()
            .all(|(_, curve)| curve.dots.iter().all(|dot| dot.value.is_nan()))
        {
            panel.note(canvas, "no point has a value");
        }
        for (style, curve) in &curves {
            curve.bars(canvas, &panel, style);
        }
        for (style, curve) in &curves {
            curve.draw(canvas, &panel, style);
        }
        canvas.outline([LEFT, TOP], [right, BOTTOM], INK, 1.0);
        let mut y = TOP + 10.0;
        if !alone {
            let every = entries.len().div_ceil(MOST_ENTRIES);
            for entry in entries.iter().step_by(every) {
                entry.sample(canvas, [right + 14.0, y]);
                let (label, size) =
                    fitted(&entry.label, TICK_SIZE, 8.0, CANVAS_RIGHT - right - 49.0);
                canvas.text([right + 47.0, y + 4.5], &label, size, INK, Anchor::Start);
                y += 20.0;
            }
            if every > 1 {
                let text = format!("{} curves", curves.len());
                canvas.label([right + 14.0, y + 4.5], &text, SOFT);
            }
        }
        if curves.iter().any(|(_, curve)| curve.barred) {
            let at = [right, TOP - 7.0];
            canvas.text(at, "bars: ± standard error", TICK_SIZE, SOFT, Anchor::End);
        }
    }
}

/// A line of a legend.
struct Entry {
    label: String,
    style: Style,
    lined: bool,
    marked: bool,
}

impl Entry {
    fn sample(&self, canvas: &mut Canvas, at: Place) {
        if self.marked {
            self.style.sample(canvas, at, self.lined)
        } else {
            (self.style).line(canvas, &[at, [at[0] + 26.0, at[1]]], 1.8)
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
            let low = if dot.low.is_nan() { panel.bottom } else { inside(panel.y(dot.low)) };
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
        let every = if dense { known.len().div_ceil(FEW_MARKERS) } else { 1 };
        for (count, &i) in known.iter().enumerate() {
            let joined = |other: Option<usize>| {
                other
                    .and_then(|other| places.get(other))
                    .is_some_and(|place| !place[1].is_nan())
            };
            // A value without neighbours is not on a line. It therefore always gets a mark, on dense curves a dot.
            let lonely = !joined(i.checked_sub(1)) && !joined(Some(i + 1));
            let small = dense && (self.scattered || count % every != every / 2);
            if !small || lonely || self.scattered {
                style.mark(canvas, places[i], small);
            }
            if let Some(motion) = self.dots[i].marked {
                Marker::Disc.sized(canvas, places[i], motion.colour(), 0.6);
            }
        }
    }
}
