//! A picture as a list of shapes in pixels, with x to the right and y down. SVG and PNG are drawn from the
//! same list, so that they show the same.

use std::collections::{BTreeSet, HashSet};
use std::fmt;
use std::hash::{DefaultHasher, Hash, Hasher};

use super::lettering::fitted;
use crate::input::{clipped, printable};

/// A place on the canvas \[px\].
pub(super) type Place = [f64; 2];

/// A colour: red, green, blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::report) struct Colour(pub u8, pub u8, pub u8);

impl fmt::Display for Colour {
    /// `#d55e00`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}

pub(super) const WHITE: Colour = Colour(255, 255, 255);
/// Colour of texts and axes.
pub(super) const INK: Colour = Colour(0x22, 0x22, 0x22);
/// Colour of secondary texts.
pub(super) const SOFT: Colour = Colour(0x5c, 0x5c, 0x5c);
/// Colour of grid lines.
pub(super) const FAINT: Colour = Colour(0xe2, 0xe2, 0xe2);
/// Colour of curves.
pub(super) const BLUE: Colour = Colour(0x0b, 0x5c, 0x9e);
/// Colour of highlights on curves.
pub(super) const RED: Colour = Colour(0xc8, 0x3c, 0x00);

/// Width of a picture \[px\] in SVG; PNG has twice as many pixels each way.
pub(super) const WIDTH: f64 = 960.0;
/// Height of most pictures \[px\].
const HEIGHT: f64 = 600.0;

/// Limit of coordinates \[px\]; it is far outside every picture.
const FARTHEST: f64 = 1e4;

/// Largest number of characters in a text. Longer texts come only from wrong numbers or names, and are cut.
const MOST_CHARACTERS: usize = 300;

/// A place clamped to [`FARTHEST`]; `None` if a coordinate is NaN.
fn bounded([x, y]: Place) -> Option<Place> {
    let far = |coordinate: f64| coordinate.clamp(-FARTHEST, FARTHEST);
    (!x.is_nan() && !y.is_nan()).then(|| [far(x), far(y)])
}

/// Number of shapes, or of places of a line, from which on those within a pixel of others are left out. More
/// shapes take minutes to draw without a visible difference.
const FEWEST_THINNED: usize = 50_000;

/// A shape moved onto whole pixels, with a hash of what it looks like. `None` instead of a hash for shapes
/// that are never left out: texts, and lines with more than two places.
fn on_pixels(mut shape: Shape) -> (Shape, Option<u64>) {
    let mut hash = DefaultHasher::new();
    let whole = |place: &mut Place, to: fn(f64) -> f64| *place = place.map(to);
    let record = match &mut shape {
        Shape::Rectangle { from, to, colour } => {
            let ends = [0, 1].map(|i| whole_ends([from[i].min(to[i]), from[i].max(to[i])]));
            (*from, *to) = (ends.map(|[low, _]| low), ends.map(|[_, high]| high));
            (0, vec![*from, *to], *colour, 0.0)
        }
        Shape::Disc {
            centre,
            radius,
            colour,
        } => {
            whole(centre, f64::round);
            (1, vec![*centre], *colour, *radius)
        }
        Shape::Line {
            points,
            colour,
            width,
        } if points.len() == 2 => {
            points.iter_mut().for_each(|place| whole(place, f64::round));
            (2, points.clone(), *colour, *width)
        }
        Shape::Polygon { points, colour } => {
            // A marker moves as a whole, so that it keeps its form.
            let middle = [0, 1]
                .map(|i| points.iter().map(|place| place[i]).sum::<f64>() / points.len() as f64);
            let step = middle.map(|middle| middle.round() - middle);
            points
                .iter_mut()
                .for_each(|place| *place = [0, 1].map(|i| place[i] + step[i]));
            (
                3,
                vec![middle.map(f64::round)],
                *colour,
                points.len() as f64,
            )
        }
        Shape::Line { .. } | Shape::Text { .. } => return (shape, None),
    };
    let (kind, places, colour, size): (u8, Vec<Place>, Colour, f64) = record;
    let places = places.as_flattened().iter().map(|at| *at as i32);
    (kind, places.collect::<Vec<i32>>(), colour, size.to_bits()).hash(&mut hash);
    (shape, Some(hash.finish()))
}

/// The ends of a side of a rectangle, on whole pixels. A side of about one pixel, as of a cell of a large
/// map, becomes the pixel in its middle.
fn whole_ends([low, high]: [f64; 2]) -> [f64; 2] {
    if high - low <= 1.4 {
        let pixel = (0.5 * (low + high)).floor();
        [pixel, pixel + 1.0]
    } else {
        [low.round(), high.round()]
    }
}

/// A line reduced to the first, lowest, highest and last of its places in each column of pixels.
fn outlined(points: &[Place]) -> Vec<Place> {
    let columns = points.chunk_by(|a, b| a[0].round() == b[0].round());
    let outline = columns.flat_map(|column| {
        let height = |&a: &usize, &b: &usize| column[a][1].total_cmp(&column[b][1]);
        let ends = [
            (0..column.len()).min_by(height),
            (0..column.len()).max_by(height),
        ];
        let kept: BTreeSet<usize> = [0, column.len() - 1]
            .into_iter()
            .chain(ends.into_iter().flatten())
            .collect();
        kept.into_iter().map(move |place| column[place])
    });
    outline.collect()
}

/// The part of a text that lies at its place: start, middle or end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// An element of a picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    Line {
        points: Vec<Place>,
        colour: Colour,
        width: f64,
    },
    Rectangle {
        from: Place,
        to: Place,
        colour: Colour,
    },
    Polygon {
        points: Vec<Place>,
        colour: Colour,
    },
    Disc {
        centre: Place,
        radius: f64,
        colour: Colour,
    },
    Text {
        /// Start, middle or end of the baseline.
        at: Place,
        text: String,
        /// Em size \[px\].
        size: f64,
        colour: Colour,
        anchor: Anchor,
        /// Whether the text reads from bottom to top.
        upwards: bool,
    },
}

