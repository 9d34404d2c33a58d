//! The kinds of motion in pictures. Each kind has one colour, one symbol, one mark and one name in all
//! pictures.

use std::collections::BTreeMap;

use super::canvas::{Anchor, Canvas, Colour, INK, Place, SOFT, WHITE, WIDTH};
use super::hatch::hatch;
use super::lettering::fitted;
use super::marker::Marker;
use super::panel::TICK_SIZE;
use super::point_style::PointStyle;
use super::ramp::ink_on;
use crate::report::PointSummary;
use crate::report::point::{CHAOTIC, TRANSIENT_CHAOS};

/// Kind of motion of a point, or the reason why it has none; the calmest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::report) enum Motion {
    SteadyContact,
    Periodic(u64),
    QuasiPeriodic,
    TransientChaos,
    Chaotic,
    NotConverged,
    Unclassified,
    Failed,
}

impl Motion {
    pub fn of(point: &PointSummary) -> Self {
        match (&*point.status, point.class.as_deref()) {
            ("diverged" | "event_storm" | "failed" | "inaccurate", _) => Self::Failed,
            (_, Some(CHAOTIC)) => Self::Chaotic,
            (_, Some(TRANSIENT_CHAOS)) => Self::TransientChaos,
            (_, Some("quasi_periodic")) => Self::QuasiPeriodic,
            (_, Some("steady_contact")) => Self::SteadyContact,
            (_, Some("periodic")) => Self::Periodic(point.period.unwrap_or(0)),
            ("not_converged", _) | (_, Some("not_converged")) => Self::NotConverged,
            _ => Self::Unclassified,
        }
    }

    /// Whether neighbouring trajectories separate exponentially, at least for a time.
    pub fn is_chaos(self) -> bool {
        matches!(self, Self::Chaotic | Self::TransientChaos)
    }

    /// Whether cells of maps are hatched: chaos that some trajectories left.
    pub fn is_hatched(self) -> bool {
        self == Self::TransientChaos
    }

    /// Whether pictures of averages mark the point, because a longer run may change its averages.
    pub fn is_marked(self) -> bool {
        matches!(self, Self::TransientChaos | Self::NotConverged)
    }

    /// The colour of the motion. Green and vermilion are from Okabe and Ito's palette, and transient chaos
    /// has a paler vermilion. Periods have one family of shades per odd factor (1, 3, 5, others), darker
    /// after every doubling. Colour-blind readers can distinguish all these colours; a test checks this. Some
    /// periods share a shade (8, 16, …; 12, 24, …; 10, 20, …; 7, 9, …). They differ by their numbers on maps,
    /// and by their rows or names elsewhere.
    pub fn colour(self) -> Colour {
        match self {
            Self::SteadyContact => Colour(0xdc, 0xdc, 0xdc),
            Self::Periodic(period) => match family(period) {
                (1, 0) => Colour(0x9f, 0xcf, 0xee),
                (1, 1) => Colour(0x3f, 0x9b, 0xd5),
                (1, 2) => Colour(0x00, 0x62, 0xa3),
                (1, _) => Colour(0x00, 0x2a, 0x5c),
                (3, 0) => Colour(0xff, 0xde, 0xa3),
                (3, 1) => Colour(0xe6, 0xb8, 0x00),
                (3, _) => Colour(0x61, 0x40, 0x00),
                (5, 0) => Colour(0xc2, 0xa9, 0xa5),
                (5, _) => Colour(0x8e, 0x42, 0x75),
                _ => Colour(0x7d, 0x68, 0x3e),
            },
            Self::QuasiPeriodic => Colour(0x00, 0x9e, 0x73),
            Self::TransientChaos => Colour(0xf6, 0x90, 0x5a),
            Self::Chaotic => Colour(0xd5, 0x5e, 0x00),
            Self::NotConverged => Colour(0x8b, 0x89, 0xa7),
            Self::Unclassified => WHITE,
            Self::Failed => Colour(0x22, 0x22, 0x22),
        }
    }

    /// The symbol of the motion on a curve: one per family of periods.
    pub(super) fn marker(self) -> Marker {
        match self {
            Self::Periodic(period) => match family(period).0 {
                1 => Marker::Disc,
                3 => Marker::Triangle,
                5 => Marker::Square,
                _ => Marker::Diamond,
            },
            Self::QuasiPeriodic => Marker::Inverted,
            Self::Failed => Marker::Cross,
            _ => Marker::Disc,
        }
    }

