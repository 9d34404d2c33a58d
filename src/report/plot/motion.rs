//! What a point did, as the pictures show it: one colour, one mark and one name for every
//! kind of motion, in all of them.

use std::collections::BTreeMap;

use super::canvas::{Anchor, Canvas, Colour, INK, Place, SOFT};
use super::panel::TICK_SIZE;
use crate::report::PointSummary;

/// Kind of motion, or why there is none; the calmest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Motion {
    SteadyContact,
    Periodic(u64),
    QuasiPeriodic,
    Chaotic,
    NotConverged,
    Unclassified,
    Failed,
}

impl Motion {
    pub fn of(point: &PointSummary) -> Self {
        match (point.status.as_str(), point.class.as_deref()) {
            ("diverged" | "event_storm" | "failed" | "inaccurate", _) => Self::Failed,
            (_, Some("chaotic")) => Self::Chaotic,
            (_, Some("quasi_periodic")) => Self::QuasiPeriodic,
            (_, Some("steady_contact")) => Self::SteadyContact,
            (_, Some("periodic")) => Self::Periodic(point.period.unwrap_or(0)),
            ("not_converged", _) | (_, Some("not_converged")) => Self::NotConverged,
            _ => Self::Unclassified,
        }
    }

    /// From Okabe and Ito's palette and tints of it, told apart by colour-blind readers and
    /// from viridis; longer periods are darker.
    pub fn colour(self) -> Colour {
        match self {
            Self::SteadyContact => Colour(0xdc, 0xdc, 0xdc),
            Self::Periodic(0 | 1) => Colour(0x9f, 0xcf, 0xee),
            Self::Periodic(2) => Colour(0x3f, 0x9b, 0xd5),
            Self::Periodic(3 | 4) => Colour(0x00, 0x62, 0xa3),
            Self::Periodic(5..=8) => Colour(0x00, 0x33, 0x66),
            Self::Periodic(_) => Colour(0x00, 0x14, 0x29),
            Self::QuasiPeriodic => Colour(0x00, 0x9e, 0x73),
            Self::Chaotic => Colour(0xd5, 0x5e, 0x00),
            Self::NotConverged => Colour(0xea, 0xb8, 0xd4),
            Self::Unclassified => Colour(0xff, 0xff, 0xff),
            Self::Failed => Colour(0x22, 0x22, 0x22),
        }
    }

    /// One or two characters for a cell of a map.
    pub fn mark(self) -> String {
        match self {
            Self::SteadyContact => "L".into(),
            Self::Periodic(0) => "p".into(),
            Self::Periodic(period) => period.to_string(),
            Self::QuasiPeriodic => "q".into(),
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
            Self::Chaotic => "chaotic".into(),
            Self::NotConverged => "not converged".into(),
            Self::Unclassified => "not classified".into(),
            Self::Failed => "failed".into(),
        }
    }
}

/// How often each kind of motion occurs.
pub(super) fn counts<'p>(
    points: impl IntoIterator<Item = &'p PointSummary>,
) -> BTreeMap<Motion, usize> {
    let mut counts = BTreeMap::new();
    for point in points {
        *counts.entry(Motion::of(point)).or_insert(0) += 1;
    }
    counts
}

/// Most entries of a key.
const MOST_ENTRIES: usize = 14;

/// The kinds of motion that a key of so many entries names, those that occur most, the calmest
/// first; and how many it leaves out.
pub(super) fn leading(
    counts: &BTreeMap<Motion, usize>,
    most: usize,
) -> (BTreeMap<Motion, usize>, usize) {
    let mut frequent: Vec<(Motion, usize)> = counts.iter().map(|(m, n)| (*m, *n)).collect();
    frequent.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let left = frequent.len().saturating_sub(most);
    (frequent.into_iter().take(most).collect(), left)
}

/// Names beside their colours, downwards from a place; gives the height used \[px\].
pub(super) fn key(canvas: &mut Canvas, at: Place, counts: &BTreeMap<Motion, usize>) -> f64 {
    const PITCH: f64 = 23.0;
    let (named, left) = leading(counts, MOST_ENTRIES);
    for (row, (motion, count)) in named.iter().enumerate() {
        let [x, y] = [at[0], at[1] + PITCH * row as f64];
        canvas.rectangle([x, y], [x + 14.0, y + 14.0], motion.colour());
        canvas.outline([x, y], [x + 14.0, y + 14.0], SOFT, 1.0);
        let text = format!("{} ({count})", motion.name());
        canvas.text([x + 21.0, y + 12.0], &text, TICK_SIZE, INK, Anchor::Start);
    }
    if left > 0 {
        let y = at[1] + PITCH * MOST_ENTRIES as f64;
        let text = format!("… and {left} more");
        canvas.text([at[0], y + 12.0], &text, TICK_SIZE, SOFT, Anchor::Start);
    }
    PITCH * counts.len().min(MOST_ENTRIES + 1) as f64
}
