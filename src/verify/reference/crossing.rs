//! When does a contact change its state within a step? The margin of the contact is sampled, and its minima
//! and its zero are located.

/// Margin of a contact and its rate. The margin is positive as long as the contact keeps its state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Margin {
    /// Margin \[m\]; \[N\] if it is a force.
    pub value: f64,
    /// Rate of the margin \[m/s\]; \[N/s\] if it is a force.
    pub rate: f64,
}

/// Time since the start of a step \[s\], and the margin there.
pub(super) type Sample = (f64, Margin);

impl Margin {
    /// The margin of a contact with a side (+1 or −1), from the deflection, the gap and their rates.
    pub fn new(
        side: f64,
        closed: bool,
        (deflection, rate): (f64, f64),
        [gap, opening]: [f64; 2],
    ) -> Self {
        let inside = if closed { 1.0 } else { -1.0 };
        Self {
            value: inside * (side * deflection - gap),
            rate: inside * (side * rate - opening),
        }
    }
}

/// The first time in a step at which the margin becomes negative; `None` if it stays positive.
///
/// `samples` are (time from the step's start, margin) in ascending order, the first one at 0, where the margin counts
/// as positive despite its round-off. `exact` returns the margin at any time of the step to round-off. Times are
/// resolved to `resolution`.
pub(super) fn first_crossing(
    samples: &[Sample],
    resolution: f64,
    mut exact: impl FnMut(f64) -> Margin,
) -> Option<f64> {
    for (i, pair) in samples.windows(2).enumerate() {
        let [(left, before), (right, after)] = [pair[0], pair[1]];
        // Samples are less accurate than `exact`. If a sample and the exact margin have different signs, the
        // margin is zero within the error of the sample. The exact margin then decides whether there is a
        // crossing, and on which side of the left sample it is.
        if after.value < 0.0 && exact(right).value < 0.0 {
            let left = match i.checked_sub(1) {
                Some(earlier) if exact(left).value < 0.0 => samples[earlier].0,
                _ => left,
            };
            return Some(zero(left, right, resolution, exact));
        }
        if before.rate < 0.0 && after.rate >= 0.0 {
            // Twice the distance that the rates can cover. A minimum farther from the surface need not be
            // computed.
            let reach = 2.0 * before.rate.abs().max(after.rate) * (right - left);
            if before.value > reach {
                continue;
            }
            let minimum = minimum(left, right, resolution, &mut exact);
            if exact(minimum).value < 0.0 {
                return Some(zero(left, minimum, resolution, exact));
            }
        }
    }
    None
}

/// Time of the minimum of the margin, by bisection on the sign of its rate.
fn minimum(
    mut left: f64,
    mut right: f64,
    resolution: f64,
    mut exact: impl FnMut(f64) -> Margin,
) -> f64 {
    // The square root of the resolution would be enough, because the margin is flat at its minimum. The full
    // resolution costs little.
    while right - left > resolution {
        let middle = 0.5 * (left + right);
        if middle <= left || middle >= right {
            break;
        }
        if exact(middle).rate < 0.0 {
            left = middle;
        } else {
            right = middle;
        }
    }
    0.5 * (left + right)
}