    /// A short text for a cell of a map: a letter, a symbol or the period.
    pub fn mark(self) -> String {
        match self {
            Self::SteadyContact => "L".into(),
            Self::Periodic(0) => "p".into(),
            Self::Periodic(period) => period.to_string(),
            Self::QuasiPeriodic => "q".into(),
            Self::TransientChaos => "t".into(),
            Self::Chaotic => "c".into(),
            Self::NotConverged => "?".into(),
            Self::Unclassified => "–".into(),
            Self::Failed => "×".into(),
        }
    }

    pub fn name(self) -> String {
        match self {
            Self::SteadyContact => "steady contact".into(),
            Self::Periodic(0) => "periodic".into(),
            Self::Periodic(period) => format!("period {period}"),
            Self::QuasiPeriodic => "quasi-periodic".into(),
            Self::TransientChaos => "transient chaos".into(),
            Self::Chaotic => "chaotic".into(),
            Self::NotConverged => "not converged".into(),
            Self::Unclassified => "not classified".into(),
            Self::Failed => "failed".into(),
        }
    }
}

/// Number of points of each kind of motion.
pub(super) fn counts<'p>(
    points: impl IntoIterator<Item = &'p PointSummary>,
) -> BTreeMap<Motion, usize> {
    let mut counts = BTreeMap::new();
    for point in points {
        *counts.entry(Motion::of(point)).or_insert(0) += 1;
    }
    counts
}

/// The odd factor of a period, and the number of its factors of two. An unknown period (0) counts as 1.
fn family(period: u64) -> (u64, u32) {
    let doublings = period.max(1).trailing_zeros();
    (period.max(1) >> doublings, doublings)
}

/// The kinds of motion for a key with at most `most` entries: the most frequent kinds, in the order of
/// [`Motion`], and the number of kinds that are left out.
fn leading(counts: &BTreeMap<Motion, usize>, most: usize) -> (BTreeMap<Motion, usize>, usize) {
    let mut frequent: Vec<(Motion, usize)> = counts.iter().map(|(m, n)| (*m, *n)).collect();
    frequent.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let left = frequent.len().saturating_sub(most);
    (frequent.into_iter().take(most).collect(), left)
}

/// Distance between entries of a key \[px\].
const PITCH: f64 = 24.0;
/// Width and height of a sample \[px\].
const SAMPLE: [f64; 2] = [20.0, 18.0];

/// Draws a sample of a key: a cell as on the map, with the letter of its motion if the map has letters.
pub(super) fn cell_sample(canvas: &mut Canvas, [x, y]: Place, look: &PointStyle) {
    let (corner, colour) = ([x + SAMPLE[0], y + SAMPLE[1]], look.colour);
    canvas.rectangle([x, y], corner, colour);
    if look.hatched {
        hatch(canvas, [x, y], corner, ink_on(colour));
        if !look.text.is_empty() {
            canvas.rectangle(
                [x + 5.0, y + 3.0],
                [corner[0] - 5.0, corner[1] - 3.0],
                colour,
            );
        }
    }
    canvas.outline([x, y], corner, SOFT, 1.0);
    let at = [x + 0.5 * SAMPLE[0], y + 13.5];
    canvas.text(at, &look.text, TICK_SIZE, ink_on(colour), Anchor::Middle);
}

/// Draws a key whose samples are cells. Returns the height used \[px\].
pub(super) fn cell_key(
    canvas: &mut Canvas,
    at: Place,
    bottom: f64,
    counts: &BTreeMap<Motion, usize>,
    look: impl Fn(Motion) -> PointStyle,
) -> f64 {
    let sample = |canvas: &mut Canvas, at: Place, motion: Motion| {
        cell_sample(canvas, at, &look(motion));
    };
    key(canvas, at, bottom, counts, sample)
}

/// Draws a sample of a key: the symbol of a motion on curves.
pub(super) fn marker_sample(canvas: &mut Canvas, [x, y]: Place, motion: Motion) {
    let at = [x + 0.5 * SAMPLE[0], y + 0.5 * SAMPLE[1]];
    motion.marker().filled(canvas, at, motion.colour());
}

