//! The followed orbits, as text.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::transitions::line;
use crate::report::followed::{Explained, Explaining, Explanation, FollowedSummary};
use crate::report::numbers::{number, to_digits};
use crate::report::summary::Summary;

/// Transitions listed before the list is cut short.
const MOST_ROWS: usize = 40;

/// Branches, bifurcations and curves, and what they explain of a sweep.
pub(super) fn push(text: &mut String, summary: &Summary) {
    let Some(found) = &summary.followed else {
        return;
    };
    let [low, high] = found.range.map(number);
    let lines = match found.lines {
        1 => "1 line".to_owned(),
        count => format!("{count} lines"),
    };
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
    if let Some(explanation) = &found.transitions {
        push_explanation(text, found, explanation);
    } else if let Some(swept) = summary
        .carried_along
        .as_ref()
        .filter(|own| **own != found.over)
    {
        _ = writeln!(
            text,
            "  changes of motion along {swept} are not compared: orbits are followed over {}",
            found.over
        );
    }
}

fn push_explanation(text: &mut String, found: &FollowedSummary, explanation: &Explanation) {
    let unit = &found.unit;
    _ = writeln!(
        text,
        "\n{} of {} changes of motion explained: a bifurcation lies within the bracket",
        explanation.within, explanation.count
    );
    let mut row = |head: &str, words: String| {
        _ = writeln!(text, "  {head:<14}{words}");
    };
    row("kinds", counted(&explanation.kinds));
    row(
        "of these",
        format!(
            "{} by a branch that is stable beside it; {} expected by chance",
            explanation.within_of_stable,
            to_digits(explanation.within_by_chance, 2)
        ),
    );
    let tolerance = with_unit(&to_digits(explanation.tolerance, 2), unit);
    row(
        "near",
        format!(
            "{} more have one within {tolerance} of it; {} of all expected by chance",
            explanation.near,
            to_digits(explanation.near_by_chance, 2)
        ),
    );
    if explanation.not_followed > 0 {
        let count = explanation.not_followed;
        row(
            "not followed",
            format!("{count} lie where no orbit was followed"),
        );
    }
    let left = |explaining: Explaining| {
        let all = explanation.all.iter();
        all.filter(move |own| own.explained == explaining)
    };
    let near: Vec<&Explained> = left(Explaining::Near).collect();
    let none: Vec<&Explained> = left(Explaining::None).collect();
    let not_followed: Vec<&Explained> = left(Explaining::NotFollowed).collect();
    list(
        text,
        "with a bifurcation near the bracket only",
        unit,
        &near,
    );
    list(text, "not explained", unit, &none);
    list(text, "where no orbit was followed", unit, &not_followed);
}

fn list(text: &mut String, title: &str, unit: &str, all: &[&Explained]) {
    if all.is_empty() {
        return;
    }
    _ = writeln!(text, "  {title}");
    for own in all.iter().take(MOST_ROWS) {
        let by = match own.by.is_empty() {
            true => String::new(),
            false => format!("  ({})", own.by.join(", ").replace('_', " ")),
        };
        _ = writeln!(text, "  {}{by}", line(&own.transition, unit));
    }
    if all.len() > MOST_ROWS {
        _ = writeln!(text, "    … and {} more", all.len() - MOST_ROWS);
    }
}

fn with_unit(words: &str, unit: &str) -> String {
    match unit {
        "" | "1" => words.to_owned(),
        unit => format!("{words} {unit}"),
    }
}

/// `3 fold, 8 period doubling`.
fn counted(counts: &BTreeMap<String, usize>) -> String {
    counted_as(counts, " ", ", ")
}

fn counted_as(counts: &BTreeMap<String, usize>, between: &str, joint: &str) -> String {
    let words = counts.iter();
    let words = words.map(|(word, count)| format!("{count}{between}{}", word.replace('_', " ")));
    let words: Vec<String> = words.collect();
    match words.is_empty() {
        true => "none".to_owned(),
        false => words.join(joint),
    }
}
