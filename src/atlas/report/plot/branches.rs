//! Followed orbits over their axis: stable and unstable branches with their bifurcations. Grey dots behind
//! them show the points of the grid.

use std::collections::{BTreeMap, BTreeSet};

use super::axis::{Axis, padded, range};
use super::axis_units::AxisUnits;
use super::canvas::{Canvas, Colour, Place};
use super::categories::colour;
use super::marker::{Marker, SAMPLE, entry, name};
use super::over_axis::{MARGIN, RIGHT};
use super::panel::{LEFT, Panel};
use super::picture::{Drawn, Picture};
use super::picture_kind::PictureKind;
use super::results::{MOST_SLICES, Results, distinct};
use crate::report::followed::{Bifurcation, FixedValues, Followed, Orbit};
use crate::report::numbers::plural;

/// Colour of the points of the grid.
const GREY: Colour = Colour(0xc0, 0xc0, 0xc0);

/// Widths of stable and unstable branches \[px\].
const STABLE: f64 = 2.4;
const UNSTABLE: f64 = 1.1;

/// Largest number of periods in the key.
const MOST_PERIODS: usize = 8;

/// Largest RMS of a shown point, divided by the largest RMS of the orbits.
const LARGEST_RMS_RATIO: f64 = 1.5;

/// Reasons for an end that need no marker, because the picture shows them.
const PLAIN_ENDS: [&str; 2] = ["the interval ends", "back at the first orbit"];

/// Draws one picture per line.
pub(super) fn draw(followed: &Followed, shown: &AxisUnits, results: Option<&Results>) -> Drawn {
    let lines = followed.lines();
    let count = lines.len();
    let mut drawn = Drawn::sliced(PictureKind::Branches.name(), count.min(MOST_SLICES), count);
    for line in lines.iter().take(MOST_SLICES) {
        let canvas = picture(followed, shown, line, results);
        let name = format!("branches{}", suffix(followed, line));
        drawn.pictures.push(Picture::new(name, canvas));
    }
    drawn
}

/// The fixed values in words: `load 0.05, mesh.half_gap 10 µm`.
pub(super) fn words(followed: &Followed, shown: &AxisUnits, fixed: &FixedValues) -> String {
    let values = fixed.values.iter().filter_map(|(name, value)| {
        let axis = followed.axes.iter().find(|axis| axis.name == *name)?;
        Some(shown.words(axis, *value))
    });
    values.collect::<Vec<_>>().join(", ")
}

/// The values of axes with several values, for a file name: `-load=0.05`.
pub(super) fn suffix(followed: &Followed, fixed: &FixedValues) -> String {
    let values = fixed.values.iter().filter_map(|(name, value)| {
        let axis = followed.axes.iter().find(|axis| axis.name == *name)?;
        (axis.values.len() > 1).then(|| format!("{name}={}", distinct(axis, *value)))
    });
    match &values.collect::<Vec<_>>()[..] {
        [] => String::new(),
        values => format!("-{}", values.join(",")),
    }
}