/// Draws the names of motions with their counts, each beside its sample, from a place down to at most
/// `bottom`. Returns the height used \[px\].
pub(super) fn key(
    canvas: &mut Canvas,
    [x, top]: Place,
    bottom: f64,
    counts: &BTreeMap<Motion, usize>,
    sample: impl Fn(&mut Canvas, Place, Motion),
) -> f64 {
    let room = ((bottom - top) / PITCH).max(1.0) as usize;
    // If some kinds are left out, one line gives their number.
    let most = if counts.len() > room { room.saturating_sub(1).max(1) } else { room };
    let (named, left) = leading(counts, most);
    let left_out = (left > 0).then(|| format!("… and {left} more classes"));
    let lines = named
        .iter()
        .map(|(motion, count)| (Some(*motion), format!("{} ({count})", motion.name())));
    let lines: Vec<(Option<Motion>, String)> =
        lines.chain(left_out.map(|words| (None, words))).collect();
    for (row, (motion, words)) in lines.iter().enumerate() {
        let y = top + PITCH * row as f64;
        if let Some(motion) = motion {
            sample(canvas, [x, y], *motion);
        }
        let left = x + SAMPLE[0] + 8.0;
        let (words, size) = fitted(words, TICK_SIZE, 8.0, WIDTH - 6.0 - left);
        canvas.text([left, y + 13.5], &words, size, INK, Anchor::Start);
    }
    PITCH * lines.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Colours for readers with full colour vision and for readers without cones for red, green or blue light: linear
    /// RGB by matrices of Machado, Oliveira and Fernandes (2009), severity 1.
    const SIGHTS: [[[f64; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ],
    ];

    fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// CIE 1976 L*a*b* of a colour for a reader's vision (sRGB, D65).
    fn lab_colour(colour: Colour, vision: &[[f64; 3]; 3]) -> [f64; 3] {
        let linear = [colour.0, colour.1, colour.2].map(|value| {
            let value = f64::from(value) / 255.0;
            if value <= 0.04045 {
                value / 12.92
            } else {
                ((value + 0.055) / 1.055).powf(2.4)
            }
        });
        let seen = times(vision, linear).map(|value| value.clamp(0.0, 1.0));
        let to_xyz = [
            [0.4124564, 0.3575761, 0.1804375],
            [0.2126729, 0.7151522, 0.0721750],
            [0.0193339, 0.1191920, 0.9503041],
        ];
        let [x, y, z] = times(&to_xyz, seen);
        let f = |value: f64| {
            if value > (6.0_f64 / 29.0).powi(3) {
                value.cbrt()
            } else {
                value / (3.0 * (6.0_f64 / 29.0).powi(2)) + 4.0 / 29.0
            }
        };
        let [x, y, z] = [f(x / 0.95047), f(y), f(z / 1.08883)];
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// A difference of 2.3 is just noticeable; a difference of eleven is visible between small marks.
    #[test]
    fn kinds_of_motion_differ_in_colour_to_every_reader() {
        let periods = [1, 2, 3, 4, 5, 6, 7, 8, 10, 12].map(Motion::Periodic);
        let others = [
            Motion::SteadyContact,
            Motion::QuasiPeriodic,
            Motion::TransientChaos,
            Motion::Chaotic,
            Motion::NotConverged,
            Motion::Unclassified,
            Motion::Failed,
        ];
        let all: Vec<Motion> = periods.into_iter().chain(others).collect();
        for (index, a) in all.iter().enumerate() {
            for b in &all[..index] {
                for vision in &SIGHTS {
                    let [p, q] = [a, b].map(|motion| lab_colour(motion.colour(), vision));
                    let distance = (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
                    assert!(distance > 11.0, "{a:?} and {b:?}: {distance}");
                }
            }
        }
    }

    #[test]
    fn a_key_of_many_kinds_ends_where_its_room_does() {
        let counts: BTreeMap<Motion, usize> =
            (1..30).map(|p| (Motion::Periodic(p), p as usize)).collect();
        let mut canvas = Canvas::titled("", "");
        let used = key(&mut canvas, [800.0, 72.0], 312.0, &counts, marker_sample);
        assert_eq!(used, 240.0);
        let texts: Vec<&str> = canvas.texts().collect();
        assert!(texts.contains(&"period 29 (29)"), "{texts:?}");
        assert!(texts.contains(&"… and 20 more classes"), "{texts:?}");
    }
}