/// Time of the zero of the margin in (left, right], by Newton's method kept inside the bracket.
fn zero(
    mut left: f64,
    mut right: f64,
    resolution: f64,
    mut exact: impl FnMut(f64) -> Margin,
) -> f64 {
    let mut time = right;
    while right - left > resolution {
        let margin = exact(time);
        if margin.value < 0.0 {
            right = time;
        } else {
            left = time;
        }
        let mut next = time - margin.value / margin.rate;
        // If the step is not finite or outside the bracket, bisect.
        if !(next > left && next < right) {
            if (next - time).abs() <= resolution {
                break;
            }
            next = 0.5 * (left + right);
        }
        let moved = (next - time).abs();
        time = next;
        if moved <= resolution {
            break;
        }
    }
    time
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first crossing of a function (value, rate), sampled at the given times.
    fn crossing(f: impl Fn(f64) -> (f64, f64), times: &[f64]) -> Option<f64> {
        let margin = |t: f64| {
            let (value, rate) = f(t);
            Margin { value, rate }
        };
        let samples: Vec<_> = times.iter().map(|&t| (t, margin(t))).collect();
        first_crossing(&samples, 1e-17, margin)
    }

    const TIMES: [f64; 5] = [0.0, 0.2, 0.5, 0.8, 1.0];

    #[test]
    fn simple_crossing_is_found_to_round_off() {
        let t = crossing(|t| (0.7 - t, -1.0), &TIMES).unwrap();
        assert!((t - 0.7).abs() < 2e-16);
        assert_eq!(crossing(|t| (1.1 - t, -1.0), &TIMES), None);
    }

    #[test]
    fn grazing_pair_between_samples_is_found_and_a_near_miss_is_not_invented() {
        // Roots at 0.6 ± 10⁻⁵, far closer than the samples.
        let graze = |gap: f64| move |t: f64| ((t - 0.6).powi(2) + gap, 2.0 * (t - 0.6));
        let t = crossing(graze(-1e-10), &TIMES).unwrap();
        assert!((t - (0.6 - 1e-5)).abs() < 1e-11, "{t}");
        assert_eq!(crossing(graze(1e-10), &TIMES), None);
        assert_eq!(crossing(graze(0.0), &TIMES), None);
    }

    #[test]
    fn zero_at_the_start_is_not_a_crossing_but_its_return_is() {
        // Starts on the surface (below it by round-off), leaves, returns at 0.3.
        let f = |t: f64| (t * (0.3 - t) - 1e-18, 0.3 - 2.0 * t);
        let t = crossing(f, &TIMES).unwrap();
        assert!((t - 0.3).abs() < 1e-15);
        // Returns before the first sample.
        let f = |t: f64| (t * (0.1 - t), 0.1 - 2.0 * t);
        let t = crossing(f, &TIMES).unwrap();
        assert!((t - 0.1).abs() < 1e-15, "{t}");
    }

    #[test]
    fn of_two_crossings_the_first_is_returned() {
        let f = |t: f64| ((t - 0.55) * (t - 0.75), 2.0 * t - 1.3);
        let t = crossing(f, &TIMES).unwrap();
        assert!((t - 0.55).abs() < 1e-15, "{t}");
    }

    #[test]
    fn error_of_a_sample_does_not_move_the_crossing() {
        let exact = |t: f64| Margin {
            value: 0.5 - 1e-12 - t,
            rate: -1.0,
        };
        let mut samples = TIMES.map(|t| (t, exact(t)));
        // The exact margin at 0.5 is negative, but the sample is positive. Then the reverse.
        samples[2].1.value = 1e-11;
        let t = first_crossing(&samples, 1e-17, exact).unwrap();
        assert!((t - (0.5 - 1e-12)).abs() < 2e-16, "{t}");
        let exact = |t: f64| Margin {
            value: 0.5 + 1e-12 - t,
            rate: -1.0,
        };
        samples[2].1.value = -1e-11;
        let t = first_crossing(&samples, 1e-17, exact).unwrap();
        assert!((t - (0.5 + 1e-12)).abs() < 2e-16, "{t}");
    }

    #[test]
    fn the_margin_is_positive_while_a_contact_stays_what_it_is() {
        let margin = |side, closed, deflection| {
            let margin = Margin::new(side, closed, (deflection, 0.5), [1.0, 0.0]);
            (margin.value, margin.rate)
        };
        assert_eq!(margin(1.0, true, 1.5), (0.5, 0.5));
        assert_eq!(margin(-1.0, true, -1.5), (0.5, -0.5));
        assert_eq!(margin(1.0, false, 0.5), (0.5, -0.5));
        assert_eq!(margin(-1.0, false, -0.5), (0.5, 0.5));
    }
}
