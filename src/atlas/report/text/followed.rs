//! The followed orbits, as text.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::table::with_unit;
use crate::report::numbers::{number, plural};
use crate::report::summary::Summary;

/// Appends the counts of branches, bifurcations and curves.
pub(super) fn push(text: &mut String, summary: &Summary) {
    let Some(found) = &summary.followed else {
        return;
    };
    let [low, high] = found.range.map(number);
    let lines = plural(found.lines, "line");
    _ = writeln!(
        text,
        "\norbits followed over {}, {}, {lines}",
        found.over,
        with_unit(&format!("{low} … {high}"), &found.unit)
    );
    let mut row = |head: &str, words: &str| {
        _ = writeln!(text, "  {head:<14}{words}");
    };
    let branches = format!(
        "{} with {} orbits, {} of them stable",
        found.branches, found.orbits, found.stable_orbits
    );
    row("branches", &branches);
    row("bifurcations", &counted(&found.bifurcations));
    let changes = format!("changed {} times along branches", found.changes_of_sequence);
    row("sequences", &changes);
    row("ends", &counted_as(&found.ends, " x ", "; "));
    if let Some(second) = &found.second {
        let curves = counted(&found.curves);
        row(
            "curves",
            &format!("{curves}, over {} and {second}", found.over),
        );
        row(
            "codimension 2",
            &counted_as(&found.codimension_two, " x ", "; "),
        );
    }
}

/// `3 fold, 8 period doubling`.
pub fn counted<W: AsRef<str>>(counts: &BTreeMap<W, usize>) -> String {
    counted_as(counts, " ", ", ")
}

fn counted_as<W: AsRef<str>>(counts: &BTreeMap<W, usize>, between: &str, joint: &str) -> String {
    let words = counts.iter();
    let words = words.map(|(word, count)| {
        let word = word.as_ref().replace('_', " ");
        format!("{count}{between}{word}")
    });
    let words: Vec<String> = words.collect();
    if words.is_empty() { "none".to_owned() } else { words.join(joint) }
}