/// Shapes in the order of drawing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Canvas {
    /// Height of the picture \[px\].
    pub height: f64,
    pub shapes: Vec<Shape>,
    /// Hashes of the shapes on whole pixels, from [`FEWEST_THINNED`] shapes on.
    seen: HashSet<u64>,
    /// Number of shapes and places of lines that were left out because others are within a pixel.
    pub left_out: usize,
}

impl Canvas {
    /// A canvas with a title, and a subtitle below it.
    pub fn titled(title: &str, subtitle: &str) -> Self {
        let mut canvas = Self {
            height: HEIGHT,
            shapes: Vec::new(),
            seen: HashSet::new(),
            left_out: 0,
        };
        const TITLE_INSET: f64 = 24.0;
        let lines = [(title, 30.0, 17.0, INK), (subtitle, 50.0, 13.0, SOFT)];
        for (text, y, size, colour) in lines {
            let shown = printable(&clipped(text, MOST_CHARACTERS)).into_owned();
            let (shown, size) = fitted(&shown, size, 9.0, WIDTH - 2.0 * TITLE_INSET);
            canvas.text([TITLE_INSET, y], &shown, size, colour, Anchor::Start);
        }
        canvas
    }

    /// Width and height \[px\].
    pub fn size(&self) -> [f64; 2] {
        [WIDTH, self.height]
    }

    /// Adds a shape. If there are very many shapes, skips a shape that has the same pixels as an earlier one.
    fn push(&mut self, shape: Shape) {
        if self.shapes.len() < FEWEST_THINNED {
            return self.shapes.push(shape);
        }
        let (shape, key) = on_pixels(shape);
        if key.is_none_or(|key| self.seen.insert(key)) {
            self.shapes.push(shape)
        } else {
            self.left_out += 1
        }
    }

    /// Adds a line through some places; it is interrupted at places with NaN.
    pub fn line(&mut self, points: &[Place], colour: Colour, width: f64) {
        let places: Vec<Option<Place>> = points.iter().copied().map(bounded).collect();
        for part in places.split(Option::is_none).filter(|part| part.len() > 1) {
            let mut points: Vec<Place> = part.iter().copied().flatten().collect();
            if points.len() > FEWEST_THINNED {
                points = outlined(&points);
                self.left_out += part.len() - points.len();
            }
            self.push(Shape::Line {
                points,
                colour,
                width,
            });
        }
    }

    /// Adds a straight dashed line.
    pub fn dashes(&mut self, from: Place, to: Place, colour: Colour, width: f64) {
        const DASH: f64 = 6.0;
        let (Some(from), Some(to)) = (bounded(from), bounded(to)) else {
            return;
        };
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let count = (length / (2.0 * DASH)).ceil().max(1.0);
        let along = |t: f64| {
            let t = t.min(1.0);
            [
                from[0] + t * (to[0] - from[0]),
                from[1] + t * (to[1] - from[1]),
            ]
        };
        for dash in 0..count as usize {
            let start = dash as f64 / count;
            self.line(&[along(start), along(start + 0.55 / count)], colour, width);
        }
    }