fn picture(
    followed: &Followed,
    shown: &AxisUnits,
    line: &FixedValues,
    results: Option<&Results>,
) -> Canvas {
    let axis = followed.axis();
    let branches_here = || {
        let branches = followed.branches.iter();
        branches.filter(|(_, orbits)| orbits.iter().all(|orbit| line.holds(&orbit.at)))
    };
    let orbits = || branches_here().flat_map(|(_, orbits)| orbits);
    let across = range(orbits().map(|orbit| orbit.at[followed.over]));
    let settled: Vec<Place> = (results.map(|results| settled(followed, line, results)))
        .unwrap_or_default()
        .into_iter()
        .filter(|[x, _]| (across[0]..=across[1]).contains(x))
        .collect();
    let up = range(orbits().map(|orbit| orbit.rms));
    // A few points with large vibration must not compress the branches.
    let top = LARGEST_RMS_RATIO * up[1];
    let (seen, beyond): (Vec<Place>, Vec<Place>) = settled.into_iter().partition(|p| p[1] <= top);
    let up = range(up.into_iter().chain(seen.iter().map(|[_, y]| *y)));
    let job = followed.job.as_deref().unwrap_or("job unknown");
    let title = format!("{job}: periodic orbits over {}", axis.name);
    let counts = [
        words(followed, shown, line),
        match branches_here().count() {
            1 => "1 branch".to_owned(),
            count => format!("{count} branches"),
        },
        plural(orbits().count(), "orbit"),
    ];
    let counts: Vec<&str> = counts
        .iter()
        .map(String::as_str)
        .filter(|w| !w.is_empty())
        .collect();
    let mut canvas = Canvas::titled(&title, &counts.join("  ·  "));
    let panel = Panel::new(
        [LEFT, RIGHT],
        [72.0, 526.0],
        shown.axis(axis, |name, unit| {
            Axis::linear(name, unit, padded(across, 0.02))
        }),
        Axis::linear("RMS of the deflection", "m", padded(up, 0.05)),
    );
    panel.frame(&mut canvas, true);
    for [x, y] in &seen {
        canvas.disc(panel.at(*x, *y), 2.6, GREY);
    }
    let periods: BTreeSet<u64> = orbits().map(|orbit| orbit.period).collect();
    let periods: Vec<u64> = periods.into_iter().collect();
    for (number, orbits) in branches_here() {
        let found = followed.bifurcations.iter().filter(|b| b.branch == *number);
        let place = |period: u64| {
            periods
                .iter()
                .position(|known| *known == period)
                .unwrap_or(0)
        };
        let ink = orbits.first().map_or(0, |orbit| place(orbit.period));
        for (stable, part) in parts(followed.over, orbits, &found.collect::<Vec<_>>()) {
            let part: Vec<Place> = part.iter().map(|[x, y]| panel.at(*x, *y)).collect();
            if stable {
                canvas.line(&part, colour(ink), STABLE)
            } else {
                canvas.dashed_line(&part, colour(ink), UNSTABLE)
            }
        }
    }
    let shown = |found: &&Bifurcation| {
        line.holds(&found.at)
            && (!found.is_end() || found.end().is_some_and(|end| !needs_no_note(end)))
    };
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    let found: Vec<&Bifurcation> = followed.bifurcations.iter().filter(shown).collect();
    // Draw frequent kinds first, so that rarer kinds lie on top.
    for found in &found {
        *kinds.entry(&found.kind).or_insert(0) += 1;
    }
    let mut order = found.clone();
    order.sort_by_key(|found| std::cmp::Reverse(kinds[&found.kind[..]]));
    for found in order {
        let at = panel.at(found.at[followed.over], found.rms);
        Marker::of(&found.kind).draw(&mut canvas, at);
    }
    key(&mut canvas, &periods, &kinds, [seen.len(), beyond.len()]);
    canvas
}

fn needs_no_note(end: &str) -> bool {
    PLAIN_ENDS.contains(&end) || end.starts_with("merges")
}

/// The points of the grid on a line, if their RMS of the deflection is known: value of the followed axis, and
/// RMS.
fn settled(followed: &Followed, line: &FixedValues, results: &Results) -> Vec<Place> {
    let axes = &results.summary.axes;
    let names: Vec<String> = axes.iter().map(|axis| axis.name.clone()).collect();
    let Some(over) = names.iter().position(|name| *name == followed.axis().name) else {
        return Vec::new();
    };
    let points = results.summary.all.iter().zip(&results.deflection_rms);
    points
        .filter(|(point, _)| line.holds_named(&names, &point.axis_values))
        .filter_map(|(point, rms)| Some([point.axis_values[over], (*rms)?]))
        .collect()
}

