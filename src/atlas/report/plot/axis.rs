//! An axis of a panel: its range, its ticks, and a label with name and unit.
//!
//! Values are in SI. Ticks and label are in a scaled unit (µm, kN, 10⁶ …). If the unit takes prefixes, or if values are
//! very small or large, the largest shown value has one to three digits before the point.

use crate::report::numbers::{number, to_digits};

/// Units that take SI prefixes.
pub(in crate::report) const PREFIXABLE: [&str; 11] = [
    "m", "m/s", "N", "N/m", "N*m", "N*s/m", "s", "Hz", "rad", "B/s", "op/s",
];
const PREFIXES: [(f64, &str); 7] = [
    (1e-9, "n"),
    (1e-6, "µ"),
    (1e-3, "m"),
    (1.0, ""),
    (1e3, "k"),
    (1e6, "M"),
    (1e9, "G"),
];

/// Values further from zero are drawn at this value, so that sums and quotients of drawn values stay finite.
const LARGEST: f64 = 1e290;

/// A range whose larger end is smaller than this is drawn as zero.
const SMALLEST: f64 = 1e-290;

/// Smallest relative width of a range. In narrower ranges, neighbouring ticks would have equal texts.
const NARROWEST: f64 = 1e-9;

/// Largest number of evenly spaced ticks that is requested when smaller numbers give only one tick.
const MOST_WANTED: usize = 8;

/// Largest distance of a position beyond a panel, in sides of the panel.
const FARTHEST_OUTSIDE: f64 = 20.0;

/// A range of values along one side of a panel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    /// Label: the name with the shown unit.
    pub label: String,
    low: f64,
    high: f64,
    logarithmic: bool,
    /// Whether ticks are at powers of two, in KiB, MiB, …
    binary: bool,
    /// Factor from SI to the shown unit.
    factor: f64,
    /// Unit of shown values.
    unit: String,
}

impl Axis {
    /// A linear axis over `low..=high`, widened if the range has only one value.
    pub fn linear(name: &str, unit: &str, range: [f64; 2]) -> Self {
        let [low, high] = padded(ordered(range), 0.0);
        let (factor, shown) = scaled_unit(unit, low.abs().max(high.abs()));
        Self {
            label: format!("{name} [{shown}]"),
            low,
            high,
            logarithmic: false,
            binary: false,
            factor,
            unit: shown,
        }
    }

    /// A logarithmic axis over `low..=high`. If `low` is not positive, the axis begins six decades below
    /// `high`.
    pub fn logarithmic(name: &str, unit: &str, range: [f64; 2]) -> Self {
        let [low, high] = positive(range);
        Self {
            low,
            high,
            logarithmic: true,
            ..Self::linear(name, unit, [low, high])
        }
    }

    /// A logarithmic axis of numbers of bytes over `low..=high`, both positive.
    pub fn bytes(name: &str, range: [f64; 2]) -> Self {
        let [low, high] = positive(range);
        Self {
            label: name.to_owned(),
            low,
            high,
            logarithmic: true,
            binary: true,
            factor: 1.0,
            unit: "B".to_owned(),
        }
    }

    /// An axis for grid values, logarithmic if they are logarithmically spaced.
    pub fn for_grid(name: &str, unit: &str, values: &[f64]) -> Self {
        if let [first, .., last] = values
            && *first > 0.0
            && last / first > 8.0
        {
            let middle = values[values.len() / 2];
            let [linear, geometric] = [0.5 * (first + last), (first * last).sqrt()];
            if (middle / geometric).ln().abs() < (middle / linear).ln().abs() {
                let margin = (last / first).powf(0.02);
                return Self::logarithmic(name, unit, [first / margin, last * margin]);
            }
        }
        Self::linear(name, unit, padded(range(values.iter().copied()), 0.02))
    }

    /// This axis in another unit; one SI unit is `factor` of these units.
    pub fn in_unit(mut self, name: &str, unit: &str, factor: f64) -> Self {
        self.label = format!("{name} [{unit}]");
        self.unit = unit.to_owned();
        self.factor = factor;
        self
    }

    /// Position of a value: 0 at the low end, 1 at the high end. It is clamped far beyond the ends, where
    /// nothing is visible. NaN for NaN, and for a negative value on a logarithmic axis.
    pub fn fraction(&self, value: f64) -> f64 {
        let fraction = if self.logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        fraction.clamp(-FARTHEST_OUTSIDE, 1.0 + FARTHEST_OUTSIDE)
    }

