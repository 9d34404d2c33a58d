//! Which orders of the mesh and of the shafts meet natural frequencies at the speeds of a grid, for
//! `atlas check`.

use serde_json::{Value, json};
use std::f64::consts::PI;

/// How far outside the grid's speeds a resonance is still told, as a part of them.
const MARGIN: f64 = 0.1;

/// Resonances of an order that are told.
const MOST: usize = 6;

/// An order that meets a mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Resonance {
    /// `mesh x 2`, `pinion x 1`.
    order: String,
    /// Whether the contacts that bear the static load are closed.
    closed: bool,
    /// The mode, from 1.
    mode: usize,
    /// Pinion speed \[rad/s\].
    speed: f64,
}

/// Where orders, by their name and turns per turn of the pinion, meet frequencies \[rad/s\] of modes with
/// contacts closed and open, in or near a range of pinion speeds \[rad/s\].
pub fn near(
    orders: &[(String, f64)],
    [closed, open]: [&[f64]; 2],
    speeds: (f64, f64),
) -> Vec<Resonance> {
    let range = speeds.0.min(speeds.1) * (1.0 - MARGIN)..=speeds.0.max(speeds.1) * (1.0 + MARGIN);
    let mut found = Vec::new();
    for (order, turns) in orders {
        for (closed, modes) in [(true, closed), (false, open)] {
            let speeds = modes
                .iter()
                .enumerate()
                .filter(|(_, frequency)| **frequency > 0.0);
            let meets = speeds.map(|(mode, frequency)| (mode + 1, frequency / turns));
            found.extend(
                meets
                    .filter(|(_, speed)| range.contains(speed))
                    .map(|(mode, speed)| Resonance {
                        order: order.clone(),
                        closed,
                        mode,
                        speed,
                    }),
            );
        }
    }
    found
}

/// Head and text of their lines, an order a line.
pub fn lines(found: &[Resonance], (low, high): (f64, f64)) -> Vec<(String, String)> {
    let span = match low == high {
        true => format!("{:.0}", rpm(low)),
        false => format!("{:.0} ... {:.0}", rpm(low), rpm(high)),
    };
    let intro =
        format!("rpm at which an order meets a mode, in or within 10 % of the grid's {span}");
    if found.is_empty() {
        return vec![("resonances".to_owned(), format!("none: no {intro}"))];
    }
    let mut lines = vec![("resonances".to_owned(), intro)];
    for orders in found.chunk_by(|one, other| one.order == other.order) {
        let states = orders
            .chunk_by(|one, other| one.closed == other.closed)
            .map(|modes| {
                let mut told: Vec<String> = (modes.iter().take(MOST))
                    .map(|one| format!("{:.0} (mode {})", rpm(one.speed), one.mode))
                    .collect();
                if modes.len() > MOST {
                    told.push(format!("{} more", modes.len() - MOST));
                }
                let state = if modes[0].closed { "closed" } else { "open" };
                format!("{state} {}", told.join(", "))
            });
        let told = states.collect::<Vec<_>>().join("; ");
        lines.push((String::new(), format!("{:<11}{told}", orders[0].order)));
    }
    lines
}

/// The same for programs.
pub fn json(found: &[Resonance]) -> Value {
    let each = found.iter().map(|one| {
        json!({
            "order": one.order,
            "contacts": if one.closed { "closed" } else { "open" },
            "mode": one.mode,
            "speed": one.speed,
            "rpm": rpm(one.speed),
        })
    });
    Value::Array(each.collect())
}

fn rpm(speed: f64) -> f64 {
    speed * 30.0 / PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_meet_modes_where_their_frequencies_are_equal() {
        let orders = [("mesh x 1".to_owned(), 20.0), ("wheel x 1".to_owned(), 0.5)];
        let found = near(
            &orders,
            [&[0.0, 2000.0, 9000.0], &[0.0, 40.0]],
            (95.0, 380.0),
        );
        let told: Vec<_> = found
            .iter()
            .map(|one| (&*one.order, one.closed, one.mode, one.speed))
            .collect();
        // 9000/20 lies more than a tenth above 380, 40/0.5 more than a tenth below 95.
        assert_eq!(told, [("mesh x 1", true, 2, 100.0)]);
        let text = lines(&found, (95.0, 380.0));
        assert_eq!(text[1].1, "mesh x 1   closed 955 (mode 2)");
        assert_eq!(json(&found)[0]["rpm"].as_f64().unwrap().round(), 955.0);
        assert!(lines(&[], (95.0, 95.0))[0].1.starts_with("none"));
    }
}
