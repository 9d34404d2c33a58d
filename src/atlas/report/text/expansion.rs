//! Averages over unstable orbits, as text.

use crate::report::numbers::{number, to_digits};
use crate::report::summary::Summary;
use std::fmt::Write;

/// Points shown before the list is cut short.
const MOST_POINTS: usize = 8;

/// A block a point: the orbits of every order, then a line a quantity.
pub(super) fn push(text: &mut String, summary: &Summary) {
    if summary.expansions.is_empty() {
        return;
    }
    text.push_str("\naverages over unstable orbits, beside averages over as many cycles of time\n");
    for found in summary.expansions.iter().take(MOST_POINTS) {
        let list = |values: &[f64]| -> String {
            let short = values.iter().map(|value| to_digits(*value, 2));
            short.collect::<Vec<_>>().join(", ")
        };
        let orbits: Vec<String> = found.orbits.iter().map(u64::to_string).collect();
        _ = writeln!(
            text,
            "  point {}: {} prime orbits up to period {}\n    orbits        {}\n    unseen        {}\n    conservation  {}",
            found.point_id,
            found.orbits.iter().sum::<u64>(),
            found.order,
            orbits.join(", "),
            list(&found.unseen),
            list(&found.conservation),
        );
        _ = writeln!(
            text,
            "    {:<18}{:<24}{:<24}time",
            "", "zeta function", "determinant"
        );
        for average in &found.averages {
            let line = format!(
                "    {:<18}{:<24}{:<24}{}",
                average.quantity,
                with_error(average.zeta),
                with_error(average.determinant),
                with_error(average.time)
            );
            _ = writeln!(text, "{}", line.trim_end());
        }
    }
    if summary.expansions.len() > MOST_POINTS {
        let more = summary.expansions.len() - MOST_POINTS;
        _ = writeln!(text, "  … and {more} more points");
    }
}

/// `0.6872 ± 0.0014`, or a dash where there is no value.
fn with_error([value, error]: [Option<f64>; 2]) -> String {
    match (value, error) {
        (None, _) => "-".to_owned(),
        (Some(value), None) => number(value),
        (Some(value), Some(error)) => format!("{} ± {}", number(value), to_digits(error, 2)),
    }
}