    /// About `wanted` ticks: values with their texts.
    pub fn ticks(&self, wanted: usize) -> Vec<(f64, String)> {
        if self.binary {
            return self.binary_ticks(wanted);
        }
        if self.logarithmic {
            let ticks = self.decade_ticks(wanted);
            // A range within one decade may contain no tick at 1, 2 or 5, or only one. It gets evenly spaced
            // ticks instead.
            if ticks.len() > 1 || self.high > 10.0 * self.low {
                return ticks;
            }
        }
        self.even_ticks(wanted)
    }

    fn even_ticks(&self, wanted: usize) -> Vec<(f64, String)> {
        let (low, high) = (self.low * self.factor, self.high * self.factor);
        let step = nice_step((high - low) / wanted.max(1) as f64);
        let digits = (-(step * 1.000_001).log10().floor()).max(0.0) as usize;
        let first = (low / step - 1e-9).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        // A single tick does not show the scale: request one more.
        if first >= last && wanted < MOST_WANTED {
            return self.even_ticks(wanted + 1);
        }
        (first..=last)
            .map(|index| {
                let shown = index as f64 * step;
                (shown / self.factor, minus(format!("{shown:.digits$}")))
            })
            .collect()
    }

    fn decade_ticks(&self, wanted: usize) -> Vec<(f64, String)> {
        let (low, high) = (self.low * self.factor, self.high * self.factor);
        let decades = (high / low).log10();
        let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
        let mantissas: &[f64] = if decades < 2.2 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let stride = (decades / wanted.max(1) as f64).ceil().max(1.0) as i32;
        let mut ticks = Vec::new();
        for exponent in (first..=last).filter(|exponent| exponent.rem_euclid(stride) == 0) {
            for mantissa in mantissas {
                let shown = mantissa * 10f64.powi(exponent);
                if shown >= low * (1.0 - 1e-9) && shown <= high * (1.0 + 1e-9) {
                    let text = if (-2..=3).contains(&exponent) {
                        format!("{:.*}", (-exponent).max(0) as usize, shown)
                    } else if *mantissa == 1.0 {
                        power_of_ten(exponent)
                    } else {
                        format!("{mantissa}·{}", power_of_ten(exponent))
                    };
                    ticks.push((shown / self.factor, text));
                }
            }
        }
        ticks
    }

    fn binary_ticks(&self, wanted: usize) -> Vec<(f64, String)> {
        let octaves = (self.high / self.low).log2();
        let stride = (octaves / wanted.max(1) as f64).ceil().max(1.0) as i32;
        let range = self.low.log2().ceil() as i32..=self.high.log2().floor() as i32;
        let whole = |bytes: f64| {
            let text = crate::report::size_text(bytes as u64);
            text.replacen(".0 ", " ", 1)
        };
        range
            .filter(|exponent| exponent.rem_euclid(stride) == 0)
            .map(|exponent| f64::from(exponent).exp2())
            .map(|bytes| (bytes, whole(bytes)))
            .collect()
    }

    /// A value in the shown unit, with two significant digits.
    pub fn briefly(&self, value: f64) -> String {
        minus(to_digits(value * self.factor, 2))
    }

    /// A value in the shown unit, with the digits of [`number`].
    pub fn shown(&self, value: f64) -> String {
        minus(number(value * self.factor))
    }

    /// A value in the shown unit, with three significant digits and the unit: `12.5 µm`.
    pub fn with_unit(&self, value: f64) -> String {
        let shown = minus(to_digits(value * self.factor, 3));
        match self.unit.as_str() {
            "–" => shown,
            unit => format!("{shown} {unit}"),
        }
    }
}

/// The scaled unit for values up to `largest`, given in the SI unit `unit`: the factor from SI, and the unit
/// as text.
pub(super) fn scaled_unit(unit: &str, largest: f64) -> (f64, String) {
    let readable = if unit.is_empty() || unit == "1" {
        "–".to_owned()
    } else {
        unit.replace('*', "·")
    };
    if largest <= 0.0 || !largest.is_finite() {
        return (1.0, readable);
    }
    if PREFIXABLE.contains(&unit) && (1e-12..1e15).contains(&largest) {
        let fitting = PREFIXES
            .iter()
            .rev()
            .find(|(size, _)| largest >= size * 0.999_999);
        let (size, prefix) = fitting.unwrap_or(&PREFIXES[0]);
        return (1.0 / size, format!("{prefix}{readable}"));
    }
    if (1e-3..1e5).contains(&largest) {
        return (1.0, readable);
    }
    // The clamp keeps the power of ten finite for the smallest numbers.
    let exponent = 3 * (largest.log10() / 3.0).floor().clamp(-100.0, 100.0) as i32;
    let power = power_of_ten(exponent);
    let shown = match unit {
        "" | "1" => power,
        _ => format!("{power} {readable}"),
    };
    (10f64.powi(-exponent), shown)
}

