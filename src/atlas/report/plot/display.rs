//! The display of values: units, decibels with a reference, logarithmic axes, and the range.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use clap::ValueEnum;
use serde::Serialize;

use super::axis::{Axis, padded, scaled_unit};
use super::error::PlotError;
use crate::report::numbers::number;
use crate::units;

/// Requested display of values.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Display {
    /// Units for the quantities that they fit. Other quantities have the unit of the manifest, or SI with
    /// prefixes.
    pub units: Vec<String>,
    /// Reference amplitude: values are shown as decibels relative to it.
    pub decibels: Option<Amount>,
    /// Which axes are logarithmic; by default the horizontal axis if its values are logarithmically spaced.
    pub log: Option<Log>,
    /// Lowest and highest value shown.
    pub range: Option<[Amount; 2]>,
}

/// Which axes are logarithmic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Log {
    /// The horizontal axis.
    X,
    /// The vertical axis.
    Y,
    /// Both.
    Xy,
}

/// A number, with a unit or in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Amount {
    number: f64,
    unit: String,
}

/// The text is not a number with a known unit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not a number, bare (SI) or with a unit such as \"1 um\" or \"20 N\"")]
pub struct NoAmount {
    text: String,
}

impl FromStr for Amount {
    type Err = NoAmount;

    fn from_str(text: &str) -> Result<Self, NoAmount> {
        let refused = || NoAmount {
            text: text.to_owned(),
        };
        let (number, unit) = units::split(text).ok_or_else(refused)?;
        if !unit.is_empty() && units::conversion(unit, unit).is_none() {
            return Err(refused());
        }
        Ok(Self {
            number,
            unit: unit.to_owned(),
        })
    }
}

impl fmt::Display for Amount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.number, self.unit)
    }
}

impl Amount {
    /// The range from this amount to `high`. If this amount has no unit, it gets that of `high`. `None` if `high` is
    /// not larger. Amounts without a common unit are not compared here: `Scale::new` compares them, because a bare
    /// number is in the SI unit of the quantity.
    pub fn up_to(mut self, high: Self) -> Option<[Self; 2]> {
        if self.unit.is_empty() {
            self.unit.clone_from(&high.unit);
        }
        let low = if self.unit == high.unit { Some(self.number) } else { self.si(&high.unit) };
        low.is_none_or(|low| low < high.number)
            .then_some([self, high])
    }

    /// The amount in the SI unit `si`; `None` if its unit belongs to another quantity.
    fn si(&self, si: &str) -> Option<f64> {
        match self.unit.as_str() {
            "" => Some(self.number),
            unit => Some(self.number * units::conversion(unit, si)?),
        }
    }
}

/// A unit of shown values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Unit {
    /// Number of these units in one SI unit.
    pub factor: f64,
    /// The unit as text, such as `µm`.
    pub text: String,
}

impl Unit {
    /// A unit for values with the unit `si`; `None` if it belongs to another quantity.
    pub fn of(unit: &str, si: &str) -> Option<Self> {
        let text = unit.trim().replace('*', "·").replace("um", "µm");
        Some(Self {
            factor: units::conversion(si, unit)?,
            text: text.replace("^2", "²").replace("^3", "³"),
        })
    }

    /// The unit that a manifest gives the axis `name`, else the unit `si`.
    pub fn of_axis(written: &BTreeMap<String, String>, name: &str, si: &str) -> Self {
        Self::or_si(written.get(name).map(String::as_str), si)
    }

    /// The unit `written`, if it is given and fits `si`, else the unit `si`.
    pub fn or_si(written: Option<&str>, si: &str) -> Self {
        let of_unit = written.and_then(|unit| Self::of(unit, si));
        of_unit.unwrap_or_else(|| Self {
            factor: 1.0,
            text: if si == "1" { "" } else { si }.to_owned(),
        })
    }

    /// `6000 rpm` for a value in SI; `number` formats its digits.
    pub fn amount(&self, number: impl Fn(f64) -> String, value: f64) -> String {
        self.after(&number(value * self.factor))
    }

    /// A text of numbers in this unit, followed by the unit.
    pub fn after(&self, text: &str) -> String {
        format!("{text} {}", self.text).trim_end().to_owned()
    }

    /// The first of `units` that fits values with the unit `si`; `None` if none fits.
    pub fn first(units: &[String], si: &str) -> Option<Self> {
        units.iter().find_map(|unit| Self::of(unit, si))
    }

