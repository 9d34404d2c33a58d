//! Lines of `atlas check` about the resonances that a Campbell diagram of the same manifest marks.

use crate::report::{Campbell, Contacts, NEAR_GRID, Resonance, Unit};
use crate::units::short;

/// Largest number of resonances listed per order and state of the contacts.
const MOST_LISTED: usize = 6;

/// A speed as text, in the unit of `value`; only small values have decimals.
pub fn speed(value: f64) -> String {
    let decimals = match value.abs() {
        0.0 => 0,
        ..10.0 => 3,
        ..100.0 => 1,
        _ => 0,
    };
    short(value, decimals)
}

/// Label and text of each line about resonances, one line per order.
pub fn lines(diagram: &Campbell, unit: &Unit) -> Vec<(String, String)> {
    let [low, high] = diagram.grid.map(|speed| speed * unit.factor);
    let span = if low == high {
        speed(low)
    } else {
        format!("{} ... {}", speed(low), speed(high))
    };
    let intro = format!(
        "{} at which an order has the frequency of a mode, in the grid ({span}) or within {:.0} % of it",
        unit.text,
        100.0 * NEAR_GRID
    );
    let resonances = diagram.resonances();
    if resonances.is_empty() {
        return vec![("resonances".to_owned(), format!("none: no {intro}"))];
    }
    let mut lines = vec![("resonances".to_owned(), intro)];
    for ray in &diagram.rays {
        let of_ray = resonances.iter().filter(|one| one.excitation == ray.name);
        let of_ray: Vec<&Resonance> = of_ray.collect();
        let by_state = [Contacts::Closed, Contacts::Open].map(|contacts| {
            let of_state = of_ray.iter().filter(|one| one.contacts == contacts);
            let mut labels: Vec<String> = (of_state.clone().take(MOST_LISTED))
                .map(|one| format!("{} (mode {})", speed(one.speed * unit.factor), one.mode))
                .collect();
            let more = of_state.count().saturating_sub(MOST_LISTED);
            if more > 0 {
                labels.push(format!("{more} more"));
            }
            (!labels.is_empty()).then(|| format!("{} {}", contacts.name(), labels.join(", ")))
        });
        let by_state: Vec<String> = by_state.into_iter().flatten().collect();
        if !by_state.is_empty() {
            lines.push((
                String::new(),
                format!("{:<10} {}", ray.name, by_state.join("; ")),
            ));
        }
    }
    lines
}