/// A value in a scaled unit, with the digits of [`number`] and the unit: `12.5 µm`.
pub(super) fn value_words(value: f64, unit: &str) -> String {
    let (factor, unit) = scaled_unit(unit, value.abs());
    let shown = minus(number(value * factor));
    match unit.as_str() {
        "–" => shown,
        unit => format!("{shown} {unit}"),
    }
}

/// A range of values in one scaled unit: `1.2 … 12.5 µm`.
pub(super) fn span_words([low, high]: [f64; 2], unit: &str) -> String {
    let (factor, shown) = scaled_unit(unit, low.abs().max(high.abs()));
    let [low, high] = [low, high].map(|value| minus(to_digits(value * factor, 3)));
    if low == high {
        format!("{low} {shown}")
    } else {
        format!("{low} … {high} {shown}")
    }
}

/// `10⁻⁶`.
fn power_of_ten(exponent: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + (digit as u32 - '0' as u32)).unwrap_or(digit),
    };
    format!(
        "10{}",
        exponent.to_string().chars().map(raised).collect::<String>()
    )
}

/// A number with a true minus sign, but without a sign before zero.
fn minus(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// The smallest of 1, 2, 5 times a power of ten that is at least `step`.
fn nice_step(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    let mantissa = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|m| m * power >= step * (1.0 - 1e-9));
    mantissa.unwrap_or(10.0) * power
}

/// The ends of a range in ascending order, clamped to [`LARGEST`]; `[0, 1]` if one is NaN.
fn ordered([low, high]: [f64; 2]) -> [f64; 2] {
    if low.is_nan() || high.is_nan() {
        return [0.0, 1.0];
    }
    let [low, high] = [low.min(high), low.max(high)];
    [low, high].map(|end| end.clamp(-LARGEST, LARGEST))
}

/// The ends of a range for a logarithmic axis: ascending, positive and different.
fn positive(range: [f64; 2]) -> [f64; 2] {
    let [low, high] = ordered(range);
    let high = if high > SMALLEST { high } else { 1.0 };
    // A range that begins at or below zero gets six decades: smaller values are not visible anyway.
    let low = if low > SMALLEST { low } else { 1e-6 * high };
    if low < high * (1.0 - NARROWEST) {
        [low, high]
    } else {
        [0.5 * high, 2.0 * high].map(|end| end.min(LARGEST))
    }
}

/// Smallest and largest value; `[0, 1]` if there is none.
pub(super) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let bounds = values
        .filter(|value| value.is_finite())
        .map(|value| value.clamp(-LARGEST, LARGEST))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        });
    if bounds[0] <= bounds[1] { bounds } else { [0.0, 1.0] }
}

