//! Which unit is meant by a length that no machine part has?

/// Diameters of shafts of gear drives \[m\].
pub(super) const DIAMETERS: [f64; 2] = [1e-3, 2.0];

/// Lengths of shafts of gear drives, and of their sections \[m\].
pub(super) const LENGTHS: [f64; 2] = [1e-4, 20.0];

/// Factors between m, mm and um, the likeliest first.
const FACTORS: [f64; 4] = [1e3, 1e-3, 1e6, 1e-6];

/// A message about a length \[m\] that is unusual for a `what`, with the length that was probably meant; `None` for a
/// usual length.
pub(super) fn of_length(metres: f64, what: &str, [least, most]: [f64; 2]) -> Option<String> {
    let fits = |length: &f64| (least..=most).contains(length);
    if fits(&metres) {
        return None;
    }
    let meant = FACTORS.map(|factor| factor * metres).into_iter().find(fits);
    let meant = meant.map_or(String::new(), |meant| {
        format!("; did you mean {}?", length(meant))
    });
    let [given, least, most] = [metres, least, most].map(length);
    Some(format!(
        "{given} is an unusual {what} (usual: {least} to {most}){meant}"
    ))
}

/// A length with four digits in m, mm or um.
pub(super) fn length(metres: f64) -> String {
    let (scale, unit) = match metres.abs() {
        size if size >= 1.0 => (1.0, "m"),
        size if size >= 1e-3 => (1e3, "mm"),
        _ => (1e6, "um"),
    };
    let four = format!("{:.3e}", scale * metres);
    match four.parse::<f64>() {
        Ok(rounded) if (1e-3..1e6).contains(&rounded.abs()) => format!("{rounded} {unit}"),
        _ => format!("{four} {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_a_unit_is_named() {
        let message_for = |metres| of_length(metres, "diameter", DIAMETERS);
        for (metres, own, meant) in [
            (0.035e-3, "35 um", "; did you mean 35 mm?"),
            (35.0, "35 m", "; did you mean 35 mm?"),
            (35e3, "35000 m", "; did you mean 35 mm?"),
            (1e-15, "1.000e-9 um", ""),
        ] {
            let expected = format!("{own} is an unusual diameter (usual: 1 mm to 2 m){meant}");
            assert_eq!(message_for(metres), Some(expected));
        }
        assert_eq!([1e-3, 0.035, 2.0].map(message_for), [None, None, None]);
    }
}