    /// Adds a dashed line through some places, with dashes of equal length.
    pub fn dashed_line(&mut self, points: &[Place], colour: Colour, width: f64) {
        self.patterned(points, [5.0, 3.5], colour, width);
    }

    /// Adds a dashed line through some places. `pattern` is the length of a dash and of a gap \[px\].
    pub fn patterned(&mut self, points: &[Place], pattern: [f64; 2], colour: Colour, width: f64) {
        let mut dash: Vec<Place> = points.iter().take(1).copied().collect();
        let (mut left, mut gap) = (pattern[0], false);
        for pair in points.windows(2) {
            let (Some(mut from), Some(to)) = (bounded(pair[0]), bounded(pair[1])) else {
                continue;
            };
            loop {
                let length = (to[0] - from[0]).hypot(to[1] - from[1]);
                if length < left {
                    left -= length;
                    dash.push(to);
                    break;
                }
                let part = left / length;
                from = [0, 1].map(|i| from[i] + part * (to[i] - from[i]));
                dash.push(from);
                if !gap {
                    self.line(&dash, colour, width);
                }
                gap = !gap;
                left = pattern[usize::from(gap)];
                dash = vec![from];
            }
        }
        if !gap {
            self.line(&dash, colour, width);
        }
    }

    pub fn rectangle(&mut self, from: Place, to: Place, colour: Colour) {
        if let (Some(from), Some(to)) = (bounded(from), bounded(to)) {
            self.push(Shape::Rectangle { from, to, colour });
        }
    }

    pub fn polygon(&mut self, points: &[Place], colour: Colour) {
        let points: Vec<Place> = points.iter().copied().filter_map(bounded).collect();
        if points.len() > 2 {
            self.push(Shape::Polygon { points, colour });
        }
    }

    pub fn outline(&mut self, from: Place, to: Place, colour: Colour, width: f64) {
        let corners = [from, [to[0], from[1]], to, [from[0], to[1]], from];
        self.line(&corners, colour, width);
    }

    pub fn disc(&mut self, centre: Place, radius: f64, colour: Colour) {
        if let Some(centre) = bounded(centre) {
            self.push(Shape::Disc {
                centre,
                radius,
                colour,
            });
        }
    }

    pub fn text(&mut self, at: Place, text: &str, size: f64, colour: Colour, anchor: Anchor) {
        self.push_text(at, text, size, colour, anchor, false);
    }

    /// Adds a text that reads from bottom to top.
    pub fn text_upwards(
        &mut self,
        at: Place,
        text: &str,
        size: f64,
        colour: Colour,
        anchor: Anchor,
    ) {
        self.push_text(at, text, size, colour, anchor, true);
    }

    fn push_text(
        &mut self,
        at: Place,
        text: &str,
        size: f64,
        colour: Colour,
        anchor: Anchor,
        upwards: bool,
    ) {
        let Some(at) = bounded(at) else {
            return;
        };
        self.shapes.push(Shape::Text {
            at,
            text: printable(&clipped(text, MOST_CHARACTERS)).into_owned(),
            size,
            colour,
            anchor,
            upwards,
        });
    }
}

#[cfg(test)]
impl Canvas {
    /// All texts, in the order of drawing.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.shapes.iter().filter_map(|shape| match shape {
            Shape::Text { text, .. } => Some(text.as_str()),
            _ => None,
        })
    }

    /// Texts that extend beyond the canvas, and pairs of texts that overlap.
    pub fn faults(&self) -> Vec<String> {
        let boxes: Vec<(&str, [f64; 4])> = (self.shapes.iter().filter_map(text_box)).collect();
        let [width, height] = self.size();
        let mut faults = Vec::new();
        for (index, (text, [left, top, right, bottom])) in boxes.iter().enumerate() {
            if *left < 0.0 || *right > width || *top < 0.0 || *bottom > height {
                faults.push(format!("`{text}` is cut off"));
            }
            for (other, [from, above, to, below]) in &boxes[..index] {
                if left < to && from < right && top < below && above < bottom {
                    faults.push(format!("`{text}` is on `{other}`"));
                }
            }
        }
        faults
    }
}