/// A range with a margin (a fraction of its width) on both sides; never empty.
pub(super) fn padded([low, high]: [f64; 2], margin: f64) -> [f64; 2] {
    let width = high - low;
    let magnitude = low.abs().max(high.abs());
    if width > NARROWEST * magnitude && magnitude > SMALLEST {
        return [low - margin * width, high + margin * width];
    }
    // A single value: the room around it is proportional to its size.
    let room = if magnitude > SMALLEST { 0.5 * magnitude } else { 1.0 };
    [low - room, high + room]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(ticks: &[(f64, String)]) -> Vec<&str> {
        ticks.iter().map(|(_, text)| text.as_str()).collect()
    }

    #[test]
    fn a_deflection_is_shown_in_micrometres() {
        let axis = Axis::linear("deflection", "m", [-2e-5, 3e-5]);
        assert_eq!(axis.label, "deflection [µm]");
        let ticks = axis.ticks(5);
        assert_eq!(texts(&ticks), ["−20", "−10", "0", "10", "20", "30"]);
        assert!((ticks[0].0 + 2e-5).abs() < 1e-18);
        assert!((axis.fraction(ticks[2].0) - 0.4).abs() < 1e-12);
    }

    #[test]
    fn a_low_panel_has_more_than_one_tick() {
        let axis = Axis::linear("force", "N", [-3700.0, 4300.0]);
        assert_eq!(texts(&axis.ticks(2)), ["−2", "0", "2", "4"]);
    }

    #[test]
    fn units_are_scaled_only_where_it_helps() {
        assert_eq!(scaled_unit("N", 5475.0), (1e-3, "kN".into()));
        assert_eq!(scaled_unit("rad/s", 1500.0), (1.0, "rad/s".into()));
        assert_eq!(scaled_unit("1", 0.3), (1.0, "–".into()));
        assert_eq!(scaled_unit("1", 2e-7).1, "10⁻⁹");
        assert_eq!(scaled_unit("N*m", 50.0).1, "N·m");
        assert_eq!(scaled_unit("m", 0.0), (1.0, "m".into()));
    }

    #[test]
    fn decades_are_thinned_and_short_ranges_are_filled() {
        let wide = Axis::logarithmic("a", "1", [1e-4, 1e4]);
        assert_eq!(texts(&wide.ticks(4)), ["10⁻⁴", "0.01", "1", "100", "10⁴"]);
        let short = Axis::logarithmic("a", "1", [0.8, 60.0]);
        assert_eq!(texts(&short.ticks(5)), ["1", "2", "5", "10", "20", "50"]);
    }

    #[test]
    fn a_logarithmic_axis_over_a_fraction_of_a_decade_has_even_ticks() {
        let axis = Axis::logarithmic("a", "1", [0.81, 0.9]);
        assert_eq!(texts(&axis.ticks(4)), ["0.85", "0.90"]);
    }

    #[test]
    fn values_are_written_with_a_unit_that_suits_them() {
        assert_eq!(value_words(1.029, "m"), "1.029 m");
        assert_eq!(value_words(-1.25e-5, "m"), "−12.5 µm");
        assert_eq!(value_words(1200.0, "rad/s"), "1200 rad/s");
        assert_eq!(value_words(0.05, "1"), "0.05");
        assert_eq!(span_words([1.2e-6, 1.25e-5], "m"), "1.2 … 12.5 µm");
        assert_eq!(span_words([3e-6, 3.0001e-6], "m"), "3 µm");
    }

    #[test]
    fn bytes_are_counted_in_powers_of_two() {
        let axis = Axis::bytes("size", [6e3, 300e6]);
        assert_eq!(
            texts(&axis.ticks(5)),
            ["64 KiB", "1 MiB", "16 MiB", "256 MiB"]
        );
    }

    #[test]
    fn grids_with_equal_ratios_get_a_logarithmic_axis() {
        let ratios: Vec<f64> = (0..6).map(|i| 1e-6 * 2f64.powi(i)).collect();
        let axis = Axis::for_grid("gap", "m", &ratios);
        let steps: Vec<f64> = ratios.iter().map(|v| axis.fraction(*v)).collect();
        assert!((steps[1] - steps[0] - (steps[5] - steps[4])).abs() < 1e-12);
        let even: Vec<f64> = (1..20).map(f64::from).collect();
        let axis = Axis::for_grid("n", "1", &even);
        assert!((axis.fraction(10.0) - 0.5).abs() < 1e-12);
    }

    /// For any range, ticks are few and positions are finite. The test counts ticks, so that an endless loop shows as
    /// too many.
    #[test]
    fn ticks_of_extreme_ranges_are_few_and_inside() {
        let ends = [
            f64::NAN,
            f64::NEG_INFINITY,
            f64::MIN,
            -1e300,
            -1.0,
            -5e-324,
            0.0,
            5e-324,
            2.3e-308,
            1e-20,
            1.0,
            1.0 + f64::EPSILON,
            1e17,
            1e300,
            f64::MAX,
            f64::INFINITY,
        ];
        for low in ends {
            for high in ends {
                for unit in ["1", "m", "rad/s"] {
                    let axes = [
                        Axis::linear("a", unit, [low, high]),
                        Axis::logarithmic("a", unit, [low, high]),
                        Axis::bytes("a", [low, high]),
                        Axis::for_grid("a", unit, &[low, low, high]),
                        Axis::linear("a", unit, padded(range([low, high].into_iter()), 0.05)),
                    ];
                    for axis in axes {
                        let ticks = axis.ticks(5);
                        assert!(ticks.len() <= 64, "{axis:?}: {} ticks", ticks.len());
                        for (value, text) in ticks {
                            let place = axis.fraction(value);
                            assert!((-0.01..=1.01).contains(&place), "{axis:?}: {value}");
                            assert!(text.chars().count() < 30, "{axis:?}: {text}");
                        }
                        for value in ends.into_iter().filter(|v| !v.is_nan()) {
                            let place = axis.fraction(value);
                            assert!(place.is_nan() || place.abs() <= 21.0, "{axis:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_range_is_never_empty() {
        for range in [[0.0, 0.0], [3.0, 3.0], [-1e-30, -1e-30], [5e-324, 5e-324]] {
            let [low, high] = padded(range, 0.05);
            assert!(low < range[0] && range[0] < high);
        }
    }
}
