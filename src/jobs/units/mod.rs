//! SI quantities and their text form. Only this module converts units.
//!
//! A quantity is a bare number in SI, or text `number unit` such as `"15 um"`,
//! `"11460 rpm"`, `"2e-3 kg*m^2"`. Powers of ten are applied to the decimal text, before
//! the number becomes binary: `"15 um"` and `1.5e-5` are the same double.

mod expression;
mod pattern;
#[cfg(test)]
mod tests;

use expression::{Exponents, UnitError};

/// A number with `decimals` decimals; if its absolute value is 1e7 or more, in scientific form with two decimals.
pub fn short(value: f64, decimals: usize) -> String {
    if value.abs() < 1e7 {
        format!("{value:.decimals$}")
    } else {
        format!("{value:.2e}")
    }
}

/// `1 point`, `3 points`.
pub fn plural(count: usize, noun: &str) -> String {
    match count {
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    }
}

/// The dimension of a quantity, which determines the accepted units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// Length \[m\].
    Length,
    /// Time \[s\].
    Time,
    /// Plane angle \[rad\].
    Angle,
    /// Speed along a line \[m/s\].
    Velocity,
    /// Angular speed or angular frequency \[rad/s\].
    AngularSpeed,
    /// Force \[N\].
    Force,
    /// Torque \[N m\].
    Torque,
    /// Translational stiffness \[N/m\].
    Stiffness,
    /// Stiffness of a tilt \[N m/rad\].
    TiltStiffness,
    /// Viscous damping coefficient \[N s/m\].
    Damping,
    /// Viscous drag on a rotation \[N m s/rad\].
    Drag,
    /// Pressure or elastic modulus \[Pa\].
    Pressure,
    /// Dynamic viscosity \[Pa s\].
    Viscosity,
    /// Density \[kg/m³\].
    Density,
    /// Mass \[kg\].
    Mass,
    /// Moment of inertia \[kg m²\].
    Inertia,
    /// Dimensionless ratio.
    Ratio,
    /// Participation of a mass-normalised mode \[1/√kg\]; bare numbers only.
    Participation,
    /// Modal participation per unit length, or modal force of a unit torque \[1/(m √kg)\]; bare numbers only.
    ParticipationByLength,
    /// Force per unit modal displacement \[N/(m √kg)\]; bare numbers only.
    ForceByModalDisplacement,
    /// Force per unit modal velocity \[N s/(m √kg)\]; bare numbers only.
    ForceByModalVelocity,
    /// Modal damping \[1/s\]; bare numbers only.
    ModalDamping,
    /// Modal stiffness \[1/s²\]; bare numbers only.
    ModalStiffness,
    /// Force on a mass-normalised mode \[N/√kg\]; bare numbers only.
    ModalForce,
    /// Force on a mass-normalised mode per unit angular speed \[N s/(rad √kg)\]; bare numbers only.
    ModalForceBySpeed,
    /// Mass-normalised modal displacement \[m √kg\]; bare numbers only.
    ModalDisplacement,
    /// Mass-normalised modal velocity \[m √kg/s\]; bare numbers only.
    ModalVelocity,
}

/// The dimensions that have a text form, with the exponents of kg, m, s and rad.
const TEXT_FORMS: [(Dimension, Exponents); 17] = [
    (Dimension::Length, Exponents([0, 1, 0, 0])),
    (Dimension::Time, Exponents([0, 0, 1, 0])),
    (Dimension::Angle, Exponents([0, 0, 0, 1])),
    (Dimension::Velocity, Exponents([0, 1, -1, 0])),
    (Dimension::AngularSpeed, Exponents([0, 0, -1, 1])),
    (Dimension::Force, Exponents([1, 1, -2, 0])),
    (Dimension::Torque, Exponents([1, 2, -2, 0])),
    (Dimension::Stiffness, Exponents([1, 0, -2, 0])),
    (Dimension::TiltStiffness, Exponents([1, 2, -2, -1])),
    (Dimension::Damping, Exponents([1, 0, -1, 0])),
    (Dimension::Drag, Exponents([1, 2, -1, -1])),
    (Dimension::Pressure, Exponents([1, -1, -2, 0])),
    (Dimension::Viscosity, Exponents([1, -1, -1, 0])),
    (Dimension::Density, Exponents([1, -3, 0, 0])),
    (Dimension::Mass, Exponents([1, 0, 0, 0])),
    (Dimension::Inertia, Exponents([1, 2, 0, 0])),
    (Dimension::Ratio, Exponents([0, 0, 0, 0])),
];

impl Dimension {
    /// The dimensions that texts with a unit may have.
    pub fn with_text_form() -> impl Iterator<Item = Self> {
        TEXT_FORMS.iter().map(|(dimension, _)| *dimension)
    }