/// A text and the area that it covers: left, top, right, bottom.
#[cfg(test)]
fn text_box(shape: &Shape) -> Option<(&str, [f64; 4])> {
    let Shape::Text {
        at: [x, y],
        text,
        size,
        anchor,
        upwards,
        ..
    } = shape
    else {
        return None;
    };
    let width = super::lettering::text_width(text, *size);
    let start = match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -0.5 * width,
        Anchor::End => -width,
    };
    // Digits and capitals rise 0.73 em above the baseline; descenders may touch other texts.
    let rise = 0.73 * size;
    let covered = if *upwards {
        [x - rise, y - start - width, *x, y - start]
    } else {
        [x + start, y - rise, x + start + width, *y]
    };
    (width > 0.0).then_some((text, covered))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_on_each_other_and_beyond_the_edge_are_found() {
        let mut canvas = Canvas::titled("a title", "a line below it");
        assert_eq!(canvas.faults(), [] as [&str; 0]);
        canvas.text(
            [900.0, 300.0],
            "far too long for its place",
            14.0,
            INK,
            Anchor::Start,
        );
        canvas.text([905.0, 304.0], "on it", 14.0, INK, Anchor::Start);
        canvas.text_upwards([30.0, 40.0], "label", 14.0, INK, Anchor::Middle);
        let faults = canvas.faults();
        assert_eq!(faults.len(), 4, "{faults:?}");
        assert!(faults[0].contains("cut off") && faults[1].contains("is on `far"));
    }

    /// Many marks on a few pixels, in two colours.
    #[test]
    fn of_very_many_shapes_one_a_pixel_is_drawn() {
        let mut canvas = Canvas::titled("", "");
        let few = canvas.shapes.len();
        for i in 0..200_000 {
            let x = 100.0 + 10.0 * f64::from(i) / 2e5;
            let colour = if i % 2 == 0 { INK } else { RED };
            canvas.disc([x, 50.0], 1.5, colour);
            canvas.rectangle([x, 60.0], [x + 0.1, 60.1], colour);
            canvas.text([x, 90.0], "kept", 9.0, INK, Anchor::Start);
        }
        let texts = canvas.texts().filter(|text| *text == "kept").count();
        assert_eq!(texts, 200_000);
        let marks = canvas.shapes.len() - few - texts;
        assert_eq!(canvas.left_out, 400_000 - marks);
        assert!(marks < FEWEST_THINNED, "{marks}");
        // Each remaining pixel has one mark of each colour and kind.
        assert!(canvas.seen.len() <= 4 * 12, "{}", canvas.seen.len());
        let line: Vec<Place> = (0..200_000)
            .map(|i| [f64::from(i) / 2e3, if i % 777 == 0 { 80.0 } else { 7.0 }])
            .collect();
        canvas.line(&line, BLUE, 1.0);
        let Some(Shape::Line { points, .. }) = canvas.shapes.last() else {
            panic!("no line");
        };
        assert!(points.len() <= 4 * 102, "{}", points.len());
        assert_eq!((points[0], points.last()), (line[0], line.last()));
        for column in points.chunk_by(|a, b| a[0].round() == b[0].round()) {
            let heights: Vec<f64> = column.iter().map(|place| place[1]).collect();
            assert!(
                heights.contains(&7.0) && heights.contains(&80.0),
                "{heights:?}"
            );
        }
    }

    #[test]
    fn dashes_are_even_however_many_places_a_line_has() {
        let drawn = |count: usize| -> Vec<[f64; 2]> {
            let mut canvas = Canvas::titled("", "");
            let places = (0..=count).map(|i| [84.0 * i as f64 / count as f64, 7.0]);
            canvas.dashed_line(&places.collect::<Vec<_>>(), INK, 1.0);
            let dashes = canvas.shapes.iter().filter_map(|shape| match shape {
                Shape::Line { points, .. } => Some([points[0][0], points[points.len() - 1][0]]),
                _ => None,
            });
            dashes.collect()
        };
        let wanted: Vec<[f64; 2]> = (0..10)
            .map(|i| 8.5 * f64::from(i))
            .map(|x| [x, x + 5.0])
            .collect();
        for count in [1, 3, 400] {
            let found = drawn(count);
            assert_eq!(found.len(), wanted.len(), "{found:?}");
            let pairs = found.iter().flatten().zip(wanted.iter().flatten());
            assert!(
                pairs.clone().all(|(a, b)| (a - b).abs() < 1e-9),
                "{found:?}"
            );
        }
    }
}