    /// The scaled unit for values up to `largest`, such as µm.
    pub fn fitting(si: &str, largest: f64) -> Self {
        let (factor, text) = scaled_unit(si, largest.abs());
        Self { factor, text }
    }

    /// A value in SI with its name, in this unit: `speed 6000 rpm`; without a unit if dimensionless.
    pub fn words(&self, name: &str, value: f64) -> String {
        let text = format!("{name} {} {}", number(value * self.factor), self.text);
        text.trim_end_matches(['–', ' ']).to_owned()
    }
}

/// The display of the values of one column.
pub(super) struct Scale {
    name: String,
    si: String,
    unit: Option<Unit>,
    /// Reference of decibels in SI.
    reference: Option<f64>,
    logarithmic: bool,
    range: [Option<f64>; 2],
}

/// Round-off limit, relative to the largest value of a quantity.
const ROUND_OFF: f64 = 1e-9;

/// Unit of powers. A power is proportional to the square of an amplitude, so that its level has 10 dB per
/// factor of 10.
const POWER: &str = "W";

impl Scale {
    /// The scale for values with a name and an SI unit.
    ///
    /// # Errors
    /// A requested unit belongs to another quantity, the reference is not positive, or the range is empty.
    pub fn new(name: &str, si: &str, display: &Display) -> Result<Self, PlotError> {
        let unfit = |option: &'static str, amount: &Amount| PlotError::OtherUnit {
            option,
            given: amount.to_string().trim_end().to_owned(),
            name: name.to_owned(),
            unit: si.to_owned(),
        };
        let reference = match &display.decibels {
            None => None,
            Some(amount) => Some(
                (amount.si(si))
                    .filter(|reference| *reference > 0.0)
                    .ok_or_else(|| unfit("--db", amount))?,
            ),
        };
        let mut range = [None; 2];
        for (end, amount) in range.iter_mut().zip(display.range.iter().flatten()) {
            // The range of a decibel scale is in decibels.
            let si = if reference.is_some() { "dB" } else { si };
            *end = Some(amount.si(si).ok_or_else(|| unfit("--range", amount))?);
        }
        // `Amount::up_to` does not compare the ends if only the lower end has a unit.
        if let ([Some(low), Some(high)], Some([given, _])) = (range, &display.range)
            && low >= high
        {
            return Err(unfit("--range", given));
        }
        Ok(Self {
            name: name.to_owned(),
            si: si.to_owned(),
            unit: Unit::first(&display.units, si),
            reference,
            logarithmic: matches!(display.log, Some(Log::Y | Log::Xy)) && reference.is_none(),
            range,
        })
    }

    /// This scale, logarithmic unless it shows decibels.
    pub fn in_decades(mut self) -> Self {
        self.logarithmic = self.reference.is_none();
        self
    }

    /// The shown form of a value: the value itself, or its level in decibels. `None` if the axis cannot show
    /// it.
    pub fn shown(&self, value: f64) -> Option<f64> {
        let shown = match self.reference {
            Some(reference) => self.decade() * (value.abs() / reference).log10(),
            None => value,
        };
        (shown.is_finite() && (!self.logarithmic || shown > 0.0)).then_some(shown)
    }

    /// The ends of an error bar, as shown values; NaN for an end that the axis cannot show. A level is that
    /// of the magnitude: if the bar includes zero, its lower end is NaN.
    pub fn bar(&self, value: f64, error: f64) -> [f64; 2] {
        let [low, high] = match self.reference {
            Some(_) => [(value.abs() - error).max(0.0), value.abs() + error],
            None => [value - error, value + error],
        };
        [low, high].map(|end| self.shown(end).unwrap_or(f64::NAN))
    }

    /// Shown value below which the values of a quantity are round-off, given its largest shown value: the
    /// largest value times [`ROUND_OFF`]. `None` for a linear axis, which such values do not extend.
    pub fn floor(&self, largest: f64) -> Option<f64> {
        match (self.reference.is_some(), self.logarithmic) {
            (true, _) => Some(largest + self.decade() * ROUND_OFF.log10()),
            (false, true) => Some(largest * ROUND_OFF),
            (false, false) => None,
        }
    }

    /// Decibels per factor of 10.
    fn decade(&self) -> f64 {
        if self.si == POWER { 10.0 } else { 20.0 }
    }

    /// An axis for shown values from low to high, with a margin at both ends.
    pub fn axis(&self, shown: [f64; 2]) -> Axis {
        let [low, high] = shown;
        let room = if self.logarithmic {
            let margin = (high / low).max(1.0).powf(0.05).max(1.02);
            [low / margin, high * margin]
        } else {
            padded(shown, 0.05)
        };
        self.axis_over(room)
    }

    /// An axis for shown values from low to high, without a margin. The requested range replaces both ends.
    pub fn axis_over(&self, shown: [f64; 2]) -> Axis {
        let ends = [0, 1].map(|end| self.range[end].unwrap_or(shown[end]));
        let axis = |unit: &str| {
            if self.logarithmic {
                Axis::logarithmic(&self.name, unit, ends)
            } else {
                Axis::linear(&self.name, unit, ends)
            }
        };
        match (self.reference, &self.unit) {
            (Some(reference), _) => {
                let unit = Unit::fitting(&self.si, reference);
                let words = unit.words("dB re", reference);
                axis("dB").in_unit(&self.name, &words, 1.0)
            }
            (None, Some(unit)) => axis(&self.si).in_unit(&self.name, &unit.text, unit.factor),
            (None, None) => axis(&self.si),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_relative_to_the_reference() {
        let display = Display {
            decibels: Some("1 um".parse().unwrap()),
            ..Display::default()
        };
        let scale = Scale::new("rms", "m", &display).unwrap();
        assert!((scale.shown(1e-5).unwrap() - 20.0).abs() < 1e-12);
        assert_eq!(scale.shown(0.0), None);
        assert_eq!(scale.axis([0.0, 20.0]).label, "rms [dB re 1 µm]");
        assert_eq!(scale.floor(20.0), Some(20.0 - 180.0));
        // A bar contains its value; if it includes zero, it has no lower end.
        let double = 20.0 * 2.0_f64.log10();
        for value in [3e-5, -3e-5] {
            let found = scale.bar(value, 1e-5);
            assert!((found[0] - (20.0 + double)).abs() < 1e-12, "{found:?}");
            assert!(
                (found[1] - (20.0 + 2.0 * double)).abs() < 1e-12,
                "{found:?}"
            );
        }
        let [low, high] = scale.bar(1e-6, 9e-6);
        assert!(low.is_nan() && (high - 20.0).abs() < 1e-12, "{low} {high}");
        let plain = Scale::new("rms", "m", &Display::default()).unwrap();
        assert_eq!(plain.bar(1.0, 2.0), [-1.0, 3.0]);
        let power = Display {
            decibels: Some("1e-3".parse().unwrap()),
            ..Display::default()
        };
        let scale = Scale::new("power_loss", "W", &power).unwrap();
        assert!((scale.shown(1.0).unwrap() - 30.0).abs() < 1e-12);
        assert_eq!(scale.floor(30.0), Some(30.0 - 90.0));
        let plain = Scale::new("force", "N", &Display::default()).unwrap();
        assert_eq!(plain.floor(8.0), None);
        assert_eq!(plain.in_decades().floor(8.0), Some(8e-9));
        let wrong = Scale::new("force_peak", "N", &display).err().unwrap();
        assert!(wrong.to_string().contains("`--db 1 um`"), "{wrong}");
    }

    #[test]
    fn units_are_taken_for_what_they_measure() {
        let display = Display {
            units: vec!["rpm".into(), "mm".into()],
            ..Display::default()
        };
        let scale = Scale::new("deflection_rms", "m", &display).unwrap();
        assert_eq!(scale.axis([0.0, 1e-3]).label, "deflection_rms [mm]");
        let speed = Unit::of("rpm", "rad/s").unwrap();
        assert_eq!(
            speed.words("speed", 100.0 * std::f64::consts::PI),
            "speed 3000 rpm"
        );
        assert_eq!(Unit::of("rpm", "m"), None);
        assert!("1 furlong".parse::<Amount>().is_err());
        assert!("much".parse::<Amount>().is_err());
    }

    #[test]
    fn the_lower_end_of_a_range_is_below_the_upper_end() {
        let range = |low: &str, high: &str| {
            let [low, high] = [low, high].map(|text| text.parse::<Amount>().unwrap());
            low.up_to(high)
        };
        assert!(range("0", "20 um").is_some() && range("10 um", "0.02 mm").is_some());
        assert!(range("20 um", "0.01 mm").is_none() && range("2", "1").is_none());
        // For a length, 0.01 is 10 mm.
        let scale = |low: &str, high: &str| {
            let range = range(low, high);
            let display = Display {
                range,
                ..Display::default()
            };
            Scale::new("deflection_rms", "m", &display)
        };
        assert!(scale("2000 um", "0.01").is_ok());
        assert!(scale("2000 um", "0.001").is_err());
    }
}