    /// The name with its article, as in messages: `a length`.
    pub fn name(self) -> &'static str {
        self.words()[0]
    }

    /// The SI unit as text, `1` when dimensionless.
    pub fn unit(self) -> &'static str {
        self.words()[1]
    }

    /// The usual units that the text form accepts; empty if only bare numbers are accepted.
    pub fn units(self) -> &'static str {
        self.words()[2]
    }

    /// Name, SI unit, usual units.
    fn words(self) -> [&'static str; 3] {
        match self {
            Self::Length => ["a length", "m", "m, cm, mm, um, nm"],
            Self::Time => ["a time", "s", "s, ms, us, min"],
            Self::Angle => ["an angle", "rad", "rad, mrad, deg, rev"],
            Self::Velocity => ["a speed", "m/s", "m/s, mm/s, um/s"],
            Self::AngularSpeed => ["an angular speed", "rad/s", "rad/s, rpm, Hz, deg/s"],
            Self::Force => ["a force", "N", "N, kN, mN"],
            Self::Torque => ["a torque", "N*m", "N*m, kN*m, N*mm"],
            Self::Stiffness => ["a stiffness", "N/m", "N/m, N/mm, N/um, kN/mm"],
            Self::TiltStiffness => ["a tilt stiffness", "N*m/rad", "N*m/rad, kN*m/rad, N*m/deg"],
            Self::Damping => ["a damping coefficient", "N*s/m", "N*s/m, N*s/mm, kN*s/m"],
            Self::Drag => [
                "a viscous drag",
                "N*m*s/rad",
                "N*m*s/rad, N*mm*s/rad, N*m/rpm",
            ],
            Self::Pressure => [
                "a pressure or elastic modulus",
                "Pa",
                "Pa, kPa, MPa, GPa, N/mm^2",
            ],
            Self::Viscosity => ["a dynamic viscosity", "Pa*s", "Pa*s, mPa*s"],
            Self::Density => ["a density", "kg/m^3", "kg/m^3, g/cm^3"],
            Self::Mass => ["a mass", "kg", "kg, g"],
            Self::Inertia => ["a moment of inertia", "kg*m^2", "kg*m^2, kg*mm^2, g*cm^2"],
            Self::Ratio => ["a ratio", "1", "%"],
            Self::Participation => ["a modal participation", "1/sqrt(kg)", ""],
            Self::ParticipationByLength => {
                ["a modal participation by length", "1/(m sqrt(kg))", ""]
            }
            Self::ForceByModalDisplacement => {
                ["a force by modal displacement", "N/(m sqrt(kg))", ""]
            }
            Self::ForceByModalVelocity => ["a force by modal velocity", "N s/(m sqrt(kg))", ""],
            Self::ModalDamping => ["a modal damping", "1/s", ""],
            Self::ModalStiffness => ["a modal stiffness", "1/s^2", ""],
            Self::ModalForce => ["a modal force", "N/sqrt(kg)", ""],
            Self::ModalForceBySpeed => ["a modal force by speed", "N s/(rad sqrt(kg))", ""],
            Self::ModalDisplacement => ["a modal displacement", "m sqrt(kg)", ""],
            Self::ModalVelocity => ["a modal velocity", "m sqrt(kg)/s", ""],
        }
    }

    /// The exponents of kg, m, s and rad; `None` if only bare numbers are accepted.
    pub fn powers(self) -> Option<[i32; 4]> {
        self.exponents().map(|Exponents(powers)| powers)
    }

    fn exponents(self) -> Option<Exponents> {
        TEXT_FORMS
            .iter()
            .find_map(|&(dimension, exponents)| (dimension == self).then_some(exponents))
    }

    fn from_exponents(exponents: Exponents) -> Option<Self> {
        TEXT_FORMS
            .iter()
            .find_map(|&(dimension, known)| (known == exponents).then_some(dimension))
    }
}

/// Why a text is not a quantity of the expected dimension.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum QuantityError {
    /// The text does not begin with a number.
    #[error("`{text}` does not begin with a number")]
    NotANumber {
        /// The text.
        text: String,
    },
    /// The number is written with a decimal comma.
    #[error("`{text}` has a decimal comma; write a decimal point")]
    DecimalComma {
        /// The text.
        text: String,
    },
    /// A number in quotes without a unit.
    #[error("`{text}` has no unit")]
    MissingUnit {
        /// The text.
        text: String,
    },
    /// An unknown unit.
    #[error("`{unit}` is not a known unit")]
    UnknownUnit {
        /// The unknown part.
        unit: String,
    },
    /// A known unit of another dimension.
    #[error("`{unit}` is {}, not {}", kind_of_unit(*found), wanted.name())]
    WrongKind {
        /// The unit as written.
        unit: String,
        /// Its dimension; `None` if no [`Dimension`] has its exponents.
        found: Option<Dimension>,
        /// The expected dimension.
        wanted: Dimension,
    },
    /// The value is infinite as a floating-point number.
    #[error("`{text}` is too large for a floating-point number (at most 1.8e308)")]
    NotFinite {
        /// The text.
        text: String,
    },
}