/// The stable and unstable parts of a branch. It is split at the bifurcation between two orbits of different
/// stability, or at the second orbit if there is no such bifurcation.
fn parts(over: usize, orbits: &[Orbit], bifurcations: &[&Bifurcation]) -> Vec<(bool, Vec<Place>)> {
    let mut parts: Vec<(bool, Vec<Place>)> = Vec::new();
    for (index, orbit) in orbits.iter().enumerate() {
        let at = [orbit.at[over], orbit.rms];
        match parts.last_mut() {
            Some((stable, part)) if *stable == orbit.stable => part.push(at),
            Some((_, part)) => {
                let between = bifurcations.iter().find(|b| {
                    let kinds = ["fold", "branch_point", "period_doubling", "torus"];
                    b.after + 1 == index && kinds.contains(&&b.kind[..])
                });
                let turn = between.map_or(at, |b| [b.at[over], b.rms]);
                part.push(turn);
                parts.push((orbit.stable, vec![turn, at]));
            }
            None => parts.push((orbit.stable, vec![at])),
        }
    }
    parts
}

fn key(canvas: &mut Canvas, periods: &[u64], kinds: &BTreeMap<&str, usize>, points: [usize; 2]) {
    let (x, mut y) = (MARGIN, 84.0);
    let mut line = |canvas: &mut Canvas, text: &str| {
        let at = y;
        y += entry(canvas, [x, y], text);
        at
    };
    let grey = Colour(0x5c, 0x5c, 0x5c);
    let at = line(canvas, "stable");
    canvas.line(&[[x, at], [x + SAMPLE, at]], grey, STABLE);
    let at = line(canvas, "unstable");
    canvas.dashed_line(&[[x, at], [x + SAMPLE, at]], grey, UNSTABLE);
    if points != [0, 0] {
        let text = match points {
            [_, 0] => "points of the grid".to_owned(),
            [_, beyond] => format!("points ({beyond} above)"),
        };
        let at = line(canvas, &text);
        canvas.disc([x + 11.0, at], 2.6, GREY);
    }
    for (index, period) in periods.iter().enumerate().take(MOST_PERIODS) {
        let at = line(canvas, &format!("period {period}"));
        canvas.rectangle([x + 4.0, at - 6.0], [x + 18.0, at + 6.0], colour(index));
    }
    if periods.len() > MOST_PERIODS {
        let text = format!("… and {} more", periods.len() - MOST_PERIODS);
        line(canvas, &text);
    }
    for (kind, count) in kinds {
        let text = match *kind {
            "end" => format!("end of a branch ({count})"),
            kind => format!("{} ({count})", name(kind)),
        };
        let at = line(canvas, &text);
        Marker::of(kind).draw(canvas, [x + 11.0, at]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stability_changes_at_the_bifurcation_and_not_at_a_graze() {
        let orbit = |x: f64, stable| Orbit {
            at: vec![x],
            period: 1,
            stable,
            sequence: String::new(),
            rms: 10.0 * x,
        };
        let found = |kind: &str, x: f64, after| Bifurcation {
            at: vec![x],
            branch: 0,
            after,
            kind: kind.into(),
            detail: String::new(),
            rms: 10.0 * x,
        };
        let orbits = [(0.0, true), (1.0, true), (2.0, false), (3.0, true)];
        let orbits = orbits.map(|(x, stable)| orbit(x, stable));
        let [graze, fold] = [found("graze", 1.2, 1), found("fold", 1.5, 1)];
        let places = |xs: &[f64]| -> Vec<Place> { xs.iter().map(|x| [*x, 10.0 * x]).collect() };
        // Without a bifurcation, stability changes at the next orbit.
        let wanted = vec![
            (true, places(&[0.0, 1.0, 1.5])),
            (false, places(&[1.5, 2.0, 3.0])),
            (true, places(&[3.0, 3.0])),
        ];
        assert_eq!(parts(0, &orbits, &[&graze, &fold]), wanted);
    }
}
