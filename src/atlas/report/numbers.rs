//! Numbers as text for readers.

pub(super) use crate::units::plural;

/// A number with four significant digits, or with all digits before the point if these are five or six.
/// Without trailing zeros.
pub(super) fn number(value: f64) -> String {
    let before_point = value.abs().log10().floor() + 1.0;
    if (4.0..=6.0).contains(&before_point) {
        to_digits(value, before_point as usize)
    } else {
        to_digits(value, 4)
    }
}

/// A number with this many significant digits, without trailing zeros: `0.05`, `4.4e8`.
pub fn to_digits(value: f64, digits: usize) -> String {
    let rounded = format!("{value:.*e}", digits.saturating_sub(1)).parse();
    let rounded: f64 = rounded.unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
        format!("{}", rounded + 0.0)
    } else {
        format!("{rounded:e}")
    }
}

/// A number of bytes: `512 B`, `1.5 MiB`.
pub fn size_text(bytes: u64) -> String {
    let mut size = bytes as f64;
    let mut units = ["B", "KiB", "MiB", "GiB", "TiB"].into_iter();
    let mut unit = units.next();
    while size >= 1024.0
        && let Some(larger) = units.next()
    {
        size /= 1024.0;
        unit = Some(larger);
    }
    let digits = usize::from(bytes >= 1024 && size < 100.0);
    format!("{size:.digits$} {}", unit.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_readable() {
        let texts = [0, 1023, 1024, 1_572_864, 150 << 20, 5 << 50].map(size_text);
        let wanted = ["0 B", "1023 B", "1.0 KiB", "1.5 MiB", "150 MiB", "5120 TiB"];
        assert_eq!(texts, wanted);
    }
}