fn kind_of_unit(dimension: Option<Dimension>) -> String {
    match dimension {
        Some(dimension) => {
            let name = dimension.name();
            let noun = name.split_once(' ').map_or(name, |(_, noun)| noun);
            format!("a unit of {noun}")
        }
        None => "a unit of something else".to_owned(),
    }
}

/// Reads text `number unit` as a quantity of the expected dimension, in SI.
///
/// Units are products and quotients of `m g s N Nm Pa rad Hz`, which take the decimal prefixes `G M k c m u µ n p`,
/// and of `rpm rev deg ° min h % t 1`, which take none. `*`, `·` or a space separates factors, `/` stands before a
/// divisor, `^` (or ², ³) before a power. `Hz` and `rpm` count revolutions of 2π rad.
///
/// # Errors
///
/// Each variant of [`QuantityError`] is one reason.
pub fn parse(text: &str, wanted: Dimension) -> Result<f64, QuantityError> {
    let (value, dimension, unit) = parse_exponents(text)?;
    if wanted.exponents() == Some(dimension) {
        return Ok(value);
    }
    Err(QuantityError::WrongKind {
        unit,
        found: Dimension::from_exponents(dimension),
        wanted,
    })
}

/// Reads text `number unit` as a quantity of the dimension of its unit.
///
/// # Errors
///
/// As [`parse`], with [`QuantityError::UnknownUnit`] instead of `WrongKind` if no [`Dimension`] fits the unit.
pub fn parse_any(text: &str) -> Result<(f64, Dimension), QuantityError> {
    let (value, exponents, unit) = parse_exponents(text)?;
    match Dimension::from_exponents(exponents) {
        Some(dimension) => Ok((value, dimension)),
        None => Err(QuantityError::UnknownUnit { unit }),
    }
}

/// The factor that converts a number from one unit to another, such as 60/(2π) from `rad/s` to `rpm`; `None` if a unit
/// is unknown or their dimensions differ.
pub fn conversion(from: &str, to: &str) -> Option<f64> {
    let [from, to] = [from, to].map(|unit| expression::parse(unit.trim()).ok());
    let (from, to) = (from?, to?);
    let ratio = from.factor / to.factor * 10f64.powi(from.ten - to.ten);
    (from.exponents == to.exponents && ratio.is_finite() && ratio > 0.0).then_some(ratio)
}

/// The number of a text `number unit`, and its unit, which may be empty. `None` if the text does not begin
/// with a finite number.
pub fn split(text: &str) -> Option<(f64, &str)> {
    let (number, unit) = split_number(text.trim())?;
    let number = scaled(number, 0).filter(|number| number.is_finite())?;
    Some((number, unit.trim()))
}

fn parse_exponents(text: &str) -> Result<(f64, Exponents, String), QuantityError> {
    let trimmed = text.trim();
    let whole = || text.to_owned();
    let (number, unit) =
        split_number(trimmed).ok_or(QuantityError::NotANumber { text: whole() })?;
    let unit = unit.trim();
    if unit.is_empty() {
        return Err(QuantityError::MissingUnit { text: whole() });
    }
    if unit.starts_with(',') {
        return Err(QuantityError::DecimalComma { text: whole() });
    }
    let scale = expression::parse(unit)
        .map_err(|UnitError { part }| QuantityError::UnknownUnit { unit: part })?;
    let value = scaled(number, scale.ten).map(|value| value * scale.factor);
    match value {
        // Adding zero turns −0 into 0, so that equal quantities have equal bits.
        Some(value) if value.is_finite() => Ok((value + 0.0, scale.exponents, unit.to_owned())),
        _ => Err(QuantityError::NotFinite { text: whole() }),
    }
}

/// Splits a leading decimal number from the rest; `None` if the text does not begin with a number.
fn split_number(text: &str) -> Option<(&str, &str)> {
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        from + bytes[from..]
            .iter()
            .take_while(|b| b.is_ascii_digit() || **b == b'_')
            .count()
    };
    let mut end = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let mantissa_start = end;
    end = digits(end);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if !bytes[mantissa_start..end].iter().any(u8::is_ascii_digit) {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent_start = end + 1 + sign;
        let exponent_end = digits(exponent_start.min(bytes.len()));
        // Underscores alone are no exponent.
        let exponent = bytes.get(exponent_start..exponent_end);
        if exponent.is_some_and(|exponent| exponent.iter().any(u8::is_ascii_digit)) {
            end = exponent_end;
        }
    }
    Some(text.split_at(end))
}

/// The decimal number times 10^`ten`, rounded once.
fn scaled(number: &str, ten: i32) -> Option<f64> {
    let number = number.replace('_', "");
    let (mantissa, exponent) = match number.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => {
            // The largest and the smallest exponent give infinity and 0, as any beyond them does.
            let limit = if exponent.starts_with('-') { i32::MIN } else { i32::MAX };
            (mantissa, exponent.parse().unwrap_or(limit))
        }
        None => (number.as_str(), 0),
    };
    let exponent = exponent.saturating_add(ten);
    format!("{mantissa}e{exponent}").parse().ok()
}
